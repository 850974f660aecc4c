"""Teams of which robots leave the ground, without forces and with them."""

import numpy as np

from mrs_simulator.core.spatial import upright
from mrs_simulator.vehicles.team import columns_of
from mrs_simulator.world.forced import ForcedMotion
from mrs_simulator.world.kinematic import KinematicMotion
from mrs_simulator.world.weather import Weather

LANDED = np.array([np.inf, np.inf, 0.0])  # [m/s] that the ground lets a robot go along x, y, z


class AirborneMotion(KinematicMotion):
    """Robots on the ground as ``KinematicMotion`` has them, and others as their drives fly them."""

    def __init__(self, *arguments, z=None, **named):
        """As ``KinematicMotion``; ``z`` (n,) [m]: heights at which robots begin, by default 0."""
        self._begin = z
        super().__init__(*arguments, **named)

    def reset(self, poses, z=None):
        """Put the robots at rest at ``poses`` (n, 3) and heights ``z`` (n,) [m], by default the first."""
        super().reset(poses)
        z = self._begin if z is None else z
        self.z = np.zeros(self.team.n) if z is None else np.array(z, dtype=float)
        self._risen = self._before = self.z
        self._aloft = {
            group.drive: self._flight_of(group, self.pose[group.rows], self.z[group.rows])
            for group in self.team.groups
            if group.drive.MEDIUM == "air"
        }

    def _flight_of(self, group, pose, z):
        return AirborneGroup(group, pose, z)

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
        """Return the least distance [m] between two robots' centres now; inf for one robot."""
        return self._bodies.closest(self.pose, self.z)

    # What is done otherwise for robots that fly --------------------------------------------------

    def _rates_of(self, group):
        if group.drive.MEDIUM != "air":
            return super()._rates_of(group)
        return np.full((len(group.kinds), len(group.drive.AXES)), np.inf)

    def _retarget(self, group, clipped, command):
        if group.drive.MEDIUM == "air":
            clipped[:] = group.part(command)
        else:
            super()._retarget(group, clipped, command)

    def _moved(self, before, command):
        after = super()._moved(before, command)
        self._before, self._risen = self.z, self.z.copy()
        for group, flight in self._flying():
            after[group.rows] = flight.advance(group.of(command), self.step)
            self._risen[group.rows] = flight.spatial.z
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

    def _flight_of(self, group, pose, z):
        rows = np.arange(self.team.n)[group.rows]
        weather = Weather(self._environment, self.step, self._seed, rows)
        # Rotors have their limits whatever those of commands.
        numbers = columns_of(group.kinds, group.drive)
        group = group._replace(drive=group.drive.with_forces(), numbers=numbers)
        return AirborneGroup(group, pose, z, weather)

    def contacts(self):
        """Return the contacts of the last step: ``(first, second, x, y, z)`` each."""
        return [(*contact, 0.0) for contact in self._wheeled_contacts()] + super().contacts()


class AirborneGroup:
    """The robots of one drive that flies: its inner state, which the drive alone knows."""

    def __init__(self, group, pose, z, weather=None):
        """``group``: a ``vehicles.team.Group``, at rest at ``pose`` (m, 3) and heights ``z`` (m,) [m].

        ``weather``: what they feel, None without forces.
        """
        self._group, self._weather = group, weather
        self._take(group.drive.begin(np.array(pose), np.array(z), group.numbers))

    def _take(self, inner):
        self._inner = inner
        self._pose, self.twist, self.spatial = self._group.drive.state(inner)

    def advance(self, command, step):
        """Return the poses (m, 3) after ``step`` [s] under ``command`` (m, axes)."""
        group, air = self._group, ()
        if self._weather is not None:
            wind = self._weather.felt().wind
            air = (np.column_stack([wind, np.zeros(len(wind))]),)
        numbers = group.numbers
        self._take(group.drive.flown(self._inner, command, group.limits, numbers, step, *air))
        below = self.spatial.z < 0.0
        if below.any():  # nobody sinks into the ground
            place = np.column_stack([self._pose[:, :2], np.maximum(self.spatial.z, 0.0)])
            self.stop(below, place, LANDED)
        return self._pose

    def stop(self, pushed, place, most):
        """Let the robots ``pushed`` (m,) bool be at ``place`` (m, 3), where contacts put them.

        ``most`` (m, 3) or (3,) [m/s]: how fast they may go along x, y and z of the common frame.
        """
        if pushed.any():
            self._take(self._group.drive.stopped(self._inner, pushed, place, most))
