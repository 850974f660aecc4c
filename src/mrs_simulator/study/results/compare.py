"""A run on robots beside its simulation: how far apart they are, and what would explain it.

Robots are taken to move as their commands of a little while ago say, at a speed and a turn rate
that are off by a factor each:

    v(t) = s_v v_obeyed(t - d),    omega(t) = s_omega omega_obeyed(t - d)

``v_obeyed`` and ``omega_obeyed`` are what the commands of the run make of robots at rest, by the limits
and ramps of its scenario; of a run without one, the commands.  ``d`` [s] is found by a search, the
factors by least squares, for the real run and for the simulated one, which is a little late itself.
What differs between the two is the estimate, in the form in which a scenario takes it as ``mismatch``
(``scenario/team/mismatch.py``): ``s_v`` is the scale of the speed, ``s_v / s_omega`` that of the track.
"""

import json
import math
import os
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import UNICYCLE_AXES, clip_commands, ramp, wrap_angle
from mrs_simulator.core.writing import write_text
from mrs_simulator.record.recording import RunError
from mrs_simulator.vehicles.team import Team

LONGEST_DELAY = 1.5  # [s] that is looked for
DELAY_STEP = 0.005  # [s]
PARTS = 5  # [-] of the time between two samples
LEAST_MOTION = 0.02  # [m/s, rad/s] root mean square of commands that a factor is estimated from
FIGURE, FILE = "compare", "compare.json"


class Fit(NamedTuple):
    """What a run's motion says of its robots; arrays (n,), NaN where the run does not show it."""

    delay: float  # [s]
    speed: np.ndarray  # [-] s_v
    turn: np.ndarray  # [-] s_omega
    speed_error: np.ndarray  # [-] standard error of s_v
    turn_error: np.ndarray  # [-] standard error of s_omega
    speed_left: np.ndarray  # [m/s] root mean square of what is left unexplained
    turn_left: np.ndarray  # [rad/s] the same of the turn rate


def motion_of(run):
    """Return the mean speed (m-1, n) [m/s] and turn rate [rad/s] between the samples of ``run``."""
    step = np.diff(run.time)[:, np.newaxis]
    moved = np.diff(run.pose[:, :, :2], axis=0)
    turned = wrap_angle(np.diff(run.pose[:, :, 2], axis=0))
    heading = run.pose[:-1, :, 2] + 0.5 * turned
    along = moved[:, :, 0] * np.cos(heading) + moved[:, :, 1] * np.sin(heading)
    # The chord of an arc is a little shorter than the way along it.
    half = 0.5 * turned
    return along / np.sinc(half / np.pi) / step, turned / step


def given(run):
    """Return the forward speeds and turn rates (m, n, 2) [m/s, rad/s] that were commanded.

    Zero where the robots obey no such axis; sideways commands of omnidirectional ones are left out,
    as their sideways motion is by :func:`motion_of`.
    """
    none = np.zeros(run.command.shape[:2])
    columns = {axis: run.command[:, :, column] for column, axis in enumerate(run.axes)}
    return np.stack([columns.get(axis, none) for axis in UNICYCLE_AXES], axis=2)


def obeyed(run):
    """Return times (k,) [s], and what the commands ``given`` make of robots at rest then, (k, n, 2).

    By the limits and ramps of the run's scenario, ``PARTS`` times between two samples, between which
    commands are taken to change evenly; without a scenario the commands at the samples.
    """
    command, scenario = given(run), run.scenario
    if scenario is None or scenario.fidelity == "point_mass" or len(run.robots) != scenario.n:
        return run.time, command
    team = Team.from_scenario(scenario)
    columns = dict(zip(team.axes, np.transpose(team.limits.of_all(team.n), (2, 0, 1))))
    free = np.full((2, team.n), np.inf)
    top, acceleration = np.transpose([columns.get(axis, free) for axis in UNICYCLE_AXES], (1, 2, 0))
    rows = np.arange(PARTS * (len(command) - 1) + 1) / PARTS
    time = np.interp(rows, np.arange(len(command)), run.time)
    at, share = rows.astype(int), (rows % 1.0)[:, np.newaxis, np.newaxis]
    then = command[np.minimum(at + 1, len(command) - 1)]
    command = clip_commands(command[at] + share * (then - command[at]), top)
    speed = np.zeros_like(command)
    speed[0] = np.where(np.isinf(acceleration), command[0], 0.0)
    for row, step in enumerate(np.diff(time)):
        speed[row + 1], _ = ramp(speed[row], command[row + 1], acceleration, step)
    return time, speed


def late(samples, time, speed, delay):
    """Return the mean of ``speed``, ``delay`` [s] late, between ``samples`` (m,) [s], (m-1, n, 2).

    Between the times at which ``speed`` (k, n, 2) is known it is taken to change evenly, before the
    first to be zero.
    """
    step = np.diff(time)
    pieces = 0.5 * (speed[1:] + speed[:-1]) * step[:, np.newaxis, np.newaxis]
    sums = np.concatenate([np.zeros_like(speed[:1]), np.cumsum(pieces, axis=0)])
    then = samples - delay
    at = np.clip(np.searchsorted(time, then, side="right") - 1, 0, len(step) - 1)
    inside = np.clip(then - time[at], 0.0, None)[:, np.newaxis, np.newaxis]
    slope = (speed[at + 1] - speed[at]) / step[at][:, np.newaxis, np.newaxis]
    total = sums[at] + speed[at] * inside + 0.5 * slope * inside**2
    return np.diff(total, axis=0) / np.diff(samples)[:, np.newaxis, np.newaxis]


def fit(run):
    """Return the ``Fit`` of ``run``: one delay for the team, factors for each robot."""
    if len(run.time) < 10:
        raise RunError("{} samples: wanted at least 10 to compare".format(len(run.time)))
    measured = np.stack(motion_of(run), axis=2)
    scale = np.maximum(np.sqrt(np.mean(measured**2, axis=0)), 1e-9)

    speed = obeyed(run)

    def unexplained(delay):
        return float(np.sum(_explained(measured, late(run.time, *speed, delay))[1] / scale**2))

    delays = np.arange(0.0, LONGEST_DELAY, DELAY_STEP)
    delay = float(delays[np.argmin([unexplained(each) for each in delays])])
    wanted = late(run.time, *speed, delay)
    factor, left = _explained(measured, wanted)
    power = np.mean(wanted**2, axis=0)
    factor = np.where(power > LEAST_MOTION**2, factor, np.nan)
    error = np.sqrt(left / np.maximum(power, 1e-12) / len(measured))
    left = np.sqrt(left)
    return Fit(delay, *factor.T, *error.T, *left.T)


def _explained(measured, wanted):
    """Return the best factors (n, 2) of ``wanted`` (m, n, 2), and the mean squares left (n, 2)."""
    power = np.maximum(np.sum(wanted**2, axis=0), 1e-12)
    factor = np.sum(measured * wanted, axis=0) / power
    return factor, np.mean((measured - factor * wanted) ** 2, axis=0)


def compared(real, simulated):
    """Return how ``real`` and ``simulated`` differ, the plain mapping that ``compare.json`` holds.

    Raises ``RunError`` if they are not of the same robots, or share no time.
    """
    if real.robots.tolist() != simulated.robots.tolist():
        text = "robots {} and {}: wanted two runs of the same"
        raise RunError(text.format(real.robots.tolist()[:10], simulated.robots.tolist()[:10]))
    here, there = fit(real), fit(simulated)
    time, apart = distances(real, simulated)
    speed, turn = here.speed / there.speed, here.turn / there.turn
    with np.errstate(divide="ignore", invalid="ignore"):  # a dead robot does not turn
        track = speed / turn
    speed_error = np.hypot(here.speed_error, speed * there.speed_error) / np.abs(there.speed)
    turn_error = np.hypot(here.turn_error, turn * there.turn_error) / np.abs(there.turn)
    robots = [
        {
            "robot": int(number),
            "speed_scale": _rounded(speed[row]),
            "speed_scale_error": _rounded(speed_error[row]),
            "track_scale": _rounded(track[row]),
            "track_scale_error": _rounded(math.hypot(speed_error[row], turn_error[row])),
            "speed_left": [_rounded(here.speed_left[row]), _rounded(there.speed_left[row])],
            "turn_left": [_rounded(here.turn_left[row]), _rounded(there.turn_left[row])],
            "most_apart": _rounded(apart[:, row].max()),
            "apart_at_end": _rounded(apart[-1, row]),
        }
        for row, number in enumerate(real.robots)
    ]
    delay = here.delay - there.delay
    scales = np.where(np.isfinite([speed, track]), [speed, track], 1.0).round(4)
    return {
        "delay": round(delay, 6),
        "delays": [here.delay, there.delay],
        "duration": float(time[-1] - time[0]),
        "robots": robots,
        "mismatch": {
            "delay": max(0.0, round(delay, 3)),
            "speed": scales[0].tolist(),
            "track": scales[1].tolist(),
        },
    }


def distances(real, simulated):
    """Return times (m,) [s] that both runs share, and how far apart robots are then, (m, n) [m]."""
    begin, end = max(real.time[0], simulated.time[0]), min(real.time[-1], simulated.time[-1])
    time = real.time[(real.time >= begin) & (real.time <= end)]
    if len(time) < 2:
        raise RunError("the runs share no time")
    there = np.stack(
        [
            [np.interp(time, run.time, run.pose[:, row, axis]) for axis in (0, 1)]
            for run in (simulated,)
            for row in range(len(run.robots))
        ]
    )
    here = real.pose[np.isin(real.time, time)][:, :, :2]
    return time, np.linalg.norm(here - there.transpose(2, 0, 1), axis=2)


def _rounded(value):
    return None if not math.isfinite(value) else float("{:.6g}".format(value))


def comparison_text(result):
    """Return ``result`` of :func:`compared` as a short table for a terminal."""
    lines = ["delay of the real robots beyond the simulated ones: {:.3f} s".format(result["delay"])]
    row = "  {:8} {:>18} {:>18} {:>10} {:>10}"
    lines.append(row.format("", "speed scale", "track scale", "most apart", "at end"))
    for robot in result["robots"]:
        scales = [_scale(robot, name) for name in ("speed_scale", "track_scale")]
        apart = ["{:.3f} m".format(robot[name]) for name in ("most_apart", "apart_at_end")]
        lines.append(row.format("robot{}".format(robot["robot"]), *scales, *apart))
    values = json.dumps(result["mismatch"]).replace('"', "")
    lines.append("  as a scenario takes it: mismatch: {}".format(values))
    return "\n".join(lines)


def _scale(robot, name):
    if robot[name] is None:
        return "not known"
    return "{:.3f} +- {:.3f}".format(robot[name], 2.0 * robot[name + "_error"])


def write_comparison(real, simulated, out, formats=("png", "pdf")):
    """Write ``compare.json`` and the overlaid figure to ``out``; return the mapping."""
    from mrs_simulator.study.draw.canvas import new_figure, save, settle
    from mrs_simulator.study.draw.compare_figure import draw_comparison

    result = compared(real, simulated)
    os.makedirs(out, exist_ok=True)
    write_text(os.path.join(out, FILE), json.dumps(result, indent=2, allow_nan=False) + "\n")
    figure = new_figure(6.5, 6.5)
    draw_comparison(figure, real, simulated, *distances(real, simulated))
    settle(figure)
    for kind in formats:
        save(figure, os.path.join(out, "{}.{}".format(FIGURE, kind)))
    return result
