"""Guards look ahead: robots stand before the fence, and before they are too near."""

import math

import numpy as np
import pytest

from mrs_simulator.control.stopping import stopping_way
from mrs_simulator.nodes.control.guards import Guards
from mrs_simulator.study.run.preflight import stopping_check
from mrs_simulator.vehicles import Team
from mrs_simulator.world.world import EVERY, World

PERIOD, GAP = 0.05, 2  # [s], and [-] periods between two poses
HOLD = PERIOD * (1 + GAP) + 0.1
FENCE = [-3.0, -3.0, 3.0, 3.0]


def driven(monkeypatch, kinds, poses, speeds, given, z=None, axis="linear.x", seconds=12.0):
    """Return tracks (k, n, 3 or 4) of robots under constant ``speeds`` along ``axis``, and guards."""
    monkeypatch.setattr("rospy.get_param", lambda name, default=None: given.get(name, default))
    more = {} if z is None else {"z": z}
    world = World(kinds, poses, step=PERIOD, **more)
    axes = world.team.axes
    guards = Guards(range(1, len(kinds) + 1), "robot", axes=axes, ahead=(Team(kinds), HOLD))
    command = np.zeros((len(kinds), len(axes)))
    command[:, axes.index(axis)] = speeds
    track, known = [], None
    for k in range(int(seconds / PERIOD)):
        now = world.pose if z is None else np.column_stack([world.pose, world.z])
        now = now.copy()
        known = now if k % GAP == 0 else known
        track.append(now)
        sent = guards.passed(command, known, k * PERIOD, np.full(len(kinds), np.inf))
        world.set_commands(EVERY, sent)
        world.step()
    return np.array(track), guards


@pytest.mark.parametrize("speed", [0.2, 0.75])
def test_robots_head_on_stand_before_they_are_too_near(monkeypatch, speed):
    poses = [[-2.0, 0.0, 0.0], [2.0, 0.0, math.pi]]
    given = {"~min_distance": 0.8}
    track, guards = driven(monkeypatch, ("pioneer3dx",) * 2, poses, speed, given)
    least = np.linalg.norm(track[:, 0, :2] - track[:, 1, :2], axis=1).min()
    assert 0.8 <= least < 0.8 + 4.0 * speed * HOLD and guards.stopped == [1, 2]


KINDS = ("pioneer3dx", "robotino3", "f1tenth", "heron")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("speed", [0.2, 0.75, -0.2])
def test_no_robot_leaves_the_fence(monkeypatch, kind, speed):
    given = {"~geofence": FENCE}
    way = 2.0 if speed == 0.75 else 0.8  # [m] to the fence
    seconds = way / abs(speed) + (4.0 if kind == "heron" else 2.5)
    poses = [[math.copysign(3.0 - way, speed), 0.0, 0.0]]
    track, guards = driven(monkeypatch, (kind,), poses, speed, given, seconds=seconds)
    assert np.abs(track[:, 0, 0]).max() <= 3.0
    assert guards.stopped == [1]


@pytest.mark.parametrize(
    "axis, speed, seconds",
    [("linear.x", 0.75, 6.0), ("linear.z", 0.5, 6.0), ("linear.z", -0.5, 12.0)],
)
def test_no_flyer_leaves_the_fence(monkeypatch, axis, speed, seconds):
    given = {"~geofence": [*FENCE, 0.5, 4.0]}
    known = [[0.0, 0.0, 0.0]], speed, given, np.array([2.0]), axis
    track, guards = driven(monkeypatch, ("crazyflie2",), *known, seconds)
    assert np.abs(track[:, 0, 0]).max() <= 3.0 and guards.stopped == [1]
    assert track[:, 0, 3].min() >= 0.5 and track[:, 0, 3].max() <= 4.0


def test_mixed_kinds_stand_before_they_are_too_near(monkeypatch):
    poses = [[-3.0, 0.0, 0.0], [3.0, 0.0, math.pi]]
    for kinds in (("pioneer3dx", "f1tenth"), ("robotino3", "pioneer3dx")):
        given = {"~min_distance": 0.8}
        track, _ = driven(monkeypatch, kinds, poses, 0.75, given, seconds=7.0)
        assert np.linalg.norm(track[:, 0, :2] - track[:, 1, :2], axis=1).min() >= 0.8


def test_preflight_names_the_speed_that_would_hold():
    pose, team = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), Team(("pioneer3dx",) * 2)
    (check,) = stopping_check(team, HOLD, 0.75, pose, 0.8, [-1.0, -1.0, 3.0, 1.0])
    assert not check.passed and "geofence: 2.00 m free" in check.text
    assert "least distance: 1.20 m free" in check.text and "0.52 m/s would hold" in check.text
    (check,) = stopping_check(team, HOLD, 0.2, pose, 0.8, [-1.0, -1.0, 3.0, 1.0])
    assert check.passed, check.text
    assert stopping_check(team, HOLD, 0.75, pose, 0.0) == []


def test_who_moves_away_from_a_bound_is_not_stopped(monkeypatch):
    given = {"~geofence": FENCE, "~min_distance": 0.8}
    poses = [[-2.99, 0.0, 0.0], [-2.99, 0.81, 0.0]]
    _, guards = driven(monkeypatch, ("pioneer3dx",) * 2, poses, 0.2, given, seconds=5.0)
    assert guards.stopped == []


def test_who_follows_keeps_the_distance_if_the_other_stops_for_a_cause_of_its_own(monkeypatch):
    given = {"~min_distance": 0.8}
    monkeypatch.setattr("rospy.get_param", lambda name, default=None: given.get(name, default))
    world = World(("pioneer3dx",) * 2, [[0.0, 0.0, 0.0], [1.3, 0.0, 0.0]], step=PERIOD)
    guards = Guards((1, 2), "robot", ahead=(world.team, HOLD))
    apart, known = [], world.pose
    for k in range(200):
        known = world.pose.copy() if k % GAP == 0 else known
        speed = min(0.75, 0.015 * k)
        sent = guards.passed(
            np.array([[speed, 0.0]] * 2), known, k * PERIOD, np.full(2, np.inf)
        ).copy()
        sent[1] *= k < 60  # it stops by itself
        world.set_commands(EVERY, sent)
        world.step()
        apart.append(world.pose[1, 0] - world.pose[0, 0])
    assert min(apart) >= 0.8 and world.pose[0, 0] > 0.1


@pytest.mark.parametrize("kind, axis", [("robotino3", "linear.y"), ("heron", "linear.x")])
def test_the_stopping_way_is_the_longest_of_all_directions(kind, axis):
    team = Team((kind,))
    assert stopping_way(team, 1.0, HOLD) >= stopping_way(team, 1.0, HOLD, (axis,)) > HOLD
    ways = [stopping_way(team, 1.0, HOLD, (each,)) for each in ("linear.x", "linear.y")]
    assert stopping_way(team, 1.0, HOLD) == max(ways)


def test_preflight_refuses_ceilings_that_climbing_robots_cannot_keep():
    pose, team = np.array([[0.0, 0.0, 0.0, 1.0]]), Team(("ardrone2",))
    wide = [-20.0, -20.0, 20.0, 20.0]
    (check,) = stopping_check(team, HOLD, 2.0, pose, 0.0, [*wide, 0.9, 1.1])
    assert not check.passed and "geofence, heights: 0.20 m free, wanted" in check.text
    would = float(check.text.split("; ")[1].split(" ")[0])
    assert 0.0 < would < 0.7
    (check,) = stopping_check(team, HOLD, would, pose, 0.0, [*wide, 0.9, 1.1])
    assert check.passed, check.text
