"""Quadrotors in the world: heights, silence, wind, contacts, and other robots beside them."""

import numpy as np
import pytest
from protocol_fixtures import failed, shipped, verdict_of

from mrs_simulator.scenario.surroundings.environment import Environment
from mrs_simulator.world.world import EVERY, World

BOTH = pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])


def flown(world, command, duration):
    for _ in range(int(round(duration / world.step_size))):
        world.set_commands(EVERY, np.array(command, dtype=float))
        world.step()


@BOTH
def test_each_takes_off_flies_and_lands(fidelity):
    poses = [[0.0, 0.0, 0.5 * np.pi], [5.0, 0.0, 0.5 * np.pi]]
    world = World(("crazyflie2", "ardrone2"), poses, fidelity=fidelity)
    ahead, up, down = ([[v, 0.0, w, 0.0]] * 2 for v, w in ((0.5, 0.0), (0.0, 0.5), (0.0, -0.5)))
    flown(world, ahead, 0.5)
    np.testing.assert_allclose(world.pose, poses)  # they stand
    flown(world, up, 2.0)
    np.testing.assert_allclose(world.spatial.z, 1.0, atol=0.3)
    flown(world, ahead, 3.0)
    np.testing.assert_allclose(world.pose[:, 1], 1.5, atol=0.4)
    flown(world, down, 3.5)
    assert not world.spatial.z.any()
    flown(world, ahead, 0.5)
    assert np.abs(world.twist).max() < 0.01


@BOTH
def test_after_silence_it_hovers_and_then_lands(fidelity):
    world = World(("crazyflie2",), [[0.0, 0.0, 0.0]], fidelity=fidelity, z=[0.5])
    flown(world, [[0.5, 0.0, 0.0, 0.0]], 0.5)
    for _ in range(250):
        world.step()
    hovering = world.pose[0, 0]
    assert world.spatial.z[0] == pytest.approx(0.5, abs=0.05)
    assert np.abs(world.twist).max() < 0.01
    for _ in range(160):
        world.step()
    assert world.spatial.z[0] == 0.0
    assert world.pose[0, 0] == pytest.approx(hovering, abs=0.05)


@pytest.mark.parametrize(
    "fidelity", ["kinematic", pytest.param("dynamic", marks=pytest.mark.release)]
)
def test_a_circle_of_crazyflies_passes_its_verdict(fidelity, tmp_path):
    scenario = shipped("formation_crazyflies", fidelity=fidelity, duration=14.0)
    verdict = verdict_of(scenario, tmp_path)
    assert verdict["passed"], failed(verdict)


def test_gusts_push_with_forces_and_repeat_with_the_seed():
    wind = Environment(wind=(2.0, 0.0), gusts=0.5)

    def drift(seed):
        world = World(("crazyflie2",) * 2, [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]], fidelity="dynamic",
                      z=[1.0, 1.0], environment=wind, seed=seed)  # fmt: skip
        for _ in range(60):
            world.step()
        return world.pose.copy()

    first = drift(1)
    # 2 m/s of wind would carry it off at 0.103 m/s; it keeps its place with a gain of 1.5/s.
    assert ((first[:, 0] > 0.0) & (first[:, 0] < 0.1)).all()
    np.testing.assert_array_equal(first, drift(1))
    assert np.abs(first - drift(2)).max() > 1e-4


def test_without_forces_it_flies_over_robots_on_the_ground():
    world = World(("crazyflie2", "pioneer3dx"), [[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], z=[1.0, 0.0])
    axes = world.team.axes
    command = np.zeros((2, len(axes)))
    command[0, axes.index("linear.x")] = 0.5
    flown(world, command, 4.0)
    assert world.pose[0, 0] == pytest.approx(0.875, abs=1e-6)  # -1 + 0.5 (4 - 0.25)
    assert not world.contacts.take()


@BOTH
def test_two_that_meet_touch_and_stay_apart(fidelity):
    world = World(("crazyflie2",) * 2, [[0.0, 0.0, 0.0], [1.0, 0.0, np.pi]], fidelity=fidelity,
                  z=[1.0, 1.0])  # fmt: skip
    flown(world, [[0.5, 0.0, 0.0, 0.0]] * 2, 2.0)
    apart = world.pose[1] - world.pose[0]
    height = world.spatial.z[1] - world.spatial.z[0]
    assert np.hypot(*apart[:2]) > 0.11 or abs(height) > 0.02
    assert len(world.contacts.take()) >= 1
