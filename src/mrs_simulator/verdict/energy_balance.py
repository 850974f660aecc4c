"""The balance of a run's energy: what it was, and what theory makes of it."""

import numpy as np

from mrs_simulator.core.sample_blocks import blocks
from mrs_simulator.protocols.curves import NOTHING, Balance, dissipated
from mrs_simulator.protocols.published.laws import MOST_PAIRS
from mrs_simulator.record.recording import part_of
from mrs_simulator.verdict.law.published_checks import (
    ESTIMATED,
    REBUILT,
    at_limit,
    samples_on_commands,
)

MOST_ROBOTS = 500  # [-] whose dense matrices of weights are built
ROUNDING = 1e-6  # [-] of the energy at the start: sums in another order
DIGITS = 1e-14  # [-] of the largest energy: what is left of its digits where it grows
# [-] of the energy that arcs and slip may cost where samples beside commands do not show it.
UNTOLD = {"kinematic": 0.01, "dynamic": 0.05}


def balance_of(control, energy, run):
    """Return the ``Balance`` of ``energy`` over ``run``.

    Where the law is published theory gives the energy's change under each held command: the published
    velocities u, held for ``Tc``, take it from ``V(p)`` to ``V(p + Tc u)``, which is ``Tc grad V^T u`` and
    the terms of higher order.  Each sample begins anew where the robots are; where one is at a limit, or
    in the dead band, the change is what it was, since theory is of unlimited inputs.  Allowed is what it
    takes to go elsewhere than the recorded commands say: on the arcs of held commands, late, or slipping.

    Without a published law, or where that is too long to compute, the dissipation along the measured
    path is added up; what robots make of their commands is allowed besides, as above.
    """
    law = control.published() if len(run.robots) <= MOST_ROBOTS else None
    rows = samples_on_commands(control, run)
    time = run.time - run.time[0]
    if law is None or law.SEES == "pose" or len(rows) < 3 or _work(law, run, control) > MOST_PAIRS:
        states = _States(control, run, np.arange(len(time)))
        balance = dissipated(
            time, states.give(energy.values), states.give(energy.losses), control.period
        )
        return balance._replace(allowed=balance.allowed + _untold(control, energy, run, rows))
    states = _States(control, run, rows)
    commands = states.commands
    values = states.give(energy.values)
    exactly = control.fidelity == "point_mass"
    after = _held(law, energy, states, control.period, exactly)
    limited = _limited(control, run)[rows]
    if control.deadband and law.SEES == "now":
        limited = limited | states.give(_stilled(law, run.hand[0]))
    free = ~(limited[:-1] | limited[1:])
    if commands.max() > 1:  # commands between two samples may be at a limit that neither shows
        free = free & np.append(True, free[:-1]) & np.append(free[1:], True)
    predicted = values[0] + _summed(np.where(free, after, values[1:]) - values[:-1])
    scale = abs(values[:-1][free][0]) if free.any() else 0.0
    cost = DIGITS * np.abs(values).max()
    if not exactly:
        cost += _robots_cost(energy, states, control.period, free)
    allowed = ROUNDING + cost / max(scale, NOTHING) + _estimated(run)
    if not exactly and law.SEES == "next":  # the law's velocities are rebuilt from samples
        allowed += REBUILT
    return Balance(rows, values, predicted, allowed, scale)


class _States:
    """Points (k, n, d), their velocities (k, n, d) and times (k,) in samples of a run, block by block."""

    def __init__(self, control, run, rows):
        self.control, self.run, self.rows = control, run, rows

    @property
    def commands(self):
        """Return how many commands lie between a sample and the next, (k - 1,)."""
        time = self.run.time[self.rows] - self.run.time[0]
        return np.diff(np.round(time / self.control.period).astype(int))

    def of(self, begin, end):
        """Return points, velocities and times of the samples from ``begin`` to before ``end``."""
        part = part_of(self.run, self.rows[begin:end])
        return part.hand, self.control.velocities(part), part.time - self.run.time[0]

    def give(self, function):
        """Return ``function`` (k,) of all states."""
        some = blocks(len(self.rows), len(self.run.robots))
        return np.concatenate([function(*self.of(rows.start, rows.stop)) for rows in some])

    def steps(self):
        """Yield ``(begin, end)`` of blocks of the steps from a sample to the next."""
        for rows in blocks(len(self.rows) - 1, len(self.run.robots)):
            yield rows.start, rows.stop


def _untold(control, energy, run, rows):
    """Return what robots make of their commands, [-] of the energy, where no published law is at hand."""
    if control.fidelity == "point_mass":
        return 0.0
    if len(rows) < len(run.time) or len(rows) < 3:
        return UNTOLD[control.fidelity]
    states = _States(control, run, rows)
    free = np.ones(len(rows) - 1, dtype=bool)
    cost = _robots_cost(energy, states, control.period, free)
    return cost / max(abs(energy.values(*states.of(0, 1))[0]), NOTHING)


def _estimated(run):
    """Return what commands may be off, [-], that were made of estimated poses."""
    return ESTIMATED if run.scenario is not None and run.scenario.odometry != "world" else 0.0


def _summed(changes):
    """Return what ``changes`` (k,) come to before and after each, (k + 1,)."""
    return np.concatenate([[0.0], np.cumsum(changes)])


def _robots_cost(energy, states, period, free):
    """Return what it takes to go elsewhere than the recorded velocities say, in the energy's unit.

    Over the steps from state to state that are ``free`` of limits, (k,) bool.  Where several commands
    lie between two samples, those between are taken from a straight line, and so is the way there: each
    misses a twelfth of the second difference of the velocities.
    """
    found = [_left_obeyed_missed(energy, states, period, *steps) for steps in states.steps()]
    left, obeyed, missed = np.where(free, np.concatenate(found, axis=1), 0.0)
    return np.abs(_summed(left - obeyed)).max() + np.abs(missed - obeyed).sum()


def _left_obeyed_missed(energy, states, period, begin, end):
    """Return the energies (3, k) after the steps from ``begin`` to before ``end``.

    Where the robots went, where their commands send them, and that with what a straight line misses.
    """
    known = max(begin - 1, 0)  # the first second difference looks back
    points, velocity, time = states.of(known, end + 1)
    several = states.commands[known:end, np.newaxis, np.newaxis]
    duration = several * period
    share = 0.5 * (1.0 - period / duration)
    ends = points[:-1] + duration * (velocity[:-1] + share * np.diff(velocity, axis=0))
    bent = np.zeros_like(ends)
    bent[1:] = duration[1:] * np.diff(velocity, n=2, axis=0) / 6.0 * (several[1:] > 1)
    new = slice(begin - known, None)
    there = (each[new] for each in (points[1:], ends, ends + bent))
    return np.array([energy.values(p, velocity[1:][new], time[1:][new]) for p in there])


def _limited(control, run):
    """Return in which samples some robot is at a limit, (m,) bool."""
    if control.saturation == "none" and control.fidelity == "point_mass":
        return np.zeros(len(run.time), dtype=bool)
    return at_limit(control, run).any(axis=1)  # robots keep their limits whatever is commanded


def _stilled(law, start):
    """Return the function of states that gives, (k,) bool, where a dead band holds a robot still."""
    begun = law.begin(start)

    def found(hand, velocity, time):
        wanted = law.velocities(hand, time, begun).any(axis=2)
        return (wanted & ~velocity.any(axis=2)).any(axis=1)

    return found


def _work(law, run, control):
    """Return how many pairs of robots are looked at over all commands of ``run``."""
    return law.WORK * (run.time[-1] - run.time[0]) / control.period * len(run.robots) ** 2


def _held(law, energy, states, period, follows):
    """Return the energies (k,) that the ``law`` makes of each state by the next one.

    Where several commands lie between two samples the law sees the points that it moves if they go
    where it ``follows`` them, and else those on a straight line to the next state.
    """
    if law.SEES == "now":
        found = [_held_at_once(law, energy, states, period, follows, *s) for s in states.steps()]
        return np.concatenate(found)
    states, commands = list(zip(*states.of(0, len(states.rows)))), states.commands
    return np.array(
        [energy.of(*end) for end in _held_in_turn(law, states, commands, period, follows)]
    )


def _held_at_once(law, energy, states, period, follows, begin, end):
    """Return the energies (k,) after the steps from ``begin`` to before ``end`` of a law without memory."""
    points, velocity, time = states.of(begin, end + 1)
    start, toward, time = points[:-1], np.diff(points, axis=0), time[:-1]
    commands, begun = states.commands[begin:end], law.begin(states.run.hand[0])
    points, velocity = start.copy(), velocity[:-1].copy()
    for step in range(commands.max()):
        on = commands > step
        share = (step / commands[on])[:, np.newaxis, np.newaxis]
        seen = points[on] if follows else start[on] + share * toward[on]
        velocity[on] = law.velocities(seen, time[on] + step * period, begun)
        points[on] += period * velocity[on]
    return energy.values(points, velocity, time + commands * period)


def _held_in_turn(law, states, commands, period, follows):
    """Yield ``(points, velocity, time)`` that a ``law`` with a memory makes of each state."""
    begun = memory = law.begin(states[0][0])
    for (start, velocity, time), (left, _, _), count in zip(states, states[1:], commands):
        points = start
        if law.SEES == "next":  # what is held from here on is part of the state
            memory = law.resumed(velocity, begun)
        for step in range(count):
            if law.SEES == "next":
                points = points + period * velocity
            at = step + (law.SEES == "next")
            seen = points if follows else start + at / count * (left - start)
            velocity, memory = law.velocity(seen, time + at * period, memory)
            if law.SEES != "next":
                points = points + period * velocity
        yield points, velocity, time + count * period
