"""The distances that the safety filter keeps between controlled points."""

import numpy as np


def sums_of_pairs(reach):
    """Return the sums of any two of ``reach`` (n,) or one number [m]: a number where all are the same."""
    if reach.ndim and (reach != reach[0]).any():
        return reach[:, np.newaxis] + reach
    return 2.0 * float(reach.flat[0])


def body_radii(team, fidelity):
    """Return the radii (n,) [m] of the discs, or balls, about centres of ``team`` that hold the bodies.

    Forces tilt bodies that fly about their middles.  In space balls stand about the places at which bodies
    begin, and are higher by the ``downwash``: their middles may lie apart by what bodies differ in height.
    """
    half = 0.5 * np.array(
        [kind.body.height if fly else 0.0 for kind, fly in zip(team.kinds, team.airborne.tolist())]
    )
    if fidelity == "point_mass" or not half.any():
        return team.reach
    tilted = np.hypot(team.reach, half) if fidelity == "dynamic" else team.reach
    if team.dimension == 2:
        return tilted
    upright = np.hypot(team.reach, half / team.downwash)
    middle = 0.5 * (half.min() + half.max())
    return np.maximum(tilted, upright) + np.abs(half - middle) / team.downwash


def tracking_errors(team, fidelity, cap=None):
    """Return the bounds on the tracking errors of ``team``, (n,) [m], 0 where robots obey at once.

    ``fidelity``: what moves them; ``cap`` (n,) [m/s]: the most that they are let go, None for their own.
    """
    if fidelity == "point_mass" or not team.is_spatial:
        return np.zeros(team.n)
    fastest = team.speeds[:, 0]
    return team.tracking(fastest if cap is None else np.minimum(fastest, cap))


def squash(team):
    """Return by what (d,) [-] distances of ``team`` are measured along x, y and z; None for 1.

    Above and below each other robots keep farther apart, for the air that rotors blow down.
    """
    if team.dimension == 2 or team.downwash == 1.0:
        return None
    return np.array([1.0, 1.0, 1.0 / team.downwash])
