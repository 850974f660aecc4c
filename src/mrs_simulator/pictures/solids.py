"""Robots and obstacles as convex polyhedra, and the painting order of their parts.

A picture is painted from back to front.  Two convex parts that a plane separates hide each other in one
order only: the part on the eye's side of that plane is painted last.
"""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.surroundings.obstacles import Cylinder
from mrs_simulator.vehicles.importing.placing import transform_at
from mrs_simulator.vehicles.portable import model_shape
from mrs_simulator.vehicles.shape import Part, outline_parts

SIDES = 16  # [-] of a cylinder
RINGS = 6  # [-] of a sphere from pole to pole
TINTED, TINT = 0.4, 0.8  # [-] of the widest part seen from above: such parts are tinted so much
NOSE = 0.45  # [-] of the lesser side of what it is on
# Parts whose pictures a line across one of these separates do not overlap, (2, 8).
DIRECTIONS = np.array(
    [(math.cos(k * math.pi / 8.0), math.sin(k * math.pi / 8.0)) for k in range(8)]
).T
SMALL = 0.3  # [-] of the longest part: shorter ones are left out of a coarse model
TOUCH = 1e-9  # [m] by which parts that touch may reach into each other
TILE = 1.0  # [m] of a long obstacle that is ordered among robots as one thing


class Solid(NamedTuple):
    """A convex polyhedron: vertices (v, 3) [m]; faces, tuples of vertices counter-clockwise from outside.

    ``crisp``: for each face, whether its rim is an edge of the thing and not of the approximation.
    """

    vertices: Any
    faces: Any
    crisp: Any


class Model(NamedTuple):
    """All solids of one kind of thing; f faces of p parts with v vertices, in the frame of its place."""

    vertices: Any  # (v, 3) [m]
    corners: Any  # (c,) indices of vertices, face after face
    counts: Any  # (f,) corners of each face
    normals: Any  # (f, 3) outwards
    offsets: Any  # (f,) [m]: normal . x = offset on the face
    part: Any  # (f,) index of the face's part
    begins: Any  # (p,) first vertex of each part
    crisp: Any  # (f,) bool
    colours: Any  # (f, 3) red, green, blue in 0..1
    own: Any  # (f,) share of the robot's own colour in 0..1
    opacity: Any  # (f,) in 0..1
    pairs: Any  # ``Pairs``
    reach: float  # [m] of the farthest vertex from the place
    nose: Any  # (3, 3) [m] an arrow ahead on the highest part in the robot's own colour


class Pairs(NamedTuple):
    """For each of k pairs of parts, the plane that separates them best."""

    normals: Any  # (k, 3)
    offsets: Any  # (k,) [m]
    beyond: Any  # (k,) the part on the side that the normal points to
    within: Any  # (k,) the other one
    apart: Any  # (k,) bool: the plane separates them; else they reach into each other

    def ranks(self, eye, screen, begins):
        """Return the painting order of the parts of m things, (m, p), the least rank first.

        ``eye`` (m, 3) [m]: in the things' frames; ``screen`` (m, v, 2) [px]: the parts' vertices, those of
        each from ``begins`` (p,) on.  Of two parts that may overlap in the picture, that on the eye's side
        of the plane between them is painted later: its rank is above the other's.
        """
        along = screen @ DIRECTIONS
        low, high = (each.reduceat(along, begins, axis=1) for each in (np.minimum, np.maximum))
        first, second = self.beyond, self.within
        aside = (low[:, first] >= high[:, second]) | (low[:, second] >= high[:, first])
        meet, ahead = ~aside.any(axis=2), eye @ self.normals.T > self.offsets
        parts = len(begins)
        ranks, settled = _ranks(parts, first, second, meet, ahead)
        if (
            not settled.all()
        ):  # parts that reach into one another are a ring: they do not count then
            ring = ~settled
            left = meet[ring] & self.apart
            ranks[ring] = _ranks(parts, first, second, left, ahead[ring])[0]
        return ranks


def _ranks(parts, first, second, meet, ahead):
    """Return the parts' ranks (m, p) and for which things (m,) each is above those that it hides.

    Of the pairs (k,) of a ``first`` and a ``second`` part those count that ``meet`` (m, k); the first is
    painted later where it is ``ahead`` (m, k).
    """
    m = len(meet)
    later = np.zeros((m, parts, parts), dtype=bool)  # [a, b]: a after b
    later[:, first, second] = meet & ahead
    later[:, second, first] = meet & ~ahead
    ranks, rising = np.zeros((m, parts), dtype=int), np.ones(m, dtype=bool)
    for _ in range(parts):  # no chain is longer
        raised = np.maximum(ranks, (later * (ranks[:, np.newaxis] + 1)).max(axis=2, initial=0))
        rising = (raised != ranks).any(axis=1)
        if not rising.any():
            break
        ranks = raised
    return ranks, ~rising


@functools.lru_cache(maxsize=64)
def kind_model(kind, coarse=False):
    """Return the ``Model`` of a ``Kind``, standing on the ground at its centre.

    Its largest part takes the robot's own colour.  ``coarse``: without the parts that are small beside it.
    """
    parts = kind_parts(kind)
    if coarse:
        least = SMALL * max(max(part.size) for part in parts)
        parts = [part for part in parts if max(part.size) >= least]
    return model_of(parts)


def reaches(kinds):
    """Return how far the models of robots of these ``kinds`` reach, (n,) [m]."""
    known = {id(kind): kind for kind in kinds}  # to hash a kind takes its time
    reach = {key: kind_model(kind).reach for key, kind in known.items()}
    return np.array([reach[id(kind)] for kind in kinds])


def kind_parts(kind):
    """Return the ``Part``s of a ``Kind``, standing on the ground at its centre, a list."""
    parts = kind.shape or _model_parts(kind) or outline_parts(kind)
    lift = kind.module.ride_height(kind.numbers)
    return [part._replace(place=_lifted(part.place, lift)) for part in parts]


def _model_parts(kind):
    """Return the parts of the kind's URDF; none where it has no file, or one without shapes."""
    try:
        return model_shape(kind.model) if kind.model else ()
    except (ScenarioError, OSError):
        return ()


def _lifted(place, lift):
    return (*place[:2], place[2] + lift, *place[3:])


def obstacle_models(obstacle, colour):
    """Yield the ``Model`` and place (x, y, yaw) of each tile of an obstacle, at most ``TILE`` wide."""
    middle = 0.5 * obstacle.height
    if isinstance(obstacle, Cylinder):
        size = (obstacle.radius, obstacle.height)
        part = Part("cylinder", size, (0.0, 0.0, middle, 0.0, 0.0, 0.0), colour)
        yield model_of([part]), (obstacle.x, obstacle.y, 0.0)
        return
    along, across = (max(1, math.ceil(side / TILE)) for side in (obstacle.length, obstacle.width))
    size = (obstacle.length / along, obstacle.width / across, obstacle.height)
    part = Part("box", size, (0.0, 0.0, middle, 0.0, 0.0, 0.0), colour)
    # Where tiles meet there is no edge.
    model = model_of([part])._replace(crisp=np.zeros(6, dtype=bool))
    cos, sin = math.cos(obstacle.yaw), math.sin(obstacle.yaw)
    for i in range(along):
        for j in range(across):
            u = (i + 0.5) * size[0] - 0.5 * obstacle.length
            v = (j + 0.5) * size[1] - 0.5 * obstacle.width
            yield (
                model,
                (obstacle.x + cos * u - sin * v, obstacle.y + sin * u + cos * v, obstacle.yaw),
            )


def solid_of(part):
    """Return the ``Solid`` of a ``Part`` at its place."""
    solid = _FORMS[part.form](*part.size)
    place = transform_at(part.place[:3], part.place[3:])
    return solid._replace(vertices=solid.vertices @ place[:3, :3].T + place[:3, 3])


def _box(length, width, height):
    signs = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
    faces = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    return Solid(0.5 * signs * (length, width, height), faces, (True,) * 6)


def _cylinder(radius, length):
    turn = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)
    rim = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    low, high = (np.column_stack([rim, np.full(SIDES, z)]) for z in (-0.5 * length, 0.5 * length))
    sides = [(k, (k + 1) % SIDES, SIDES + (k + 1) % SIDES, SIDES + k) for k in range(SIDES)]
    caps = [tuple(reversed(range(SIDES))), tuple(range(SIDES, 2 * SIDES))]
    return Solid(np.concatenate([low, high]), (*sides, *caps), (False,) * SIDES + (True,) * 2)


def _sphere(radius):
    count = 2 * RINGS
    down = np.pi * np.arange(1, RINGS) / RINGS
    turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    rings = [
        (math.sin(a) * np.cos(turn), math.sin(a) * np.sin(turn), np.full(count, math.cos(a)))
        for a in down
    ]
    vertices = [np.stack(ring, axis=1) for ring in rings] + [[(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]]
    top, bottom = count * (RINGS - 1), count * (RINGS - 1) + 1
    faces = []
    for k in range(count):
        after = (k + 1) % count
        faces.append((top, k, after))
        for ring in range(RINGS - 2):
            above, below = ring * count, (ring + 1) * count
            faces.append((above + k, below + k, below + after, above + after))
        last = (RINGS - 2) * count
        faces.append((bottom, last + after, last + k))
    return Solid(radius * np.concatenate(vertices), tuple(faces), (False,) * len(faces))


_FORMS = {"box": _box, "cylinder": _cylinder, "sphere": _sphere}


def model_of(parts):
    """Return the ``Model`` of ``Part``s."""
    solids = [solid_of(part) for part in parts]
    begins = np.cumsum([0] + [len(solid.vertices) for solid in solids])
    vertices = np.concatenate([solid.vertices for solid in solids])
    faces = [
        tuple(begin + corner for corner in face)
        for begin, solid in zip(begins, solids)
        for face in solid.faces
    ]
    counts = np.array([len(face) for face in faces])
    part = np.repeat(np.arange(len(solids)), [len(solid.faces) for solid in solids])
    normals = np.array([_normal(vertices[list(face)]) for face in faces])
    offsets = np.einsum("fd,fd->f", normals, vertices[[face[0] for face in faces]])
    shares = own_shares(parts, solids)
    return Model(
        vertices=vertices,
        corners=np.array([corner for face in faces for corner in face]),
        counts=counts,
        normals=normals,
        offsets=offsets,
        part=part,
        begins=begins[:-1],
        crisp=np.concatenate([solid.crisp for solid in solids]),
        colours=np.array([parts[k].colour[:3] for k in part]),
        own=shares[part],
        opacity=np.ones(len(faces)),
        pairs=_pairs(vertices, begins, normals, offsets, part, len(solids)),
        reach=float(np.sqrt(np.square(vertices).sum(axis=1).max())),
        nose=arrow_on([solid for solid, own in zip(solids, shares) if own > 0.0]),
    )


def own_shares(parts, solids):
    """Return the share of the robot's own colour in each part's: all where it looks like the largest."""
    sizes = np.array([np.ptp(solid.vertices, axis=0) for solid in solids])
    bulk, above = sizes.prod(axis=1), sizes[:, 0] * sizes[:, 1]
    main = parts[int(np.argmax(bulk))].colour
    same = [part.colour == main for part in parts]
    return np.where(same, 1.0, np.where(above > TINTED * above.max(), TINT, 0.0))


def arrow_on(solids):
    """Return an arrow (3, 3) [m] near the front end of the highest of ``solids``, on top of it."""
    corners = max((solid.vertices for solid in solids), key=lambda each: each[:, 2].max())
    low, high = corners.min(axis=0), corners.max(axis=0)
    length, width, _ = high - low
    size = NOSE * min(length, width)
    tip, middle = high[0] - 0.25 * size, 0.5 * (low[1] + high[1])
    arrow = (tip, middle), (tip - size, middle + 0.5 * size), (tip - size, middle - 0.5 * size)
    return np.array([(x, y, high[2]) for x, y in arrow])


def _normal(corners):
    """Return the unit normal (3,) of a flat polygon ``corners`` (k, 3), by Newell's sum."""
    total = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    length = np.linalg.norm(total)
    return total / length if length > 0.0 else np.array([0.0, 0.0, 1.0])


def _pairs(vertices, begins, normals, offsets, part, count):
    """Return the ``Pairs`` of ``count`` parts: of all their faces' planes the one with the widest gap."""
    # How far each part lies beyond each face's plane, (f, p).
    beyond = np.minimum.reduceat(normals @ vertices.T, begins[:-1], axis=1) - offsets[:, np.newaxis]
    chosen = []
    for a in range(count):
        for b in range(a + 1, count):
            own, other = np.flatnonzero(part == a), np.flatnonzero(part == b)
            first = own[np.argmax(beyond[own, b])]
            second = other[np.argmax(beyond[other, a])]
            face, far, near = (
                (first, b, a) if beyond[first, b] >= beyond[second, a] else (second, a, b)
            )
            chosen.append((face, far, near))
    faces, far, near = np.array(chosen, dtype=int).reshape(-1, 3).T
    return Pairs(normals[faces], offsets[faces], far, near, beyond[faces, far] >= -TOUCH)
