"""Motion with forces: driven wheels, caster, contact and friction in pybullet.

Two wheels on an axle roll in the solver.  Wheels with rollers and wheels that slide as a rule are without
friction there, and what they push with comes from ``wheel_forces``; bodies, contacts and weight are the
solver's for all robots alike.
"""

from typing import List, NamedTuple, Tuple

import numpy as np
import pybullet

from mrs_simulator.core.kinematics import Reach, ramped, wrap_angle
from mrs_simulator.core.snapshots import NotCopied
from mrs_simulator.core.uneven_wheels import UnevenWheels
from mrs_simulator.scenario.surroundings.obstacles import is_flat
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.limits import AxisLimits
from mrs_simulator.vehicles.team import shared
from mrs_simulator.world.contact.bodies import Bodies
from mrs_simulator.world.contact.movers import ObstacleMover
from mrs_simulator.world.contact.scene import (
    add_ground,
    add_obstacle,
    add_robot,
    close_solver,
    keep_from_touching,
    mass_and_inertia,
    mass_centre,
    open_solver,
    wide_spheres,
)
from mrs_simulator.world.motion.wheel_forces import WheelForces

GRAVITY = 9.81  # [m/s^2]
SUBSTEP = 0.005  # [s] the longest step of the solver
ITERATIONS = 10  # [-] of the solver in one substep
GROUND_FRICTION = 1.0  # [-] pybullet multiplies the two friction coefficients
SETTLING = 40  # [-] substeps in which a robot put on the ground comes to rest
STILL = 1e-3  # [m/s, rad/s] below which a robot that is to stand counts as standing
STANDING = 25  # [-] steps in which all do before the solver rests
NO_RAMP = 1e3  # [m/s^2, rad/s^2] stands for no ramp: motors have torque, not infinite acceleration
# What pybullet's saveState leaves out changes the last bits of robots whose wheels slip.
NO_COPY = "the memory of pybullet's solver cannot be copied"


class Model(NamedTuple):
    """What pybullet says of a kind's model, and how it stands on its wheels."""

    links: int
    rolling: List[int]  # links that roll on the ground as spheres, wider than the outline
    wheels: List[int]  # joints of wheels that roll in the solver
    mass: float  # [kg]
    inertia: float  # [kg m^2] about the vertical through the centre of mass
    ahead: float  # [m] of base_link at which the centre of mass lies, of which pybullet speaks
    height: float = 0.0  # [m] of the centre of mass
    tilt: Tuple[float, float] = (0.0, 0.0)  # [rad] roll and pitch


class DynamicMotion:
    """Robots as rigid bodies on their wheels, in a pybullet world of their own."""

    SUBSTEP, ITERATIONS = SUBSTEP, ITERATIONS  # of the solver, unless others are given
    z = spatial = None  # all robots are on the ground

    def __init__(
        self,
        kinds,
        poses,
        obstacles=(),
        limits="firmware",
        step=0.02,
        substep=None,
        iterations=None,
        mirrored=(),
        errors=None,
    ):
        """``kinds``: the ``Team``, or its kinds; ``poses`` (n, 3); ``step`` [s] of one advance.

        ``substep`` [s] and ``iterations`` of the solver trade speed for accuracy.  ``mirrored``:
        rows of robots that ``place`` alone moves; ``errors``: of wheels, as ``UnevenWheels.of`` takes
        them: the solver's wheels are nominal, and turn as the body has to move.
        """
        substep = self.SUBSTEP if substep is None else substep
        iterations = self.ITERATIONS if iterations is None else iterations
        self.step = step
        self.team = Team.of(kinds, limits)
        self._uneven = UnevenWheels.of(errors)
        self._limits = [
            AxisLimits(group.limits.top, np.minimum(group.limits.acceleration, NO_RAMP))
            for group in self.team.groups
        ]
        self._most = [  # by which what ramps changes in a step
            Reach.of(step * group.drive.rates(limits, group.numbers))
            for group, limits in zip(self.team.groups, self._limits)
        ]
        self._models = {}
        self._substeps = max(1, int(np.ceil(step / substep - 1e-9)))
        self._open(iterations, obstacles)
        self._bodies = {}  # by row
        self._populate(poses)
        models = [self._models[kind] for kind in self.team.kinds]
        self._ahead = shared([model.ahead for model in models])
        self._wheels = [model.wheels for model in models]
        self._torques = [[kind.numbers.torque] * 2 for kind in self.team.kinds]
        self._mirrored = np.array(mirrored, dtype=int)
        self._pushed = [self._wheel_forces(group, self._bodies) for group in self.team.groups]
        self._plane = Bodies(self.team, obstacles, mirrored)
        for row in set(mirrored) & set(self._bodies):
            self._make_firm(row)
        self._begin(np.array(poses, dtype=float))

    def _open(self, iterations, obstacles):
        """Open the solver, with the ground and the ``obstacles`` in it."""
        self._client = open_solver()
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=self.step / self._substeps,
            numSolverIterations=iterations,
            numSubSteps=0,
            deterministicOverlappingPairs=1,
            physicsClientId=self._client,
        )
        pybullet.setGravity(0.0, 0.0, -GRAVITY, physicsClientId=self._client)
        ground = add_ground(self._client)
        pybullet.changeDynamics(
            ground, -1, lateralFriction=GROUND_FRICTION, physicsClientId=self._client
        )
        self._names = {ground: "ground"}
        # On flat ones robots drive.
        fixed = [None if is_flat(o) else add_obstacle(self._client, o) for o in obstacles]
        self._names.update({body: o.name for body, o in zip(fixed, obstacles) if body is not None})
        self._movers = ObstacleMover(self._client, obstacles, fixed)

    def _populate(self, poses):
        """Put all robots onto the ground; ``_models`` knows their kinds from then on."""
        for row, (kind, pose) in enumerate(zip(self.team.kinds, poses)):
            self._bodies[row] = self._add_robot(row, kind, pose)
        self._rest()

    def _add_robot(self, row, kind, pose):
        if not kind.model:
            text = "kind {}: no model given, wanted one for motion with forces"
            raise ValueError(text.format(kind.name))
        body = self._loaded(kind, pose)
        model = self._models.get(kind)
        if model is None:
            model = self._models[kind] = self._learned(kind, body, pose)
        client = {"physicsClientId": self._client}
        for link in range(-1, model.links):
            wheel = link in model.wheels
            # Damping on its own: given together, pybullet forgets a friction of zero.
            pybullet.changeDynamics(
                body, link, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, **client
            )
            pybullet.changeDynamics(
                body,
                link,
                lateralFriction=kind.numbers.friction if wheel else 0.0,
                spinningFriction=kind.numbers.spin_friction if wheel else 0.0,
                **client,
            )
        pybullet.changeDynamics(
            body, -1, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING, **client
        )
        keep_from_touching(self._client, body, model.rolling)
        self._names[body] = "robot{}".format(row + 1)
        return body

    def _make_firm(self, row):
        """Let a mirrored robot stay where it is put, and push without being pushed: it has no mass."""
        pybullet.changeDynamics(self._bodies[row], -1, mass=0.0, physicsClientId=self._client)

    def _loaded(self, kind, pose):
        """Return the new body of a robot of a ``kind`` at ``pose``."""
        return add_robot(self._client, kind, pose)

    def _learned(self, kind, body, pose):
        """Return the ``Model`` of a ``kind`` whose first robot is ``body``, at ``pose``."""
        links = pybullet.getNumJoints(body, physicsClientId=self._client)
        joints = [
            pybullet.getJointInfo(body, joint, physicsClientId=self._client)[1].decode()
            for joint in range(links)
        ]
        pushed = kind.module.is_pushed(kind.numbers)
        missing = [name for name in kind.numbers.joints if name not in joints]
        if missing or not (kind.numbers.joints or pushed):
            raise ValueError(
                "kind {}: {} has no joint {}, wanted the driven wheels' (known: {})".format(
                    kind.name, kind.model, missing[0] if missing else "given", ", ".join(joints)
                )
            )
        wheels = [] if pushed else [joints.index(name) for name in kind.numbers.joints]
        ahead = float(mass_centre(self._client, body)[0])
        rolling = wide_spheres(self._client, body, pose[:2], kind.body.reach)
        return Model(links, rolling, wheels, *mass_and_inertia(self._client, body), ahead)

    def _wheel_forces(self, group, among):
        """Return the ``WheelForces`` of those robots of a ``group`` that have them, or None.

        ``among``: rows of the team.
        """
        rows = np.arange(self.team.n)[group.rows]
        members = [
            member
            for member, (row, kind) in enumerate(zip(rows.tolist(), group.kinds))
            if group.drive.is_pushed(kind.numbers) and row in among and row not in self._mirrored
        ]
        if not members:
            return None
        models = [self._models[group.kinds[member]] for member in members]
        mass, inertia = (np.array([getattr(m, key) for m in models]) for key in ("mass", "inertia"))
        return WheelForces(group, np.array(members), rows[members], mass, inertia)

    def _rest(self):
        """Let the first robot of each kind sink onto its wheels; all are put down as it then stands."""
        first = {}
        for row, kind in enumerate(self.team.kinds):
            first.setdefault(kind, self._bodies[row])
        for kind, body in first.items():
            wheels = self._models[kind].wheels
            if wheels:
                self._hold(body, wheels, [0.0] * 2, [kind.numbers.torque] * 2)
        for _ in range(SETTLING):
            pybullet.stepSimulation(physicsClientId=self._client)
        for kind, body in first.items():
            position, turn = pybullet.getBasePositionAndOrientation(
                body, physicsClientId=self._client
            )
            roll, pitch, _ = pybullet.getEulerFromQuaternion(turn)
            self._models[kind] = self._models[kind]._replace(height=position[2], tilt=(roll, pitch))

    def _begin(self, poses):
        """Put the robots at rest at ``poses`` (n, 3)."""
        for row, body in self._bodies.items():
            self._put(row, poses[row].tolist())
            for wheel in self._wheels[row]:
                pybullet.resetJointState(body, wheel, 0.0, 0.0, physicsClientId=self._client)
        n = len(poses)
        self.pose, self.twist = poses, np.zeros((n, 3))
        self._angles = np.zeros((n, 2))
        self._inner = [
            np.zeros((len(group.kinds), len(group.drive.AXES))) for group in self.team.groups
        ]
        self._driven = np.full((n, 2), np.nan)
        self._stood = 0
        self._drive(np.zeros((n, 2)))

    def __getstate__(self):
        raise NotCopied(NO_COPY)

    @property
    def wheel_travel(self):
        """Return how far the wheels of each group have rolled, a list of (m, encoders) [m]."""
        return self._counted_by(list(map(self._travel, self.team.groups, self._pushed)))

    def _counted_by(self, travel):
        """Return what encoders count where nominal wheels rolled ``travel``, a list of (m, encoders)."""
        if self._uneven is None:
            return travel
        return [self._uneven.counted(*each) for each in zip(self.team.groups, travel)]

    def _travel(self, group, forces):
        if self._angles is None:
            self._angles = self._turned()
        if forces is None and group.drive.ENCODERS == 2:
            return (self._angles[group.rows].T * group.numbers.radius).T
        travel = np.zeros((len(group.kinds), group.drive.ENCODERS))
        if group.drive.ENCODERS == 2:
            travel[:] = (self._angles[group.rows].T * group.numbers.radius).T
        if forces is not None:
            travel[forces.members] = forces.travel
        return travel

    def joints(self):
        """Return the drives' inner joints, such as steering angles, (n,) [rad]; 0 where none is."""
        return self.team.joints_of(self._inner)

    def _put(self, row, pose):
        x, y, theta = pose
        model, body = self._models[self.team.kinds[row]], self._bodies[row]
        turn = pybullet.getQuaternionFromEuler([*model.tilt, theta])
        ahead = model.ahead
        place = [x + ahead * np.cos(theta), y + ahead * np.sin(theta), model.height]
        pybullet.resetBasePositionAndOrientation(body, place, turn, physicsClientId=self._client)
        pybullet.resetBaseVelocity(body, [0.0] * 3, [0.0] * 3, physicsClientId=self._client)

    def place(self, rows, poses, twists):
        """Put mirrored robots ``rows`` (m,) at ``poses`` (m, 3) with body ``twists`` (m, 3)."""
        self.pose, self.twist = self.pose.copy(), self.twist.copy()
        self.pose[rows], self.twist[rows] = poses, twists

    def move_obstacles(self, obstacles):
        """Let the ``obstacles``, of the same number and sizes, be where they are after the next step."""
        self._movers.aim(self._plane.obstacles, obstacles, self.step)
        self._plane.move_obstacles(obstacles)

    def advance(self, command):
        """Move for one step under ``command`` (n, a), a column for each axis of the team.

        Velocities are clipped and ramped once a step as the firmware does, and held by the wheels'
        motors while the solver takes its substeps.
        """
        mirrored = self.pose[self._mirrored], self.twist[self._mirrored]
        for row, pose in zip(self._mirrored, mirrored[0].tolist()):
            self._put(row, pose)
        speeds = self._wheel_targets(command)
        self._drive(speeds)
        if self._is_solved(speeds):
            self._read()
            self.place(self._mirrored, *mirrored)
        else:
            self.twist = np.zeros_like(self.twist)

    def _wheel_targets(self, command):
        """Let velocities follow ``command`` (n, a) for a step; return the speeds of the wheels that roll,
        (n, 2) [rad/s]."""
        if len(self._mirrored):
            command = command.copy()
            command[self._mirrored] = 0.0
        speeds = np.empty((self.team.n, 2))
        for index, group in enumerate(self.team.groups):
            inner, limits, numbers = self._inner[index], self._limits[index], group.numbers
            target = group.drive.target(group.of(command), inner, limits, numbers)
            self._inner[index], _ = ramped(inner, target, self._most[index])
            speeds[group.rows] = self._rates(index, group)
        return speeds

    def _is_solved(self, speeds):
        """Let the solver move its bodies for a step, and return True, unless all of them stand at wheel
        ``speeds`` (n, 2) [rad/s]."""
        pushed = [forces for forces in self._pushed if forces is not None]
        if not pushed and self._stand(speeds):
            return False
        for _ in range(self._substeps):
            for forces in pushed:
                self._push(forces)
            self._before_substep()
            if self._movers:
                self._movers.advance(self.step / self._substeps)
            pybullet.stepSimulation(physicsClientId=self._client)
        return True

    def _stand(self, speeds):
        """Return whether all robots stand, with their wheels commanded to ``speeds`` (n, 2) [rad/s].

        The solver ends before it converges, and robots at rest would creep by up to 0.2 mm/s; with 200
        iterations it is nothing.
        """
        still = not (len(self._mirrored) or np.any(speeds)) and np.abs(self.twist).max() < STILL
        if still and self._movers:
            reach = self._plane.footprints.reach
            still = not self._movers.are_near(self.pose[:, :2], reach)
        self._stood = self._stood + 1 if still else 0
        return self._stood > STANDING

    def _before_substep(self):
        """Let what else pulls at bodies do so; here nothing does."""

    def add_name(self, body, name):
        """Report contacts of a further ``body`` under ``name``."""
        self._names[body] = name

    def _rates(self, index, group):
        """Return the turn rates, (m, 2) [rad/s], of wheels that roll in the solver; aim the others."""
        inner, forces = self._inner[index], self._pushed[index]
        velocity, joints = self._held(group, inner), group.joints_of(inner)
        if forces is not None:
            forces.aim(velocity[forces.members], joints[forces.members])
        if all(group.drive.is_pushed(kind.numbers) for kind in group.kinds):
            return 0.0
        return group.drive.wheel_rates(velocity, joints, group.numbers)

    def _held(self, group, inner):
        """Return the velocities (m, axes) at which the ``group``'s nominal wheels would be held."""
        velocity = group.velocities(inner)
        return velocity if self._uneven is None else self._uneven.moved(group, velocity)

    def _push(self, forces):
        """Let wheel forces act on the bodies for the solver's next substep."""
        client, bodies = self._client, [self._bodies[row] for row in forces.rows]
        places, velocities = [], []
        for body in bodies:
            position, turn = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
            places.append(position + turn)
            linear, angular = pybullet.getBaseVelocity(body, physicsClientId=client)
            velocities.append(linear + angular)
        place, ahead = np.array(places), self._ahead
        pose, twist = seen_at_centre(
            place, np.array(velocities), ahead if np.ndim(ahead) == 0 else ahead[forces.rows]
        )
        force, point, torque = forces.push(pose, twist, self.step / self._substeps)
        at = np.column_stack([point, place[:, 2]]).tolist()
        frame = pybullet.WORLD_FRAME
        for body, f, p, m in zip(bodies, force.tolist(), at, torque.tolist()):
            pybullet.applyExternalForce(body, -1, f, p, frame, physicsClientId=client)
            pybullet.applyExternalTorque(body, -1, [0.0, 0.0, m], frame, physicsClientId=client)

    def _drive(self, speeds):
        """Let the wheels turn at ``speeds`` (n, 2) [rad/s]; only motors with a new speed are set."""
        changed = np.flatnonzero(np.any(speeds != self._driven, axis=1)).tolist()
        for row, speed in zip(changed, speeds[changed].tolist()):
            if not self._wheels[row] or row not in self._bodies:
                continue
            self._hold(self._bodies[row], self._wheels[row], speed, self._torques[row])
        self._driven[changed] = speeds[changed]

    def _hold(self, body, wheels, speed, torque):
        pybullet.setJointMotorControlArray(
            body,
            wheels,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=speed,
            velocityGains=[1.0] * len(wheels),
            forces=torque,
            physicsClientId=self._client,
        )

    def _read(self):
        client, places, velocities = self._client, [], []
        for body in self._bodies.values():
            position, turn = pybullet.getBasePositionAndOrientation(body, client)
            places.append(position + turn)
            linear, angular = pybullet.getBaseVelocity(body, client)
            velocities.append(linear + angular)
        self._take_in(np.array(places), np.array(velocities))

    def _take_in(self, place, velocity):
        self.pose, self.twist = seen_at_centre(place, velocity, self._ahead)
        self._angles = None  # as the solver has them, which few ask for

    def _turned(self):
        """Return how far the wheels of the bodies have turned, (m, 2) [rad], 0 where none roll."""
        angles = np.zeros((len(self._bodies), 2))
        for row, body, own in zip(self._bodies, self._bodies.values(), angles):
            wheels = self._wheels[row]
            if wheels:
                own[:] = [state[0] for state in pybullet.getJointStates(body, wheels, self._client)]
        return angles

    def contacts(self):
        """Return the contacts after the last step: ``(first, second, x, y)`` each."""
        found = {}
        for point in pybullet.getContactPoints(physicsClientId=self._client):
            names = self._names[point[1]], self._names[point[2]]
            # On the ground, or not quite touching.
            if "ground" in names or point[8] > 0.0:
                continue
            first, second = sorted(names, key=_robots_first)
            found.setdefault((first, second), (first, second, point[5][0], point[5][1]))
        # The solver sees no contact of two bodies without mass.
        if len(self._mirrored):
            for contact in self._plane.firm_contacts(self.pose):
                found.setdefault(contact[:2], contact[:4])
        return list(found.values())

    def closest(self):
        """Return the least distance [m] between two robots' centres now; inf for one robot."""
        return self._plane.closest(self.pose)

    def close(self):
        """Disconnect from pybullet; closing twice does no harm."""
        if self._client >= 0:
            close_solver(self._client)
            self._client = -1


def seen_at_centre(place, velocity, ahead):
    """Return pose (m, 3) and body twist (m, 3) of the robots' centres.

    ``place`` (m, 7): position and quaternion of the base's centre of mass, ``ahead`` [m] of the centre;
    ``velocity`` (m, 6) of it, linear and angular.
    """
    x, y, z, w = place[:, 3:].T
    theta = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    cos, sin = np.cos(theta), np.sin(theta)
    pose, twist = np.empty((len(place), 3)), np.empty((len(place), 3))
    pose[:, 0], pose[:, 1] = place[:, 0] - ahead * cos, place[:, 1] - ahead * sin
    pose[:, 2] = wrap_angle(theta)
    omega = velocity[:, 5]
    twist[:, 0] = cos * velocity[:, 0] + sin * velocity[:, 1]
    twist[:, 1] = cos * velocity[:, 1] - sin * velocity[:, 0] - ahead * omega
    twist[:, 2] = omega
    return pose, twist


def _robots_first(name):
    number = name[5:]
    return (0, int(number)) if name.startswith("robot") and number.isdigit() else (1, 0)
