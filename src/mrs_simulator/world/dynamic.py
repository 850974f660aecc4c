"""Motion with forces: driven wheels, caster, contact and friction in pybullet."""

from typing import List, NamedTuple, Tuple

import numpy as np
import pybullet

from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.limits import AxisLimits
from mrs_simulator.vehicles.team import joined, shared
from mrs_simulator.world.bodies import Bodies
from mrs_simulator.world.scene import add_ground, add_obstacle, add_robot, mass_centre

GRAVITY = 9.81  # [m/s^2]
SUBSTEP = 0.005  # [s] the longest step of the solver
ITERATIONS = 10  # [-] of the solver in one substep
GROUND_FRICTION = 1.0  # [-] pybullet multiplies the two friction coefficients
SETTLING = 40  # [-] substeps in which a robot put on the ground comes to rest
NO_RAMP = 1e3  # [m/s^2, rad/s^2] stands for no ramp: motors have torque, not infinite acceleration


class Model(NamedTuple):
    """What pybullet says of a kind's model, and how it stands on its wheels."""

    links: int
    wheels: List[int]  # joints
    ahead: float  # [m] of base_link at which the centre of mass lies, of which pybullet speaks
    height: float = 0.0  # [m] of the centre of mass
    tilt: Tuple[float, float] = (0.0, 0.0)  # [rad] roll and pitch


class DynamicMotion:
    """Robots as rigid bodies on their wheels, in a pybullet world of their own."""

    def __init__(
        self,
        kinds,
        poses,
        obstacles=(),
        limits="firmware",
        step=0.02,
        substep=SUBSTEP,
        iterations=ITERATIONS,
        mirrored=(),
    ):
        """``kinds``: the ``Team``, or its kinds; ``poses`` (n, 3); ``step`` [s] of one advance.

        ``substep`` [s] and ``iterations`` of the solver trade speed for accuracy.  ``mirrored``:
        rows of robots that ``place`` alone moves.
        """
        self.step = step
        self.team = Team.of(kinds, limits)
        self._limits = [
            AxisLimits(group.limits.top, np.minimum(group.limits.acceleration, NO_RAMP))
            for group in self.team.groups
        ]
        self._models = {}
        self._client = pybullet.connect(pybullet.DIRECT)
        self._substeps = max(1, int(np.ceil(step / substep - 1e-9)))
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=step / self._substeps,
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
        for obstacle in obstacles:
            self._names[add_obstacle(self._client, obstacle)] = obstacle.name
        self._bodies = [
            self._add_robot(row, kind, pose)
            for row, (kind, pose) in enumerate(zip(self.team.kinds, poses))
        ]
        self._rest()
        models = [self._models[kind] for kind in self.team.kinds]
        self._ahead = shared([model.ahead for model in models])
        self._wheels = [model.wheels for model in models]
        self._torques = [[kind.numbers.torque] * 2 for kind in self.team.kinds]
        self._mirrored = np.array(mirrored, dtype=int)
        self._plane = Bodies(self.team, obstacles, mirrored)
        for row in mirrored:
            # Without mass it stays where it is put, and pushes without being pushed.
            pybullet.changeDynamics(self._bodies[row], -1, mass=0.0, physicsClientId=self._client)
        self.reset(poses)

    def _add_robot(self, row, kind, pose):
        body = add_robot(self._client, kind, pose)
        model = self._models.get(kind)
        if model is None:
            model = self._models[kind] = self._learned(kind, body)
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
        self._names[body] = "robot{}".format(row + 1)
        return body

    def _learned(self, kind, body):
        """Return the ``Model`` of a ``kind`` whose first robot is ``body``."""
        links = pybullet.getNumJoints(body, physicsClientId=self._client)
        joints = [
            pybullet.getJointInfo(body, joint, physicsClientId=self._client)[1].decode()
            for joint in range(links)
        ]
        missing = [name for name in kind.numbers.joints if name not in joints]
        if missing or not kind.numbers.joints:
            raise ValueError(
                "kind {}: {} has no joint {}, wanted the driven wheels' (known: {})".format(
                    kind.name, kind.model, missing[0] if missing else "given", ", ".join(joints)
                )
            )
        wheels = [joints.index(name) for name in kind.numbers.joints]
        return Model(links, wheels, float(mass_centre(self._client, body)[0]))

    def _rest(self):
        """Let the first robot of each kind sink onto its wheels; all are put down as it then stands."""
        first = {}
        for kind, body in zip(self.team.kinds, self._bodies):
            first.setdefault(kind, body)
        for kind, body in first.items():
            self._hold(body, self._models[kind].wheels, [0.0] * 2, [kind.numbers.torque] * 2)
        for _ in range(SETTLING):
            pybullet.stepSimulation(physicsClientId=self._client)
        for kind, body in first.items():
            position, turn = pybullet.getBasePositionAndOrientation(
                body, physicsClientId=self._client
            )
            roll, pitch, _ = pybullet.getEulerFromQuaternion(turn)
            self._models[kind] = self._models[kind]._replace(height=position[2], tilt=(roll, pitch))

    def reset(self, poses):
        """Put the robots at rest at ``poses`` (n, 3)."""
        poses = np.array(poses, dtype=float)
        for row, pose in enumerate(poses.tolist()):
            self._put(row, pose)
            for wheel in self._wheels[row]:
                pybullet.resetJointState(
                    self._bodies[row], wheel, 0.0, 0.0, physicsClientId=self._client
                )
        n = len(poses)
        self._plane.moved_elsewhere()
        self.pose, self.twist = poses, np.zeros((n, 3))
        self._angles = np.zeros((n, 2))
        self._velocities = [
            np.zeros((len(group.kinds), len(group.drive.AXES))) for group in self.team.groups
        ]
        self._joints = [np.zeros(len(group.kinds)) for group in self.team.groups]
        self._driven = np.full((n, 2), np.nan)
        self._drive(np.zeros((n, 2)))

    @property
    def wheel_travel(self):
        """Return how far the wheels of each group have rolled, a list of (m, encoders) [m]."""
        return [(self._angles[group.rows].T * group.numbers.radius).T for group in self.team.groups]

    def joints(self):
        """Return the drives' inner joints, such as steering angles, (n,) [rad]; 0 where none is."""
        return joined(self.team, self._joints)

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

    def advance(self, command):
        """Move for one step under ``command`` (n, a), a column for each axis of the team.

        Velocities are clipped and ramped once a step as the firmware does, and held by the wheels'
        motors while the solver takes its substeps.
        """
        if len(self._mirrored):
            command = command.copy()
            command[self._mirrored] = 0.0
        mirrored = self.pose[self._mirrored], self.twist[self._mirrored]
        for row, pose in zip(self._mirrored, mirrored[0].tolist()):
            self._put(row, pose)
        speeds = np.empty((self.team.n, 2))
        for index, group in enumerate(self.team.groups):
            self._velocities[index], self._joints[index], _ = group.drive.ramped(
                self._velocities[index], self._joints[index], group.of(command),
                self._limits[index], group.numbers, self.step,
            )  # fmt: skip
            speeds[group.rows] = group.drive.wheel_rates(
                self._velocities[index], self._joints[index], group.numbers
            )
        self._drive(speeds)
        for _ in range(self._substeps):
            pybullet.stepSimulation(physicsClientId=self._client)
        self._read()
        self.place(self._mirrored, *mirrored)

    def _drive(self, speeds):
        """Let the wheels turn at ``speeds`` (n, 2) [rad/s]; told are those whose speed is new."""
        changed = np.flatnonzero(np.any(speeds != self._driven, axis=1)).tolist()
        for row, speed in zip(changed, speeds[changed].tolist()):
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
        client = self._client
        places, velocities, angles = [], [], []
        for body, wheels in zip(self._bodies, self._wheels):
            position, turn = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
            places.append(position + turn)
            linear, angular = pybullet.getBaseVelocity(body, physicsClientId=client)
            velocities.append(linear + angular)
            left, right = pybullet.getJointStates(body, wheels, physicsClientId=client)
            angles.append((left[0], right[0]))
        self._take_in(np.array(places), np.array(velocities), np.array(angles))

    def _take_in(self, place, velocity, angles):
        x, y, z, w = place[:, 3:].T
        theta = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        cos, sin, ahead = np.cos(theta), np.sin(theta), self._ahead
        pose, twist = np.empty((len(place), 3)), np.empty((len(place), 3))
        pose[:, 0], pose[:, 1] = place[:, 0] - ahead * cos, place[:, 1] - ahead * sin
        pose[:, 2] = wrap_angle(theta)
        omega = velocity[:, 5]
        twist[:, 0] = cos * velocity[:, 0] + sin * velocity[:, 1]
        twist[:, 1] = cos * velocity[:, 1] - sin * velocity[:, 0] - ahead * omega
        twist[:, 2] = omega
        self.pose, self.twist = pose, twist
        self._angles = angles

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
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1


def _robots_first(name):
    number = name[5:]
    return (0, int(number)) if name.startswith("robot") and number.isdigit() else (1, 0)
