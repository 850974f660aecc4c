"""Robots with arms, and the load that they carry, as rigid bodies in pybullet.

Base and arm are one body; motors hold the joints' rates as far as their efforts allow.  Grips are springs
with damping between tools and grasps, of the stiffness that the load is given with: what they pull is known
to the bit, and is the same thing as without forces of motion.
"""

import os
import tempfile

import numpy as np
import pybullet

from mrs_simulator.core import grasps
from mrs_simulator.state.columns import LoadState
from mrs_simulator.vehicles.arms.assembling import PREFIX, assembled
from mrs_simulator.world.arms.armed import AT_END, ArmedMotion
from mrs_simulator.world.arms.carrying import CarriedLoad
from mrs_simulator.world.motion.dynamic import DynamicMotion

ITERATIONS = 50  # [-] of the solver in one substep
SUBSTEP = 0.004  # [s] the longest step of the solver
STRONGEST = 1e4  # [N m] of a joint whose description gives no effort


class ArmedBodies(DynamicMotion):
    """``DynamicMotion`` of the bases, whose bodies have the arms on them."""

    SUBSTEP, ITERATIONS = SUBSTEP, ITERATIONS

    def __init__(self, team, *arguments, **named):
        """``team``: the ``ArmedTeam``; the others as ``DynamicMotion`` takes them."""
        self._armed = team
        self._arm_joints = {}  # kind -> (indices of the arm's joints, index of the tool's link)
        self.grip = None  # what acts on tools and load before each of the solver's substeps
        super().__init__(team.bases, *arguments, **named)
        for row, kind in enumerate(self.team.kinds):
            if kind.arm is not None:
                self.bend(self._bodies[row], kind, kind.arm.home)

    @property
    def client(self):
        """Return pybullet's number of this world."""
        return self._client

    def arm_of(self, row):
        """Return the body of robot ``row``, its arm's joints and its tool's link, by their indices."""
        return (self._bodies[row], *self._arm_joints[self.team.kinds[row]])

    def _loaded(self, kind, pose):
        if kind.arm is None:
            return super()._loaded(kind, pose)
        handle, path = tempfile.mkstemp(suffix=".urdf")
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                file.write(assembled(kind))
            body = super()._loaded(kind._replace(model=path), pose)
        finally:
            os.remove(path)
        if kind not in self._arm_joints:
            self._arm_joints[kind] = self._found_in(body, kind.arm.model)
        self.bend(body, kind, kind.arm.home)
        self.drive_arm(body, kind, np.zeros(len(kind.arm.model.joints)))
        return body

    def _found_in(self, body, model):
        """Return the indices of the joints of an arm of this ``model``, and that of its tool's link."""
        count = pybullet.getNumJoints(body, physicsClientId=self._client)
        infos = [pybullet.getJointInfo(body, i, physicsClientId=self._client) for i in range(count)]
        joints = {info[1].decode(): info[0] for info in infos}
        links = {info[12].decode(): info[0] for info in infos}
        return [joints[PREFIX + name] for name in model.joints], links[PREFIX + model.tool]

    def bend(self, body, kind, q):
        """Put the arm of a ``body`` of this ``kind`` at rest at ``q`` (k,) [rad]."""
        for joint, angle in zip(self._arm_joints[kind][0], q):
            pybullet.resetJointState(body, joint, angle, 0.0, physicsClientId=self._client)

    def drive_arm(self, body, kind, rates):
        """Let motors hold the joints of an arm at ``rates`` (k,) [rad/s] from now on."""
        joints = self._arm_joints[kind][0]
        pybullet.setJointMotorControlArray(
            body,
            joints,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=list(rates),
            velocityGains=[1.0] * len(joints),
            forces=np.minimum(kind.arm.chain.effort, STRONGEST).tolist(),
            physicsClientId=self._client,
        )

    def _before_substep(self):
        if self.grip is not None:
            self.grip()


class ArmedDynamicMotion(ArmedMotion):
    """``ArmedMotion`` with forces."""

    def __init__(self, team, poses, obstacles, limits, step, mirrored=(), errors=None):
        """As ``DynamicMotion``; ``team``: the ``ArmedTeam``."""
        given = team, poses, obstacles, limits, step
        bodies = ArmedBodies(*given, mirrored=mirrored, errors=errors)
        super().__init__(team, bodies, mirrored)

    @property
    def bodies(self):
        """Return the ``ArmedBodies``."""
        return self._bases

    def advance(self, command):
        base, rates = self.team.split(command)
        team, step = self.team, self._bases.step
        rates = (team.moved(self.q, rates, step) - self.q) / step
        rates[self._mirrored] = 0.0
        for group in team.arms:
            for row in group.rows:
                body, _, _ = self._bases.arm_of(row)
                self._bases.drive_arm(body, team.kinds[row], rates[row, : len(group.chain.joints)])
        self._bases.advance(base)
        self._read()

    def _read(self):
        for group in self.team.arms:
            for row in group.rows:
                body, joints, _ = self._bases.arm_of(row)
                states = pybullet.getJointStates(body, joints, physicsClientId=self._bases.client)
                self.q[row, : len(joints)] = [state[0] for state in states]
        team = self.team
        self.ended = (self.q > team.upper - AT_END) | (self.q < team.lower + AT_END)
        self.ended &= team.rates > 0.0

    def carry(self, load, points):
        """Return the ``load`` as it hangs between tools at ``points`` (n, 3) from now on; ``LoadError``."""
        return HangingLoad(load, points, self)


class HangingLoad(CarriedLoad):
    """A load that is a body of its own, on springs between tools and grasps."""

    def __init__(self, load, points, motion):
        """As ``CarriedLoad``; ``motion``: the ``ArmedDynamicMotion``."""
        super().__init__(load, points)
        bodies = motion.bodies
        self._client, self._bodies = {"physicsClientId": bodies.client}, bodies
        # Of each grip's share of the mass as much as makes it swing no more than once.
        self._damping = 2.0 * np.sqrt(load.stiffness * load.mass / len(load.grasps))
        place, turn = grasps.hanging_pose(self.grasps, points, load.weight, load.stiffness)
        at = grasps.grasp_points(self.grasps, place, turn)
        self.state = LoadState(place, turn, load.stiffness * (points - at))
        half = [0.5 * side for side in load.size]
        shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, **self._client)
        self._body = pybullet.createMultiBody(
            load.mass, shape, -1, place.tolist(), turn.tolist(), **self._client
        )
        pybullet.changeDynamics(
            self._body,
            -1,
            linearDamping=0.0,
            angularDamping=0.0,
            localInertiaDiagonal=load.inertia.tolist(),
            activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            **self._client,
        )
        self._pass_through()
        self._forces = []
        bodies.add_name(self._body, "load")
        bodies.grip = self._pull

    def _pass_through(self):
        """Let the arms' links pass through the load: what they hold it by is a spring."""
        for row in range(len(self.grasps)):
            body, links, _ = self._bodies.arm_of(row)
            for link in links:
                pybullet.setCollisionFilterPair(body, self._body, link, -1, 0, **self._client)

    def _pull(self):
        """Let grips pull at tools and load in the solver's next substep."""
        place, turn = pybullet.getBasePositionAndOrientation(self._body, **self._client)
        velocity, spin = map(np.array, pybullet.getBaseVelocity(self._body, **self._client))
        at = grasps.grasp_points(self.grasps, np.array(place), np.array(turn))
        moving = velocity + np.cross(spin, at - place)
        force = np.zeros_like(at)
        for row in np.flatnonzero(self.held):
            body, _, tool = self._bodies.arm_of(row)
            state = pybullet.getLinkState(
                body, tool, computeLinkVelocity=1, computeForwardKinematics=1, **self._client
            )
            # The velocity is that of the link's centre of mass, a hand's breadth from the tool at most.
            misfit, sliding = state[4] - at[row], state[6] - moving[row]
            force[row] = self.load.stiffness * misfit + self._damping * sliding
            pull = {"flags": pybullet.WORLD_FRAME, **self._client}
            pybullet.applyExternalForce(body, tool, (-force[row]).tolist(), state[4], **pull)
            pybullet.applyExternalForce(
                self._body, -1, force[row].tolist(), at[row].tolist(), **pull
            )
        self._forces.append(force)

    def update(self, points):
        """Evaluate the grips' forces of the last step; return the rows of robots that let go."""
        place, turn = pybullet.getBasePositionAndOrientation(self._body, **self._client)
        force = np.mean(self._forces, axis=0) if self._forces else np.zeros_like(self.grasps)
        self._forces = []
        self.state = LoadState(np.array(place), np.array(turn), force)
        size, gone = np.linalg.norm(force, axis=1) * self.held, []
        row = int(np.argmax(size))
        if size[row] > self.load.grip:
            self.held[row] = False
            gone.append(row)
            if not grasps.are_noncollinear(self.grasps[self.held]):
                self.held[:] = False
        return gone
