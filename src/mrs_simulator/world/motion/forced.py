"""Robots under forces: in the water as arrays, on wheels in a solver; kept apart as without forces."""

import math

import numpy as np

from mrs_simulator.scenario.surroundings.environment import CALM
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.team import columns_of
from mrs_simulator.world.incidents.incident_detection import IncidentDetector, mended, not_finite
from mrs_simulator.world.motion.kinematic import KinematicMotion
from mrs_simulator.world.motion.wind_and_waves import Weather


class ForcedMotion(KinematicMotion):
    """Robots under forces, each group as its own kind of motion has it.

    Robots on wheels meet each other and obstacles in the solver.  To those in the water and in the air
    they are firm: they push others, and are not pushed.
    """

    def __init__(self, kinds, poses, obstacles=(), limits="firmware", step=0.02, mirrored=(),
                 encoders=False, environment=CALM, seed=0, engine="pybullet", errors=None):  # fmt: skip
        """As ``KinematicMotion``; ``seed``: of the gusts and waves of ``environment``; ``engine``: what
        moves robots on wheels."""
        self._environment, self._seed = environment, seed
        team, self._wheeled = Team.of(kinds, limits), None
        if any(group.drive.MEDIUM == "ground" for group in team.groups):
            from mrs_simulator.world.motion.wheeled import (
                WheeledPart,  # pybullet only where it is used
            )

            given = team, poses, obstacles, limits, step, mirrored
            self._wheeled = WheeledPart(*given, engine, errors)
        super().__init__(
            *(team, poses, obstacles, limits, step, mirrored, encoders),
            environment=environment,
            errors=errors,
        )
        self._reach = np.inf  # waves push harder than thrusters
        # (n, 4) of thrusters commanded past the controllers, nan where not; None: nowhere
        self.efforts = None
        groups = self.team.groups
        self._parts = {g.drive: self._part(g) for g in groups if g.drive.MEDIUM == "water"}
        self._watched = [(g, self._parts[g.drive]) for g in groups if g.drive in self._parts]

    @property
    def wheeled(self):
        """Return the ``WheeledPart``, None where no robot is on wheels."""
        return self._wheeled

    def _firm(self, mirrored):
        return list(mirrored) if self._wheeled is None else [*mirrored, *self._wheeled.rows]

    def _part(self, group):
        rows = np.arange(self.team.n)[group.rows]
        weather = Weather(self._environment, self.step, self._seed, rows)
        return ForcedGroup(group, weather, self.step)

    def place(self, rows, poses, twists):
        super().place(rows, poses, twists)
        if self._wheeled is not None:
            self._wheeled.place(rows, poses, twists)

    def move_obstacles(self, obstacles):
        """Let the ``obstacles``, of the same number and sizes, be where they are after the next step."""
        super().move_obstacles(obstacles)
        if self._wheeled is not None:
            self._wheeled.move_obstacles(obstacles)

    def joints(self):
        result = np.zeros(self.team.n)
        if self._wheeled is not None:
            result[self._wheeled.rows] = self._wheeled.joints()
        return result

    def contacts(self):
        """Return the contacts of the last step: ``(first, second, x, y)`` each."""
        return self._wheeled_contacts() + [contact[:4] for contact in self._contacts]

    def detected_incidents(self):
        """Return ``(row, what)`` of the incidents of the last step, ``what`` of ``scenario.incidents``."""
        return [
            (int(np.arange(self.team.n)[group.rows][member]), what)
            for group, part in self._watched
            for member, what in part.detector.take()
        ]

    def close(self):
        """Disconnect from the solver."""
        if self._wheeled is not None:
            self._wheeled.close()

    # What is done otherwise for robots under forces ----------------------------------------------

    def _moved(self, before, command):
        after = before.copy(order="F")
        for group, travel in zip(self.team.groups, self.wheel_travel):
            if group.drive not in self._parts:
                continue
            part = self._parts[group.drive]
            efforts = None if self.efforts is None else self.efforts[group.rows]
            after[group.rows] = part.advance(before[group.rows], group.of(command), efforts)
            if self._encoders:
                travel += self.step * part.counted()
        if self._wheeled is not None:
            after[self._wheeled.rows] = self._wheeled.advance(command)
            if self._encoders:
                self._wheeled.count(self.team, self.wheel_travel)
        after[self._mirrored] = before[self._mirrored]  # nothing carries them off
        return after

    def _separate(self):
        contacts = super()._separate()
        if self._wheeled is None:
            return contacts
        return [contact for contact in contacts if not self._wheeled.knows(contact)]

    def _wheeled_contacts(self):
        return [] if self._wheeled is None else self._wheeled.contacts()

    def _own_twist(self):
        twist = np.zeros_like(self.pose)
        for group in self.team.groups:
            if group.drive in self._parts:
                twist[group.rows] = self._parts[group.drive].twist()
        if self._wheeled is not None:
            twist[self._wheeled.rows] = self._wheeled.twist
        return twist

    def _feel(self, group, pushed, moved):
        if group.drive in self._parts:
            self._parts[group.drive].feel(pushed, moved)


class ForcedGroup:
    """The inner state of the robots of one drive under forces."""

    def __init__(self, group, weather, step):
        """``group``: a ``vehicles.team.Group``; ``weather``: what these robots feel; ``step`` [s]."""
        self._drive, self._limits = group.drive, group.limits
        self._numbers = columns_of(group.kinds, group.drive)  # whatever the limits
        self._weather, self._step = weather, step
        self._state = group.drive.begin(len(group.kinds))
        self.detector = IncidentDetector(len(group.kinds), step)

    def advance(self, pose, command, efforts=None):
        """Return the poses (m, 3) after a step from ``pose`` under ``command`` (m, axes).

        ``efforts`` (m, 4): of thrusters that are commanded past the controllers.
        """
        after, state = self._drive.forced(
            pose,
            self._state,
            command,
            self._limits,
            self._numbers,
            self._weather.disturbances(),
            self._step,
            *(() if efforts is None else (efforts,)),
        )
        # What is wrong with a velocity shows in the pose at once.
        bad = None if math.isfinite(after.sum()) else not_finite((after, *state))
        if bad is not None:  # they are where they were, at rest
            at_rest = self._drive.begin(len(after))
            after = np.where(bad[:, np.newaxis], pose, after)
            state = mended(state, at_rest, bad, self.detector)
        self._state = state
        return after

    def counted(self):
        """Return what the encoders count per second, (m, encoders)."""
        velocity = self._drive.axis_velocity(self._state)
        return self._drive.rim_speeds(velocity, np.zeros(len(velocity)), self._numbers)

    def twist(self):
        """Return the body twists (m, 3) through the water, [m/s, m/s, rad/s]."""
        return self._drive.twist_of(self._state)

    def feel(self, pushed, moved):
        """Let the robots ``pushed`` (m,) bool be as fast as contacts let them, ``moved`` (m, 2) [m/s]."""
        self._state = self._drive.stopped(self._state, pushed, moved[pushed])
