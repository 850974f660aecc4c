"""Rates of the robots' odometry: one for all, or each kind's own."""

import numpy as np

from mrs_simulator.core.step_rates import rate_note, steps_between

OF_KINDS = "kinds"  # the rate that means each kind's own
MOST_NAMED = 5  # [-] robots that the notes name


def odometry_steps(team, rate, step):
    """Return the steps between two odometries of each robot of ``team``, (n,) whole numbers.

    ``rate`` [Hz] of all robots, or ``OF_KINDS``; ``step`` [s].  The nearest whole number of steps, at
    least one: :func:`odometry_notes` says where that is another rate.
    """
    wanted = _wanted(team, rate)
    return np.array([steps_between(rate, step) for rate in wanted.tolist()])


def odometry_notes(team, rate, step):
    """Return notes on rates that whole steps of ``step`` [s] cannot keep, a list of texts."""
    if rate is None:
        return []
    rates = enumerate(_wanted(team, rate).tolist(), 1)
    notes = [rate_note("robot{}: odometry".format(number), each, step) for number, each in rates]
    notes = [note for note in notes if note]
    more = len(notes) - MOST_NAMED
    return notes[:MOST_NAMED] + (["and of {} more robots".format(more)] if more > 0 else [])


def _wanted(team, rate):
    if rate == OF_KINDS:
        return np.array([kind.odometry_rate for kind in team.kinds], dtype=float)
    return np.full(team.n, float(rate))


class OdometrySchedule:
    """When each robot publishes odometry, every so many steps since a common start."""

    def __init__(self, steps):
        """``steps`` (n,): as of :func:`odometry_steps`."""
        self._steps = np.asarray(steps, dtype=int)
        self._alike = bool((self._steps == self._steps[0]).all())
        self._rows = np.arange(len(self._steps))

    @property
    def shortest(self):
        """Return the least number of steps between two odometries of a robot."""
        return int(self._steps.min())

    def due(self, elapsed):
        """Return the rows of the robots due ``elapsed`` steps after the start, (m,)."""
        if self._alike:
            return self._rows if elapsed % int(self._steps[0]) == 0 else self._rows[:0]
        return self._rows[elapsed % self._steps == 0]
