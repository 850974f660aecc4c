"""Mismatch between robots and their data in following commands, as found by ``report --compare``.

    v(t) = speed v_command(t - delay),    omega(t) = speed/track omega_command(t - delay)

``speed``: true over nominal radius of the wheels, 0 for a dead robot; ``track``: true over nominal track.
"""

import numpy as np

from mrs_simulator.core.fields import EACH, Field
from mrs_simulator.scenario.reading import Section, record

SCALES = {"low": 0.2, "high": 5.0}  # [-] bounds of a factor
MISMATCH = (
    Field(
        "delay",
        (0.0,),
        "s",
        low=0.0,
        high=2.0,
        type=EACH,
        rule="0 s",
        meaning="by which commands are obeyed late, rounded to whole steps",
    ),
    Field(
        "speed",
        (1.0,),
        low=0.0,
        high=SCALES["high"],
        type=EACH,
        rule="1",
        meaning="true over nominal radius of wheels: speeds are so many times as large; 0: a dead robot",
    ),
    Field(
        "track",
        (1.0,),
        **SCALES,
        type=EACH,
        rule="1",
        meaning="true over nominal track: turn rates are `speed/track` times as large",
    ),
)


class Mismatch(record("Mismatch", MISMATCH)):
    """``delay`` [s], ``speed`` and ``track`` [-]: a tuple of one value for all robots, or one for each."""

    __slots__ = ()

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


def read_mismatch(top, others):
    """Return the ``Mismatch`` under ``mismatch`` of ``top``; ``ScenarioError`` if it is none."""
    section = Section(top.take("mismatch", {}), top.at("mismatch"), top.n)
    values = section.values(MISMATCH).values()
    return Mismatch(*((value,) if isinstance(value, float) else value for value in values))


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
