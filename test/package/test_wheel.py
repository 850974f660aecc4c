"""The wheel runs in a clean virtual environment, without ROS, and gives the catkin package's values."""

import os
import zipfile

import pytest
from clean_wheel import ROOT, CleanEnvironment, NoIndex, compared

from mrs_simulator import load_scenario, run_experiment
from mrs_simulator.__main__ import COMMANDS, main
from mrs_simulator.scenario.shipped import scenario_path

MOST_BYTES = 2e6
HIDDEN = "rospy", "geometry_msgs", "pybullet", "pandas"


@pytest.mark.release
def test_the_wheel_in_a_clean_environment(tmp_path):
    """One test, so that the environment is made once however the tests are spread."""
    try:
        clean = CleanEnvironment(tmp_path / "clean")
    except NoIndex as error:
        pytest.skip("pip reaches no package index: {}".format(error))
    it_is_small_and_holds_scenarios_and_kinds(clean)
    the_readmes_protocol_gives_the_values_of_the_catkin_package(clean, tmp_path / "readme")
    scenarios_give_the_values_of_the_catkin_package(clean, tmp_path / "scenarios")
    what_is_missing_is_named(clean, tmp_path)
    a_protocol_finds_the_twist_of_ros(clean)


def files(*parts):
    return {name for name in os.listdir(os.path.join(ROOT, *parts)) if not name.startswith("__")}


def it_is_small_and_holds_scenarios_and_kinds(clean):
    assert os.path.getsize(clean.wheel) < MOST_BYTES
    held = {}
    for name in zipfile.ZipFile(clean.wheel).namelist():
        held.setdefault(os.path.dirname(name), set()).add(os.path.basename(name))
    assert held["mrs_simulator/scenarios"] == files("scenarios")
    kinds = ("src", "mrs_simulator", "vehicles", "kinds")
    assert held["mrs_simulator/vehicles/kinds"] == files(*kinds)
    pages = {name for name in files("docs") if name.endswith(".md")}
    assert held["mrs_simulator/docs"] == pages - {
        "development.md",
        "agreement.md",
        "agreement_dynamic.md",
    }


def the_readmes_protocol_gives_the_values_of_the_catkin_package(clean, tmp_path):
    code = "import importlib.util as u; print([n for n in {!r} if u.find_spec(n)])".format(HIDDEN)
    assert clean.python(code).strip() == "[]"
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as file:
        law = file.read().partition("```python\n")[2].partition("```")[0]
    tmp_path.mkdir()
    (tmp_path / "my_law.py").write_text(law)
    name = str(tmp_path / "my_law.py") + ":Follow"
    there, here = tmp_path / "there", tmp_path / "here"
    clean.run(
        "experiment", "paper_four.yaml", "--duration", "5", "--protocol", name, "--out", there
    )
    scenario = load_scenario(scenario_path("paper_four.yaml")).overridden(
        duration=5.0, protocol=name
    )
    run_experiment(scenario, str(here), formats=())
    said, near = compared(str(there / "run.csv"), str(here / "run.csv"))
    assert near, said
    assert (there / "trajectories.pdf").stat().st_size > 1000


RUNS = """
from mrs_simulator import load_scenario, run_experiment
from mrs_simulator.scenario.shipped import scenario_path
for name in {names!r}:
    scenario = load_scenario(scenario_path(name + ".yaml")).overridden(duration=1.0)
    run_experiment(scenario, {out!r} + "/" + name, formats=())
"""


def scenarios_give_the_values_of_the_catkin_package(clean, tmp_path):
    names = ("formation_mixed", "consensus_drops", "formation_crazyflies")
    there, here = tmp_path / "there", tmp_path / "here"
    clean.python(RUNS.format(names=names, out=str(there)))
    exec(RUNS.format(names=names, out=str(here)))
    for name in names:
        said, near = compared(str(there / name / "run.csv"), str(here / name / "run.csv"))
        assert near, (name, said)


def what_is_missing_is_named(clean, tmp_path):
    said = clean.run("experiment", "paper_dynamic.yaml", "--out", tmp_path, codes=(2,))
    assert "pip install pybullet" in said and "Traceback" not in said
    law = "from mrs_simulator import PioneerControl, run\nrun(PioneerControl)"
    (tmp_path / "law.py").write_text(law)
    with pytest.raises(Exception, match="a control node needs ROS .* mrs-simulator experiment"):
        clean.python("import runpy; runpy.run_path({!r})".format(str(tmp_path / "law.py")))


TWIST = """
import mrs_simulator
from geometry_msgs.msg import Twist, Vector3
twist = Twist(angular=Vector3(0.0, 0.0, 0.5))
twist.linear.x = 0.1
assert twist == Twist(Vector3(0.1, 0.0, 0.0), Vector3(z=0.5)) != Twist()
assert mrs_simulator.make_twist(0.1, 0.5) == twist
for wrong in (lambda: Twist(1.0), lambda: Vector3(w=1.0)):
    try: wrong()
    except (TypeError, AttributeError) as error: print(error)
"""


def a_protocol_finds_the_twist_of_ros(clean):
    code = "import mrs_simulator.control.twist_message\n" + TWIST
    assert clean.python(code).splitlines() == [
        "Twist: wanted linear, angular or keyword arguments",
        "Vector3 has no field 'w', wanted x, y, z",
    ]


def test_the_command_tells_its_commands(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    told = capsys.readouterr().out
    assert all("\n  {} ".format(name) in told for name in COMMANDS)
    with pytest.raises(SystemExit) as ended:
        main(["experimant"])
    assert ended.value.code == 2
    assert "did you mean 'experiment'? (known: analyse" in capsys.readouterr().err


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_each_command_has_a_help(name, capsys):
    with pytest.raises(SystemExit) as ended:
        main([name, "--help"])
    assert ended.value.code == 0
    assert "usage: mrs-simulator {} ".format(name) in capsys.readouterr().out
