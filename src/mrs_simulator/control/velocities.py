"""The velocities that a law returned, as arrays, and what is refused of them."""

import numpy as np

from mrs_simulator.control.positions import Neighbour, RaisedNeighbour
from mrs_simulator.control.twists import ControlError, described


def team_velocities(wanted, n, d):
    """Return what ``pointMassLaw`` returned as an array (n, d) [m/s].

    Raises ``ControlError`` if it is none.
    """
    u = _numbers(wanted)
    if u is None:
        text = "pointMassLaw returned {}, wanted an array {} of velocities"
        raise ControlError(text.format(described(wanted), (n, d)))
    if u.shape != (n, d):
        raise ControlError(
            "pointMassLaw returned shape {}, wanted {}: a velocity for each robot".format(
                u.shape, (n, d)
            )
        )
    return u


def own_velocity(wanted, robot, d):
    """Return what ``neighbourLaw`` returned for ``robot`` as an array (d,) [m/s].

    Raises ``ControlError`` if it is none.
    """
    velocity = _numbers(wanted)
    if velocity is None or velocity.shape != (d,):
        text = "neighbourLaw returned {} for robot {}, wanted {}"
        raise ControlError(
            text.format(described(wanted), robot, "(ux, uy, uz)" if d == 3 else "(ux, uy)")
        )
    return velocity


def neighbours_of(row, hand, turn, numbers, topology):
    """Return a ``Neighbour`` for each robot that the one in ``row`` receives data of, a tuple.

    ``hand`` (n, d) [m]: the points; ``turn`` (d, d) leads into the robot's frame by ``p @ turn``.
    """
    neighbour = Neighbour if hand.shape[1] == 2 else RaisedNeighbour.at
    return tuple(
        neighbour(numbers[other], *((hand[other] - hand[row]) @ turn).tolist(), weight)
        for other, weight in topology.weighted_neighbours(row)
    )


def turned_by(theta, d=2):
    """Return R(theta)^T (d, d) about z: ``v @ R`` is ``v`` as seen from a frame turned by theta."""
    cos, sin = np.cos(theta), np.sin(theta)
    if d == 2:
        return np.array([[cos, -sin], [sin, cos]])
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _numbers(value):
    """Return ``value`` as an array of floats, None where it is not numeric."""
    if value is None:
        return None
    try:
        found = np.asarray(value)
        # numpy would drop the imaginary parts with a warning
        return None if found.dtype.kind == "c" else np.asarray(found, dtype=float)
    except (TypeError, ValueError):
        return None
