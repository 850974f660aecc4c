"""What sensors read, recorded beside ``run.csv``: one file for each that ``record`` of a scenario names.

``sensor_NAME.csv`` has a row for each sample of each robot, of a range-bearing sensor for each robot that
was seen: ``time`` [s] of the measurement since the run began, ``robot``, and the reading's values.
"""

import os
from typing import NamedTuple, Optional, Tuple

import numpy as np

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.core.writing import Blocks
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.sensors.suite import Suite, of_robot
from mrs_simulator.sensors.types import TYPES

FILE = "sensor_{}.csv"  # by the sensor's name
SIZES = {9: 11.0, 15: 18.0}  # [bytes] of a value with so many digits, about
WHO, NUMBER = 8.0, 2.5  # [bytes] of time and robot, about, and of the number of one that was seen
MEGABYTE = 1e6  # [bytes]


class Recorded(NamedTuple):
    """One sensor that is recorded."""

    name: str
    columns: Tuple[str, ...]
    digits: int
    numbered: bool  # whether the first column is the number of what was seen
    robots: Tuple[int, ...]  # numbers
    rate: float  # [Hz] of all robots together
    most: int = 1  # [-] rows of one sample at most: robots, or beacons, that may be seen
    # [bytes] of one robot's where robots begin, None: all values are long
    sample: Optional[float] = None

    def largest(self, duration):
        """Return about how many bytes ``duration`` [s] take at most."""
        row = WHO + SIZES[self.digits] * len(self.columns)
        if self.numbered:
            row += NUMBER - SIZES[self.digits]
        return self._samples(duration) * row * self.most

    def size(self, duration):
        """Return about how many bytes ``duration`` [s] take, where sensors go on to see as at the start."""
        largest = self.largest(duration)
        return largest if self.sample is None else self._samples(duration) * self.sample

    def _samples(self, duration):
        """Return how many samples of a robot are taken in ``duration`` [s], its beginning included."""
        return self.rate * duration + len(self.robots)

    def summary(self, duration):
        """Return in words what is recorded in ``duration`` [s], and how much it is."""
        if not self.columns:
            return "record: pictures of {} are in bags alone".format(self.name)
        text = "{}: {} robots, {} values at {:g} Hz for {:g} s: about {:.2g} MB"
        values, size = len(self.columns), self.size(duration) / MEGABYTE
        file, rate = FILE.format(self.name), self.rate / len(self.robots)
        summary = text.format(file, len(self.robots), values, rate, duration, size)
        if self.most == 1:
            return summary
        most = self.largest(duration) / MEGABYTE
        return "{} if as many are seen as at the start, at most {:.2g} MB".format(summary, most)


def recorded_sensors(names, mounts, kinds):
    """Return the ``Recorded`` of the sensors ``names``; ``mounts``, ``kinds``: of each robot.

    Raises ``ScenarioError`` for one that no robot has.
    """
    known = {mount.name for own in mounts for mount in own}
    result = []
    for name in names:
        if name not in known:
            raise ScenarioError(unknown_name("record", name, known))
        own = [
            (row + 1, mount, kinds[row])
            for row, fitted in enumerate(mounts)
            for mount in fitted
            if mount.name == name
        ]
        _check_alike(name, own)
        columns = max((columns_of(mount, kind) for _, mount, kind in own), key=len)
        sensor = TYPES[own[0][1].type]
        robots, rate = tuple(number for number, _, _ in own), sum(mount.rate for _, mount, _ in own)
        seen = max(sensor.most(mount.settings, len(mounts)) for _, mount, _ in own)
        result.append(
            Recorded(name, columns, sensor.DIGITS, bool(sensor.LISTS), robots, rate, seen)
        )
    return result


def _check_alike(name, own):
    """Raise ``ScenarioError`` if mounts ``own`` (number, mount, kind) of one name are of several types."""
    (first, mount, _), *others = own
    for number, other, _ in others:
        if other.type != mount.type:
            text = (
                "record: {} of robot{} is a {}, and of robot{} a {}; wanted one type for one file"
            )
            raise ScenarioError(text.format(name, first, mount.type, number, other.type))


def columns_of(mount, kind):
    """Return the names of the values of a ``mount`` on a robot of ``kind``, () for pictures."""
    sensor = TYPES[mount.type]
    columns = [
        "{}{}".format(name, k + 1) if width > 1 else name
        for name, width in sensor.columns(mount.settings, kind).items()
        for k in range(width)
    ]
    return (sensor.LISTS, *columns) if sensor.LISTS else tuple(columns)


def lines_of(sensor, number, time, reading):
    """Return the lines of a ``reading`` of a ``Recorded`` of robot ``number``, at ``time`` [s]."""
    fields = [np.ravel(getattr(reading, field)) for field in reading.PER_ROBOT]
    if sensor.numbered:  # one row for each that was seen
        rows = zip(reading.numbers.tolist(), *(field.tolist() for field in fields))
    else:
        rows = [np.concatenate(fields).tolist()]
    begin = "{!r},{}".format(round(float(time), 9), number)
    return [_line(begin, row, sensor) for row in rows]


def _line(begin, row, sensor):
    form = ",%.{}g".format(sensor.digits) * len(row)
    return begin + form % tuple(row) + "," * (len(sensor.columns) - len(row)) + "\n"


class SensorFiles:
    """The files of one run; samples that a full disk cannot take are lost and counted."""

    def __init__(self, sensors, out):
        """``sensors``: ``Recorded`` each; ``out``: the directory."""
        self._sensors = {each.name: each for each in sensors}
        self._files = {
            each.name: Blocks(
                os.path.join(out, FILE.format(each.name)),
                ",".join(("time", "robot", *each.columns)) + "\n",
            )
            for each in sensors
            if each.columns
        }

    def add(self, name, number, time, reading):
        """Append the ``reading`` of the sensor ``name`` of robot ``number``, measured at ``time`` [s]."""
        self._files[name].add(lines_of(self._sensors[name], number, time, reading))

    def warnings(self):
        """Return what is not in the files and why, a list of texts."""
        text = "{}: {} samples are missing: the disk was full"
        return [text.format(f.path, f.lost) for f in self._files.values() if f.lost]

    def flush(self):
        """Write what waits."""
        for file in self._files.values():
            file.flush()

    def close(self):
        """Write what waits and close the files."""
        for file in self._files.values():
            file.close()


class SensorRecorder:
    """Reads and records the sensors that a scenario names, beside any other reader of them."""

    def __init__(self, sensors, scenario, world, out):
        """``sensors``: ``Recorded`` each, of ``scenario``; ``out``: the directory."""
        self._suite = Suite.of_scenario(scenario, *world.senses)
        wanted = {}
        for each in sensors:
            for number in each.robots if each.columns else ():
                wanted.setdefault(number - 1, set()).add(each.name)
        self._suite.activate(wanted)
        self.files = SensorFiles(sensors, out)
        self._written = {}

    def update(self, step, world):
        """Read and write what is due at the world's ``step``."""
        self._suite.update(step, world.sensed)
        for sensor in self._suite.active:
            # also what is known later: its stamp is that of the measurement
            reading = sensor.newest
            if reading is not None and reading is not self._written.get(sensor):
                self._written[sensor] = reading
                for k, row in enumerate(sensor.rows.tolist()):
                    own = of_robot(reading, k)
                    self.files.add(sensor.mount.name, row + 1, reading.stamp, own)
