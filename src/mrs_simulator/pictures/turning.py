"""Models of kinds whose wheels and rotors turn, for painting.

Parts keep their planes, by which they are ordered: what turns of a wheel or a rotor are marks on its ends.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.spatial import about_z
from mrs_simulator.pictures.moving_parts import (
    BLADE,
    BLADES,
    CAP_REACH,
    HUB,
    HUB_REACH,
    SPOKE,
    SPOKES,
    SWEPT,
    moving_places,
    parted,
)
from mrs_simulator.pictures.solids import kind_model, kind_parts

ROUND = 0.2 * np.pi * np.arange(10)  # [rad] corners of a hub


class _Turning(NamedTuple):
    """One moving part of a model."""

    part: Any  # its ``MovingPart``
    marks: Any  # the slice of the model's vertices that are of its marks
    points: Any  # these (k, 3) [m], in the part's frame
    solid: Any  # the slice of its own vertices
    faces: Any  # (f,) bool: its own and its marks'


def posed(kind, motion):
    """Return the ``Model`` of m robots of a ``Kind`` with its moving parts as they are now.

    ``motion``: their ``Motion``.  Of a model with such parts the vertices are (m, v, 3), and where some
    steer normals and offsets are (m, f, 3) and (m, f).
    """
    model, moving = _marked(kind)
    m = len(motion.place)
    if not moving or not m:
        return model
    origin, level = np.zeros((m, 3)), np.broadcast_to(np.eye(3), (m, 3, 3))
    vertices = np.repeat(model.vertices[np.newaxis], m, axis=0)
    for each in moving:
        place, turn = motion.frames(each.part, origin, level)
        vertices[:, each.marks] = place[:, np.newaxis] + each.points @ turn.swapaxes(1, 2)
    model = model._replace(vertices=vertices)
    steered = [each for each in moving if each.part.is_steered]
    return model if motion.steering is None else _steered(model, steered, motion.steering)


def _steered(model, parts, steering):
    """Return the ``model`` of m robots with those ``parts`` turned by ``steering`` (m,) [rad]."""
    if not parts:
        return model
    normals, offsets = (np.repeat(each[np.newaxis], len(steering), axis=0) for each in model[3:5])
    back = about_z(-steering)  # rows of vectors times this are turned
    for each in parts:
        middle, faces = each.part.place[:3, 3], each.faces
        own = model.vertices[:, each.solid]
        model.vertices[:, each.solid] = middle + (own - middle) @ back
        normals[:, faces] = model.normals[faces] @ back
        offsets[:, faces] += (normals[:, faces] - model.normals[faces]) @ middle
    return model._replace(normals=normals, offsets=offsets)


@functools.lru_cache(maxsize=64)
def _marked(kind):
    """Return the ``Model`` of a ``Kind`` with marks as further faces of its moving parts, and these."""
    model, places = kind_model(kind), moving_places(kind)
    moving = parted(kind)[1]
    marks = [_marks(kind_parts(kind)[place].size, part) for place, part in zip(places, moving)]
    if not moving:
        return model, ()
    # The marks' vertices come first: there they count for the extent of no part.
    counts = np.array([[len(corners) for corners, _, _ in of] for of in marks])
    total, ends = counts.sum(), np.cumsum(counts.sum(axis=1))
    faces, points = [], []
    for part, of in zip(moving, marks):
        points += [part.place[:3, 3] + corners @ part.place[:3, :3].T for corners, _, _ in of]
        faces += [(side * part.place[:3, 2], colour[:3]) for _, side, colour in of]
    normals, colours = map(np.array, zip(*faces))
    offsets = [normal @ corners[0] for normal, corners in zip(normals, points)]
    whose, plain = np.repeat(places, counts.shape[1]), np.zeros(counts.size)
    swept = np.isin(model.part, [k for k, part in zip(places, moving) if part.is_rotor])
    marked = model._replace(
        vertices=np.concatenate([*points, model.vertices]),
        corners=np.append(model.corners + total, np.arange(total)),
        counts=np.append(model.counts, counts.ravel()),
        normals=np.concatenate([model.normals, normals]),
        offsets=np.append(model.offsets, offsets),
        part=np.append(model.part, whose),
        begins=model.begins + total,
        crisp=np.append(model.crisp, plain > 0.0),
        colours=np.concatenate([model.colours, colours]),
        own=np.append(model.own, plain),
        opacity=np.append(np.where(swept, SWEPT, 1.0), plain + 1.0),
    )
    borders = np.append(marked.begins, len(marked.vertices))
    return marked, tuple(
        _Turning(
            part,
            slice(end - sum(len(corners) for corners, _, _ in of), end),
            np.concatenate([corners for corners, _, _ in of]),
            slice(borders[place], borders[place + 1]),
            marked.part == place,
        )
        for place, part, of, end in zip(places, moving, marks, ends)
    )


def _marks(size, part):
    """Return the marks on both ends of a moving ``part``, a cylinder of ``size``, a list.

    Each has corners (k, 3) [m] in the part's frame, counter-clockwise from outside, the side of z that it
    is on, and a colour.
    """
    radius, half = size[0], 0.5 * size[1]
    hub = np.stack([np.cos(ROUND), np.sin(ROUND)], axis=1)
    bar = 0.5 * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    if part.is_rotor:
        flat = (bar * BLADES, BLADE), (CAP_REACH * hub, BLADE)
    else:
        flat = (HUB_REACH * hub, HUB), (bar * SPOKES, SPOKE), ((bar * SPOKES)[:, ::-1][::-1], SPOKE)
    return [
        (
            np.column_stack([radius * corners, np.full(len(corners), side * half)])[::side],
            side,
            colour,
        )
        for side in (1, -1)
        for corners, colour in flat
    ]
