"""Unicycles moved over several steps in one compiled call: law, saturation, ramps, arcs, room to move.

The numbers are those of ``KinematicMotion``, ``PointMassMotion`` and ``Team`` in their order, but for sines
and cosines: they are the C library's at the begin of a stretch, and turned with the robots from there on,
which takes a third of the time.  Trajectories agree to rounding as long as robots do not touch: tests
hold them to 1e-9 m.
"""

import functools

import numpy as np

from mrs_simulator.core.compiled_terms import kernel
from mrs_simulator.core.compiling import jit

PI, TURN = np.pi, 2.0 * np.pi
FASTEST = 1e12  # [m/s] of a wanted velocity: a greater one is mapped with care
SMALL = 0.1  # [rad], for which five terms of a series are exact
DONE, NEAR, ODD = 0, 1, 2  # why a stretch ended: complete; bodies may touch; no usable command
SCOPES = ("none", "robot", "team")  # of saturation

term = None  # the law, compiled


def stretch(steps, until, every, pose, inner, command, limits, step, reach, room, l, scope, *given):
    """Move robots by up to ``steps`` steps, in place; return ``(steps done, room left, why it ended)``.

    ``pose`` (n, 3); ``inner`` (n, 2), speeds; ``command`` (n, 2), in force.  The law, ``term(points,
    *given)``, is asked after ``until`` steps and after every ``every`` from then on.  ``limits`` (n, 10):
    least and greatest target, most change, twice that, and limit of commands, of v and omega each.
    ``reach`` [m]: what nobody exceeds in a step of ``step`` [s]; ``room`` [m]: how far robots may move
    before bodies can touch; ``l`` [m]; ``scope``: saturation, a row of ``SCOPES``.  A step in which bodies
    may touch (``NEAR``) is not made; a command that nobody could follow (``ODD``) is not given.
    """
    n = len(pose)
    after, mean, points = np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 2))
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    for count in range(steps):
        fastest = 0.0
        for row in range(n):
            for axis in range(2):
                target = min(max(command[row, axis], limits[row, axis]), limits[row, 2 + axis])
                most = limits[row, 4 + axis]
                change = min(max(target - inner[row, axis], -most), most)
                after[row, axis] = inner[row, axis] + change
                lost = abs(change) * change / limits[row, 6 + axis]
                mean[row, axis] = after[row, axis] - lost
            fastest = max(fastest, abs(mean[row, 0]))
        travel = min(reach, step * fastest)
        if room <= travel:
            return count, room, NEAR
        room -= travel
        for row in range(n):
            half = 0.5 * step * mean[row, 1]
            share, cos_half = half_turn(half)
            sin_half, along = half * share, step * mean[row, 0] * share
            # Of the mean heading, along which the centre moves, and of the one at the end.
            c, s = (
                cos[row] * cos_half - sin[row] * sin_half,
                sin[row] * cos_half + cos[row] * sin_half,
            )
            pose[row, 0] += along * c
            pose[row, 1] += along * s
            cos[row], sin[row] = c * cos_half - s * sin_half, s * cos_half + c * sin_half
            theta = pose[row, 2] + half + half
            if theta < -PI or theta >= PI:
                theta = (theta + PI) % TURN - PI
            pose[row, 2] = theta
            inner[row, 0], inner[row, 1] = after[row, 0], after[row, 1]
        if count + 1 < until or (count + 1 - until) % every != 0:
            continue
        for row in range(n):
            points[row, 0] = pose[row, 0] + l * cos[row]
            points[row, 1] = pose[row, 1] + l * sin[row]
        if not mapped(term(points, *given), cos, sin, l, after):
            return count + 1, room, ODD
        worst = 1.0
        for row in range(n):
            v, omega = abs(after[row, 0]), abs(after[row, 1])
            excess = max(v / limits[row, 8], omega / limits[row, 9], 1.0)
            worst = max(worst, excess)
            mean[row, 0] = excess if scope == 1 else 1.0
        for row in range(n):
            factor = worst if scope == 2 else mean[row, 0]
            command[row, 0], command[row, 1] = after[row, 0] / factor, after[row, 1] / factor
    return steps, room, DONE


def point_stretch(steps, until, every, pose, twist, command, step, l, scope, *given):
    """Move hand points as point masses by up to ``steps`` steps, in place; return as ``stretch`` does.

    Arguments as there, and ``twist`` (n, 3), that of the last step; a point has neither limits nor a body,
    so that ``scope`` means nothing.
    """
    n = len(pose)
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    points, wanted = np.empty((n, 2)), np.empty((n, 2))
    for count in range(steps):
        for row in range(n):
            along, across = command[row, 0], l * command[row, 1]
            pose[row, 0] += step * (cos[row] * along - sin[row] * across)
            pose[row, 1] += step * (sin[row] * along + cos[row] * across)
            twist[row, 0], twist[row, 1] = along, across
        if count + 1 < until or (count + 1 - until) % every != 0:
            continue
        for row in range(n):
            points[row, 0] = pose[row, 0] + l * cos[row]
            points[row, 1] = pose[row, 1] + l * sin[row]
        if not mapped(term(points, *given), cos, sin, l, wanted):
            return count + 1, ODD
        command[:] = wanted
    return steps, DONE


def mapped(u, cos, sin, l, wanted):
    """Put the commands (n, 2) that give points the velocities ``u``, eq. (7), into ``wanted``.

    Return whether robots could follow all of them, and there is one for each.
    """
    if u.shape != wanted.shape:
        return False
    for row in range(len(u)):
        x, y = u[row, 0], u[row, 1]
        v, omega = cos[row] * x + sin[row] * y, (cos[row] * y - sin[row] * x) / l
        if not (abs(v) <= FASTEST and abs(omega) <= FASTEST):
            return False
        wanted[row, 0], wanted[row, 1] = v, omega
    return True


def half_turn(half):
    """Return ``sin(half)/half`` and ``cos(half)``; of small angles by series, to the last bits."""
    if abs(half) > SMALL:
        return np.sin(half) / half, np.cos(half)
    s = half * half
    share = 1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0)))
    cos = 1.0 - s / 2.0 * (1.0 - s / 12.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0 * (1.0 - s / 90.0))))
    return share, cos


@functools.lru_cache(maxsize=None)
def compiled_stretch(law, loops):
    """Return ``loops``, a stretch, under the function ``law`` of the points, compiled."""
    return kernel(law, loops, jit(), jit(cache=True))


class Leaps:
    """A ``World`` of unicycles that moves by several steps at once under a law that is asked meanwhile."""

    def __init__(self, world, law, given, every, l, saturation):
        """``law(points, *given)`` returns velocities (n, 2); it is asked every ``every`` steps.

        ``l`` [m] is the hand length, ``saturation`` one of ``SCOPES``.
        """
        self._world, self._every = world, every
        loops = point_stretch if world.fidelity == "point_mass" else stretch
        self._function = compiled_stretch(law, loops)
        self._given = l, SCOPES.index(saturation), *given

    def advance(self, steps):
        """Move by up to ``steps`` steps; return how many were made, and why it ended.

        ``NEAR``: the next step is to be made by ``World.step``; ``ODD``: a command is due that the law
        is to be asked for.  A command due after the last step is given, too, but for these.
        """
        return self._world.leap(steps, self._every, self._function, *self._given)
