"""``PioneerControl``: the control of n robots by one function that a researcher rewrites."""

import copy

import numpy as np

from mrs_simulator.control.class_checks import HOOKS, OWN, check_class, refuse_own_name
from mrs_simulator.control.hooks import LawHooks
from mrs_simulator.control.law_runner import LawRunner
from mrs_simulator.control.positions import (  # noqa: F401, laws import them from here
    Neighbour,
    Position,
    RaisedNeighbour,
    RaisedPosition,
)
from mrs_simulator.control.safety.bounds import Surroundings
from mrs_simulator.control.safety.safety_filter import SafetyFilter
from mrs_simulator.control.twists import ControlError
from mrs_simulator.core.claims import NO_TOPOLOGY, Condition, listed, without_theorem
from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import checked_values
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import HAND_LENGTH, NO_LIMITS, point_mass_from_unicycle
from mrs_simulator.scenario.network.links import NO_FAULTS
from mrs_simulator.scenario.scenario import DEFAULT_KIND
from mrs_simulator.scenario.surroundings.environment import CALM
from mrs_simulator.sensors.readings import readings_by_number
from mrs_simulator.vehicles import Team

# What goes on between a law and the robots.
LOOP = ("commands", "wanted_commands", "saturated")
OF_POINTS = "of_points"  # in the meta of a run that theory gives


class PioneerControl(LawHooks):
    """Controls a team by a law that a researcher writes: a subclass that overrides ``LawHooks``' methods.

    What it reads and calls is here; ``runner`` runs the law, and ``safety_filter`` keeps the robots apart.
    """

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        check_class(cls, PioneerControl)
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
        links=NO_FAULTS,
        seed=0,
        team=None,
        surroundings=None,
        deadband=0.0,
    ):
        """``numbers``: the robots' numbers; ``team``: their ``vehicles.Team``, whose limits are kept to
        by ``saturation``; without it robots of the default kind with ``limits``.

        ``period`` [s] between two commands; ``fidelity``: what moves the robots, for tolerances;
        ``safety`` [m]: radii of the robots, (n,) or one for all, that the safety filter keeps apart, 0
        for no filter; ``surroundings``: :class:`Surroundings` that it keeps them from too, or None.
        ``links``: faults of the edges, drawn from ``seed``; then each robot runs the law by itself,
        on what reached it.  ``deadband`` [m/s, rad/s]: a command without a larger component is zero.

        Raises ``ValueError`` that names an unknown or impossible parameter.
        """
        if all(getattr(type(self), hook) is getattr(LawHooks, hook) for hook in HOOKS):
            text = "{} has no law: wanted {}"
            raise ControlError(text.format(type(self).__name__, " or ".join(HOOKS)))
        numbers = tuple(numbers)
        team = Team((DEFAULT_KIND,) * len(numbers), limits) if team is None else team
        surroundings = Surroundings() if surroundings is None else surroundings
        self._keep(numbers=numbers, saturation=saturation, period=period, fidelity=fidelity)
        self._keep(deadband=deadband, safety=safety, _environment=CALM, _sensor_changes=())
        self._keep(links=links, edge_seed=seed, _given_topology=topology)
        self._keep(SENSORS=tuple(dict.fromkeys((*self.SENSORS, *surroundings.sensed))))
        self._keep(readings=readings_by_number(numbers, self.SENSORS, {}))
        own = any(getattr(type(self), name) is not getattr(PioneerControl, name) for name in LOOP)
        self._keep(runner=LawRunner(self, own), safety_filter=SafetyFilter(self, surroundings))
        self.time = 0.0
        self.set_team(team)
        self.set_parameters(parameters or {})
        self.runner.set_links(links, seed)

    def __setattr__(self, name, value):
        if name in OWN_NAMES:
            refuse_own_name(type(self), PioneerControl, name, value)
        super().__setattr__(name, value)

    def __copy__(self):
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other._keep(runner=self.runner.of(other), safety_filter=self.safety_filter.of(other))
        return other

    def _keep(self, **own):
        """Set names of PioneerControl's own, which laws may not assign."""
        self.__dict__.update(own)

    def commands(self, pose, time=0.0, joints=None, readings=None):
        """Return the team's commands, (n, a) [m/s, rad/s], from ``pose`` (n, 3) at ``time`` [s].

        Of robots that leave the ground ``pose`` is (n, 4), with their heights.  One column for each axis
        of the team: ``(v, omega)`` for unicycles.  ``joints`` (n,) [rad]: the drives' inner joints; by
        default what is expected after the commands so far.  ``readings``: the newest of the robots'
        sensors, ``{row: {name: reading}}``; by default those of before.

        Within ``limits`` and finite.  Raises ``ControlError`` for a wrong number or kind of Twists
        or NaN, and whatever the law itself raises.
        """
        return self.runner.commands(pose, time, joints, readings)

    def wanted_commands(self, pose):
        """Return the law's commands, (n, 2), from ``pose`` (n, 3) as it is known, at ``self.time``."""
        return self.runner.wanted_commands(pose)

    @property
    def foreseen(self):
        """Return what is known of the scenario before the run that may go wrong, a list of texts."""
        return [*self.safety_filter.warnings, *self.runner.warnings]

    @property
    def dimension(self):
        """Return d, how many coordinates the controlled points have: 2 on the ground."""
        return self.team.dimension

    @property
    def carried(self):
        """Return the velocities (n, d) [m/s] with which a current carries the points, besides commands."""
        result = np.zeros((len(self.numbers), self.dimension))
        result[self.team.afloat, :2] = self._environment.current
        return result

    @property
    def limits(self):
        """Return the limits of each command axis: ``vehicles.limits.AxisLimits``."""
        return self.team.limits

    def saturated(self, command, scope):
        """Return ``command`` (n, a) within each robot's limits.

        ``scope``: each robot slowed by a factor of its own, "robot", all by the greatest, "team", or
        not at all, "none"; each point keeps its direction.
        """
        if scope == "none":
            return command
        return self.team.saturated(command, self.joints, self.period, scope)

    def set_parameters(self, given):
        """Set the parameters ``given`` by name, the others to their defaults; all or none."""
        self._keep(parameters=self.checked_parameters(given))
        for name, value in self.parameters.items():
            setattr(self, name, value)
        self.topology = self._given_topology or Topology(len(self.numbers), [])
        for each in self.runner.copies:
            each.set_parameters(given)

    @explained_by("docs/protocols.md#parameters-and-topology")
    def checked_parameters(self, given):
        """Return all parameters' values with ``given``; ``ValueError`` names an impossible one."""
        return checked_values(self.PARAMETERS, given, type(self).__name__)

    def set_topology(self, topology):
        """Replace the interaction graph; ``ValueError`` if it is not over these robots."""
        if topology.n != len(self.numbers):
            raise ValueError(
                "topology over {} robots, wanted {}".format(topology.n, len(self.numbers))
            )
        self._keep(_given_topology=topology)
        self.topology = topology
        for each in self.runner.copies:
            each.set_topology(topology)

    def set_team(self, team):
        """Let the robots be the ``vehicles.Team``; ``ValueError`` where the law is of other dimensions."""
        if team.dimension not in self.DIMENSIONS:
            text = "{}: a law for points of {} dimensions, while those of the robots have {}"
            written = " or ".join(map(str, self.DIMENSIONS))
            raise ControlError(text.format(type(self).__name__, written, team.dimension))
        self._keep(team=team, joints=team.rest_joints)  # [rad]
        self.runner.set_team(team)
        self.safety_filter.set_team()

    def all_claims(self, start):
        """Return what theory says of a run from ``start`` (n, d) over the edges that there are."""
        if self.runner.network is None:
            return self._blaming_no_edges(listed(self.claims(start)), start)
        known = self.claims_over_links(start)
        if known is not None:
            return listed(known)
        return without_theorem(listed(self.claims(start)), "edges are " + self.links.faults)

    def _blaming_no_edges(self, claims, start):
        """Return ``claims`` whose conditions say so where they fail for want of a topology alone.

        That is where the scenario has none, and over a ring they hold.
        """
        n, failed = len(self.numbers), any(isinstance(c, Condition) and not c.holds for c in claims)
        if not failed or n < 2 or self._given_topology is not None:
            return claims
        other = copy.copy(self)
        ring = [(i, i % n + 1) for i in range(1, n + 1)] if n > 2 else [(1, 2)]
        other.topology = Topology(n, ring, directed=False)
        try:
            made = {c.name: c for c in listed(other.claims(start)) if isinstance(c, Condition)}
        except Exception:  # of a law that cannot do with this graph
            return claims
        return [
            c._replace(why="; ".join(filter(None, (c.why, NO_TOPOLOGY))))
            if isinstance(c, Condition) and not c.holds and c.name in made and made[c.name].holds
            else c
            for c in claims
        ]

    def predicted_track(self, start, time):
        """Return the prediction over the edges that there are, as :meth:`prediction` does."""
        perfect = self.runner.network is None
        return (self.prediction if perfect else self.prediction_over_links)(start, time)

    def points(self, pose):
        """Return the controlled points (..., n, d) [m] of robots at ``pose`` (..., n, 3), or (..., n, 4).

        Each drive has its own: hand points ``l`` ahead of the axle, eq. (2), for unicycles.
        """
        return self.team.point(np.asarray(pose, dtype=float), self.joints, self.l)

    def velocities(self, run):
        """Return the points' commanded velocities, (m, n, d) [m/s], from the samples of ``run`` on."""
        if run.meta.get(OF_POINTS) and run.hand.shape[2] == 3:
            return run.command
        if run.meta.get(OF_POINTS):  # whose points are hand points, whatever the robots are
            rows = run.command.reshape(-1, 2), run.pose[:, :, 2].ravel()
            return point_mass_from_unicycle(*rows, self.l).reshape(run.hand.shape)
        recorded = run.command, run.pose, run.hand, self.l, self.period
        if self.team.has_arms:
            return self.team.velocities_in(*recorded, run.joints)
        return self.team.velocities_in(*recorded)

    def commands_for(self, velocity, pose):
        """Return the commands (n, a) that give the points ``velocity`` (n, d) [m/s]: eq. (7)."""
        return self.team.command(velocity, pose, self.joints, self.l, self.period)


OWN_NAMES = frozenset(OWN) | {
    name
    for name in (*vars(LawHooks), *vars(PioneerControl))
    if callable(getattr(PioneerControl, name))
    or isinstance(getattr(PioneerControl, name), property)
}
