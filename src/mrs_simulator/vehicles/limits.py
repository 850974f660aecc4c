"""Limits of robots: their kinds', or a scenario's."""

import math
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import Limits
from mrs_simulator.scenario.team.limits import LoweredLimits
from mrs_simulator.vehicles.kind import AxisLimit

ACROSS = "linear."  # how the names of the axes of translation begin


class AxisLimits(NamedTuple):
    """Limits of each command axis in SI units: (a,) if all robots have the same, else (n, a)."""

    top: np.ndarray
    acceleration: np.ndarray

    def of(self, rows):
        """Return the limits of the robots in ``rows``."""
        if self.top.ndim == 1:
            return self
        return AxisLimits(self.top[rows], self.acceleration[rows])

    def of_all(self, n):
        """Return the same limits as arrays (n, a), column by column in memory."""
        shape = n, self.top.shape[-1]
        return AxisLimits(*(np.array(np.broadcast_to(each, shape), order="F") for each in self))


def kind_limits(kind, limits):
    """Return one ``AxisLimit`` for each axis of a ``kind`` of robot under ``limits``.

    ``limits``: "firmware" (factory settings), "top" (the highest that the firmware accepts), a
    ``LoweredLimits`` of one of them, None for no limits, or ``Limits`` of one's own: its ``v_max``
    holds for every axis of translation, its ``omega_max`` for the turn rate.
    """
    if limits is None:
        return (AxisLimit(math.inf, math.inf),) * len(kind.axes)
    if isinstance(limits, Limits):
        return tuple(AxisLimit(*_of_axis(limits, axis)) for axis in kind.axes)
    if isinstance(limits, LoweredLimits):
        return tuple(
            limit._replace(top=min(limit.top, *_of_axis(limits[1:], axis)))
            for axis, limit in zip(kind.axes, kind_limits(kind, limits.preset))
        )
    return kind.limits[limits]


def _of_axis(limits, axis):
    across = axis.startswith(ACROSS)
    return limits[0::2] if across else limits[1::2]


def stacked(rows):
    """Return the ``AxisLimits`` of robots, from one tuple of ``AxisLimit`` for each; (a,) if equal."""
    if all(row is rows[0] or row == rows[0] for row in rows):
        return AxisLimits(*np.array(rows[0], dtype=float).T.copy())
    table = np.array(rows, dtype=float)
    return AxisLimits(np.asfortranarray(table[:, :, 0]), np.asfortranarray(table[:, :, 1]))
