"""The run that theory gives beside a recorded one: of points, and of robots as their drives are stated."""

import functools
import math
import weakref

import numpy as np

from mrs_simulator.control.pioneer_control import OF_POINTS
from mrs_simulator.protocols.published.arms import robots_of
from mrs_simulator.protocols.published.laws import (
    MOST_COMMANDS,
    MOST_PAIRS,
    FaultyEdges,
    Listeners,
    exact_motion,
)
from mrs_simulator.protocols.published.robots import Robots, are_stated, posed_commands
from mrs_simulator.record.recording import Run, part_of
from mrs_simulator.scenario.scenario import DEFAULT_KIND
from mrs_simulator.scenario.team.mismatch import NO_MISMATCH
from mrs_simulator.vehicles.team import Team
from mrs_simulator.verdict.theory.motion import Advance, begin_moving, limit_to_grip
from mrs_simulator.verdict.theory.one_step_predictions import one_step_predictions

MOST_ROBOTS = 500  # [-] whose dense matrices of weights are built
MOST_STEPS = 200000  # [-] of robots that speed up in ramps, each a step of the world


def published_law(control):
    """Return the published law of ``control``; None for teams too large for it, and for laws by sensors."""
    law = law_of_few(control)
    return None if law is not None and law.SEES == "sensors" else law


def law_of_few(control):
    """Return the published law of ``control``, by sensors or not; None for teams too large for it."""
    return control.published() if len(control.numbers) <= MOST_ROBOTS else None


def faulty_edges(control):
    """Return the control's edges as ``FaultyEdges``, None if they have no faults."""
    if not control.links.faults:
        return None
    return FaultyEdges(control.links, control.topology, control.period, control.edge_seed)


def is_blind(control, law):
    """Return whether the control's edges have faults over which the published law is not stated."""
    if law.SEES == "pose":
        return bool(control.links.faults)
    return control.links.changes_edges and law.over(np.ones((1, 1), dtype=bool)) is None


def exact_run(control, run, kept=None):
    """Return the ``Run`` of point masses that the published law moves from the start of ``run``.

    Of a law that sees poses: of unicycles without limits.  None where no law is published, or the
    solution is too long to compute.  ``kept``: as :func:`exact_motion`.
    """
    return _NEWEST.of(control, run, kept)


def _exact_run(control, run, kept):
    law = published_law(control)
    if law is None or is_blind(control, law):
        return None
    if law.SEES == "pose":
        return _exact_unicycles(control, law, run)
    edges = faulty_edges(control)
    with np.errstate(all="ignore"):
        times, drift = run.time - run.time[0], current_of(control, run)
        motion = exact_motion(law, run.hand[0], control.period, times, edges, drift, kept)
    if motion is None or not np.isfinite(motion[0]).all():
        return None
    hand, velocity = motion
    pose = np.zeros(hand.shape[:2] + (3,))
    pose[:, :, :2] = hand[:, :, :2] - [control.l, 0.0]
    command = velocity / [1.0, control.l] if control.dimension == 2 else velocity
    facts = {OF_POINTS: True}
    return Run(run.time, run.robots, pose, hand, command, [], run.scenario, facts)


class _Newest:
    """Keeps the newest exact run as long as its control: warnings and verdict want the same."""

    def __init__(self):
        self._of, self._asked, self._found = None, None, None

    def of(self, control, run, kept):
        """Return the exact ``Run`` beside ``run``."""
        asked = run.time, run.pose[0], run.hand[0], [control.period, control.l, control.edge_seed]
        law = repr(control.parameters), control.topology, control.links, control.fidelity
        known = self._of is not None and self._of() is control and self._asked[1] == law
        if not (known and all(map(np.array_equal, asked, self._asked[0]))):
            found = _exact_run(control, run, kept)
            self._of = weakref.ref(control, self._forget)
            self._asked = (asked, law)
            self._found = found
        return self._found and self._found._replace(scenario=run.scenario)

    def _forget(self, control):
        if self._of is control:
            self.__init__()


_NEWEST = _Newest()


def current_of(control, run):
    """Return with which velocities (n, 2) [m/s] the current carries the robots of ``run``."""
    result = np.zeros(run.hand.shape[1:])
    if run.scenario is not None:
        for row, kind in enumerate(control.team.kinds):
            if kind.module.MEDIUM == "water":
                result[row, :2] = run.scenario.environment.current
    return result


def _exact_unicycles(control, law, run):
    commands = (run.time[-1] - run.time[0]) / control.period
    if control.fidelity == "point_mass" or commands > MOST_COMMANDS:
        return None
    team = Team([DEFAULT_KIND] * len(run.robots), None)
    robots = Robots(team, control.l, control.period, "none")
    robots.be(run.pose[0])
    moved = functools.partial(_moved, control, law, robots, advance=Advance(NO_MISMATCH, team))
    return _run_of(robots, run, moved)


def robots_run(control, run, gripping=False):
    """Return the ``Run`` of the robots themselves under the published law, from the start of ``run``.

    Commands are held, speeds limited and ramped, and wheels roll without slip, as
    :mod:`published.drives` states it; bodies pass through each other, and point masses keep their
    headings.  Its ``meta`` holds ``limited``, (m, n) bool, who is at a limit or speeds up as fast as it
    can, and ``cut``, (m, n) [m], how much of its point's path that has cut off until then, and
    ``memory``, what the law remembers before the command that each sample is under.

    Robots that the scenario says to follow their commands late, too fast or too slowly do so here. Those
    of a run that is the rest of another begin as fast as they were.

    ``gripping``: their wheels also slip where they would speed up faster than friction lets them.

    None where that is not known: of points without limits (those of cars have one), under the safety
    filter, of robots with uneven wheels, and as in :func:`exact_run`.
    """
    law, scenario = published_law(control), run.scenario
    if law is None or scenario is None or not _can_be_followed(control, run, law):
        return None
    frozen = scenario.fidelity == "point_mass"
    robots = robots_of(control, frozen)
    robots.drift = current_of(control, run)[:, :2] @ [1.0, 1j]
    if gripping:
        limit_to_grip(robots)
    mismatch = scenario.mismatch
    by_step = (robots.is_ramped and not frozen) or any(mismatch.delay)
    step = scenario.step if by_step else math.inf
    last = run.time[-1] - run.time[0]
    commands = last / control.period
    work = law.WORK * commands * len(run.robots) ** 2
    work *= len(run.robots) if control.links.faults else 1
    if commands > MOST_COMMANDS or work > MOST_PAIRS or last / step > MOST_STEPS:
        return None
    if math.isinf(step) and not control.links.faults and mismatch == NO_MISMATCH:
        with np.errstate(all="ignore"):
            followed = one_step_predictions(law, robots, run, control.period)
        if followed is not None:
            facts = {
                "limited": followed.limited,
                "cut": followed.cut,
                "memory": (None,) * len(run.time),
            }
            columns = followed.pose, followed.hand, followed.command
            return Run(run.time, run.robots, *columns, [], scenario, facts, control.team.axes)

    def moved(time):
        return _moved(control, law, robots, time, Advance(mismatch, robots.team, step))

    robots.be_as(run, 0)
    if robots.is_ramped and not frozen and run.time[0] > 0.0:
        with np.errstate(all="ignore"):
            begin_moving(robots, run, moved)
    return _run_of(robots, run, moved)


def _run_of(robots, run, moved):
    """Return the ``Run`` of ``robots``, ``moved`` from sample to sample; None where they diverge."""
    with np.errstate(all="ignore"):
        rows = [(robots.pose, robots.points, *each) for each in moved(run.time)]
    *columns, memory = zip(*rows)
    pose, hand, command, limited, cut = map(np.array, columns)
    if not np.isfinite(pose).all():
        return None
    facts = {"limited": limited, "cut": cut, "memory": memory}
    return Run(run.time, run.robots, pose, hand, command, [], run.scenario, facts, robots.team.axes)


def later(followed, rows):
    """Return the ``rows``, a slice, of a run that :func:`robots_run` gave."""
    limited, cut = followed.meta["limited"][rows], followed.meta["cut"][rows]
    facts = {"limited": limited, "cut": cut - cut[0], "memory": followed.meta["memory"][rows]}
    return part_of(followed, rows)._replace(meta=facts)


def _can_be_followed(control, run, law):
    scenario = run.scenario
    # Of a car also the point mass is commanded no more than a steering angle below a right one.
    unlimited = bool(np.isinf(control.limits.top).all()) and not control.team.has_joints
    return not (
        (scenario.fidelity == "point_mass" and (unlimited or law.SEES == "pose"))
        or not are_stated(control.team)
        or is_blind(control, law)
        or np.any(control.safety)
        or _has_uneven_wheels(scenario)
        or len(run.robots) != control.team.n
        or (any(scenario.mismatch.delay) and run.time[0] > 0.0)
        or control.period > _timeout(scenario, control.team)
    )


def _has_uneven_wheels(scenario):
    errors = scenario.odometry_errors
    return errors is not None and (errors.Ed, errors.Eb) != (1.0, 1.0)


def _timeout(scenario, team):
    own = scenario.cmd_vel_timeout
    return float(team.timeouts.min()) if own is None else own


def _moved(control, law, robots, time, advance):
    """Yield ``(command, limited, cut, memory)`` at each sample, while ``robots`` move there.

    ``time`` (m,) [s] of the samples; ``advance``: the :class:`Advance` that moves them.
    """
    wanted, time = _Wanted(control, law, robots), time - time[0]
    cut, row, now, count = np.zeros(robots.team.n), 0, 0.0, 0
    late = np.zeros(robots.team.n, dtype=bool)
    ramped = robots.is_ramped and not math.isinf(advance.step)
    tiny = 1e-6 * control.period
    while True:
        before = wanted.memory
        u, command = wanted.at(now)
        limited = robots.limited_now | late
        begin, until = wanted.points, (count + 1) * control.period
        while row < len(time) and time[row] < until - tiny:
            advance(robots, command, time[row] - now)
            now = max(now, time[row])
            yield command, limited, cut.copy(), before
            row += 1
        if row == len(time):
            return
        advance(robots, command, until - now)
        late = robots.lag(advance.acting(command)) if ramped else late
        if (limited | late).any():
            moved = (robots.points - begin) / control.period
            off = u - moved
            off[:, :2] += np.column_stack([robots.drift.real, robots.drift.imag])
            lost = functools.reduce(np.hypot, off.T) * control.period
            cut += np.where(limited | late, lost, 0.0)
        now, count = until, count + 1


class _Wanted:
    """What the published law wants of the robots, command by command."""

    def __init__(self, control, law, robots):
        self.law, self.robots, self.control = law, robots, control
        edges, start = faulty_edges(control), robots.points
        self.team = None if edges is None else Listeners(law, edges, start)
        self.memory = None if self.team or law.SEES == "pose" else law.begin(start)

    def at(self, time):
        """Return velocities (n, 2) [m/s] and commands (n, a) at ``time`` [s], which is a command's."""
        law, robots = self.law, self.robots
        self.points = robots.points  # (n, d) [m] at that time
        if law.SEES == "pose":
            wanted, command = posed_commands(law, robots, robots.pose, time)
            return robots.velocities(wanted), command
        if self.team is not None:
            u = self.team.velocity(self.points, time)
        else:
            u, self.memory = law.velocity(self.points, time, self.memory)
        return u, robots.commands(u)
