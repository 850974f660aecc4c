"""Obstacles under the mouse: their handles, and how dragging one changes them.  No painting.

Points are (2,) [m] in the common frame.
"""

import math

import numpy as np

from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder, clearance, is_flat

TURN = "turn"  # the handle that turns a box about its centre
HEIGHT = 0.5  # [m] of one that is drawn
APART, AHEAD = 5.0, 3.0  # [-] reaches: between opposite handles; from a box to where it is turned
# Of a box: which way each handle lies from the centre, along and across, in halves of its sides.
SIDES = {
    "ahead": (1, 0),
    "ahead left": (1, 1),
    "left": (0, 1),
    "behind left": (-1, 1),
    "behind": (-1, 0),
    "behind right": (-1, -1),
    "right": (0, -1),
    "ahead right": (1, -1),
}
RIM = {"east": (1, 0), "north": (0, 1), "west": (-1, 0), "south": (0, -1)}  # of a cylinder


def handles(obstacle, reach):
    """Return ``{name: point}`` of the handles by which ``obstacle`` is resized and turned.

    ``reach`` [m]: distance within which a handle is grabbed.  Sides too near to each other have none, so
    that the obstacle can still be moved.
    """
    centre = np.array([obstacle.x, obstacle.y])
    if isinstance(obstacle, Cylinder):
        ways = RIM if 2.0 * obstacle.radius > APART * reach else {}
        return {name: centre + obstacle.radius * np.array(way) for name, way in ways.items()}
    axes, size = _axes(obstacle), np.array([obstacle.length, obstacle.width])
    wide = size > APART * reach
    result = {
        name: centre + (0.5 * size * way) @ axes
        for name, way in SIDES.items()
        if wide[np.flatnonzero(way)].all()
    }
    result[TURN] = centre + (0.5 * size[0] + AHEAD * reach) * axes[0]
    return result


def _axes(box):
    """Return the directions of a box's length and width, the rows of (2, 2)."""
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    return np.array([[cos, sin], [-sin, cos]])


def dragged(obstacle, name, point, step, angle):
    """Return ``obstacle`` with its handle ``name`` at ``point``, None where nothing would be left.

    The opposite side stays.  Lengths are whole multiples of ``step`` [m], headings of ``angle`` [rad].
    """
    apart = np.asarray(point, dtype=float) - [obstacle.x, obstacle.y]
    if isinstance(obstacle, Cylinder):
        radius = rounded(float(np.hypot(*apart)), step)
        return obstacle._replace(radius=radius) if radius > 0.0 else None
    if name == TURN:
        return obstacle._replace(yaw=rounded(math.atan2(apart[1], apart[0]), angle))
    axes, way = _axes(obstacle), np.array(SIDES[name])
    size = np.array([obstacle.length, obstacle.width])
    wanted = np.round((way * (axes @ apart) + 0.5 * size) / step) * step
    after = np.where(way == 0, size, np.round(wanted, 9))
    if np.any(after <= 0.0):
        return None
    shift = (0.5 * way * (after - size)) @ axes
    x, y = np.round(shift + [obstacle.x, obstacle.y], 9).tolist()
    length, width = after.tolist()
    return obstacle._replace(x=x, y=y, length=length, width=width)


def spanned(shape, name, begin, end, step):
    """Return the ``shape`` called ``name`` drawn from ``begin`` to ``end``, None where it has no size.

    A ``"box"`` lies between two corners, a ``"cylinder"`` about ``begin``.
    """
    begin, end = (np.round(np.asarray(point) / step) * step for point in (begin, end))
    if shape == "cylinder":
        radius = rounded(float(np.hypot(*(end - begin))), step)
        x, y = np.round(begin, 9).tolist()
        return Cylinder(name, x, y, radius, HEIGHT) if radius > 0.0 else None
    length, width = np.round(np.abs(end - begin), 9).tolist()
    x, y = np.round(0.5 * (begin + end), 9).tolist()
    return Box(name, x, y, 0.0, length, width, HEIGHT) if min(length, width) > 0.0 else None


def moved(obstacle, place, step):
    """Return ``obstacle`` with its centre at ``place`` (2,) to the nearest ``step`` [m]."""
    x, y = (rounded(value, step) for value in np.asarray(place, dtype=float).tolist())
    return obstacle._replace(x=x, y=y)


def turned(obstacle, angle):
    """Return ``obstacle`` turned by ``angle`` [rad]; a cylinder stays as it is."""
    if isinstance(obstacle, Cylinder):
        return obstacle
    return obstacle._replace(yaw=round(math.remainder(obstacle.yaw + angle, 2.0 * math.pi), 9))


def scaled(obstacle, change):
    """Return ``obstacle`` with sides, or a diameter, longer by ``change`` [m]; None if none is left."""
    if isinstance(obstacle, Cylinder):
        radius = round(obstacle.radius + 0.5 * change, 9)
        return obstacle._replace(radius=radius) if radius > 0.0 else None
    length, width = (round(side + change, 9) for side in (obstacle.length, obstacle.width))
    return obstacle._replace(length=length, width=width) if min(length, width) > 0.0 else None


def obstacle_at(obstacles, point, reach):
    """Return the place among ``obstacles`` of that within ``reach`` [m] of ``point``, -1 for none.

    Of several it is the one that is in the least depth under the point: small ones lie on large ones.
    """
    away = np.array([clearance(each, [point])[0][0] for each in obstacles])
    near = np.flatnonzero(away <= reach) if len(away) else ()
    return int(near[np.argmin(np.abs(away[near]))]) if len(near) else -1


def rounded(value, step):
    """Return ``value`` to the nearest multiple of ``step``, without the noise of its last digits."""
    return round(round(value / step) * step, 9)


def free_name(shape, taken):
    """Return a name for a new ``shape`` that is not among those ``taken``."""
    number = 1
    while "{}{}".format(shape, number) in taken:
        number += 1
    return "{}{}".format(shape, number)


def described(obstacle):
    """Return in words what ``obstacle`` is."""
    if isinstance(obstacle, Cylinder):
        return "{}: radius {:g} m, height {:g} m".format(
            obstacle.name, obstacle.radius, obstacle.height
        )
    size = "{}: {:g} m long, {:g} m wide".format(obstacle.name, obstacle.length, obstacle.width)
    if is_flat(obstacle):
        return size + ", land"
    return "{}, {:g} m high, turned by {:.3g}\u00b0".format(
        size, obstacle.height, math.degrees(obstacle.yaw)
    )
