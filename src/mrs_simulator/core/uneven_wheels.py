"""Wheels that differ from nominal ones: how robots move on them, and what their encoders count.

A robot with a left and a right wheel turns them as its nominal wheels would have to turn, and moves by
those that it has (Borenstein and Feng, UMBmark, 1994):

    v = (c_l r_l + c_r r_r)/2,    omega = (c_r r_r - c_l r_l)/(E_b b),    r_l, r_r = v_0 -+ omega_0 b/2,

with nominal velocities ``v_0``, ``omega_0`` and track ``b``, and the true diameters over the nominal one,
``c_l = 2/(E_d + 1)``, ``c_r = 2/(1/E_d + 1)``.  Commanded to go straight, it veers along a circle of radius
``R = E_b b (E_d + 1)/(2 (E_d - 1))``.  Odometry takes the counted turns for those of nominal wheels.
"""

import numpy as np

from mrs_simulator.core.kinematics import body_speeds, wheel_speeds


class UnevenWheels:
    """The wheels of all robots of a team, of the same ratios ``Ed`` and ``Eb``."""

    @classmethod
    def of(cls, errors):
        """Return the wheels of ``errors``, an ``OdometryErrors``; None for nominal ones."""
        given = errors is not None and (errors.Ed, errors.Eb) != (1.0, 1.0)
        return cls(errors) if given else None

    def __init__(self, errors):
        self._diameters, self._track = np.array(errors.wheels), errors.Eb
        half = 0.5 * np.array(
            [[1.0 + errors.Eb, 1.0 - errors.Eb], [1.0 - errors.Eb, 1.0 + errors.Eb]]
        )
        self._counts = (half / self._diameters[:, np.newaxis]).T

    def moved(self, group, velocity):
        """Return the velocities (m, axes) at which robots of a ``group`` move that hold ``velocity``."""
        if not group.drive.ENCODERS:
            return velocity
        track = group.numbers.track
        return body_speeds(wheel_speeds(velocity, track) * self._diameters, self._track * track)

    def counted(self, group, rolled):
        """Return what encoders count, (m, encoders) [m], where nominal wheels ``rolled`` the way."""
        return rolled @ self._counts if group.drive.ENCODERS else rolled
