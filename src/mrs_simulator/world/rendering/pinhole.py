"""Pinhole cameras by OpenGL's numbers: depths of its buffer, and fields of view."""

import math

import numpy as np

NOTHING = 1.0 - 1e-7  # [-] in a buffer of float32, which is as empty at 1 less its last digit


def depths(buffer, least, most):
    """Return the depth [m] in a ``buffer`` of OpenGL's, 0 at ``least`` and 1 at ``most`` [m], or beyond."""
    buffer = np.asarray(buffer, dtype=float)
    far = least * most / (most - (most - least) * buffer)
    return np.where(buffer < NOTHING, far, np.inf)


def upright_field(numbers):
    """Return the field of view [deg] of a camera from bottom to top, whose pixels are square."""
    return math.degrees(
        2.0 * math.atan(math.tan(0.5 * numbers.view) * numbers.height / numbers.width)
    )
