"""``PioneerControl``: the control of n robots by one function that a researcher rewrites."""

import itertools

import numpy as np

from mrs_simulator.control.class_checks import HOOKS, OWN, check_class, refuse_own_name
from mrs_simulator.control.guards import stilled
from mrs_simulator.control.network import Network
from mrs_simulator.control.positions import (  # noqa: F401, laws import them from here
    Neighbour,
    Position,
    RaisedNeighbour,
    RaisedPosition,
)
from mrs_simulator.control.safety.bounds import Surroundings
from mrs_simulator.control.safety.deadlock_detector import DeadlockDetector
from mrs_simulator.control.safety.distances import squash, sums_of_pairs, tracking_errors
from mrs_simulator.control.safety.filter import capped, safe_velocities
from mrs_simulator.control.safety.sensed import SensedNeighbourhood, safe_by_sensors
from mrs_simulator.control.safety.way_out import WayOut
from mrs_simulator.control.twists import (
    ControlError,
    check_finite,
    commands_of,
    twists_of,
)
from mrs_simulator.control.velocities import (
    neighbours_of,
    own_velocity,
    team_velocities,
    turned_by,
)
from mrs_simulator.core.claims import without_theorem
from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import checked_values
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import HAND_LENGTH, NO_LIMITS, max_abs, point_mass_from_unicycle
from mrs_simulator.scenario.network.links import NO_FAULTS
from mrs_simulator.scenario.scenario import DEFAULT_KIND
from mrs_simulator.scenario.surroundings.environment import CALM
from mrs_simulator.sensors.readings import readings_by_number
from mrs_simulator.vehicles import Team

UNCHANGED = 1e-9  # [m/s] up to which a velocity is that which was wanted
FASTEST = 1e12  # [m/s] of a wanted velocity: a greater one is mapped with care
OF_POINTS = "of_points"  # in the meta of a run that theory gives


class PioneerControl:
    """Controls a team by a law that a researcher writes.

    Override ONE of

    - ``calculateControlLaw(pos_map)``: positions by robot number in, ``Twist`` by number out;
    - ``pointMassLaw(hand)``: hand points (n, d) in, their wanted velocities (n, d) out; the mapping
      (7) turns them into the unicycles' ``(v, omega)``.  d is 2, also for robots that fly, at the
      height at which they begin; it is 3 for a team that flies where ``DIMENSIONS``, which says for
      which d the law is written, and the scenario's ``control.dimension`` have it so;
    - ``neighbourLaw(robot, theta, neighbours)``: the same for one robot at a time, from the relative
      positions of its neighbours alone.

    ``PARAMETERS`` describes the law's own parameters; each is an attribute of that name (``self.k``).
    ``self.numbers`` are the robots' numbers, ``self.topology`` the interaction graph, ``self.time``
    [s] the time since the control began and ``self.period`` [s] that between two commands.  These and
    other names of its own are to be read; assigning them is an error that says so.

    ``SENSORS`` names the sensors that the law asks of every robot; ``self.readings[number]`` then has
    the newest of each as an attribute, such as ``.sonar``, None until one has come.  ``self.obstacles``
    are the scene's, in the common frame.
    """

    PARAMETERS = (HAND_LENGTH,)
    DIMENSIONS = (
        2,
    )  # of the points that the law is written for: (2, 3) for laws of points anywhere
    SENSORS = ()  # names of the sensors that every robot must have
    LOCAL_FRAMES = False
    MEMORYLESS = False  # the law knows positions alone: its claims hold from any moment of a run on
    KEEPS_CONNECTED = False  # theory says that the graph of ``graph_at`` never falls apart
    TAKES_EDGES = True  # the law looks up ``self.topology`` at each command: edges may come and go
    IN_CURRENT = False  # the claims hold where a current carries robots, by ``self.carried``
    _network = None  # of edges with faults
    _heights = None  # (n) [m] of robots that leave the ground
    _sensed = None  # the readings that came last
    _unkept = ()  # texts
    obstacles = ()  # ``scenario.surroundings.obstacles``

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
        if not any(
            getattr(type(self), hook) is not getattr(PioneerControl, hook) for hook in HOOKS
        ):
            raise ControlError(
                "{} has no law: wanted {}".format(type(self).__name__, " or ".join(HOOKS))
            )
        numbers = tuple(numbers)
        team = Team((DEFAULT_KIND,) * len(numbers), limits) if team is None else team
        self._keep(numbers=numbers, saturation=saturation, period=period, fidelity=fidelity)
        self._keep(deadband=deadband)
        self._keep(_environment=CALM, safety=safety, _is_filtered=bool(np.any(safety)))
        surroundings = Surroundings() if surroundings is None else surroundings
        asked = tuple(dict.fromkeys((*self.SENSORS, *surroundings.sensed)))
        self._keep(_surroundings=surroundings, SENSORS=asked)
        self._keep(_deadlocks=DeadlockDetector(len(numbers)))
        self._keep(links=links, edge_seed=seed, _given_topology=topology)
        self._keep(readings=readings_by_number(numbers, self.SENSORS, {}))
        self.time = 0.0
        self.begin_scene(0.0)
        self.set_team(team)
        self.set_parameters(parameters or {})
        if links.faults:
            self._keep(_network=Network(self, links, seed))

    def __setattr__(self, name, value):
        if name in OWN_NAMES:
            refuse_own_name(type(self), PioneerControl, name, value)
        super().__setattr__(name, value)

    def _keep(self, **own):
        """Set names of PioneerControl's own, which laws may not assign."""
        self.__dict__.update(own)

    # What a researcher rewrites ------------------------------------------------------------------

    def calculateControlLaw(self, pos_map):
        """Return each robot's ``Twist``: by robot number, or a sequence in the order of ``numbers``.

        ``pos_map`` maps each robot's number to its :class:`Position`.  This default maps
        :meth:`pointMassLaw` to unicycles by (7).
        """
        pose = np.array([pos_map[number] for number in self.numbers])
        if self.dimension == 3:
            pose = np.column_stack([pose, [pos_map[number].z for number in self.numbers]])
        return dict(zip(self.numbers, twists_of(self._array_law(pose), self.team.axes)))

    def pointMassLaw(self, hand):
        """Return the points' wanted velocities, shape (n, d) [m/s], from ``hand`` (n, d) [m]."""
        raise NotImplementedError(
            "{} has no law: wanted calculateControlLaw, pointMassLaw or neighbourLaw".format(
                type(self).__name__
            )
        )

    def neighbourLaw(self, robot, theta, neighbours):
        """Return the wanted velocity ``(ux, uy)`` [m/s] of one hand point from what its robot sees.

        ``robot``: its number; ``theta`` [rad] its heading; ``neighbours``: a tuple of
        :class:`Neighbour`.  Of points in space these have a height ``z`` of
        theirs, and ``(ux, uy, uz)`` is wanted.  A law written so is distributed by construction.  With
        ``LOCAL_FRAMES = True`` there is no common compass: relative positions come, and the velocity
        goes, in the robot's own frame, and ``theta`` is 0.
        """
        raise NotImplementedError

    def start(self):
        """Begin anew: what a law remembers of the past belongs here."""

    def claims(self, start):
        """Return what theory says of a run from hand points ``start`` (n, d): a list of
        ``core.claims.Claim`` and ``Condition``."""
        return []

    def claims_over_links(self, start):
        """Return what theory says, as :meth:`claims` does, where ``self.links`` have faults; None where it
        says nothing: then those of :meth:`claims` are measured, without a theorem."""
        return None

    def prediction_over_links(self, start, time):
        """Return the prediction, as :meth:`prediction` does, where ``self.links`` have faults."""
        return None

    def prediction(self, start, time):
        """Return the hand points that theory predicts at ``time`` (m,) [s], (m, n, d), or None."""
        return None

    def stability(self, start):
        """Return the ``core.stability.Stability`` of a run from ``start`` (n, d): how far its threshold is,
        or None where no theorem names one."""
        return None

    def published(self):
        """Return the law as ``protocols.published.laws.Published``, written independently, or None.

        With it a verdict compares each recorded command, and the motion, with the law's equation.
        """
        return None

    def resumed(self, time, memory):
        """Return the control that a run's rest from ``time`` [s] after its start on is judged by, or None.

        ``memory``: that of the published law then.  A law that knows positions alone is the same at any
        time; another one says here what its claims say of the rest: its copy, or None for nothing.
        """
        return self if self.MEMORYLESS else None

    def energy(self, start):
        """Return the ``protocols.curves.Energy`` that decreases from ``start`` (n, d), or None."""
        return None

    def graph_at(self, start, hand):
        """Return the graph that the places ``hand`` (n, d) make in a run from ``start``, or None where it
        does not depend on them.  With ``KEEPS_CONNECTED`` theory says that it never falls apart."""
        return None

    def curves(self, run):
        """Return a list of ``protocols.curves.Curve`` to draw of ``run`` beside theory."""
        return []

    def targets(self, hand):
        """Return where the hand points ``hand`` (n, d) are wanted now, (n, d) [m], or None."""
        return None

    def warnings(self, pose):
        """Return warnings, a list of texts, about running from ``pose`` (n, 3), with heights (n, 4)."""
        return []

    def measures(self, run):
        """Return further values of ``run`` for its verdict, plain values by name."""
        return {}

    # What the loops call -------------------------------------------------------------------------

    def know(self, obstacles):
        """Set the ``obstacles`` of the scene, which the law may read."""
        self._keep(obstacles=tuple(obstacles))

    def begin_scene(self, time):
        """Set the ``time`` [s] of the scene at which the law begins, by which obstacles on tracks move."""
        self._keep(_scene_begun=float(time))

    def commands(self, pose, time=0.0, joints=None, readings=None):
        """Return the team's commands, (n, a) [m/s, rad/s], from ``pose`` (n, 3) at ``time`` [s].

        Of robots that leave the ground ``pose`` is (n, 4), with their heights.  One column for each axis
        of the team: ``(v, omega)`` for unicycles.  ``joints`` (n,) [rad]: the drives' inner joints; by
        default what is expected after the commands so far.  ``readings``: the newest of the robots'
        sensors, ``{row: {name: reading}}``; by default those of before.

        Within ``limits`` and finite.  Raises ``ControlError`` for a wrong number or kind of Twists
        or NaN, and whatever the law itself raises.
        """
        if self._has_joints:
            self._set_joints(time, joints)
        if readings is not None and readings is not self._sensed:
            known = readings_by_number(self.numbers, self.SENSORS, readings)
            self._keep(_sensed=readings, readings=known)
        pose = np.asarray(pose, dtype=float, order="F")  # so the law meets the same in every loop
        heights = pose[:, 3].tolist() if pose.shape[1] > 3 else None
        self.__dict__.update(time=time, _heights=heights)  # as _keep, in less time
        if heights and self.dimension == 2:
            pose = pose[:, :3]
        command = self._limited_commands(pose)
        if self._is_filtered:
            command = self._safe(command, pose)
        if self.deadband:
            command = stilled(command, self.deadband)
        if self._has_joints:
            self._keep(_given=command)
        return command

    def _limited_commands(self, pose):
        """Return the law's commands (n, a) within limits and finite, from ``pose`` (n, 3)."""
        if self._network is not None:
            command = self._network.commands(pose)
        elif self._gives_twists or not self.team.limits_joints or self.saturation == "none":
            command = self.wanted_commands(pose)
        else:
            u, pointing = self._wanted_velocities(pose)
            given = u, pose, self.joints, self.l, self.period
            if max_abs(u) <= FASTEST:  # nor is nan
                return self.team.command_within(*given, self.saturation, pointing)
            command = self.team.command(*given, pointing)
        if self.team.is_within(command):
            return command
        check_finite(command, self.numbers, self.team.axes)
        return self.saturated(command, self.saturation)

    def _set_joints(self, time, joints):
        """Set the ``joints``; None: to those that the last command leads to."""
        if joints is None and (self._given is None or time <= self.time):
            joints = self.team.rest_joints
        elif joints is None:
            joints = self.team.joints_after(self._given, self.joints, self.period)
        self._keep(joints=joints)

    def wanted_commands(self, pose):
        """Return the law's commands, (n, 2), from ``pose`` (n, 3) as it is known, at ``self.time``."""
        if not self._gives_twists:
            return self._array_law(pose)
        if self._heights is None:
            rows = map(tuple.__new__, itertools.repeat(Position), zip(*pose.T.tolist()))
        else:
            rows = map(RaisedPosition.at, pose[:, :3].tolist(), self._heights)
        given = self.calculateControlLaw(dict(zip(self.numbers, rows)))
        return commands_of(given, self.numbers, self.team)

    @property
    def _gives_twists(self):
        return type(self).calculateControlLaw is not PioneerControl.calculateControlLaw

    @property
    def is_bare(self):
        """Return whether ``pointMassLaw`` and limits alone decide on commands."""
        loop = ("commands", "wanted_commands", "saturated", "calculateControlLaw", "neighbourLaw")
        replaced = any(getattr(type(self), n) is not getattr(PioneerControl, n) for n in loop)
        acts = self._network or self._is_filtered or self.SENSORS or self.deadband
        return not (replaced or acts)

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

    @property
    def is_by_neighbours(self):
        """Return whether the law is :meth:`neighbourLaw`."""
        by_neighbours = type(self).neighbourLaw is not PioneerControl.neighbourLaw
        return by_neighbours and not self._gives_twists

    def set_parameters(self, given):
        """Set the parameters ``given`` by name, the others to their defaults; all or none."""
        self._keep(parameters=self.checked_parameters(given))
        for name, value in self.parameters.items():
            setattr(self, name, value)
        self.topology = self._given_topology or Topology(len(self.numbers), [])
        for each in self._network.copies if self._network else ():
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
        for each in self._network.copies if self._network else ():
            each.set_topology(topology)

    def set_team(self, team):
        """Let the robots be the ``vehicles.Team``; ``ValueError`` where the law is of other dimensions."""
        if team.dimension not in self.DIMENSIONS:
            text = "{}: a law for points of {} dimensions, while those of the robots have {}"
            written = " or ".join(map(str, self.DIMENSIONS))
            raise ControlError(text.format(type(self).__name__, written, team.dimension))
        joints = team.rest_joints  # [rad]
        self._keep(team=team, joints=joints, _given=None, _has_joints=team.has_joints)
        self._keep(_way_out=None)  # made when it is needed

    def all_claims(self, start):
        """Return what theory says of a run from ``start`` (n, d) over the edges that there are."""
        if self._network is None:
            return list(self.claims(start))
        known = self.claims_over_links(start)
        if known is not None:
            return list(known)
        return without_theorem(self.claims(start), "edges are " + self.links.faults)

    def predicted_track(self, start, time):
        """Return the prediction over the edges that there are, as :meth:`prediction` does."""
        perfect = self._network is None
        return (self.prediction if perfect else self.prediction_over_links)(start, time)

    # Inside --------------------------------------------------------------------------------------

    def points(self, pose):
        """Return the controlled points (..., n, d) [m] of robots at ``pose`` (..., n, 3), or (..., n, 4).

        Each drive has its own: hand points ``l`` ahead of the axle, eq. (2), for unicycles.
        """
        return self.team.point(np.asarray(pose, dtype=float), self.joints, self.l)

    def _array_law(self, pose):
        u, pointing = self._wanted_velocities(pose)
        return self.team.command(u, pose, self.joints, self.l, self.period, pointing)

    def _wanted_velocities(self, pose):
        """Return the velocities (n, d) [m/s] that the law wants, and the team's ``pointing``."""
        pointing = self.team.pointing(pose, self.joints)
        hand = self.team.point(pose, self.joints, self.l, pointing)
        if self.is_by_neighbours:
            u = np.array([self.seen_by(row, pose, hand) for row in range(len(pose))])
        else:
            u = team_velocities(self.pointMassLaw(hand), len(self.numbers), self.dimension)
        if self._is_filtered:
            self._keep(_unlimited=u)
        return u, pointing

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

    def seen_by(self, row, pose, hand):
        """Return what :meth:`neighbourLaw` wants of the robot in ``row``, (d,) [m/s].

        ``pose`` (n, 3), of which its own heading is taken; ``hand`` (n, d) as that robot knows them.
        """
        theta, turn = float(pose[row, 2]), np.eye(hand.shape[1])
        if self.LOCAL_FRAMES:
            turn[:2, :2], theta = turned_by(theta), 0.0
        robot = self.numbers[row]
        seen = neighbours_of(row, hand, turn, self.numbers, self.topology)
        return turn @ own_velocity(self.neighbourLaw(robot, theta, seen), robot, self.dimension)

    def _safe(self, command, pose):
        """Return ``command`` as the safety filter lets it pass, on the controlled points."""
        wanted = self.team.velocity(command, pose, self.joints, self.l, self.period)
        points, distance = self.points(pose), self.safe_distance
        if self._surroundings.sensed:
            velocity = self._safe_by_sensors(wanted, points, pose)
            self._deadlocks.note(self.time, wanted, velocity, points, distance)
            return self.saturated(self.commands_for(velocity, pose), "robot")
        bounds = self.safe_bounds(points)
        if self.way_out is None:
            # One factor for the whole team keeps every pair's constraint.
            velocity = self._filtered(wanted, points, distance, bounds)
            passed = self.saturated(self.commands_for(velocity, pose), "team")
        else:
            passed = self._turned_away(command, wanted, pose, points, distance, bounds)
            # Bodies are no nearer than points with their reach.
            passed = self._with_way_out(passed, pose, bounds.least(len(points)))
            velocity = wanted
            if passed is not command:
                velocity = self.team.velocity(passed, pose, self.joints, self.l, self.period)
        self._deadlocks.note(self.time, wanted, velocity, points, distance)
        return passed

    def _filtered(self, wanted, points, distance, bounds):
        """Return the velocities (n, d) nearest to ``wanted`` with which ``points`` keep ``distance``."""
        return safe_velocities(
            wanted,
            points,
            distance,
            self.period,
            bounds=bounds,
            speed=self._surroundings.speed,
            squash=self.safe_squash,
            brakes=self.safe_brakes,
        )

    def _turned_away(self, command, wanted, pose, points, distance, bounds):
        """Return ``command`` (n, a), but another one for robots that the filter has go otherwise.

        ``wanted`` (n, d) [m/s]: what it gives the ``points``.  The filter starts from what the law wants
        before limits: these slow down a robot that has to turn, and would do so again for each way aside.
        """
        given, speed, top = wanted, self._surroundings.speed, self.team.speeds[:, 0]
        if not self._gives_twists and self._network is None:
            wanted = capped(self._unlimited, top if speed is None else np.minimum(top, speed))
        velocity = self._filtered(wanted, points, distance, bounds)
        changed = (np.abs(velocity - wanted) > UNCHANGED).any(axis=1)
        if speed is not None:
            changed |= np.linalg.norm(given, axis=1) > speed
        if not changed.any():
            return command
        # The way out is certified: each robot may be as fast as it can.
        other = self.saturated(self.commands_for(velocity, pose), "robot")
        return np.where(changed[:, np.newaxis], other, command)

    def _with_way_out(self, command, pose, gap):
        """Return ``command`` (n, a) for robots to which it leaves a way out; the others brake.

        ``gap`` (n,) [m]: by which bodies are at least clear of what stands."""
        heights = np.ones(len(pose)) if self._heights is None else np.array(self._heights)
        around = self._surroundings.standing()
        return self.way_out.certified(command, pose, heights, self.time, around, gap)

    def _safe_by_sensors(self, wanted, points, pose):
        """Return the velocities (n, 2) that the robots' own sensors let pass."""
        turn = np.stack([turned_by(theta) for theta in pose[:, 2].tolist()])
        own = np.einsum("ij,ijk->ik", points - pose[:, :2], turn)
        reach = self._reach
        # Their centres are seen, while their points are kept apart.
        reaches = reach + np.broadcast_to(self.team.lead(self.l), len(reach))
        sensed = [SensedNeighbourhood(*each, reaches, self.period) for each in zip(own, reach)]
        names = self._surroundings.sensed
        readings = [
            [getattr(self.readings[number], name) for name in names] for number in self.numbers
        ]
        return safe_by_sensors(wanted, sensed, turn, readings, self._surroundings.speed)

    @property
    def way_out(self):
        """Return the ``WayOut`` that robots keep; None for points, and where the filter goes by sensors."""
        if self.fidelity == "point_mass" or self._surroundings.sensed:
            return None
        if self._way_out is None:
            given = self.team, self.body_radii, self.period, self.fidelity
            self._keep(_way_out=WayOut(*given))
        return self._way_out

    @property
    def body_radii(self):
        """Return the radii (n,) [m] about the centres that bodies lie within."""
        return np.broadcast_to(np.asarray(self.safety, dtype=float), len(self.numbers))

    @property
    def safe_brakes(self):
        """Return the ``Brakes`` by which the safety filter slows robots; None where they stop at once."""
        return None if self.way_out is None else self.way_out.brakes

    @property
    def filter_sensors(self):
        """Return the names of the sensors by which the safety filter acts; () where it knows positions."""
        return self._surroundings.sensed

    @property
    def filter_warnings(self):
        """Return what of its promise the safety filter cannot keep in this scenario, a list of texts."""
        return list(self._unkept)

    @property
    def filter_sees_robots(self):
        """Return whether the safety filter distinguishes robots, and keeps the distance of each pair."""
        return not self._surroundings.sensed or self._surroundings.sees

    def safe_bounds(self, points, time=None, standing=False):
        """Return the ``Bounds`` that the safety filter keeps robots' ``points`` (n, 2) in.

        ``time`` [s] since the law began, by default now, gives where obstacles on tracks are; ``standing``:
        leave them out.
        """
        around = self.safe_surroundings(standing)
        time = self.scene_time(self.time if time is None else time)
        return around.bounds(points, self._reach, time, self.period)

    def safe_surroundings(self, standing=False):
        """Return the ``Surroundings`` that the safety filter keeps robots from; ``standing``: without what
        moves."""
        return self._surroundings.standing() if standing else self._surroundings

    def scene_time(self, time):
        """Return the time [s] of the scene at ``time`` [s] since the law began."""
        return self._scene_begun + time

    @property
    def filter_flees(self):
        """Return the top speed [m/s] of moving obstacles that the safety filter knows of, 0 for none."""
        return self._surroundings.fastest

    @property
    def safe_speed(self):
        """Return the most that the safety filter lets controlled points go, (n,) [m/s], or None."""
        return self._surroundings.speed

    @property
    def safety_deadlock(self):
        """Return the robots that the safety filter holds still, ``(number, since [s])`` of each."""
        rows = self._deadlocks.rows(self.time)
        return tuple((self.numbers[row], since) for row, since in rows)

    @property
    def safe_distance(self):
        """Return ``D_s`` [m] between controlled points: ``kept_distance`` and both robots' tracking errors.

        A number where all robots are of one size, else (n, n).
        """
        late = self._late
        return sums_of_pairs(self._radii + late if late.any() else self._radii)

    @property
    def kept_distance(self):
        """Return what the filter keeps between controlled points [m]: ``radius_i + l_i + radius_j + l_j``.

        ``l_i``: how far the point is from the robot's centre, ``l`` for unicycles.

        A number where all robots are of one size, else (n, n).
        """
        return sums_of_pairs(self._radii)

    @property
    def safe_squash(self):
        """Return by what (d,) [-] the filter measures distances along x, y and z; None for 1."""
        return squash(self.team)

    @property
    def _radii(self):
        return np.asarray(self.safety, dtype=float) + self.team.lead(self.l)

    @property
    def _late(self):
        """Return the bounds on the robots' tracking errors, (n,) [m], 0 where they obey at once, or where
        their braking is predicted."""
        if self.way_out is not None:
            return np.zeros(self.team.n)
        return tracking_errors(self.team, self.fidelity, self._surroundings.speed)

    @property
    def _reach(self):
        """Return ``radius_i + l_i`` and its tracking error of each robot, (n,) [m]."""
        return np.broadcast_to(self._radii + self._late, len(self.numbers))


OWN_NAMES = frozenset(OWN) | {
    name
    for name, value in vars(PioneerControl).items()
    if callable(value) or isinstance(value, property)
}
