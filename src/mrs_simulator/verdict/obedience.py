"""Whether robots do as commanded: gain, bias and dead time of each wheel or axis, fitted from a record.

From one recorded sample to the next a robot went at a mean velocity y; its kind's own drive, within its
limits and ramps, would have gone at x under the recorded commands.  Over a window of samples

    y - x = (g - 1) x - T x' + b

is fitted by least squares: gain g, dead time T [s], bias b [m/s].  Each is looked at with the other two
held to the spread that the kind declares of them, so that what a window cannot distinguish shows in the
standard error.
"""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import max_of_rows, wrap_angle
from mrs_simulator.protocols.published.arms import robots_of
from mrs_simulator.protocols.published.robots import are_stated
from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.team.mismatch import NO_MISMATCH
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.vehicles.team import Team
from mrs_simulator.verdict.theory.exact_runs import current_of
from mrs_simulator.verdict.theory.motion import commanded_ways
from mrs_simulator.verdict.verdict import Check

WINDOW = 5.0  # [s] in which a robot is looked at, besides the whole run
FEWEST = 20  # [-] samples of a window
SURE = 3.0  # [-] standard errors
# [-] of gains, [s] of dead times, [m/s] of biases: with a wider bound a window decides nothing.
TELLING = (0.8, 0.5, 0.1)
RESOLVED = 0.2  # [-] of the declared bias: by how much velocities are uncertain at least
ROUGH = 0.5  # [-] of the change of commands from sample to sample, which slip and samples blur
HARSH = 1.0  # [m/s^2] of a change of commands, beyond which a sample shows nothing: wheels spin
STEEP = 0.3  # [-] of its ramps together, from which on a robot goes along one
MOST_COMMANDS = 50000  # [-] that are followed
AT_ONCE = 200000  # [-] samples of robots, which take 80 MB
ROBOT_AXES = (("obeyed", 0), ("spread", 0), ("found", 1), ("error", 1))  # of the arrays of ``Fits``
SHOWN = 3  # [-] robots that are named
NAMES = (
    "gain of wheels and axes [-]",
    "dead time of wheels and axes [s]",
    "bias of wheels and axes [m/s]",
)
SPEEDS = ("linear.x", "linear.y", "angular.z", "linear.z")
DIRECTIONS = ("ahead", "sideways", "turning", "upwards")


def obedience_checks(control, run):
    """Return a ``Check`` each of gain, dead time and bias: the worst, or that the run does not show it.

    Turn rates count as speeds at half of the body's width.  None of points, real robots, robots with
    arms or uneven wheels, those that wind and waves push, of drives that are not stated, and where the
    law, or faults of its edges, make commands jump between samples.
    """
    found = fits(control, run)
    return [] if found is None else [_check(which, found, run) for which in range(len(NAMES))]


class Fits(NamedTuple):
    """Fits of all windows; c wheels and axes of each robot."""

    names: Any  # n tuples of c names, "" for none
    obeyed: Any  # (n, c) bool, of which commands say something
    spread: Any  # (n, 3) of gain [-], dead time [s] and bias [m/s], as declared
    windows: Any  # slices of the ways between samples
    found: Any  # (w, n, c, 3) gain less 1, dead time, bias
    error: Any  # (w, n, c, 3) standard errors

    @property
    def bound(self):
        """Return how much each may be, (w, n, c, 3)."""
        return self.spread[:, np.newaxis] + SURE * self.error

    @property
    def there(self):
        """Return what is fitted at all, (n, c, 3) bool."""
        named = np.array([[bool(name) for name in own] for own in self.names])
        return np.stack([self.obeyed, self.obeyed, named], axis=2)

    @property
    def decides(self):
        """Return what a window decides, (w, n, c, 3) bool: bounds are narrow enough."""
        return self.there & (self.bound < TELLING)


def fits(control, run):
    """Return the :class:`Fits` of ``run``, None where it shows none."""
    if not _can_be_fitted(control, run):
        return None
    n, size = control.team.n, max(1, AT_ONCE // len(run.time))
    if size >= n or not _is_separable(control, run):
        return _fits_of(control, run)
    rows = (slice(row, row + size) for row in range(0, n, size))
    parts = [_fits_of(*_part_of(control, run, each)) for each in rows]
    names = [name for part in parts for name in part.names]
    joined = (
        np.concatenate([getattr(part, field) for part in parts], axis=axis)
        for field, axis in ROBOT_AXES
    )
    return Fits(names, windows=parts[0].windows, **dict(zip(dict(ROBOT_AXES), joined)))


def _is_separable(control, run):
    """Return whether each robot can be fitted without the others: all are unicycles without mismatch."""
    stacks = robots_of(control).stacks and control.dimension == 2
    return stacks and run.scenario.mismatch == NO_MISMATCH


def _part_of(control, run, rows):
    """Return what :func:`_fits_of` takes, of the robots ``rows``, a slice."""
    team = Team(control.team.kinds[rows], run.scenario.limits)
    same = {name: getattr(control, name) for name in ("l", "period", "saturation", "deadband")}
    part = SimpleNamespace(team=team, dimension=control.dimension, **same)
    columns = {name: getattr(run, name)[:, rows] for name in ("pose", "hand", "command")}
    return part, Run(run.time, run.robots[rows], scenario=run.scenario, meta=run.meta, **columns)


def _fits_of(control, run):
    """Return the :class:`Fits` of all robots at once."""
    names, rows = _channels(control.team)
    obeyed = np.array(
        [[_is_asked(kind, name) for name in own] for kind, own in zip(control.team.kinds, names)]
    )
    asked, went = _velocities(control, run)
    asked, went = (np.einsum("ncv,knv->knc", rows, each) for each in (asked, went))
    spread = np.array([kind.spread[run.scenario.fidelity] for kind in control.team.kinds])
    time = run.time - run.time[0]
    change = _changes(time, asked, spread)
    ramping = _ramping(control, run, change)
    duration = np.broadcast_to(np.diff(time)[:, np.newaxis], change.shape)
    seen, windows = (duration, asked, went, change, ramping), _parts(time)
    of_all = [_fitted(*seen, _slopes(duration, asked), spread)[:, np.newaxis]]
    if windows:
        slopes = [_slopes(duration[some], asked[some]) for some in windows]
        beside = [_beside([each[some] for some in windows]) for each in seen]
        of_parts = _fitted(*beside, _beside(slopes), np.tile(spread, (len(windows), 1)))
        of_all.append(of_parts.reshape((2, len(windows)) + of_all[0].shape[2:]))
    windows = [slice(0, len(asked)), *windows]
    return Fits(names, obeyed, spread, windows, *np.concatenate(of_all, axis=1))


def _slopes(duration, asked):
    """Return how fast ``asked`` (k, n, c) changes, at ways that take ``duration`` (k, n) [s]."""
    return np.gradient(asked, np.cumsum(duration[:, 0]), axis=0)


def _beside(windows):
    """Return arrays (k, n, ...) of windows as one, (k, w n, ...): all are fitted at once."""
    return np.concatenate(windows, axis=1)


def _can_be_fitted(control, run):
    scenario = run.scenario
    if scenario is None or scenario.fidelity == "point_mass" or not run.meta.get("lockstep"):
        return False
    team, environment, errors = control.team, scenario.environment, scenario.odometry_errors
    pushed = any(environment.wind) or environment.wave_height
    even = errors is None or (errors.Ed, errors.Eb) == (1.0, 1.0)
    short = (
        len(run.time) < FEWEST + 1 or (run.time[-1] - run.time[0]) / control.period > MOST_COMMANDS
    )
    known = len(run.robots) == team.n and are_stated(team) and not team.has_arms
    jumps = (
        control.links.faults or getattr(control, "JUMPS", False) or _senses_noise(control, scenario)
    )
    unseen = jumps and scenario.record_period > 1.5 * control.period  # between two samples
    return known and even and not (short or unseen or (pushed and scenario.fidelity == "dynamic"))


def _senses_noise(control, scenario):
    """Return whether the law reads sensors whose readings jump, by noise or because some are lost."""
    return any(
        noise.stddev or noise.dropout
        for own in (fitted_mounts(control.team, scenario.sensors) if control.SENSORS else ())
        for mount in own
        if mount.name in control.SENSORS
        for _, noise in mount.noise
    )


def _channels(team):
    """Return the names of each robot's wheels and axes, and how these go with its velocities, (n, 4, 4).

    Velocities are ahead, sideways and upwards [m/s] and turning [rad/s], in the order of ``SPEEDS``.
    """
    names, rows = [], np.zeros((team.n, len(SPEEDS), len(SPEEDS)))
    for row, kind in enumerate(team.kinds):
        turned = 0.5 * kind.body.width
        if kind.drive == "differential":
            turned = 0.5 * kind.numbers.track
            names.append(("left wheel", "right wheel", "sideways", ""))
            rows[row, :3] = [1.0, 0.0, -turned, 0.0], [1.0, 0.0, turned, 0.0], [0.0, 1.0, 0.0, 0.0]
            continue
        there = [axis in kind.axes for axis in SPEEDS]
        there[1] = there[1] or kind.module.MEDIUM == "ground"
        rows[row] = np.diag(np.where(there, [1.0, 1.0, turned, 1.0], 0.0))
        names.append(tuple(name if on else "" for name, on in zip(DIRECTIONS, there)))
    return names, rows


def _is_asked(kind, name):
    """Return whether commands say anything of a channel of this ``name``; wheels let nothing aside."""
    return bool(name) and (name != DIRECTIONS[1] or SPEEDS[1] in kind.axes)


def _velocities(control, run):
    """Return mean body velocities (m - 1, n, 4) between samples: as commanded, and as recorded."""
    duration = np.diff(run.time)[:, np.newaxis]
    drift = current_of(control, run)[:, :2] @ [1.0, 1j]
    z = np.zeros(run.pose.shape[:2]) if control.dimension == 2 else run.heights
    recorded = np.concatenate([run.pose, z[..., np.newaxis]], axis=2)
    asked = _body_speeds(duration, *commanded_ways(control, run), 0.0)
    return asked, _body_speeds(duration, recorded[:-1], recorded[1:], drift)


def _body_speeds(duration, before, after, drift):
    """Return what arcs between poses and heights (m - 1, n, 4) say of velocities, (m - 1, n, 4)."""
    way, turn, climb = (after - before)[..., :2], (after - before)[..., 2], (after - before)[..., 3]
    turn = wrap_angle(turn)
    along = way[..., 0] + 1j * way[..., 1] - drift * duration
    mean = along * np.exp(-1j * (before[..., 2] + 0.5 * turn)) / np.sinc(turn / (2.0 * np.pi))
    return np.stack([mean.real, mean.imag, turn, climb], axis=2) / duration[..., np.newaxis]


def _parts(time):
    """Return the windows of a run, slices of the ways between its samples, none if it is one itself."""
    size = max(FEWEST, int(np.ceil(WINDOW / np.median(np.diff(time)))))
    count = (len(time) - 1) // size
    return [slice(k * size, (k + 1) * size) for k in range(count)] if count > 1 else []


def _changes(time, asked, spread):
    """Return by how much commands have just changed, (k, n) [m/s]: such samples count the less.

    Looked at as far back as a dead time of the ``spread`` (n, 3) goes; robots begin at rest.
    """
    step = max_of_rows(np.abs(np.diff(asked, axis=0, prepend=0.0)))
    after = np.append(step[1:], step[-1:], axis=0)
    result = np.maximum(step, after)
    for back in range(1, 2 + int(spread[:, 1].max() / np.median(np.diff(time)))):
        result[back:] = np.maximum(result[back:], step[:-back])
    return result


def _ramping(control, run, change):
    """Return where robots go along ramps while not each command is recorded, (k, n) bool.

    The model may then be ahead of the robot, or behind, for as long as the ramps last.
    """
    if run.scenario.record_period < 1.5 * control.period:
        return np.zeros(change.shape, dtype=bool)
    team, ramps = control.team, np.zeros(control.team.n)
    for axis, steepest in zip(team.axes, team.limits.of_all(team.n).acceleration.T):
        turned = [0.5 * kind.body.width for kind in team.kinds] if axis == SPEEDS[2] else 1.0
        ramps += np.where(np.isfinite(steepest), steepest, np.inf) * turned
    return change > STEEP * ramps * np.diff(run.time)[:, np.newaxis]


def _fitted(duration, asked, went, change, ramping, slope, spread):
    """Return fits and their standard errors, (2, n, c, 3), of velocities (k, n, c) over a window.

    Of gain less 1, dead time [s] and bias [m/s]; ``spread`` (n, 3) of each; ``duration`` (k, n) [s] of the
    ways between samples; ``change``: :func:`_changes`; ``ramping`` (k, n): :func:`_ramping`; ``slope``:
    :func:`_slopes`.
    """
    spread = spread[:, np.newaxis]
    least = RESOLVED * spread[..., 2]
    share = 1.0 / np.hypot(1.0, ROUGH * change / least[:, 0])[..., np.newaxis]
    # All of these count as one.
    share[ramping] /= np.sqrt(np.broadcast_to(ramping.sum(axis=0), ramping.shape)[ramping])[
        :, np.newaxis
    ]
    share[change > HARSH * duration] = 0.0
    columns = share * asked, -share * slope, np.broadcast_to(share, asked.shape)
    off = share * (went - asked)
    square, target = np.empty((*asked.shape[1:], 3, 3)), np.empty((*asked.shape[1:], 3))
    for i, column in enumerate(columns):
        target[..., i] = _summed(column, off)
        for j, other in enumerate(columns[: i + 1]):
            square[..., i, j] = square[..., j, i] = _summed(column, other)
    prior = np.eye(3) * (spread**-2.0)[..., np.newaxis, :]
    # Residuals of a fit that may go far beyond the spread: what the model cannot explain at all.
    inverse = _inverses(square / least[..., np.newaxis, np.newaxis] ** 2 + 1e-6 * prior)
    free = np.einsum("ncij,ncj->nci", inverse, target / least[..., np.newaxis] ** 2)
    left = off - columns[0] * free[..., 0]
    left -= columns[1] * free[..., 1]
    left -= share * free[..., 2]
    power = _summed(left, left)
    noise = np.maximum(least, np.sqrt(power / len(left) * _repeated(left, power)))[..., np.newaxis]
    # Each with the other two held to their spread; 1e-9 of what is not excited at all.
    held = (1.0 + 1e-9) - np.eye(3)[:, np.newaxis, np.newaxis, np.newaxis]
    inverse = _inverses(square / noise[..., np.newaxis] ** 2 + prior * held)
    found = np.einsum("wncwj,ncj->ncw", inverse, target / noise**2)
    return np.stack([found, np.sqrt(np.einsum("wncww->ncw", inverse))])


def _inverses(matrix):
    """Return the inverses of symmetric positive definite ``matrix`` (..., 3, 3), as ``L D L^T`` gives them.

    LAPACK is called for each of thousands of such, and wakes its threads each time.
    """
    a, b, c = (matrix[..., 0, column] for column in range(3))
    first, second = b / a, c / a  # below the diagonal of L, as is third
    d = matrix[..., 1, 1] - first * b
    e = matrix[..., 1, 2] - first * c
    third = e / d
    f = matrix[..., 2, 2] - second * c - third * e
    corner = first * third - second
    result = np.empty_like(matrix)
    result[..., 0, 0] = 1.0 / a + first**2 / d + corner**2 / f
    result[..., 0, 1] = result[..., 1, 0] = -first / d - third * corner / f
    result[..., 0, 2] = result[..., 2, 0] = corner / f
    result[..., 1, 1] = 1.0 / d + third**2 / f
    result[..., 1, 2] = result[..., 2, 1] = -third / f
    result[..., 2, 2] = 1.0 / f
    return result


def _summed(first, second):
    """Return the sums (n, c) of products of (k, n, c) and (k, n, c)."""
    return np.einsum("knc,knc->nc", first, second)


def _repeated(left, power):
    """Return how many residuals (k, n, c), of ``power`` (n, c), count as one independent one, (n, c)."""
    rho = np.clip(_summed(left[1:], left[:-1]) / np.maximum(power, 1e-300), 0.0, 0.95)
    return (1.0 + rho) / (1.0 - rho)


def _check(which, fitted, run):
    """Return the check of the gains, dead times or biases."""
    found, bound = fitted.found[..., which], fitted.bound[..., which]
    known = fitted.decides[..., which]
    wrong = known & (np.abs(found) > bound)
    unsure = _unsure(run, ~known.any(axis=(0, 2)))
    exact = 1.0 if which == 0 else 0.0
    if not known.any():
        return Check(NAMES[which], exact, None, None, None, note=unsure)
    share = np.where(known, np.abs(found) / bound, -1.0)
    place = np.unravel_index(int(np.argmax(share)), share.shape)
    window, row, channel = place
    part, name = fitted.windows[window], fitted.names[row][channel]
    where = "robot{}, {}, {:.1f} to {:.1f} s".format(
        run.robots[row], name, run.time[part.start], run.time[part.stop]
    )
    value, most = float(found[place]), float(bound[place])
    note = ", ".join(filter(None, (where, unsure)))
    return Check(NAMES[which], exact, exact + value, most, bool(not wrong.any()), value, note)


def _unsure(run, silent):
    """Return of which robots, ``silent`` (n,) bool, a run does not show it, in words, or ""."""
    robots = ["robot{}".format(number) for number in run.robots[silent]]
    more = ", ..." if len(robots) > SHOWN else ""
    text = "undecided for {}{}: commands are too small, or too short"
    return text.format(", ".join(robots[:SHOWN]), more) if robots else ""
