"""The drives as they are stated a second time for verdicts: mappings, limits, ramps and motion."""

import itertools

import numpy as np
import pytest
from protocol_fixtures import check, failed, shipped, verdict_of

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.kinematics import Limits
from mrs_simulator.protocols.published.drives import STATED, approached, reached
from mrs_simulator.protocols.published.robots import Robots
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.drives import DRIVES, car, omnidirectional

KINDS = ("pioneer3dx", "robotino3", "f1tenth", "turtlebot3_burger", "youbot", "heron")
L, PERIOD = 0.3, 0.02
WHEELBASE = 0.3302  # [m] of F1TENTH


def robots(kinds=KINDS, limits=None, scope="none", period=PERIOD):
    return Robots(Team(kinds, limits), L, period, scope)


def placed(team, seed=0):
    """Return poses (n, 3) and points (n, 2) of ``team`` at random, cars steered by up to 0.3 rad."""
    draw = np.random.default_rng(seed)
    pose = draw.uniform(-3.0, 3.0, (team.n, 3))
    joints = np.where([kind.name == "f1tenth" for kind in team.kinds], draw.uniform(-0.3, 0.3), 0.0)
    return pose, team.point(pose, joints, L)


def test_the_points_are_where_the_drives_have_them():
    made = robots()
    pose, points = placed(made.team)
    made.be(pose, points)
    np.testing.assert_allclose(made.points, points, atol=1e-12)
    np.testing.assert_allclose(made.pose, pose, atol=1e-12)


def test_robots_put_elsewhere_have_other_headings():
    made = robots()
    for seed in (0, 1):
        pose, points = placed(made.team, seed)
        made.be(pose, points)
        np.testing.assert_allclose(made.points, points, atol=1e-12)


def test_any_velocity_of_the_points_is_reached():
    made = robots(period=1e-6)  # a car's command tells the steering angle after one period
    pose, points = placed(made.team)
    u = np.random.default_rng(1).uniform(-1.0, 1.0, points.shape)
    made.be(pose, points)
    command = made.commands(u)
    np.testing.assert_allclose(made.velocities(command), u, atol=1e-6)
    made.move(command, 1e-6)
    # A car steers within the period, the faster the shorter it is.
    np.testing.assert_allclose(made.points - points, 1e-6 * u, atol=2e-11)


def test_commands_with_typed_out_numbers():
    made = robots(("robotino3", "f1tenth", "pioneer3dx"))
    pose = np.array([[0.0, 0.0, np.pi / 2], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    made.be(pose)
    command = made.commands(np.array([[1.0, 0.0], [1.0, 0.6], [1.0, 0.6]]))
    angle = 0.6 / L * PERIOD  # [rad] after one period: straight ahead delta' = u_n/d
    expected = [[0, -1, 0], [1, 0, np.tan(angle) / WHEELBASE], [1, 0, 2.0]]
    np.testing.assert_allclose(command, expected, atol=1e-12)


def test_limits_keep_the_direction_of_each_point():
    made = robots(limits="firmware", scope="robot")
    pose, points = placed(made.team)
    made.be(pose, points)
    u = 30.0 * np.random.default_rng(2).uniform(0.5, 1.0, points.shape)
    moved = made.velocities(made.commands(u))
    assert made.limited_now.all()
    cross = moved[:, 0] * u[:, 1] - moved[:, 1] * u[:, 0]
    free = [row for row, kind in enumerate(made.team.kinds) if kind.name != "f1tenth"]
    np.testing.assert_allclose(cross[free], 0.0, atol=1e-9)  # a car's angle is clipped, too
    assert (np.hypot(*moved.T) < 0.9 * np.hypot(*u.T)).all()


def test_one_factor_for_the_team():
    limits = Limits(1.0, 1e3, np.inf, np.inf)
    made = robots(("robotino3", "pioneer3dx"), limits, "team")
    made.be(np.zeros((2, 3)))
    np.testing.assert_allclose(made.commands(np.array([[0.2, 0.0], [4.0, 0.0]]))[:, 0], [0.05, 1.0])


def test_ramps_and_their_means():
    value, mean = reached(np.array([0.0, 0.9, 1.0]), np.array([1.0, 1.0, 1.0]), 2.0, 0.1)
    np.testing.assert_allclose(value, [0.2, 1.0, 1.0])
    np.testing.assert_allclose(mean, [0.1, 0.975, 1.0])  # the second ramps for half of the time


def test_boats_come_nearer_and_nearer():
    # At 0.5 m/s^2 from 1 m/s of error to 0.4, then with 0.8 s: 0.4 exp(-1) after 0.8 s more.
    value, mean = approached(np.array([[0.0]]), np.array([[1.0]]), 0.5, 0.8, 2.0)
    np.testing.assert_allclose(value, 1.0 - 0.4 * np.exp(-1.0))
    way = 0.5 * 0.5 * 1.2**2 + 0.8 - 0.8 * 0.4 * (1.0 - np.exp(-1.0))
    np.testing.assert_allclose(mean, way / 2.0)


def test_quadrotors_speed_up_no_faster_than_they_tilt():
    # Towards 2 m/s: at 9.81 tan(30 deg) = 5.663809 m/s^2 down to an error of that times 0.25 s.
    made = robots(("crazyflie2",), "top")
    made.be(np.array([[0.0, 0.0, 0.5 * np.pi]]))
    made.move(np.array([[2.0, 0.0, 0.0, 0.0]]), 0.02)
    np.testing.assert_allclose(made.pose, [[0.0, 0.5 * 5.663809 * 0.02**2, 0.5 * np.pi]], atol=1e-8)


def test_every_drive_is_stated():
    assert {drive.__name__.rpartition(".")[2] for drive in STATED} == set(DRIVES)


# Verdicts --------------------------------------------------------------------------------------


def of_kinds(name, *kinds, **changes):
    scenario = shipped(name, **changes)
    return scenario._replace(kinds=tuple(itertools.islice(itertools.cycle(kinds), scenario.n)))


ROBOTS = "largest distance from the law on these robots [m]"
COMMANDS = "commands off the published law [-]"


@pytest.mark.parametrize(
    "name", ["formation_omnidirectional", "formation_cars", "formation_mixed", "formation_boats"]
)
def test_each_drive_moves_as_it_is_stated(tmp_path, name):
    verdict = verdict_of(shipped(name, duration=6.0), tmp_path)
    assert check(verdict, COMMANDS)["passed"] and check(verdict, ROBOTS)["passed"]
    assert check(verdict, ROBOTS)["measured"] < 1e-8


@pytest.mark.parametrize(
    "drive, name", [(omnidirectional, "formation_omnidirectional"), (car, "formation_cars")]
)
def test_a_mistake_in_the_mapping_of_a_drive_fails(tmp_path, monkeypatch, drive, name):
    mapping = "wanted" if drive.JOINTS else "command"
    right = getattr(drive, mapping)

    def wrong(velocity, *given, **out):
        return right(1.05 * velocity, *given, **out)

    monkeypatch.setattr(drive, mapping, wrong)
    assert {COMMANDS, ROBOTS} <= set(failed(verdict_of(shipped(name, duration=2.0), tmp_path)))


def test_who_was_slow_is_named_and_the_rest_is_judged(tmp_path):
    given = of_kinds("paper_four", "pioneer3dx", "robotino3", "turtlebot3_burger", duration=60)
    verdict = verdict_of(given, tmp_path)
    settling = check(verdict, "settling time")
    assert settling["passed"] and "robot2 was at its limits until" in settling["note"], settling
    assert verdict["passed"], failed(verdict)


def test_limits_that_go_on_in_the_judged_rest_are_named(tmp_path):
    verdict = verdict_of(shipped("crazyflies_cube", duration=8.0), tmp_path)
    left_out = check(verdict, "worst displacement error")["note"]
    note = check(verdict, "largest distance from the exact solution")["note"]
    assert "until 8.0 s" in left_out and "until 7.7 s" in note
    assert float(note.split("; limits cut ")[1].split(" m at most")[0]) <= 0.001, note


def test_a_robot_too_slow_for_its_leader_is_not_judged(tmp_path):
    given = of_kinds("leader_follower", "pioneer3dx", "robotino3", "turtlebot3_burger", duration=16)
    verdict = verdict_of(given, tmp_path)
    error = check(verdict, "worst separation error")
    assert error["passed"] is None and "at its limits until" in error["note"], error
    # The rims of the Robotinos turn with 0.59 m/s at most.
    assert "robot5 was" in error["note"] and "(and robot2)" in error["note"]
    assert error["measured"] > 0.1
    assert not failed(verdict)


class Hasty(PioneerControl):
    """States consensus and does a little more."""

    MEMORYLESS = True

    def pointMassLaw(self, hand):
        return -0.0505 * self.topology.laplacian() @ hand

    def published(self):
        from mrs_simulator.protocols.published.laws import Averaging, weights_of

        return Averaging(weights_of(self.topology), 0.05)


def test_a_law_of_ones_own_is_held_against_its_statement_on_any_team(tmp_path):
    given = of_kinds("displacement_formation", "robotino3", "f1tenth", duration=2)
    given = given.changed(control=dict(given.control._asdict(), parameters={"l": 0.3}))
    verdict = verdict_of(given, tmp_path, Hasty)
    assert {COMMANDS, ROBOTS} <= set(failed(verdict))
