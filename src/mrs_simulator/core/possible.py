"""What recorded poses cannot be: robots that jump, and bodies inside each other."""

import numpy as np

from mrs_simulator.core.neighbours import close_pairs

SLACK = 0.3  # [m] by which a robot may be farther than its top speed explains: pushes, noise
MARGIN = 1.5  # [-] by which it may be faster
PRESSED = 0.02  # [m] by which bodies that touch may be pressed into each other, or wrongly measured


def jump(before, after, dt, speeds):
    """Return ``(row, distance)`` of the robot that jumped farthest, None if none did.

    ``before``, ``after``: poses (n, 3) [m, m, rad], ``dt`` [s] apart; ``speeds`` (n,) [m/s]: the
    robots' top speeds, ``inf`` where unknown.
    """
    moved = _lengths(after[:, :2] - before[:, :2])
    excess = moved - SLACK - MARGIN * np.asarray(speeds) * max(dt, 0.0)
    row = int(np.argmax(excess)) if len(excess) else 0
    return (row, float(moved[row])) if len(excess) and excess[row] > 0.0 else None


def first_jump(time, pose, speeds):
    """Return ``(sample, row, distance)`` of the first jump in a run, None if there is none.

    ``time`` (m,) [s], ``pose`` (m, n, 3) and ``speeds`` as for :func:`jump`.
    """
    if len(time) < 2:
        return None
    moved = _lengths(np.diff(pose[:, :, :2], axis=0))
    reach = SLACK + MARGIN * np.asarray(speeds) * np.diff(time)[:, np.newaxis]
    found = np.argwhere(moved > reach)
    if not len(found):
        return None
    sample, row = map(int, found[0])
    return sample + 1, row, float(moved[sample, row])


def first_overlap(pose, inner):
    """Return ``(sample, i, j, distance)`` where two bodies first were in one place, or None.

    ``pose`` (m, n, 3); ``inner`` (n,) [m]: radii about the robots' points that their bodies fill.
    """
    inner = np.broadcast_to(np.asarray(inner, dtype=float), pose.shape[1:2])
    largest = 2.0 * float(inner.max()) - PRESSED if len(inner) > 1 else 0.0
    if largest <= 0.0:
        return None
    for sample, points in enumerate(pose[:, :, :2]):
        if not np.isfinite(points).all():
            continue
        first, second = close_pairs(points, largest)
        apart = _lengths(points[second] - points[first])
        wrong = np.flatnonzero(apart < inner[first] + inner[second] - PRESSED)
        if len(wrong):
            pair = wrong[np.argmin(apart[wrong])]
            return sample, int(first[pair]), int(second[pair]), float(apart[pair])
    return None


def _lengths(vectors):
    return np.sqrt((vectors * vectors).sum(axis=-1))
