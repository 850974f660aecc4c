"""Where the published law takes robots from each sample of a run, predicted for all samples at once.

A run of thousands of commands is followed one command after the other.  Where each recorded sample is
where the law takes the robots from the sample before, the record itself is that motion: all stretches
between samples are then one problem of arrays.
"""

from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.sample_blocks import blocks

SURE = 1e-7  # [m] that samples may be off in all, added up over the run: a tenth of the least tolerance
WHOLE = 1e-6  # [-] of a command period by which a sample may be beside a command


class Predicted(NamedTuple):
    """What the law makes of robots at the samples of a run; arrays (m, n, ...)."""

    pose: Any
    hand: Any
    command: Any
    limited: Any  # (m, n) bool, who is at a limit
    cut: Any  # (m, n) [m] of each point's path that limits have cut off until then


def one_step_predictions(law, robots, run, period):
    """Return how ``robots`` move under ``law`` as :class:`Predicted`, or None where samples do not show it.

    Each sample is followed to the next.  That is the motion from the start, but for ``SURE``, where the
    samples are met and no difference grows: the law keeps points close, and no command moves a point by
    more than ``l``, which could turn its robot too far.  Made of laws that see no more than the points
    and the time, and of robots without ramps whose commands fall on the samples.
    """
    counts = commands_between(run.time - run.time[0], period)
    if counts is None or len(np.unique(counts)) != 1 or counts[0] < 1:
        return None
    if law.SEES != "now" or not law.keeps_close(period) or not robots.stacks:
        return None
    if robots.deadband:  # at whose edge differences grow
        return None
    off, parts = 0.0, []
    for rows in blocks(len(run.time), len(run.robots)):
        parts.append(_predicted(law, robots, run, rows, period, counts[0]))
        off += _missed(run, rows.start + 1, *parts[-1][:2])
        if not (off <= SURE and parts[-1][-1]):  # nor is nan
            return None
    pose, hand, lost, command, limited = map(np.concatenate, zip(*(part[:-1] for part in parts)))
    for found, start in ((pose, run.pose[0]), (hand, run.hand[0]), (lost, 0.0)):
        found[1:], found[0] = found[:-1], start  # a sample is where the one before leads
    return Predicted(pose, hand, command, limited, np.cumsum(lost, axis=0))


def commands_between(time, period):
    """Return how many commands lie between samples, (m - 1,) int; None where samples are beside commands.

    ``time`` (m,) [s] of the samples, from a command on; ``period`` [s] of the commands.
    """
    count = time / period
    whole = np.round(count)
    if (np.abs(count - whole) > WHOLE * np.maximum(count, 1.0)).any():
        return None
    return np.diff(whole.astype(int))


def _predicted(law, robots, run, rows, period, count):
    """Return where the samples ``rows`` lead in ``count`` commands, and how they begin.

    Poses and points after these, and what limits have cut off by then; the first commands, and who is at a
    limit under them; last whether no command could turn a robot too far.
    """
    calm, farthest = True, np.inf if robots.frozen else robots.l
    time, begun = run.time[rows] - run.time[0], law.begin(run.hand[0])
    robots.be(run.pose[rows], run.hand[rows])
    lost, current = 0.0, np.column_stack([robots.drift.real, robots.drift.imag])
    for step in range(count):
        points = robots.points
        u = law.velocities(points, time + step * period, begun)
        wanted = robots.commands(u)
        full = robots.limited_now
        calm = calm and bool((robots.sizes(wanted) * period <= farthest).all())
        if step == 0:
            command, limited = wanted, full
        robots.move(wanted, period)
        off = u + current - (robots.points - points) / period
        lost = lost + np.where(full, np.hypot(off[..., 0], off[..., 1]) * period, 0.0)
    return robots.pose, robots.points, lost, command, limited, calm


def _missed(run, row, pose, hand):
    """Return by how much [m] the samples from ``row`` on are off these poses and points, added up."""
    count = min(len(pose), len(run.time) - row)
    rows = slice(row, row + count)
    off = np.maximum(_apart(pose[:count], run.pose[rows]), _apart(hand[:count], run.hand[rows]))
    return off.max(axis=1).sum()


def _apart(points, others):
    return np.hypot(points[..., 0] - others[..., 0], points[..., 1] - others[..., 1])
