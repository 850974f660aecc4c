"""What a protocol has drawn of a run beside what theory says of it: energies, connectivity, peaks."""

from typing import Any, NamedTuple

import numpy as np

NOTHING = 1e-9  # [-] an energy that begins with less cannot be balanced


class Curve(NamedTuple):
    """A measured curve and the predicted one, for the figure ``certificates``.

    ``name``: with its unit; ``at`` (m,): what it is drawn against, called ``across``; ``measured``
    (m,); ``predicted`` (m,) or None; ``bound``: a number that theory says is never passed, or None;
    ``log``: on a logarithmic axis; ``points``: measured is drawn as points, as of one number for each
    robot; ``predicted_at`` (p,): where ``predicted`` is, if it is not where the measured curve is.
    """

    name: str
    at: Any
    measured: Any
    predicted: Any = None
    bound: Any = None
    across: str = "time [s]"
    log: bool = False
    points: bool = False
    predicted_at: Any = None


class Energy(NamedTuple):
    """A Lyapunov function ``value`` of points (n, d) and its ``dissipation``, both one number.

    Along the exact law ``V' = -dissipation <= 0``.  Both stand here by themselves: neither calls the
    law.  ``name``: with the unit.  Those of a ``moving`` thing are functions of points (n, d) [m],
    velocities (n, d) [m/s] and the time [s] since the start.  ``stacks``: both also take the points
    (k, n, d) of k states, and return (k,).
    """

    name: str
    value: Any
    dissipation: Any
    moving: bool = False
    stacks: bool = False

    def of(self, hand, velocity, time):
        """Return the value in that state."""
        return self.value(hand, velocity, time) if self.moving else self.value(hand)

    def spent(self, hand, velocity, time):
        """Return the dissipation in that state."""
        return self.dissipation(hand, velocity, time) if self.moving else self.dissipation(hand)

    def values(self, hand, velocity=None, time=None):
        """Return the values (k,) in the states ``hand``, ``velocity`` (k, n, d) and ``time`` (k,)."""
        return self._over(self.value, hand, velocity, time)

    def losses(self, hand, velocity, time):
        """Return the dissipations (k,) in these states."""
        return self._over(self.dissipation, hand, velocity, time)

    def _over(self, function, *states):
        if self.stacks:
            return np.asarray(function(*states if self.moving else states[:1]), dtype=float)
        each = zip(*states) if self.moving else zip(states[0])
        return np.array([function(*state) for state in each], dtype=float)


def integral(time, values):
    """Return the integral of ``values`` (m,) over ``time`` (m,) up to each sample, by trapezoids, (m,)."""
    steps = 0.5 * (values[1:] + values[:-1]) * np.diff(time)
    return np.concatenate([[0.0], np.cumsum(steps)])


class Balance(NamedTuple):
    """What an energy was, and what theory makes of it, over the samples ``rows`` of a run."""

    rows: Any  # (k,) of the run's samples
    measured: Any  # (k,)
    predicted: Any  # (k,) from the first on
    allowed: float  # [-] of ``scale``, by which the robots alone may set them apart
    scale: float  # the energy where the theory begins, 0 where it says nothing
    free: bool = False  # whether it is of unlimited inputs throughout, not of those commands alone

    def since(self, first):
        """Return the balance from the sample ``first`` of the run on."""
        kept = self.rows >= first
        rows, measured = self.rows[kept], self.measured[kept]
        return self._replace(rows=rows, measured=measured, predicted=self.predicted[kept]).anew()

    def anew(self):
        """Return this curve with a prediction that begins at its first sample."""
        if not len(self.rows):
            return self
        off = self.measured[0] - self.predicted[0]
        return self._replace(predicted=self.predicted + off, scale=abs(float(self.measured[0])))

    @property
    def residual(self):
        """Return the largest difference, [-] of ``scale``; None where that is nothing."""
        if not len(self.rows) or self.scale <= NOTHING:
            return None
        return float(np.abs(self.measured - self.predicted).max()) / self.scale


def dissipated(time, values, spent, period):
    """Return the ``Balance`` of an energy with ``V(0)`` less the integral of its dissipation.

    ``values`` and ``spent``: both in all samples ``time``, (m,) each.  Allowed is what sampling costs:
    commands that are held for ``period`` [s] act on where robots were, at most ``period`` times the largest
    dissipation, and trapezoids miss a third of what they lose on every other sample.
    """
    lost = integral(time, spent)
    coarse = integral(time[::2], spent[::2])
    quadrature = float(np.abs(coarse - lost[::2]).max(initial=0.0)) / 3.0
    scale = abs(float(values[0]))
    allowed = (period * float(spent.max(initial=0.0)) + 2.0 * quadrature) / max(scale, NOTHING)
    rows = np.arange(len(time))
    return Balance(rows, values, values[0] - lost, allowed + 1e-9, scale, free=True)
