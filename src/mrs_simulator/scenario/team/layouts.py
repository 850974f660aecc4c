"""Initial poses of a team: lines, circles, grids and random layouts, shape (n, 3) [m, m, rad]."""

import numpy as np

from mrs_simulator.core.fields import POSITIVE, Parameter, checked_values, unknown_name
from mrs_simulator.core.kinematics import wrap_angle

TRIES_PER_ROBOT = 2000  # [-] draws of a random position before it is said that none is free

LARGEST = 1e6  # [m] of any length of a layout

_SPACING = Parameter("spacing", 2.0, "m", **POSITIVE, high=LARGEST, meaning="between neighbours")
_RADIUS = Parameter("radius", 5.0, "m", **POSITIVE, high=LARGEST, meaning="of the circle")
_APART = Parameter(
    "min_distance", 1.5, "m", low=0.0, high=LARGEST, meaning="between any two centres"
)
_SIZE = Parameter("size", 20.0, "m", **POSITIVE, high=LARGEST, meaning="side of the square")
LAYOUTS = {
    "line": (_SPACING,),
    "grid": (_SPACING,),
    "circle": (_RADIUS,),
    "random": (_APART, _SIZE),
}


def make_layout(name, n, seed=0, **parameters):
    """Return n poses in the layout called ``name``; ``parameters`` as in ``LAYOUTS``.

    Raises ``ValueError`` for an unknown layout or parameter, or a random one that has no room.
    """
    if name not in LAYOUTS:
        raise ValueError(unknown_name("layout", name, LAYOUTS))
    values = checked_values(LAYOUTS[name], parameters, owner="layout {}".format(name))
    if name == "random":
        return extend_poses(np.empty((0, 3)), n, seed=seed, **values)
    return {"line": _line, "grid": _grid, "circle": _circle}[name](n, **values)


def extend_poses(poses, n, min_distance=1.5, size=20.0, seed=0):
    """Return ``poses`` (m, 3) and n - m more, drawn in a square about the origin, all apart.

    ``size`` [m] is the square's side, ``min_distance`` [m] the least distance between centres;
    headings are drawn from [-pi, pi).  The same seed gives the same poses.
    """
    draw = np.random.default_rng(seed)
    result = np.empty((n, 3), order="F")  # by columns: rows of two numbers are slow to sum
    result[: len(poses)] = poses
    for count in range(len(poses), n):
        for _ in range(TRIES_PER_ROBOT):
            position = draw.uniform(-0.5 * size, 0.5 * size, 2)
            x, y = (result[:count, axis] - position[axis] for axis in (0, 1))
            squared = x**2 + y**2
            if not count or squared.min() >= min_distance**2:
                break
        else:
            text = (
                "random layout: no room for robot {} of {} at {:g} m from the others in a square "
                "of {:g} m; wanted a larger size or fewer robots"
            )
            raise ValueError(text.format(count + 1, n, min_distance, size))
        result[count] = position[0], position[1], draw.uniform(-np.pi, np.pi)
    return np.ascontiguousarray(result)


def _line(n, spacing):
    poses = np.zeros((n, 3))
    poses[:, 0] = spacing * (np.arange(n - 1, -1, -1) - 0.5 * (n - 1))
    return poses


def _grid(n, spacing):
    side = int(np.ceil(np.sqrt(n)))
    cells = np.arange(n)
    poses = np.zeros((n, 3))
    poses[:, 0] = spacing * (cells % side - 0.5 * (side - 1))
    poses[:, 1] = spacing * (0.5 * (side - 1) - cells // side)
    return poses


def _circle(n, radius):
    angle = 2.0 * np.pi * np.arange(n) / n
    heading = wrap_angle(angle + 0.5 * np.pi)  # along the circle
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), heading], axis=1)
