"""The safety filter by readings of each robot's own sensors, instead of known positions.

A robot takes half of what a pair of robots may use up, since the other one does the same: what both do
keeps the bound of the pair (Wang, Ames and Egerstedt, 2017, of decentralised barriers).
"""

import numpy as np

from mrs_simulator.control.safety.nearest_velocities import FIXED_RATE, GAMMA
from mrs_simulator.core.kinematics import cos_sin

SHARE = 0.5  # [-] of what a pair may use up, which each of its robots takes
ARC = 5  # [-] places in a cone where an echo may come from
SWIRL = 0.5  # [rad] by which a robot that is stopped turns aside
PARALLEL = 1e-6  # [-] sine of the angle between two lines that do not meet
ROUNDING = 1e-9  # [m/s]
TINY = 1e-300
CONTRADICTED = 0.02  # [m] by which another transducer's range must be longer to exclude a place


class SensedNeighbourhood:
    """One robot among what it senses, all in its own frame."""

    def __init__(self, point, radius, reaches, period):
        """``point`` (2,) [m]: the controlled one; ``radius`` [m]: of a disc about it that holds the body.

        ``reaches`` (n,) [m]: how far the other robots' discs reach from their centres, which are seen;
        ``period`` [s] for which a velocity is held.
        """
        self.point, self.radius = np.asarray(point, dtype=float), radius
        self._reaches, self._period = reaches, period

    def bounds(self, readings):
        """Return ``out`` (k, 2), ``limit`` (k,) [m/s]: ``readings`` allow ``-out u <= limit``."""
        found = [self._of(reading) for reading in readings]
        return tuple(np.concatenate([each[k] for each in found]) for k in (0, 1))

    def _of(self, reading):
        """Return the ways out (k, 2) and the limits (k,) [m/s] of one reading."""
        if hasattr(reading, "numbers"):
            return self._of_robots(reading)
        return self._of_echoes(reading)

    def _of_robots(self, reading):
        """Return the ways out and limits of other robots, ``p`` from them to here:

        ``-2 p^T u <= min(gamma h^3, h/Tc)/2``.
        """
        apart = self.point - reading.points
        far = np.maximum(np.hypot(*apart.T), 1e-9)
        margin = far * far - (self.radius + self._reaches[reading.numbers - 1]) ** 2
        limit = SHARE * np.minimum(GAMMA * margin**3, margin / self._period)
        return apart / far[:, np.newaxis], limit / (2.0 * far)

    def _of_echoes(self, reading):
        """Return the ways out and limits of the echoes of a sonar or laser.

        The body that a sonar detects is convex and touches the arc of its cone from beyond: it lies behind
        an unknown tangent of the arc.  Of a ray the point that it meets is known.
        """
        if reading.cone == 0.0:
            points = reading.points[np.isfinite(reading.ranges)]
            way = self.point - points
            far = np.maximum(np.hypot(*way.T), 1e-9)
            out, gap = way / far[:, np.newaxis], far - self.radius
        else:
            points, out = arcs(reading)
            gap = np.einsum("ij,ij->i", out, self.point - points) - self.radius
        return out, SHARE * np.minimum(FIXED_RATE, 1.0 / self._period) * gap


def arcs(reading):
    """Return the places in the cones where echoes may come from, and the ways from there, (k, 2) each.

    A place in the cone of another transducer with a longer range is excluded: that one would have detected
    a body there.  A transducer all of whose places are excluded keeps them.
    """
    echoing = np.flatnonzero(np.isfinite(reading.ranges))
    x, y, direction = reading.places[echoing].T
    angle = direction[:, np.newaxis] + np.linspace(-reading.cone, reading.cone, ARC)
    along = np.stack(cos_sin(angle), axis=2)
    place = reading.ranges[echoing, np.newaxis, np.newaxis] * along
    place += np.stack([x, y], axis=1)[:, np.newaxis]
    possible = ~_contradicted(reading, place)
    possible[~possible.any(axis=1)] = True
    return place[possible], -along[possible]


def _contradicted(reading, place):
    """Return which of ``place`` (h, a, 2) a longer range of another transducer excludes, (h, a) bool."""
    way = place[:, :, np.newaxis] - reading.places[:, :2]
    far = np.hypot(way[..., 0], way[..., 1])
    cos, sin = cos_sin(reading.places[:, 2])
    ahead = way[..., 0] * cos + way[..., 1] * sin
    inside = ahead > far * np.cos(reading.cone)
    # a lost range excludes nothing
    ranges = np.where(np.isnan(reading.ranges), 0.0, reading.ranges)
    return (inside & (far < np.minimum(ranges, reading.most) - CONTRADICTED)).any(axis=2)


def safe_by_sensors(wanted, sensed, turn, readings, speed=None):
    """Return the velocities (n, 2) [m/s] nearest to ``wanted`` that each robot's ``readings`` allow.

    ``sensed``: the robots' :class:`SensedNeighbourhood`; ``turn`` (n, 2, 2): ``turn[i] @ v`` is ``v``
    of the i-th robot's frame in the common one; ``readings``: a list for each robot, in which None stands
    for no reading yet: then the robot stands still.
    ``speed`` (n,) [m/s]: caps.
    """
    result = np.zeros_like(wanted)
    for row, (neighbourhood, own) in enumerate(zip(sensed, readings)):
        if any(reading is None for reading in own):
            continue
        out, limit = neighbourhood.bounds(own)
        velocity = nearest(wanted[row] @ turn[row], out, limit)
        result[row] = turn[row] @ velocity
    if speed is not None:  # standing still is allowed, and what lies between
        size = np.maximum(np.linalg.norm(result, axis=1), TINY)
        result *= np.minimum(1.0, speed / size)[:, np.newaxis]
    return result


def nearest(wanted, out, limit):
    """Return the velocity (2,) nearest to ``wanted`` (2,) with ``-out u <= limit``, out (k, 2), limit (k,).

    It is ``wanted`` itself, on one of the lines, or where two of them meet.  A robot that a line stops
    turns aside first.  Where the lines leave no room it is what violates them least.
    """
    if (-out @ wanted <= limit).all():
        return wanted
    wanted = _aside(wanted)
    kept = limit < np.hypot(*wanted)  # others do not matter to what is no faster
    own, most = -out[kept], limit[kept]
    excess = own @ wanted - most
    on_lines = wanted - excess[:, np.newaxis] * own
    first, second = np.triu_indices(len(own), 1)
    cross = own[first, 0] * own[second, 1] - own[first, 1] * own[second, 0]
    meet = np.abs(cross) > PARALLEL
    first, second, cross = first[meet], second[meet], cross[meet]
    x = (most[first] * own[second, 1] - most[second] * own[first, 1]) / cross
    y = (most[second] * own[first, 0] - most[first] * own[second, 0]) / cross
    places = np.concatenate([wanted[np.newaxis], on_lines, np.stack([x, y], axis=1), [[0.0, 0.0]]])
    worst = (places @ own.T - most).max(axis=1)
    far = np.hypot(*(places - wanted).T)
    allowed = worst <= ROUNDING
    if not allowed.any():
        return places[np.argmin(worst)]
    return places[np.argmin(np.where(allowed, far, np.inf))]


def _aside(wanted):
    """Return ``wanted`` (2,) turned aside, all robots to the same side, to break symmetry."""
    cos, sin = np.cos(SWIRL), np.sin(SWIRL)
    return np.array([cos * wanted[0] - sin * wanted[1], sin * wanted[0] + cos * wanted[1]])
