"""What sensors should have read, and laws by sensors as published: see :mod:`protocols.published.laws`.

Readings follow from recorded poses, by plane geometry that has nothing in common with the sensors that the
robots have; only the noise is theirs, which is a function of the scenario's seed.
"""

import math
from typing import NamedTuple

import numpy as np

from mrs_simulator.protocols.published.laws import Published
from mrs_simulator.scenario.surroundings.obstacles import Cylinder
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.noise import Draws, Streams

EARLY = 1e-9  # [s] by which a reading may be known before its latency is over
HIDING = 1e-9  # [m] by which a body must be nearer than the robot that it hides


class Sensed(Published):
    """A law of robots that know what their sensors read.

    ``answers(record)`` yields ``(row, u)`` for samples of a :class:`Record` in turn: the velocities
    (n, 2) [m/s] of the points in the common frame; samples whose readings are not known are left out.
    """

    SEES = "sensors"

    def answers(self, record):
        """Yield ``(row, u)``."""
        raise NotImplementedError

    def velocity(self, points, time, memory):
        """Raise ``TypeError``: from points it is not known what was sensed."""
        raise TypeError("a law by sensors has no velocities of points alone")


class Seen(NamedTuple):
    """Other robots: rows (k,), ranges (k,) [m] and points (k,) [m], complex, in the robot's frame."""

    rows: np.ndarray
    ranges: np.ndarray
    points: np.ndarray


class Echoes(NamedTuple):
    """Ranges (k,) [m] from places (k,) [m], complex, in directions (k,) [rad] of the robot's frame."""

    ranges: np.ndarray
    places: np.ndarray
    directions: np.ndarray
    most: float


class Record:
    """A recorded run, and what sensors should have read in it.

    ``rows``: the samples that fall on commands; ``known``: the run with the poses that the law knew.
    """

    def __init__(self, control, run, known, rows):
        """``control``: whose sensors, obstacles and period these are."""
        scenario = run.scenario
        self.run, self.known, self.rows, self.period = run, known, rows, control.period
        self.kinds, self.obstacles = control.team.kinds, control.obstacles
        self._seed, self._step = scenario.seed, scenario.step
        self._mounts = [
            {mount.name: mount for mount in own}
            for own in fitted_mounts(control.team, scenario.sensors)
        ]
        self._draws, self._begun = {}, run.meta.get("scene_time", 0.0)
        self._standing = [None if each.track else _outline(each) for each in self.obstacles]
        self._places = {round(time / self._step): row for row, time in enumerate(run.time)}

    def readings(self, name, row):
        """Return ``(sample, readings)`` that the sensor ``name`` of each robot had given last at ``row``.

        ``sample`` counts them; None in place of a reading of which the pose was not recorded.
        """
        time, found = self.run.time[row], []
        for robot, mounts in enumerate(self._mounts):
            mount = mounts[name]
            steps = max(1, round(1.0 / (mount.rate * self._step)))
            sample = math.floor((time - mount.latency + EARLY) / (steps * self._step) + 1e-6)
            at = self._places.get(sample * steps)
            reading = None if sample < 0 or at is None else self._read(robot, mount, at, sample)
            found.append((sample, reading))
        return [sample for sample, _ in found], [reading for _, reading in found]

    def is_stated(self, name):
        """Return whether all transducers of the sensor ``name`` measure at once."""
        return all(getattr(own[name].settings, "turns", 1) == 1 for own in self._mounts)

    def _read(self, robot, mount, row, sample):
        noise = self._noise(robot, mount).at(sample)
        read = _seen if mount.type == "range_bearing" else _echoes
        return read(self, robot, mount, row, noise)

    def _noise(self, robot, mount):
        key = robot, mount.name
        if key not in self._draws:
            steps = max(1, round(1.0 / (mount.rate * self._step)))
            streams = Streams(self._seed, [robot + 1], mount.name, mount.type == "range_bearing")
            self._draws[key] = Draws(dict(mount.noise), streams, steps * self._step)
        return self._draws[key]

    def pose(self, row, robot):
        """Return where a robot truly was, complex [m], and its heading [rad]."""
        x, y, theta = self.run.pose[row, robot]
        return complex(x, y), theta

    def shapes(self, row, without, height):
        """Return corners (4,) [m], complex, or centre and radius [m], of what stands at a ``height`` [m].

        ``without``: rows of robots that are left out.
        """
        found = [
            _outline(each, self.run.time[row]) if outline is None else outline
            for each, outline in zip(self.obstacles, self._standing)
            if each.height > height
        ]
        for robot, kind in enumerate(self.kinds):
            body = kind.body
            if robot in without or body.height <= height:
                continue
            z, theta = self.pose(row, robot)
            turn = np.exp(1j * theta)
            if body.round:
                middle = z + 0.5 * (body.front - body.rear) * turn
                found.append((middle, 0.5 * (body.front + body.rear)))
                continue
            side = 0.5j * body.width
            ends = [body.front + side, side - body.rear, -body.rear - side, body.front - side]
            found.append(z + np.array(ends) * turn)
        return found


def _outline(obstacle, time=0.0):
    x, y = obstacle.x, obstacle.y
    if obstacle.track is not None:
        x, y = obstacle.track.place((x, y), time)
    if isinstance(obstacle, Cylinder):
        return complex(x, y), obstacle.radius
    a, b = 0.5 * obstacle.length, 0.5j * obstacle.width
    return complex(x, y) + np.array([a + b, b - a, -a - b, a - b]) * np.exp(1j * obstacle.yaw)


def _seen(record, robot, mount, row, noise):
    """Return what a sensor of range and bearing should have seen, as ``Seen``."""
    z, theta = record.pose(row, robot)
    place, count = complex(*mount.place[:2]), len(record.kinds)
    eye = z + place * np.exp(1j * theta)
    ranges = bearings = np.full(count, np.nan)
    ranges, bearings = ranges.copy(), bearings.copy()
    for other in range(count):
        way = record.pose(row, other)[0] - eye
        bearing = _turned(np.angle(way) - theta)
        aside = abs(_turned(bearing - mount.place[3]))
        full = mount.settings.view >= 2.0 * math.pi
        if other == robot or abs(way) > mount.settings.most:
            continue
        if full or aside <= 0.5 * mount.settings.view:
            hides = mount.settings.occlusion and abs(way) > 0.0
            if not (hides and _is_hidden(record, row, (robot, other), eye, way, mount.place[2])):
                ranges[other], bearings[other] = abs(way), bearing
    ranges = np.maximum(noise.noisy(ranges[np.newaxis], "range")[0], 0.0)
    bearings = noise.noisy(bearings[np.newaxis], "bearing")[0]
    rows = np.flatnonzero(np.isfinite(ranges) & np.isfinite(bearings))
    return Seen(rows, ranges[rows], place + ranges[rows] * np.exp(1j * bearings[rows]))


def _is_hidden(record, row, without, eye, way, height):
    shapes = record.shapes(row, without, height)
    direction = np.array([way / abs(way)])
    return min((_along(each, eye, direction)[0] for each in shapes), default=np.inf) < (
        abs(way) - HIDING
    )


def _echoes(record, robot, mount, row, noise):
    """Return what a sonar or a laser should have read, as ``Echoes``."""
    z, theta = record.pose(row, robot)
    settings, own = mount.settings, np.exp(1j * mount.place[3])
    if mount.type == "sonar":
        inner = np.array(settings.transducers)
        places = complex(*mount.place[:2]) + (inner[:, 0] + 1j * inner[:, 1]) * own
        directions, half = mount.place[3] + inner[:, 2], 0.5 * settings.cone
    else:
        directions = mount.place[3] + np.linspace(settings.first, settings.last, settings.rays)
        places, half = np.full(settings.rays, complex(*mount.place[:2])), 0.0
    eye, ahead = z + places * np.exp(1j * theta), np.exp(1j * (theta + directions))
    found = np.full(len(places), np.inf)
    reach = settings.most + abs(eye - eye[0]).max()
    if mount.type == "laser":
        eye = eye[:1]
    for shape in _near(record.shapes(row, (robot,), mount.place[2]), eye[0], reach):
        own_range = _in_cone(shape, eye, ahead, half) if half else _along(shape, eye, ahead)
        found = np.minimum(found, own_range)
    found[found > settings.most] = np.inf
    found = noise.noisy(found[np.newaxis])[0]
    found = np.where(found > settings.most, np.inf, np.maximum(found, settings.least))
    return Echoes(found, places, directions, settings.most)


def _near(shapes, eye, reach):
    """Return the ``shapes`` without those with a side or rim more than ``reach`` [m] away from ``eye``."""
    corners = np.array([each for each in shapes if not isinstance(each, tuple)]).reshape(-1, 4)
    side = corners[:, [1, 2, 3, 0]] - corners
    inwards = ((eye - corners) * np.conj(side)).imag
    near = iter((inwards >= -reach * abs(side)).all(axis=1).tolist())
    return [
        each
        for each in shapes
        if (abs(eye - each[0]) - each[1] <= reach if isinstance(each, tuple) else next(near))
    ]


def _in_cone(shape, eye, ahead, half):
    """Return the distances (k,) [m] of a shape's points within ``half`` [rad] of the directions ``ahead``.

    Of a convex shape the nearest one is the nearest of all, or lies on the edge of the cone.
    """
    way = _nearest(shape, eye) - eye
    near = np.where((way * np.conj(ahead)).real >= np.cos(half) * abs(way), abs(way), np.inf)
    for side in (-half, half):
        near = np.minimum(near, _along(shape, eye, ahead * np.exp(1j * side)))
    return near


def _nearest(shape, eye):
    """Return the points (k,) of a shape that are nearest to the points ``eye`` (k,)."""
    if isinstance(shape, tuple):
        middle, radius = shape
        out = eye - middle
        return middle + out * np.minimum(1.0, radius / np.maximum(abs(out), 1e-300))
    a, b = _sides(shape)
    side, from_side = b - a, _from_sides(shape, eye)
    along = from_side.real / np.hypot(side.real, side.imag) ** 2
    feet = a + np.clip(along, 0.0, 1.0) * side
    found = feet[abs(feet - eye).argmin(axis=0), np.arange(len(eye))]
    return np.where((from_side.imag >= 0.0).all(axis=0), eye, found)


def _sides(corners):
    """Return where the sides between ``corners`` (4,) begin and end, (4, 1)."""
    return corners[:, np.newaxis], corners[[1, 2, 3, 0], np.newaxis]


def _from_sides(corners, eye):
    """Return points ``eye`` (k,) in the axes of each side, from its begin, times its length, (4, k)."""
    return np.array([(eye - a) * np.conj(b - a) for a, b in zip(corners, corners[[1, 2, 3, 0]])])


def _along(shape, eye, ahead):
    """Return the distances (k,) [m] from ``eye``, (k,) or one, along ``ahead`` to a shape; inf if none."""
    if isinstance(shape, tuple):
        middle, radius = shape
        to = (middle - eye) * np.conj(ahead)
        chord = np.sqrt(np.maximum(radius**2 - to.imag**2, 0.0))
        meets = (abs(to.imag) <= radius) & (to.real + chord >= 0.0)
        return np.where(meets, np.maximum(to.real - chord, 0.0), np.inf)
    a, b = _sides(shape)
    first, last = (a - eye) * np.conj(ahead), (b - eye) * np.conj(ahead)
    with np.errstate(all="ignore"):
        far = first.real - first.imag * (last.real - first.real) / (last.imag - first.imag)
    meets = (first.imag * last.imag <= 0.0) & (first.imag != last.imag) & (far >= 0.0)
    inside = (_from_sides(shape, eye).imag >= 0.0).all(axis=0)
    return np.where(inside, 0.0, np.where(meets, far, np.inf).min(axis=0))


def _turned(angle):
    """Return an ``angle`` [rad] from -pi to pi."""
    return np.angle(np.exp(1j * angle))


def pairs(velocities):
    """Return complex ``velocities`` (n,) as (n, 2)."""
    return np.array([[each.real, each.imag] for each in velocities])


def locals_of(record, name, answer):
    """Yield ``(row, u)`` of a law by which each robot answers ``answer(robot, reading)``, complex.

    In the robot's own frame [m/s]; ``reading`` is None before the first.
    """
    for row in record.rows:
        samples, readings = record.readings(name, row)
        if any(k >= 0 and reading is None for k, reading in zip(samples, readings)):
            continue
        headings = [record.pose(row, robot)[1] for robot in range(len(readings))]
        own = [answer(robot, reading) for robot, reading in enumerate(readings)]
        yield row, pairs(np.exp(1j * np.array(headings)) * own)
