"""``SafetyFilter``: the commands of a team that the safety filter lets pass."""

import copy

import numpy as np

from mrs_simulator.control.safety.bounds import NO_BOUNDS
from mrs_simulator.control.safety.braking_certificate import WayOut
from mrs_simulator.control.safety.deadlock_detector import DeadlockDetector
from mrs_simulator.control.safety.distances import squash, sums_of_pairs, tracking_errors
from mrs_simulator.control.safety.filter_by_sensors import SensedNeighbourhood, safe_by_sensors
from mrs_simulator.control.safety.nearest_velocities import UNCHANGED, capped, safe_velocities
from mrs_simulator.control.safety.one_call import OneCall
from mrs_simulator.control.velocities import turned_by
from mrs_simulator.core.compiling import in_time


class SafetyFilter:
    """Keeps the controlled points of one control's robots apart, and from what surrounds them."""

    def __init__(self, control, surroundings):
        """``control``: the ``PioneerControl``, whose ``safety`` are the robots' radii [m], 0 for no filter;
        ``surroundings``: the ``Surroundings`` that it keeps them from."""
        self._control, self._around = control, surroundings
        self.acts = bool(np.any(control.safety))
        self.warnings = []  # texts: what of its promise it cannot keep in this scenario
        self._deadlocks = DeadlockDetector(len(control.numbers))
        self._way_out = self._one_call = None  # made when they are needed
        self.begin_scene(0.0)

    def of(self, control):
        """Return the same of a shallow copy ``control``."""
        other = copy.copy(self)
        other._control = control
        return other

    def set_team(self):
        """Take the team that the control has from now on."""
        self._way_out = self._one_call = None

    def begin_scene(self, time):
        """Set the ``time`` [s] of the scene at which the law begins, by which obstacles on tracks move."""
        self._scene_begun = float(time)

    def scene_time(self, time):
        """Return the time [s] of the scene at ``time`` [s] since the law began."""
        return self._scene_begun + time

    def passed(self, command, pose, unlimited):
        """Return ``command`` (n, a) as the filter lets it pass, on the controlled points.

        ``pose`` (n, 3), of points in space (n, 4); ``unlimited`` (n, d) [m/s]: what the law wants before
        limits, None where it gives commands.  ``command``: None for what limits leave of ``unlimited``,
        where it :attr:`limits_velocities`.
        """
        one_call = self._known_call()
        loop = one_call.loop() if one_call.fits else None
        if loop is not None:
            return self._in_one_call(loop, command, pose, unlimited)
        if command is None:
            command = self._control.runner.limited_command(unlimited, pose)
        if not one_call.fits:
            return self._step_by_step(command, pose, unlimited)
        with in_time():  # its parts pay by themselves where the whole would not
            return self._step_by_step(command, pose, unlimited)

    @property
    def limits_velocities(self):
        """Return whether :meth:`passed` finds commands within limits by itself."""
        return self._known_call().fits

    def _known_call(self):
        if self._one_call is None:
            self._one_call = OneCall(self._control, self._around, self.way_out)
        return self._one_call

    def _in_one_call(self, loop, command, pose, unlimited):
        """As :meth:`passed`, by the compiled ``loop``."""
        control, bounds, points = self._control, NO_BOUNDS, None
        if self._around.obstacles or self._around.arena:
            points = control.points(pose)
            bounds = self.bounds(points)
        given = pose, unlimited, bounds, self._deadlocks.since
        command, passed, done = self._one_call.passed(loop, control, command, *given)
        if not done:
            given = pose, control.joints, control.l, control.period
            wanted = control.team.velocity(command, *given)
            passed = self._with_way_out(passed, pose, bounds.least(len(pose)))
            velocity = control.team.velocity(passed, *given)
            self._deadlocks.note(control.time, wanted, velocity, points, self.distance)
        return passed

    def _step_by_step(self, command, pose, unlimited):
        """As :meth:`passed`, by numpy, or by loops that are compiled one by one."""
        control = self._control
        given = pose, control.joints, control.l, control.period
        wanted = control.team.velocity(command, *given)
        points, distance = control.points(pose), self.distance
        if self._around.sensed:
            velocity = self._by_sensors(wanted, points, pose)
            self._deadlocks.note(control.time, wanted, velocity, points, distance)
            return control.saturated(control.commands_for(velocity, pose), "robot")
        bounds = self.bounds(points)
        if self.way_out is None:
            # One factor for the whole team keeps every pair's constraint.
            velocity = self._filtered(wanted, points, distance, bounds)
            passed = control.saturated(control.commands_for(velocity, pose), "team")
        else:
            passed = self._turned_away(command, wanted, unlimited, pose, points, distance, bounds)
            # Bodies are no nearer than points with their reach.
            passed = self._with_way_out(passed, pose, bounds.least(len(points)))
            velocity = wanted
            if passed is not command:
                velocity = control.team.velocity(passed, *given)
        self._deadlocks.note(control.time, wanted, velocity, points, distance)
        return passed

    def _filtered(self, wanted, points, distance, bounds):
        """Return the velocities (n, d) nearest to ``wanted`` with which ``points`` keep ``distance``."""
        return safe_velocities(
            wanted,
            points,
            distance,
            self._control.period,
            bounds=bounds,
            speed=self.speed,
            squash=self.squash,
            brakes=self.brakes,
        )

    def _turned_away(self, command, wanted, unlimited, pose, points, distance, bounds):
        """Return ``command`` (n, a), but another one for robots that the filter has go otherwise.

        ``wanted`` (n, d) [m/s]: what it gives the ``points``.  The filter starts from what the law wants
        before limits: these slow down a robot that has to turn, and would do so again for each way aside.
        """
        control = self._control
        given, speed, top = wanted, self.speed, control.team.speeds[:, 0]
        if unlimited is not None:
            wanted = capped(unlimited, top if speed is None else np.minimum(top, speed))
        velocity = self._filtered(wanted, points, distance, bounds)
        changed = (np.abs(velocity - wanted) > UNCHANGED).any(axis=1)
        if speed is not None:
            changed |= np.linalg.norm(given, axis=1) > speed
        if not changed.any():
            return command
        # The way out is certified: each robot may be as fast as it can.
        other = control.saturated(control.commands_for(velocity, pose), "robot")
        return np.where(changed[:, np.newaxis], other, command)

    def _with_way_out(self, command, pose, gap):
        """Return ``command`` (n, a) for robots to which it leaves a way out; the others brake.

        ``gap`` (n,) [m]: by which bodies are at least clear of what stands."""
        heights = self._control.runner.heights
        heights = np.ones(len(pose)) if heights is None else np.array(heights)
        around, time = self._around.standing(), self._control.time
        return self.way_out.certified(command, pose, heights, time, around, gap)

    def _by_sensors(self, wanted, points, pose):
        """Return the velocities (n, 2) that the robots' own sensors let pass."""
        control = self._control
        turn = np.stack([turned_by(theta) for theta in pose[:, 2].tolist()])
        own = np.einsum("ij,ijk->ik", points - pose[:, :2], turn)
        reach = self._reach
        # Their centres are seen, while their points are kept apart.
        reaches = reach + np.broadcast_to(control.team.lead(control.l), len(reach))
        sensed = [SensedNeighbourhood(*each, reaches, control.period) for each in zip(own, reach)]
        readings = [
            [getattr(control.readings[number], name) for name in self.sensors]
            for number in control.numbers
        ]
        return safe_by_sensors(wanted, sensed, turn, readings, self.speed)

    @property
    def way_out(self):
        """Return the ``WayOut`` that robots keep; None for points, and where the filter goes by sensors."""
        control = self._control
        if control.fidelity == "point_mass" or self._around.sensed:
            return None
        if self._way_out is None:
            given = control.team, self.body_radii, control.period, control.fidelity
            self._way_out = WayOut(*given)
        return self._way_out

    @property
    def body_radii(self):
        """Return the radii (n,) [m] about the centres that bodies lie within."""
        control = self._control
        return np.broadcast_to(np.asarray(control.safety, dtype=float), len(control.numbers))

    @property
    def brakes(self):
        """Return the ``Brakes`` by which the filter slows robots; None where they stop at once."""
        return None if self.way_out is None else self.way_out.brakes

    @property
    def sensors(self):
        """Return the names of the sensors by which the filter acts; () where it knows positions."""
        return self._around.sensed

    @property
    def sees_robots(self):
        """Return whether the filter distinguishes robots, and keeps the distance of each pair."""
        return not self._around.sensed or self._around.sees

    def bounds(self, points, time=None):
        """Return the ``Bounds`` that the filter keeps robots' ``points`` (n, 2) in.

        ``time`` [s] since the law began, by default now, gives where obstacles on tracks are.
        """
        if not (self._around.obstacles or self._around.arena):
            return NO_BOUNDS
        time = self.scene_time(self._control.time if time is None else time)
        return self._around.bounds(points, self._reach, time, self._control.period)

    def surroundings(self, standing=False):
        """Return the ``Surroundings`` that the filter keeps robots from; ``standing``: without what
        moves."""
        return self._around.standing() if standing else self._around

    @property
    def flees(self):
        """Return the top speed [m/s] of moving obstacles that the filter knows of, 0 for none."""
        return self._around.fastest

    @property
    def speed(self):
        """Return the most that the filter lets controlled points go, (n,) [m/s], or None."""
        return self._around.speed

    @property
    def deadlock(self):
        """Return the robots that the filter holds still, ``(number, since [s])`` of each."""
        rows = self._deadlocks.rows(self._control.time)
        return tuple((self._control.numbers[row], since) for row, since in rows)

    @property
    def distance(self):
        """Return ``D_s`` [m] between controlled points: ``radius_i + l_i + radius_j + l_j``, and tracking
        errors of both robots.

        ``l_i``: how far the point is from the robot's centre, ``l`` for unicycles.  A number where all
        robots are of one size, else (n, n).
        """
        late = self._late
        return sums_of_pairs(self._radii + late if late.any() else self._radii)

    @property
    def squash(self):
        """Return by what (d,) [-] the filter measures distances along x, y and z; None for 1."""
        return squash(self._control.team)

    @property
    def _radii(self):
        control = self._control
        return np.asarray(control.safety, dtype=float) + control.team.lead(control.l)

    @property
    def _late(self):
        """Return the bounds on the robots' tracking errors, (n,) [m], 0 where they obey at once, or where
        their braking is predicted."""
        control = self._control
        if self.way_out is not None:
            return np.zeros(control.team.n)
        return tracking_errors(control.team, control.fidelity, self.speed)

    @property
    def _reach(self):
        """Return ``radius_i + l_i`` and its tracking error of each robot, (n,) [m]."""
        return np.broadcast_to(self._radii + self._late, len(self._control.numbers))
