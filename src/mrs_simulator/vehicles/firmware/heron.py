"""The Heron's commands besides speed and turn rate, as heron_controller takes them."""

import numpy as np

from mrs_simulator.core.kinematics import wrap_angle

COURSE_GAIN = 0.3  # [1/s] of the heading's error


def drive(left, right):
    """Return the efforts (4,) of thruster commands ``left`` and ``right``, -1..1."""
    return np.array([np.clip(left, -1.0, 1.0), np.clip(right, -1.0, 1.0), np.nan, np.nan])


def helm(thrust, numbers):
    """Return the efforts (4,) of a share of the greatest ``thrust``, -1..1; the turn rate is controlled."""
    share = np.clip(thrust, -1.0, 1.0)
    force = 2.0 * share * (numbers.most if share > 0.0 else -numbers.least)
    return np.array([np.nan, np.nan, force, np.nan])


def wrench(force, torque):
    """Return the efforts (4,) of a ``force`` ahead [N] and a ``torque`` [N m] counter-clockwise."""
    return np.array([np.nan, np.nan, force, torque])


def course(yaw, speed, heading):
    """Return the command (2,): ``speed`` [m/s], and the turn rate [rad/s] to ``yaw`` [rad],
    counter-clockwise from east."""
    return np.array([speed, COURSE_GAIN * float(wrap_angle(yaw - heading))])
