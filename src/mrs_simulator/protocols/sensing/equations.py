"""Laws of robots that know what their own sensors measure: functions of arrays in a robot's own frame."""

import functools
import itertools

import numpy as np

INSIDE = 1e-9  # [-] by which a point may be outside a circle that goes through it


def limited_visibility(others, radius, gain, period):
    """Return the velocity (2,) [m/s] of a robot that sees ``others`` (k, 2) [m] within ``radius`` V [m].

    Towards the centre c of the smallest circle about all of them and itself, by ``gain period |c|`` in a
    period, as far as it stays within V/2 of the middle of the way to each: two robots that both do so
    are no farther than V apart afterwards (Ando, Oasa, Suzuki, Yamashita, 1999).
    """
    centre = smallest_circle(np.concatenate([np.zeros((1, 2)), others]))
    far = np.hypot(*centre)
    if far == 0.0:
        return np.zeros(2)
    along = centre / far
    half = 0.5 * np.asarray(others, dtype=float)
    ahead = half @ along
    aside = np.einsum("ij,ij->i", half, half) - ahead * ahead
    most = ahead + np.sqrt(np.maximum(0.25 * radius * radius - aside, 0.0))
    way = min(gain * period * far, float(np.min(most, initial=np.inf)))
    return max(way, 0.0) / period * along


def smallest_circle(points):
    """Return the centre (2,) [m] of the smallest circle about ``points`` (k, 2): through two or three."""
    points = np.array(sorted(set(map(tuple, np.asarray(points, dtype=float).tolist()))))
    if len(points) == 1:
        return points[0]
    x, y = points.T
    pairs, triples = _choices(len(points))
    (ax, bx), (ay, by) = x[pairs], y[pairs]
    across, up = _through(x[triples], y[triples])
    across = np.concatenate([0.5 * (ax + bx), across])
    up = np.concatenate([0.5 * (ay + by), up])
    # The smallest circle about a centre that holds all is the one to the farthest point.
    off, high = across - x[:, np.newaxis], up - y[:, np.newaxis]
    far = np.sqrt((off * off + high * high).max(axis=0))
    best = np.argmin(np.where(np.isnan(far), np.inf, far))
    return np.array([across[best], up[best]])


@functools.lru_cache(maxsize=16)
def _choices(count):
    """Return the rows of all pairs, (2, j), and triples, (3, k), of ``count`` points."""
    chosen = (list(itertools.combinations(range(count), size)) for size in (2, 3))
    return [np.array(rows, dtype=int).reshape(-1, size).T for size, rows in zip((2, 3), chosen)]


def _through(x, y):
    """Return the centres, x (k,) and y (k,), of circles through three points, (3, k); nan of a line."""
    (bx, cx), (by, cy) = x[1:] - x[0], y[1:] - y[0]
    cross = 2.0 * (bx * cy - by * cx)
    b, c = bx * bx + by * by, cx * cx + cy * cy
    cross = np.where(np.abs(cross) > INSIDE * (b + c), cross, np.nan)
    return x[0] + (cy * b - by * c) / cross, y[0] + (bx * c - cx * b) / cross


def wall_beside(front, rear):
    """Return ``(distance [m], angle [rad])`` of a straight wall to the left from two transducers.

    ``front`` and ``rear``: x, y [m] and range [m] of each, which is the distance across to the wall, as
    long as the wall's normal is within their cones.  The distance is that of the robot's centre; the
    angle is that of the heading against the wall, positive towards it:

        r_rear - r_front = (x_front - x_rear) sin(angle),   D = r + x sin(angle) + y cos(angle).
    """
    (x, y, r), (x_rear, _, r_rear) = front, rear
    sin = float(min(max((r_rear - r) / (x - x_rear), -1.0), 1.0))
    cos = np.sqrt(1.0 - sin * sin)
    return r + x * sin + y * cos, float(np.arcsin(sin))


def along_wall(speed, approach, angle):
    """Return the velocity (2,) [m/s], ``speed`` along a wall to the left and ``approach`` towards it."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([speed * cos + approach * sin, approach * cos - speed * sin])


def towards(other, distance, gain):
    """Return the velocity (2,) [m/s] ``gain (|z| - distance) z/|z|`` towards ``other``, z (2,) [m]."""
    far = max(float(np.hypot(*other)), 1e-9)
    return gain * (far - distance) / far * np.asarray(other)


def steady_ranges(speed, turn, leads, distance, gain):
    """Return the ranges (n - 1,) [m] at which robots end that follow each other by :func:`towards`.

    The first drives at ``speed`` [m/s] and ``turn`` [rad/s]; ``leads`` (n,) [m]: how far ahead of its
    centre, which is followed, each robot's controlled point is.  On a straight way all go at ``speed``:
    ``distance + speed/gain``.  On circles about one centre a point at radius R goes at ``turn R`` along
    the tangent, towards the centre before it, whose radius is r: there
    ``r^2 = R^2 + (distance + turn R/gain)^2``.  None where that has no solution: the circle is too small.
    """
    if turn == 0.0:
        return np.full(len(leads) - 1, distance + speed / gain)
    share, ranges = abs(turn) / gain, []
    square = (speed / turn) ** 2  # of the radius on which the robot before has its centre
    for lead in leads[1:]:
        inner = (share * distance) ** 2 - (1.0 + share**2) * (distance**2 - square)
        if inner < 0.0:
            return None
        radius = (np.sqrt(inner) - share * distance) / (1.0 + share**2)
        if radius <= lead:
            return None
        ranges.append(distance + share * radius)
        square = radius**2 - lead**2  # a point ahead of its centre goes round on a larger circle
    return np.array(ranges)
