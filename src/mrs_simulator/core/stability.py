"""Thresholds of theorems: how far a run is from one, and whether what it speaks of grew or decayed."""

import math
from typing import Callable, NamedTuple

import numpy as np

from mrs_simulator.core.claims import NEGLIGIBLE, RATE_FLOOR, disagreement

WINDOWS = 8  # [-] over which the envelope of an oscillation is taken
LATE = 0.6  # [-] share of the run, at its end, in which the slowest mode is looked for


class Stability(NamedTuple):
    """A threshold: the quantity ``of`` decays if ``margin`` is above 0, and grows if it is below.

    ``name``: the boundary as a formula for a figure's legend; ``margin`` [-]: the share of the bound
    that is left, ``1 - value/bound``, by the theorem alone; ``of``: a quantity as in ``core.claims``.
    """

    name: str
    margin: float
    of: Callable = disagreement


def share_left(value, bound):
    """Return the margin [-] of ``0 < value < bound``: ``1 - value/bound``; ``value`` itself up to 0."""
    if not value > 0.0:
        return float(value)
    return 1.0 - value / bound


def growth_rate(time, values):
    """Return the rate [1/s] at which ``values`` (m,) grow late in the run at ``time`` (m,) [s].

    The slope of a straight line through the logarithm of the largest value in each of ``WINDOWS``
    windows over the last part of the run, so that oscillations count by their envelope; below zero
    they decay.  What lies below rounding is left out.  None where nothing moves from the start, or
    where less than three windows are left.
    """
    values = np.asarray(values, dtype=float)
    if len(values) < 3 * WINDOWS or not values[0] > NEGLIGIBLE or not np.isfinite(values).all():
        return None
    sunk = np.flatnonzero(values <= RATE_FLOOR * values[0])
    end = sunk[0] if len(sunk) else len(values)
    begin = int(round((1.0 - LATE) * end))
    parts = [part for part in np.array_split(np.arange(begin, end), WINDOWS) if len(part)]
    if len(parts) < 3:
        return None
    peaks = np.array([part[np.argmax(values[part])] for part in parts])
    slope = float(np.polyfit(time[peaks], np.log(values[peaks]), 1)[0])
    return slope if math.isfinite(slope) else None


def stability_measures(control, run):
    """Return ``stability_margin`` and ``growth_rate`` [1/s] of ``run``, by name; {} without a threshold."""
    known = control.stability(run.hand[0])
    if known is None:
        return {}
    margin = known.margin if math.isfinite(known.margin) else None
    return {"stability_margin": margin, "growth_rate": growth_rate(run.time, known.of(run.hand))}
