"""Checks of measured poses and predicted paths before real robots are driven.

Poses are of the wheel-axle centres in the common frame, (n, 3) [m, m, rad]; NaN: not known.
"""

import math
from typing import NamedTuple

import numpy as np

from mrs_simulator.control.guards import PLACE, outside, pairs_nearer
from mrs_simulator.control.stopping import LEVEL, LINEAR, UPRIGHT, greatest_speed, stopping_way
from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.core.neighbours import closest_pair, least_distance
from mrs_simulator.study.run.experiment import Experiment, LawFailed
from mrs_simulator.vehicles import Team

PLACE_TOLERANCE = 0.3  # [m], [rad]
MIN_DISTANCE = 1.0  # [m] between centres
# What a person who sees the robots may judge otherwise; it takes knowing where they are.
JUDGED = ("stands in place", "distances", "predicted distances")


class Check(NamedTuple):
    """One line of the table."""

    subject: str
    passed: bool
    text: str


def reception_checks(numbers, ages, timeout, topics):
    """Return whether each robot publishes and is fresh.

    ``ages`` (n,) [s]: the longest that each was silent, ``inf`` if never received; ``timeout`` [s];
    ``topics``: names of each robot's.
    """
    checks = []
    for number, age, name in zip(numbers, ages, topics):
        received = math.isfinite(age)
        text = name if received else "never received on {}: is its driver running?".format(name)
        checks.append(Check("robot{} publishes".format(number), received, text))
        text = "silent for up to {:.2f} s, wanted at most {:g} s".format(age, timeout)
        if received:
            checks.append(Check("robot{} is fresh".format(number), age <= timeout, text))
    return checks


def sensor_check(names, missing):
    """Return whether every robot's sensors ``names`` are received; ``missing``: which are not, in words."""
    return Check("sensors heard", not missing, missing or ", ".join(names))


def place_checks(numbers, pose, wanted, tolerance=PLACE_TOLERANCE):
    """Return whether each robot that is known stands at its pose in ``wanted`` (n, 3).

    ``tolerance``: of the distance [m] and of the heading [rad].
    """
    checks = []
    for number, here, there in zip(numbers, pose, wanted):
        if not np.isfinite(here).all():
            continue
        distance = math.hypot(here[0] - there[0], here[1] - there[1])
        turn = float(wrap_angle(here[2] - there[2]))
        text = (
            "at {}, {:.2f} m and {:.2f} rad from the scenario's {}, wanted at most {:g} m and rad"
        )
        text = text.format(shown(here), distance, turn, shown(there), tolerance)
        passed = distance <= tolerance and abs(turn) <= tolerance
        checks.append(Check("robot{} stands in place".format(number), passed, text))
    return checks


def distance_check(numbers, pose, least=MIN_DISTANCE):
    """Return whether all centres are known to be at least ``least`` [m] apart."""
    near = pairs_nearer(pose, least)
    text = _unknown(pose) if len(pose) > 1 else ""
    if near:
        text = ", ".join(
            "robot{} and robot{} {:.2f} m apart".format(numbers[i], numbers[j], distance)
            for i, j, distance in near
        )
        text += ", wanted {:g} m".format(least)
    return Check("distances", not text, text or "all at least {:g} m apart".format(least))


def _unknown(pose):
    return "" if np.isfinite(pose).all() else "not checked: not all poses are known"


def fence_check(numbers, pose, fence):
    """Return whether all robots are known to stand inside ``fence`` [m]."""
    beyond = outside(pose, fence)
    text = ", ".join("robot{} at {} outside".format(numbers[i], shown(pose[i])) for i in beyond)
    text = text or _unknown(pose)
    return Check("geofence", not text, text or "all inside")


def speed_check(scenario, speeds=(math.inf, math.inf)):
    """Return whether speeds are limited: by the scenario, or by ``speeds`` [m/s, rad/s] for all."""
    # The fastest robot's.
    top = Team.from_scenario(scenario).speeds.max(axis=0).tolist()
    v_max, omega_max = map(min, zip(top, speeds))
    text = "{:.2f} m/s, {:.2f} rad/s".format(v_max, omega_max)
    if np.isfinite(speeds).all():
        return Check("speed limits", True, text)
    if not np.isfinite([v_max, omega_max]).all():
        text = "the scenario has none, wanted limits: {v_max: ..., omega_max: ...}"
    elif scenario.fidelity == "point_mass":
        text = "fidelity: point_mass knows no limits, wanted another fidelity"
    elif scenario.control.saturation == "none":
        text = "control.saturation: none leaves the law's speeds as they are"
    else:
        return Check("speed limits", True, text)
    return Check("speed limits", False, text)


def stopping_check(team, hold, v_max, pose, least=MIN_DISTANCE, fence=None):
    """Return whether robots at ``v_max`` [m/s], as fast as they may be, can keep to the bounds.

    Twice the way in which they stand, ``hold`` [s] for which they go on included, must fit between the
    sides of ``fence`` [m], and between any two of the starts ``pose`` beyond ``least`` [m].  The way is
    the longest of all directions in which the robots move, astern, across, up and down among them.
    """
    bounds = []
    if fence is not None:
        bounds.append(("geofence", min(fence[2] - fence[0], fence[3] - fence[1]), LEVEL))
        if len(fence) == 6 and "linear.z" in team.axes:
            bounds.append(("geofence, heights", fence[5] - fence[4], UPRIGHT))
    if least > 0.0 and len(pose) > 1 and np.isfinite(pose).all():
        places = pose[:, PLACE[: pose.shape[1] - 1]]
        bounds.append(("least distance", float(least_distance(places)) - least, LINEAR))
    if not bounds or not np.isfinite(v_max):
        return []
    wrong = []
    for name, room, axes in bounds:
        way = stopping_way(team, v_max, hold, axes)
        if 2.0 * way > room:
            speed = greatest_speed(team, 0.5 * max(room, 0.0), hold, v_max, axes)
            text = "{}: {:.2f} m free, wanted {:.2f} m at {:.2f} m/s; {:.2f} m/s would hold"
            wrong.append(text.format(name, room, 2.0 * way, v_max, int(100.0 * speed) / 100.0))
    way = stopping_way(team, v_max, hold)
    text = "; ".join(wrong) or "{:.2f} m from {:.2f} m/s".format(way, v_max)
    return [Check("stopping way", not wrong, text)]


def predicted_checks(scenario, pose, least=MIN_DISTANCE, fence=None):
    """Return whether the paths that the simulator predicts from ``pose`` keep to the bounds.

    ``least`` [m] between centres; ``fence`` ``[x_min, y_min, x_max, y_max]`` [m] or None.
    """
    if not np.isfinite(pose).all():
        return [Check("predicted paths", False, "not predicted: not all poses are known")]
    fidelity = "kinematic" if scenario.fidelity == "point_mass" else scenario.fidelity
    scenario = scenario._replace(poses=pose, odometry="world", fidelity=fidelity)
    try:
        time, track, collisions = predicted(scenario)
    except (ValueError, LawFailed) as error:
        return [Check("predicted paths", False, "not predicted: {}".format(error))]
    checks = [_predicted_distance(time, track, least)]
    if fence is not None:
        checks.append(_predicted_fence(time, track, fence))
    if collisions:
        first = collisions[0]
        text = "{} with {} at {:.1f} s".format(first.first, first.second, first.time)
        checks.append(Check("predicted collisions", False, text))
    return checks


def predicted(scenario):
    """Return the time (m,) [s], the poses (m, n, 3) and the collisions of a headless run."""
    experiment = Experiment(scenario)
    try:
        samples = [(time, pose.copy()) for time, pose, _ in experiment.samples()]
    finally:
        experiment.world.close()
    time, track = zip(*samples)
    return np.array(time), np.array(track), experiment.collisions


def _predicted_distance(time, track, least):
    name = "predicted distances"
    if track.shape[1] < 2:
        return Check(name, True, "one robot")
    closest = [closest_pair(pose[:, :2]) for pose in track]
    when = min(range(len(closest)), key=lambda sample: closest[sample][2])
    first, second, apart = closest[when]
    text = "least {:.2f} m, robot{} and robot{} at {:.1f} s, wanted {:g} m".format(
        apart, first + 1, second + 1, time[when], least
    )
    return Check(name, apart >= least, text)


def _predicted_fence(time, track, fence):
    for stamp, pose in zip(time, track):
        beyond = outside(pose, fence)
        if beyond:
            text = "robot{} leaves it at {}, after {:.1f} s"
            text = text.format(beyond[0] + 1, shown(pose[beyond[0]]), stamp)
            return Check("predicted geofence", False, text)
    return Check("predicted geofence", True, "all stay inside for {:g} s".format(time[-1]))


def shown(pose):
    """Return a pose as a person reads it."""
    return "({:.2f}, {:.2f}, {:.2f})".format(*pose)


def table(checks):
    """Return the checks as lines of text."""
    width = max(len(check.subject) for check in checks)
    return "\n".join(
        "{:6}  {:{}}  {}".format("OK" if c.passed else "NOT OK", c.subject, width, c.text)
        for c in checks
    )


def as_rows(checks):
    """Return the checks as plain mappings for other programs: robot ("" for the team), what, ..."""
    rows = []
    for check in checks:
        first, _, rest = check.subject.partition(" ")
        robot, what = (first, rest) if first[:5] == "robot" else ("", check.subject)
        value, _, wanted = check.text.partition(", wanted ")
        row = {"robot": robot, "what": what, "passed": bool(check.passed), "value": value}
        rows.append(dict(row, wanted=wanted, judged=what in JUDGED))
    return rows
