"""Mistakes of users: each gets one clear line that says what and where."""

import contextlib
import io
import os
import re
import signal
import socket
import subprocess
import sys
import warnings

import numpy as np
import pytest

from mrs_simulator import PioneerControl
from mrs_simulator.control.pioneer_control import ControlError
from mrs_simulator.core.doc_links import page_of
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.writing import printing
from mrs_simulator.nodes.control.reconfigure import TellingServer
from mrs_simulator.protocols.loading import ProtocolError, load_protocol
from mrs_simulator.protocols.making import make_control
from mrs_simulator.ros.node import arguments, deferred_output
from mrs_simulator.ros.node.arguments import parse, scenario_from
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.results.report import main as report
from mrs_simulator.study.run.command import main as experiment
from mrs_simulator.study.run.command import sweep_main
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.study.run.simulating import simulate

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LAW = "    def pointMassLaw(self, hand):\n        return -hand\n"
HEAD = "from mrs_simulator import Parameter, PioneerControl, make_twist\n"


def protocol_of(tmp_path, text):
    path = tmp_path / "my_law.py"
    path.write_text(HEAD + text)
    return str(path)


@pytest.mark.parametrize(
    "text, said",
    [
        ("import nothing_like_it\n", "my_law.py, line 2: ModuleNotFoundError: No module named"),
        ("\nclass Law(PioneerControl:\n    pass\n", "my_law.py, line 3: SyntaxError"),
        ("x = 1\ny = x / 0\n", "my_law.py, line 3: ZeroDivisionError"),
        ("import helper_of_mine\n", "helper_of_mine.py, line 1: NameError"),
        (
            "class Law(PioneerControl):\n    PARAMETERS = ('k',)\n",
            r"my_law.py, line 2: TypeError: Law.PARAMETERS\[0\]: 'k', wanted a Parameter\(name",
        ),
        (
            "class Law(PioneerControl):\n    PARAMETERS = (Parameter('k', 1.0))\n",
            r"Law.PARAMETERS is one Parameter, wanted a tuple: \(Parameter\(...\),\)",
        ),
        (
            "class Law(PioneerControl):\n    PARAMETERS = (Parameter('k', 5.0, high=1.0),)\n",
            r"Law.PARAMETERS\[0\]: the default does not fit: k = 5.0: wanted a number of at most 1",
        ),
        (
            "class Law(PioneerControl):\n    PARAMETERS = (Parameter('k', [1]),)\n",
            r"Law.PARAMETERS\[0\]: the default does not fit: k = \[1\]: wanted a default that is",
        ),
        (
            "class Law(PioneerControl):\n    def calculateControlLaw(self, pos_map):\n"
            "        return {}\n    def pointMassLaw(self, hand):\n        return hand\n",
            "Law overrides calculateControlLaw and pointMassLaw: the first hides the other",
        ),
    ],
)
def test_a_protocol_s_mistake_has_its_place(tmp_path, text, said):
    (tmp_path / "helper_of_mine.py").write_text("missing_name\n")
    with pytest.raises(ProtocolError, match=said):
        load_protocol(protocol_of(tmp_path, text))


@pytest.mark.parametrize(
    "body, page",
    [
        ("calculateControlLaw = pointMassLaw = lambda self, known: known", "docs/protocols.md"),
        ("topology = 3", "docs/protocols.md#names-that-are-taken"),
        ("PARAMETERS = 3", "docs/protocols.md#parameters-and-topology"),
        ("DIMENSIONS = 3", "docs/protocols.md#in-space"),
        ("SENSORS = 3", "docs/sensors.md"),
    ],
)
def test_a_protocol_s_mistake_has_the_page_that_explains_it(tmp_path, body, page):
    with pytest.raises(ProtocolError) as refused:
        load_protocol(protocol_of(tmp_path, "class Law(PioneerControl):\n    {}\n".format(body)))
    assert page_of(refused.value) == page


def test_a_law_of_both_hooks_may_call_the_other():
    class Law(PioneerControl):
        def calculateControlLaw(self, pos_map):
            return super().calculateControlLaw(pos_map)

        def pointMassLaw(self, hand):
            return -hand

    assert Law([1]).commands(np.array([[1.0, 0.0, 0.0]])).shape == (1, 2)


def test_a_class_without_a_law_is_refused():
    class Law(PioneerControl):
        pass

    with pytest.raises(ControlError, match="Law has no law: wanted calculateControlLaw or"):
        Law([1, 2])


@pytest.mark.parametrize(
    "hook, answer, said",
    [
        ("neighbourLaw", None, r"neighbourLaw returned NoneType for robot 1, wanted \(ux, uy\)"),
        ("neighbourLaw", 3.0, "neighbourLaw returned float for robot 1"),
        ("neighbourLaw", (1.0, 2.0, 3.0), "neighbourLaw returned tuple of 3 for robot 1"),
        ("pointMassLaw", None, r"pointMassLaw returned NoneType, wanted an array \(2, 2\)"),
        ("pointMassLaw", {"a": 1}, "pointMassLaw returned dict"),
        ("calculateControlLaw", None, "calculateControlLaw returned NoneType, wanted 2 Twists"),
    ],
)
def test_what_a_law_returns_by_mistake_is_named(hook, answer, said):
    law = type("Law", (PioneerControl,), {hook: lambda self, *arguments: answer})
    control = law([1, 2], topology=Topology.preset("chain", 2))
    with pytest.raises(ControlError, match=said):
        control.commands(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]))


def test_a_missing_scenario_says_where_it_was_looked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_lab.yaml").write_text("")
    with pytest.raises(ScenarioError) as caught:
        scenario_path("papr.yaml")
    said = str(caught.value)
    assert said.startswith("scenario papr.yaml: no such file (looked in {}, ".format(tmp_path))
    assert said.endswith("scenarios); did you mean 'paper.yaml'?")
    with pytest.raises(ScenarioError, match=r"looked in \S+\); did you mean 'my_lab.yaml'"):
        scenario_path(str(tmp_path / "my_lob.yaml"))
    with pytest.raises(SystemExit) as ended:
        experiment(["papr.yaml", "--out", str(tmp_path / "out")])
    assert ended.value.code == 2 and "did you mean 'paper.yaml'" in capsys.readouterr().err
    with pytest.raises(SystemExit) as ended:
        report(["run.csv", "--out", "out", "--scenario", "papr.yaml"])
    assert ended.value.code == 2 and "did you mean 'paper.yaml'" in capsys.readouterr().err


@pytest.mark.parametrize(
    "asked, meant",
    [("papr", "paper"), ("papr/run.csv", "paper"), ("paper/rn.csv", "paper/run.csv"), ("x", None)],
)
def test_the_nearest_run_is_named_for_a_missing_one(tmp_path, monkeypatch, capsys, asked, meant):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "paper").mkdir()
    (tmp_path / "paper" / "run.csv").write_text("")
    (tmp_path / "pape").mkdir()  # holds no run
    with pytest.raises(SystemExit) as ended:
        report([asked])
    hint = "; did you mean {!r}?".format(meant) if meant else ""
    said = "report: {}: no such run{} (see".format(asked, hint)
    assert ended.value.code == 2 and capsys.readouterr().err.startswith(said)


def test_a_shipped_scenario_needs_no_ending(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "paper").mkdir()  # results of an earlier run
    (tmp_path / "mine").mkdir()
    assert scenario_path("paper") == scenario_path("paper.yaml")
    assert scenario_path("mine") == "mine"


def test_degrees_for_radians_are_doubted(tmp_path, capsys):
    path = tmp_path / "lab.yaml"
    path.write_text("poses: [[0, 0, 0], [3, 0, 90]]\nduration: 0.1\n")
    scenario = load_scenario(str(path))
    said = "robot2: heading 90 rad is more than 2 turns; wanted radians, not degrees"
    assert scenario.warnings() == [said]
    assert load_scenario(scenario_path("paper.yaml")).warnings() == []
    with pytest.raises(SystemExit):
        experiment([str(path), "--out", str(tmp_path / "out"), "--formats", ""])
    told = capsys.readouterr()
    assert "warning: " + said in told.out and told.err == "experiment: warning: " + said + "\n"
    with pytest.raises(SystemExit):
        sweep_main([str(path), "seed=1", "--part", "1/1", "--out", str(tmp_path / "out")])
    assert capsys.readouterr().err.count("experiment: warning: " + said) == 1


def test_every_command_line_overrides_the_same_of_a_scenario(tmp_path, capsys):
    given = dict(robots="3", fidelity="kinematic", odometry="wheel", limits="top", duration="0.1")
    names = dict.fromkeys([*given, "scenario", "protocol"], "")
    argv = ["--{}={}".format(*pair) for pair in given.items()]
    over_ros = scenario_from(parse("", names, ["--scenario", "paper_four.yaml", *argv]))
    with pytest.raises(SystemExit):
        experiment(["paper_four.yaml", "--out", str(tmp_path), "--formats", "", *argv])
    headless = load_scenario(str(tmp_path / "scenario.yaml"))
    assert headless.to_dict() == over_ros.to_dict()
    assert (headless.n, headless.odometry, headless.limits) == (3, "wheel", "top")


@pytest.mark.parametrize(
    "words, said",
    [
        (
            ["mrs_simulator", "simulation.launch", "robot:=4"],
            "unknown 'robot'; did you mean 'robots'",
        ),
        (["mrs_simulator", "simulation.launch", "robots:=4", "__log:=x", "-p", "11311"], ""),
        ([os.path.join(ROOT, "launch", "simulation.launch"), "protcol:=x"], "mean 'protocol'"),
        (["mrs_simulator", "missing.launch", "robot:=4"], ""),
    ],
)
def test_misspelt_arguments_of_roslaunch_are_refused(monkeypatch, words, said):
    line = ["/usr/bin/python3", "/usr/bin/roslaunch", *words]
    monkeypatch.setattr(deferred_output, "command_line", lambda process: line)
    if not said:
        return arguments.refuse_unknown_launch_arguments()
    with pytest.raises(ValueError, match=re.escape("roslaunch: " + words[-1]) + ".*" + said):
        arguments.refuse_unknown_launch_arguments()


def test_the_parent_s_command_line_is_read():
    assert deferred_output.command_line(os.getpid())[0].endswith(os.path.basename(sys.executable))
    assert deferred_output.command_line(2**30) == []


def test_a_value_beyond_its_range_is_logged_where_clients_get_no_answer(monkeypatch):
    said = []
    monkeypatch.setattr("rospy.logerr", lambda text, *values: said.append(text % values))
    server = TellingServer.__new__(TellingServer)
    server.type = type("Type", (), {"min": {"k": 0.0, "name": ""}, "max": {"k": 1.0, "name": ""}})
    server.type.config_description = dict(
        parameters=[{"name": "k"}, {"name": "name"}], groups=[], name="", type="", id=0, parent=0
    )
    config = {"k": 7.0, "name": "a"}
    server._clamp(config)
    assert config == {"k": 1.0, "name": "a"}
    assert said == [
        "pioneer_control: k = 7.0 is out of range: 1.0 is taken, wanted from 0.0 to 1.0"
    ]


@pytest.mark.parametrize(
    "name", sorted(os.listdir(os.path.join(ROOT, "src/mrs_simulator/scripts")))
)
def test_a_program_without_its_workspace_says_what_to_source(name):
    script = os.path.join(ROOT, "src", "mrs_simulator", "scripts", name)
    environment = {key: os.environ[key] for key in ("PATH", "HOME") if key in os.environ}
    ended = subprocess.run(
        [sys.executable, "-I", script], env=environment, stderr=subprocess.PIPE, timeout=60
    )
    said = ended.stderr.decode()
    assert ended.returncode == 1 and said.count("\n") == 1
    assert said.startswith(name + ": No module named") and "first: source devel/setup.bash" in said


def test_an_interrupt_of_a_law_s_own_program_makes_no_traceback(tmp_path):
    path = protocol_of(
        tmp_path,
        "from mrs_simulator import run\n"
        "class Law(PioneerControl):\n    def pointMassLaw(self, hand):\n        return -hand\n"
        "print('ready', flush=True)\nrun(Law)\n",
    )
    with socket.create_server(("127.0.0.1", 0)) as nobody:
        nobody.settimeout(60.0)
        uri = "http://127.0.0.1:{}".format(nobody.getsockname()[1])
        process = subprocess.Popen(
            [sys.executable, path],
            env=dict(os.environ, ROS_MASTER_URI=uri, PYTHONUNBUFFERED="1"),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        assert process.stdout.readline() == b"ready\n"
        nobody.accept()[0].close()  # in the middle of the search for a master
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert b"Traceback" not in said


def test_a_law_of_a_wrong_shape_is_reported_in_one_line_with_its_page(tmp_path, capfd):
    class Flat(PioneerControl):
        def pointMassLaw(self, hand):
            return hand[:, 0]

    scenario = scenario_from_dict({"poses": [[0, 0, 0], [3, 0, 0]], "duration": 1})
    run_experiment(scenario, str(tmp_path), Flat, formats=())
    said = capfd.readouterr().err
    text = "experiment: pointMassLaw returned shape (2,), wanted (2, 2): a velocity for each robot"
    assert said == text + " (see docs/troubleshooting.md#protocols)\n"


@pytest.mark.parametrize(
    "init, said",
    [
        ("(self):\n        self.q = 1", r"Law.__init__ raised TypeError: .*'numbers'"),
        ("(self, *a, **k):\n        self.q = 1", r"Law.__init__ does not begin with super\(\)"),
        (
            "(self, *a, **k):\n        super().__init__(*a, **k)\n        self.q = 1 / 0",
            "my_law.py, line 5: Law.__init__ raised ZeroDivisionError: division by zero; wanted",
        ),
        (
            "(self, *a, **k):\n        self.q",
            "my_law.py, line 4: Law.__init__ raised AttributeError",
        ),
    ],
)
def test_an_init_that_does_not_fit_is_reported_in_one_line(tmp_path, capsys, init, said):
    law = protocol_of(tmp_path, "class Law(PioneerControl):\n    def __init__" + init + "\n" + LAW)
    path = tmp_path / "s.yaml"
    path.write_text("poses: [[0, 0, 0]]\nduration: 0.1\n")
    with pytest.raises(SystemExit) as ended:
        experiment([str(path), "--protocol", law, "--out", str(tmp_path / "out")])
    told = capsys.readouterr().err
    assert ended.value.code == 2 and told.count("\n") == 1 and re.search(said, told)


def test_an_init_that_fits_is_taken(tmp_path):
    init = "(self, *a, **k):\n        super().__init__(*a, **k)\n        self.q = 1\n"
    law = protocol_of(tmp_path, "class Law(PioneerControl):\n    def __init__" + init + LAW)
    scenario = scenario_from_dict({"poses": [[0, 0, 0]]})
    assert make_control(scenario, load_protocol(law)).q == 1


@pytest.mark.parametrize("given", [dict, 3.0, "law", len])
def test_what_is_no_protocol_is_named(given):
    with pytest.raises(ProtocolError, match="protocol|wanted a subclass of PioneerControl"):
        simulate("paper_four", protocol=given, duration=0.1)


@pytest.mark.parametrize(
    "words, unbuffered",
    [
        (["scenarios"], ""),
        (["scenarios"], "1"),
        (["--help"], ""),
        pytest.param(["--help"], "1", marks=pytest.mark.release),
        (["report", "--help"], ""),
        pytest.param(["report", "--help"], "1", marks=pytest.mark.release),
        pytest.param(["scenarios", "--help"], "", marks=pytest.mark.release),
        (["scenarios", "--help"], "1"),
    ],
)
def test_output_that_cannot_be_written_ends_a_program_without_a_traceback(words, unbuffered):
    environment = dict(os.environ, PYTHONUNBUFFERED=unbuffered)
    read, write = os.pipe()
    os.close(read)
    for output, code, said in (
        (write, 141, ""),
        (os.open("/dev/full", os.O_WRONLY), 2, "standard output: No space left on device\n"),
    ):
        command = [sys.executable, "-m", "mrs_simulator", *words]
        ended = subprocess.run(
            command, env=environment, stdout=output, stderr=subprocess.PIPE, timeout=60
        )
        os.close(output)
        assert (ended.returncode, ended.stderr.decode()) == (code, said)


class Gone(io.StringIO):
    """Standard output whose reader has gone."""

    def write(self, text):
        raise BrokenPipeError(32, "Broken pipe")

    def fileno(self):
        raise io.UnsupportedOperation


@pytest.mark.parametrize("ending", [sys.exit, int])
def test_a_failed_write_that_is_not_reported_ends_a_program(monkeypatch, ending):
    @printing
    def main():
        with contextlib.suppress(OSError):  # as argparse prints its help
            print("usage: ")
        return ending()

    monkeypatch.setattr(sys, "stdout", Gone())
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 141


def test_a_failed_write_is_no_bad_input(monkeypatch, capsys):
    @printing
    def main():
        with refusing_bad_input("experiment"):
            print("PASSED")

    monkeypatch.setattr(sys, "stdout", Gone())
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 141 and capsys.readouterr().err == ""


def test_an_error_that_is_not_the_output_s_leaves_a_program(capsys):
    @printing
    def main():
        print("begun")
        raise BrokenPipeError(32, "another pipe")

    with pytest.raises(BrokenPipeError, match="another pipe"):
        main()
    assert capsys.readouterr().out == "begun\n"


@pytest.mark.parametrize("column", ["x", "alpha_x"])
def test_numbers_near_the_largest_make_no_warnings(tmp_path, capfd, column):
    scenario = scenario_from_dict({"poses": [[0, 0, 0], [3, 0, 0]], "duration": 0.5})
    run_experiment(scenario.with_protocol("consensus"), str(tmp_path), formats=())
    lines = (tmp_path / "run.csv").read_text().split("\n")
    at = lines[0].split(",").index(column)
    for row, value in ((3, "1e308"), (5, "-1e308")):
        numbers = lines[row].split(",")
        lines[row] = ",".join([*numbers[:at], value, *numbers[at + 1 :]])
    (tmp_path / "run.csv").write_text("\n".join(lines))
    capfd.readouterr()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(SystemExit):
            report([str(tmp_path), "--formats", "png"])
    said = capfd.readouterr()
    assert said.err == "" and "FAILED" in said.out
    assert ("no robot jumps" in said.out) == (column == "x")


@pytest.mark.parametrize("given", [5, [1.0], "gain"])
def test_parameters_that_are_no_mapping_are_named(given):
    with pytest.raises(ScenarioError, match="parameters: .*, wanted a mapping"):
        simulate("paper_four", parameters=given, duration=0.1)
