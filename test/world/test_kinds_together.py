"""Each shipped kind moves in pairs and triples of kinds as it does alone."""

import functools
import itertools

import numpy as np
import pytest

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.control.twists import twists_of
from mrs_simulator.core.kinematics import TWIST_AXES
from mrs_simulator.vehicles import Team, shipped_kinds
from mrs_simulator.vehicles.arms.team import ArmedTeam, has_arms
from mrs_simulator.vehicles.registry import shipped_kind
from mrs_simulator.vehicles.team import on_all_axes
from mrs_simulator.world.world import EVERY, World

# One of each drive, one more of one of these, and one with an arm.
FEW = "pioneer3dx", "amigobot", "crazyflie2", "f1tenth", "heron", "husky_panda", "robotino3"
PAIRS = list(itertools.combinations(shipped_kinds(), 2))
TRIPLES = {
    False: list(itertools.combinations(FEW, 3)),
    True: list(itertools.combinations(shipped_kinds(), 3)),
}
APART = 40.0  # [m]
ASKED = {"linear.x": 0.2, "linear.y": 3.0, "linear.z": 0.1, "angular.z": 0.3}  # beyond sideways


class ByArrays(PioneerControl):
    def pointMassLaw(self, hand):
        return np.full((len(hand), 2), 0.2)


class ByHook(PioneerControl):
    def calculateControlLaw(self, pos_map):
        asked = [ASKED.get(axis, 0.0) for axis in self.team.axes]
        command = np.where(self.team.robot_axes, asked, 0.0)
        return dict(zip(pos_map, twists_of(command, self.team.axes)))


def moved(kinds):
    """Return the commands (n, 6) of both laws, and how far (n, 4) the robots of ``kinds`` went by each."""
    team = (ArmedTeam if has_arms(list(map(shipped_kind, kinds))) else Team)(kinds)
    pose = np.zeros((team.n, 3))
    pose[:, 1], pose[:, 2] = APART * np.arange(team.n), 0.3
    z = np.where(team.airborne, 1.0, 0.0) if team.airborne.any() else None
    world, found = World(team, pose, z=z), []
    for law in (ByArrays, ByHook):
        before = places(world)
        command = law(range(1, team.n + 1), team=team).commands(world.pose, 0.0, world.joints)
        world.set_commands(EVERY, command)
        world.step()
        axes = [axis for axis in team.axes if axis in TWIST_AXES]
        found += [on_all_axes(command[:, : len(axes)], axes), places(world) - before]
    return np.concatenate(found, axis=1)


def places(world):
    return np.column_stack([world.pose, np.zeros(len(world.pose)) if world.z is None else world.z])


@functools.lru_cache(maxsize=None)
def alone(kind):
    return moved((kind,))


@pytest.mark.parametrize("every", [False, pytest.param(True, marks=pytest.mark.release)])
@pytest.mark.parametrize("first", shipped_kinds())
def test_a_kind_moves_in_pairs_and_triples_as_it_does_alone(first, every):
    assert alone(first)[0, [6, 16]].all()  # along x, by the one law and by the other
    for kinds in PAIRS + TRIPLES[every]:
        if kinds[0] == first:
            wanted = np.concatenate([alone(kind) for kind in kinds])
            np.testing.assert_allclose(moved(kinds), wanted, rtol=0.0, atol=1e-12, err_msg=kinds)


def test_nothing_is_written_into_a_part_that_may_be_a_copy():
    for kinds in (("robotino3", "crazyflie2"), ("robotino3", "pioneer3dx")):
        group = Team(kinds).groups[0]
        with pytest.raises(ValueError, match="read-only"):
            group.part(np.zeros((2, 4)))[:] = 1.0
