"""Robots and obstacles of a picture: faces, shadows, marks and numbers."""

from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.spatial import about_z, rotated, rotations
from mrs_simulator.pictures.arms import ABOVE as OVER
from mrs_simulator.pictures.arms import load_tile
from mrs_simulator.pictures.camera import NEAR
from mrs_simulator.pictures.drawing import Polygons, ranges, taken, with_opacity
from mrs_simulator.pictures.moving_parts import parted
from mrs_simulator.pictures.signs import MANY_ROBOTS, circle, dots
from mrs_simulator.pictures.solids import kind_model, obstacle_models, reaches
from mrs_simulator.pictures.turning import posed

AMBIENT = 0.52  # [-] of light that comes from everywhere
DARKEST = 0.1  # [-] brightness of what is black: its faces would not differ
RIM = 0.7  # [-] brightness of edges beside that of their faces
LEAST_SEEN = 3.0  # [px] of a robot's reach, below which its mark alone is painted
COARSE = 22.0  # [px] below which its small parts are left out
MARK = 5.0  # [px] radius of the mark under a robot that is hard to see
LARGER = 1.06  # [-] shadows beside outlines
ABOVE = 11.0  # [px] from a robot's top to the middle of its number


class Robots(NamedTuple):
    """n robots in the camera's frame."""

    kinds: Any  # ``Kind``s, (n,)
    place: Any  # (n, 3) [m]
    theta: Any  # (n,) [rad]
    turn: Any  # (n, 3, 3), robots' frames into the common frame
    shades: Any  # (n, 3) their own colours
    away: Any  # (n,) [m] from the eye
    screen: Any  # (n, 2) [px]
    size: Any  # (n,) [px] of their reach
    inside: Any  # (n,) bool: in the picture

    def rows_of_kinds(self, chosen):
        """Yield each kind with the rows of its robots that are ``chosen`` (n,), where there are any."""
        names = np.array([kind.name for kind in self.kinds])
        for kind in {each.name: each for each in self.kinds}.values():
            rows = np.flatnonzero(chosen & (names == kind.name))
            if len(rows):
                yield kind, rows


class _Faces(NamedTuple):
    """f polygons of things of known distance."""

    points: Any  # (v, 2) [px]
    counts: Any  # (f,)
    colours: Any  # (f, 4)
    rims: Any  # (f, 4)
    away: Any  # (f,) [m] of the thing from the eye


def seen_robots(view, kinds, pose, place, turn, shades):
    """Return the ``Robots``; those whose ``pose`` or ``place`` is not finite are not in the picture."""
    seen = view.seen(place)
    reach = reaches(kinds)
    known = np.isfinite(pose).all(axis=1) & np.isfinite(place).all(axis=1)
    ahead = known & (seen[:, 2] > NEAR + reach)
    screen = view.screen(np.where(ahead[:, np.newaxis], seen, (0.0, 0.0, 1.0)))
    size = view.scale * reach / np.where(ahead, seen[:, 2], 1.0)
    room = size[:, np.newaxis]
    inside = ((screen >= -room) & (screen <= (view.width, view.height) + room)).all(axis=1)
    away = np.linalg.norm(place - view.eye, axis=1)
    return Robots(
        tuple(kinds),
        place,
        pose[:, 2],
        turn,
        np.asarray(shades),
        away,
        screen,
        size,
        ahead & inside,
    )


def shadows(view, robots, above=()):
    """Return the ground that the robots stand on or are above, as seen from straight above.

    ``above``: outlines (k, 2) [m] of what else is above the ground.
    """
    points, counts = [], []
    for outline in above:
        seen = view.seen(np.column_stack([outline, np.zeros(len(outline))]))
        if (seen[:, 2] > NEAR).all():
            points.append(view.screen(seen))
            counts.append(len(seen))
    level = about_z(robots.theta)
    for kind, rows in robots.rows_of_kinds(robots.inside):
        rim = _rim(kind.body)
        ground = np.einsum("vd,med->mve", rim, level[rows])
        ground += robots.place[rows, np.newaxis] * (1.0, 1.0, 0.0)
        seen = view.seen(ground)
        seen = seen[(seen[..., 2] > NEAR).all(axis=1)]
        points.append(view.screen(seen).reshape(-1, 2))
        counts += [len(rim)] * len(seen)
    if not counts:
        return None
    colours = np.tile((0.0, 0.0, 0.0, view.palette.shadow), (len(counts), 1))
    return Polygons(np.concatenate(points), np.array(counts), colours, np.zeros_like(colours))


def _rim(body):
    """Return the outline (k, 3) [m] of a ``Body``, a little larger, on the ground."""
    if body.round:
        rim = body.front * circle()
    else:
        side = 0.5 * body.width
        rim = np.array(
            [(body.front, side), (-body.rear, side), (-body.rear, -side), (body.front, -side)]
        )
    return np.column_stack([LARGER * rim, np.zeros(len(rim))])


def marks(robots, radius=MARK):
    """Return discs of ``radius`` [px] in the colours of robots that reach less far; None where none is."""
    rows = np.flatnonzero(robots.inside & (robots.size < radius))
    if not len(rows):
        return None
    return dots(robots.screen[rows], with_opacity(robots.shades[rows], 0.9), radius)


def numbers(view, robots, names):
    """Return the robots' ``names`` above them; None where there are none, or too many, in view."""
    rows = np.flatnonzero(robots.inside)
    if not 0 < len(rows) <= MANY_ROBOTS:
        return None
    top = robots.place[rows].copy()
    top[:, 2] += [robots.kinds[row].body.height for row in rows]
    # In a near view from above the body's farther rim is higher in the picture than its middle.
    bodies = [robots.kinds[row].body for row in rows]
    behind = [0.5 * max(body.length, body.width) for body in bodies]
    right = view.camera.axes[0]
    top += np.outer(behind, (-right[1], right[0], 0.0))
    places = view.screen(view.seen(top)) - (0.0, ABOVE)
    return view.texts(places, tuple(str(names[row]) for row in rows))


def things(view, robots, obstacles, arms=(), load=None, motion=None):
    """Return the faces of robots and obstacles that face the camera, the farthest thing's first.

    ``arms``: ``pictures.arms.Placed``s of the robots; ``load``: a ``Load`` and its ``LoadState``, or None;
    ``motion``: the robots' ``Motion``, None where nothing turns.
    """
    large = robots.inside & (robots.size >= COARSE)
    small = robots.inside & (robots.size >= LEAST_SEEN) & ~large
    found = []
    for coarse, chosen in ((False, large), (True, small)):
        for kind, rows in robots.rows_of_kinds(chosen):
            where = robots.place[rows], robots.turn[rows], robots.shades[rows], robots.away[rows]
            is_still = coarse or motion is None
            model = kind_model(kind, coarse) if is_still else posed(kind, motion.of(rows))
            found.append(_faces(view, model, *where, not coarse))
            found.append(_noses(view, kind, *where))
    for each in arms:
        found += _arm_faces(view, robots, each)
    if load is not None:
        found.append(_load_faces(view, *load))
    for obstacle in obstacles:
        found += _tiles(view, obstacle)
    found = [each for each in found if len(each.counts)]
    if not found:
        return None
    points, counts, colours, rims, away = (np.concatenate(each) for each in zip(*found))
    order = np.argsort(-away, kind="stable")
    return Polygons(taken(points, counts, order), counts[order], colours[order], rims[order])


def faint(view, ghosts, opacity):
    """Return the faces of ``Ghosts`` that face the camera, seen through; None where there are none."""
    if not len(ghosts.kinds):
        return None
    team = seen_robots(view, ghosts.kinds, ghosts.place, ghosts.place, ghosts.turn, ghosts.shades)
    faces = things(view, team, ())
    if faces is None:
        return None
    colours = np.array(faces.colours)
    colours[:, 3] *= opacity
    return faces._replace(colours=colours, rims=np.zeros_like(faces.rims))


def _arm_faces(view, robots, arms):
    """Yield the faces of the ``arms`` of those robots that are large enough in the picture."""
    chosen = (robots.inside & (robots.size >= LEAST_SEEN))[arms.rows]
    rows, links = arms.rows[chosen], arms.links[chosen]
    for link, model in enumerate(arms.models):
        place, turn = links[:, link, :3, 3], links[:, link, :3, :3]
        middle = place + turn @ model.vertices.mean(axis=0)
        away = np.linalg.norm(middle - view.eye, axis=1)
        away = np.minimum(away, robots.away[rows] - OVER)  # it stands on its base
        yield _faces(view, model, place, turn, robots.shades[rows], away)


def _load_faces(view, load, carried):
    """Return the faces of the ``load``, tile by tile."""
    model, middles = load_tile(tuple(load.size))
    turns = np.broadcast_to(carried.orientation, (len(middles), 4))
    place = carried.place + rotated(turns, middles)
    ahead = view.seen(place)[:, 2] > NEAR + model.reach
    place, shades = place[ahead], np.zeros((int(ahead.sum()), 3))
    away = np.linalg.norm(place - view.eye, axis=1)
    return _faces(view, model, place, rotations(turns[ahead]), shades, away)


def _tiles(view, obstacle):
    shade = np.array([view.palette.obstacle])
    for model, (x, y, yaw) in obstacle_models(obstacle, (*view.palette.obstacle, 1.0)):
        place = np.array([(x, y, 0.0)])
        if view.seen(place)[0, 2] > NEAR + model.reach:
            away = np.linalg.norm(place - view.eye, axis=1)
            yield _faces(view, model, place, about_z([yaw]), shade, away)


def _faces(view, model, place, turn, shades, away, rimmed=True):
    """Return the faces of m things of one ``model`` that face the camera, as ``_Faces``.

    Vertices, normals and offsets of the ``model`` may be (m, ...), those of each thing.
    """
    world = place[:, np.newaxis] + model.vertices @ turn.swapaxes(1, 2)
    screen = view.screen(view.seen(world))
    eye = np.einsum("mdi,md->mi", turn, view.eye - place)
    facing = (model.normals @ eye[:, :, np.newaxis])[..., 0] > model.offsets
    last = model.pairs.ranks(eye, screen, model.begins)[:, model.part]
    order = np.argsort(np.where(facing, last, np.inf), axis=1, kind="stable")
    things, places = np.nonzero(np.take_along_axis(facing, order, axis=1))
    faces = order[things, places]
    counts = model.counts[faces]
    begins = np.cumsum(model.counts) - model.counts
    corners = model.corners[ranges(begins[faces], counts)]
    points = screen[np.repeat(things, counts), corners]
    own = model.own[faces][:, np.newaxis]
    colours = own * shades[things] + (1.0 - own) * model.colours[faces]
    lit = (model.normals @ (view.light @ turn)[:, :, np.newaxis])[..., 0]
    bright = (AMBIENT + (1.0 - AMBIENT) * np.maximum(lit, 0.0))[things, faces]
    colours = (DARKEST + (1.0 - DARKEST) * colours) * bright[:, np.newaxis]
    # Seams between faces of one colour are painted over; edges of the thing are drawn.
    rims = colours * np.where(model.crisp[faces], RIM, 1.0)[:, np.newaxis]
    opacity = model.opacity[faces]
    rims = with_opacity(rims, rimmed * (opacity == 1.0))
    return _Faces(points, counts, with_opacity(colours, opacity), rims, away[things])


def _noses(view, kind, place, turn, shades, away):
    """Return the arrow on top of each robot that shows its heading."""
    nose = parted(kind)[0].nose
    world = place[:, np.newaxis] + np.einsum("vd,med->mve", nose, turn)
    above = np.einsum("md,md->m", turn[:, :, 2], view.eye - world[:, 0]) > 0.0
    points = view.screen(view.seen(world[above])).reshape(-1, 2)
    dark = shades[above].sum(axis=1) < 1.5
    colours = with_opacity(
        np.where(dark[:, np.newaxis], (0.95, 0.95, 0.95), (0.12, 0.12, 0.12)), 0.9
    )
    return _Faces(points, np.full(int(above.sum()), len(nose)), colours, colours, away[above])
