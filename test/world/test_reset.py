"""A world that was reset is a new world to the bit, whatever robots did before."""

import numpy as np
import pytest

from mrs_simulator.vehicles import kind
from mrs_simulator.world.world import EVERY, World

WHEELED = ("pioneer3dx", "husky", "robotino3", "f1tenth", "youbot", "turtlebot3_burger")
OTHERS = ("heron", "wamv", "crazyflie2", "ardrone2", "pioneer3dx", "f1tenth")
ARMED = ("husky_panda", "pioneer3dx")
TEAMS = [
    (WHEELED, "kinematic", "pybullet"),
    (WHEELED, "dynamic", "pybullet"),
    (WHEELED, "dynamic", "planar"),
    (OTHERS, "kinematic", "pybullet"),
    (OTHERS, "dynamic", "pybullet"),
    (ARMED, "dynamic", "pybullet"),
]


def world_of(kinds, fidelity, engine, rng):
    """Return a world in which robots stand so near that they meet, at any heading."""
    reach = np.array([kind(name).body.reach for name in kinds])
    x = np.cumsum(2.0 * reach + 0.05) - reach
    poses = np.column_stack([x, np.zeros(len(x)), rng.uniform(-np.pi, np.pi, len(x))])
    z = [float(kind(name).module.MEDIUM == "air") for name in kinds]
    more = {"odometry_kind": "wheel", "seed": 3, "z": z if any(z) else None}
    return World(kinds, poses, fidelity=fidelity, engine=engine, **more)


def driven_hard(world, seed, steps=25):
    """Return all that a world shows under commands beyond limits that jump every seventh step."""
    rng, shown = np.random.default_rng(seed), []
    for step in range(steps):
        if step % 7 == 0:
            world.set_commands(EVERY, rng.uniform(-3.0, 3.0, (world.n, len(world.team.axes))))
        world.step()
        spatial = () if world.z is None else (world.z, world.spatial.orientation)
        state = world.pose, world.twist, world.joints, world.estimates.odometry(), *spatial
        shown.append(np.concatenate([np.ravel(each) for each in state]))
    return np.array(shown), [each[1:3] for each in world.contacts.take()]


@pytest.mark.parametrize("kinds, fidelity, engine", TEAMS)
def test_after_a_reset_the_bytes_are_those_of_a_new_world(kinds, fidelity, engine):
    used, new = (world_of(kinds, fidelity, engine, np.random.default_rng(5)) for _ in range(2))
    try:
        driven_hard(used, seed=1)
        used.reset()
        found, touched = driven_hard(used, seed=2)
        wanted, wanted_touched = driven_hard(new, seed=2)
        assert np.isfinite(wanted).all() and found.tobytes() == wanted.tobytes()
        assert touched == wanted_touched
    finally:
        used.close()
        new.close()


def test_refused_commands_are_counted_over_resets():
    world = World(("pioneer3dx",), [[0.0, 0.0, 0.0]])
    world.set_commands(EVERY, np.array([[np.nan, 0.0]]))
    world.reset()
    assert world.commands.refused.tolist() == [1]
