"""Mismatch between robots and their data in following commands, as found by ``report --compare``.

    v(t) = speed v_command(t - delay),    omega(t) = speed/track omega_command(t - delay)

``speed``: true over nominal radius of the wheels; ``track``: true over nominal track.
"""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.scenario.reading import ScenarioError, Section, number, shown

LONGEST = 2.0  # [s] of a delay
SCALES = (0.2, 5.0)  # [-] least and most of a factor


class Mismatch(NamedTuple):
    """One value for all robots, or one for each."""

    delay: Tuple[float, ...] = (0.0,)  # [s]
    speed: Tuple[float, ...] = (1.0,)  # [-]
    track: Tuple[float, ...] = (1.0,)  # [-]

    def with_robots(self, n):
        """Return the mismatch of n robots: added ones have the last one's values."""
        return Mismatch(*(values if len(values) == 1 else _cut(values, n) for values in self))

    def to_plain(self):
        """Return the mapping that a scenario holds."""
        return {
            name: values[0] if len(values) == 1 else list(values)
            for name, values in self._asdict().items()
        }


NO_MISMATCH = Mismatch()


def _cut(values, n):
    return (values + (values[-1],) * n)[:n]


def read_mismatch(content, where, n):
    """Return the ``Mismatch`` in the mapping ``content``; ``ScenarioError`` if it is none."""
    section = Section(content, where)
    low, high = SCALES
    mismatch = Mismatch(
        _read(section, "delay", n, 0.0, 0.0, LONGEST),
        _read(section, "speed", n, 1.0, low, high),
        _read(section, "track", n, 1.0, low, high),
    )
    section.done()
    return mismatch


def _read(section, key, n, default, low, high):
    given = section.take(key, default)
    if not isinstance(given, list):
        return (number(given, section.at(key), low=low, high=high),)
    if len(given) != n:
        raise ScenarioError(
            "{}: {}, wanted a number, or {}".format(section.at(key), shown(given), n)
        )
    places = ["{}[{}]".format(section.at(key), row) for row in range(n)]
    return tuple(number(value, place, low=low, high=high) for value, place in zip(given, places))


class CommandMismatch:
    """The commands that robots follow, delayed and scaled, step by step."""

    def __init__(self, mismatch, axes, n, step):
        """``axes``: names of the commands' components; ``step`` [s]."""
        speed, track = np.asarray(mismatch.speed), np.asarray(mismatch.track)
        scales = [speed if axis.startswith("linear") else speed / track for axis in axes]
        self._factor = np.stack([np.broadcast_to(scale, n) for scale in scales], axis=1)
        self._late = np.broadcast_to(np.round(np.array(mismatch.delay) / step).astype(int), n)
        self._commands = np.zeros((int(self._late.max()) + 1, n, len(axes)))
        self._rows, self._count = np.arange(n), 0

    def applied(self, command):
        """Return the command that acts in this step, (n, a), while ``command`` (n, a) is in force."""
        self._commands[self._count % len(self._commands)] = command
        when = (self._count - self._late) % len(self._commands)
        self._count += 1
        return self._factor * self._commands[when, self._rows]
