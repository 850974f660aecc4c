"""The examples in the documentation run as they stand."""

import os
import re

import numpy as np
import pytest

from mrs_simulator import simulate
from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.graphs import Topology
from mrs_simulator.protocols import HOMES, shipped
from mrs_simulator.protocols.loading import load_protocol
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.vehicles.drives import DRIVES

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def page(name):
    with open(os.path.join(ROOT, name), encoding="utf-8") as file:
        return file.read()


PAGES = "".join(
    map(page, ("docs/protocols.md", "docs/claims.md", "docs/edges.md", "docs/verdict.md"))
)
EXAMPLES = re.findall(r"```python\n(.*?)```", PAGES, re.S)


@pytest.mark.parametrize("number", range(len(EXAMPLES)))
def test_the_examples_of_the_protocols_page_run(tmp_path, number):
    (tmp_path / "example.py").write_text(EXAMPLES[number])
    law = load_protocol(str(tmp_path / "example.py"))
    control = law(range(1, 4), Topology.preset("path", 3))
    pose = np.array([[0.0, 0.0, 0.1], [2.0, 0.0, 1.0], [4.0, 1.0, 2.0]])
    control.start()
    assert control.commands(pose).shape == (3, 2)
    control.claims(pose[:, :2])


def test_every_shipped_protocol_is_described():
    text = page("docs/shipped_protocols.md")
    for name in HOMES:
        assert "`{}`".format(name) in text, name
        assert shipped(name).__doc__
        for parameter in shipped(name).PARAMETERS:
            assert parameter.meaning, (name, parameter.name)


def test_each_protocol_is_measured_on_every_drive():
    """Else: python3 benchmarks/drives.py NAME"""
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", page("docs/shipped_protocols.md"), re.M))
    for name in HOMES:
        assert [part.split()[0] for part in rows[name].split("; ")] == list(DRIVES), name


def test_classes_with_a_theorem_are_the_shipped_protocols():
    assert len(HOMES) > 30
    assert HOMES["line_of_sight"] == ("currents.law", "LineOfSight")
    for name in HOMES:
        assert issubclass(shipped(name), PioneerControl) and "Theorem: " in shipped(name).__doc__
    for base in ("shaped", "remembering", "sensing", "double_integrator"):  # state none
        assert base not in HOMES


def test_every_shipped_scenario_is_valid():
    folder = os.path.join(ROOT, "scenarios")
    names = [name for name in os.listdir(folder) if name.endswith(".yaml")]
    assert len(names) > 20
    for name in names:
        assert load_scenario(os.path.join(folder, name)).title, name


def test_links_and_pictures_of_the_readme_exist():
    for target in re.findall(r"\]\(([^)#:]+)\)", page("README.md")):
        assert os.path.exists(os.path.join(ROOT, target)), target


def test_the_readmes_protocol_is_loaded_by_its_file_too(tmp_path):
    code = page("README.md").partition("```python\n")[2].partition("```")[0]
    (tmp_path / "my_law.py").write_text(code)
    # It ends with run(Follow), which must not start a node here.
    law = load_protocol(str(tmp_path / "my_law.py") + ":Follow")
    pose = np.array([[4.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(law([1, 2]).commands(pose), [[0.1, 0.0], [0.6, 0.0]])


def test_the_readmes_run_has_the_verdict_that_it_shows(tmp_path):
    readme = page("README.md")
    (tmp_path / "my_law.py").write_text(readme.partition("```python\n")[2].partition("```")[0])
    run = simulate("paper_four.yaml", protocol=str(tmp_path / "my_law.py") + ":Follow")
    shown = re.search(r"^```\n(4 robots.*?)^```$", readme, re.M | re.S).group(1).splitlines()
    assert set(shown) - {"    ..."} <= set(str(run).splitlines())
