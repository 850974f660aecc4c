"""The balance of a run's energy: what it was, and what theory makes of it."""

import numpy as np

from mrs_simulator.control.laws.exactness import at_limit
from mrs_simulator.control.laws.published import MOST_PAIRS, on_arcs
from mrs_simulator.core.curves import NOTHING, Balance, dissipated
from mrs_simulator.core.kinematics import hand_points

MOST_ROBOTS = 500  # [-] whose dense matrices of weights are built
WHOLE = 1e-6  # [-] of a command period by which a sample may be beside a command
LAG = 0.1  # [s] by which robots with masses and motors are late
ROUNDING = 1e-6  # [-] of the energy at the start: sums in another order
DIGITS = 1e-14  # [-] of the largest energy: what is left of its digits where it grows


def balance_of(control, energy, run):
    """Return the ``Balance`` of ``energy`` over ``run``.

    Where the law is published theory gives the energy's change under each held command: the published
    velocities u, held for ``Tc``, take it from ``V(p)`` to ``V(p + Tc u)``, which is ``Tc grad V^T u`` and
    the terms of higher order.  Each sample begins anew where the robots are; where one is at a limit the
    change is what it was, since theory is of unlimited inputs.  Without a published law, or where that
    is too long to compute, the dissipation along the measured path is added up.
    """
    law = control.published() if len(run.robots) <= MOST_ROBOTS else None
    rows, velocity = samples_on_commands(control, run), control.velocities(run)
    time = run.time - run.time[0]
    if law is None or law.SEES == "pose" or len(rows) < 3 or _work(law, run, control) > MOST_PAIRS:
        return dissipated(energy, time, run.hand, velocity, control.period)
    states = [(run.hand[row], velocity[row], time[row]) for row in rows]
    commands = np.diff(np.round(time[rows] / control.period).astype(int))
    values = np.array([energy.of(*state) for state in states])
    after = [energy.of(*end) for end in _held(law, states, commands, control.period)]
    limited = _limited(control, run)[rows]
    ends = np.where(limited[:-1] | limited[1:], values[1:], after)
    changes = np.concatenate([[0.0], np.cumsum(ends - values[:-1])])
    cost = _robots_cost(control, energy, run, rows, states) + DIGITS * np.abs(values).max()
    allowed = ROUNDING + cost / max(abs(values[0]), NOTHING)
    return Balance(rows, values, values[0] + changes, allowed)


def _robots_cost(control, energy, run, rows, states):
    """Return what robots may make of the energy beside points, in its unit.

    Unicycles turn while a command is held, so that their points go on arcs; robots in water or air are
    late by the time constants of their controllers, all robots on full dynamics by ``LAG``.
    """
    if control.fidelity == "point_mass":
        return 0.0
    cost, period = 0.0, control.period
    if control.team.is_of_unicycles:
        commands = np.diff(np.round((run.time[rows] - run.time[0]) / period))
        for row, state, count in zip(rows, states, commands):
            pose, command = run.pose[row], run.command[row]
            after = hand_points(on_arcs(pose, command, period), control.l)
            straight = state[0] + period * state[1]
            cost += count * abs(energy.of(after, *state[1:]) - energy.of(straight, *state[1:]))
    lag = control.team.lateness + (LAG if control.fidelity == "dynamic" else 0.0)
    if lag:
        points, velocity, time = states[0]
        late = energy.of(points, velocity, time + lag)
        cost += abs(late - energy.of(points + lag * velocity, velocity, time + lag))
    return cost


def _limited(control, run):
    """Return in which samples some robot is at a limit, (m,) bool."""
    if control.saturation == "none":
        return np.zeros(len(run.time), dtype=bool)
    return at_limit(control, run.command).any(axis=1)


def samples_on_commands(control, run):
    """Return the samples, rows of ``run``, that fall on a command."""
    count = (run.time - run.time[0]) / control.period
    return np.flatnonzero(np.abs(count - np.round(count)) < WHOLE * np.maximum(count, 1.0))


def _work(law, run, control):
    """Return how many pairs of robots are looked at over all commands of ``run``."""
    return law.WORK * (run.time[-1] - run.time[0]) / control.period * len(run.robots) ** 2


def _held(law, states, commands, period):
    """Yield ``(points, velocity, time)`` that the ``law`` makes of each state after its ``commands``."""
    begun = memory = law.begin(states[0][0])
    for (points, velocity, time), count in zip(states, commands):
        if law.SEES == "next":  # what is held from here on is part of the state
            memory = law.resumed(velocity, begun)
        for step in range(count):
            if law.SEES == "next":
                points = points + period * velocity
                velocity, memory = law.velocity(points, time + (step + 1) * period, memory)
                continue
            if law.SEES == "now":
                memory = begun
            velocity, memory = law.velocity(points, time + step * period, memory)
            points = points + period * velocity
        yield points, velocity, time + count * period
