"""``LawRunner``: makes a team's commands by a law, from poses to limits, safety filter and dead band."""

import copy
import itertools

import numpy as np

from mrs_simulator.control.guards import stilled
from mrs_simulator.control.hooks import LawHooks
from mrs_simulator.control.network import Network
from mrs_simulator.control.positions import Position, RaisedPosition
from mrs_simulator.control.twists import check_finite, commands_of
from mrs_simulator.control.velocities import neighbours_of, own_velocity, team_velocities, turned_by
from mrs_simulator.core.garbage import collected_later
from mrs_simulator.core.kinematics import FASTEST, are_within
from mrs_simulator.sensors.readings import readings_by_number

FEW = 200  # [-] robots among whose positions and Twists garbage may be looked for


class LawRunner:
    """Runs the law of one control at each command."""

    def __init__(self, control, replaces_loop):
        """``control``: the ``PioneerControl`` whose law it is; ``replaces_loop``: whether its class does
        what goes on between law and robots in a way of its own."""
        self._control, self.replaces_loop = control, replaces_loop
        self.network = None  # ``Network`` of edges with faults
        self.warnings = []  # texts: what the law's commands may do to these robots
        self.heights = None  # (n) [m] of robots that leave the ground
        self._sensed = None  # the readings that came last
        self._unlimited = None  # (n, d) [m/s] wanted by the law before limits

    def of(self, control):
        """Return the same of a shallow copy ``control``."""
        other = copy.copy(self)
        other._control = control
        return other

    def set_team(self, team):
        """Set the ``vehicles.Team``, at rest."""
        self._given, self._has_joints = None, team.has_joints  # the commands of the last period

    def set_links(self, links, seed):
        """Let edges have the faults of ``links``, drawn from ``seed``."""
        if links.faults:
            self.network = Network(self._control, links, seed)

    @property
    def copies(self):
        """Return the controls of single robots, which run the law on what reached these; () without."""
        return () if self.network is None else self.network.copies

    @property
    def gives_twists(self):
        """Return whether the law is :meth:`calculateControlLaw`."""
        return type(self._control).calculateControlLaw is not LawHooks.calculateControlLaw

    @property
    def is_by_neighbours(self):
        """Return whether the law is :meth:`neighbourLaw`."""
        by_neighbours = type(self._control).neighbourLaw is not LawHooks.neighbourLaw
        return by_neighbours and not self.gives_twists

    @property
    def is_by_points(self):
        """Return whether the law is :meth:`pointMassLaw`."""
        return not (self.gives_twists or self.is_by_neighbours)

    def commands(self, pose, time, joints, readings, hand=None):
        """Return the commands, as ``PioneerControl.commands`` does.

        ``hand``: the controlled points of unicycles at ``pose``, where they are known.
        """
        control = self._control
        if self._has_joints:
            self._set_joints(time, joints)
        if readings is not None:
            self.sense(readings)
        pose = np.asarray(pose, dtype=float, order="F")  # so the law meets the same in every loop
        self.heights = pose[:, 3].tolist() if pose.shape[1] > 3 else None
        control.__dict__["time"] = time  # as _keep, in less time
        if self.heights and control.dimension == 2:
            pose = pose[:, :3]
        acts = control.safety_filter.acts
        command = self._filtered_commands(pose, hand) if acts else self._limited_commands(pose)
        if control.deadband:
            command = stilled(command, control.deadband)
        if self._has_joints:
            self._given = command
        return command

    def sense(self, readings):
        """Let the law have the newest ``readings`` of the robots' sensors, ``{row: {name: reading}}``."""
        control = self._control
        if readings is not self._sensed:
            self._sensed = readings
            control._keep(readings=readings_by_number(control.numbers, control.SENSORS, readings))

    def _filtered_commands(self, pose, hand):
        """Return the commands (n, a) that the safety filter lets pass, from ``pose`` (n, 3), and the points
        ``hand`` there, None where these are not known."""
        safety, by_points = (
            self._control.safety_filter,
            not self.gives_twists and self.network is None,
        )
        if by_points and safety.limits_velocities:
            if hand is None:
                unlimited, _ = self._wanted_velocities(pose)
            else:
                unlimited = self._unlimited = self.velocities(hand, self._control.time)
            return safety.passed(None, pose, unlimited)
        command = self._limited_commands(pose)
        return safety.passed(command, pose, self._unlimited if by_points else None)

    def limited_command(self, velocity, pose):
        """Return the commands (n, a) that give points ``velocity`` (n, d) [m/s], as :meth:`limited`."""
        return self.limited(self._control.commands_for(velocity, pose))

    def _limited_commands(self, pose):
        """Return the law's commands (n, a) within limits and finite, from ``pose`` (n, 3)."""
        control = self._control
        team = control.team
        if self.network is not None:
            command = self.network.commands(pose)
        elif self.gives_twists or not team.limits_joints or control.saturation == "none":
            command = control.wanted_commands(pose)
        else:
            u, pointing = self._wanted_velocities(pose)
            given = u, pose, control.joints, control.l, control.period
            if are_within(u, FASTEST):
                return team.command_within(*given, control.saturation, pointing)
            command = team.command(*given, pointing)
        return self.limited(command)

    def limited(self, command):
        """Return ``command`` (n, a) within limits; ``ControlError`` where it is not finite."""
        control = self._control
        if control.team.is_within(command):
            return command
        check_finite(command, control.numbers, control.team.axes)
        return control.saturated(command, control.saturation)

    def _set_joints(self, time, joints):
        """Set the ``joints``; None: to those that the last command leads to."""
        control = self._control
        if joints is None and (self._given is None or time <= control.time):
            joints = control.team.rest_joints
        elif joints is None:
            joints = control.team.joints_after(self._given, control.joints, control.period)
        control._keep(joints=joints)

    def wanted_commands(self, pose):
        """Return the law's commands, as ``PioneerControl.wanted_commands`` does."""
        if not self.gives_twists:
            return self.array_law(pose)
        if len(pose) <= FEW:
            return self._by_twists(pose)
        with collected_later():
            return self._by_twists(pose)

    def _by_twists(self, pose):
        """Return the commands (n, a) in the Twists of ``calculateControlLaw``, from ``pose`` (n, 3)."""
        control = self._control
        if self.heights is None:
            rows = zip(itertools.repeat(Position), zip(*pose.T.tolist()))
            rows = itertools.starmap(tuple.__new__, rows)
        else:
            rows = map(RaisedPosition.at, pose[:, :3].tolist(), self.heights)
        given = control.calculateControlLaw(dict(zip(control.numbers, rows)))
        return commands_of(given, control.numbers, control.team)

    def array_law(self, pose):
        """Return the commands (n, a) by ``pointMassLaw`` or ``neighbourLaw``, from ``pose`` (n, 3)."""
        control = self._control
        u, pointing = self._wanted_velocities(pose)
        return control.team.command(u, pose, control.joints, control.l, control.period, pointing)

    def _wanted_velocities(self, pose):
        """Return the velocities (n, d) [m/s] that the law wants, and the team's ``pointing``."""
        control = self._control
        pointing = control.team.pointing(pose, control.joints)
        hand = control.team.point(pose, control.joints, control.l, pointing)
        if self.is_by_neighbours:
            u = np.array([self.seen_by(row, pose, hand) for row in range(len(pose))])
        else:
            u = self.velocities(hand, control.time)
        if control.safety_filter.acts:
            self._unlimited = u
        return u, pointing

    def unlimited_commands(self, pose, time):
        """Return the commands (n, a) that the law wants at ``pose`` (n, 3), before limits."""
        self._control.__dict__["time"] = time  # as _keep, in less time
        return self.wanted_commands(pose)

    def velocities(self, points, time):
        """Return the velocities (n, d) [m/s] that ``pointMassLaw`` wants of ``points`` (n, d) [m]."""
        control = self._control
        control.__dict__["time"] = time  # as _keep, in less time
        wanted = control.pointMassLaw(points)
        return team_velocities(wanted, len(control.numbers), control.dimension)

    def seen_by(self, row, pose, hand):
        """Return what :meth:`neighbourLaw` wants of the robot in ``row``, (d,) [m/s].

        ``pose`` (n, 3), of which its own heading is taken; ``hand`` (n, d) as that robot knows them.
        """
        control = self._control
        theta, d = float(pose[row, 2]), hand.shape[1]
        turn = turned_by(theta, d) if control.LOCAL_FRAMES else np.eye(d)
        theta = 0.0 if control.LOCAL_FRAMES else theta
        robot = control.numbers[row]
        seen = neighbours_of(row, hand, turn, control.numbers, control.topology)
        velocity = control.neighbourLaw(robot, theta, seen)
        return turn @ own_velocity(velocity, robot, control.dimension)

    def commands_of_one(self, row, known, joints, heights, source):
        """Return the command (a,) of the robot in ``row`` from the poses ``known`` (n, 3) to it.

        ``joints`` and ``heights``: as known to it; ``source``: the control whose time and readings it has.
        """
        control = self._control
        self.heights = heights
        control._keep(time=source.time, joints=joints)
        if control.SENSORS:  # no robot has the sensors of others
            number = control.numbers[row]
            others = readings_by_number(control.numbers, control.SENSORS, {})
            control._keep(readings={**others, number: source.readings[number]})
        return control.wanted_commands(known)[row]
