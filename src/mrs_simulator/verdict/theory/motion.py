"""How robots of the published drives go on: from what speeds, and under which commands."""

import math

import numpy as np

from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.protocols.published.arms import robots_of
from mrs_simulator.protocols.published.drives import Unicycles
from mrs_simulator.scenario.team.mismatch import NO_MISMATCH
from mrs_simulator.vehicles.grip import grip

NUDGE = 1e-6  # [m/s, rad/s] of a speed, to see what it does
LEAST = 1e-6  # [s] of what a speed does to a place, below which it hardly shows there
MET = 1e-12  # [m, rad] of the next sample
EVEN = 1e-6  # [-] of a command period by which samples may be unevenly far apart
MOST_TRIES = 20  # [-]


class Advance:
    """Moves robots under the commands that act on them, by the scenario's ``mismatch``.

    A robot follows ``factor`` (n, a) times the command in force ``late`` (n,) steps before.
    """

    def __init__(self, mismatch, team, step=math.inf):
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


def limit_to_grip(robots):
    """Let differential drives of ``robots`` speed up no faster than the friction of their wheels lets them.

    That is the ``grip`` of their kinds.
    """
    for group, part in robots.parts:
        if type(part) is not Unicycles:
            continue
        kinds = [robots.team.kinds[row] for row in np.arange(robots.team.n)[group.rows]]
        most = np.array([grip(kind) for kind in kinds])
        part.acceleration = np.minimum(np.broadcast_to(part.acceleration, most.shape), most)
        robots.is_ramped = True


def commanded_ways(control, run):
    """Return where robots that obey the recorded commands of ``run`` go between samples.

    Poses and heights ``(before, after)``, (m - 1, n, 4) [m, m, rad, m] each, from rest at the start.
    What was commanded between two samples lies on a straight line between their commands.
    """
    robots, duration = robots_of(control), np.diff(run.time)
    counts = np.maximum(1, np.rint(duration / control.period).astype(int))
    advance = Advance(run.scenario.mismatch, control.team, run.scenario.step)
    even = np.ptp(duration) < EVEN * control.period
    if robots.stacks and advance.late is None and even:
        return _stacked_ways(run, robots, advance, float(duration.mean()), int(counts[0]))
    robots.be(run.pose[0], run.in_space(control.dimension).hand[0])
    places = [_place(robots)]
    for row, count in enumerate(counts.tolist()):
        now, then = run.command[row], run.command[row + 1]
        for k in range(count):
            advance(robots, now + k / count * (then - now), duration[row] / count)
        places.append(_place(robots))
    return np.array(places[:-1]), np.array(places[1:])


def _place(robots):
    """Return poses and heights (n, 4) of ``robots``, without heights 0."""
    height = robots.points[:, 2:] if robots.team.dimension == 3 else np.zeros((robots.team.n, 1))
    return np.concatenate([robots.pose, height], axis=1)


def _stacked_ways(run, robots, advance, duration, count):
    """Return what :func:`commanded_ways` does, of all ways at once: each is one of a stack of teams.

    Where a way begins does not matter to it but for speeds, which ramps carry from one to the next.
    """
    parts = max(1, int(round(duration / count / advance.step)))
    step = duration / (count * parts)
    now, then = run.command[:-1], run.command[1:]
    commands = [advance.acting(now + k / count * (then - now)) for k in range(count)]
    ((_, part),) = robots.parts
    before = np.zeros(now.shape[:2] + (4,))
    robots.be(before[..., :3])
    if part.is_ramped:
        goals = np.stack([part.obeyed(each) for each in commands], axis=1)
        goals = np.repeat(goals.reshape((-1,) + now.shape[1:]), parts, axis=0)
        speeds = _ramped(goals, part.acceleration * step)
        part.velocity[1:] = speeds[count * parts - 1 : -1 : count * parts]
    for command in commands:
        for _ in range(parts):
            part.move(command, step)
    after = before.copy()
    after[..., :3] = robots.pose
    return before, after


def _ramped(goals, most):
    """Return speeds (s, n, a) that follow ``goals`` (s, n, a) from rest, by ``most`` in a step."""
    speeds = goals.copy()
    first = np.zeros_like(goals[:1])
    jumps = (np.abs(np.diff(goals, axis=0, prepend=first)) > most).any(axis=(1, 2))
    until = 0
    for row in np.flatnonzero(jumps).tolist():
        while row < len(goals) and row >= until:
            before = speeds[row - 1] if row else first[0]
            speeds[row] = before + np.clip(goals[row] - before, -most, most)
            if (speeds[row] == goals[row]).all():
                break
            row += 1
        until = max(until, row + 1)
    return speeds


def begin_moving(robots, run, moved):
    """Let ``robots`` begin as fast as those of ``run`` were in its first sample.

    As recorded; of differential drives so that ``moved(time)``, which yields at each ``time`` (k,) [s],
    leads them to the second sample: along the arc and in heading, each by a speed of its own.
    """
    if run.twist is not None:
        robots.speed_up(*_level_twist(run))
        return
    turn = wrap_angle(run.pose[1, :, 2] - run.pose[0, :, 2])
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
        return np.column_stack([missed.real, wrap_angle(robots.pose[:, 2] - run.pose[1, :, 2])])

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
    part = run.spatial.orientation[0]
    tilted = np.column_stack([twist[:, :2], run.spatial.twist[0, :, 0]])
    axis = part[:, :3]  # v + 2 w (q x v) + 2 q x (q x v) turns v by the quaternion (q, w)
    once = 2.0 * np.cross(axis, tilted)
    velocity = tilted + part[:, 3:] * once + np.cross(axis, once)
    level = _complex(velocity) * np.exp(-1j * run.pose[0, :, 2])
    return np.column_stack([level.real, level.imag, twist[:, 2]]), velocity[:, 2]


def _complex(vectors):
    return vectors[:, 0] + 1j * vectors[:, 1]
