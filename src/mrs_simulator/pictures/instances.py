"""The bodies of a scene as triangles and where they stand, for a drawing by a graphics card."""

import functools
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.spatial import about_z, rotated, rotations
from mrs_simulator.pictures.arms import load_tile, scene_arms
from mrs_simulator.pictures.moving_parts import SWEPT, parted
from mrs_simulator.pictures.scene import GHOST_SHOWN
from mrs_simulator.pictures.solids import kind_model, model_of
from mrs_simulator.scenario.surroundings.obstacles import Cylinder, is_flat
from mrs_simulator.vehicles.shape import FORMS, Part

NOSE = -1.0  # as a share of the robot's own colour: the arrow, dark or light, whichever is seen
# [-] cosine of the bend at a corner up to which a body is round; length of a sum of normals
ROUND, LEAST_SUM = 0.85, 1e-9
ABOVE = 0.002  # [m] of the arrow over the part that it lies on


class Instances(NamedTuple):
    """m things of one ``Model``."""

    model: Any
    place: Any  # (m, 3) [m]
    turn: Any  # (m, 3, 3) from the things' frames into the common frame, and their scale
    shades: Any  # (m, 3) their own colours
    has_nose: bool = False  # whether an arrow on top shows their heading
    opacity: float = 1.0
    casts: bool = True  # a shadow


def instances(scene, obstacle_colour):
    """Return the ``Instances`` of a ``Scene``, a list, one for all things that look the same.

    Robots, their wheels and rotors, arms and load, ghosts, and obstacles that stand up.  Robots whose poses
    are not known are left out.
    """
    place, turn, shades = scene.place, scene.turn, np.asarray(scene.shades)
    known = np.isfinite(place).all(axis=1) & np.isfinite(turn).all(axis=(1, 2))
    found = []
    for kind, rows in _rows_of(scene.kinds, known):
        found += _robots(scene, kind, rows, place[rows], turn[rows], shades[rows])
    for arms in scene_arms(scene):
        left = known[arms.rows]
        for link, model in enumerate(arms.models):
            links = arms.links[left, link]
            found.append(
                Instances(model, links[:, :3, 3], links[:, :3, :3], shades[arms.rows[left]])
            )
    if scene.carried is not None:
        found.append(_load(*scene.carried))
    for ghosts in scene.ghosts:
        sure = np.isfinite(ghosts.place).all(axis=1) & np.isfinite(ghosts.turn).all(axis=(1, 2))
        for kind, rows in _rows_of(ghosts.kinds, sure):
            where = ghosts.place[rows], ghosts.turn[rows], ghosts.shades[rows]
            found.append(Instances(kind_model(kind), *where, True, GHOST_SHOWN, casts=False))
    standing = [each for each in scene.obstacles if not is_flat(each)]
    return _merged([*found, *_obstacles(standing, obstacle_colour)])


def land(scene):
    """Return the ``Instances`` of a scene's land in the water, flat bodies, a list."""
    return list(_obstacles([each for each in scene.obstacles if is_flat(each)], (0.0,) * 3))


def _rows_of(kinds, known):
    """Yield each kind with the rows of its robots whose poses are ``known`` (n,)."""
    rows_of = {}  # by identity, since to hash a kind takes its time
    for row in np.flatnonzero(known).tolist():
        rows_of.setdefault(id(kinds[row]), []).append(row)
    for rows in rows_of.values():
        yield kinds[rows[0]], rows


def _robots(scene, kind, rows, place, turn, shades):
    """Yield the bodies, wheels and rotors of the robots in ``rows``, all of one ``kind``."""
    body, moving = parted(kind)
    yield Instances(body, place, turn, shades, True)
    motion = scene.motion.of(rows)
    for part in moving:
        where = motion.frames(part, place, turn)
        yield Instances(part.models[0], *where, shades)
        for disc in part.models[1:]:
            yield Instances(disc, *where, shades, opacity=SWEPT)


def _merged(things):
    """Return ``things`` with those together that are of the same model and look."""
    groups = {}
    for each in things:
        key = id(each.model), each.has_nose, each.opacity, each.casts
        groups.setdefault(key, []).append(each)
    return [
        group[0]
        if len(group) == 1
        else group[0]._replace(
            place=np.concatenate([each.place for each in group]),
            turn=np.concatenate([each.turn for each in group]),
            shades=np.concatenate([each.shades for each in group]),
        )
        for group in groups.values()
    ]


def _obstacles(obstacles, colour):
    """Yield all boxes and all cylinders as one ``Instances`` each: a body of 1 m, scaled."""
    for form, chosen in (
        ("cylinder", [each for each in obstacles if isinstance(each, Cylinder)]),
        ("box", [each for each in obstacles if not isinstance(each, Cylinder)]),
    ):
        if not chosen:
            continue
        place = np.array([(each.x, each.y, 0.5 * each.height) for each in chosen])
        if form == "box":
            turn = about_z([each.yaw for each in chosen])
            size = np.array([(each.length, each.width, each.height) for each in chosen])
        else:
            turn = about_z(np.zeros(len(chosen)))
            size = np.array([(each.radius, each.radius, each.height) for each in chosen])
        shades = np.tile(colour, (len(chosen), 1))
        yield Instances(_unit(form), place, turn * size[:, np.newaxis], shades)


@functools.lru_cache(maxsize=None)
def _unit(form):
    """Return the ``Model`` of a box with sides, or a cylinder with radius and height, of 1 m."""
    return model_of([Part(form, (1.0, 1.0, 1.0)[: FORMS[form]])])


def _load(load, carried):
    model, middles = load_tile(tuple(load.size))
    turns = np.broadcast_to(carried.orientation, (len(middles), 4))
    place = carried.place + rotated(turns, middles)
    return Instances(model, place, rotations(turns), np.zeros((len(middles), 3)))


def triangles(model, with_nose):
    """Return the corners of the triangles of a ``Model``, (3 t, 10): place, normal, colour, own share.

    ``with_nose``: the arrow on top too.
    """
    rows, begin, normals = [], 0, _corner_normals(model)
    for face, count in enumerate(model.counts.tolist()):
        of_face = slice(begin, begin + count)
        corners = np.column_stack([model.vertices[model.corners[of_face]], normals[of_face]])
        rest = (*model.colours[face], model.own[face])
        for second in range(1, count - 1):
            fan = corners[[0, second, second + 1]]
            rows += [(*corner, *rest) for corner in fan.tolist()]
        begin += count
    if with_nose:
        raised = model.nose + (0.0, 0.0, ABOVE)
        rows += [(*corner, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, NOSE) for corner in raised.tolist()]
    return np.array(rows, dtype=np.float32)


def _corner_normals(model):
    """Return the normal (c, 3) at each corner of the faces: on what is round that of the round body."""
    faces = np.repeat(np.arange(len(model.counts)), model.counts)
    flat, is_round = model.normals[faces], ~model.crisp[faces]
    summed = np.zeros_like(model.vertices)
    np.add.at(summed, model.corners[is_round], flat[is_round])
    normals = summed[model.corners]
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), LEAST_SUM)
    bends = np.einsum("cd,cd->c", normals, flat)
    return np.where((is_round & (bends > ROUND))[:, np.newaxis], normals, flat)
