"""Laws by own sensors as published, for verdicts: see :mod:`protocols.published.sensors`."""

import math

import numpy as np

from mrs_simulator.protocols.published.sensors import Sensed, locals_of

ASIDE = 0.35  # [rad] from a direction, within which a transducer looks that way


class LimitedVisibility(Sensed):
    """To the centre c of the smallest circle about all that are seen: Ando and others, 1999.

    By the share ``gain Tc`` of the way, and no farther than V/2 from the middle m of the way to each,
    ``|s c/|c| - m| <= V/2``.
    """

    def __init__(self, gain, radius, period):
        self.gain, self.radius, self.period = gain, radius, period

    def answers(self, record):
        return locals_of(record, "neighbours", self._answer)

    def _answer(self, robot, seen):
        if seen is None:
            return 0j
        points = seen.points[seen.ranges <= self.radius]
        centre = _circle([0j, *points.tolist()])[0]
        if centre == 0:
            return 0j
        ahead, way = centre / abs(centre), self.gain * self.period * abs(centre)
        for middle in 0.5 * points * np.conj(ahead):
            inner = max((0.5 * self.radius) ** 2 - middle.imag**2, 0.0)
            way = min(way, middle.real + math.sqrt(inner))
        return max(way, 0.0) * ahead / self.period


def _circle(points, on=()):
    """Return centre and radius of the smallest circle about ``points`` through ``on`` (Welzl, 1991)."""
    found = _through(on)
    for k, point in enumerate(points if len(on) < 3 else ()):
        if abs(point - found[0]) > found[1] * (1.0 + 1e-12) + 1e-15:
            found = _circle(points[:k], (*on, point))
    return found


def _through(on):
    if len(on) < 2:
        return (on[0], 0.0) if on else (0j, -1.0)
    a, b = on[0], on[1]
    centre = 0.5 * (a + b)
    if len(on) == 3:
        rows = np.array([[(p - a).real, (p - a).imag] for p in on[1:]])
        if (
            abs(np.linalg.det(rows)) < 1e-12 * np.abs(rows).max() ** 2
        ):  # in a line: the farthest two
            return max((_through((p, q)) for p in on for q in on if p != q), key=lambda c: c[1])
        x, y = np.linalg.solve(2.0 * rows, (rows * rows).sum(axis=1))
        centre = a + complex(x, y)
    return centre, abs(a - centre)


class WallFollowing(Sensed):
    """Along a wall at ``speed + gain (gap - wanted)``, towards it at ``gain (D - distance)``.

    Two transducers that look aside have the wall, with its normal at an angle a from theirs, at
    ``D = r + x sin a + y cos a``, each with its own r, x and y.
    """

    def __init__(self, gain, distance, speed, gap, leads):
        """``leads`` (n,) [m]: how far ahead of the centre the points are."""
        self.gain, self.distance, self.speed, self.gap = gain, distance, speed, gap
        self.leads = leads

    def answers(self, record):
        return locals_of(record, "sonar", self._answer)

    def _answer(self, robot, echoes):
        if echoes is None:
            return 0j
        ranges, places = echoes.ranges, echoes.places
        looks = np.exp(1j * echoes.directions)
        ahead = [r for r, look in zip(ranges, looks) if abs(np.angle(look)) < ASIDE]
        nearest = min((r for r in ahead if math.isfinite(r)), default=math.inf)
        speed = self.speed
        if nearest < 2.0 * self.gap:
            speed += self.gain * (nearest - self.gap)
        left = [k for k, look in enumerate(looks) if abs(np.angle(look / 1j)) < ASIDE]
        left.sort(key=lambda k: places[k].real)
        rear, front = left[0], left[-1]
        if not (math.isfinite(ranges[rear]) and math.isfinite(ranges[front])):
            return complex(speed)
        apart = places[front].real - places[rear].real
        sine = min(max((ranges[rear] - ranges[front]) / apart, -1.0), 1.0)
        normal = complex(sine, math.sqrt(1.0 - sine * sine))  # towards the wall
        wall = ranges[front] + (places[front] * np.conj(normal)).real
        error = wall - self.leads[robot] * sine - self.distance
        return (self.gain * error - 1j * speed) * normal


class SensedFollowing(Sensed):
    """``gain (|z| - distance) z/|z|`` towards the robot before; the first at ``speed`` and ``turn``."""

    def __init__(self, gain, distance, speed, turn, leads):
        """``leads`` (n,) [m]: how far ahead of the centre the points are."""
        self.gain, self.distance, self.leads = gain, distance, leads
        self.first = complex(speed, turn * leads[0])

    def answers(self, record):
        return locals_of(record, "neighbours", self._answer)

    def _answer(self, robot, seen):
        if robot == 0:
            return self.first
        before = () if seen is None else np.flatnonzero(seen.rows == robot - 1)
        if not len(before):
            return 0j
        z = seen.points[before[0]] - self.leads[robot]
        return self.gain * (z - self.distance * z / max(abs(z), 1e-9))
