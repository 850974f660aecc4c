"""Which sensors each robot has: its kind's mounts, as the scenario changes them."""

import copy
import functools
import keyword
import math
import re
from typing import Any, NamedTuple, Tuple

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.scenario.reading import ScenarioError, unwanted
from mrs_simulator.sensors.noise import Noise, read_noise
from mrs_simulator.sensors.types import TYPES
from mrs_simulator.vehicles.quantities import QuantitySection, quantity

NAME = re.compile("[A-Za-z][A-Za-z0-9_]*")  # part of a topic, and an attribute
FARTHEST = 100.0  # [m] from the robot's centre
RATES = (0.01, 1000.0)  # [Hz]


class Mount(NamedTuple):
    """A sensor at its place on a robot; robots with equal ones are read together."""

    name: str
    type: str
    place: Tuple[float, ...]  # x, y, z [m], yaw [rad] in the robot's frame, z above its underside
    rate: float  # [Hz]
    noise: Tuple[Tuple[str, Noise], ...]  # by quantity
    settings: Any  # of the type

    @property
    def latency(self):
        """Return the time [s] from a measurement until all of it is known."""
        return max([noise.latency for _, noise in self.noise], default=0.0)


def fitted_mounts(team, changes=()):
    """Return the robots' ``Mount`` tuples, one for each robot, in the order in which they are declared.

    ``team``: their ``vehicles.Team``; ``changes``: ``SensorChange`` of the scenario.  Raises
    ``ScenarioError`` that names the entry.
    """
    found = {}
    result = []
    for row, kind in enumerate(team.kinds):
        meant = tuple(k for k, change in enumerate(changes) if change.concerns(row + 1))
        key = kind, meant
        if key not in found:
            found[key] = (
                _of_robot(kind, [changes[k] for k in meant], row + 1) if meant else _own(kind)
            )
        result.append(found[key])
    return tuple(result)


def spare_mounts(kind):
    """Return the ``Mount`` tuple of the places for sensors that a robot of ``kind`` has without one."""
    contents, where, off = _declared(kind)
    return tuple(read_mount(name, contents[name], where[name]) for name in contents if name in off)


@functools.lru_cache(maxsize=64)
def _own(kind):
    """Return the ``Mount`` tuple of a ``kind`` without changes."""
    return _of_robot(kind, (), 1)


def _of_robot(kind, changes, number):
    """Return the ``Mount`` tuple of a robot of ``kind`` after ``changes``."""
    contents, where, off = (copy.copy(each) for each in _declared(kind))
    for change in changes:
        for name, content in change.mounts.items():
            place = "{}.{}".format(change.where, name)
            if content is None:
                if name not in contents or name in off:
                    owner = "{}: robot{} ({})".format(place, number, kind.name)
                    raise ScenarioError(unknown_name(owner, name, set(contents) - off))
                off.add(name)
                continue
            contents[name], where[name] = _merged(contents.get(name, {}), content), place
            off.discard(name)
    mounts = []
    for name, content in contents.items():
        if name not in off:
            mounts.append(read_mount(name, content, where[name]))
            TYPES[mounts[-1].type].check(kind, where[name])
    return tuple(mounts)


@functools.lru_cache(maxsize=64)
def _declared(kind):
    """Return the mounts that a ``kind`` declares, their places for errors, and which are not fitted.

    They are not to be changed.
    """
    contents, where, off = {}, {}, set()
    for name, content in kind.mounts.items():
        place = where[name] = "{}: mounts.{}".format(kind.name, name)
        if content is None:  # a base's mount that this kind has not
            continue
        if not isinstance(content, dict):
            raise unwanted(place, content, "a mapping")
        contents[name] = {key: value for key, value in content.items() if key != "fitted"}
        if not QuantitySection(content, place).flag("fitted", True):
            off.add(name)
        read_mount(name, contents[name], place)  # all are checked, fitted or not
    return contents, where, off


def _merged(below, content):
    """Return ``content`` over that ``below``; one of another type or model takes nothing from it."""
    for key in ("type", "model"):
        if key in content and content[key] != below.get(key, content[key]):
            return dict(content) if key == "type" else dict({"type": below.get("type")}, **content)
    result = dict(below, **content)
    noise = below.get("noise"), content.get("noise")
    if all(isinstance(each, dict) for each in noise):
        result["noise"] = {**noise[0], **noise[1]}
    return result


def read_mount(name, content, where):
    """Return the ``Mount`` called ``name`` in the mapping ``content``; ``ScenarioError`` if it is none."""
    if not NAME.fullmatch(name) or keyword.iskeyword(name):
        raise unwanted(where, name, "letters, digits and _, and no word of Python's")
    section = QuantitySection(content, where)
    if not section.has("type"):
        raise ScenarioError(
            "{}: no such sensor to tune; a new one has a type, one of {}".format(
                where, ", ".join(sorted(TYPES))
            )
        )
    sensor = TYPES[section.text("type", choices=sorted(TYPES))]
    section = _of_model(section, sensor, content, where)
    mount = Mount(
        name,
        section.text("type"),
        _read_place(section),
        section.quantity("rate", "Hz", sensor.RATE, low=RATES[0], high=RATES[1]),
        _read_noise(section, sensor),
        sensor.settings(section),
    )
    section.done()
    return mount


def _of_model(section, sensor, content, where):
    """Return the section with what the named model of the sensor's type gives beneath it."""
    if not section.has("model"):
        section.take("model")
        return section
    known = sensor.MODELS
    name = section.text("model")
    if name not in known:
        raise ScenarioError(unknown_name(section.at("model"), name, known))
    section = QuantitySection({**known[name], **content}, where)
    section.take("model")
    return section


def _read_place(section):
    """Return x, y, z [m] and yaw [rad]."""
    given, where = section.take("place", [0.0, 0.0, 0.0]), section.at("place")
    if not isinstance(given, list) or len(given) != 3:
        raise unwanted(where, given, "[x, y, z]")
    place = [quantity(each, "m", where, low=-FARTHEST, high=FARTHEST) for each in given]
    return (*place, section.quantity("yaw", "rad", 0.0, low=-2.0 * math.pi, high=2.0 * math.pi))


def _read_noise(section, sensor):
    """Return the ``Noise`` of each quantity, over that of the sensor's type."""
    given, usual = section.section("noise"), sensor.NOISE
    if "" in sensor.QUANTITIES:  # of one quantity
        return (("", read_noise(given, sensor.QUANTITIES[""], usual.get("", Noise()))),)
    noise = tuple(
        (quantity, read_noise(given.section(quantity), unit, usual.get(quantity, Noise())))
        for quantity, unit in sensor.QUANTITIES.items()
    )
    given.done()
    return noise
