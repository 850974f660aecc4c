"""How far estimates of poses were from the truth in a run: numbers and curves."""

import numpy as np

from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.protocols.curves import Curve

UNKNOWN = "poses are those that the control estimated: where the robots truly were is not known"
OLDEST = 0.5  # [s] of the run's time, after which estimates no longer hold
SAME = 1e-6  # [s] by which stamps of one time may differ


def held_at(stamps, times):
    """Return which of the ascending ``stamps`` (k,) [s] holds at each of ``times`` (m,) [s], -1 for none.

    That is the newest that is not after the time, unless it is more than ``OLDEST`` before it.
    """
    stamps, times = np.asarray(stamps, dtype=float), np.asarray(times, dtype=float)
    newest = np.searchsorted(stamps, times + SAME) - 1
    if not len(stamps):
        return newest
    return np.where(times - stamps[newest] <= OLDEST, newest, -1)


def _is_known(run):
    """Return whether there are estimates, and the truth beside them."""
    return run.estimate is not None and not run.meta.get("truth_unknown")


def estimation_errors(run):
    """Return the errors (m, n) [m] of positions and (m, n) [rad] of headings that the control knew."""
    off = run.estimate - run.pose
    return np.hypot(off[..., 0], off[..., 1]), np.abs(wrap_angle(off[..., 2]))


def estimation_measures(run):
    """Return root mean square and largest errors of a run's estimates by name; {} where not known."""
    if not _is_known(run):
        return {}
    place, heading = estimation_errors(run)
    return {
        "estimation_error": float(np.sqrt((place**2).mean())),  # [m]
        "largest_estimation_error": float(place.max()),  # [m]
        "heading_error": float(np.sqrt((heading**2).mean())),  # [rad]
        "largest_heading_error": float(heading.max()),  # [rad]
    }


def estimation_curves(run):
    """Return the root mean square errors over the team against time, [] where they are not known."""
    if not _is_known(run):
        return []
    place, heading = (np.sqrt((each**2).mean(axis=1)) for each in estimation_errors(run))
    return [
        Curve("position off its estimate [m]", run.time, place),
        Curve("heading off its estimate [rad]", run.time, heading),
    ]
