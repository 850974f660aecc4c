"""What recorded poses cannot be: robots that jump, and bodies inside each other."""

import itertools

import numpy as np

from mrs_simulator.core.neighbours import close_pairs, lengths
from mrs_simulator.core.sample_blocks import blocks

SLACK = 0.3  # [m] by which a robot may be farther than its top speed explains: pushes, noise
MARGIN = 1.5  # [-] by which it may be faster
PRESSED = 0.02  # [m] by which bodies that touch may be pressed into each other, or wrongly measured


def jump(before, after, dt, speeds):
    """Return ``(row, distance)`` of the robot that jumped farthest, None if none did.

    ``before``, ``after``: poses (n, 3) [m, m, rad], ``dt`` [s] apart; ``speeds`` (n,) [m/s]: the
    robots' top speeds, ``inf`` where unknown.
    """
    moved = lengths(after[:, :2] - before[:, :2])
    excess = moved - SLACK - MARGIN * np.asarray(speeds) * max(dt, 0.0)
    row = int(np.argmax(excess)) if len(excess) else 0
    return (row, float(moved[row])) if len(excess) and excess[row] > 0.0 else None


def first_jump(time, pose, speeds, z=None):
    """Return ``(sample, row, distance)`` of the first jump in a run, None if there is none.

    ``time`` (m,) [s], ``pose`` (m, n, 3) and ``speeds`` as for :func:`jump`; ``z`` (m, n) [m]: heights,
    None for robots that all stand.  Where a place is nan, no robot jumps.
    """
    for some in blocks(len(time) - 1, pose.shape[1]):
        rows = slice(some.start, some.stop + 1)
        places = pose[rows, :, :2] if z is None else np.dstack([pose[rows, :, :2], z[rows]])
        moved = lengths(np.diff(places, axis=0))
        reach = SLACK + MARGIN * np.asarray(speeds) * np.diff(time[rows])[:, np.newaxis]
        found = np.argwhere(moved > reach)
        if len(found):
            sample, row = map(int, found[0])
            return some.start + sample + 1, row, float(moved[sample, row])
    return None


def first_overlap(pose, inner, z=None, tall=0.0):
    """Return ``(sample, i, j, distance)`` where two bodies first were in one place, or None.

    ``pose`` (m, n, 3); ``inner`` (n,) [m]: radii about the robots' points that their bodies fill; ``z``
    (m, n) [m]: heights from which on they are ``tall`` (n,) [m], None for robots that all stand.
    """
    inner = np.broadcast_to(np.asarray(inner, dtype=float), pose.shape[1:2])
    largest = 2.0 * float(inner.max()) - PRESSED if len(inner) > 1 else 0.0
    if largest <= 0.0:
        return None
    rows = blocks(*pose.shape[:2])
    for sample in itertools.chain.from_iterable(range(part.start, part.stop) for part in rows):
        points = pose[sample, :, :2]
        if not np.isfinite(points).all():
            continue
        first, second = close_pairs(points, largest)
        apart = lengths(points[second] - points[first])
        near = apart < inner[first] + inner[second] - PRESSED
        if z is not None:
            low, high = z[sample], z[sample] + tall
            shared = np.minimum(high[first], high[second]) - np.maximum(low[first], low[second])
            near &= shared > PRESSED
        wrong = np.flatnonzero(near)
        if len(wrong):
            pair = wrong[np.argmin(apart[wrong])]
            return sample, int(first[pair]), int(second[pair]), float(apart[pair])
    return None
