"""How kinds of robots stand on their wheels, learned from their models in pybullet."""

from typing import NamedTuple

import numpy as np
import pybullet

from mrs_simulator.core.fields import counted
from mrs_simulator.world.motion.dynamic import SETTLING, DynamicMotion
from mrs_simulator.world.motion.planar_body import GRAVITY

APART = 20.0  # [m] between robots that are looked at
CARRIES = 1e-3  # [-] of the weight, above which a support carries


class Stance(NamedTuple):
    """A robot at rest, lengths ahead of its centre."""

    mass: float  # [kg]
    inertia: float  # [kg m^2] about the vertical through the centre of mass
    ahead: float  # [m] of the centre of mass, links included
    height: float  # [m] of it above the ground
    reach: float  # [m] from the centre, beyond which nothing of the robot is
    half: float = 0.0  # [m] from the middle to a wheel that rolls
    load: float = 0.0  # [N] on both of these
    front: float = 0.0  # [m] of the foremost and of the rearmost support
    rear: float = 0.0

    @property
    def shift(self):
        """Return by how much [-] the load on both wheels falls for a force ahead.

        With casters on both sides of the axle it stays as it is: that of each is unknown.
        """
        if self.front > 0.0 > self.rear:
            return 0.0
        return -self.height / (self.front + self.rear)


class Standing(DynamicMotion):
    """One robot of each kind at rest, to be looked at."""

    def __init__(self, kinds):
        """``kinds``: each once.  Raises ``ValueError`` for one without a model."""
        poses = np.zeros((len(kinds), 3))
        poses[:, 0] = APART * np.arange(len(kinds))
        super().__init__(kinds, poses)

    def learned(self):
        """Return the ``Model`` and the ``Stance`` of each kind, two mappings."""
        for _ in range(SETTLING):
            pybullet.stepSimulation(physicsClientId=self._client)
        self._read()
        stances = {kind: self._stance(row, kind) for row, kind in enumerate(self.team.kinds)}
        return dict(self._models), stances

    def _stance(self, row, kind):
        body, model, of = self._bodies[row], self._models[kind], {"physicsClientId": self._client}
        x = self.pose[row, 0]
        centre, height = self._mass_centre(body, model)
        boxes = np.array([pybullet.getAABB(body, k, **of) for k in range(-1, model.links)])
        far = np.abs(boxes[:, :, :2] - [x, 0.0]).max(axis=1)
        reach = max(float(np.hypot(*far.T).max()), kind.body.reach)
        stance = Stance(model.mass, model.inertia, centre - x, height, reach)
        return self._on_wheels(stance, kind, body, x) if model.wheels else stance

    def _mass_centre(self, body, model):
        """Return x and height [m] of the whole body's centre of mass."""
        of = {"physicsClientId": self._client}
        places = [pybullet.getBasePositionAndOrientation(body, **of)[0]]
        places += [pybullet.getLinkState(body, link, **of)[0] for link in range(model.links)]
        masses = [pybullet.getDynamicsInfo(body, k, **of)[0] for k in range(-1, model.links)]
        x, _, z = np.array(masses) @ np.array(places) / sum(masses)
        return float(x), float(z)

    def _on_wheels(self, stance, kind, body, x):
        """Return the ``stance`` of a robot at ``x`` [m] with what its wheels and casters carry."""
        wheels = self._models[kind].wheels
        points = pybullet.getContactPoints(bodyA=body, physicsClientId=self._client)
        on_ground = [point for point in points if self._names[point[2]] == "ground"]
        under = [point for point in on_ground if point[3] in wheels]
        weight = GRAVITY * stance.mass
        others = [
            point[5][0] - x
            for point in on_ground
            if point[3] not in wheels and point[9] > CARRIES * weight
        ]
        if len({point[3] for point in under}) < 2 or not others:
            text = "kind {}: stands on {}, wanted two driven wheels and a caster (engine: planar)"
            links = sorted({point[3] for point in on_ground})
            raise ValueError(text.format(kind.name, counted(len(links), "support")))
        front, rear = max(others + [0.0]), min(others + [0.0])
        load = sum(point[9] for point in under)
        if not front > 0.0 > rear:
            load = weight * (1.0 - stance.ahead / (front + rear))
        half = np.mean([abs(point[5][1]) for point in under])
        return stance._replace(half=float(half), load=float(load), front=front, rear=rear)
