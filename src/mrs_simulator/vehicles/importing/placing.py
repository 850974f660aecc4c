"""Rigid transforms as 4 x 4 matrices, (4, 4), that take points of one frame into another."""

import numpy as np


def transform_at(xyz, rpy):
    """Return the transform of a frame at ``xyz`` [m], turned by roll, pitch and yaw ``rpy`` [rad].

    ``R = Rz(yaw) Ry(pitch) Rx(roll)``, the fixed-axis angles of URDF.
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    result = np.eye(4)
    result[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    result[:3, 3] = xyz
    return result


def inverse_transform(transform):
    """Return the inverse of ``transform``."""
    result = np.eye(4)
    result[:3, :3] = transform[:3, :3].T
    result[:3, 3] = -transform[:3, :3].T @ transform[:3, 3]
    return result


def roll_pitch_yaw(transform):
    """Return the angles (3,) [rad] with which ``transform_at`` gives the rotation of ``transform``."""
    turn = transform[:3, :3]
    level = np.hypot(turn[0, 0], turn[1, 0])
    if level < 1e-9:  # pitch of a right angle: roll and yaw turn about one axis
        return np.array([np.arctan2(-turn[1, 2], turn[1, 1]), np.arctan2(-turn[2, 0], level), 0.0])
    return np.array(
        [
            np.arctan2(turn[2, 1], turn[2, 2]),
            np.arctan2(-turn[2, 0], level),
            np.arctan2(turn[1, 0], turn[0, 0]),
        ]
    )
