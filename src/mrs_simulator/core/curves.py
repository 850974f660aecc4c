"""What a protocol has drawn of a run beside what theory says of it: energies, connectivity, peaks."""

from typing import Any, NamedTuple

import numpy as np


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
    """A Lyapunov function ``value`` of hand points (n, 2) and its ``dissipation``, both one number.

    Along the exact law ``V' = -dissipation <= 0``.  Both stand here by themselves: neither calls the
    law.  ``name``: with the unit.
    """

    name: str
    value: Any
    dissipation: Any


def energy_curve(energy, run):
    """Return the ``Curve`` of ``energy`` along ``run`` beside ``V(0)`` less what was dissipated.

    Predicted: ``V(0) - integral of the dissipation`` over the measured hand points, by trapezoids.
    """
    time = run.time - run.time[0]
    values = np.array([energy.value(hand) for hand in run.hand])
    spent = np.array([energy.dissipation(hand) for hand in run.hand])
    return Curve(energy.name, time, values, values[0] - integral(time, spent), log=False)


def integral(time, values):
    """Return the integral of ``values`` (m,) over ``time`` (m,) up to each sample, by trapezoids, (m,)."""
    steps = 0.5 * (values[1:] + values[:-1]) * np.diff(time)
    return np.concatenate([[0.0], np.cumsum(steps)])


def energy_residual(energy, run, period):
    """Return the largest residual of the energy's balance over the run and what it may be, [-] of V(0).

    The residual is ``|V(t) - V(0) + integral of the dissipation|``.  It may be what sampling costs:
    commands that are held for ``period`` [s] act on where robots were, at most ``period`` times the
    largest dissipation, and trapezoids miss a third of what they lose on every other sample.
    """
    curve = energy_curve(energy, run)
    scale = max(abs(float(curve.measured[0])), 1e-12)
    residual = float(np.abs(curve.measured - curve.predicted).max()) / scale
    spent = np.array([energy.dissipation(hand) for hand in run.hand])
    coarse = integral(curve.at[::2], spent[::2])
    fine = integral(curve.at, spent)[::2]
    quadrature = float(np.abs(coarse - fine).max(initial=0.0)) / 3.0
    allowed = (period * float(spent.max(initial=0.0)) + 2.0 * quadrature) / scale
    return residual, allowed + 1e-9
