"""Robots moved over several steps by loops that numba compiles: law, limits, ramps, motion, room to move.

The numbers are those of ``KinematicMotion``, ``PointMassMotion`` and ``Team`` in their order, but for sines
and cosines: they are the C library's at the begin of a stretch, and turned with the robots from there on,
which takes a third of the time.  Trajectories agree to rounding as long as robots do not touch: tests
hold them to 1e-9 m.
"""

import math

import numpy as np

PI, TURN = np.pi, 2.0 * np.pi
FASTEST = 1e12  # [m/s] of a wanted velocity: a greater one is mapped with care
SMALL = 0.1  # [rad], for which five terms of a series are exact
DONE, NEAR, ODD = 0, 1, 2  # why a stretch ended: complete; bodies may touch; no usable command
SCOPES = ("none", "robot", "team")  # of saturation
DIAGONAL = math.sqrt(2.0)  # [-] of a velocity by its greatest component, at most

term = None  # the law, compiled


def stretch(steps, until, every, pose, inner, command, limits, step, reach, room, l, scope, *given):
    """Move robots by up to ``steps`` steps, in place; return ``(steps done, room left, why it ended)``.

    ``pose`` (n, 3); ``inner`` (n, 2), speeds; ``command`` (n, 2), in force.  The law, ``term(points,
    *given)``, is asked after ``until`` steps and after every ``every`` from then on.  ``limits`` (n, 10):
    least and greatest target, most change, twice that, and limit of commands, of v and omega each.
    ``reach`` [m]: the longest way in a step of ``step`` [s]; ``room`` [m]: how far robots may move
    before bodies can touch; ``l`` [m]; ``scope``: saturation, a row of ``SCOPES``.  A step in which bodies
    may touch (``NEAR``) is not made; a command that no robot could follow (``ODD``) is not given.
    """
    n = len(pose)
    after, mean, points = np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 2))
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    for count in range(steps):
        fastest = ramp(inner, command, limits, after, mean)
        travel = min(reach, step * fastest)
        if room <= travel:
            return count, room, NEAR
        room -= travel
        arcs(pose, cos, sin, step, mean)
        inner[:] = after
        if not is_due(count + 1, until, every):
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
            mean[row, 0] = excess
        saturate(after, mean, worst, scope, command)
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
        if not is_due(count + 1, until, every):
            continue
        for row in range(n):
            points[row, 0] = pose[row, 0] + l * cos[row]
            points[row, 1] = pose[row, 1] + l * sin[row]
        if not mapped(term(points, *given), cos, sin, l, wanted):
            return count + 1, ODD
        for row in range(n):
            command[row, 0], command[row, 1] = wanted[row, 0], wanted[row, 1]
    return steps, DONE


def sliding_stretch(
    steps, until, every, pose, inner, command, limits, wheels, step, reach, room, l, scope, *given
):
    """Move omnidirectional bases, of which none turns, as ``stretch`` does unicycles.

    Arguments as there, but for columns of three axes; ``wheels`` (n, 4, 3) of each robot: what one of its
    rims does at vx and at vy, and the limit of its speed.  Where a robot turns, or is to turn, no step is
    made.
    """
    n = len(pose)
    for row in range(n):
        if inner[row, 2] != 0.0 or command[row, 2] != 0.0:
            return 0, room, NEAR
    after, mean, points = np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 2))
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    for count in range(steps):
        fastest = slide_ramp(inner, command, limits, wheels, after, mean)
        travel = min(reach, step * DIAGONAL * fastest)
        if room <= travel:
            return count, room, NEAR
        room -= travel
        for row in range(n):
            x, y = step * mean[row, 0], step * mean[row, 1]
            pose[row, 0] += cos[row] * x - sin[row] * y
            pose[row, 1] += sin[row] * x + cos[row] * y
            inner[row, 0], inner[row, 1] = after[row, 0], after[row, 1]
        if not is_due(count + 1, until, every):
            continue
        for row in range(n):
            points[row, 0], points[row, 1] = pose[row, 0], pose[row, 1]
        if not mapped(term(points, *given), cos, sin, 1.0, after):
            return count + 1, room, ODD
        worst = 1.0
        for row in range(n):
            x, y = after[row, 0], after[row, 1]
            excess = max(abs(x) / limits[row, 12], abs(y) / limits[row, 13], 1.0)
            excess = max(excess, rim_excess(x, y, wheels[row]))
            worst = max(worst, excess)
            mean[row, 0] = excess
        saturate(after, mean, worst, scope, command)
    return steps, room, DONE


def is_due(step, until, every):
    """Return whether the law is asked after ``step``."""
    return step >= until and (step - until) % every == 0


def ramp(inner, command, limits, after, mean):
    """Put the speeds (n, 2) at the end of a step, and their means, into ``after`` and ``mean``.

    Return the greatest of the mean speeds.
    """
    fastest = 0.0
    for row in range(len(inner)):
        for axis in range(2):
            target = min(max(command[row, axis], limits[row, axis]), limits[row, 2 + axis])
            change = approach(target, inner[row, axis], limits[row, 4 + axis])
            after[row, axis] = inner[row, axis] + change
            mean[row, axis] = after[row, axis] - abs(change) * change / limits[row, 6 + axis]
        fastest = max(fastest, abs(mean[row, 0]))
    return fastest


def slide_ramp(inner, command, limits, wheels, after, mean):
    """As ``ramp``, of bases whose rims slow all axes alike."""
    fastest = 0.0
    for row in range(len(inner)):
        for axis in range(2):
            asked = max(command[row, axis], limits[row, axis])
            after[row, axis] = min(asked, limits[row, 3 + axis])
        slower = max(rim_excess(after[row, 0], after[row, 1], wheels[row]), 1.0)
        for axis in range(2):
            target = after[row, axis] / slower
            change = approach(target, inner[row, axis], limits[row, 6 + axis])
            after[row, axis] = inner[row, axis] + change
            mean[row, axis] = after[row, axis] - abs(change) * change / limits[row, 9 + axis]
        fastest = max(fastest, abs(mean[row, 0]), abs(mean[row, 1]))
    return fastest


def approach(target, speed, most):
    """Return the change of ``speed`` toward ``target``, by ``most`` at most."""
    return min(max(target - speed, -most), most)


def arcs(pose, cos, sin, step, mean):
    """Move unicycles along arcs at ``mean`` speeds (n, 2), and turn ``cos``, ``sin`` of their headings."""
    for row in range(len(pose)):
        half = 0.5 * step * mean[row, 1]
        share, cos_half = half_turn(half)
        sin_half, along = half * share, step * mean[row, 0] * share
        # Of the mean heading, along which the centre moves, and of the one at the end.
        c = cos[row] * cos_half - sin[row] * sin_half
        s = sin[row] * cos_half + cos[row] * sin_half
        pose[row, 0] += along * c
        pose[row, 1] += along * s
        cos[row], sin[row] = c * cos_half - s * sin_half, s * cos_half + c * sin_half
        theta = pose[row, 2] + half + half
        if theta < -PI or theta >= PI:
            theta = (theta + PI) % TURN - PI
        pose[row, 2] = theta


def saturate(wanted, excess, worst, scope, command):
    """Put ``wanted`` (n, 2), slowed as ``scope`` says, into ``command``.

    ``excess`` (n, 2): by which factor each is too fast, in the first column; ``worst``: the greatest.
    """
    for row in range(len(wanted)):
        factor = worst if scope == 2 else excess[row, 0] if scope == 1 else 1.0
        command[row, 0], command[row, 1] = wanted[row, 0] / factor, wanted[row, 1] / factor


def rim_excess(x, y, wheels):
    """Return by which factor the fastest rim of ``wheels`` (4, 3) is too fast at the velocity (x, y)."""
    excess = 0.0
    for wheel in range(len(wheels)):
        rim = wheels[wheel, 0] * x + wheels[wheel, 1] * y
        excess = max(excess, abs(rim) / wheels[wheel, 2])
    return excess


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
