"""Mirrored robots: bodies that are only where they are put, among simulated ones."""

import numpy as np
import pytest

from mrs_simulator.scenario.surroundings.obstacles import Box
from mrs_simulator.vehicles import kind
from mrs_simulator.world.world import World, WorldError

KIND = "pioneer3dx"
PIONEER = kind("pioneer3dx")
FIDELITIES = ("kinematic", "dynamic")
EXACT = {"kinematic": 1e-9, "dynamic": 2e-3}  # [m] rigid bodies in pybullet sink in a little
APART = 2.0 * PIONEER.body.front  # [m] of two centres, nose to nose


@pytest.fixture
def world():
    made = []

    def make(poses, **options):
        options = dict({"mirrored": [1], "limits": "top"}, **options)
        made.append(World((KIND,) * len(poses), poses, **options))
        return made[-1]

    yield make
    for each in made:
        each.close()


def drive(world, v, seconds):
    """Command every robot, the mirrored ones too."""
    rows, command = np.arange(world.n), np.broadcast_to([v, 0.0], (world.n, 2))
    for _ in range(int(round(seconds / world.step_size))):
        world.set_commands(rows, command)
        world.step()


@pytest.mark.parametrize("fidelity", FIDELITIES + ("point_mass",))
def test_it_is_where_it_was_put_and_obeys_no_command(world, fidelity):
    made = world([[0.0, 0.0, 0.0], [3.0, 0.0, 1.0]], fidelity=fidelity)
    drive(made, 0.3, 0.5)
    np.testing.assert_allclose(made.pose[1], [3.0, 0.0, 1.0], atol=1e-12)
    made.place([1], [[5.0, 2.0, 7.0]], [[0.2, 0.0, -0.1]])
    drive(made, 0.3, 0.5)
    np.testing.assert_allclose(made.pose[1], [5.0, 2.0, 7.0 - 2.0 * np.pi], atol=1e-12)
    assert made.twist[1].tolist() == [0.2, 0.0, -0.1]
    assert made.pose[0, 0] > 0.1 and made.twist[0, 0] > 0.2
    made.place([1], [[5.0, 2.0, 0.0]])
    made.step()
    assert not made.twist[1].any()


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_a_simulated_robot_runs_into_it_and_does_not_push_it(world, fidelity):
    made = world([[0.0, 0.0, 0.0], [1.2, 0.0, np.pi]], fidelity=fidelity)
    drive(made, 0.5, 3.0)
    assert made.contacts.take()[0][1:3] == ("robot1", "robot2")
    np.testing.assert_allclose(np.abs(made.pose[1]), [1.2, 0.0, np.pi], atol=1e-12)
    assert made.pose[0, 0] == pytest.approx(1.2 - APART, abs=EXACT[fidelity])
    assert abs(made.twist[0, 0]) < 0.05


def test_the_simulated_robot_gives_way_by_all_of_the_depth(world):
    for row in (0, 1):
        made = world([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], mirrored=[row])
        made.place([row], [[0.5 if row == 0 else 0.45, 0.0, 0.0]])
        made.step()
        # Nose to tail, one robot's length from centre to centre.
        assert made.pose[1, 0] - made.pose[0, 0] == pytest.approx(PIONEER.body.length)


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_it_pushes_a_simulated_robot_away(world, fidelity):
    made = world([[0.0, 0.0, 0.0], [1.0, 0.0, np.pi]], fidelity=fidelity)
    for x in np.arange(1.0, 0.0, -0.01):
        made.place([1], [[x, 0.0, np.pi]], [[0.5, 0.0, 0.0]])
        made.step()
    assert made.pose[1, 0] == pytest.approx(x)
    assert made.pose[0, 0] == pytest.approx(x - APART, abs=0.03)
    assert [each[1:3] for each in made.contacts.take()] == [("robot1", "robot2")]


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_two_of_them_and_obstacles_are_named_and_no_robot_moves(world, fidelity):
    poses = [[-3.0, 0.0, 0.0], [0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]
    crate = Box("crate", 0.0, 3.0, 0.0, 1.0, 1.0, 0.5)
    made = world(poses, obstacles=[crate], mirrored=[2, 1], fidelity=fidelity)
    # In a row, each with its nose 1 cm deep in what is ahead of it.
    ahead = 2.5 - PIONEER.body.front + 0.01
    where = [[0.0, ahead, 0.5 * np.pi], [0.0, ahead - PIONEER.body.length + 0.01, 0.5 * np.pi]]
    made.place([1, 2], where)
    for _ in range(5):
        made.step()
    np.testing.assert_allclose(made.pose[1:], where, atol=1e-12)
    told = {each[1:3] for each in made.contacts.take()}
    assert told == {("robot2", "robot3"), ("robot2", "crate")}


def test_a_jump_into_a_simulated_robot_leaves_finite_poses(world):
    made = world([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], fidelity="dynamic")
    made.place([1], [[0.1, 0.05, 0.3]])
    drive(made, 0.0, 1.0)
    assert np.isfinite(made.pose).all() and np.abs(made.pose).max() < 5.0
    np.testing.assert_allclose(made.pose[1], [0.1, 0.05, 0.3], atol=1e-12)


def test_the_first_robot_may_be_mirrored_and_the_others_stand_as_before(world):
    poses = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]
    made = world(poses, mirrored=[0], fidelity="dynamic")
    alone = world(poses, mirrored=[], fidelity="dynamic")
    drive(made, 0.3, 1.0)
    drive(alone, 0.3, 1.0)
    np.testing.assert_allclose(made.pose[1], alone.pose[1], atol=1e-3)
    assert made.pose[0].tolist() == [0.0, 0.0, 0.0]


def test_reset_leaves_it_where_it_is_and_refuses_an_occupied_place(world):
    made = world([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    drive(made, 0.5, 1.0)
    made.place([1], [[4.0, 1.0, 0.0]])
    made.reset()
    assert made.pose.tolist() == [[0.0, 0.0, 0.0], [4.0, 1.0, 0.0]]
    made.place([1], [[0.2, 0.1, 0.0]])
    before = made.pose.tolist()
    with pytest.raises(WorldError, match="robot1 and robot2 overlap"):
        made.reset()
    assert made.pose.tolist() == before


def test_its_watchdog_and_its_odometry_are_its_own(world):
    made = world([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], odometry_kind="wheel")
    drive(made, 0.5, 0.2)
    assert made.command.tolist() == [[0.5, 0.0]] * 2  # shown, though not obeyed
    made.place([1], [[4.0, 1.0, 0.5]])
    for _ in range(40):
        made.step()
    assert made.commands.timed_out.tolist() == [True, False]
    assert made.estimates.pose()[1].tolist() == made.pose[1].tolist()


@pytest.mark.parametrize(
    "rows, poses, said",
    [
        ([0], [[1.0, 0.0, 0.0]], "robot1 is simulated"),
        ([1], [[np.nan, 0.0, 0.0]], "robot2: pose .*nan.*wanted finite"),
        ([1], [[1e9, 0.0, 0.0]], "robot2: pose .*within 1e"),
    ],
)
def test_what_cannot_be_placed_is_refused_by_name(world, rows, poses, said):
    made = world([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    with pytest.raises(WorldError, match=said):
        made.place(rows, poses)
    assert made.pose.tolist() == [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]


def test_a_team_without_a_mirrored_robot_is_refused(world):
    made = world([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    with pytest.raises(WorldError, match=r"real robots \[2\]: wanted numbers from 1 to 1"):
        made.set_team((KIND,), [[0.0, 0.0, 0.0]])
    assert made.n == 2
    with pytest.raises(WorldError, match=r"real robots \[0\]"):
        world([[0.0, 0.0, 0.0]], mirrored=[-1])


@pytest.mark.parametrize("period, stopped_after", [(0.0, 0.6), (0.1, 0.7)])
def test_the_watchdog_looks_as_often_as_it_is_set_to(world, period, stopped_after):
    made = world([[0.0, 0.0, 0.0]], mirrored=[], limits=None, watch_period=period)
    for _ in range(2):
        made.step()
    made.set_commands([0], np.array([[0.5, 0.0]]))  # at 0.04 s: 0.6 s later lies between two looks
    while not made.commands.timed_out[0]:
        made.step()
    # It drove on until the look that found it silent.
    expected = 0.5 * (stopped_after - 0.04 if period else stopped_after)
    assert made.pose[0, 0] == pytest.approx(expected)
