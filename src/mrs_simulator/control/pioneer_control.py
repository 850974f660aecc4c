"""``PioneerControl``: the control of n robots by one function that a researcher rewrites."""

from typing import NamedTuple

import numpy as np
from geometry_msgs.msg import Twist

from mrs_simulator.core import formation
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import NO_LIMITS, hand_points, saturate, unicycle_from_point_mass
from mrs_simulator.core.parameters import checked_values

HAND_LENGTH = next(p for p in formation.PARAMETERS if p.name == "l")
RESERVED = ("numbers", "topology", "limits", "saturation", "parameters", "period", "time")


class Position(NamedTuple):
    """A robot's position in the common frame: x, y [m], theta [rad] of the wheel-axle centre."""

    x: float
    y: float
    theta: float


class ControlError(ValueError):
    """A law that did not return one finite Twist for each robot; the message says which."""


def make_twist(v, omega):
    """Return the ``Twist`` of forward speed ``v`` [m/s] and turn rate ``omega`` [rad/s]."""
    twist = Twist()
    twist.linear.x = v
    twist.angular.z = omega
    return twist


class PioneerControl:
    """Controls a team.  As it stands it runs the paper's formation law (6).

    Override ONE of

    - ``calculateControlLaw(pos_map)``: positions by robot number in, ``Twist`` by number out;
    - ``pointMassLaw(hand)``: hand points (n, 2) in, their wanted velocities (n, 2) out; the mapping
      (7) turns them into the unicycles' ``(v, omega)``.

    ``PARAMETERS`` describes the law's own parameters; each is an attribute of that name (``self.k``).
    ``self.numbers`` are the robots' numbers, ``self.topology`` the interaction graph, ``self.time``
    [s] the time since the control began and ``self.period`` [s] that between two commands.
    """

    PARAMETERS = formation.PARAMETERS

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        own_law = {"calculateControlLaw", "pointMassLaw"} & set(vars(cls))
        if own_law and "PARAMETERS" not in vars(cls) and cls.PARAMETERS is formation.PARAMETERS:
            cls.PARAMETERS = ()
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
    ):
        """``numbers``: the robots' numbers; ``limits``: of each robot, kept to by ``saturation``.

        Raises ``ValueError`` that names an unknown or impossible parameter.
        """
        self.numbers = tuple(numbers)
        self.limits = limits
        self.saturation = saturation
        self.period, self.time = period, 0.0
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
        """Return the hand points' wanted velocities, shape (n, 2) [m/s], from ``hand`` (n, 2) [m].

        This default is the paper's law (6), ``u_i = -(k/T)(alpha_i - alpha_i*)``.
        """
        return formation.formation_velocity(hand, self._offsets, self._closure, self.k, self.T)

    def targets(self, hand):
        """Return where the hand points ``hand`` (n, 2) are wanted now, (n, 2) [m], or None.

        For displays; this default is the paper's ``alpha_i*``, and None for other laws.
        """
        if self.PARAMETERS is not formation.PARAMETERS:
            return None
        return hand - formation.target_errors(hand, self._offsets, self._closure)

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
        return saturate(command, self.limits, self.saturation)

    def set_parameters(self, given):
        """Set the parameters ``given`` by name, the others to their defaults; all or none."""
        values = checked_values(self.PARAMETERS, given, type(self).__name__)
        topology, closure = self._given_topology, values.get("closure")
        if self.PARAMETERS is formation.PARAMETERS:
            self._closure = formation.closure_topology(closure, len(self.numbers), topology)
            self._offsets = formation.line_offsets(len(self.numbers), values["c"])
            topology = self._closure
        self.topology = topology or Topology(len(self.numbers), [])
        for name, value in values.items():
            setattr(self, name, value)
        self.parameters = values

    def set_topology(self, topology):
        """Replace the interaction graph; the paper's law then follows it (closure ``topology``)."""
        if topology.n != len(self.numbers):
            raise ValueError(
                "topology over {} robots, wanted {}".format(topology.n, len(self.numbers))
            )
        self._given_topology = topology
        if self.PARAMETERS is formation.PARAMETERS:
            self.set_parameters(dict(self.parameters, closure="topology"))
        else:
            self.topology = topology

    def warnings(self, pose):
        """Return warnings, a list of texts, about running from ``pose`` (n, 3) at this period.

        The paper's law on unicycles spins for ever when the held arc turns too far: safe is
        ``Tc <= l/(kappa e_max)`` or ``omega_max Tc <= 1``.
        """
        if self.PARAMETERS is not formation.PARAMETERS:
            return []
        hand = hand_points(pose, self.l)
        e_max = formation.error_norm(hand, self._offsets, self._closure)
        omega_max = self.limits.omega_max if self.saturation != "none" else np.inf
        longest = formation.largest_stable_period(self.k, self.T, self.l, e_max, omega_max)
        if self.period <= longest * (1.0 + 1e-9):
            return []
        return [
            "one command every {:g} s is too slow for l = {:g} m and kappa = k/T = {:g} /s with "
            "errors up to {:.3g} m: a robot may spin for ever. Wanted a period of at most "
            "l/(kappa e_max) = {:.3g} s, or a limit on the turn rate with omega_max Tc <= 1".format(
                self.period, self.l, self.k / self.T, e_max, self.l * self.T / (self.k * e_max)
            )
        ]

    # Inside --------------------------------------------------------------------------------------

    def _array_law(self, pose):
        u = np.asarray(self.pointMassLaw(hand_points(pose, self.l)), dtype=float)
        if u.shape != (len(self.numbers), 2):
            raise ControlError(
                "pointMassLaw returned shape {}, wanted ({}, 2): a velocity for each robot".format(
                    u.shape, len(self.numbers)
                )
            )
        return unicycle_from_point_mass(u, pose[:, 2], self.l)

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


def _listed(numbers):
    numbers = sorted(numbers, key=str)
    return ", ".join(map(str, numbers[:10])) + (", ..." if len(numbers) > 10 else "") or "none"


def _described(value):
    count = " of {}".format(len(value)) if isinstance(value, (list, tuple)) else ""
    return "{}{}".format(type(value).__name__, count)
