"""The drives in the world: mixed teams, outlines, odometry and point masses."""

import os

import numpy as np
import pytest

from mrs_simulator.core.kinematics import Limits
from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.study.results.report import judged
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.vehicles import Team, kind, shipped_kinds
from mrs_simulator.vehicles.team import on_axes
from mrs_simulator.world.world import EVERY, World, WorldError

MIXED = ("pioneer3dx", "robotino3", "f1tenth", "husky", "youbot")
APART = [[3.0 * row, 0.0, 0.0] for row in range(5)]
X, Y, TURN = 0, 1, 2  # the axes of a mixed team


def drive(world, commands, duration):
    for _ in range(int(round(duration / world.step_size))):
        world.set_commands(EVERY, np.array(commands, dtype=float))
        world.step()
    return world.pose - np.array(APART[: world.n])


def test_a_mixed_team_has_the_axes_of_all_and_each_robot_its_own():
    team = Team(MIXED)
    assert team.axes == ("linear.x", "linear.y", "angular.z")
    np.testing.assert_array_equal(team.robot_axes[:, Y], [False, True, False, False, True])
    assert team.robot_axes[:, [X, TURN]].all()
    assert [group.drive.__name__.rpartition(".")[2] for group in team.groups] == [
        "differential",
        "omnidirectional",
        "car",
    ]


def test_every_robot_of_a_mixed_team_moves_by_its_own_drive():
    limits = Limits(2.0, 3.0, np.inf, np.inf)
    world = World(MIXED, APART, limits=limits)
    moved = drive(world, [[0.2, 0.0, 0.0], [0.2, 0.1, 0.0], [1.0, 0.0, 0.0], [0.3, 0.0, 0.0],
                          [0.0, 0.4, 0.0]], 2.0)  # fmt: skip
    np.testing.assert_allclose(
        moved[:, :2], [[0.4, 0.0], [0.4, 0.2], [2.0, 0.0], [0.6, 0.0], [0.0, 0.8]], atol=1e-9
    )
    np.testing.assert_allclose(world.twist[4], [0.0, 0.4, 0.0], atol=1e-12)
    assert world.twist[2, 0] == pytest.approx(1.0)


@pytest.mark.parametrize("others", [(), ("crazyflie2", "f1tenth")])
def test_a_base_goes_sideways_no_faster_than_its_rims(others):
    kinds = ("robotino3", *others)
    world = World(kinds, APART[: len(kinds)], limits=Limits(2.0, 3.0, np.inf, np.inf))
    world.set_commands(
        [0], on_axes(np.array([[0.0, 2.0]]), ("linear.x", "linear.y"), world.team.axes)
    )
    world.step()
    assert world.twist[0, 1] == pytest.approx(0.589049, abs=1e-6)
    free = World(("robotino3",), [[0.0, 0.0, 0.0]], limits=None)
    free.set_commands([0], np.array([[0.0, 2.0, 0.0]]))
    free.step()
    assert free.twist[0, 1] == 2.0


def test_a_car_drives_its_least_circle():
    world = World(("f1tenth",), [[0.0, 0.0, 0.0]], limits=Limits(5.0, 9.0, np.inf, np.inf))
    poses = []
    for step in range(600):
        world.set_commands([0], np.array([[1.0, 9.0]]))
        world.step()
        if step > 50:  # once it is steered
            poses.append(world.pose[0, :2].copy())
    poses = np.array(poses)
    across = poses.max(axis=0) - poses.min(axis=0)
    np.testing.assert_allclose(across, 2.0 * 0.7416, atol=2e-3)


@pytest.mark.parametrize("name", shipped_kinds())
def test_each_kind_stops_by_itself_after_its_silence_and_is_set_back(name):
    world = World((name,), [[1.0, 2.0, 0.5]])
    axes = len(world.team.axes)
    world.set_commands([0], np.full((1, axes), 0.1))
    for _ in range(200):
        world.step()
    assert not world.command.any()
    # What floats or flies comes to rest by and by.
    np.testing.assert_allclose(
        world.twist, 0.0, atol=1e-9 if kind(name).module.MEDIUM == "ground" else 6e-3
    )
    assert np.hypot(*(world.pose[0, :2] - [1.0, 2.0])) > 0.01
    world.reset()
    np.testing.assert_array_equal(world.pose, [[1.0, 2.0, 0.5]])


def test_odometry_of_every_drive_follows_the_truth_but_for_its_noise():
    world = World(MIXED, APART, odometry_kind="wheel", seed=3)
    commands = [[0.2, 0.0, 0.3], [0.2, 0.1, 0.3], [0.5, 0.0, 0.3], [0.3, 0.0, 0.2], [0.2, 0.2, 0.2]]
    drive(world, commands, 4.0)
    error = np.abs(world.estimates.pose() - world.pose)
    assert error[:, :2].max() < 0.02
    assert (error[:, :2].max(axis=1) > 0.0).all()


def test_round_and_square_robots_touch_where_their_outlines_do():
    apart = 0.210 + 0.225  # a Pioneer's front and a Robotino's radius
    World(("pioneer3dx", "robotino3"), [[0.0, 0.0, 0.0], [apart + 0.001, 0.0, 0.0]])
    with pytest.raises(WorldError, match="robot1 and robot2 overlap"):
        World(("pioneer3dx", "robotino3"), [[0.0, 0.0, 0.0], [apart - 0.001, 0.0, 0.0]])


def test_a_base_pushed_sideways_against_another_is_stopped_and_reported():
    world = World(("robotino3", "youbot"), [[0.0, 0.0, 0.0], [0.0, 0.7, 0.0]])
    for _ in range(200):
        world.set_commands([0], np.array([[0.0, 0.3, 0.0]]))
        world.step()
    assert [collision[1:3] for collision in world.contacts.take()] == [("robot1", "robot2")]
    assert world.pose[1, 1] - world.pose[0, 1] > 0.225 + 0.180 - 0.01


@pytest.mark.parametrize("name", ["robotino3", "pioneer3dx", "f1tenth"])
def test_a_point_mass_moves_as_its_command_says(name):
    options = dict(fidelity="point_mass", hand_length=0.2, command_period=0.05)
    world = World((name,), [[1.0, 2.0, 0.7]], **options)
    team, wanted = world.team, np.array([[0.3, -0.4]])
    before = team.point(world.pose, np.zeros(1), 0.2)
    world.set_commands([0], team.command(wanted, world.pose, np.zeros(1), 0.2, 0.05))
    world.step()
    after = team.point(world.pose, np.zeros(1), 0.2)
    np.testing.assert_allclose(after - before, 0.02 * wanted, atol=1e-15)


def test_saturation_slows_each_robot_along_its_own_direction():
    team = Team(MIXED)
    joints = np.array([0.0, 0.0, 0.1, 0.0, 0.0])
    pose = np.array([[0.0, 0.0, 0.4]] * 5)
    wanted = np.array([[2.0, 0.1], [1.0, 1.0], [30.0, 2.0], [-3.0, 0.2], [0.1, -0.2]])
    command = team.command(wanted, pose, joints, 0.3, 0.02)
    factor = team.excess(command, joints, 0.02)
    assert (factor[:4] > 1.0).all()
    assert factor[4] < 1.0
    slow = team.slowed(command, np.maximum(factor, 1.0), joints)
    after = team.excess(slow, joints, 0.02)
    np.testing.assert_allclose(after, np.minimum(factor, 1.0), rtol=1e-9)
    given = team.velocity(slow, pose, joints, 0.3, 0.02)
    np.testing.assert_allclose(given * np.maximum(factor, 1.0)[:, np.newaxis], wanted, rtol=1e-9)


def test_every_shipped_kind_can_be_loaded():
    assert {kind(name).drive for name in shipped_kinds()} == {
        "differential",
        "omnidirectional",
        "car",
        "vessel",
        "quadrotor",
    }


SCENARIOS = os.path.join(
    os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "scenarios"
)


def run_of(name, duration):
    """Return the ``Run`` of the first ``duration`` [s] of a shipped scenario, and its control."""
    scenario = load_scenario(os.path.join(SCENARIOS, name + ".yaml"))._replace(duration=duration)
    experiment = Experiment(scenario)
    samples = [
        (stamp, pose, experiment.state(pose, command).hand, command)
        for stamp, pose, command in experiment.samples()
    ]
    time, pose, hand, command = map(np.array, zip(*samples))
    run = Run(time, np.arange(1, scenario.n + 1), pose, hand, command, experiment.collisions,
              scenario, {"ended": "complete"}, experiment.control.team.axes)  # fmt: skip
    return run, experiment.control


@pytest.mark.parametrize(
    "name, duration, track",
    [
        ("formation_omnidirectional", 220.0, 1e-10),  # [m] from theory's track: exact
        # A start with ramps, 0.5 s late.
        pytest.param("formation_mixed", 220.0, 0.2, marks=pytest.mark.release),
        ("formation_cars", 60.0, 2.0),  # three cars take wider turns
        pytest.param("formation_cars", 100.0, 2.0, marks=pytest.mark.release),
    ],
)
def test_shipped_formations_pass_and_follow_theory_as_far_as_it_goes(name, duration, track):
    run, control = run_of(name, duration)
    verdict, prediction = judged(run, control)
    assert verdict["passed"], verdict["checks"]
    apart = np.linalg.norm(run.hand - prediction, axis=2).max(axis=0)
    assert apart.max() < track
    reached = control.team.at_limits(run.command, 0.999).any(axis=0)
    if name == "formation_cars":
        # Whoever steered within the limits followed theory; who did not is known to have not.
        np.testing.assert_array_equal(reached, [True, True, True, False, False, False, False])
        assert apart[3:].max() < 0.4  # the start with ramps
    else:
        assert not reached.any()


def test_at_a_limit_is_who_has_reached_one():
    team = Team(("pioneer3dx", "robotino3", "f1tenth", "f1tenth"))
    free = np.array([[0.7, 0.0, 0.0], [0.5, 0.0, 0.0], [5.0, 0.0, 5.0], [-4.0, 0.0, 1.0]])
    full = np.array([[0.75, 0.0, 0.0], [0.0, 0.589, 0.0], [1.0, 0.0, 1.4], [-5.0, 0.0, 0.0]])
    reached = team.at_limits(np.stack([free, full]), 0.999)
    np.testing.assert_array_equal(reached, [[False] * 4, [True] * 4])
