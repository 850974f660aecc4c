"""Motion with forces of kinds whose wheels slide or have rollers, alone and in mixed teams."""

import numpy as np
import pytest

from mrs_simulator.core.kinematics import Limits
from mrs_simulator.scenario.surroundings.obstacles import Box
from mrs_simulator.vehicles import kind
from mrs_simulator.world.world import EVERY, World

NO_RAMP = Limits(9.0, 9.0, np.inf, np.inf)


def world_of(*kinds, apart=3.0, **options):
    poses = [[apart * row, 0.0, 0.0] for row in range(len(kinds))]
    return World(kinds, poses, fidelity="dynamic", **options)


def drive(world, command, duration):
    try:
        for _ in range(int(round(duration / world.step_size))):
            world.set_commands(EVERY, np.array(command, dtype=float))
            world.step()
    finally:
        world.close()
    return world


@pytest.mark.parametrize(
    "name, command",
    [
        ("robotino3", (0.3, -0.2, 0.0)),
        ("robotino3", (0.0, 0.0, 0.5)),
        ("youbot", (0.0, 0.4, 0.0)),
        pytest.param("youbot", (0.3, 0.0, 0.5), marks=pytest.mark.release),
        ("husky", (0.5, 0.0)),
        pytest.param("husky", (0.0, 1.0), marks=pytest.mark.release),
        pytest.param("pioneer3at", (0.4, 0.5), marks=pytest.mark.release),
        ("f1tenth", (1.0, 0.5)),
        ("turtlebot3_burger", (0.2, 0.5)),
        pytest.param("amigobot", (0.3, 0.5), marks=pytest.mark.release),
        pytest.param("epuck", (0.1, 1.0), marks=pytest.mark.release),
    ],
)
def test_every_kind_follows_its_commands_on_its_wheels(name, command):
    world = drive(world_of(name), [command], 2.0)
    v = command[:-1] + (0.0,) * (3 - len(command))
    # Wheels that push sideways in a curve slide a little.
    np.testing.assert_allclose(world.twist[0], [*v, command[-1]], atol=0.015)


@pytest.mark.parametrize(
    "name, command",
    [("robotino3", (0.2, 0.1, 0.3)), ("f1tenth", (1.0, 0.5)), ("husky", (0.4, 0.5))],
)
def test_encoders_and_truth_part_only_by_what_the_wheels_slide(name, command):
    world = drive(world_of(name, odometry_kind="wheel"), [command], 2.0)
    gone = np.hypot(*world.pose[0, :2])
    slid = np.hypot(*(world.estimates.odometry()[0, :2] - world.pose[0, :2]))
    assert 0.0 < slid < 0.07 * gone


def test_the_ground_limits_how_a_car_accelerates():
    # 9.51 m/s^2 needs a friction of 0.97 under all wheels; only the rear one, with 0.48 of the weight,
    # drives: mu g (L - a)/L = 1.0489 * 9.81 * 0.4808 = 4.947 m/s^2.
    world = drive(
        world_of("f1tenth", limits=Limits(20.0, 90.0, np.inf, np.inf)), [(20.0, 0.0)], 0.4
    )
    assert world.twist[0, 0] / 0.4 == pytest.approx(4.947, rel=0.02)


def test_an_omnidirectional_base_accelerates_by_the_grip_of_its_wheels():
    # Ahead two of three wheels push, at 30 deg to the way: mu g 2 cos(30 deg)/3.
    grip = 0.9 * 9.81 * 2.0 * np.cos(np.pi / 6.0) / 3.0
    kinds = (
        kind(
            "strong",
            own={"strong": {"base": "robotino3", "wheels": {"torque": 90.0, "speed": 500.0}}},
        ),
    )
    world = drive(world_of(*kinds, limits=NO_RAMP), [(9.0, 0.0, 0.0)], 0.2)
    assert world.twist[0, 0] / 0.2 == pytest.approx(grip, rel=0.02)


def test_a_car_too_fast_for_its_curve_slides():
    world = drive(world_of("f1tenth"), [(5.0, 6.0)], 2.0)
    assert abs(world.twist[0, 1]) > 0.3
    assert np.hypot(*world.twist[0, :2]) < 4.5


def test_robots_of_three_drives_push_each_other_and_are_named():
    world = world_of("robotino3", "pioneer3dx", apart=0.8)
    drive(world, [(0.3, 0.0, 0.0), (0.0, 0.0, 0.0)], 3.0)
    assert [each[1:3] for each in world.contacts.take()] == [("robot1", "robot2")]
    assert world.pose[1, 0] > 0.81  # pushed along, against its braked wheels
    assert world.pose[1, 0] - world.pose[0, 0] > 0.301 + 0.225 - 0.02


def test_an_obstacle_stops_a_base_that_goes_sideways():
    wall = Box("wall", 0.0, 1.0, 0.0, 2.0, 0.1, 0.5)
    world = World(("youbot",), [[0.0, 0.0, 0.0]], obstacles=[wall], fidelity="dynamic")
    drive(world, [(0.0, 0.5, 0.0)], 3.0)
    assert [each[1:3] for each in world.contacts.take()] == [("robot1", "wall")]
    assert world.pose[0, 1] == pytest.approx(1.0 - 0.05 - 0.18, abs=0.02)


def test_a_mixed_team_gives_the_same_bytes_again_and_after_a_reset():
    kinds = ("pioneer3dx", "robotino3", "f1tenth", "husky")
    command = np.array([(0.2, 0.0, 0.3), (0.2, 0.1, 0.3), (0.5, 0.0, 0.3), (0.3, 0.0, 0.2)])

    def run(world):
        for _ in range(40):
            world.set_commands(EVERY, command)
            world.step()
        return world.pose.copy(), world.estimates.odometry().copy()

    first, second = (world_of(*kinds, odometry_kind="wheel") for _ in range(2))
    once = run(first)
    np.testing.assert_array_equal(once, run(second))
    first.reset()
    np.testing.assert_array_equal(run(first), once)
    first.close()
    second.close()


def test_a_mirrored_base_stays_where_it_is_put():
    world = world_of("robotino3", "robotino3", mirrored=[1])
    world.place([1], [[3.0, 1.0, 0.5]])
    drive(world, [(0.2, 0.0, 0.0)] * 2, 1.0)
    np.testing.assert_array_equal(world.pose[1], [3.0, 1.0, 0.5])
    assert world.pose[0, 0] > 0.1
