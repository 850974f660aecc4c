"""Bodies in a pybullet world: ground, obstacles, robots."""

import numpy as np
import pybullet

from mrs_simulator.scenario.surroundings.obstacles import Cylinder
from mrs_simulator.vehicles.shape import outline_parts

# Groups of collision, and masks of those with which a body collides.  Versions of pybullet ask for both
# masks of a pair, or for one of them.
MOVING, FIXED, GROUND_ALONE, ROLLING = 1, 2, 64, 128  # the first two are pybullet's own
GROUND = FIXED | GROUND_ALONE, -1 ^ FIXED
# by whether they move
OTHERS = {True: (MOVING, -1 ^ ROLLING), False: (FIXED, -1 ^ FIXED ^ ROLLING)}
WIDE = 2e-3  # [m] beyond the outline, of boxes that pybullet makes 1 mm too large
ABOVE = 0.02  # [m] the ground, up to which a wheel stands there
OBSTACLE_COLOUR = [0.55, 0.55, 0.6, 1.0]  # [-] red, green, blue, opacity
_SPARE = []  # an emptied world, if any: to make one takes three times as long as to empty one


def open_solver():
    """Return the client of an empty pybullet world without a picture."""
    try:
        return _SPARE.pop()
    except IndexError:  # or another thread was faster
        return pybullet.connect(pybullet.DIRECT)


def close_solver(client):
    """Give back the ``client`` that :func:`open_solver` returned."""
    if _SPARE:
        pybullet.disconnect(physicsClientId=client)
    else:
        pybullet.resetSimulation(physicsClientId=client)
        _SPARE.append(client)


def add_ground(client):
    """Return the body of a level ground plane without a picture of its own."""
    shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
    ground = pybullet.createMultiBody(0.0, shape, physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(ground, -1, *GROUND, physicsClientId=client)
    return ground


def wide_spheres(client, body, centre, reach):
    """Return the links of a robot's ``body`` on the ground that are spheres which stand there, and reach
    farther than ``reach`` [m] from its ``centre`` (x, y).

    Models have spheres for wheels and casters, which are narrower: another robot touches the body before
    them.  None are returned of a model whose base has no shape of its own.
    """
    if not pybullet.getCollisionShapeData(body, -1, client):
        return []
    return [
        link
        for link in range(pybullet.getNumJoints(body, client))
        if _is_wide(client, body, link, centre, reach)
    ]


def _is_wide(client, body, link, centre, reach):
    forms = [shape[2] for shape in pybullet.getCollisionShapeData(body, link, client)]
    if not forms or any(form != pybullet.GEOM_SPHERE for form in forms):
        return False
    low, high = np.array(pybullet.getAABB(body, link, client))
    far = np.hypot(*(0.5 * (low + high)[:2] - centre)) + 0.5 * (high - low)[0]
    return low[2] < ABOVE and far > reach + WIDE


def keep_from_touching(client, body, rolling):
    """Let the links ``rolling`` of a robot's ``body`` touch nothing but the ground."""
    if not rolling:
        return
    for link in range(-1, pybullet.getNumJoints(body, client)):
        group = (ROLLING, GROUND_ALONE) if link in rolling else OTHERS[True]
        pybullet.setCollisionFilterGroupMask(body, link, *group, physicsClientId=client)


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
    body = pybullet.createMultiBody(
        0.0,
        pybullet.createCollisionShape(physicsClientId=client, **solid),
        pybullet.createVisualShape(physicsClientId=client, rgbaColor=OBSTACLE_COLOUR, **seen),
        [obstacle.x, obstacle.y, 0.5 * height],
        pybullet.getQuaternionFromEuler([0.0, 0.0, yaw]),
        physicsClientId=client,
    )
    pybullet.setCollisionFilterGroupMask(body, -1, *OTHERS[False], physicsClientId=client)
    return body


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
