"""Teams of which robots leave the ground, without forces and with them."""

import importlib

import numpy as np

from mrs_simulator.core.spatial import upright
from mrs_simulator.scenario.incidents import LOST, SATURATED, UPSIDE_DOWN
from mrs_simulator.vehicles.team import columns_of
from mrs_simulator.world.contact.flight_contact import FlightContacts
from mrs_simulator.world.incidents.incident_detection import IncidentDetector, mended, not_finite
from mrs_simulator.world.motion.forced import ForcedMotion
from mrs_simulator.world.motion.kinematic import KinematicMotion
from mrs_simulator.world.motion.stretches import NEAR, STALE
from mrs_simulator.world.motion.wind_and_waves import Weather

LANDED = np.array([np.inf, np.inf, 0.0])  # [m/s] that the ground lets a robot go along x, y, z


class AirborneMotion(KinematicMotion):
    """Robots on the ground as ``KinematicMotion`` has them, and others as their drives fly them."""

    def __init__(self, *arguments, z=None, **named):
        """As ``KinematicMotion``; ``z`` (n,) [m]: heights at which robots begin, by default 0."""
        super().__init__(*arguments, **named)
        self.z = np.zeros(self.team.n) if z is None else np.array(z, dtype=float)
        self._risen = self._before = self.z
        self._aloft = {
            group.drive: self._flight_of(group, self.pose[group.rows], self.z[group.rows])
            for group in self.team.groups
            if group.drive.MEDIUM == "air"
        }

    def _flight_of(self, group, pose, z):
        return AirborneGroup(group, pose, z, self.step)

    # Motors --------------------------------------------------------------------------------------

    def inject(self, row, fault, rotor=0):
        """Inject the ``fault``, ``LOST`` or ``OFF`` of ``scenario.incidents``, into robot ``row``.

        Into a ``rotor``, its index, or its motors.  ``ValueError`` for one that has none.
        """
        for group, flight in self._flying():
            member = np.flatnonzero(np.arange(self.team.n)[group.rows] == row)
            if len(member) and hasattr(group.drive, "lost"):
                return flight.inject(int(member[0]), fault, rotor)
        raise ValueError("a {} has no rotors".format(self.team.kinds[row].title))

    def power(self, row):
        """Switch the motors of robot ``row``, which flies, on again."""
        for group, flight in self._flying():
            own = np.arange(self.team.n)[group.rows] == row
            if own.any() and hasattr(group.drive, "lost"):
                flight.power(own)

    @property
    def powered(self):
        """Return which robots, (n,) bool, fly with all of their rotors."""
        result = np.zeros(self.team.n, dtype=bool)
        for group, flight in self._flying():
            result[group.rows] = flight.powered
        return result

    def detected_incidents(self):
        """Return ``(row, what)`` of the incidents of the last step, ``what`` of ``scenario.incidents``."""
        found = []
        for group, flight in self._flying():
            for member, what in flight.detector.take():
                found.append((int(np.arange(self.team.n)[group.rows][member]), what))
        return found

    def _flying(self):
        """Return the groups that fly, and their inner states."""
        return [(g, self._aloft[g.drive]) for g in self.team.groups if g.drive in self._aloft]

    def place(self, rows, poses, twists, z=None):
        """Put mirrored robots as ``KinematicMotion`` does; ``z`` (m,) [m]: their heights, by default as
        they are."""
        super().place(rows, poses, twists)
        if z is not None:
            self.z = self.z.copy()
            self.z[rows] = z

    @property
    def spatial(self):
        """Return what pose and twist leave out, a ``Spatial``."""
        if len(self._aloft) == len(self.team.groups) == 1 and not len(self._mirrored):
            return self._aloft[self.team.groups[0].drive].spatial.copy()
        result = upright(self.pose[:, 2], self.z)
        for group, flight in self._flying():
            result.put(group.rows, flight.spatial)
        rows = self._mirrored
        result.put(rows, upright(self.pose[rows, 2], self.z[rows]))
        return result

    def contacts(self):
        """Return the contacts of the last step: ``(first, second, x, y, z)`` each."""
        return [(*contact[:4], contact.z) for contact in self._contacts]

    def closest(self):
        return self._bodies.closest(self.pose, self.z)

    # What is done otherwise for robots that fly --------------------------------------------------

    def _rates_of(self, group):
        if group.drive.MEDIUM != "air":
            return super()._rates_of(group)
        return np.full((len(group.kinds), len(group.drive.AXES)), np.inf)

    def _target_of(self, group, clipped, command):
        if group.drive.MEDIUM == "air":
            return group.part(command)
        return super()._target_of(group, clipped, command)

    def _moved(self, before, command):
        after = super()._moved(before, command)
        self._before, self._risen = self.z, self.z.copy()
        for group, flight in self._flying():
            after[group.rows] = flight.advance(group.of(command), self.step)
            self._risen[group.rows] = flight.spatial.z
        if len(self._mirrored):
            rows = self._mirrored
            after[rows], self._risen[rows] = before[rows], self.z[rows]
        return after

    def _own_twist(self):
        twist = super()._own_twist()
        for group, flight in self._flying():
            twist[group.rows] = flight.twist
        return twist

    def _separate(self):
        self.z = self._risen.copy()
        return self._bodies.separate(self.pose, self._reach, self.z)

    def _feel_contacts(self, before, free):
        super()._feel_contacts(before, free)
        place = np.column_stack([self.pose[:, :2], self.z])
        pushed = (place != np.column_stack([free[:, :2], self._risen])).any(axis=1)
        moved = np.abs(place - np.column_stack([before[:, :2], self._before])) / self.step
        for group, flight in self._flying():
            flight.stop(pushed[group.rows], place[group.rows], moved[group.rows])

    def _feel(self, group, pushed, moved):
        if group.drive.MEDIUM != "air":
            super()._feel(group, pushed, moved)


class ForcedAirborneMotion(AirborneMotion, ForcedMotion):
    """Robots under forces of which some fly, as their drives have them ``with_forces``.

    Those in the water and on wheels move as ``ForcedMotion`` has them.
    """

    SAVED = (200e-6, 200e-9)  # [s] that :meth:`fuse_steps` saves, as ``compiling.SAVED``

    def _flight_of(self, group, pose, z):
        rows = np.arange(self.team.n)[group.rows]
        weather = Weather(self._environment, self.step, self._seed, rows)
        # Rotors have their limits whatever those of commands.
        numbers = columns_of(group.kinds, group.drive)
        group = group._replace(
            drive=importlib.import_module(group.drive.WITH_FORCES), numbers=numbers
        )
        names = ["robot{}".format(row + 1) for row in rows.tolist()]
        free = ~np.isin(rows, self._mirrored)
        self._bodies.solved[rows[free]] = hasattr(group.drive, "lost")
        touching = None
        if hasattr(group.drive, "lost"):
            touching = FlightContacts(group.kinds, names, self._bodies.obstacles, free)
        return AirborneGroup(group, pose, z, self.step, weather, touching)

    @property
    def can_fuse(self):
        """Return whether :meth:`fuse_steps` moves these robots: quadrotors in steady air."""
        alone = len(self.team.groups) == len(self._aloft) == 1
        still = not (len(self._mirrored) or self._encoders or self._bodies.moves)
        return alone and still and all(flight.can_fuse for _, flight in self._flying())

    def fuse_steps(self, plan, command, function, kept, dimension, *given):
        """Move as ``KinematicMotion.fuse_steps`` does, by ``flight_stretches.flight_stretch``."""
        ((_, flight),) = self._flying()
        result = flight.fuse_steps(plan, command, function, self.step, dimension, kept, *given)
        self.pose, self._twist, self._contacts = np.array(flight.pose, order="F"), None, []
        self.z = self._risen = flight.spatial.z.copy()
        return result

    def move_obstacles(self, obstacles):
        """Let the ``obstacles``, of the same number and sizes, be where they are after the next step."""
        super().move_obstacles(obstacles)
        for _, flight in self._flying():
            flight.move_obstacles(obstacles)

    def _separate(self):
        # Robots that stand on the ground stay whatever touches them, unless they are pushed as bodies.
        self._bodies.resting = self._risen <= 0.0 if self._bodies.moves else None
        return super()._separate()

    def detected_incidents(self):
        return super().detected_incidents() + ForcedMotion.detected_incidents(self)

    def contacts(self):
        wheeled = [(*contact, 0.0) for contact in self._wheeled_contacts()]
        touched = [contact for _, flight in self._flying() for contact in flight.contacts()]
        return wheeled + touched + super().contacts()

    def close(self):
        """Disconnect from the solvers."""
        super().close()
        for _, flight in self._flying():
            flight.close()


class AirborneGroup:
    """The robots of one drive that flies: its inner state, which the drive alone knows."""

    def __init__(self, group, pose, z, step, weather=None, touching=None):
        """``group``: a ``vehicles.team.Group``, at rest at ``pose`` (m, 3) and heights ``z`` (m,) [m].

        ``step`` [s]; ``weather``: what they feel, ``touching``: what lets them touch, both None without
        forces.
        """
        self._group, self._weather, self._touching = group, weather, touching
        self.detector = IncidentDetector(len(group.kinds), step)
        self._take(group.drive.begin(np.array(pose), np.array(z), group.numbers))

    def _take(self, inner):
        self._inner, self._room = inner, None
        self.pose, self.twist, self.spatial = self._group.drive.state(inner)

    @property
    def powered(self):
        """Return which robots, (m,) bool, have all of their rotors."""
        working = getattr(self._inner, "working", None)
        return True if working is None else working.all(axis=1)

    def advance(self, command, step):
        """Return the poses (m, 3) after ``step`` [s] under ``command`` (m, axes)."""
        group, forces = self._group, ()
        if self._weather is not None:
            forces = (self._wind(),)
        if self._touching is not None:
            forces += (self._touching.solver(self._inner, step),)
        given = self._inner, command, group.limits, group.numbers, step
        inner = group.drive.flown(*given, *forces)
        bad = not_finite(inner)
        if bad is not None:
            inner = self._stopped(mended(inner, self._inner, bad, self.detector), bad)
        self._take(inner)
        self._look()
        below = self.spatial.z < 0.0
        if below.any():  # robots do not sink into the ground
            place = np.column_stack([self.pose[:, :2], np.maximum(self.spatial.z, 0.0)])
            self.stop(below, place, LANDED)
        return self.pose

    @property
    def can_fuse(self):
        """Return whether :meth:`fuse_steps` moves these robots."""
        able = self._touching is not None and hasattr(self._group.drive, "stretched")
        return able and self._weather.is_steady

    def fuse_steps(self, plan, command, function, step, dimension, kept, *given):
        """Move by several steps of ``step`` [s] as ``KinematicMotion.fuse_steps`` does.

        ``dimension``: how many coordinates the controlled points have.
        """
        group, inner = self._group, self._inner
        if inner.working is not None or not self.detector.is_idle:
            return 0, 0, NEAR
        is_new = self._room is None
        room = self._touching.room(inner.place) if is_new else self._room
        near, wind = (room, self._touching.contact, dimension), self._wind()
        own = inner, command, group.limits, group.numbers, step, wind, near, kept
        inner, (done, filled, room, why) = group.drive.stretched(function, plan, *own, *given)
        if why == STALE and is_new and done == 0:
            return 0, 0, NEAR
        self._touching.forget()
        self._take(inner)
        self._room = None if why == STALE else room
        return done, filled, why

    def _wind(self):
        wind = self._weather.disturbances().wind
        return np.column_stack([wind, np.zeros(len(wind))])

    def _stopped(self, inner, rows):
        """Return ``inner`` with robots ``rows`` (m,) bool at rest, their motors off where they have any."""
        drive = self._group.drive
        pose, _, spatial = drive.state(inner)
        inner = drive.stopped(inner, rows, np.column_stack([pose[:, :2], spatial.z]), np.zeros(3))
        return drive.powerless(inner, rows) if hasattr(drive, "lost") else inner

    def _look(self):
        drive = self._group.drive
        if hasattr(drive, "upside_down"):
            self.detector.update(UPSIDE_DOWN, drive.upside_down(self._inner))
            self.detector.update(SATURATED, drive.saturated(self._inner, self._group.numbers))

    def move_obstacles(self, obstacles):
        """Let a solver have the ``obstacles`` where they are after the next step."""
        if self._touching is not None:
            self._touching.move_obstacles(obstacles)

    def inject(self, member, fault, rotor):
        """Inject a ``fault`` into the robot ``member``: into a ``rotor``, its index, or its motors."""
        drive = self._group.drive
        if fault == LOST:
            self._take(drive.lost(self._inner, member, rotor))
        else:
            self._take(drive.powerless(self._inner, member))

    def power(self, rows):
        """Switch the motors of robots ``rows`` (m,) bool on again."""
        self._take(self._group.drive.powered(self._inner, rows))

    def contacts(self):
        """Return the contacts of the last step that a solver found: ``(first, second, x, y, z)`` each."""
        return [] if self._touching is None else self._touching.contacts()

    def stop(self, pushed, place, most):
        """Let the robots ``pushed`` (m,) bool be at ``place`` (m, 3), where contacts put them.

        ``most`` (m, 3) or (3,) [m/s]: how fast they may go along x, y and z of the common frame.
        """
        if pushed.any():
            self._take(self._group.drive.stopped(self._inner, pushed, place, most))

    def close(self):
        """Disconnect from the solver."""
        if self._touching is not None:
            self._touching.close()
