"""Attitudes and places as commands of quadrotors: velocities that bring them about."""

import numpy as np

from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.vehicles.drives.rotors import GRAVITY

PLACE_GAIN, YAW_GAIN = 2.0, 2.0  # [1/s] of errors of place and heading; chosen for the model


def response(kind, step):
    """Return ``(3,)`` [s]: the velocity by which a robot's is to be exceeded per acceleration, along x,
    y, z.

    ``v' = (v_wanted - v)/T`` over a ``step`` [s] gains ``(v_wanted - v)(1 - exp(-step/T))``, so that
    ``v_wanted = v + a step/(1 - exp(-step/T))`` gains ``a step``.
    """
    time = np.array(kind.numbers.response)
    return step / -np.expm1(-step / time)


def tilted(ahead, left, thrust, heading):
    """Return the acceleration (3,) [m/s^2] of a body tilted ``ahead`` and ``left`` [rad] with ``thrust``
    [m/s^2].

    Thrust per mass along the body's axis: pitched by ``ahead`` first, then rolled; common frame, weight
    included.
    """
    forward = np.sin(ahead) * np.cos(left) * thrust
    beside = np.sin(left) * thrust
    up = np.cos(ahead) * np.cos(left) * thrust
    cos, sin = np.cos(heading), np.sin(heading)
    return np.array([cos * forward - sin * beside, sin * forward + cos * beside, up - GRAVITY])


def towards(place, wanted, velocity=0.0):
    """Return the velocity (3,) [m/s] that closes the gap from ``place`` to ``wanted`` (3,) [m], which
    moves with ``velocity``: ``v = v_wanted + k (p_wanted - p)``."""
    return velocity + PLACE_GAIN * (np.asarray(wanted) - place)


def turning(heading, wanted, rate=0.0):
    """Return the turn rate [rad/s] that closes the gap from ``heading`` to ``wanted`` [rad]."""
    return rate + YAW_GAIN * float(wrap_angle(wanted - heading))


def command(velocity, rate, heading):
    """Return the command (4,) of a ``velocity`` (3,) [m/s], common frame, and a turn rate [rad/s]."""
    cos, sin = np.cos(heading), np.sin(heading)
    x, y, z = velocity
    return np.array([cos * x + sin * y, cos * y - sin * x, z, rate])
