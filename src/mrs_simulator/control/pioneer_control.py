"""``PioneerControl``: the control of n robots by one function that a researcher rewrites."""

from typing import NamedTuple

import numpy as np
from geometry_msgs.msg import Twist

from mrs_simulator.core.formation import HAND_LENGTH
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import (
    NO_LIMITS,
    hand_points,
    point_mass_from_unicycle,
    saturate,
    unicycle_from_point_mass,
)
from mrs_simulator.core.parameters import checked_values
from mrs_simulator.core.protocols.safety import safe_velocities

RESERVED = (
    "numbers",
    "topology",
    "limits",
    "saturation",
    "parameters",
    "period",
    "time",
    "fidelity",
)


class Position(NamedTuple):
    """A robot's position in the common frame: x, y [m], theta [rad] of the wheel-axle centre."""

    x: float
    y: float
    theta: float


class Neighbour(NamedTuple):
    """A robot that another hears: relative position of its hand point [m] and the edge's weight."""

    number: int
    x: float
    y: float
    weight: float


class ControlError(ValueError):
    """A law that did not return one finite Twist for each robot; the message says which."""


def make_twist(v, omega):
    """Return the ``Twist`` of forward speed ``v`` [m/s] and turn rate ``omega`` [rad/s]."""
    twist = Twist()
    twist.linear.x = v
    twist.angular.z = omega
    return twist


class PioneerControl:
    """Controls a team by a law that a researcher writes.

    Override ONE of

    - ``calculateControlLaw(pos_map)``: positions by robot number in, ``Twist`` by number out;
    - ``pointMassLaw(hand)``: hand points (n, 2) in, their wanted velocities (n, 2) out; the mapping
      (7) turns them into the unicycles' ``(v, omega)``;
    - ``neighbourLaw(robot, theta, neighbours)``: the same for one robot at a time, from the relative
      positions of its neighbours alone.

    ``PARAMETERS`` describes the law's own parameters; each is an attribute of that name (``self.k``).
    ``self.numbers`` are the robots' numbers, ``self.topology`` the interaction graph, ``self.time``
    [s] the time since the control began and ``self.period`` [s] that between two commands.
    """

    PARAMETERS = (HAND_LENGTH,)
    LOCAL_FRAMES = False

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        for parameter in cls.PARAMETERS:
            if parameter.name in RESERVED or hasattr(PioneerControl, parameter.name):
                raise TypeError(
                    "{}: a parameter may not be called {!r}, which PioneerControl uses".format(
                        cls.__name__, parameter.name
                    )
                )
        if not any(parameter.name == "l" for parameter in cls.PARAMETERS):
            cls.PARAMETERS = tuple(cls.PARAMETERS) + (HAND_LENGTH,)

    def __init__(
        self,
        numbers,
        topology=None,
        limits=NO_LIMITS,
        saturation="robot",
        parameters=None,
        period=0.02,
        fidelity="kinematic",
        safety=0.0,
    ):
        """``numbers``: the robots' numbers; ``limits``: of each robot, kept to by ``saturation``.

        ``period`` [s] between two commands; ``fidelity``: what moves the robots, for tolerances;
        ``safety`` [m]: radius of the robots that the safety filter keeps apart, 0 for no filter.

        Raises ``ValueError`` that names an unknown or impossible parameter.
        """
        self.numbers = tuple(numbers)
        self.limits = limits
        self.saturation = saturation
        self.period, self.time, self.fidelity = period, 0.0, fidelity
        self.safety = safety
        self._given_topology = topology
        self.set_parameters(parameters or {})

    # What a researcher rewrites ------------------------------------------------------------------

    def calculateControlLaw(self, pos_map):
        """Return each robot's ``Twist``: by robot number, or a sequence in the order of ``numbers``.

        ``pos_map`` maps each robot's number to its :class:`Position`.  This default maps
        :meth:`pointMassLaw` to unicycles by (7).
        """
        pose = np.array([pos_map[number] for number in self.numbers])
        return {
            number: make_twist(v, omega)
            for number, (v, omega) in zip(self.numbers, self._array_law(pose).tolist())
        }

    def pointMassLaw(self, hand):
        """Return the hand points' wanted velocities, shape (n, 2) [m/s], from ``hand`` (n, 2) [m]."""
        raise NotImplementedError(
            "{} has no law: wanted calculateControlLaw, pointMassLaw or neighbourLaw".format(
                type(self).__name__
            )
        )

    def neighbourLaw(self, robot, theta, neighbours):
        """Return the wanted velocity ``(ux, uy)`` [m/s] of one hand point from what its robot sees.

        ``robot``: its number; ``theta`` [rad] its heading; ``neighbours``: a tuple of
        :class:`Neighbour`, the robots that it hears.  A law written so is distributed by
        construction.  With ``LOCAL_FRAMES = True`` there is no common compass: relative positions
        come, and the velocity goes, in the robot's own frame, and ``theta`` is 0.
        """
        raise NotImplementedError

    def start(self):
        """Begin anew: what a law remembers of the past belongs here."""

    def claims(self, start):
        """Return what theory says of a run from hand points ``start`` (n, 2): a list of
        ``core.claims.Claim`` and ``Condition``."""
        return []

    def prediction(self, start, time):
        """Return the hand points that theory predicts at ``time`` (m,) [s], (m, n, 2), or None."""
        return None

    def targets(self, hand):
        """Return where the hand points ``hand`` (n, 2) are wanted now, (n, 2) [m], or None."""
        return None

    def warnings(self, pose):
        """Return warnings, a list of texts, about running from ``pose`` (n, 3)."""
        return []

    def measures(self, run):
        """Return further values of ``run`` for its verdict, plain values by name."""
        return {}

    # What the loops call -------------------------------------------------------------------------

    def commands(self, pose, time=0.0):
        """Return the team's commands, shape (n, 2) [m/s, rad/s], from ``pose`` (n, 3) at ``time`` [s].

        Within ``limits`` and finite.  Raises ``ControlError`` for a wrong number or kind of Twists
        or NaN, and whatever the law itself raises.
        """
        self.time = time
        if type(self).calculateControlLaw is PioneerControl.calculateControlLaw:
            command = self._array_law(pose)
        else:
            rows = map(Position._make, pose.tolist())
            command = self._from_twists(self.calculateControlLaw(dict(zip(self.numbers, rows))))
        self._check_finite(command)
        command = saturate(command, self.limits, self.saturation)
        return self._safe(command, pose) if self.safety > 0.0 else command

    def set_parameters(self, given):
        """Set the parameters ``given`` by name, the others to their defaults; all or none."""
        self.parameters = self.checked_parameters(given)
        for name, value in self.parameters.items():
            setattr(self, name, value)
        self.topology = self._given_topology or Topology(len(self.numbers), [])

    def checked_parameters(self, given):
        """Return all parameters' values with ``given``; ``ValueError`` names an impossible one."""
        return checked_values(self.PARAMETERS, given, type(self).__name__)

    def set_topology(self, topology):
        """Replace the interaction graph; ``ValueError`` if it is not over these robots."""
        if topology.n != len(self.numbers):
            raise ValueError(
                "topology over {} robots, wanted {}".format(topology.n, len(self.numbers))
            )
        self._given_topology = self.topology = topology

    # Inside --------------------------------------------------------------------------------------

    def _hand(self, pose):
        return hand_points(pose, self.l)

    def _array_law(self, pose):
        if type(self).neighbourLaw is not PioneerControl.neighbourLaw:
            u = self._by_neighbours(pose)
        else:
            u = np.asarray(self.pointMassLaw(self._hand(pose)), dtype=float)
        if u.shape != (len(self.numbers), 2):
            raise ControlError(
                "pointMassLaw returned shape {}, wanted ({}, 2): a velocity for each robot".format(
                    u.shape, len(self.numbers)
                )
            )
        return unicycle_from_point_mass(u, pose[:, 2], self.l)

    def _by_neighbours(self, pose):
        hand, velocities = self._hand(pose), []
        for row, robot in enumerate(self.numbers):
            theta = float(pose[row, 2])
            turn = _rotation(theta) if self.LOCAL_FRAMES else np.eye(2)
            seen = [
                Neighbour(self.numbers[other], *((hand[other] - hand[row]) @ turn).tolist(), weight)
                for other, weight in self.topology.heard_by(row)
            ]
            wanted = self.neighbourLaw(robot, 0.0 if self.LOCAL_FRAMES else theta, tuple(seen))
            velocities.append(turn @ np.asarray(wanted, dtype=float))
        return np.array(velocities)

    def _safe(self, command, pose):
        """Return ``command`` as the safety filter lets it pass, on hand points."""
        wanted = point_mass_from_unicycle(command, pose[:, 2], self.l)
        hand, distance = self._hand(pose), self.safe_distance
        velocity = safe_velocities(wanted, hand, distance, self.period)
        # One factor for the whole team keeps every pair's constraint.
        return saturate(unicycle_from_point_mass(velocity, pose[:, 2], self.l), self.limits, "team")

    @property
    def safe_distance(self):
        """Return ``D_s`` [m] between hand points: ``2 (radius + l)``."""
        return 2.0 * (self.safety + self.l)

    def _from_twists(self, twists):
        if isinstance(twists, dict):
            if set(twists) != set(self.numbers):
                raise ControlError(
                    "calculateControlLaw returned Twists for robots {}, wanted {}".format(
                        _listed(twists), _listed(self.numbers)
                    )
                )
            twists = [twists[number] for number in self.numbers]
        elif not isinstance(twists, (list, tuple)) or len(twists) != len(self.numbers):
            raise ControlError(
                "calculateControlLaw returned {}, wanted {} Twists, one for each robot".format(
                    _described(twists), len(self.numbers)
                )
            )
        return np.array([self._pair(*item) for item in zip(self.numbers, twists)])

    def _pair(self, number, twist):
        try:
            return float(twist.linear.x), float(twist.angular.z)
        except (AttributeError, TypeError, ValueError):
            raise ControlError(
                "calculateControlLaw returned {} for robot {}, wanted a Twist of numbers".format(
                    _described(twist), number
                )
            ) from None

    def _check_finite(self, command):
        bad = np.flatnonzero(~np.isfinite(command).all(axis=1))
        if len(bad):
            v, omega = command[bad[0]]
            raise ControlError(
                "the law gave robot {} v = {} m/s, omega = {} rad/s, wanted finite numbers".format(
                    self.numbers[bad[0]], v, omega
                )
            )


def _rotation(theta):
    """Return R(theta)^T for row vectors: ``v @ R`` is ``v`` as seen from a frame turned by theta."""
    cos, sin = np.cos(theta), np.sin(theta)
    return np.array([[cos, -sin], [sin, cos]])


def _listed(numbers):
    numbers = sorted(numbers, key=str)
    return ", ".join(map(str, numbers[:10])) + (", ..." if len(numbers) > 10 else "") or "none"


def _described(value):
    count = " of {}".format(len(value)) if isinstance(value, (list, tuple)) else ""
    return "{}{}".format(type(value).__name__, count)
