"""Positions and neighbours as laws get them: in the common frame, and relative to a robot."""

from typing import NamedTuple


class Position(NamedTuple):
    """A robot's position in the common frame: x, y [m], theta [rad] of its centre.

    The centre is the wheel-axle centre of robots with an axle.  ``z`` [m] is an attribute; a position
    unpacks to x, y and theta.
    """

    x: float
    y: float
    theta: float

    @property
    def z(self):
        """Return the height [m]: 0 on the ground."""
        return 0.0


class RaisedPosition(Position):
    """The :class:`Position` of a robot in a team that leaves the ground, with a height ``z`` of its own."""

    z = 0.0

    @classmethod
    def at(cls, pose, z):
        """Return the position at ``pose`` (x, y, theta) and height ``z`` [m]."""
        position = cls._make(pose)
        position.z = z
        return position


class Neighbour(NamedTuple):
    """A neighbour of a robot: relative position of its hand point [m] and the edge's weight."""

    number: int
    x: float
    y: float
    weight: float


class RaisedNeighbour(Neighbour):
    """A :class:`Neighbour` in a law of points in space, whose relative height ``z`` [m] is an attribute."""

    z = 0.0

    @classmethod
    def at(cls, number, x, y, z, weight):
        """Return the neighbour ``number`` at relative position ``(x, y, z)`` [m]."""
        neighbour = cls(number, x, y, weight)
        neighbour.z = z
        return neighbour
