"""Bodies in a pybullet world: ground, obstacles, robots."""

import numpy as np
import pybullet

from mrs_simulator.scenario.surroundings.obstacles import Cylinder
from mrs_simulator.vehicles.shape import outline_parts

OBSTACLE_COLOUR = [0.55, 0.55, 0.6, 1.0]  # [-] red, green, blue, opacity


def add_ground(client):
    """Return the body of a level ground plane without a picture of its own."""
    shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
    return pybullet.createMultiBody(0.0, shape, physicsClientId=client)


def add_obstacle(client, obstacle):
    """Return the fixed body of a ``Box`` or ``Cylinder``."""
    height = obstacle.height
    if isinstance(obstacle, Cylinder):
        form, yaw = {"shapeType": pybullet.GEOM_CYLINDER, "radius": obstacle.radius}, 0.0
        solid, seen = dict(form, height=height), dict(form, length=height)
    else:
        half = [0.5 * obstacle.length, 0.5 * obstacle.width, 0.5 * height]
        solid = seen = {"shapeType": pybullet.GEOM_BOX, "halfExtents": half}
        yaw = obstacle.yaw
    return pybullet.createMultiBody(
        0.0,
        pybullet.createCollisionShape(physicsClientId=client, **solid),
        pybullet.createVisualShape(physicsClientId=client, rgbaColor=OBSTACLE_COLOUR, **seen),
        [obstacle.x, obstacle.y, 0.5 * height],
        pybullet.getQuaternionFromEuler([0.0, 0.0, yaw]),
        physicsClientId=client,
    )


def add_robot(client, kind, pose):
    """Return the body of a robot of a ``kind``, its centre at ``pose`` (x, y, theta)."""
    return pybullet.loadURDF(
        kind.model,
        [pose[0], pose[1], kind.module.ride_height(kind.numbers)],
        pybullet.getQuaternionFromEuler([0.0, 0.0, pose[2]]),
        flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
        physicsClientId=client,
    )


def add_looks(client, kind, pose):
    """Return a body that looks like a robot of a ``kind``, its centre at ``pose``, and touches nothing.

    It is drawn by its shape, else by its model, else by its outline.
    """
    if kind.model and not kind.shape:
        return add_robot(client, kind, pose)
    parts = kind.shape or outline_parts(kind)
    count = len(parts)
    return pybullet.createMultiBody(
        0.0,
        -1,
        -1,
        [pose[0], pose[1], kind.module.ride_height(kind.numbers)],
        pybullet.getQuaternionFromEuler([0.0, 0.0, pose[2]]),
        linkMasses=[0.0] * count,
        linkCollisionShapeIndices=[-1] * count,
        linkVisualShapeIndices=[_visual(client, part) for part in parts],
        linkPositions=[part.place[:3] for part in parts],
        linkOrientations=[pybullet.getQuaternionFromEuler(part.place[3:]) for part in parts],
        linkInertialFramePositions=[[0.0] * 3] * count,
        linkInertialFrameOrientations=[[0.0, 0.0, 0.0, 1.0]] * count,
        linkParentIndices=[0] * count,
        linkJointTypes=[pybullet.JOINT_FIXED] * count,
        linkJointAxis=[[0.0, 0.0, 1.0]] * count,
        physicsClientId=client,
    )


def _visual(client, part):
    if part.form == "box":
        size = {"shapeType": pybullet.GEOM_BOX, "halfExtents": [0.5 * each for each in part.size]}
    elif part.form == "cylinder":
        radius, length = part.size
        size = {"shapeType": pybullet.GEOM_CYLINDER, "radius": radius, "length": length}
    else:
        size = {"shapeType": pybullet.GEOM_SPHERE, "radius": part.size[0]}
    return pybullet.createVisualShape(rgbaColor=part.colour, physicsClientId=client, **size)


def mass_and_inertia(client, body):
    """Return the mass [kg] of ``body`` and its inertia [kg m^2] about the vertical through its centre of
    mass, links included as they stand."""
    links = range(pybullet.getNumJoints(body, physicsClientId=client))
    of = {"physicsClientId": client}
    places = [pybullet.getBasePositionAndOrientation(body, **of)[0]]
    places += [pybullet.getLinkState(body, link, **of)[0] for link in links]
    parts = [pybullet.getDynamicsInfo(body, link, **of) for link in range(-1, len(links))]
    mass, own = np.array([(part[0], part[2][2]) for part in parts]).T
    places = np.array(places)[:, :2]
    apart = places - mass @ places / mass.sum()
    return float(mass.sum()), float(own.sum() + mass @ np.square(apart).sum(axis=1))


def mass_centre(client, body):
    """Return where pybullet's origin of ``body``, its centre of mass, lies in base_link, (3,) [m]."""
    return np.array(pybullet.getDynamicsInfo(body, -1, physicsClientId=client)[3])
