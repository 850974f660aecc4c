"""Claims that discriminate: commands as the published law wants them, motion as its exact solution."""

import numpy as np

from mrs_simulator.control.pioneer_control import OF_POINTS
from mrs_simulator.control.safety.filter_by_sensors import SHARE
from mrs_simulator.control.safety.nearest_velocities import FIXED_RATE, filter_acts
from mrs_simulator.core.claims import LAW, ROBOTS, Claim, NothingDecays
from mrs_simulator.core.neighbours import lengths
from mrs_simulator.core.sample_blocks import blocks
from mrs_simulator.protocols.published.arms import robots_of
from mrs_simulator.protocols.published.laws import Listeners
from mrs_simulator.protocols.published.robots import AT_LIMIT, are_stated, posed_commands
from mrs_simulator.verdict.law.late_commands import late_commands
from mrs_simulator.verdict.law.sensed_commands import sensed_pairs
from mrs_simulator.verdict.theory.exact_runs import (
    faulty_edges,
    is_blind,
    law_of_few,
    published_law,
    robots_run,
)

COMMANDS = "commands off the published law [-]"
DISTANCE = "largest distance from the exact solution [m]"
ON_ROBOTS = "largest distance from the law on these robots [m]"
ROUNDING = 1e-6  # [-] of the largest velocity or of the team's size: sums in another order
# [-] of the largest velocity: what estimated poses cost, and what a law remembers of all samples.
ESTIMATED, REBUILT = 0.05, 1e-3
DRIFTED = 1.0  # [-] of the same: commands as far off as what is wanted are due to no drift,
DRIFT = 0.02  # [m] but where so much of it makes as much of a difference to the law
DRIFT_SHARES = [sign * 2.0**-k for k in range(8) for sign in (1.0, -1.0)]  # [-] of it
UNTIMED = 0.03  # [-] of the mean velocity: commands of poses that arrived some time before
LEAST_SPEED = 1e-3  # [m/s] to which differences of commands are related at least
UNKNOWN = (
    "the law saw wheel odometry that is not recorded, and commands are {:.2g} off what the true poses "
    "want: drift, or another law; wanted estimates: odometry, which records what was received"
)
UNREAD = "what sensors had read when a law was asked is not known without lockstep"
UNSTATED = "the published law is not stated over edges that come and go"
MOST_CHECKED = 4e7  # [-] pairs of robots over all samples whose commands are looked at
NUDGE = 1e-9  # [m] by which a start is moved to see whether differences grow
WHOLE = 1e-6  # [-] of a command period by which a sample may be beside a command
BELOW = 0.98  # [-] of a cap of speed, of what is not taken for capped
CLOSE = 1e-6  # [m] to where theory has a robot, within which it is there


def exactness_claims(control, run, exact, followed=None):
    """Return the claims on commands and motion, as far as the published law and ``run`` allow.

    ``exact``: the points' ``Run`` that theory gives, ``followed``: that of the robots, or None.  Points
    are compared with robots where held commands can add up at most, on wheels that neither ramp nor slip.
    """
    law, claims = published_law(control), []
    if law is None:
        return _by_sensors(control, run)
    rows = samples_on_commands(control, run)
    every = 1 < len(rows) == len(run.time) and _commands_between(control, run, 0, 1) == 1
    by_one = law.SEES != "past" and not control.links.faults
    known = by_one or (every and law.SEES != "pose")
    if control.deadband:  # what it swallows of velocities no later command shows
        known, exact = known and law.SEES in ("now", "pose"), None
    if are_stated(control.team) and not run.meta.get("lockstep"):
        claims.append(_late_commands(control, law, run))
    elif are_stated(control.team) and len(rows) > 1 and known:
        claims.append(_commands(control, law, run, followed if run.meta.get("lockstep") else None))
    known = followed is not None and control.fidelity != "dynamic" and run.meta.get("lockstep")
    narrow = law.NARROWS and control.fidelity == "kinematic"
    narrow = narrow and not np.isfinite(control.limits.acceleration).any()
    narrow = narrow and (known or control.team.is_of_unicycles)
    if exact is not None and (control.fidelity == "point_mass" or narrow):
        held = _apart(followed, exact) if known else held_arcs(control, run)
        claims.append(_distance(DISTANCE, exact, held))
    if known:
        claims.append(_on_robots(control, run, followed))
    return claims


def _by_sensors(control, run):
    """Return the claim on the commands of a law by sensors, a list."""
    stated = control.SENSORS and are_stated(control.team) and run.scenario is not None
    law = law_of_few(control) if stated else None
    if law is None or law.SEES != "sensors" or control.dimension != 2:
        return []
    unproved = "" if run.meta.get("lockstep") else UNREAD
    if control.links.faults:
        unproved = "the published law is not stated over edges with faults"

    def error(run):
        rows = samples_on_commands(control, run)
        robots = robots_of(control)
        pairs = sensed_pairs(control, robots, law, run, as_known(control, run), rows)
        found = _largest_share(robots, pairs)
        return found if control.LOCAL_FRAMES else _unless_drifted(control, law, run, found)

    tolerance = ROUNDING if control.LOCAL_FRAMES else _uncertainty(control, law, run)
    return [Claim(COMMANDS, 0.0, tolerance, error, unproved=unproved, question=LAW, motion=False)]


def _on_robots(control, begun, followed):
    """Return the claim that the robots are where the published law takes them, but for rounding."""
    claim = _distance(ON_ROBOTS, followed)

    def distance(run):
        value = claim.measure(run)
        if value > claim.tolerance:
            _refuse_chaos(control, begun, followed, max(claim.tolerance, 0.1 * value))
        return value

    return claim._replace(free=False, measure=distance)


def _refuse_chaos(control, run, followed, tolerance):
    """Raise ``NothingDecays`` where a start that is off by a hair ends farther off than ``tolerance``."""
    aside = np.zeros(run.hand.shape[1:])
    aside[:, 0] = NUDGE * (-1.0) ** np.arange(len(run.robots))
    pose = run.pose.copy()
    pose[:, :, 0] += aside[:, 0]
    nudged = run._replace(pose=pose, hand=run.hand + aside)
    other = robots_run(control, nudged)
    off = np.inf if other is None else _apart(other, followed)
    if off > tolerance:
        text = "a start that is {:g} m beside this one ends up to {:.2g} m beside it"
        raise NothingDecays(text.format(NUDGE, off))


def held_arcs(control, run):
    """Return by how much [m] held commands may carry hand points off the exact solution of ``run``.

    A robot turns by ``omega Tc`` while a command is held, so that its hand point's velocity is off by
    ``|u| |omega| Tc/2`` in the mean; added up over the run, of unicycles.
    """
    if control.fidelity == "point_mass":
        return 0.0
    turn = np.minimum(0.5 * np.abs(run.command[:, :, 1]) * control.period, 1.0)
    speed = np.hypot(run.command[:, :, 0], control.l * run.command[:, :, 1])
    return float(np.sum((speed * turn).max(axis=1)[:-1] * np.diff(run.time)))


def _commands(control, law, run, followed):
    if run.estimate is not None:  # what the law saw is known
        followed = None
    return Claim(
        COMMANDS,
        0.0,
        _uncertainty(control, law, run),
        lambda run: _unless_drifted(
            control, law, run, command_error(control, law, as_known(control, run), followed)
        ),
        question=LAW,
        motion=False,
    )


def _saw_unknown(run):
    """Return whether the law of ``run`` saw estimates of poses that were not recorded.

    Of real robots nothing else is recorded than what they report.
    """
    return _by_wheels(run) and run.estimate is None and not run.are_real.all()


def knows_noise(run):
    """Return whether the law of ``run`` saw odometry with errors that the scenario declares, unrecorded.

    They may be of any size, and grow without bound.
    """
    return _saw_unknown(run) and run.scenario.odometry_errors is not None


def _by_wheels(run):
    return run.scenario is not None and run.scenario.odometry != "world"


def _unless_drifted(control, law, run, error):
    """Return ``error`` [-]; ``NothingDecays`` for one that unknown drift of odometry may have made."""
    if not (_saw_unknown(run) and error > ESTIMATED):
        return error
    if knows_noise(run) or error < DRIFTED or error < _of_drift(control, law, run):
        raise NothingDecays(UNKNOWN.format(error))
    return error


@np.errstate(all="ignore")
def _of_drift(control, law, run):
    """Return what up to ``DRIFT`` of poses makes of commands, [-] of the largest velocity.

    Along the difference of recorded and wanted velocities, forth and back. Of a law that sees places
    alone; it is much where the law is steep, as near the range of its edges.
    """
    if law.SEES != "now" or control.links.faults:
        return 0.0
    rows = _spread(samples_on_commands(control, run), _most_rows(law, run))
    robots = robots_of(control)
    memory, time = law.begin(run.hand[0]), run.time - run.time[0]
    worst = largest = 0.0
    for row in rows:
        u = law.velocity(run.hand[row], time[row], memory)[0]
        robots.be_as(run, row)
        off = robots.velocities(run.command[row]) - u
        off = DRIFT * off / np.maximum(np.linalg.norm(off, axis=1, keepdims=True), 1e-300)
        for share in DRIFT_SHARES:
            near = law.velocity(run.hand[row] + share * off, time[row], memory)[0]
            worst = max(worst, np.linalg.norm(near - u, axis=1).max())
        largest = max(largest, np.linalg.norm(u, axis=1).max())
    return float(worst / max(largest, LEAST_SPEED))


def _uncertainty(control, law, run):
    """Return what commands may be off the published law, [-] of the largest velocity."""
    if _saw_unknown(run):
        return ESTIMATED
    if control.fidelity == "point_mass" or law.SEES not in ("next", "past"):
        return ROUNDING
    if control.links.faults or law.SEES == "past":
        return REBUILT
    return ROUNDING + rebuilt(control, law, as_known(control, run))


def as_known(control, run):
    """Return ``run`` with the poses that the control knew, where they were recorded."""
    if run.estimate is None:
        return run
    points = control.team.point(
        run.estimate, run.joints if run.joints is not None else 0.0, control.l
    )
    return run._replace(pose=run.estimate, hand=points)


def _late_commands(control, law, run):
    """Return the claim on commands that follow from poses of some time before."""
    unproved = ""
    if law.SEES in ("next", "past"):
        unproved = "the law has a memory, and poses and commands were not recorded in lockstep"
    if control.links.faults:
        unproved = "which messages were lost or late is not known without lockstep"

    def error(run):
        found = late_command_error(control, law, as_known(control, run))
        if found is None:
            raise NothingDecays("too few samples in which robots were commanded to move")
        return _unless_drifted(control, law, run, found.error)

    tolerance = ESTIMATED if _by_wheels(run) else UNTIMED
    return Claim(COMMANDS, 0.0, tolerance, error, unproved=unproved, question=LAW, motion=False)


def delay_measures(control, run):
    """Return ``command_delay`` [s], by how much commands are behind poses, by name; {} if unknown."""
    law = published_law(control)
    found = None
    if law is not None and are_stated(control.team):
        found = late_command_error(control, law, as_known(control, run))
    return {} if found is None else {"command_delay": found.delay}


def late_command_error(control, law, run):
    """Return the ``Late`` of a run that was not recorded in lockstep, None of too few samples.

    Poses stand for a sample and a command for its period, by which what the law wanted is uncertain.
    """
    if law.SEES in ("next", "past") or control.links.faults or len(run.time) < 3:
        return None
    rows = np.arange(min(len(run.time), _most_rows(law, run)))
    robots = robots_of(control)
    found = [command for _, command in _wanted(control, law, robots, run, rows)]
    wanted = np.concatenate([np.reshape(each, (-1,) + run.command.shape[1:]) for each in found])

    def sizes(row, command):
        robots.be_as(run, row)
        return robots.sizes(command)

    time = run.time[rows] - run.time[0]
    hold = control.period + float(np.median(np.diff(time)))
    return late_commands(time, wanted, run.command[rows], sizes, hold)


def _distance(name, exact, held=0.0):
    """Return the claim of the largest distance from ``exact``: within rounding and ``held`` [m]."""
    size = max(1.0, float(np.ptp(exact.hand[0], axis=0).max(initial=0.0)))
    tolerance = ROUNDING * size + held

    def distance(run):
        return _apart(run, exact)

    return Claim(name, 0.0, tolerance, distance, free=True, question=ROBOTS)


def _apart(run, other):
    """Return the largest distance [m] between points of two runs, over the samples of the shorter."""
    samples = min(len(run.time), len(other.time))
    return float(lengths(run.hand[:samples] - other.hand[:samples]).max())


def command_error(control, law, run, followed=None):
    """Return the largest difference of a command from the law's, over the largest wanted velocity.

    Both as velocities of the controlled points [m/s], the law's within the robots' limits.  At most
    ``MOST_CHECKED`` pairs of robots are looked at, over samples that are spread evenly.  ``followed``: the
    run of the robots under the law, if it is known, which shows what a law remembers at limits.
    """
    rows, most = samples_on_commands(control, run), _most_rows(law, run)
    robots = robots_of(control)
    if control.links.faults or law.SEES == "past":
        wanted_of = _wanted_by_listeners(control, law, robots, run, rows[:most])
    else:
        wanted_of = _wanted(control, law, robots, run, _spread(rows, most), followed)
    return _largest_share(robots, ((wanted, run.command[row]) for row, wanted in wanted_of))


def rebuilt(control, law, run):
    """Return what commands may be off, [-], of a law whose velocities are rebuilt from samples.

    Between two samples robots are taken to be on a straight line.  Where the law's own velocities would
    have led them differs from it by the curvature of their paths, which the line misses but for terms of
    the next order, and by slip: as much of it as the line misses where it all comes at once at either end,
    and less where it comes bit by bit.  The two may have cancelled out in part: allowed is twice that.
    """
    rows = _spread(samples_on_commands(control, run), _most_rows(law, run))
    robots = robots_of(control)
    ways = [_wanted(control, law, robots, run, rows, straight=each) for each in (True, False)]
    return 2.0 * _largest_share(robots, ((line, own) for (_, line), (_, own) in zip(*ways)))


def _largest_share(robots, pairs):
    """Return the largest difference of two commands (..., a), over the largest first one."""
    worst = largest = 0.0
    for wanted, other in pairs:
        error, size = (robots.sizes(c) for c in (wanted - other, wanted))
        worst, largest = max(worst, error.max()), max(largest, size.max())
    return float(worst / max(largest, LEAST_SPEED))


def _most_rows(law, run):
    """Return in how many samples ``MOST_CHECKED`` lets commands be looked at."""
    return max(2, int(MOST_CHECKED / (law.WORK * len(run.robots) ** 2)))


def _spread(rows, most):
    """Return at most ``most`` of the ``rows``, spread evenly."""
    return rows[:: -(-len(rows) // most)]


def samples_on_commands(control, run):
    """Return the samples, rows of ``run``, that fall on a command."""
    count = (run.time - run.time[0]) / control.period
    return np.flatnonzero(np.abs(count - np.round(count)) < WHOLE * np.maximum(count, 1.0))


def _commands_between(control, run, row, after):
    return int(round((run.time[after] - run.time[row]) / control.period))


def _wanted_by_listeners(control, law, robots, run, rows):
    """Yield ``(row, command)`` as :func:`_wanted` does, where each sample is a command."""
    if is_blind(control, law):
        raise NothingDecays(UNSTATED)
    time, edges = run.time - run.time[0], faulty_edges(control)
    team = None if edges is None else Listeners(law, edges, run.hand[0])
    memory = law.begin(run.hand[0])
    for row in rows:
        if team is None:
            u, memory = law.velocity(run.hand[row], time[row], memory)
        else:
            u = team.velocity(run.hand[row], time[row])
        yield row, _commanded(robots, run, row, u)


def _commanded(robots, run, row, u):
    """Return the commands (n, a) for the velocities ``u`` (n, 2) [m/s] at a ``row`` of ``run``."""
    robots.be_as(run, row)
    return robots.commands(u)


def _wanted(control, law, robots, run, rows, followed=None, straight=True):
    """Yield ``(row, command)``: the commands (n, a) that the law wants at samples of ``run``.

    Of a team that stacks, blocks of rows and their commands (k, n, a).  ``straight``: see :func:`_next`.
    """
    time, memory = run.time - run.time[0], law.begin(run.hand[0])
    if law.SEES == "pose":
        for row in rows:
            robots.be_as(run, row)
            yield row, posed_commands(law, robots, run.pose[row], time[row])[1]
        return
    if law.SEES == "now" and robots.stacks:
        for some in blocks(len(rows), len(run.robots)):
            block = rows[some]
            u = law.velocities(run.hand[block], time[block], memory)
            yield block, _commanded(robots, run, block, u)
        return
    if law.SEES == "now":
        for row in rows:
            u, _ = law.velocity(run.hand[row], time[row], memory)
            yield row, _commanded(robots, run, row, u)
        return
    u, _ = law.velocity(run.hand[0], 0.0, memory)
    yield 0, _commanded(robots, run, 0, u)
    limited = at_limit(control, run).any(axis=1)
    for row, after in zip(rows, rows[1:]):
        if not limited[row]:
            u = _next(control, law, robots, run, memory, row, after, straight)
        elif followed is not None and _is_there(followed, run, after):
            u, _ = law.velocity(run.hand[after], time[after], followed.meta["memory"][after])
        else:
            continue
        yield after, _commanded(robots, run, after, u)


def _is_there(followed, run, row):
    """Return whether robots are in the sample ``row`` where the ``followed`` are."""
    return row < len(followed.time) and bool(
        np.abs(followed.hand[row] - run.hand[row]).max() < CLOSE
    )


def _next(control, law, robots, run, memory, row, after, straight=True):
    """Return the velocities at sample ``after`` from those commanded at ``row``, free of limits.

    ``straight``: the way of robots on the ground is a straight line, else that of the law's velocities.
    """
    robots.be_as(run, row)
    u = robots.velocities(run.command[row])
    then = law.resumed(u, memory)
    steps = _commands_between(control, run, row, after)
    points, left = run.hand[row], run.hand[after]
    for step in range(1, steps + 1):
        time = run.time[row] - run.time[0] + step * control.period
        if control.fidelity == "point_mass" or not (straight or step == steps):
            points = points + control.period * u
        else:  # which arcs between two samples are not known: a straight line
            points = points + (left - points) / (steps + 1 - step)
        u, then = law.velocity(points, time, then)
    return u


def at_limit(control, run):
    """Return which robots are at a limit of theirs in the samples of ``run``, (m, n) bool.

    Of speeds, and of joints' angles and rates; of robots with arms also of accelerations, by which their
    tools leave their paths.
    """
    if run.meta.get(OF_POINTS):
        return np.zeros(run.hand.shape[:2], dtype=bool)
    found = np.empty(run.hand.shape[:2], dtype=bool)
    for rows in blocks(*found.shape):
        recorded = run.command[rows], run.pose[rows], run.hand[rows], control.l, control.period
        found[rows] = control.team.limits_in(*recorded, AT_LIMIT)
    return (
        found | _ramps(control, run) if control.team.has_arms and run.twist is not None else found
    )


def _ramps(control, run):
    """Return whose base speeds up as fast as it can until after the next command, (m, n) bool."""
    columns = {axis: k for k, axis in enumerate(("linear.x", "linear.y", "angular.z"))}
    based = [k for k, axis in enumerate(run.axes) if axis in columns]
    wanted, had = run.command[..., based], run.twist[..., [columns[run.axes[k]] for k in based]]
    most = control.limits.of_all(control.team.n).acceleration[:, based] * control.period
    return (np.abs(wanted - had) > most + ROUNDING).any(axis=2)


def may_sense(control, velocity, hand, bounds):
    """Return whether a safety filter by sensors may have changed what was wanted to ``velocity`` (n, d).

    What a sonar detects may seem nearer than it is by twice the way from the transducer to the point, which
    both lie on the robot.
    """
    reach = control.safety_filter.distance
    reach = np.full(len(hand), 0.5 * reach) if np.ndim(reach) == 0 else 0.5 * np.diagonal(reach)
    gap = bounds.least(len(hand)) - 2.0 * reach
    apart = np.linalg.norm(hand[:, np.newaxis] - hand, axis=2) - 3.0 * reach[:, np.newaxis] - reach
    np.fill_diagonal(apart, np.inf)
    gap = np.minimum(gap, apart.min(axis=1))
    return bool((np.linalg.norm(velocity, axis=1) > SHARE * FIXED_RATE * gap).any())


def _before_limits(control, run, row, velocity):
    """Return the ``velocity`` (n, d) [m/s] of a sample, at top speed for robots that are at a limit.

    The filter starts from what the law wants before limits.
    """
    if control.safety_filter.way_out is None:
        return velocity
    given = run.command[row : row + 1], run.pose[row : row + 1], run.hand[row : row + 1]
    limited = control.team.limits_in(*given, control.l, control.period, SHARE)[0]
    if control.saturation == "team":  # one robot's limit slows all
        limited = np.broadcast_to(limited.any(), limited.shape)
    top = control.team.speeds[:, 0]
    if (
        control.safety_filter.speed is not None
    ):  # a cap alone has robots at their limits go as they would
        top = np.minimum(top, BELOW * control.safety_filter.speed)
    size = np.linalg.norm(velocity, axis=1)
    raised = limited & (size > 0.0) & (size < top) & np.isfinite(top)
    return velocity * np.where(raised, top / np.maximum(size, 1e-300), 1.0)[:, np.newaxis]


def may_have_braked(control, run, row):
    """Return whether robots may have been braked in a sample of ``run``, to keep them a way out."""
    if control.safety_filter.way_out is None:
        return False
    place = run.hand[row] if control.dimension == 3 else run.pose[row, :, :2]
    around = control.safety_filter.surroundings(standing=True)
    return control.safety_filter.way_out.may_have_acted(run.command[row], place, around)


def filter_acted(control, run):
    """Return the last sample of ``run`` whose command the safety filter changed, or None.

    As far as samples show: between two of them it may have acted as well.
    """
    if not np.any(control.safety):
        return None
    distance = control.safety_filter.distance
    speed = control.safety_filter.speed
    velocity = control.velocities(run)
    for row in range(len(run.time) - 1, -1, -1):
        hand, u = run.hand[row], velocity[row]
        bounds = control.safety_filter.bounds(hand, run.time[row])
        squash = control.safety_filter.squash
        if control.safety_filter.sensors and may_sense(control, u, hand, bounds):
            return row
        more = {
            "bounds": bounds,
            "speed": speed,
            "squash": squash,
            "brakes": control.safety_filter.brakes,
        }
        u = _before_limits(control, run, row, u)
        if filter_acts(u, hand, distance, control.period, **more):
            return row
        if may_have_braked(control, run, row):
            return row
    return None
