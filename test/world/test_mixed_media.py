"""Robots on the ground, in the water and in the air in one team, with forces."""

import numpy as np
import pytest
from protocol_fixtures import check, failed, shipped, verdict_of

from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.surroundings.environment import Environment
from mrs_simulator.vehicles import Team
from mrs_simulator.world.world import EVERY, World

KINDS = ("heron", "pioneer3dx", "crazyflie2", "robotino3", "f1tenth", "otter", "crazyflie2")
ROWS = {"ground": [1, 3, 4], "water": [0, 5], "air": [2, 6]}
POSES = np.array([[4.0 * row, 3.0 * (row % 2), 0.3 * row] for row in range(len(KINDS))])
HEIGHTS = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.5])
WEATHER = Environment(current=(0.2, -0.1), wind=(1.0, 0.0))  # the same for each, wherever it stands
AHEAD = {"linear.x": 0.3, "linear.y": 0.1, "linear.z": 0.2, "angular.z": 0.2}


def driven(rows, **options):
    """Return the world of the robots ``rows`` of the team after 1.2 s under one command."""
    world = World(
        [KINDS[row] for row in rows], POSES[rows], fidelity="dynamic", z=HEIGHTS[rows],
        environment=WEATHER, cmd_vel_timeout=9.0, odometry_kind="wheel", **options,
    )  # fmt: skip
    drive(world, 60)
    return world


def drive(world, steps):
    """Let each robot obey a command on all of its axes for ``steps``."""
    team = world.team
    for _ in range(steps):
        world.set_commands(
            EVERY, np.where(team.robot_axes, [AHEAD[axis] for axis in team.axes], 0.0)
        )
        world.step()


@pytest.fixture(scope="module")
def mixed():
    world = driven(list(range(len(KINDS))))
    yield world
    world.close()


@pytest.mark.parametrize("medium", sorted(ROWS))
def test_each_moves_as_it_does_without_robots_of_other_media(mixed, medium):
    rows = ROWS[medium]
    alone = driven(rows)
    for name in ("pose", "twist", "joints"):
        np.testing.assert_array_equal(getattr(alone, name), getattr(mixed, name)[rows])
    np.testing.assert_array_equal(alone.estimates.pose(), mixed.estimates.pose()[rows])
    if medium == "air":
        np.testing.assert_array_equal(alone.z, mixed.z[rows])
    alone.close()


def test_it_begins_anew():
    world = driven([0, 1, 2])
    first = world.pose.copy(), world.z.copy(), world.estimates.pose().copy()
    world.reset()
    np.testing.assert_array_equal(world.pose[:, :2], POSES[:3, :2])
    drive(world, 60)
    for value, again in zip(first, (world.pose, world.z, world.estimates.pose())):
        np.testing.assert_allclose(again, value, atol=1e-3)  # the solver remembers its contacts
    world.close()


def test_those_on_wheels_are_firm_to_others():
    """A Heron drives against a Pioneer, and a Crazyflie against a Robotino."""
    poses = [[1.2, 0.0, 0.0], [3.0, 0.0, 1.57], [1.8, 9.0, 0.0], [3.0, 9.0, 0.0]]
    world = World(("heron", "pioneer3dx", "crazyflie2", "robotino3"), poses, fidelity="dynamic",
                  z=[0.0, 0.0, 0.05, 0.0])  # fmt: skip
    command = np.zeros((4, len(world.team.axes)))
    command[[0, 2], world.team.axes.index("linear.x")] = [0.8, 0.5]
    for _ in range(160):
        world.set_commands(EVERY, command)
        world.step()
    told = {(each.first, each.second) for each in world.contacts.take()}
    assert told == {("robot1", "robot2"), ("robot3", "robot4")}
    alone = World(("pioneer3dx", "robotino3"), [poses[1], poses[3]], fidelity="dynamic")
    for _ in range(160):
        alone.step()
    np.testing.assert_array_equal(world.pose[[1, 3]], alone.pose)
    alone.close()
    assert world.pose[0, 0] == pytest.approx(3.0 - 0.675 - 0.5 * 0.425, abs=0.02)
    assert np.abs(world.twist[0, 0]) < 0.02
    world.close()


def test_a_robot_on_wheels_pushes_a_boat_and_meets_its_like_in_the_solver():
    poses = [[0.0, 0.0, 0.0], [1.5, 0.0, 1.57], [0.0, 9.0, 0.0], [0.6, 9.0, np.pi]]
    world = World(("pioneer3dx", "heron", "pioneer3dx", "pioneer3dx"), poses, fidelity="dynamic")
    for _ in range(200):
        world.set_commands([0, 2, 3], np.array([[0.4, 0.0]] * 3))
        world.step()
    told = {(each.first, each.second) for each in world.contacts.take()}
    assert told == {("robot1", "robot2"), ("robot3", "robot4")}
    assert world.pose[0, 0] > 1.3
    assert world.pose[1, 0] > 2.0
    assert world.pose[3, 0] - world.pose[2, 0] > 0.4
    world.close()


def test_a_mirrored_robot_is_where_it_is_put():
    world = World(
        ("heron", "pioneer3dx", "pioneer3dx"), POSES[:3], fidelity="dynamic", mirrored=(1,),
        environment=WEATHER,
    )  # fmt: skip
    world.place([1], np.array([[9.0, 9.0, 1.0]]), np.array([[0.1, 0.0, 0.0]]))
    drive(world, 50)
    np.testing.assert_array_equal(world.pose[1], [9.0, 9.0, 1.0])
    np.testing.assert_array_equal(world.twist[1], [0.1, 0.0, 0.0])
    assert world.pose[2, 0] > POSES[2, 0] + 0.1
    world.close()


def test_a_groups_part_is_written_to_axes_that_lie_apart():
    """A Robotino obeys linear.x, linear.y and angular.z of a team that also knows linear.z."""
    team = Team(("crazyflie2", "robotino3"))
    values = np.zeros((2, 4))
    team.groups[1].put(values, np.array([[1.0, 2.0, 3.0]]))
    np.testing.assert_array_equal(values, [[0.0] * 4, [1.0, 2.0, 0.0, 3.0]])


def test_the_team_on_the_shore_passes_its_verdict(tmp_path):
    verdict = verdict_of(shipped("shore", fidelity="dynamic", duration=2.0), tmp_path)
    assert check(verdict, "commands off the published law [-]")["passed"]
    # Of the whole, 80 s, the theorem is tested where shipped scenarios are.
    assert not failed(verdict) and "the theorem is not tested" in verdict["reason"]


def test_what_is_late_for_ever_is_judged_once_that_costs_nothing(tmp_path):
    """Boats come to their speeds without end; a law that knows the time alone goes on from any moment."""
    content = {
        "model": "heron",
        "poses": [[1.0, 1.0, 0.0], [-3.0, 3.0, 0.0]],
        "fidelity": "dynamic",
        "control": {
            "protocol": "marching",
            "rate": 5,
            "parameters": {
                "path": "line",
                "shape": "line",
                "gain": 0.1,
                "anchor": 0.1,
                "speed": 0.3,
            },
        },
        "topology": {"edges": [[1, 2]], "directed": False},
        "duration": 30.0,
    }
    verdict = verdict_of(scenario_from_dict(content), tmp_path)
    assert check(verdict, "steady displacement error [m]")["passed"]
