"""Commands against the published law where poses and commands were not recorded in lockstep.

Over ROS a recorded command was made of poses of some time before: those that had arrived, when the law
was asked, as old as the odometry then was.  How long before is measured, and what the law wants about
that time bounds each command.
"""

from typing import NamedTuple

import numpy as np

LONGEST = 0.5  # [s] by which commands may be behind poses
STEP = 0.01  # [s] in which that is looked for
PARTS = 9  # [-] of the time about it, in which the law is looked at
LEAST_SPEED = 1e-3  # [m/s] to which differences of commands are related at least
FEWEST = 10  # [-] samples


class Late(NamedTuple):
    """How far recorded commands are from the published law's."""

    error: float  # [-] mean over all samples, of the mean velocity that the law wants
    delay: float  # [s] by which commands are behind poses


def late_commands(time, wanted, recorded, sizes, hold):
    """Return the ``Late`` of commands ``recorded`` (m, n, a) at ``time`` (m,) [s], None of too few.

    ``wanted`` (m, n, a): what the law wants of the poses at ``time``.  ``sizes(row, command)`` returns how
    fast a command (n, a), or a difference of two, moves the robots' points (n,) [m/s]; ``hold`` [s]: for
    how long one pose and one command stand.  The delay is that of the least mean difference; each
    command is then held to what the law wants within ``hold`` about it.  Samples in which all
    robots are commanded to stand are left out: a controller says so that is stopped.
    """
    driven = recorded.any(axis=(1, 2))
    scale = np.maximum(np.abs(wanted).max(axis=(0, 1)), 1e-12)
    delays = np.arange(0.0, LONGEST + STEP / 2.0, STEP)

    def misfit(delay):
        kept = driven & (time - delay >= time[0])
        if np.count_nonzero(kept) < FEWEST:
            return np.inf
        return float(np.abs((recorded - _at(time, wanted, time - delay)) / scale)[kept].mean())

    misfits = [misfit(delay) for delay in delays]
    delay = float(delays[int(np.argmin(misfits))])
    kept = np.flatnonzero(driven & (time - delay - hold >= time[0]))
    if len(kept) < FEWEST:
        return None
    about = [_at(time, wanted, time[kept] - delay + s) for s in np.linspace(-hold, hold, PARTS)]
    off = recorded[kept] - np.clip(recorded[kept], np.min(about, axis=0), np.max(about, axis=0))
    # The mean, since single messages come later than others.
    error = np.mean([sizes(row, each) for row, each in zip(kept, off)])
    size = np.mean([sizes(row, wanted[row]) for row in kept])
    return Late(float(error / max(size, LEAST_SPEED)), delay)


def _at(time, values, when):
    """Return ``values`` (m, n, a) of ``time`` (m,), by straight lines between, at ``when`` (k,)."""
    when = np.clip(when, time[0], time[-1])
    after = np.clip(np.searchsorted(time, when), 1, len(time) - 1)
    share = (when - time[after - 1]) / (time[after] - time[after - 1])
    share = share[:, np.newaxis, np.newaxis]
    return (1.0 - share) * values[after - 1] + share * values[after]
