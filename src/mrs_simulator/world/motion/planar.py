"""Motion with forces of robots on flat ground, in the plane; in pybullet while they may touch, or tip.

Two wheels on an axle roll as ``rolling`` has it.  Wheels with rollers, and wheels that slide as a rule,
push a rigid body with what ``wheel_forces`` gives, as they do in ``dynamic``.  A robot that may touch
another one or an obstacle, or that would tip, is a body in pybullet from that step on, with the velocity
that it has and under the same motors; it comes back when nothing is near and it stands on all its wheels.
"""

import numpy as np
import pybullet

from mrs_simulator.core.compiling import same_bits
from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.core.neighbours import squared
from mrs_simulator.scenario.surroundings.moving_obstacles import moves
from mrs_simulator.scenario.surroundings.obstacles import is_flat
from mrs_simulator.vehicles.drives import differential
from mrs_simulator.world.contact.broad_phase import BroadPhase
from mrs_simulator.world.motion.compiled_rolling import compiled_rolled
from mrs_simulator.world.motion.dynamic import STANDING, STILL, DynamicMotion, seen_at_centre
from mrs_simulator.world.motion.planar_body import PlanarBodies
from mrs_simulator.world.motion.rolling import Wheels, rolled
from mrs_simulator.world.motion.rolling_steps import compiled_roll_step
from mrs_simulator.world.motion.stretches import NEAR
from mrs_simulator.world.motion.wheel_stances import Standing

SUBSTEP, ITERATIONS = 1.0 / 240.0, 50  # [s], [-] of the solver, as pybullet has them untuned
HELD = 10  # [-] steps that a robot is in the solver at least
LEVEL = 0.01  # [rad] of tilt, and
# [m/s, rad/s] of bouncing, rolling and pitching, below which it stands on all its wheels
CALM = 0.05
WORTH = 2000  # [-] steps that take numpy as long as numba takes to load
EVERY = slice(None)
QUICKER = 0.5  # [m/s] by which a robot may become faster in a step


class PlanarMotion(DynamicMotion):
    """``DynamicMotion`` in the plane, and in the solver where that is needed."""

    SUBSTEP, ITERATIONS = SUBSTEP, ITERATIONS
    SAVED = (60e-6, 1e-6)  # [s] that :meth:`fuse_steps` saves, as ``compiling.SAVED``

    def __init__(self, kinds, poses, obstacles=(), *arguments, **named):
        """As ``DynamicMotion``.  Raises ``ValueError`` for kinds that do not stand on two wheels and
        casters, nor are pushed by wheel forces."""
        self._solid = [each for each in obstacles if not is_flat(each)]
        super().__init__(kinds, poses, obstacles, *arguments, **named)
        self._since = np.zeros(self.team.n, dtype=int)  # steps in the solver
        self._calm = np.zeros(self.team.n, dtype=bool)
        self._counted = [  # by encoders of those that wheel forces push, [m]
            np.zeros((len(group.kinds), group.drive.ENCODERS)) for group in self.team.groups
        ]
        self._sliding = [None] * len(self.team.groups)
        self._known = None  # what ``rolling_steps`` takes of these robots
        self._is_alike = self.can_fuse
        self._divide()

    def _populate(self, poses):
        standing = Standing(list(dict.fromkeys(self.team.kinds)))
        try:
            self._models, self._stances = standing.learned()
        finally:
            standing.close()
        own = [self._stances[kind] for kind in self.team.kinds]
        self._mass, self._inertia, self._centre = (
            np.array([getattr(stance, key) for stance in own])
            for key in ("mass", "inertia", "ahead")
        )
        self._broad_phase = BroadPhase([stance.reach for stance in own], self._solid)
        self._radius = np.array([kind.numbers.radius for kind in self.team.kinds])

    def _divide(self):
        """Divide robots into those in the solver, those that roll and those pushed in the plane."""
        free = set(range(self.team.n)) - set(self._bodies) - set(self._mirrored.tolist())
        groups = self.team.groups
        self._pushed = list(
            map(self._forces_of, groups, self._pushed, [self._bodies] * len(groups))
        )
        self._sliding = list(map(self._forces_of, groups, self._sliding, [free] * len(groups)))
        self._rolling = np.array([row for row in sorted(free) if self._wheels[row]], dtype=int)
        self._on_wheels = self._columns(self._rolling.tolist())

    def _forces_of(self, group, known, among):
        """Return the ``WheelForces`` of the ``group``'s rows ``among`` these, which may be ``known``."""
        forces = self._wheel_forces(group, among)
        same = None not in (forces, known) and np.array_equal(forces.rows, known.rows)
        return known if same else forces

    def _columns(self, rows):
        kinds = [self.team.kinds[row] for row in rows]
        own = [self._stances[kind] for kind in kinds]
        columns = [(
            stance.mass, stance.inertia, stance.ahead, stance.height, stance.half, stance.load,
            stance.shift, stance.front - stance.ahead, stance.rear - stance.ahead,
            kind.numbers.friction, kind.numbers.torque / kind.numbers.radius,
        ) for kind, stance in zip(kinds, own)]  # fmt: skip
        return Wheels(*np.array(columns, dtype=float).reshape(-1, len(Wheels._fields)).T.copy())

    @property
    def wheel_travel(self):
        result = [counted.copy() for counted in self._counted]
        for group, travel in zip(self.team.groups, result):
            if group.drive.ENCODERS == 2:
                travel += (self._angles[group.rows].T * group.numbers.radius).T
        return self._counted_by(result)

    def move_obstacles(self, obstacles):
        moving = [each for each in self._plane.obstacles if moves(each)]
        super().move_obstacles(obstacles)
        solid = [each for each in obstacles if not is_flat(each)]
        self._broad_phase.stand(solid + [each for each in moving if not is_flat(each)])

    # A step --------------------------------------------------------------------------------------

    def advance(self, command):
        """Move for one step under ``command`` (n, a), a column for each axis of the team."""
        mirrored = self.pose[self._mirrored], self.twist[self._mirrored]
        self._choose()
        if self._is_alike and not self._bodies and self._roll_by_loop(command):
            return
        speeds = self._wheel_targets(command)
        pose, twist = self.pose.copy(), self.twist.copy()
        self._roll(speeds, pose, twist)
        for forces in filter(None, self._sliding):
            self._slide(forces, pose, twist)
        solved = list(self._bodies)
        if solved:
            pose[solved], twist[solved] = self.pose[solved], self.twist[solved]
            self._solve(speeds, mirrored[0], solved, pose, twist)
        for forces, counted in zip(self._pushed + self._sliding, 2 * self._counted):
            if forces is not None:
                counted[forces.members] += forces.travel
                forces.reset()
        self.pose, self.twist = pose, twist
        if len(self._mirrored):
            self.place(self._mirrored, *mirrored)

    def _roll_by_loop(self, command):
        """As :meth:`advance`, of robots that all roll, in one compiled call; return whether that can be."""
        step = same_bits(compiled_roll_step, WORTH)
        if step is None:
            return False
        n = self.team.n
        after = np.empty((n, 3)), np.empty((n, 3)), np.empty((2, n)), np.empty((2, n))
        inner = np.asfortranarray(self._inner[0]).T
        state = np.ascontiguousarray(self.pose), np.ascontiguousarray(self.twist), inner
        wheels, limits, gear, times = self._gear()
        if not step(wheels, gear, limits, times, *state, np.asfortranarray(command).T, after):
            return False
        self.pose, self.twist, self._inner[0] = after[0], after[1], after[2].T
        self._angles += after[3].T
        return True

    def _gear(self):
        """Return what ``rolling_steps`` takes of these robots and their steps, which stays."""
        if self._known is None:
            n, (group,) = self.team.n, self.team.groups
            top, most = self._limits[0].of_all(n).top, self._most[0]
            limits = [np.broadcast_to(each, (n, 2)).T for each in (-top, top, most.up, most.both)]
            limits.append(np.broadcast_to(self.team.limits.of_all(n).top, (n, 2)).T)
            gear = np.empty((2, n))
            gear[:] = [np.broadcast_to(each, n) for each in (group.numbers.track, self._radius)]
            times = self.step, self.step / self._substeps, self._substeps
            wheels = np.array(self._on_wheels)
            self._known = wheels, np.ascontiguousarray(np.concatenate(limits)), gear, times
        return self._known

    @property
    def can_fuse(self):
        """Return whether :meth:`fuse_steps` moves these robots: those of one kind of drive, on two wheels
        each, that nothing but these moves."""
        alike = [group.drive for group in self.team.groups] == [differential]
        carried = len(self._mirrored) or self._uneven or self._movers
        return type(self) is PlanarMotion and alike and all(self._wheels) and not carried

    def fuse_steps(self, plan, command, function, kept, *given):
        """Move as ``KinematicMotion.fuse_steps`` does, by ``rolling_steps.rolling_stretch``."""
        if not self._is_free():
            return 0, 0, NEAR
        (wheels, limits, gear, times), near = self._gear(), self._broad_phase
        moved = pose, twist, angles = [
            np.array(each, order="C") for each in (self.pose, self.twist, self._angles)
        ]
        inner, obeyed = (each.copy("F") for each in (self._inner[0], command))
        given = wheels, gear, times, (*near.room, QUICKER), kept, *given
        done, filled, *near.room, why = function(
            plan, pose, twist, inner.T, angles, obeyed.T, limits, *given
        )
        command[:] = obeyed
        self.pose, self.twist, self._angles, self._inner[0] = *moved, inner
        return done, filled, why

    def _is_free(self):
        """Return whether all are in the plane, and no two may be near each other after another step."""
        near, way = self._broad_phase, self._fastest_way()
        room, gone = near.room
        if self._bodies or room - gone > way:
            return not self._bodies
        for _ in range(2):
            if near.near(self.pose[:, :2], way, np.zeros(self.team.n, dtype=bool)) is not None:
                return False
            near.room = near.room[0], 0.0  # nobody has moved since
            if near.room[0] > way:
                return True
            near.list_anew()  # which may be all that leaves no room
        return False

    def _fastest_way(self):
        """Return how far [m] robots move in the coming step at most."""
        return self.step * (np.sqrt(squared(self.twist[:, :2]).max()) + QUICKER)

    def _rates(self, index, group):
        forces, inner = self._sliding[index], self._inner[index]
        if forces is not None:
            own = self._held(group, inner), group.joints_of(inner)
            forces.aim(*(each[forces.members] for each in own))
        return super()._rates(index, group)

    def _roll(self, speeds, pose, twist):
        """Move robots that roll in the plane, in place; tipping ones are left to the solver."""
        if not len(self._rolling):
            return
        rows = EVERY if len(self._rolling) == self.team.n else self._rolling
        rims = speeds[rows].T * self._radius[rows]
        own = pose[rows], twist[rows]
        move = same_bits(compiled_rolled, WORTH) or rolled
        pose[rows], twist[rows], turned, tips = move(
            self._on_wheels, *own, rims, self.step, self._substeps
        )
        turned /= self._radius[rows]
        if tips.any():
            turned[:, tips] = 0.0
            self._put_in(self._rolling[tips].tolist())
        self._angles[rows] += turned.T

    def _slide(self, forces, pose, twist):
        """Move robots pushed by wheel ``forces`` in the plane, in place."""
        rows, duration = forces.rows, self.step / self._substeps
        ahead = self._centre[rows]
        cos, sin = cos_sin(pose[rows, 2])
        centre, moving = pose[rows], twist[rows]
        centre[:, 0] += ahead * cos
        centre[:, 1] += ahead * sin
        moving[:, 1] += ahead * moving[:, 2]
        bodies = PlanarBodies(self._mass[rows], self._inertia[rows], centre, moving)
        for _ in range(self._substeps):
            moving = bodies.twist.copy()
            moving[:, 1] -= ahead * moving[:, 2]
            wrench = forces.wrench(moving, duration)
            wrench[:, 2] += (forces.ahead - ahead) * wrench[:, 1]
            bodies.advance(wrench, duration)
        cos, sin = cos_sin(bodies.pose[:, 2])
        pose[rows], twist[rows] = bodies.pose, bodies.twist
        pose[rows, 0] -= ahead * cos
        pose[rows, 1] -= ahead * sin
        twist[rows, 1] -= ahead * bodies.twist[:, 2]

    def _solve(self, speeds, mirrored, solved, pose, twist):
        """Let the solver move robots ``solved``, rows, and write ``pose`` and ``twist`` (n, 3) of these."""
        for row, place in zip(self._mirrored.tolist(), mirrored.tolist()):
            if row in self._bodies:
                self._put(row, place)
        self._drive(speeds)
        if self._is_solved(speeds):
            self._read()
            pose[solved], twist[solved] = self.pose[solved], self.twist[solved]
        else:
            twist[solved] = 0.0
        self._since[solved] += 1

    def _stand(self, speeds):
        rows = list(self._bodies)
        moving = np.any(speeds[rows]) or np.abs(self.twist[rows]).max() >= STILL
        still = not (moving or self._movers or set(rows) & set(self._mirrored.tolist()))
        self._stood = self._stood + 1 if still else 0
        return self._stood > STANDING

    def _take_in(self, place, velocity):
        rows = list(self._bodies)
        pose, twist = self.pose.copy(), self.twist.copy()
        ahead = self._ahead if np.ndim(self._ahead) == 0 else self._ahead[rows]
        pose[rows], twist[rows] = seen_at_centre(place, velocity, ahead)
        self.pose, self.twist = pose, twist
        self._angles[rows] = self._turned()
        tilts = np.array([self._models[self.team.kinds[row]].tilt for row in rows])
        off = np.abs(_tilt(place[:, 3:]) - tilts).max(axis=1)
        shaken = np.abs(velocity[:, 2:5]).max(axis=1)
        self._calm[rows] = (off < LEVEL) & (shaken < CALM)

    # Who is in the solver ------------------------------------------------------------------------

    def _choose(self):
        """Put robots that may touch something into the solver, and take free ones out."""
        before = np.zeros(self.team.n, dtype=bool)
        solved = list(self._bodies)
        if solved:
            before[solved] = True
        near = self._broad_phase.near(self.pose[:, :2], self._fastest_way(), before)
        if near is None and not solved:
            return
        near = np.zeros_like(before) if near is None else near
        leaves = before & ~near & self._calm & (self._since >= HELD)
        leaves[self._mirrored] = (before & ~near)[self._mirrored]
        if leaves.any():
            self._take_out(np.flatnonzero(leaves).tolist())
        enters = np.flatnonzero(near & ~before).tolist()
        if enters or leaves.any():
            self._put_in(enters)

    def _put_in(self, rows):
        """Move robots ``rows`` from the plane into the solver, as bodies in their present state."""
        client = {"physicsClientId": self._client}
        for row in rows:
            kind, (x, y, theta) = self.team.kinds[row], self.pose[row].tolist()
            vx, vy, omega = self.twist[row].tolist()
            self._bodies[row] = body = self._add_robot(row, kind, (x, y, theta))
            if row in self._mirrored:
                self._make_firm(row)
            self._put(row, (x, y, theta))
            model, half = self._models[kind], self._stances[kind].half
            vy += model.ahead * omega
            cos, sin = np.cos(theta), np.sin(theta)
            linear = [cos * vx - sin * vy, sin * vx + cos * vy, 0.0]
            pybullet.resetBaseVelocity(body, linear, [0.0, 0.0, omega], **client)
            rims = vx - half * omega, vx + half * omega
            for wheel, angle, rim in zip(self._wheels[row], self._angles[row].tolist(), rims):
                rate = rim / kind.numbers.radius
                pybullet.resetJointState(body, wheel, angle, rate, **client)
            self._driven[row], self._since[row], self._calm[row] = np.nan, 0, False
        self._stood = 0
        self._divide()

    def _take_out(self, rows):
        """Remove the bodies of robots ``rows`` from the solver."""
        for row in rows:
            body = self._bodies.pop(row)
            del self._names[body]
            pybullet.removeBody(body, physicsClientId=self._client)

    def contacts(self):
        return super().contacts() if self._bodies or len(self._mirrored) else []


def _tilt(turn):
    """Return roll and pitch, (m, 2) [rad], of quaternions (m, 4)."""
    x, y, z, w = turn.T
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    return np.stack([roll, pitch], axis=1)
