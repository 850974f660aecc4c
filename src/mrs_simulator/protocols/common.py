"""Conditions and tracks shared by several protocols."""

import numpy as np

from mrs_simulator.core.claims import Claim, Condition, decay_rate, decreases
from mrs_simulator.core.spectra import stable_step

AGREED = 0.02  # [m] from the predicted point of agreement, at the end of a run
REST = 0.02  # [m] from its place at most, where friction lets a robot with masses and wheels rest
LEAST_DECAY = 20.0  # [-] times that: what rests bends a rate by a twentieth at most
DECAY = "decay rate of the disagreement [1/s]"
SHARE = "decay rate over the exact solution's [-]"


def spanning_tree(topology):
    """Return the condition that all robots receive, directly or over others, from one."""
    return Condition(
        "spanning tree",
        topology.has_spanning_tree(),
        "no robot reaches all, not even over others",
        necessary=True,
    )


def below(name, value, bound, necessary=False):
    """Return the condition ``value < bound``, called ``name``; ``necessary`` as in ``Condition``."""
    why = "{:.4g} against {:.4g}".format(value, bound)
    return Condition(name, bool(value < bound), why, necessary=necessary)


def attracting(gain, why="robots are driven apart"):
    """Return the condition ``gain > 0``; ``why`` theory says that the protocol fails without it."""
    return Condition("gain above 0", gain > 0.0, why, necessary=True)


def gain_conditions(gain, period, eigenvalues):
    """Return the conditions that ``gain`` neither drives apart nor overshoots at ``eigenvalues``."""
    step = stable_step(eigenvalues)
    return [attracting(gain), below("gain Tc < 2/lambda_max", gain * period, step, necessary=True)]


def resting(control, robots):
    """Return down to which norm [m] of the errors of ``robots`` a rate shows, for ``claims.rate``.

    0 without friction; None where robots with forces do not stand on wheels.
    """
    if control.fidelity != "dynamic":
        return 0.0
    if any(group.drive.MEDIUM != "ground" for group in control.team.groups):
        return None
    return LEAST_DECAY * REST * np.sqrt(robots)


def falls(energy, name, tolerance=1e-6, free=False):
    """Return the claim that the ``energy`` of a gradient law never grows, in a list; [] without one."""
    return [] if energy is None else [decreases(energy.values, name, tolerance, free)]


def all_hold(conditions):
    """Return whether the theorem speaks of this run."""
    return all(condition.holds for condition in conditions)


def commands_by(time, period):
    """Return how many commands have run out by ``time`` (m,) [s], (m,); one each ``period`` [s]."""
    return np.floor(np.asarray(time) / period + 1e-6).astype(int)


def held_track(points, time, period):
    """Return the track (m, n, d) [m] at ``time`` (m,) [s] of the ``points`` of successive commands.

    Between two commands hand points move on straight lines.
    """
    count, before = np.asarray(time) / period, commands_by(time, period)
    knots = np.array([point for _, point in zip(range(int(before.max()) + 2), points)])
    share = np.maximum(count - before, 0.0)[:, np.newaxis, np.newaxis]
    return (1.0 - share) * knots[before] + share * knots[before + 1]


def decays_as(exact, of, tolerance=0.02):
    """Claim that the quantity ``of`` decays at the rate that ``exact(start, time)`` shows meanwhile.

    The eigenvalue alone shows in no run where modes nearly coincide, oscillate or come in turns.
    """
    size = lasting(of)

    def share(run):
        track = exact(run.hand[0], run.time - run.time[0])
        measured, theory = (decay_rate(run.time, size(hand)) for hand in (run.hand, track))
        return measured / theory if measured and theory else None

    return Claim(SHARE, 1.0, tolerance, share, free=True)


def level(points, dimension):
    """Return ``points`` (..., 2) of the plane at height 0 where there are three coordinates, (..., d)."""
    points = np.asarray(points, dtype=float)
    lacking = dimension - points.shape[-1]
    return points if not lacking else np.pad(points, [(0, 0)] * (points.ndim - 1) + [(0, lacking)])


def lasting(quantity):
    """Return the quantity's largest value from each sample on: the envelope of what oscillates."""
    return lambda hand: np.maximum.accumulate(quantity(hand)[::-1])[::-1]
