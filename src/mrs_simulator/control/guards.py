"""Guards of real robots as functions of arrays: fences, distances, jumps, speeds, stalls.

Poses are in the common frame, (n, 3) [m, m, rad], or (n, 4) with the heights [m] of a team that leaves
the ground, unless said otherwise; comparisons with NaN, the pose of a robot without odometry, are false.
"""

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import NO_LIMITS, UNICYCLE_AXES, scaled, wrap_angle
from mrs_simulator.core.neighbours import close_pairs, squared
from mrs_simulator.scenario.team.limits import LoweredLimits

PLANAR_AXES = ("linear.x", "linear.y", "angular.z")
LEVEL_AXES = ("linear.x", "linear.y", "linear.z", "angular.z")  # of robots that leave the ground
PLACE = [0, 1, 3]  # columns of x, y and the height
MARGIN = 1.5  # [-] by which a robot may be faster than its limits say
AT_ORIGIN = 1e-3  # [m], [rad] within which odometry counts as newly begun
AWAY = 0.02  # [m], [rad] beyond which it does not
# [m/s, rad/s] from which on a robot counts as commanded to move
LEAST_COMMAND = np.array([0.05, 0.1])
LEAST_MOTION = 0.2  # [-] of its command that a moving robot reaches at least, its ramps included
# [m, rad] that it was commanded to move meanwhile
FROZEN_AFTER = np.array([0.02, math.radians(2.0)])
COMMAND_UNIT = np.array([1e-3, math.radians(1.0)])  # [m/s, rad/s] to which drivers round commands
SMOOTHING = 0.5  # [s] over which its measured speed is averaged
LONGEST_GAP = 1.0  # [s] between two poses, after which the motion between them is unknown


def checked_fence(fence):
    """Return ``fence``, ``[x_min, y_min, x_max, y_max]`` [m]; ``ValueError`` if it holds nothing.

    Of robots that fly it may have ``z_min, z_max`` besides.
    """
    if fence is not None and len(fence) == 6 and not fence[4] < fence[5]:
        raise ValueError("geofence = {}: wanted z_min < z_max, its last two".format(list(fence)))
    if fence is not None and not (fence[0] < fence[2] and fence[1] < fence[3]):
        raise ValueError(
            "geofence = {}: wanted [x_min, y_min, x_max, y_max] with x_min < x_max, "
            "y_min < y_max".format(list(fence))
        )
    return fence


def outside(pose, fence):
    """Return the rows of the robots outside ``fence`` [m], a list; none without a fence.

    ``pose`` (n, 3), or (n, 4) with heights: of these alone the fence's z is asked.
    """
    if fence is None:
        return []
    x, y = pose[:, 0], pose[:, 1]
    beyond = (x < fence[0]) | (y < fence[1]) | (x > fence[2]) | (y > fence[3])
    if len(fence) == 6 and pose.shape[1] > 3:
        beyond |= (pose[:, 3] < fence[4]) | (pose[:, 3] > fence[5])
    return np.flatnonzero(beyond).tolist()


def pairs_nearer(pose, distance):
    """Return ``(i, j, d)`` of the pairs of rows whose centres are d < ``distance`` [m] apart.

    ``pose`` (n, 3), or (n, 4) with heights.
    """
    if distance <= 0.0 or len(pose) < 2:
        return []
    places = pose[:, PLACE[: pose.shape[1] - 1]]
    known = np.flatnonzero(np.isfinite(places).all(axis=1))
    points = places[known]
    first, second = close_pairs(points, distance)
    apart = np.sqrt(squared(points[second] - points[first]))
    return list(zip(known[first].tolist(), known[second].tolist(), apart.tolist()))


def limited(limits, v_max=math.inf, omega_max=math.inf):
    """Return a scenario's ``limits`` lowered to ``v_max`` [m/s] and ``omega_max`` [rad/s]."""
    if isinstance(limits, str):
        return LoweredLimits(limits, v_max, omega_max)
    limits = NO_LIMITS if limits is None else limits
    return limits._replace(
        v_max=min(limits.v_max, v_max), omega_max=min(limits.omega_max, omega_max)
    )


def slowed(command, v_max, omega_max, scope="robot", axes=UNICYCLE_AXES):
    """Return ``command`` (n, a) within the top speeds [m/s, rad/s], each row scaled by one factor.

    ``v_max``, ``omega_max``: one number for all robots each, or of each robot, (n,); ``axes``: the
    columns of ``command``.  ``scope``: "team" for one factor for all; any other, "none" too, which would
    leave robots too fast: each robot is scaled by itself.
    """
    speed, turn = np.abs(speed_and_turn(command, axes)).T
    excess = np.maximum(speed / v_max, turn / omega_max)
    return scaled(command, excess, "team" if scope == "team" else "robot")


def stilled(command, deadband):
    """Return ``command`` (n, a), zero for robots of which no component exceeds ``deadband``.

    ``deadband`` [m/s, rad/s].
    """
    if deadband <= 0.0:
        return command
    moves = (np.abs(command) > deadband).any(axis=1)
    return np.where(moves[:, np.newaxis], command, 0.0)


def planar(command, axes):
    """Return how ``command`` (n, a) moves robots: itself for unicycles, else (n, 3) or (n, 4).

    The columns are vx, vy, of a team that leaves the ground vz, and omega, as far as ``axes`` has them.
    """
    if axes == UNICYCLE_AXES:
        return command
    columns = LEVEL_AXES if "linear.z" in axes else PLANAR_AXES
    result = np.zeros((len(command), len(columns)))
    for column, axis in enumerate(columns):
        if axis in axes:
            result[:, column] = command[:, axes.index(axis)]
    return result


def speed_and_turn(command, axes):
    """Return speed and turn rate of ``command`` (n, a), (n, 2) [m/s, rad/s]; of unicycles signed."""
    values = planar(command, axes)
    if values is command:
        return command
    speed = np.hypot(values[:, 0], values[:, 1])
    if values.shape[1] == len(LEVEL_AXES):
        speed = np.hypot(speed, values[:, 2])
    return np.stack([speed, values[:, -1]], axis=1)


def _for(columns, pair):
    """Return the ``pair``, of translation and turn, for each of 2 to 4 ``columns``."""
    return pair[[0] * (columns - 1) + [1]]


class Violations:
    """Robots that broke a bound: they stand until the cause is gone and a person releases them."""

    def __init__(self, numbers, fence=None, min_distance=0.0):
        """``numbers``: the robots' numbers; ``fence`` [m]; ``min_distance`` [m] between centres."""
        self.numbers = tuple(numbers)
        self.fence, self.min_distance = checked_fence(fence), min_distance
        self.reasons = {}

    def causes(self, pose):
        """Return ``{row: text}`` of the robots that break a bound at ``pose``."""
        found = {}
        for row in outside(pose, self.fence):
            place = ", ".join(
                "{:.2f}".format(value) for value in pose[row, PLACE[: self._shown(pose)]]
            )
            found[row] = "outside the geofence at ({})".format(place)
        for i, j, distance in pairs_nearer(pose, self.min_distance):
            for row, other in ((i, j), (j, i)):
                text = "{:.2f} m from robot{}".format(distance, self.numbers[other])
                found[row] = found[row] + " and " + text if row in found else text
        return found

    def _shown(self, pose):
        """Return how many coordinates of ``pose`` the fence bounds."""
        return 3 if pose.shape[1] > 3 and self.fence is not None and len(self.fence) == 6 else 2

    def check(self, pose, others=()):
        """Check ``pose``; return the texts of the robots that are stopped from now on.

        ``others``: causes ``{row: text}`` found elsewhere, which are gone when they are released.
        """
        found = {**dict(others), **self.causes(pose)}
        new = {row: why for row, why in found.items() if row not in self.reasons}
        self.reasons.update(new)
        return [self._line(row, new) for row in sorted(new)]

    def release(self, pose):
        """Release the robots whose cause is gone at ``pose``."""
        causes = self.causes(pose)
        self.reasons = {row: causes[row] for row in self.reasons if row in causes}

    def text(self):
        """Return which robots are stopped and why, "" if none is."""
        return "; ".join(self._line(row, self.reasons) for row in sorted(self.reasons))

    def _line(self, row, reasons):
        return "robot{} stopped: {}".format(self.numbers[row], reasons[row])


class Standstill:
    """Finds robots that are commanded to move and do not: motors off, stuck, miswired, or a dead link.

    Speeds along the axes and turn rate are looked at one by one; a robot that follows any of them moves.
    """

    def __init__(self, patience):
        """``patience`` (n,) [s]: for how long each may fail to move, ``inf``: for ever."""
        self._patience = np.asarray(patience, dtype=float)
        self._time = None

    def forget(self):
        """Reset: watch from the next pose on."""
        self._time = None

    def stuck(self, now, pose, command):
        """Return the rows of the robots that have failed to move for longer than their patience.

        ``pose`` at ``now`` [s]; ``command`` [m/s, rad/s] as :func:`planar` returns it, in force since
        the last call.
        """
        columns = command.shape[1]
        commanded = np.where(np.abs(command) >= _for(columns, LEAST_COMMAND), np.sign(command), 0.0)
        if self._time is None or not 0.0 <= now - self._time <= LONGEST_GAP:
            self._speed = np.zeros_like(commanded)
            self._since = np.full(commanded.shape, float(now))
            self._commanded = commanded
        else:
            fade = math.exp((self._time - now) / SMOOTHING)
            self._speed = fade * self._speed + self._moved(pose, columns) / SMOOTHING
        self._time, self._pose = now, pose.copy()
        # In either direction: a robot that is to reverse takes seconds to slow down.
        moves = (commanded != 0.0) & (np.abs(self._speed) >= LEAST_MOTION * np.abs(command))
        self._since[moves | (commanded == 0.0) | (commanded != self._commanded)] = now
        self._commanded = commanded
        late = (now - self._since).max(axis=1) > self._patience
        return np.flatnonzero(late & ~moves.any(axis=1)).tolist()

    def _moved(self, pose, columns):
        moved = body_motion(self._pose, pose)
        return moved[:, {2: [0, 2], 3: [0, 1, 2], 4: [0, 1, 3, 2]}[columns]]


class Repetition:
    """Finds robots that are commanded to move while their odometry repeats itself: a link that is lost.

    A driver that has lost its robot may go on publishing the last pose, with new stamps.
    """

    def __init__(self, patience):
        """``patience`` (n,) [s]: for how long each may repeat itself, ``inf``: for ever."""
        self._patience = np.asarray(patience, dtype=float)
        finite = self._patience[np.isfinite(self._patience)]
        self._window = float(finite.max()) if len(finite) else 0.0
        self.forget()

    def forget(self):
        """Reset: watch from the next call on."""
        n = len(self._patience)
        self._total = np.zeros((n, 1))  # [m, rad] that each was commanded to move so far
        self._totals = deque()  # (time, total) over the window
        self._begun, self._commanded = np.full(n, -math.inf), np.full(n, -math.inf)
        self._time = None

    def frozen(self, now, changed, command):
        """Return the rows of the robots that should have moved and still report the same pose.

        ``changed`` (n,) [s]: when the odometry of each last changed, by the clock of ``now`` [s];
        ``command`` [m/s, rad/s] as :func:`planar` returns it, in force since the last call.
        """
        if not self._window:
            return []
        unit = _for(command.shape[1], COMMAND_UNIT)
        commanded = np.floor(np.abs(command) / unit + 0.5) * unit
        before = now if self._time is None else self._time
        self._time, self._total = now, self._total + commanded * (now - before)
        self._totals.append((now, self._total))
        while len(self._totals) > 1 and self._totals[1][0] <= now - self._window + 1e-9:
            self._totals.popleft()
        moving = commanded.any(axis=1)
        # A robot at rest has reported the same pose for long: the time counts from its command to move.
        self._begun[moving & (before - self._commanded > self._patience)] = before
        self._commanded[moving] = now
        late = now - np.maximum(changed, self._begun) >= self._patience
        wanted = self._total - self._totals[0][1]
        return np.flatnonzero(
            late & (wanted > _for(command.shape[1], FROZEN_AFTER)).any(axis=1)
        ).tolist()


def body_motion(before, after):
    """Return how far robots went forward and left [m], turned [rad] and, of (n, 4), rose [m]."""
    turn = wrap_angle(after[:, 2] - before[:, 2])
    heading = before[:, 2] + 0.5 * turn
    step = after[:, :2] - before[:, :2]
    cos, sin = np.cos(heading), np.sin(heading)
    forward, left = step[:, 0] * cos + step[:, 1] * sin, step[:, 1] * cos - step[:, 0] * sin
    return np.column_stack([forward, left, turn, after[:, 3:] - before[:, 3:]])


class JumpBounds(NamedTuple):
    """How far a robot may be from its last pose."""

    slack: float  # [m], [rad]
    v_max: float  # [m/s]
    omega_max: float  # [rad/s]
    longest: float = math.inf  # [s] without odometry for which a robot may go on moving
    silence: float = math.inf  # [s] after which a pose at the origin means that odometry began anew

    def exceeded(self, before, after, dt, climb=0.0):
        """Return what jumped between poses ``before`` and ``after``, ``dt`` [s] later, or "".

        ``climb`` [m]: by how much the height changed.
        """
        moved = math.hypot(math.hypot(after[0] - before[0], after[1] - before[1]), climb)
        turned = abs(float(wrap_angle(after[2] - before[2])))
        reach = MARGIN * min(dt, self.longest)
        far = moved > self.slack + reach * self.v_max
        far = far or turned > self.slack + reach * self.omega_max
        if far or (dt > self.silence and _away(before) and not _away(after, AT_ORIGIN)):
            return "jumped by {:.2f} m and {:.2f} rad within {:.2f} s".format(moved, turned, dt)
        return ""


def _away(pose, distance=AWAY):
    return max(math.hypot(pose[0], pose[1]), abs(pose[2])) > distance


class Tracks:
    """The newest pose of each robot; from a jump on, the last one before it, until accepted."""

    def __init__(self, n, bounds=None):
        """``bounds``: of each robot :class:`JumpBounds`, or None where every pose is accepted.

        None instead of all of them: every pose of every robot is accepted.
        """
        self.pose = np.full((n, 3), np.nan)
        self.first = np.full((n, 3), np.nan)
        self.jumps = {}
        self._received, self._z = np.full((n, 3), np.nan), np.zeros(n)
        self._times = [None] * n
        self._bounds = bounds

    def take(self, row, pose, times, z=0.0):
        """Add ``pose`` of robot ``row`` at the height ``z`` [m].

        ``times`` [s]: when it came, and its stamp.
        """
        last, self._times[row] = self._times[row], times
        bounds = self._bounds and self._bounds[row]
        if bounds and last is not None:
            # Of two messages that come in one burst the stamps give the time between them.
            dt = max(0.0, times[0] - last[0], times[1] - last[1])
            jump = bounds.exceeded(self._received[row], pose, dt, z - self._z[row])
            if jump:
                self.jumps[row] = jump
        self._received[row], self._z[row] = pose, z
        if row not in self.jumps:
            self.pose[row] = pose
        if last is None:
            self.first[row] = pose

    def take_all(self, rows, poses, times, z):
        """Add ``poses`` (m, 3) of the robots ``rows`` (m,) at the heights ``z`` (m,) [m].

        ``times`` [s] as of ``take``, which does so one by one.
        """
        if self._bounds is not None:
            for row, pose, height in zip(rows.tolist(), poses.tolist(), z.tolist()):
                self.take(row, pose, times, height)
            return
        new = rows[np.isnan(self.first[rows, 0])]
        self.pose[rows] = self._received[rows] = poses
        self.first[new] = self.pose[new]
        for row in new.tolist():
            self._times[row] = times

    def accept(self):
        """Accept the poses of the robots that jumped."""
        for row in self.jumps:
            self.pose[row] = self.first[row] = self._received[row]
        self.jumps = {}
