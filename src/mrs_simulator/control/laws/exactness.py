"""Claims that discriminate: commands as the published law wants them, motion as its exact solution."""

import numpy as np

from mrs_simulator.control.laws.published import FaultyEdges, Listeners, exact_motion, exact_poses
from mrs_simulator.control.pioneer_control import OF_POINTS
from mrs_simulator.control.safety_filter import filter_acts
from mrs_simulator.core.claims import Claim
from mrs_simulator.core.recording import Run
from mrs_simulator.vehicles.drives import differential

COMMANDS = "commands off the published law [-]"
DISTANCE = "largest distance from the exact solution [m]"
AT_LIMIT = 0.999  # [-] of a limit, from which on it counts as reached
ROUNDING = 1e-6  # [-] of the largest velocity or of the team's size: sums in another order
# [-] of the largest velocity: what estimated poses and velocities that are rebuilt from samples cost.
ESTIMATED, REBUILT = 0.05, 1e-3
MOST_ROBOTS = 500  # [-] whose dense matrices of weights are built
LEAST_SPEED = 1e-3  # [m/s] to which differences of commands are related at least
MOST_CHECKED = 4e7  # [-] pairs of robots over all samples whose commands are looked at
WHOLE = 1e-6  # [-] of a command period by which a sample may be beside a command


def exact_run(control, run):
    """Return the ``Run`` of point masses that the published law moves from the start of ``run``.

    None where no law is published, or the solution is too long to compute.
    """
    law = _law(control)
    if law is None:
        return None
    if law.SEES == "pose":
        return _exact_robots(control, law, run)
    edges = faulty_edges(control)
    if control.links.changes_edges and law.over(np.ones((1, 1), dtype=bool)) is None:
        return None
    with np.errstate(all="ignore"):
        motion = exact_motion(law, run.hand[0], control.period, run.time - run.time[0], edges)
    if motion is None or not np.isfinite(motion[0]).all():
        return None
    hand, velocity = motion
    pose = np.zeros(hand.shape[:2] + (3,))
    pose[:, :, :2] = hand - [control.l, 0.0]
    command = velocity / [1.0, control.l]
    facts = {OF_POINTS: True}
    return Run(run.time, run.robots, pose, hand, command, [], run.scenario, facts)


def _exact_robots(control, law, run):
    """Return the exact ``Run`` of unicycles under a law that sees poses, or None."""
    if control.fidelity == "point_mass" or not by_wheels(control):
        return None
    with np.errstate(all="ignore"):
        time = run.time - run.time[0]
        motion = exact_poses(law, run.pose[0], control.period, time, control.l)
    if motion is None or not np.isfinite(motion[0]).all():
        return None
    pose, command = motion
    theta = pose[:, :, 2, np.newaxis]
    hand = pose[:, :, :2] + control.l * np.concatenate([np.cos(theta), np.sin(theta)], axis=2)
    return Run(run.time, run.robots, pose, hand, command, [], run.scenario)


def _law(control):
    """Return the published law; None for teams too large for it."""
    return control.published() if len(control.numbers) <= MOST_ROBOTS else None


def exactness_claims(control, run, exact):
    """Return the claims on commands and motion, as far as the published law and ``run`` allow.

    The motion of robots is not compared where what held commands leave may grow, where they speed up
    in ramps, or where wheels slip.
    """
    law, claims = _law(control), []
    if law is None:
        return claims
    rows = _rows(control, run)
    every = 1 < len(rows) == len(run.time) and _commands_between(control, run, 0, 1) == 1
    by_one = law.SEES != "past" and not control.links.faults
    if by_wheels(control) and len(rows) > 1 and (by_one or (every and law.SEES != "pose")):
        claims.append(_commands(control, law, run))
    robots = law.NARROWS and control.fidelity == "kinematic" and by_wheels(control)
    robots = robots and np.isinf(control.limits.acceleration).all()  # no ramps
    if exact is not None and (robots or control.fidelity == "point_mass"):
        claims.append(_distance(exact))
    return claims


def _commands(control, law, run):
    unproved = (
        "" if run.meta.get("lockstep") else "poses and commands were not recorded in lockstep"
    )
    tolerance = ROUNDING
    if control.fidelity != "point_mass" and law.SEES in ("next", "past"):
        tolerance = REBUILT
    if run.scenario is not None and run.scenario.odometry != "world":
        tolerance = ESTIMATED
    return Claim(
        COMMANDS,
        0.0,
        tolerance,
        lambda run: command_error(control, law, run),
        unproved=unproved,
        own=True,
    )


def _distance(exact):
    """Return the claim of the largest distance: from rounding for points, from held arcs for robots.

    While a command is held a robot turns by ``omega Tc``, so that its hand point's velocity is off by
    ``|u| |omega| Tc/2`` in the mean; the tolerance adds that up over the run.
    """
    size = max(1.0, float(np.ptp(exact.hand[0], axis=0).max(initial=0.0)))

    def distance(run):
        return float(np.linalg.norm(run.hand - exact.hand, axis=2).max())

    return Claim(DISTANCE, 0.0, ROUNDING * size, distance, free=True, own=True)


def held_arcs(control, run):
    """Return by how much [m] held commands may carry hand points off the exact solution of ``run``."""
    if control.fidelity == "point_mass" or not by_wheels(control):
        return 0.0
    turn = np.minimum(0.5 * np.abs(run.command[:, :, 1]) * control.period, 1.0)
    speed = np.hypot(run.command[:, :, 0], control.l * run.command[:, :, 1])
    return float(np.sum((speed * turn).max(axis=1)[:-1] * np.diff(run.time)))


def command_error(control, law, run):
    """Return the largest difference of a command from the law's, over the largest wanted velocity.

    Both as velocities of hand points [m/s], the law's within the robots' limits.  At most
    ``MOST_CHECKED`` pairs of robots are looked at, over samples that are spread evenly.
    """
    rows = _rows(control, run)
    most = max(2, int(MOST_CHECKED / (law.WORK * len(run.robots) ** 2)))
    if control.links.faults or law.SEES == "past":
        wanted_of = _wanted_by_listeners(control, law, run, rows[:most])
    else:
        wanted_of = _wanted(control, law, run, rows[:: -(-len(rows) // most)])
    worst = largest = 0.0
    for row, wanted in wanted_of:
        error, size = (_speeds(c, control.l) for c in (wanted - run.command[row], wanted))
        worst, largest = max(worst, error.max()), max(largest, size.max())
    return float(worst / max(largest, LEAST_SPEED))


def _rows(control, run):
    """Return the samples, rows of ``run``, that fall on a command."""
    count = (run.time - run.time[0]) / control.period
    return np.flatnonzero(np.abs(count - np.round(count)) < WHOLE * np.maximum(count, 1.0))


def _commands_between(control, run, row, after):
    return int(round((run.time[after] - run.time[row]) / control.period))


def faulty_edges(control):
    """Return the control's edges as :class:`FaultyEdges`, None if they have no faults."""
    if not control.links.faults:
        return None
    return FaultyEdges(control.links, control.topology, control.period, control.edge_seed)


def _wanted_by_listeners(control, law, run, rows):
    """Yield ``(row, command)`` as :func:`_wanted` does, where each sample is a command."""
    time, edges = run.time - run.time[0], faulty_edges(control)
    team = None if edges is None else Listeners(law, edges, run.hand[0])
    memory = law.begin(run.hand[0])
    for row in rows:
        if team is None:
            u, memory = law.velocity(run.hand[row], time[row], memory)
        else:
            u = team.velocity(run.hand[row], time[row])
        yield row, limited(control, commands_of(u, run.pose[row, :, 2], control.l))


def _wanted(control, law, run, rows):
    """Yield ``(row, command)``: the commands (n, 2) that the law wants at samples of ``run``."""
    time, memory = run.time - run.time[0], law.begin(run.hand[0])
    if law.SEES == "pose":
        for row in rows:
            yield (
                row,
                law.commands(run.pose[row], run.hand[row], run.command[row], time[row], control.l),
            )
        return
    if law.SEES == "now":
        for row in rows:
            u, _ = law.velocity(run.hand[row], time[row], memory)
            yield row, limited(control, commands_of(u, run.pose[row, :, 2], control.l))
        return
    u, _ = law.velocity(run.hand[0], 0.0, memory)
    yield 0, limited(control, commands_of(u, run.pose[0, :, 2], control.l))
    for row, after in zip(rows, rows[1:]):
        u = _next(control, law, run, memory, row, after)
        if u is not None:
            yield after, limited(control, commands_of(u, run.pose[after, :, 2], control.l))


def _next(control, law, run, memory, row, after):
    """Return the velocities at sample ``after`` from those commanded at ``row``; None at a limit."""
    command = run.command[row]
    if at_limit(control, command).any():
        return None
    then = law.resumed(velocities_of(command, run.pose[row, :, 2], control.l), memory)
    steps = _commands_between(control, run, row, after)
    points, left = run.hand[row], run.hand[after]
    u = velocities_of(command, run.pose[row, :, 2], control.l)
    for step in range(1, steps + 1):
        time = run.time[row] - run.time[0] + step * control.period
        if control.fidelity == "point_mass":
            points = points + control.period * u
        else:  # which arcs between two samples are not known: a straight line
            points = points + (left - points) / (steps + 1 - step)
        u, then = law.velocity(points, time, then)
    return u


def commands_of(u, theta, l):
    """Return ``(v, omega)``, (n, 2), that give hand points the velocities ``u`` (n, 2) [m/s]."""
    ahead = (u[:, 0] + 1j * u[:, 1]) * np.exp(-1j * theta)
    return np.column_stack([ahead.real, ahead.imag / l])


def velocities_of(command, theta, l):
    """Return the hand points' velocities (n, 2) [m/s] under ``command`` (n, 2)."""
    u = (command[:, 0] + 1j * l * command[:, 1]) * np.exp(1j * theta)
    return np.column_stack([u.real, u.imag])


def limited(control, command):
    """Return ``command`` (n, 2) scaled as the control's saturation says, in each robot or in all."""
    if control.saturation == "none":
        return command
    share = np.max(np.abs(command) / control.limits.top, axis=-1)
    share = np.full(len(command), share.max()) if control.saturation == "team" else share
    return command / np.maximum(share, 1.0)[:, np.newaxis]


def at_limit(control, command):
    """Return which robots are at a limit of theirs, (..., n) bool, under ``command`` (..., n, a)."""
    return control.team.at_limits(command, AT_LIMIT)


def by_wheels(control):
    """Return whether all robots take ``(v, omega)``: the mapping (7) is known here for those alone."""
    return all(group.drive is differential for group in control.team.groups)


def filter_acted(control, run):
    """Return whether the safety filter changed a command of ``run``, as far as its samples tell."""
    if not np.any(control.safety) or not by_wheels(control):
        return False
    distance, speed = control.safe_distance, control.safe_speed
    for hand, pose, command in zip(run.hand, run.pose, run.command):
        u = velocities_of(command, pose[:, 2], control.l)
        bounds = control.safe_bounds(hand)
        if filter_acts(u, hand, distance, control.period, bounds=bounds, speed=speed):
            return True
    return False


def _speeds(command, l):
    return np.hypot(command[:, 0], l * command[:, 1])
