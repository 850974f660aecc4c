"""Places of sensors on robots, in the common frame."""

import numpy as np

from mrs_simulator.core.kinematics import cos_sin


def carried(pose, place):
    """Return points (m, K, 2) [m] of the robots at ``pose`` (m, 3); ``place`` (K, 2) in their frames."""
    cos, sin = (each[:, np.newaxis] for each in cos_sin(pose[:, 2]))
    x, y = place[:, 0], place[:, 1]
    return np.stack([pose[:, :1] + cos * x - sin * y, pose[:, 1:2] + sin * x + cos * y], axis=-1)


def turned(theta, along):
    """Return the vectors ``along`` (K, 2) turned by headings ``theta`` (m,) [rad], (m, K, 2)."""
    cos, sin = (each[:, np.newaxis] for each in cos_sin(theta))
    c, s = along[:, 0], along[:, 1]
    return np.stack([cos * c - sin * s, sin * c + cos * s], axis=-1)


def echoes(ranges, place):
    """Return the points (..., K, 2) [m] ``ranges`` (..., K) away from ``place`` (K, 3): x, y, direction."""
    along = np.stack(cos_sin(place[:, 2]), axis=-1)
    with np.errstate(invalid="ignore"):  # infinite times 0
        return place[:, :2] + ranges[..., np.newaxis] * along
