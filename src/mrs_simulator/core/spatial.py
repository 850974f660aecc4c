"""The state of robots in space beyond the planar one: height, orientation and the rest of the twist.

A team on the ground has no such state: None.
Quaternions are ``x, y, z, w`` as in ``geometry_msgs/Quaternion``; body frames are those of REP 103, x
ahead, y to the left, z up.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin


class Spatial(NamedTuple):
    """What belongs to poses and twists (..., n, 3) of the same robots."""

    # (..., n) [m] height of the robots' reference above the ground, 0 when they stand on it
    z: np.ndarray
    orientation: np.ndarray  # (..., n, 4), unit quaternions of the body frames in the common frame
    twist: np.ndarray  # (..., n, 3) vz [m/s], wx, wy [rad/s], body frame

    def of(self, rows):
        """Return the ``Spatial`` of the robots in ``rows``, of a state at one time."""
        return Spatial(self.z[rows], self.orientation[rows], self.twist[rows])

    def put(self, rows, part):
        """Write ``part``, the ``Spatial`` of the robots in ``rows``, of a state at one time."""
        self.z[rows], self.orientation[rows], self.twist[rows] = part

    def copy(self):
        """Return a copy with its own arrays."""
        return Spatial(*map(np.copy, self))


def upright(theta, z=0.0):
    """Return the ``Spatial`` of robots at rest that stand upright at headings ``theta`` (..., n) [rad]."""
    theta = np.asarray(theta, dtype=float)
    z = np.broadcast_to(np.asarray(z, dtype=float), theta.shape).copy()
    return Spatial(z, turned_about_z(theta), np.zeros(theta.shape + (3,)))


def turned_about_z(theta):
    """Return the quaternions (..., 4) of turns by ``theta`` (...) [rad] about the vertical."""
    cos, sin = cos_sin(0.5 * np.asarray(theta, dtype=float))
    result = np.zeros(cos.shape + (4,))
    result[..., 2], result[..., 3] = sin, cos
    return result


def turned(orientation, theta):
    """Return quaternions (..., 4) turned by ``theta`` (...) [rad] about the vertical: ``q_z(theta) q``."""
    cos, sin = cos_sin(0.5 * np.asarray(theta, dtype=float))
    x, y, z, w = np.moveaxis(orientation, -1, 0)
    parts = cos * x - sin * y, cos * y + sin * x, cos * z + sin * w, cos * w - sin * z
    return np.stack(parts, axis=-1)


def quaternion_product(first, second):
    """Return the quaternions (..., 4) of the turns ``second`` followed by ``first``, in the fixed frame."""
    a, b = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    vector = a[..., 3:] * b[..., :3] + b[..., 3:] * a[..., :3] + np.cross(a[..., :3], b[..., :3])
    scalar = a[..., 3] * b[..., 3] - np.sum(a[..., :3] * b[..., :3], axis=-1)
    return np.concatenate([vector, scalar[..., np.newaxis]], axis=-1)


def rotated(orientation, vectors):
    """Return ``vectors`` (..., 3) turned by unit quaternions (..., 4): ``v + 2 u x (u x v + w v)``."""
    turn = np.asarray(orientation, dtype=float)
    u, w = turn[..., :3], turn[..., 3:]
    return vectors + 2.0 * np.cross(u, np.cross(u, vectors) + w * vectors)


def headings(orientation):
    """Return the headings (...) [rad] of unit quaternions (..., 4), whatever their roll and pitch."""
    turn = np.asarray(orientation, dtype=float)
    x, y, z, w = turn.T if turn.ndim == 2 else np.moveaxis(turn, -1, 0)
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def about_z(theta):
    """Return the rotation matrices (n, 3, 3) of turns by ``theta`` (n,) [rad] about the vertical."""
    cos, sin = cos_sin(np.asarray(theta, dtype=float))
    zero, one = np.zeros(len(cos)), np.ones(len(cos))
    rows = (cos, -sin, zero), (sin, cos, zero), (zero, zero, one)
    return np.moveaxis(np.array(rows), -1, 0)


def rotations(orientation):
    """Return the rotation matrices (n, 3, 3) of unit quaternions (n, 4)."""
    x, y, z, w = np.asarray(orientation, dtype=float).T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    return np.moveaxis(np.array(rows), -1, 0)
