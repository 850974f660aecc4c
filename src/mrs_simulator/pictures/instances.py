"""The bodies of a scene as triangles and where they stand, for a drawing by a graphics card."""

import functools
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.spatial import rotated
from mrs_simulator.pictures.arms import load_tile, scene_arms
from mrs_simulator.pictures.robots import about_z, rotations
from mrs_simulator.pictures.solids import kind_model, obstacle_models
from mrs_simulator.scenario.surroundings.obstacles import is_flat

NOSE = -1.0  # as a share of the robot's own colour: the arrow, dark or light, whichever is seen
ABOVE = 0.002  # [m] of the arrow over the part that it lies on


class Instances(NamedTuple):
    """m things of one ``Model``."""

    model: Any
    place: Any  # (m, 3) [m]
    turn: Any  # (m, 3, 3) from the things' frames into the common frame
    shades: Any  # (m, 3) their own colours
    has_nose: bool = False  # whether an arrow on top shows their heading


def instances(scene, obstacle_colour):
    """Yield the ``Instances`` of a ``Scene``: robots, their arms and load, and obstacles that stand up.

    Robots whose poses are not known are left out.
    """
    place, turn, shades = scene.place, scene.turn, np.asarray(scene.shades)
    known = np.isfinite(place).all(axis=1) & np.isfinite(turn).all(axis=(1, 2))
    rows_of = {}
    for row in np.flatnonzero(known).tolist():
        rows_of.setdefault(scene.kinds[row], []).append(row)
    for kind, rows in rows_of.items():
        yield Instances(kind_model(kind), place[rows], turn[rows], shades[rows], True)
    for arms in scene_arms(scene):
        left = known[arms.rows]
        for link, model in enumerate(arms.models):
            frames = arms.links[left, link]
            yield Instances(model, frames[:, :3, 3], frames[:, :3, :3], shades[arms.rows[left]])
    if scene.carried is not None:
        yield _load(*scene.carried)
    for obstacle in scene.obstacles:
        for model, (x, y, yaw) in () if is_flat(obstacle) else _models(obstacle, obstacle_colour):
            place = np.array([(x, y, 0.0)])
            yield Instances(model, place, about_z([yaw]), np.array([obstacle_colour]))


@functools.lru_cache(maxsize=256)
def _models(obstacle, colour):
    return tuple(obstacle_models(obstacle, (*colour, 1.0)))


def _load(load, carried):
    model, middles = load_tile(tuple(load.size))
    turns = np.broadcast_to(carried.orientation, (len(middles), 4))
    place = carried.place + rotated(turns, middles)
    return Instances(model, place, rotations(turns), np.zeros((len(middles), 3)))


def triangles(model, with_nose):
    """Return the corners of the triangles of a ``Model``, (3 t, 10): place, normal, colour, own share.

    ``with_nose``: the arrow on top too.
    """
    rows, begin = [], 0
    for face, count in enumerate(model.counts.tolist()):
        corners = model.vertices[model.corners[begin : begin + count]]
        rest = (*model.normals[face], *model.colours[face], model.own[face])
        for second in range(1, count - 1):
            fan = corners[[0, second, second + 1]]
            rows += [(*corner, *rest) for corner in fan.tolist()]
        begin += count
    if with_nose:
        raised = model.nose + (0.0, 0.0, ABOVE)
        rows += [(*corner, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, NOSE) for corner in raised.tolist()]
    return np.array(rows, dtype=np.float32)
