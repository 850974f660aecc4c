"""What stretches are made of: loops along arrays, one robot per column, that numba compiles.

They are short, of few arrays each: such loops use the processor's vectors without reordered arithmetic.
What is rare, such as an angle to be wrapped, has a loop of its own.
"""

import math

import numpy as np

from mrs_simulator.core.kinematics import FASTEST
from mrs_simulator.scenario.team.robots import FARTHEST

PI, TURN = np.pi, 2.0 * np.pi
SMALL = 0.1  # [rad], for which five terms of a series are exact
UNLISTED = -1.0  # of room: pairs are to be listed anew


def ramp(target, most, both, inner, after, mean):
    """Let ``inner`` (n,) approach ``target``, which becomes the change, by ``most`` each.

    Fills ``after`` and the ``mean`` over the step; ``both``: twice ``most``.
    """
    n = len(target)
    for row in range(n):
        target[row] = min(max(target[row] - inner[row], -most[row]), most[row])
    for row in range(n):
        after[row] = inner[row] + target[row]
    for row in range(n):
        mean[row] = after[row] - abs(target[row]) * target[row] / both[row]


def clip(values, least, greatest, clipped):
    """Fill ``clipped`` (n,) with ``values`` between ``least`` and ``greatest``."""
    for row in range(len(values)):
        clipped[row] = min(max(values[row], least[row]), greatest[row])


def copy(values, to):
    """Fill ``to`` (n,) with ``values``."""
    for row in range(len(values)):
        to[row] = values[row]


def greatest_of(values):
    """Return the greatest absolute value of ``values`` (n,), 0 for none."""
    a = b = c = d = 0.0
    whole = len(values) - len(values) % 4
    for row in range(0, whole, 4):  # four at once: each waits for the one before
        a, b = max(a, abs(values[row])), max(b, abs(values[row + 1]))
        c, d = max(c, abs(values[row + 2])), max(d, abs(values[row + 3]))
    for row in range(whole, len(values)):
        a = max(a, abs(values[row]))
    return max(max(a, b), max(c, d))


def head(theta, cos, sin):
    """Fill ``cos`` and ``sin`` (n,) of the headings ``theta``."""
    for row in range(len(theta)):
        cos[row], sin[row] = math.cos(theta[row]), math.sin(theta[row])


def arc(v, omega, step, pose, cos, sin, spare):
    """Move unicycles at ``v``, ``omega`` (n,) along arcs for ``step`` [s].

    ``pose`` (3, n), ``cos`` and ``sin`` (n,) of its headings, in place; ``spare`` (4, n).
    """
    n, (x, y, theta) = len(v), (pose[0], pose[1], pose[2])
    share, turned, c, s = spare[0], spare[1], spare[2], spare[3]
    half_turns(omega, 0.5 * step, share, turned)
    # Of the mean heading, along which the centre moves.
    rotate(cos, sin, omega, 0.5 * step, share, turned, c, s)
    for row in range(n):
        x[row] += step * v[row] * share[row] * c[row]
    for row in range(n):
        y[row] += step * v[row] * share[row] * s[row]
    rotate(c, s, omega, 0.5 * step, share, turned, cos, sin)
    beyond = 0
    for row in range(n):
        half = 0.5 * step * omega[row]
        angle = theta[row] + half + half
        theta[row] = angle
        beyond |= (angle < -PI) | (angle >= PI)
    if beyond:
        for row in range(n):
            if theta[row] < -PI or theta[row] >= PI:
                theta[row] = (theta[row] + PI) % TURN - PI


def half_turns(omega, time, share, turned):
    """Fill ``share`` with ``sin(a)/a`` and ``turned`` with ``cos(a)`` (n,) of ``a = time omega``.

    Of small angles by series, to the last bits.
    """
    n, wide = len(omega), 0
    for row in range(n):
        s = (time * omega[row]) ** 2
        share[row] = 1.0 - s * (1 / 6 - s * (1 / 120 - s * (1 / 5040 - s * (1 / 362880))))
    for row in range(n):
        s = (time * omega[row]) ** 2
        inner = s * (1 / 720 - s * (1 / 40320 - s * (1 / 3628800)))
        turned[row] = 1.0 - s * (1 / 2 - s * (1 / 24 - inner))
    for row in range(n):
        wide |= abs(time * omega[row]) > SMALL
    if wide:
        for row in range(n):
            angle = time * omega[row]
            if abs(angle) > SMALL:
                share[row], turned[row] = math.sin(angle) / angle, math.cos(angle)


def rotate(cos, sin, omega, time, share, turned, to_cos, to_sin):
    """Turn ``cos``, ``sin`` (n,) by ``time omega``, of which :func:`half_turns` gave the rest."""
    for row in range(len(cos)):
        s = time * omega[row] * share[row]
        to_cos[row] = cos[row] * turned[row] - sin[row] * s
    for row in range(len(cos)):
        s = time * omega[row] * share[row]
        to_sin[row] = sin[row] * turned[row] + cos[row] * s


def room_around(pose, around):
    """Return how far [m] all robots at ``pose`` (3, n) may move before any two bodies can touch.

    ``around``: rows of the pairs listed (m,), (m,); where robots were then (2, n); the distance at which a
    pair may touch and the way for which the list is whole [m], and what rounding takes; how far each
    robot reaches (n,) [m]; x, y, cos, sin and halves (6, k) of obstacles.  ``UNLISTED`` where it is not the
    pairs listed that are near, but what is not listed.
    """
    first, second, origin, bounds, reach, posts = around
    x, y, moved, nearest = pose[0], pose[1], 0.0, np.inf
    for row in range(len(x)):
        dx, dy = x[row] - origin[0, row], y[row] - origin[1, row]
        moved = max(moved, dx * dx + dy * dy)
    for k in range(len(first)):
        dx, dy = x[second[k]] - x[first[k]], y[second[k]] - y[first[k]]
        nearest = min(nearest, dx * dx + dy * dy)
    room, listed = 0.5 * (math.sqrt(nearest) - bounds[0]), bounds[1] - math.sqrt(moved)
    for k in range(posts.shape[1]):
        cos, sin = posts[2, k], posts[3, k]
        for row in range(len(x)):
            dx, dy = x[row] - posts[0, k], y[row] - posts[1, k]
            along, across = abs(cos * dx + sin * dy), abs(cos * dy - sin * dx)
            room = min(room, max(along - posts[4, k], across - posts[5, k]) - reach[row])
    if listed < room and listed < 0.5 * bounds[1]:
        return UNLISTED
    return min(room, listed) - bounds[2]


def place_points(pose, l, cos, sin, points):
    """Fill ``points`` (n, 2) with those at ``l`` [m] ahead of ``pose`` (3, n)."""
    for row in range(len(points)):
        points[row, 0] = pose[0, row] + l * cos[row]
        points[row, 1] = pose[1, row] + l * sin[row]


def map_all(u, cos, sin, l, wanted):
    """Put the commands that give points the velocities ``u`` (n, 2), eq. (7), into ``wanted`` (2, n).

    Return whether robots could follow all of them, and there is one for each.
    """
    n = wanted.shape[1]
    if u.shape != (n, 2):
        return False
    v, omega, odd = wanted[0], wanted[1], 0
    for row in range(n):
        v[row] = cos[row] * u[row, 0] + sin[row] * u[row, 1]
    for row in range(n):
        omega[row] = (cos[row] * u[row, 1] - sin[row] * u[row, 0]) / l
    for row in range(n):  # nor is nan
        odd |= (not abs(v[row]) <= FASTEST) | (not abs(omega[row]) <= FASTEST)
    return odd == 0


def excesses(wanted, top, excess):
    """Fill ``excess`` (n,): by which factor ``wanted`` (2, n) is beyond its limits ``top``, 1 where not."""
    for row in range(len(excess)):
        excess[row] = max(abs(wanted[0, row]) / top[0, row], 1.0)
    for row in range(len(excess)):
        excess[row] = max(abs(wanted[1, row]) / top[1, row], excess[row])


def saturate(wanted, excess, scope, command):
    """Put ``wanted`` (2, n) into ``command``, slower by the ``excess`` (n,) of each robot.

    By the team's greatest where ``scope`` is 2, as it is where that is 0.
    """
    worst = greatest_of(excess) if scope == 2 else 1.0
    for axis in range(2):
        if scope == 1:
            for row in range(len(excess)):
                command[axis, row] = wanted[axis, row] / excess[row]
        else:
            for row in range(len(excess)):
                command[axis, row] = wanted[axis, row] / worst


def keep(pose, command, kept):
    """Put ``pose`` (3, n) and ``command`` (a, n) into ``kept`` (3 + a, n).

    Return whether all robots are where a sample may be.
    """
    far = 0
    for row in range(pose.shape[1]):
        x, y = pose[0, row], pose[1, row]
        far |= (not abs(x) <= FARTHEST) | (not abs(y) <= FARTHEST)
    for axis in range(3):
        copy(pose[axis], kept[axis])
    for axis in range(len(command)):
        copy(command[axis], kept[3 + axis])
    return far == 0
