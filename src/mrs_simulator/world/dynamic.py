"""Motion with forces: driven wheels, caster, contact and friction in pybullet."""

import numpy as np
import pybullet

from mrs_simulator.core.kinematics import (
    clip_commands,
    ramp,
    wheel_speeds,
    wrap_angle,
)
from mrs_simulator.vehicles import limits_of_team, robot_kind
from mrs_simulator.world.bodies import Bodies
from mrs_simulator.world.scene import add_ground, add_obstacle, add_robot, mass_centre

GRAVITY = 9.81  # [m/s^2]
SUBSTEP = 0.005  # [s] the longest step of the solver
ITERATIONS = 10  # [-] of the solver in one substep
GROUND_FRICTION = 1.0  # [-] pybullet multiplies the two friction coefficients
SETTLING = 40  # [-] substeps in which a robot put on the ground comes to rest
NO_RAMP = 1e3  # [m/s^2, rad/s^2] stands for no ramp: motors have torque, not infinite acceleration


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
        """``poses`` (n, 3); ``step`` [s] of one advance.

        ``substep`` [s] and ``iterations`` of the solver trade speed for accuracy.  ``mirrored``:
        rows of robots that ``place`` alone moves.
        """
        self.step = step
        self.limits = limits_of_team(kinds, limits)
        self._kind = robot_kind(kinds[0])
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
        self._bodies = [self._add_robot(row, pose) for row, pose in enumerate(poses)]
        self._rest()
        self._mirrored = np.array(mirrored, dtype=int)
        self._plane = Bodies(kinds, obstacles, mirrored)
        for row in mirrored:
            # Without mass it stays where it is put, and pushes without being pushed.
            pybullet.changeDynamics(self._bodies[row], -1, mass=0.0, physicsClientId=self._client)
        self.reset(poses)

    def _add_robot(self, row, pose):
        body = add_robot(self._client, self._kind, pose)
        if row == 0:
            self._learn_model(body)
        client = {"physicsClientId": self._client}
        for link in range(-1, self._links):
            wheel = link in self._wheels
            # Damping on its own: given together, pybullet forgets a friction of zero.
            pybullet.changeDynamics(
                body, link, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, **client
            )
            pybullet.changeDynamics(
                body,
                link,
                lateralFriction=self._kind.WHEEL_FRICTION if wheel else 0.0,
                spinningFriction=self._kind.WHEEL_SPIN_FRICTION if wheel else 0.0,
                **client,
            )
        pybullet.changeDynamics(
            body, -1, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING, **client
        )
        self._names[body] = "robot{}".format(row + 1)
        return body

    def _learn_model(self, body):
        self._links = pybullet.getNumJoints(body, physicsClientId=self._client)
        joints = [
            pybullet.getJointInfo(body, joint, physicsClientId=self._client)[1].decode()
            for joint in range(self._links)
        ]
        self._wheels = [joints.index(name) for name in self._kind.WHEEL_JOINTS]
        # pybullet speaks of the centre of mass; base_link lies this far from it.
        self._mass_centre = mass_centre(self._client, body)

    def _rest(self):
        """Let the first robot sink onto its wheels; all are put down at that height and tilt."""
        body = self._bodies[0]
        self._drive([body], np.zeros((1, 2)))
        for _ in range(SETTLING):
            pybullet.stepSimulation(physicsClientId=self._client)
        position, turn = pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
        roll, pitch, _ = pybullet.getEulerFromQuaternion(turn)
        self._height, self._tilt = position[2], (roll, pitch)

    def reset(self, poses):
        """Put the robots at rest at ``poses`` (n, 3)."""
        poses = np.array(poses, dtype=float)
        for body, pose in zip(self._bodies, poses.tolist()):
            self._put(body, pose)
            for wheel in self._wheels:
                pybullet.resetJointState(body, wheel, 0.0, 0.0, physicsClientId=self._client)
        n = len(poses)
        self._plane.moved_elsewhere()
        self.pose, self.twist = poses, np.zeros((n, 3))
        self.wheel_travel = np.zeros((n, 2))
        self._velocity = np.zeros((n, 2))
        self._driven = np.full((n, 2), np.nan)
        self._drive(self._bodies, np.zeros((n, 2)))
        self._driven[:] = 0.0

    def _put(self, body, pose):
        x, y, theta = pose
        turn = pybullet.getQuaternionFromEuler([*self._tilt, theta])
        ahead = self._mass_centre[0]
        place = [x + ahead * np.cos(theta), y + ahead * np.sin(theta), self._height]
        pybullet.resetBasePositionAndOrientation(body, place, turn, physicsClientId=self._client)
        pybullet.resetBaseVelocity(body, [0.0] * 3, [0.0] * 3, physicsClientId=self._client)

    def place(self, rows, poses, twists):
        """Put mirrored robots ``rows`` (m,) at ``poses`` (m, 3) with body ``twists`` (m, 3)."""
        self.pose, self.twist = self.pose.copy(), self.twist.copy()
        self.pose[rows], self.twist[rows] = poses, twists

    def advance(self, command):
        """Move for one step under ``command`` (n, 2) [m/s, rad/s].

        Velocities are clipped and ramped once a step as the firmware does, and held by the wheels'
        motors while the solver takes its substeps.
        """
        target = clip_commands(command, self.limits.velocities())
        target[self._mirrored] = 0.0
        mirrored = self.pose[self._mirrored], self.twist[self._mirrored]
        for row, pose in zip(self._mirrored, mirrored[0].tolist()):
            self._put(self._bodies[row], pose)
        reach = np.minimum(self.limits.accelerations(), NO_RAMP)
        self._velocity, _ = ramp(self._velocity, target, reach, self.step)
        speeds = wheel_speeds(self._velocity, self._kind.WHEEL_TRACK) / self._kind.WHEEL_RADIUS
        changed = np.flatnonzero(np.any(speeds != self._driven, axis=1))
        self._drive([self._bodies[row] for row in changed], speeds[changed])
        self._driven[changed] = speeds[changed]
        for _ in range(self._substeps):
            pybullet.stepSimulation(physicsClientId=self._client)
        self._read()
        self.place(self._mirrored, *mirrored)

    def _drive(self, bodies, speeds):
        torque = [self._kind.WHEEL_TORQUE] * 2
        for body, speed in zip(bodies, speeds.tolist()):
            pybullet.setJointMotorControlArray(
                body,
                self._wheels,
                pybullet.VELOCITY_CONTROL,
                targetVelocities=speed,
                velocityGains=[1.0, 1.0],
                forces=torque,
                physicsClientId=self._client,
            )

    def _read(self):
        client, wheels = self._client, self._wheels
        places, velocities, angles = [], [], []
        for body in self._bodies:
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
        cos, sin, ahead = np.cos(theta), np.sin(theta), self._mass_centre[0]
        pose, twist = np.empty((len(place), 3)), np.empty((len(place), 3))
        pose[:, 0], pose[:, 1] = place[:, 0] - ahead * cos, place[:, 1] - ahead * sin
        pose[:, 2] = wrap_angle(theta)
        omega = velocity[:, 5]
        twist[:, 0] = cos * velocity[:, 0] + sin * velocity[:, 1]
        twist[:, 1] = cos * velocity[:, 1] - sin * velocity[:, 0] - ahead * omega
        twist[:, 2] = omega
        self.pose, self.twist = pose, twist
        self.wheel_travel = angles * self._kind.WHEEL_RADIUS

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
