"""Robots that wheel forces push: their wheels slide or have rollers, which the solver does not know."""

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.vehicles.team import columns_of
from mrs_simulator.world.motion.planar_body import GRAVITY, Footing, about, stiffness, wheel_forces


class WheelForces:
    """The wheel forces of the robots of one drive; m of them, ``rows`` (m,) of the team."""

    def __init__(self, group, members, rows, mass, inertia):
        """``members`` (m,): of the ``vehicles.team.Group``; ``mass`` [kg] and ``inertia`` [kg m^2] about
        the vertical through the centre of mass, (m,)."""
        self.members, self.rows = members, rows
        self._drive, self._mass, self._inertia = group.drive, mass, inertia
        kinds = [group.kinds[member] for member in members]
        self._numbers = columns_of(kinds, group.drive)
        self._friction = np.array([kind.numbers.friction for kind in kinds])
        self.reset()

    def reset(self):
        """Let the wheels have turned by nothing."""
        self.travel = np.zeros((len(self.rows), self._drive.ENCODERS))

    def aim(self, velocity, joints):
        """Hold the wheels at ``velocity`` (m, axes of the drive) with ``joints`` (m,) for the substeps."""
        stand = self._drive.stand(joints, self._numbers)
        grip = (GRAVITY * self._friction * self._mass)[:, np.newaxis] * stand.weight
        self._footing = Footing(
            about(stand.along, stand.ahead), about(stand.across, stand.ahead), grip, stand.push
        )
        self._joints, self.ahead = joints, stand.ahead
        self._gain = stiffness(self._footing, self._mass, self._inertia)
        self._rims = self._drive.rim_targets(velocity, joints, self._numbers)

    def push(self, pose, twist, duration):
        """Return forces (m, 3) [N], where they act (m, 2) [m], and torques (m,) [N m] about the vertical.

        ``pose`` (m, 3) and body ``twist`` (m, 3) of the centres; the encoders count for ``duration`` [s].
        """
        wrench = self.wrench(twist, duration)
        cos, sin = cos_sin(pose[:, 2])
        force = np.zeros((len(pose), 3))
        force[:, 0] = cos * wrench[:, 0] - sin * wrench[:, 1]
        force[:, 1] = sin * wrench[:, 0] + cos * wrench[:, 1]
        place = pose[:, :2] + self.ahead[:, np.newaxis] * np.stack([cos, sin], axis=1)
        return force, place, wrench[:, 2]

    def wrench(self, twist, duration):
        """Return the wrench (m, 3) [N, N, N m] in the bodies' frames, about a point ``ahead`` of centres.

        ``twist`` (m, 3) of the centres; the encoders count for ``duration`` [s].
        """
        moving = twist.copy()
        moving[:, 1] += self.ahead * twist[:, 2]
        wrench, turning = wheel_forces(moving, self._rims, self._footing, self._gain)
        self.travel += duration * self._drive.counted(turning, self._joints, self._numbers)
        return wrench
