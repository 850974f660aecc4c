"""Wheels and water: where a scenario has land, what is beside it is water, and wheels do not swim."""

import numpy as np

from mrs_simulator.scenario.incidents import IN_WATER
from mrs_simulator.scenario.surroundings.obstacles import clearance, is_flat
from mrs_simulator.world.checks import WorldError
from mrs_simulator.world.part import Part

FAR_AWAY = 1e9  # [m] from any land


def off_land(team, points, obstacles):
    """Return which robots, (n,) bool, on wheels have their ``points`` (n, 2) [m] in water: on no land.

    None where ``obstacles`` have no land.
    """
    land = [each for each in obstacles if is_flat(each)]
    on_wheels = np.array([kind.module.MEDIUM == "ground" for kind in team.kinds])
    if not land or not on_wheels.any():
        return np.zeros(team.n, dtype=bool)
    gaps = np.stack([clearance(each, points)[0] for each in land])
    return on_wheels & (gaps > 0.0).all(axis=0)


def refuse_wheels_in_water(team, poses, obstacles, mirrored=()):
    """Raise ``WorldError`` that names the first robot on wheels whose pose (n, 3) is in water."""
    wet = off_land(team, poses[:, :2], obstacles)
    wet[list(mirrored)] = False
    if wet.any():
        row = int(np.flatnonzero(wet)[0])
        text = "robot{} at {} is in the water, a {} on wheels; wanted it on land"
        raise WorldError(text.format(row + 1, poses[row, :2].tolist(), team.kinds[row].title))


def has_shore(team, obstacles):
    """Return whether a ``team`` among ``obstacles`` has robots on wheels that can drive off the land."""
    return bool(off_land(team, np.full((team.n, 2), FAR_AWAY), obstacles).any())


class Shore(Part):
    """Robots on wheels that drive off the land: they stop, obey nothing more, and are reported."""

    def __init__(self, team, motion, faults, settings):
        """``settings``: the ``WorldSettings``, with its obstacles."""
        self._team, self._motion, self._faults = team, motion, faults
        self._land = [each for each in settings.obstacles if is_flat(each)]
        self._mirrored = settings.mirrored
        self._wet = np.zeros(team.n, dtype=bool)

    def before_step(self, command):
        """Return what robots obey instead of ``command`` (n, a)."""
        return np.where(self._wet[:, np.newaxis], 0.0, command) if self._wet.any() else command

    def after_step(self):
        """Report the robots that have come into the water in this step."""
        wet = off_land(self._team, self._motion.pose[:, :2], self._land)
        wet[self._mirrored] = False
        for row in np.flatnonzero(wet & ~self._wet).tolist():
            self._faults.report(row, IN_WATER)
        self._wet |= wet
