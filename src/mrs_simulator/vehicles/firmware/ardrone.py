"""The AR.Drone's Twist, whose components are shares of its greatest angles and speeds.

As ardrone_autonomy hands them on: ``linear.x`` tilts ahead, ``linear.y`` to the left, both by shares of
``euler_angle_max``; ``linear.z`` is a share of ``control_vz_max``, ``angular.z`` of ``control_yaw``,
counter-clockwise.
All six components zero is the hover mode; with ``angular.x`` or ``angular.y`` the robot stays level
instead.
"""

import numpy as np

from mrs_simulator.vehicles.drives.rotors import GRAVITY
from mrs_simulator.vehicles.firmware import flying

NOTHING = 1e-6  # [-] of a component, below which it is zero
UNKNOWN, LANDED, FLYING, HOVERING, RISING, LANDING = 0, 2, 3, 4, 6, 8  # state of navdata
STATES = {
    "landed": LANDED,
    "flying": FLYING,
    "hovering": HOVERING,
    "taking off": RISING,
    "landing": LANDING,
}


def shares(twist):
    """Return ``twist`` (6,) cut to -1..1; nan is zero."""
    return np.clip(np.nan_to_num(twist, nan=0.0), -1.0, 1.0)


def command(twist, velocity, heading, kind, top, response):
    """Return the command (4,), level velocities and turn rate, of ``twist`` (6,), shares.

    ``velocity`` (3,) [m/s], common frame, and ``heading`` [rad] of the robot; ``top`` (4,): its limits;
    ``response`` as of ``flying.response``.
    """
    if (np.abs(twist) < NOTHING).all():  # the hover mode
        return np.zeros(4)
    tilt = kind.numbers.tilt_max * twist[:2]
    # Its own controller keeps the height, so that thrust grows with the tilt.
    thrust = GRAVITY / (np.cos(tilt[0]) * np.cos(tilt[1]))
    wanted = velocity + response * flying.tilted(*tilt, thrust, heading)
    wanted[2] = twist[2] * top[2]
    return flying.command(wanted, twist[5] * top[3], heading)
