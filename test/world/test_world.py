"""The world: exact motion, limits, watchdogs, collisions, teams, odometry."""

import numpy as np
import pytest

from mrs_simulator.core.kinematics import Limits
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.surroundings.obstacles import Box
from mrs_simulator.scenario.team.layouts import make_layout
from mrs_simulator.vehicles import kind
from mrs_simulator.world.world import EVERY, World, WorldError

ONE = ("pioneer3dx",)
PIONEER = kind("pioneer3dx")


def drive(world, command, seconds):
    """Give all robots ``command`` at each step for ``seconds``."""
    rows = np.arange(world.n)
    for _ in range(int(round(seconds / world.step_size))):
        world.set_commands(rows, np.broadcast_to(command, (world.n, 2)))
        world.step()
    return world


def test_a_held_command_is_an_exact_arc():
    world = drive(World(ONE, [[1.0, 2.0, 0.3]], limits=None), [0.5, 0.8], 2.0)
    # x' = v cos theta, y' = v sin theta, theta' = omega, integrated by hand.
    theta = 0.3 + 0.8 * 2.0
    radius = 0.5 / 0.8
    expected = [
        1.0 + radius * (np.sin(theta) - np.sin(0.3)),
        2.0 - radius * (np.cos(theta) - np.cos(0.3)),
        theta,
    ]
    np.testing.assert_allclose(world.pose[0], expected, atol=1e-12)
    np.testing.assert_allclose(world.twist[0], [0.5, 0.0, 0.8])


def test_limits_are_the_firmwares():
    world = drive(World(ONE, [[0.0, 0.0, 0.0]]), [5.0, 0.0], 1.0)
    assert world.twist[0, 0] == pytest.approx(0.3)  # 0.3 m/s^2 for 1 s
    drive(world, [5.0, 0.0], 4.0)
    assert world.twist[0, 0] == pytest.approx(0.75)


def test_acceleration_covers_the_distance_that_it_must():
    # v^2/(2 a) while it speeds up: 0.75^2/0.6 = 0.9375 m in 2.5 s.
    world = drive(World(ONE, [[0.0, 0.0, 0.0]]), [5.0, 0.0], 2.5)
    assert world.pose[0, 0] == pytest.approx(0.9375, abs=1e-9)


def test_each_robot_is_stopped_by_its_own_watchdog():
    world = World(ONE * 2, [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]], limits=None)
    world.set_commands([0, 1], np.array([[0.5, 0.0], [0.5, 0.0]]))
    for _ in range(50):
        world.set_commands([1], np.array([[0.5, 0.0]]))
        world.step()
    assert world.commands.timed_out.tolist() == [True, False]
    assert world.pose[0, 0] == pytest.approx(0.5 * 0.6)
    assert world.pose[1, 0] == pytest.approx(0.5)


@pytest.mark.parametrize("bad", [[np.nan, 0.0], [0.0, np.inf], [-np.inf, np.nan]])
def test_commands_that_are_not_finite_are_refused_and_counted(bad):
    world = World(ONE * 2, [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]], limits=None)
    world.set_commands([0, 1], np.array([bad, [0.5, 0.0]]))
    world.step()
    assert world.commands.refused.tolist() == [1, 0]
    assert world.pose[0].tolist() == [0.0, 0.0, 0.0]
    assert world.pose[1, 0] > 0.0


def test_a_collision_is_reported_once_and_blocks_the_way():
    world = World(ONE * 2, [[0.0, 0.0, 0.0], [1.0, 0.0, np.pi]], limits=None)
    drive(world, [0.5, 0.0], 2.0)
    (collision,) = world.contacts.take()
    # Fronts 0.21 m ahead of each centre: they meet 0.29 m from each start.
    assert collision.time == pytest.approx(0.58, abs=0.021)
    assert collision[1:3] == ("robot1", "robot2")
    assert (collision.x, collision.y) == pytest.approx((0.5, 0.0), abs=0.01)
    assert world.motion.closest() == pytest.approx(0.42, abs=1e-6)
    assert world.contacts.closest <= world.motion.closest()
    assert world.contacts.take() == []


def test_a_robot_does_not_enter_an_obstacle():
    world = World(
        ONE, [[0.0, 0.0, 0.0]], obstacles=[Box("crate", 1.5, 0.0, 0.0, 1.0, 1.0, 0.5)], limits=None
    )
    drive(world, [0.5, 0.0], 4.0)
    assert world.contacts.take()[0][1:3] == ("robot1", "crate")
    assert world.pose[0, 0] <= 1.0 - PIONEER.body.front + 1e-9


def test_overlapping_robots_are_refused_by_name():
    poses = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.2, 0.1, 0.0]]
    with pytest.raises(WorldError, match="robot2 and robot3 overlap: centres 0.224 m apart"):
        World(ONE * 3, poses)
    with pytest.raises(WorldError, match="robot1 overlaps obstacle crate"):
        World(ONE, poses[:1], obstacles=[Box("crate", 0.3, 0.0, 0.0, 0.2, 0.2, 0.5)])
    assert World(ONE * 3, poses, fidelity="point_mass").n == 3  # points have no bodies


@pytest.mark.parametrize(
    "kinds, poses, said",
    [
        (ONE, [[0.0, 0.0]], r"shape \(1, 2\)"),
        ((), [], "at least one"),
        (ONE * 2, [[0.0, 0.0, 0.0], [2.0, np.nan, 0.0]], "robot2: pose .*nan"),
        (("pioneer4dx",), [[0.0, 0.0, 0.0]], "did you mean 'pioneer3dx'"),
    ],
)
def test_a_team_that_cannot_be_leaves_the_old_one(kinds, poses, said):
    world = World(ONE, [[1.0, 0.0, 0.0]])
    with pytest.raises(WorldError, match=said):
        world.set_team(kinds, poses)
    assert world.pose.tolist() == [[1.0, 0.0, 0.0]]


def test_reset_puts_robots_back_at_rest_and_time_goes_on():
    world = drive(World(ONE, [[1.0, 2.0, 3.0]]), [0.5, 0.1], 1.0)
    world.reset()
    assert world.pose.tolist() == [[1.0, 2.0, 3.0]]
    assert not world.twist.any() and not world.commands.commanded.any()
    assert world.time == pytest.approx(1.0)
    world.step()
    assert world.pose.tolist() == [[1.0, 2.0, 3.0]]


def test_wheel_odometry_starts_at_zero_and_drifts():
    start = [[4.0, -1.0, 1.0], [8.0, 1.0, -2.0]]
    world = World(ONE * 2, start, odometry_kind="wheel", seed=3)
    assert not world.estimates.odometry().any()
    np.testing.assert_array_equal(world.estimates.origins(), start)
    drive(world, [0.5, 0.3], 10.0)
    error = world.estimates.pose() - world.pose
    assert 1e-5 < np.abs(error[:, :2]).max() < 0.5
    assert np.abs(world.estimates.odometry()[:, 0]).max() < 5.0
    again = drive(World(ONE * 2, start, odometry_kind="wheel", seed=3), [0.5, 0.3], 10.0)
    np.testing.assert_array_equal(world.estimates.odometry(), again.estimates.odometry())


def test_point_masses_keep_their_heading():
    world = drive(World(ONE, [[0.0, 0.0, 0.0]], fidelity="point_mass"), [0.5, 2.0], 1.0)
    np.testing.assert_allclose(world.pose[0], [0.5, 0.05 * 2.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("n", [1, 2, 7, 50, 200, 1000])
def test_any_number_of_robots_drives(n):
    poses = make_layout("grid", n, spacing=1.5)
    world = drive(World(ONE * n, poses, limits=Limits(1.0, 1.0, np.inf, np.inf)), [0.2, 0.1], 0.2)
    np.testing.assert_allclose(world.pose[:, 2] - poses[:, 2], 0.02)
    assert world.contacts.take() == []


@pytest.mark.parametrize("mirrored", [(), (1,)])
def test_arrays_lie_in_memory_column_by_column(mirrored):
    # Laws, samples and steps read them by columns: a step of 10,000 robots takes a fourth more otherwise.
    world = World(ONE * 3, make_layout("grid", 3, spacing=2.0), mirrored=mirrored)
    drive(world, [0.3, 0.1], 0.1)
    if mirrored:
        world.place(mirrored, [[9.0, 0.0, 0.0]])
    for array in (world.pose, world.estimates.pose(), world.command, world.twist):
        assert array.flags.f_contiguous and not array.flags.c_contiguous


def test_each_step_counts_with_numbers_of_pythons_own():
    # A numpy scalar takes ten times as long: together a tenth of a step of few robots.
    world = drive(World(ONE * 2, [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]), [0.3, 0.1], 3.0)
    commands, bodies = world.commands, world.motion._bodies
    counted = commands._longest_silent, bodies.room, bodies._free
    assert commands._longest_silent > 0 and 0.0 < bodies.room < bodies._free
    assert [type(number) for number in counted] == [int, float, float]


def test_watchdogs_look_at_every_robot_in_time():
    world = World(
        ONE * 6, make_layout("grid", 6, spacing=2.0), cmd_vel_timeout=0.1, watch_period=0.04
    )
    heard, draw = np.full(6, -100), np.random.default_rng(5)
    for step in range(200):
        rows = np.flatnonzero(draw.random(6) < 0.15)
        world.set_commands(rows, np.full((len(rows), 2), 0.1))
        heard[rows] = step
        world.step()
        # Silent for more than 5 steps, looked at every second one: known by the next look.
        assert world.commands.commanded[step - heard <= 4].all()
        assert not world.commands.commanded[step - heard >= 6].any()
        assert not world.command[~world.commands.commanded].any()


def test_every_robot_is_commanded_at_once_and_by_one_bad_row_no_other_is_lost():
    world = World(ONE * 3, make_layout("grid", 3, spacing=2.0))
    world.set_commands(EVERY, np.array([[0.1, 0.0], [np.nan, 0.0], [0.3, 0.0]]))
    assert world.command[:, 0].tolist() == [0.1, 0.0, 0.3]
    assert world.commands.refused.tolist() == [0, 1, 0] and world.commands.commanded.tolist() == [
        True,
        False,
        True,
    ]


def test_a_run_after_a_reset_is_the_same_run():
    world = World(ONE * 2, [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], odometry_kind="wheel", seed=4)
    first = drive(world, [0.4, 0.2], 2.0).estimates.odometry().copy()
    world.reset()
    np.testing.assert_array_equal(drive(world, [0.4, 0.2], 2.0).estimates.odometry(), first)


def test_what_the_world_hands_out_cannot_be_changed():
    world = drive(World(ONE, [[0.0, 0.0, 0.0]]), [0.4, 0.2], 0.1)
    for array in (world.pose, world.twist, world.command, world.joints, world.estimates.odometry()):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_odometry_noise_of_a_robot_in_a_mixed_team_is_its_own():
    places = [[3.0 * row, 0.0, 0.0] for row in range(4)]
    kinds = ("pioneer3dx", "robotino3", "f1tenth", "pioneer3dx")

    def told(count):
        world = World(kinds[:count], places[:count], odometry_kind="wheel", seed=2)
        for _ in range(100):
            world.set_commands(EVERY, np.broadcast_to([0.2, 0.0, 0.1], (count, 3)))
            world.step()
        return world.estimates.odometry().copy()

    np.testing.assert_array_equal(told(4)[:3], told(3))
    assert np.abs(told(4)[3] - told(4)[0]).max() > 1e-6  # nor is it another's


def test_each_kind_is_stopped_after_its_own_silence():
    world = World(("pioneer3dx", "husky"), [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]], limits=None)
    world.set_commands(EVERY, np.full((2, 2), 0.1))
    when = [None, None]
    for _ in range(50):
        world.step()
        for row in np.flatnonzero(world.commands.timed_out):
            when[row] = when[row] or world.time
    # Seen one step after the last in which it still drove.
    np.testing.assert_allclose(when, world.commands.timeouts + 0.02, atol=0.011)
    assert world.commands.timeouts[1] == 0.25
    given = World(("pioneer3dx", "husky"), world.pose, cmd_vel_timeout=1.0)
    assert given.commands.timeouts.tolist() == [1.0, 1.0]


def test_encoders_of_point_masses_are_refused_by_name():
    content = {"poses": [[0, 0, 0]], "sensors": [{"mounts": {"wheels": {"type": "encoders"}}}]}
    scenario = scenario_from_dict(content)
    World.from_scenario(scenario).close()
    with pytest.raises(
        WorldError, match="robot1: wheels are encoders, but point masses have no wheels"
    ):
        World.from_scenario(scenario.changed(fidelity="point_mass"))
