"""Parts of a world: the documentation's example, its order in a step, and its snapshot."""

import os
import re

import numpy as np
import pytest

from mrs_simulator.world.part import Part
from mrs_simulator.world.world import EVERY, World

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def documented():
    """Return the part that docs/development.md has as its example."""
    with open(os.path.join(ROOT, "docs", "development.md"), encoding="utf-8") as file:
        section = file.read().split("## How to add a part of the world")[1]
    names = {}
    exec(re.search(r"```python\n(.*?)```", section, re.S).group(1), names)
    return names["Mud"]


class Muddy(World):
    def _make_parts(self, takeoff):
        super()._make_parts(takeoff)
        self.mud = documented()(self.motion, self.faults, 1.0)
        self.parts.append(self.mud)
        self._list_hooks()


def test_the_documented_part_acts_and_is_taken_back():
    world = Muddy(("pioneer3dx",), [[-1.205, 0.0, 0.0]], limits=None, cmd_vel_timeout=9.0)
    world.set_commands(EVERY, np.array([[0.5, 0.0]]))
    for _ in range(20):  # 0.2 m, to 5 mm before the mud
        world.step()
    kept = world.snapshot()
    for _ in range(2):
        for _ in range(50):
            world.step()
        (incident,) = world.faults.take()
        assert incident[2] == "in_mud"
        # One step of 10 mm into it, and 49 of 5 mm.
        assert world.pose[0, 0] == pytest.approx(-1.005 + 0.010 + 49 * 0.005)
        world.restore(kept)
    world.reset()
    world.step()
    assert world.pose[0, 0] == -1.205


def test_parts_add_columns_to_the_state():
    class Estimating(Part):
        def columns(self):
            return {"estimate": np.ones((1, 3))}

    world = World(("pioneer3dx",), [[0.0, 0.0, 0.0]])
    assert not hasattr(world.state(), "estimate") and not world.state().commanded.any()
    world.parts.append(Estimating())
    assert world.state().estimate.tolist() == [[1.0, 1.0, 1.0]]
