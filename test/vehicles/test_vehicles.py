"""Kinds, drives and teams: reading, units, inheritance, limits, groups."""

import math
import os

import numpy as np
import pytest
import yaml

from mrs_simulator.core.kinematics import Limits
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.team.limits import LoweredLimits
from mrs_simulator.vehicles import Team, kind, shipped_kinds
from mrs_simulator.vehicles.quantities import quantity
from mrs_simulator.vehicles.registry import DIRECTORY


def written(tmp_path, name="mine.yaml", **content):
    path = tmp_path / name
    path.write_text(yaml.safe_dump(content))
    return str(path)


def test_the_pioneer_has_the_numbers_of_its_data_sheets():
    found = kind("pioneer3dx")
    assert (found.body.front, found.body.rear, found.body.width) == (0.210, 0.301, 0.425)
    assert (found.numbers.track, found.numbers.radius, found.mass) == (0.357, 0.09, 9.0)
    v, omega = found.limits["firmware"]
    assert v == (0.75, 0.3) and omega == (math.radians(100.0), math.radians(100.0))
    v, omega = found.limits["top"]
    assert v == (1.5, 2.0) and omega == (math.radians(360.0), math.radians(300.0))
    assert found.axes == ("linear.x", "angular.z") and os.path.isfile(found.model)


@pytest.mark.parametrize("name", shipped_kinds())
def test_every_number_of_a_shipped_kind_has_a_source(name):
    with open(os.path.join(DIRECTORY, name + ".yaml"), encoding="utf-8") as file:
        content = yaml.safe_load(file)
    sources = content.get("sources", {})
    for path in numbers_in({k: v for k, v in content.items() if k not in ("sources", "mounts")}):
        known = [".".join(path[:end]) for end in range(1, len(path) + 1)]
        assert any(key in sources for key in known), "{}: {}".format(name, ".".join(path))


def numbers_in(content, path=()):
    for key, value in content.items():
        if isinstance(value, dict):
            yield from numbers_in(value, path + (key,))
        elif isinstance(value, (int, float)) or (isinstance(value, str) and value[:1].isdigit()):
            yield path + (key,)


@pytest.mark.parametrize(
    "value, unit, wanted",
    [
        ("425 mm", "m", 0.425),
        ("360 deg/s", "rad/s", 2.0 * math.pi),
        ("300 mm/s^2", "m/s^2", 0.3),
        ("3000 rpm", "rad/s", 100.0 * math.pi),
        (1.5, "m/s", 1.5),
        ("36 km/h", "m/s", 10.0),
        ("250 g", "kg", 0.25),
    ],
)
def test_quantities_may_have_units(value, unit, wanted):
    assert quantity(value, unit, "here") == pytest.approx(wanted, rel=1e-15)


@pytest.mark.parametrize(
    "value, unit, said",
    [
        ("3 furlongs", "m", "here: '3 furlongs', wanted a number with one of the units m, cm, mm"),
        ("1 rad", "m", "units m, cm, mm"),
        ("wide", "m", "units m"),
        ("3 m", "", "wanted a number without a unit"),
        (True, "m", "wanted a number"),
        ("-1 m", "m", "wanted a number above 0"),
        (float("nan"), "m", "wanted a number"),
    ],
)
def test_what_is_no_quantity_is_refused(value, unit, said):
    with pytest.raises(ScenarioError, match=said):
        quantity(value, unit, "here", above=0.0)


def test_a_kind_inherits_and_the_nearer_wins(tmp_path):
    path = written(
        tmp_path,
        base="pioneer3dx",
        limits={"firmware": {"linear.x": {"max": "0.4 m/s"}}},
        wheels={"track": "0.4 m"},
    )
    own, base = kind(path), kind("pioneer3dx")
    assert own.name == own.title == "mine"
    assert own.limits["firmware"][0] == (0.4, 0.3)
    assert own.limits["firmware"][1] == base.limits["firmware"][1]
    assert own.numbers == base.numbers._replace(track=0.4)
    assert own.body == base.body and own.model == base.model
    beside = kind(
        "other.yaml", relative_to=os.path.dirname(written(tmp_path, "other.yaml", base="mine.yaml"))
    )
    assert beside.numbers == own.numbers
    mine = kind("fast", own={"fast": {"base": "pioneer3dx", "mass": "12 kg"}})
    assert (mine.name, mine.mass) == ("fast", 12.0)
    adapted = kind("pioneer3dx", own={"pioneer3dx": {"base": "pioneer3dx", "mass": 11}})
    assert adapted.mass == 11.0


@pytest.mark.parametrize(
    "content, said",
    [
        ({"base": "pionear3dx"}, "did you mean 'pioneer3dx'"),
        ({"base": "mine.yaml"}, "leads back to it"),
        ({"base": 3}, "base: 3, wanted a kind's name"),
        ({"base": "pioneer3dx", "wheels": {"trakc": 1}}, "wheels: unknown 'trakc'; did you mean"),
        ({"base": "pioneer3dx", "colour": "red"}, "unknown 'colour'"),
        ({"base": "pioneer3dx", "mass": "9 stone"}, "mass: '9 stone', wanted a number with"),
        ({"base": "pioneer3dx", "wheels": 3}, "wheels: 3, wanted a mapping"),
        ({"base": "pioneer3dx", "model": "none.urdf"}, "model: .*, wanted a file"),
        ({"base": "pioneer3dx", "limits": {"firmware": {"linear.y": {"max": 1}}}}, "linear.y"),
        ({"base": "pioneer3dx", "drive": "hover"}, "drive: 'hover', wanted one of"),
        ({"drive": "differential"}, "name|body|height"),
        ({"base": "pioneer3dx", "body": {"front": 0, "rear": 0}}, "rear: 0 together with front"),
    ],
)
def test_a_kind_that_cannot_be_is_refused(tmp_path, content, said):
    with pytest.raises(ValueError, match=said):
        kind(written(tmp_path, **content))


def test_a_team_of_one_kind_shares_its_numbers():
    team = Team(("pioneer3dx",) * 3)
    assert team.axes == ("linear.x", "angular.z") and team.robot_axes.all()
    assert team.limits.top.shape == (2,)
    (group,) = team.groups
    np.testing.assert_array_equal(group.numbers.track, [0.357] * 3)
    values = np.zeros((3, 2))
    assert np.shares_memory(group.of(values), values)


def test_saturation_keeps_each_path_or_the_whole_motion():
    team, still = Team(("pioneer3dx",) * 3, Limits(0.75, 1.5, 0.3, 2.0)), np.zeros(3)
    command = np.array([[1.5, 0.3], [0.1, -3.0], [0.1, 0.1]])
    by_robot = team.saturated(command, still, 0.02, "robot")
    np.testing.assert_allclose(by_robot, [[0.75, 0.15], [0.05, -1.5], [0.1, 0.1]])
    np.testing.assert_allclose(team.saturated(command, still, 0.02, "team"), command / 2.0)


def test_each_robot_of_a_mixed_team_has_its_own_limits():
    slow = kind(
        "slow",
        own={"slow": {"base": "pioneer3dx", "limits": {"firmware": {"linear.x": {"max": 0.3}}}}},
    )
    team = Team(("pioneer3dx", slow))
    np.testing.assert_array_equal(team.limits.top[:, 0], [0.75, 0.3])
    np.testing.assert_array_equal(
        team.excess(np.array([[0.75, 0.0], [0.75, 0.0]]), np.zeros(2), 0.02), [1.0, 2.5]
    )
    np.testing.assert_array_equal(team.speeds[:, 0], [0.75, 0.3])
    lowered = Team(team.kinds, LoweredLimits("top", v_max=0.5))
    np.testing.assert_array_equal(lowered.speeds[:, 0], [0.5, 0.5])
    given = Team(team.kinds, Limits(0.2, 1.0, math.inf, 3.0))
    np.testing.assert_array_equal(given.limits.top, [0.2, 1.0])
    np.testing.assert_array_equal(given.limits.acceleration, [math.inf, 3.0])
    assert np.isinf(Team(team.kinds, None).speeds).all()


@pytest.mark.parametrize("scope", ["robot", "team"])
def test_steering_angles_are_limited_without_the_way_through_twists(scope):
    team, draw = Team(("pioneer3dx", "robotino3", "f1tenth") * 5), np.random.default_rng(0)
    assert team.limits_joints
    pose = draw.uniform(-3.0, 3.0, (15, 3))
    joints = np.where([each.drive == "car" for each in team.kinds], 0.4, 0.0)
    given = draw.uniform(-2.0, 2.0, (15, 2)), pose, joints, 0.05, 0.02
    command = team.command_within(*given, scope)
    wanted = team.saturated(team.command(*given), joints, 0.02, scope)
    np.testing.assert_allclose(command, wanted, rtol=1e-12, atol=1e-12)
    # A turn rate that is limited beside the steering angle is told by the Twist alone.
    assert not Team(team.kinds, Limits(1.0, 1.0, 1.0, 1.0)).limits_joints
