"""Moving a tool by base and arm together: damped least squares within limits.

Of m robots with c inputs each, base speeds and joint rates, the tool moves by ``J x``, J (m, 3, c).
Inputs are scaled by the greatest speeds S, ``x = S y``.  For a wanted velocity u and
secondary inputs x0,

    x = x0 + S A' (A A' + lambda^2 I)^-1 (u - J x0),   A = J S,

moves the tool exactly by u, and is the nearest to x0 that does, where ``lambda = 0``: wherever the least
singular value sigma of A is at least ``EASY``.  Nearer to a singularity ``lambda^2 = DAMPING^2 (1 -
(sigma/EASY)^2)`` (Chiaverini, Siciliano and Egeland, IEEE Trans. Control Systems Technology, 1994).

Inputs that would go beyond their bounds are held there, and the others make up for them (Flacco, De Luca
and Khatib, IEEE Trans. Robotics, 2015, in its simplest form).
"""

import numpy as np

EASY = 0.05  # [m/s] least speed of the tool, with inputs of length 1 of their greatest, undamped
DAMPING = 0.05  # [m/s]
SMALL = 1e-12  # [-] beyond a bound


def tool_inputs(jacobians, wanted, besides, scale, low, high):
    """Return the inputs (m, c) with which tools move by ``wanted`` (m, 3) [m/s].

    ``jacobians`` (m, 3, c); ``besides`` (m, c): inputs wanted besides; ``scale`` (m, c): the greatest
    speeds, 0 for inputs that a robot has not; ``low``, ``high`` (m, c): bounds, 0 between them.
    """
    held, free = np.zeros_like(scale), scale > 0.0
    rest = np.clip(besides, low, high)
    for _ in range(scale.shape[1]):
        x = _solved(jacobians, wanted, np.where(free, rest, held), scale * free)
        beyond = free & ((x < low - SMALL) | (x > high + SMALL))
        if not beyond.any():
            break
        held = np.where(beyond, np.clip(x, low, high), held)
        free &= ~beyond
    return np.clip(x, low, high)


def _solved(jacobians, wanted, begin, scale):
    """Return ``begin`` (m, c) changed where ``scale`` is above 0, so that the tools move as wanted."""
    scaled = jacobians * scale[:, np.newaxis]
    square = scaled @ np.swapaxes(scaled, 1, 2)
    least = np.sqrt(np.maximum(np.linalg.eigvalsh(square)[:, 0], 0.0))
    short = np.maximum(1.0 - (least / EASY) ** 2, 0.0)
    square = square + (DAMPING**2 * short)[:, np.newaxis, np.newaxis] * np.eye(3)
    left = wanted - np.einsum("mic,mc->mi", jacobians, begin)
    found = np.linalg.solve(square, left[..., np.newaxis])[..., 0]
    return begin + scale * np.einsum("mic,mi->mc", scaled, found)
