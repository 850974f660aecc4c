"""The safety filter among obstacles, within an arena, under caps of speed; deadlocks."""

import inspect
import math
import textwrap

import numpy as np
import pytest
from ros_fixtures import log_of, wait_until

from mrs_simulator import PioneerControl, run_experiment
from mrs_simulator.control.safety.bounds import Surroundings
from mrs_simulator.control.safety.deadlock_detector import DeadlockDetector
from mrs_simulator.control.safety.nearest_velocities import (
    FIXED_RATE,
    filter_acts,
    margins,
    safe_velocities,
)
from mrs_simulator.record.controller_log import deadlock_in, deadlock_text
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder, clearance
from mrs_simulator.verdict.verdict import verdict_text

PERIOD = 0.02
DRUM = Cylinder("drum", 1.0, 0.0, 0.5, 1.0)
CRATE = Box("crate", 0.0, 0.0, math.pi / 2.0, 4.0, 2.0, 1.0)  # 4 m along y, 2 m along x


def test_clearances_typed_out():
    far, out = clearance(DRUM, [[4.0, 4.0], [1.0, 0.25]])
    np.testing.assert_allclose(far, [4.5, -0.25])
    np.testing.assert_allclose(out, [[0.6, 0.8], [0.0, 1.0]])
    far, out = clearance(CRATE, [[3.0, 1.0], [-4.0, 6.0], [0.9, 0.0], [0.0, -1.9], [1.0, 0.5]])
    np.testing.assert_allclose(far, [2.0, 5.0, -0.1, -0.1, 0.0], atol=1e-12)
    ways = [[1.0, 0.0], [-0.6, 0.8], [1.0, 0.0], [0.0, -1.0], [1.0, 0.0]]
    np.testing.assert_allclose(out, ways, atol=1e-12)


def test_a_robot_before_a_wall_is_slowed_to_the_bound():
    room = Surroundings((DRUM,), (-5.0, -5.0, 5.0, 5.0))
    points, reach = np.array([[0.0, 0.0]]), np.array([0.3])
    bounds = room.bounds(points, reach)
    np.testing.assert_allclose(bounds.gap, [0.2, 4.7, 4.7, 4.7, 4.7])
    safe = safe_velocities([[1.0, 0.3]], points, 0.6, PERIOD, swirl=0.0, bounds=bounds)
    np.testing.assert_allclose(safe, [[0.2 * FIXED_RATE, 0.3]], atol=1e-6)
    assert filter_acts(safe, points, 0.6, PERIOD, bounds=bounds)
    away = np.array([[-1.0, 0.3]])
    np.testing.assert_array_equal(safe_velocities(away, points, 0.6, PERIOD, bounds=bounds), away)
    assert not filter_acts(away, points, 0.6, PERIOD, bounds=bounds)


def test_inside_an_obstacle_it_is_sent_out():
    points = np.array([[0.8, 0.0]])
    bounds = Surroundings((DRUM,)).bounds(points, np.array([0.3]))
    safe = safe_velocities([[0.0, 0.0]], points, 0.6, PERIOD, swirl=0.0, bounds=bounds)
    np.testing.assert_allclose(safe, [[-0.6 * FIXED_RATE, 0.0]], atol=1e-6)


def dykstra(wanted, sets):
    """Return the point of the intersection of convex ``sets``, as projections, nearest to ``wanted``."""
    x, pull = wanted.copy(), [np.zeros_like(wanted) for _ in sets]
    for _ in range(1500):
        for k, onto in enumerate(sets):
            y = onto(x + pull[k])
            x, pull[k] = y, x + pull[k] - y
    return x


def half_space(row, limit):
    return lambda u: u - row * (max(0.0, float((row * u).sum()) - limit) / float((row * row).sum()))


def disc(robot, radius):
    def onto(u):
        u = u.copy()
        u[robot] *= min(1.0, radius / max(float(np.hypot(*u[robot])), 1e-300))
        return u

    return onto


def test_the_nearest_velocities_are_those_of_alternating_projections():
    points = np.array([[0.0, 0.0], [1.1, 0.1], [0.4, 1.2]])
    draw = np.random.default_rng(5)
    wanted = draw.normal(0.0, 1.0, (3, 2)) - points
    wanted[0] = [0.6, -1.0]
    speed, reach = np.array([0.5, 0.4, 0.3]), np.full(3, 0.5)
    bounds = Surroundings((), (-0.7, -0.55, 4.0, 4.0)).bounds(points, reach)
    safe = safe_velocities(wanted, points, 1.0, PERIOD, swirl=0.0, bounds=bounds, speed=speed)
    sets = [disc(robot, cap) for robot, cap in enumerate(speed)]
    h, first, second = margins(points, 1.0)
    for k, (i, j) in enumerate(zip(first, second)):
        row = np.zeros((3, 2))
        row[i], row[j] = -2.0 * (points[i] - points[j]), 2.0 * (points[i] - points[j])
        sets.append(half_space(row, min(h[k] ** 3, h[k] / PERIOD)))
    for i, out, gap in zip(bounds.robot, bounds.way_out, bounds.gap):
        row = np.zeros((3, 2))
        row[i] = -out
        sets.append(half_space(row, FIXED_RATE * gap))
    np.testing.assert_allclose(safe, dykstra(wanted, sets), atol=1e-4)
    assert np.abs(safe - wanted).max() > 0.1  # something acted


@pytest.mark.parametrize("period", [PERIOD, 0.1])
def test_points_sent_through_things_touch_nothing(period):
    draw = np.random.default_rng(8)
    things = (DRUM, Box("b", -1.5, 1.0, 0.4, 1.0, 0.4, 1.0), Box("w", 0, -2.5, 0, 3, 0.1, 1))
    room, reach = Surroundings(things, (-4.0, -4.0, 4.0, 4.0), np.full(4, 1.5)), np.full(4, 0.3)
    points = np.array([[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]])
    goal = -points + draw.normal(0.0, 0.2, (4, 2))
    for _ in range(int(11.0 / period)):
        bounds = room.bounds(points, reach)
        assert bounds.gap.min() >= -1e-9 and margins(points, 0.6)[0].min() >= -1e-9
        wanted = 2.5 * (goal - points)
        u = safe_velocities(wanted, points, 0.6, period, bounds=bounds, speed=room.speed)
        assert np.linalg.norm(u, axis=1).max() <= 1.5 + 1e-9
        points = points + period * u
    assert np.linalg.norm(goal - points, axis=1).max() < 0.1


# Deadlocks -------------------------------------------------------------------------------------


def test_who_is_held_and_since_when():
    held = DeadlockDetector(3)
    points = np.array([[0.0, 0.0], [1.0, 0.0], [9.0, 0.0]])
    wanted, still = np.array([[1.0, 0.0], [0.0, 0.0], [0.5, 0.0]]), np.zeros((3, 2))
    free = np.array([[0.0, 0.0], [0.0, 0.0], [0.5, 0.0]])
    held.note(1.0, wanted, free, points, 0.8)
    held.note(2.0, wanted, still, points, 0.8)
    assert held.rows(3.9) == []
    assert held.rows(4.0) == [(0, 1.0)]  # robot 2 wants nothing, robot 3 was free
    held.note(5.0, wanted, still, points, 0.8)
    assert held.rows(5.0) == [(0, 1.0), (2, 2.0)]
    passing = still + [[0.0, 0.0], [0.0, 0.3], [0.0, 0.0]]  # robot 2 makes room
    held.note(6.0, wanted, passing, points, 0.8)
    assert held.rows(6.0) == [(2, 2.0)]
    held.note(0.0, wanted, still, points, 0.8)  # another run
    assert held.rows(3.0) == [(0, 0.0), (2, 0.0)]


def test_a_deadlock_in_words_and_back():
    held = ((1, 12.3), (4, 20.0))
    text = "deadlock: the safety filter holds still robot 1 since 12.3 s, robot 4 since 20.0 s"
    assert deadlock_text(held) == text and deadlock_in(text) == held
    assert deadlock_text(()) == "" and deadlock_in("another warning") == ()


class Behind(PioneerControl):
    """Robot 1 wants to go through the wall before it, robot 2 stays where it is."""

    def pointMassLaw(self, hand):
        return (hand[:, :1] < 50.0) * [[0.5, 0.0], [0.0, 0.0]]


def blocked(**safety):
    return scenario_from_dict(
        {
            "poses": [[0.0, 0.0, 0.0], [-3.0, 0.0, 0.0]],
            "fidelity": "kinematic",
            "limits": "none",
            "duration": 8.0,
            "obstacles": [{"type": "wall", "from": [2.0, -9.0], "to": [2.0, 9.0]}],
            "control": {"safety": safety or True},
        }
    )


def found(verdict, name):
    return next(check for check in verdict["checks"] if check["name"].startswith(name))


def test_a_deadlock_is_reported_and_not_judged(tmp_path):
    scenario = blocked(arena=[-9, -9, 1.5, 9], speed=[0.3, 0.3])
    # Turned aside it creeps along the border, at 0.15 of what it wants.
    verdict = run_experiment(scenario, str(tmp_path), Behind, formats=())
    check = found(verdict, "robots held still")
    assert check["measured"] == 1 and check["passed"] is None
    assert verdict["outcome"] == "not_judged" and "robot 1 since" in check["note"]
    since = deadlock_in(check["note"])[0][1]
    assert 2.0 < since < 5.0
    assert "deadlock" in verdict_text(verdict)
    assert found(verdict, "least clearance")["passed"]
    assert found(verdict, "largest share of a speed cap")["passed"]


def test_over_ros_a_deadlock_is_reported_in_the_status_the_log_and_the_verdict(ros, tmp_path):
    law = tmp_path / "behind.py"
    law.write_text(
        "from mrs_simulator import PioneerControl\n\n\n"
        + textwrap.dedent(inspect.getsource(Behind))
    )
    path = tmp_path / "blocked.yaml"
    scenario = blocked(arena=[-9, -9, 1.5, 9], speed=[0.3, 0.3])
    near = [[0.8, 0.0, 0.0], [-3.0, 0.0, 0.0]]  # held still after a second or two
    slower = dict(scenario.control.to_plain(), rate=20)
    scenario = scenario.changed(duration=10.0, poses=near, step=0.05, control=slower)
    path.write_text(scenario.to_yaml())
    given = ["--scenario", path]
    ros.node("stage", *given, "_speed:=4", "_lockstep:=true", "_wait_for_recorders:=1")
    probe = ros.probe()
    control = ros.node(
        "pioneer_control", *given, "--protocol", "{}:Behind".format(law), "_lockstep:=true"
    )
    record = ros.node("record", *given, "--out", tmp_path / "out")
    told = probe.wait("[w for w in control('warnings') or () if w.startswith('deadlock: ')]")
    assert deadlock_in(told[-1])[0][0] == 1 and probe.ask("control('running')")
    verdict = ros.judged(record, tmp_path / "out")
    wait_until(lambda: "deadlock: the safety filter holds still robot 1" in log_of(control))
    assert found(verdict, "robots held still")["measured"] == 1
    assert verdict["outcome"] == "not_judged"


def test_true_keeps_robots_from_robots_alone(tmp_path):
    scenario = blocked().changed(duration=5.0)
    verdict = run_experiment(scenario, str(tmp_path), Behind, formats=())
    assert not [check for check in verdict["checks"] if "clearance" in check["name"]]
    assert found(verdict, "collisions")["measured"] > 0
    scenario = blocked(obstacles=True).changed(duration=5.0)
    kept = run_experiment(scenario, str(tmp_path), Behind, formats=())
    assert found(kept, "collisions")["measured"] == 0 and found(kept, "least clearance")["passed"]


def test_a_scenario_says_what_is_kept_and_says_it_again():
    scenario = blocked(arena=[-9, -8, 1.5, 8], speed=[0.3, 0.4])
    again = scenario_from_dict(scenario.to_dict())
    assert again.control.safety == scenario.control.safety
    assert again.control.safety.speed == (0.3, 0.4) and again.control.safety.obstacles
    assert scenario.changed(robots=1, poses=[[0, 0, 0]]).control.safety.speed == (0.3,)
    assert scenario.with_robots(4).control.safety.speed == (0.3, 0.4, 0.4, 0.4)
    for safety, said in (
        ({"arena": [1, 0, -1, 2]}, "x_min < x_max"),
        ({"speed": 0.0}, "above 0"),
        ({"speed": [0.3]}, "2 such numbers"),
        ({"aerna": [0, 0, 1, 1]}, "aerna"),
        (3, "wanted true, false, or a mapping"),
    ):
        with pytest.raises(ScenarioError, match=said):
            scenario_from_dict({**blocked().to_dict(), "control": {"safety": safety}})


def test_land_keeps_off_boats_alone():
    land = Box("beach", 5.0, 0.0, 0.0, 2.0, 20.0, 0.0)
    points, reach = np.array([[3.0, 0.0], [3.0, 1.0], [3.5, 2.0]]), np.full(3, 0.2)
    room = Surroundings((land, DRUM), (-9.0, -9.0, 9.0, 9.0))
    mixed = room._replace(afloat=np.array([True, False, False])).bounds(points, reach)
    whole = room.bounds(points, reach)
    assert len(whole.robot) == len(mixed.robot) + 2
    assert mixed.least(3)[0] == whole.least(3)[0] == pytest.approx(0.8)
    assert (mixed.least(3)[1:] > whole.least(3)[1:]).all()
    afloat = room._replace(afloat=np.array([True, False, False]))
    for each in (room, afloat, Surroundings()):
        np.testing.assert_array_equal(
            each.least_gaps(points, reach), each.bounds(points, reach).least(3)
        )
