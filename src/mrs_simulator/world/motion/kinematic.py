"""Motion without forces: each drive's exact kinematics, and point masses for pure theory."""

import math

import numpy as np

from mrs_simulator.core.compiling import same_bits
from mrs_simulator.core.kinematics import (
    UNICYCLE_AXES,
    Reach,
    cos_sin,
    max_abs,
    moved_along_arcs_wrapped,
    ramped,
)
from mrs_simulator.core.neighbours import least_distance
from mrs_simulator.core.spatial import upright
from mrs_simulator.core.uneven_wheels import UnevenWheels
from mrs_simulator.scenario.surroundings.environment import CALM
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.drives import differential, omnidirectional
from mrs_simulator.vehicles.team import on_axes
from mrs_simulator.world.contact.bodies import Bodies
from mrs_simulator.world.motion.compiled import compiled_approached, compiled_carried, compiled_feel
from mrs_simulator.world.motion.crowd_steps import compiled_step
from mrs_simulator.world.motion.stretches import STALE


def approached_function():
    """Return ``core.kinematics.ramped``, or its compiled twin where that pays."""
    return same_bits(compiled_approached, MANY) or ramped


def carried_function():
    """Return ``core.kinematics.moved_along_arcs_wrapped``, or its compiled twin where that pays."""
    return same_bits(compiled_carried, MANY) or moved_along_arcs_wrapped


MANY = 25  # [-] worlds of one process, such as a search makes, from which on loading numba pays
CLIMB = "linear.z"
PLANAR_AXES = ("linear.x", "linear.y", "angular.z")
DIAGONAL = math.sqrt(2.0)  # [-] of a velocity by its greatest component, at most
SHORT = 0.05  # [m] in a step: a bound that spares bodies most of the looks as it is


def into_body(vectors, theta):
    """Return ``vectors`` (n, 2), of the common frame, in the bodies' frames."""
    cos, sin = cos_sin(theta)
    x, y = vectors[:, 0], vectors[:, 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=1)


def currents(team, environment, mirrored):
    """Return the velocities (n, 2) [m/s] of the water that carries robots, None where none is carried."""
    result = np.zeros((team.n, 2))
    for group in team.groups:
        if group.drive.MEDIUM == "water":
            result[group.rows] = environment.current
    result[mirrored] = 0.0  # they are where they are
    return result if result.any() else None


class KinematicMotion:
    """Robots moved exactly, with the firmware's limits, bodies kept apart."""

    z = spatial = None  # all robots are on the ground

    def __init__(self, kinds, poses, obstacles=(), limits="firmware", step=0.02, mirrored=(),
                 encoders=False, environment=CALM, errors=None):  # fmt: skip
        """``kinds``: the ``Team``, or its kinds; ``poses`` (n, 3); ``step`` [s] of one advance.

        ``limits`` as in ``vehicles.limits.kind_limits``; ``mirrored``: rows of robots that ``place``
        alone moves; ``encoders``: keep ``wheel_travel``, which only odometry wants; ``environment``: its
        current carries robots in the water; ``errors``: of wheels, as ``UnevenWheels.of`` takes them.
        """
        self.step = step
        self.team = Team.of(kinds, limits)
        self._approached, self._carried = approached_function(), carried_function()
        self._most = Reach.of(step * self.team.by_group(self._rates_of, np.inf))
        self._least, self._greatest = (
            self.team.by_group(lambda g, end=end: self._bounds_of(g)[end]) for end in (0, 1)
        )
        self._retargeted = [g for g in self.team.groups if not getattr(g.drive, "CLIPPED", False)]
        self._unramped = [group for group in self.team.groups if not group.drive.RAMPS]
        # [m] the longest way in a step
        self._reach = step * float(self.team.speeds[:, 0].max())
        self._encoders, self._bounds, self._shares = encoders, None, None
        self._is_alike = None  # whether all are unicycles that nothing but their wheels moves
        self._bodies = Bodies(self.team, obstacles, self._firm(mirrored))
        self._mirrored = np.array(sorted(mirrored), dtype=int)
        self._current = currents(self.team, environment, self._mirrored)
        if self._current is not None:
            self._reach += step * float(np.hypot(*environment.current))
        self._uneven = UnevenWheels.of(errors)
        if len(self._mirrored) or self._uneven:
            self._reach = np.inf
        self.pose = np.array(poses, dtype=float, order="F")
        # as ``place`` set them
        self._twist, self._mirrored_twist = None, np.zeros((len(self._mirrored), 3))
        # What ramps, group after group: velocities along the team's axes, or joints instead.
        self._inner = np.zeros((self.team.n, len(self.team.axes)), order="F")
        self.wheel_travel = [  # how far the wheels of each group have rolled, (m, encoders) [m]
            np.zeros((len(group.kinds), group.drive.ENCODERS), order="F")
            for group in self.team.groups
        ]
        self._contacts = []

    def _firm(self, mirrored):
        """Return the rows of robots that give way to no other: the ``mirrored`` ones."""
        return mirrored

    def _rates_of(self, group):
        return group.drive.rates(group.limits, group.numbers)

    def _bounds_of(self, group):
        drive, limits = group.drive, group.limits
        if hasattr(drive, "bounds"):
            return drive.bounds(limits, group.numbers)
        return -limits.top, limits.top

    def _target_of(self, group, clipped, command):
        """Return the inner states (m, axes of the drive) to which the group ramps under ``command`` (n, a).

        ``clipped``: the group's commands within the bounds of each axis.
        """
        own = group.part(command), group.part(self._inner)
        if hasattr(group.drive, "retargeted"):
            return group.drive.retargeted(clipped, *own, group.numbers)
        return group.drive.target(*own, group.limits, group.numbers)

    def _inner_of(self, group):
        return group.part(self._inner)

    def joints(self):
        """Return the drives' inner joints, such as steering angles, (n,) [rad]; 0 where none is."""
        joints = np.zeros(self.team.n)
        for group in self.team.jointed:
            joints[group.rows] = group.joints_of(self._inner_of(group))
        return joints

    def place(self, rows, poses, twists):
        """Put mirrored robots ``rows`` (m,) at ``poses`` (m, 3) with body ``twists`` (m, 3)."""
        self.pose, self._twist = self.pose.copy(order="F"), None
        self.pose[rows] = poses
        self._mirrored_twist[np.searchsorted(self._mirrored, rows)] = twists

    def displace(self, row, by):
        """Put robot ``row`` elsewhere, ``by`` (2,) [m]."""
        self.pose = self.pose.copy(order="F")
        self.pose[row, :2] += by
        self._bodies.moved_elsewhere()

    def advance(self, command):
        """Move for one step under ``command`` (n, a), a column for each axis of the team."""
        if len(self._mirrored):
            command = command.copy(order="K")
            command[self._mirrored] = 0.0
        if self._contacts and self._step_by_loop(command):
            return
        before = self.pose
        free = self._moved(before, command)
        self.pose, self._twist = free.copy(order="F"), None
        self._contacts = self._separate()
        if self._contacts:
            self._feel_contacts(before, free)

    def _step_by_loop(self, command):
        """As :meth:`advance`, of unicycles in a crowd, in one compiled call; return whether that can be."""
        if not self.is_crowd:
            return False
        step = same_bits(compiled_step)
        if step is None:
            return False
        limits, *bounds = self.crowd_given()
        n, before = self.team.n, self.pose
        pose, inner = np.empty((n, 3), order="F"), np.empty((n, 2), order="F")
        after = inner.T, (np.empty(n), np.empty(n))
        state = before.T, self._inner.T, self._bodies.headings(before)
        given = state, (np.asfortranarray(command).T, limits), *bounds
        contacts = self._bodies.step_by_loop(step, given, pose, after)
        if contacts is None:
            return False
        self.pose, self._inner, self._twist, self._contacts = pose, inner, None, contacts
        return True

    @property
    def is_of_unicycles(self):
        """Return whether all robots are unicycles that nothing but their wheels moves."""
        if self._is_alike is None:
            self._is_alike = self.can_fuse and self.team.groups[0].drive is differential
        return self._is_alike

    @property
    def is_crowd(self):
        """Return whether ``crowd_steps`` move these robots: unicycles, rectangles on open ground."""
        return self.is_of_unicycles and self._bodies.is_plain

    @property
    def room(self):
        """Return how many steps robots move at least before two bodies can touch, by what is known."""
        return self._bodies.room / self._reach

    def crowd_given(self):
        """Return what ``crowd_steps.step_all`` takes that stays: the limits, and what is after them."""
        if self._bounds is None:
            self._bounds = self._fusing_bounds()
        share = self.step * DIAGONAL if SHORT < self._reach < np.inf else 0.0
        return *self._bounds, self.step, (self._reach, share)

    def lend(self):
        """Return poses (n, 3), inner states (n, a) and bodies, which another moves from here on, up to
        :meth:`go_on_from`."""
        return self.pose, self._inner, self._bodies

    def go_on_from(self, pose, inner, *seen):
        """Go on from poses (n, 3), inner states (n, a) and what ``Bodies.go_on_from`` takes after these."""
        self.pose, self._inner, self._twist = pose, inner, None
        self._contacts = self._bodies.go_on_from(pose, *seen)

    @property
    def can_fuse(self):
        """Return whether :meth:`fuse_steps` moves these robots: unicycles, or omnidirectional bases, that
        nothing but their wheels moves."""
        drives = [group.drive for group in self.team.groups]
        alike = drives in ([differential], [omnidirectional])
        carried = self._current is not None or len(self._mirrored) or self._encoders
        carried = carried or self._uneven
        return type(self) is KinematicMotion and alike and not carried

    def fuse_steps(self, plan, command, function, kept, *given):
        """Move by several steps by a function of ``stretches``; return how many, how many samples were
        kept, and why it ended.

        ``plan`` and ``kept`` as there; ``command`` (n, a), which is changed in place.
        """
        if self._bounds is None:
            self._bounds = self._fusing_bounds()
        # The law may raise: nothing has happened then.
        moved = pose, inner, obeyed = [each.copy("F") for each in (self.pose, self._inner, command)]
        bodies, columns = self._bodies, (each.T for each in moved)
        room = self.step, self._reach, bodies.room, bodies.around(pose)
        done, filled, bodies.room, why = function(
            plan, *columns, *self._bounds, *room, kept, *given
        )
        if why == STALE:
            bodies.list_anew()
        command[:] = obeyed
        self.pose, self._inner, self._twist, self._contacts = pose, inner, None, []
        return done, filled, why

    def _fusing_bounds(self):
        """Return the ``limits`` that ``stretches`` keep to, and where bases have them the ``wheels``."""
        top = self.team.limits.of_all(self.team.n).top
        bounds = self._least, self._greatest, self._most.up, self._most.both, top
        limits = np.ascontiguousarray(np.concatenate(bounds, axis=1).T)
        (group,) = self.team.groups
        if group.drive is differential:
            return (limits,)
        return limits, omnidirectional.rims(group.numbers, self.team.n)

    def move_obstacles(self, obstacles):
        """Let the ``obstacles`` be where they are now."""
        self._bodies.move_obstacles(obstacles)

    def _separate(self):
        """Push overlapping bodies apart; return the contacts."""
        return self._bodies.separate(self.pose, self._farthest())

    def _farthest(self):
        """Return a distance [m] that no robot exceeded in this step."""
        if not SHORT < self._reach < np.inf or self._current is not None:
            return self._reach
        # Turn rates and angles count like speeds: that is quicker, and the bound rarely any worse.
        return min(self._reach, self.step * DIAGONAL * max_abs(self._mean))

    def _moved(self, before, command):
        """Return the poses (n, 3) after a step from ``before``, without contacts."""
        self._mean = self._follow(command)
        velocity = self._velocities(self._mean)
        if self._encoders:
            self._count(velocity)
        velocity = self._by_true_wheels(velocity)
        twist = planar(self.team.in_rows(velocity), self.team.axes)
        if self._shares is None:  # [s] by which twists are distances, and half of the turns
            self._shares = np.full(twist.shape, self.step, order="F")
            self._shares[:, -1] *= 0.5
        after = self._carried(before, twist * self._shares)
        if self._current is not None:
            after[:, :2] += self.step * self._current
        return after

    def _follow(self, command):
        """Let the inner states follow ``command``; return their means (n, a) over the step."""
        command = self.team.grouped(command)
        target = np.minimum(np.maximum(command, self._least), self._greatest)
        for group in self._retargeted:
            group.fill(target, self._target_of(group, group.part(target), command))
        before = self._inner
        self._inner, mean = self._approached(before, target, self._most)
        for group in self._unramped:
            given = group.part(before), group.part(target), group.limits, group.numbers
            for values, part in zip((self._inner, mean), group.drive.followed(*given, self.step)):
                group.fill(values, part)
        return mean

    def _velocities(self, inner):
        """Return the velocities (n, a) along the team's axes of ``inner`` states, group after group."""
        if not self.team.has_joints:
            return inner
        velocity = inner.copy(order="F")
        for group in self.team.jointed:
            group.fill(velocity, group.velocities(group.part(inner)))
        return velocity

    def _by_true_wheels(self, velocity):
        """Return the velocities (n, a) of the bodies whose wheels are held at ``velocity``."""
        if self._uneven is None:
            return velocity
        moved = velocity.copy(order="F")
        for group in self.team.groups:
            where = group.span, group.columns
            moved[where] = self._uneven.moved(group, velocity[where])
        return moved

    def _count(self, velocity):
        """Let the encoders count a step of mean ``velocity`` (n, a), group after group."""
        for group, travel in zip(self.team.groups, self.wheel_travel):
            if not group.drive.ENCODERS:
                continue
            joints = group.joints_of(self._inner_of(group))
            speeds = group.drive.rim_speeds(group.part(velocity), joints, group.numbers)
            travel += self.step * speeds

    @property
    def twist(self):
        """Return the body twists, (n, 3) [m/s, m/s, rad/s]."""
        if self._twist is None:  # few ask for it at every step
            self._twist = self._own_twist()
            if self._current is not None:
                self._twist[:, :2] += into_body(self._current, self.pose[:, 2])
            self._twist[self._mirrored] = self._mirrored_twist
        return self._twist

    def _own_twist(self):
        """Return the body twists (n, 3) that the robots move by themselves."""
        velocity = self.team.in_rows(self._by_true_wheels(self._velocities(self._inner)))
        return np.array(on_axes(velocity, self.team.axes, PLANAR_AXES), order="F")

    def _feel_contacts(self, before, free):
        if self._current is None and [g.drive for g in self.team.groups] == [differential]:
            feel = same_bits(compiled_feel)
            if feel is not None:
                self._approached, self._carried = compiled_approached(), compiled_carried()
                given = self.pose.T, free.T, before.T, *self._bodies.headings(before), self.step
                feel(*given, self._inner.T)
                return
        pushed = np.any(self.pose[:, :2] != free[:, :2], axis=1)
        moved = (self.pose[:, :2] - before[:, :2]) / self.step
        if self._current is not None:
            moved -= self._current
        body = into_body(moved, before[:, 2])
        for group in self.team.groups:
            self._feel(group, pushed[group.rows], body[group.rows])

    def _feel(self, group, pushed, moved):
        """Let the robots of ``group`` that are ``pushed`` (m,) be as fast as contacts let them.

        ``moved`` (m, 2) [m/s] as seen from the bodies.
        """
        inner = self._inner_of(group).copy()
        inner[pushed] = group.drive.blocked(inner[pushed], moved[pushed])
        group.fill(self._inner, inner)

    def contacts(self):
        """Return the contacts of the last step: ``Touches``, or ``(first, second, x, y)`` each."""
        return self._contacts

    def closest(self):
        """Return the least distance [m] between two robots' centres now; inf for one robot."""
        return self._bodies.closest(self.pose)

    def close(self):
        """Nothing is held."""


def planar(velocity, axes):
    """Return ``velocity`` (n, a) along ``axes`` as twists that ``displaced`` takes, (n, 2) or (n, 3)."""
    return velocity if axes == UNICYCLE_AXES else on_axes(velocity, axes, PLANAR_AXES)


class PointMassMotion:
    """Controlled points as point masses: ``alpha' = A(theta) (v, omega)``, (3), headings frozen.

    No limits and no bodies: the world of the theorems.  A command held for one step moves the point
    by exactly ``step * alpha'``.
    """

    def __init__(self, kinds, poses, hand_length, step=0.02, mirrored=(), period=0.0,
                 environment=CALM, z=None):  # fmt: skip
        """``kinds``: the ``Team``, or its kinds; ``hand_length`` [m] is l, as the drives' points take it.

        ``mirrored``: rows of robots that ``place`` alone moves; ``period`` [s] for which a command is
        held, by default ``step``: a car's gives the steering angle at its end; ``environment``: its current
        carries points in the water; ``z`` (n,) [m]: heights at which robots begin, by default 0.
        """
        self.step, self._period = step, period or step
        self.team = Team.of(kinds, None)
        self._climb = self.team.axes.index(CLIMB) if CLIMB in self.team.axes else None
        self._hand_length = hand_length
        self._mirrored = np.array(mirrored, dtype=int)
        self._current = currents(self.team, environment, self._mirrored)
        self.wheel_travel = [
            np.zeros((len(group.kinds), group.drive.ENCODERS)) for group in self.team.groups
        ]
        self.pose = np.array(poses, dtype=float, order="F")
        self.twist = np.zeros_like(self.pose)
        self.z = None  # of a team on the ground
        if self.team.is_spatial:
            self.z = np.zeros(self.team.n) if z is None else np.array(z, dtype=float)
            self._rising = np.zeros(self.team.n)

    @property
    def spatial(self):
        """Return what pose and twist leave out, a ``Spatial``; None for a team on the ground."""
        if self.z is None:
            return None
        result = upright(self.pose[:, 2], self.z)
        result.twist[:, 0] = self._rising
        return result

    def joints(self):
        """Return the drives' inner joints, (n,) [rad]: none of them moves."""
        return np.zeros(self.team.n)

    def place(self, rows, poses, twists, z=None):
        """Put mirrored robots ``rows`` (m,) at ``poses`` (m, 3) with body ``twists`` (m, 3).

        ``z`` (m,) [m]: their heights, by default as they are.
        """
        self._renew()
        self.pose[rows], self.twist[rows] = poses, twists
        if self.z is not None and z is not None:
            self.z[rows] = z

    def displace(self, row, by):
        """Put point ``row`` elsewhere, ``by`` (2,) [m]."""
        self._renew()
        self.pose[row, :2] += by

    def _renew(self):
        """Replace poses and twists by copies, since callers may keep the old arrays."""
        self.pose, self.twist = self.pose.copy(order="F"), self.twist.copy(order="F")

    def advance(self, command):
        """Move for one step under ``command`` (n, a); the body twist is the point's velocity."""
        self._renew()
        mirrored_twist = self.twist[self._mirrored]
        command = np.array(command, dtype=float)
        command[self._mirrored] = 0.0
        u = self.team.velocity(command, self.pose, self.joints(), self._hand_length, self._period)
        if self._current is not None:
            u = u + self._current
        cos, sin = cos_sin(self.pose[:, 2])
        self.pose[:, :2] += self.step * u
        self.twist[:, 0] = cos * u[:, 0] + sin * u[:, 1]
        self.twist[:, 1] = cos * u[:, 1] - sin * u[:, 0]
        self.twist[self._mirrored] = mirrored_twist
        if self.z is not None and self._climb is not None:
            self._rising = command[:, self._climb]
            self.z = self.z + self.step * self._rising

    @property
    def can_fuse(self):
        """Return whether :meth:`fuse_steps` moves these points: of unicycles that obey commands alone."""
        drives = [group.drive for group in self.team.groups]
        return drives == [differential] and not len(self._mirrored)

    def fuse_steps(self, plan, command, function, kept, *given):
        """Move as ``KinematicMotion.fuse_steps`` does, by ``stretches.point_stretch``."""
        moved = pose, twist, obeyed = [each.copy("F") for each in (self.pose, self.twist, command)]
        result = function(plan, *(each.T for each in moved), self.step, kept, *given)
        self.pose, self.twist, command[:] = pose, twist, obeyed
        return result

    def move_obstacles(self, obstacles):
        """Change nothing: points meet no obstacles."""

    def contacts(self):
        """Return no contacts: points have no bodies."""
        return []

    def closest(self):
        """Return the least distance [m] between two robots' centres now; inf for one robot."""
        place = self.pose[:, :2]
        return least_distance(place if self.z is None else np.column_stack([place, self.z]))

    def close(self):
        """Nothing is held."""
