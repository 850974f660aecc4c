"""Velocities that a law wants at places of one's own choice, of robots without limits and faults."""

import numpy as np

from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import scenario_from_dict

FLYING = "crazyflie2"  # whose points have three coordinates
OWN = ("protocol", "parameters", "rate", "dimension")  # of the scenario's control, what is kept


def ideal_scenario(scenario):
    """Return a scenario of points with the law, graph and start of ``scenario``, and nothing else."""
    given = scenario.to_dict()
    own = given.get("control", {})
    content = {
        "poses": scenario.poses[:, :3].tolist(),
        "fidelity": "point_mass",
        "limits": "none",
        "seed": scenario.seed,
        "control": {**{key: own[key] for key in OWN if key in own}, "saturation": "none"},
    }
    if scenario.control.dimension == 3:
        heights = scenario.starts[:, 3] if scenario.starts.shape[1] > 3 else np.ones(scenario.n)
        content.update(model=FLYING, altitude=heights.tolist())
    if "topology" in given:
        content["topology"] = given["topology"]
    return scenario_from_dict(content, scenario.path or "its points")._replace(path=scenario.path)


def velocities_at(scenario, points, theta, time, fresh, protocol=None):
    """Return the velocities (k, n, d) [m/s] wanted at ``points`` (k, n, d), all at ``time`` [s].

    ``theta`` (k, n): the robots' headings; ``fresh``: each state by a new instance of the law, else by
    one, in turn; ``protocol``: its class, where the scenario does not name it.  Raises ``ValueError`` for a
    law of sensors, whose readings places alone do not give.
    """
    control, found = make_control(scenario, protocol), []
    if control.SENSORS:
        text = "{} asks for sensors {}, wanted a law of positions"
        raise ValueError(text.format(type(control).__name__, ", ".join(control.SENSORS)))
    for row, pose in enumerate(_poses(control, points, theta)):
        if fresh and row:
            control = make_control(scenario, protocol)
        if fresh or not row:
            control.start()
        command = control.commands(pose, time)
        known = command, pose, control.joints, control.l, control.period
        found.append(control.team.velocity(*known))
    return np.array(found).reshape(np.shape(points))


def start_points(scenario, protocol=None):
    """Return the controlled points (n, d) [m] that the scenario begins with."""
    return make_control(scenario, protocol).points(scenario.starts)


def _poses(control, points, theta):
    """Return the poses (k, n, 3), in space (k, n, 4), that put the controlled points to ``points``."""
    points, theta = np.asarray(points, dtype=float), np.asarray(theta, dtype=float)
    poses = np.zeros(points.shape[:2] + (points.shape[2] + 1,))
    poses[..., 2], poses[..., 3:] = theta, points[..., 2:]
    for pose, wanted in zip(poses, points):
        pose[:, :2] = wanted[:, :2] - control.points(pose)[:, :2]
    return poses
