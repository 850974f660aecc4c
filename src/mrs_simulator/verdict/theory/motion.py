"""How robots of the published drives go on: from what speeds, and under which commands."""

import math

import numpy as np

from mrs_simulator.scenario.team.mismatch import NO_MISMATCH

NUDGE = 1e-6  # [m/s, rad/s] of a speed, to see what it does
LEAST = 1e-6  # [s] of what a speed does to a place, below which it hardly shows there
MET = 1e-12  # [m, rad] of the next sample
MOST_TRIES = 20  # [-]


class Advance:
    """Moves robots under the commands that act on them, by the scenario's ``mismatch``.

    A robot follows ``factor`` (n, a) times the command in force ``late`` (n,) steps before.
    """

    def __init__(self, mismatch, team, step):
        """``step`` [s] of ramps and delays, inf without any."""
        self.step, self.factor, self.late, self.given = step, None, None, []
        if mismatch == NO_MISMATCH:
            return
        whole = mismatch.with_robots(team.n)
        straight = np.broadcast_to(whole.speed, team.n)
        turning = straight / np.broadcast_to(whole.track, team.n)
        each = [turning if axis.startswith("angular") else straight for axis in team.axes]
        self.factor = np.transpose(each)
        if any(whole.delay):
            self.late = np.rint(np.broadcast_to(whole.delay, team.n) / step).astype(int)

    def acting(self, command):
        """Return the ``command`` (n, a) as robots without delay follow it."""
        return command if self.factor is None else self.factor * command

    def __call__(self, robots, command, duration):
        """Move ``robots`` for ``duration`` [s] under ``command`` (n, a), in steps while anything ramps."""
        if duration <= 0.0:
            return
        parts = 1 if math.isinf(self.step) else max(1, int(round(duration / self.step)))
        if self.late is None:
            robots.move(self.acting(command), duration, parts)
            return
        for _ in range(parts):
            self.given.append(command)
            when = len(self.given) - 1 - self.late
            held = np.array([self.given[max(at, 0)][row] for row, at in enumerate(when)])
            held[when < 0] = 0.0
            robots.move(self.acting(held), duration / parts)


def begin_moving(robots, run, moved):
    """Let ``robots`` begin as fast as those of ``run`` were in its first sample.

    As recorded; of differential drives so that ``moved(time)``, which yields at each ``time`` (k,) [s],
    leads them to the second sample: along the arc and in heading, each by a speed of its own.
    """
    if run.twist is not None:
        robots.speed_up(*_level_twist(run))
        return
    turn = _wrapped(run.pose[1, :, 2] - run.pose[0, :, 2])
    ahead = np.exp(1j * (run.pose[0, :, 2] + 0.5 * turn))
    went = _complex(run.pose[1] - run.pose[0])
    duration = run.time[1] - run.time[0]
    speeds = np.column_stack([(went / ahead).real, turn]) / duration

    def off(speeds):
        """Return by how much (n, 2) [m, rad] robots as fast as ``speeds`` (n, 2) miss the second sample."""
        robots.be_as(run, 0)
        robots.speed_up(np.insert(speeds, 1, 0.0, axis=1))
        for _ in moved(run.time[:2]):
            pass
        missed = _complex(robots.pose - run.pose[1]) / ahead
        return np.column_stack([missed.real, _wrapped(robots.pose[:, 2] - run.pose[1, :, 2])])

    for _ in range(MOST_TRIES):
        missed = off(speeds)
        if not np.abs(missed).max() > MET:  # nor is nan
            break
        gain = [(off(speeds + aside) - missed) / NUDGE for aside in NUDGE * np.eye(2)]
        (along, _), (bent, turned) = (each.T for each in gain)
        omega = missed[:, 1] / np.maximum(turned, LEAST)
        v = (missed[:, 0] - bent * omega) / np.maximum(along, LEAST)
        speeds = speeds - np.column_stack([v, omega])
    robots.be_as(run, 0)
    robots.speed_up(np.insert(speeds, 1, 0.0, axis=1))


def _level_twist(run):
    """Return level twists (n, 3) in the first sample of ``run``, and how fast robots climb, or None."""
    twist = run.twist[0]
    if run.spatial is None:
        return twist, None
    part, tilted = (
        run.spatial.orientation[0],
        np.column_stack([twist[:, :2], run.spatial.twist[0, :, 0]]),
    )
    axis = part[:, :3]  # v + 2 w (q x v) + 2 q x (q x v) turns v by the quaternion (q, w)
    once = 2.0 * np.cross(axis, tilted)
    velocity = tilted + part[:, 3:] * once + np.cross(axis, once)
    level = _complex(velocity) * np.exp(-1j * run.pose[0, :, 2])
    return np.column_stack([level.real, level.imag, twist[:, 2]]), velocity[:, 2]


def _complex(vectors):
    return vectors[:, 0] + 1j * vectors[:, 1]


def _wrapped(angle):
    return np.angle(np.exp(1j * angle))
