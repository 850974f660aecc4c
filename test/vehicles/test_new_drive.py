"""The drive that the developer's page writes as an example works in the world and under a control."""

import os
import re
import sys
import types

import numpy as np
import pytest

from mrs_simulator.core.graphs import Topology
from mrs_simulator.protocols import shipped
from mrs_simulator.vehicles import Team, drives, kind
from mrs_simulator.world.world import EVERY, World

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
with open(os.path.join(ROOT, "docs", "development.md"), encoding="utf-8") as page:
    SECTION = page.read().partition("## A new drive")[2]
CODE = re.search(r"```python\n(.*?)```", SECTION, re.S).group(1)
KIND = re.search(r"```yaml\n(.*?)```", SECTION, re.S).group(1)
NAME = "mrs_simulator.vehicles.drives.ball"


@pytest.fixture()
def ball(monkeypatch, tmp_path):
    """Return the kind on the page, of the drive on the page."""
    module = types.ModuleType(NAME)
    exec(compile(CODE, "development.md", "exec"), module.__dict__)
    monkeypatch.setitem(sys.modules, NAME, module)
    reading = sys.modules["mrs_simulator.vehicles.kind"]
    for each in (drives, reading):
        monkeypatch.setattr(each, "DRIVES", drives.DRIVES + ("ball",))
    path = tmp_path / "ball_bot.yaml"
    path.write_text(KIND)
    return kind(str(path))


def names_of(drive):
    module = drives.drive_module(drive)
    return {
        name
        for name, value in vars(module).items()
        if not name.startswith("_")
        and getattr(value, "__module__", module.__name__).rpartition(".")[2] in drives.DRIVES
        and not name.endswith("Parameters")
    } - {"np", "NamedTuple", "Tuple"}


def test_the_page_names_what_a_drive_has():
    page, _, further = SECTION.partition("As an example")[0].partition("Some drives need more")
    table = set(re.findall(r"`(\w+)`", page.partition("| name |")[2])) - {"joints", "inner"}
    assert names_of("differential") == table | {"CLIPPED"}
    assert set(re.findall(r"^def (\w+)", CODE, re.M)) <= table
    more = set(re.findall(r"`(\w+)`", further)) - {"followed"}
    more -= {"JOINTS", "OWN_LIMITS", "RAMPS", "CLIPPED", "top"}  # flags and arguments
    assert table | more <= names_of("car") | {"wheel_rates"}


def test_the_example_drives_beside_other_robots(ball):
    world = World((ball, "pioneer3dx"), [[0.0, 0.0, 0.5 * np.pi], [3.0, 0.0, 0.0]],
                  odometry_kind="wheel")  # fmt: skip
    for _step in range(100):
        world.set_commands(EVERY, np.array([[0.4, 0.2, 0.0], [0.3, 0.0, 0.0]]))
        world.step()
    # Turned to the left by 90 deg: 0.4 m/s ahead is along y, from a ramp of 1 m/s^2 on.
    np.testing.assert_allclose(world.pose[0], [-0.38, 0.72, 0.5 * np.pi], atol=1e-9)
    np.testing.assert_allclose(world.estimates.pose()[0], world.pose[0], atol=0.02)


def test_a_law_for_points_moves_the_example(ball):
    team = Team((ball, ball, "robotino3"))
    law = shipped("consensus")
    control = law(range(1, 4), Topology.preset("path", 3), team=team, saturation="none")
    pose = np.array([[0.0, 0.0, 0.3], [2.0, 0.0, 1.0], [4.0, 1.0, 2.0]])
    command = control.commands(pose)
    assert command.shape == (3, 3)
    assert not command[:2, 2].any()
    u = team.velocity(command, pose, np.zeros(3), control.l, control.period)
    np.testing.assert_allclose(u, control.pointMassLaw(pose[:, :2]), atol=1e-12)
