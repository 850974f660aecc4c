"""All sensors of a team: the active ones are read when they are due, the others never."""

import functools
import itertools
from collections import deque
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.core.step_rates import rate_note, steps_between
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.noise import Draws, Streams
from mrs_simulator.sensors.readings import frozen
from mrs_simulator.sensors.scenery import Scenery
from mrs_simulator.sensors.types import TYPES

LATE = 1e-9  # [s] by which a reading may be later than its latency, for rounding


class SensorError(ValueError):
    """A sensor that a robot lacks; the message names both."""

    page = "docs/sensors.md#which-sensors-a-robot-has"


class Suite:
    """The sensors of the robots of one run."""

    def __init__(self, team, mounts, obstacles=(), seed=0, step=0.02, picture=None):
        """``mounts``: of each robot, as of ``fitted_mounts``; ``step`` [s] of the world.

        ``picture``: renders what cameras see, see ``Scenery``.
        """
        self._picture = picture
        self._team, self.mounts, self._step = team, mounts, step
        self._obstacles, self._scenery = tuple(obstacles), None
        self._fitted = [
            _SensorGroup(*each, team, seed, step) for each in _groups_of_equal_mounts(team, mounts)
        ]
        self._active, self._looking_back = [], []
        self._running = [fitted for fitted in self._fitted if fitted.always_read]
        self._begun = 0
        self._forget()

    @classmethod
    def of_scenario(cls, scenario, team, obstacles=None, picture=None):
        """Return the sensors of ``team``, the robots of ``scenario``.

        ``obstacles``: by default those of the scenario.  Raises ``ScenarioError`` for impossible sensors.
        """
        mounts = fitted_mounts(team, scenario.sensors)
        obstacles = scenario.obstacles if obstacles is None else obstacles
        return cls(team, mounts, obstacles, scenario.seed, scenario.step, picture)

    @property
    def is_idle(self):
        """Return whether no sensor is read."""
        return not self._running

    def activate(self, wanted):
        """Read the sensors ``wanted``, ``{row: names}``, from now on, and no others.

        Raises ``SensorError`` for one that a robot lacks.
        """
        for row, names in wanted.items():
            check_fitted(self.mounts[row], names, row + 1, self._team.kinds[row])
        for fitted in self._fitted:
            fitted.is_active = any(
                fitted.mount.name in wanted.get(row, ()) for row in fitted.rows.tolist()
            )
        self._active = [fitted for fitted in self._fitted if fitted.is_active]
        self._running = [f for f in self._fitted if f.is_active or f.always_read]
        self._forget()
        self._looking_back = [fitted for fitted in self._active if fitted.looks_back]
        if self._active and self._scenery is None:
            self._scenery = Scenery(self._team, self._obstacles, self._picture)

    def activate_from(self, wanted, step, state):
        """Activate sensors as :meth:`activate` at the world's ``step``, and read newly active ones at once.

        ``state()`` returns the ``State`` then.  A reading between two samples of a sensor has the noise of
        the last one.  A sensor that needs the step before has no reading yet; one that is always read
        returns its last.
        """
        before = self._active
        self.activate(wanted)
        for fitted in self._active:
            if fitted not in before:
                if not fitted.always_read:
                    fitted.begin()
                if fitted.newest is None or not fitted.always_read:
                    fitted.take(step - self._begun, state(), self._scenery)
        self._is_settled = False

    def _forget(self):
        """Forget which readings were returned."""
        self._returned = None  # readings of the sensors, and what is made of them
        self._is_settled = False  # whether these stay the newest until a sensor is read

    @property
    def active(self):
        """Return the active sensors: each has ``mount``, ``rows`` and ``known(time)``."""
        return list(self._active)

    def begin(self, step=0):
        """Begin a run at the world's ``step``, from which samples are counted, without any readings."""
        self._begun = step
        self._forget()
        for fitted in self._fitted:
            fitted.begin()

    def update(self, step, state):
        """Read what is due at the world's ``step``; ``state()`` returns the ``State`` then."""
        elapsed = step - self._begun
        due = [fitted for fitted in self._running if elapsed % fitted.steps == 0]
        if due:
            now, self._is_settled = state(), False
            for fitted in due:
                fitted.take(elapsed, now, self._scenery)
        for fitted in self._looking_back:
            if (elapsed + 1) % fitted.steps == 0:
                fitted.before = elapsed, state()
        return [fitted for fitted in due if fitted.is_active]

    def next_due(self, step):
        """Return the step after ``step`` at which :meth:`update` does something next; inf where never."""
        elapsed = step - self._begun
        due = [fitted.steps - elapsed % fitted.steps for fitted in self._running]
        due += [fitted.steps - (elapsed + 1) % fitted.steps for fitted in self._looking_back]
        return step + min(due, default=np.inf)

    def readings(self, time):
        """Return the newest readings at ``time`` [s], ``{row: {name: reading}}``, after their latencies.

        A name is absent before its first reading.  Without new readings the same mapping is returned.
        """
        if self._is_settled:
            return self._returned[1]
        known = [fitted.known(time) for fitted in self._active]
        if self._returned is None or any(a is not b for a, b in zip(known, self._returned[0])):
            result = {row: {} for row in range(self._team.n)}
            for fitted, reading in zip(self._active, known):
                if reading is not None:
                    name, rows = fitted.mount.name, fitted.rows.tolist()
                    for row, own in zip(rows, of_robots(reading, len(rows))):
                        result[row][name] = own
            self._returned = known, result
        self._is_settled = not any(fitted.is_waiting for fitted in self._active)
        return self._returned[1]

    @property
    def notes(self):
        """Return notes on rates that are no multiple of the world's step, a list of texts."""
        return self._rate_notes(self._fitted)

    @property
    def active_notes(self):
        """Return the ``notes`` on active sensors."""
        return self._rate_notes(self._active)

    def _rate_notes(self, sensors):
        names = ["robot{}: {}".format(each.rows[0] + 1, each.mount.name) for each in sensors]
        rates = [each.mount.rate for each in sensors]
        notes = (rate_note(name, rate, self._step) for name, rate in zip(names, rates))
        return [note for note in notes if note]


class _SensorGroup:
    """One sensor of the robots that have equal mounts of it."""

    def __init__(self, mount, rows, team, seed, step):
        self.mount, self.rows = mount, rows
        self.sensor = TYPES[mount.type](mount, rows, team)
        self.steps = steps_between(mount.rate, step)
        self.is_active = False
        self.always_read = self.sensor.ALWAYS_READ
        self.looks_back = self.sensor.LOOKS_BACK
        streams = Streams(seed, (rows + 1).tolist(), mount.name, self.sensor.SEES_ROBOTS)
        self._draws = Draws(dict(mount.noise), streams, self.steps * step)
        self.begin()

    def begin(self):
        self._pending = deque()
        self.newest = self._known = self.before = self._taken = None
        self.sensor.begin()

    def take(self, elapsed, state, environment):
        """Read the sample at ``elapsed`` steps, once."""
        if self._taken == elapsed:
            return
        rng = self._draws.at(elapsed // self.steps)
        more = ()
        if self.looks_back:
            if self.before is None or self.before[0] != elapsed - 1:
                return  # it was not active then
            more = (self.before[1],)
        self.newest, self._taken = self.sensor.read(state, environment, rng, *more), elapsed
        if not self.is_active:
            self._pending.clear()  # always read, but nothing collects the readings
        self._pending.append(self.newest)

    @property
    def is_waiting(self):
        """Return whether there are readings whose latency was not over when :meth:`known` was called."""
        return bool(self._pending)

    def known(self, time):
        """Return the newest reading whose latency is over at ``time`` [s], or None."""
        while self._pending and self._pending[0].stamp + self.mount.latency <= time + LATE:
            self._known = self._pending.popleft()
        return self._known


def check_fitted(mounts, names, number, kind):
    """Raise ``SensorError`` for the first of ``names`` that the robot ``number`` has not."""
    known = [mount.name for mount in mounts]
    for name in names:
        if name not in known:
            owner = "sensors of robot{} ({})".format(number, kind.name)
            raise SensorError(unknown_name(owner, name, known))


def of_robot(reading, k):
    """Return the ``reading`` of the k-th of its robots; its arrays are not to be written to."""
    if hasattr(reading, "of"):
        return frozen(reading.of(k))
    own = {name: getattr(reading, name)[k] for name in reading.PER_ROBOT}
    return frozen(reading._replace(**own))


def of_robots(reading, count):
    """Return what :func:`of_robot` does of the first ``count`` robots, a list."""
    if hasattr(reading, "of"):
        return [of_robot(reading, k) for k in range(count)]
    frozen(reading)  # and with it the rows
    columns = (
        value if name in reading.PER_ROBOT else itertools.repeat(value, count)
        for name, value in zip(reading._fields, reading)
    )
    make = functools.partial(tuple.__new__, type(reading))  # as ``_make``, in a third of the time
    return list(map(make, zip(*columns)))


class _MountOfDrive(NamedTuple):
    mount: Any
    drive: str


def _groups_of_equal_mounts(team, mounts):
    """Yield each mount, with the rows (m,) of the robots of one drive that have it."""
    rows = {}
    for row, (kind, own) in enumerate(zip(team.kinds, mounts)):
        for mount in own:
            rows.setdefault(_MountOfDrive(mount, kind.drive), []).append(row)
    for key, found in rows.items():
        yield key.mount, np.array(found)
