"""Worlds that are taken back to a moment go on from there to the same bits."""

import numpy as np
import pytest

from mrs_simulator.core.snapshots import NotCopied, Snapshot
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.world.world import World


def flying():
    """Return a world in which robots take off, and lose their motors in the air."""
    content = {
        "model": "crazyflie2",
        "poses": [[0, 0, 0], [2, 0, 0], [4, 0, 0]],
        "altitude": 0.3,
        "takeoff": True,
        "events": [{"at": 0.2, "robot": 2, "event": "motors_off"}],
    }
    return World.from_scenario(scenario_from_dict(content, "test"))


def driving():
    """Return a world of noisy odometry and inexact commands, in which two robots meet."""
    content = {
        "poses": [[0, 0, 0], [1, 0, 3.1], [0, 5, 0]],
        "odometry": "wheel",
        "odometry_rate": 10.0,
        "mismatch": {"speed": 0.9, "delay": 0.1},
        "seed": 3,
    }
    return World.from_scenario(scenario_from_dict(content, "test"))


def told(world, steps, command=0.3):
    """Return what the ``world`` tells of its next ``steps``, robot 3 without a command."""
    rows, found = [], []
    for _ in range(steps):
        commands = np.full((2, world.command.shape[1]), command)
        world.set_commands([0, 1], commands)
        world.step()
        rows.append([world.pose, world.twist, world.estimates.pose(), world.estimates.odometry()])
        found += world.contacts.take() + world.faults.take()
    state = world.commands.timed_out.tolist(), world.flights.states(), world.time
    return np.array(rows).tobytes(), found, state, world.contacts.measure()


@pytest.mark.parametrize("make", [flying, driving])
@pytest.mark.parametrize("before", [5, 40])
def test_a_world_goes_on_alike(make, before):
    world = make()
    told(world, before)
    kept = world.snapshot()
    first = told(world, 100)
    assert first[1]  # a fault, or a collision
    for _ in range(2):
        world.restore(kept)
        assert told(world, 100) == first


def test_another_future_leaves_the_snapshot_as_it_was():
    world = driving()
    told(world, 10)
    kept = world.snapshot()
    first = told(world, 50)
    world.restore(kept)
    assert told(world, 50, -0.3) != first
    world.reset()
    told(world, 10)
    world.restore(kept)
    assert told(world, 50) == first


def test_efforts_stay_those_of_the_motion():
    world = World(("heron",), [[0.0, 0.0, 0.0]], fidelity="dynamic")
    world.commands.set_efforts([0], [[10.0, 10.0, np.nan, np.nan]])
    world.step()
    kept = world.snapshot()
    for _ in range(2):
        world.restore(kept)
        assert world.commands.efforts is world.motion.efforts
        world.commands.set_efforts([0], [[0.0, 0.0, np.nan, np.nan]])
        assert not world.motion.efforts[0, :2].any()


class Holder:
    def __init__(self, **held):
        vars(self).update(held)


def test_what_is_shared_stays_shared():
    numbers, inner = [1], Holder(numbers=None)
    inner.numbers = numbers
    first, second = Holder(numbers=numbers, inner=inner), Holder(numbers=numbers, inner=inner)
    inner.outer = first
    kept = Snapshot([first, second])
    numbers.append(2)
    first.added = True
    kept.restore()
    assert first.numbers == [1] and not hasattr(first, "added")
    assert first.numbers is second.numbers is first.inner.numbers
    assert first.inner is second.inner and first.inner.outer is first


def counter():
    count = 0

    def add():
        nonlocal count
        count += 1
        return count

    return add


def test_functions_are_shared_unless_they_may_have_a_state():
    Snapshot([Holder(f=lambda: 1, g=np.sin, h=len, c=Holder, m=np)]).restore()
    with pytest.raises(NotCopied, match="counter.*refers to variables around it"):
        Snapshot([Holder(f=counter())])
    with pytest.raises(NotCopied, match="generator"):
        Snapshot([Holder(g=(k for k in range(3)))])
