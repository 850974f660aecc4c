"""A team in three dimensions as a drawing: ground, trails, targets, edges, obstacles and robots."""

import functools
from typing import Any, NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.arrays import are_near
from mrs_simulator.core.spatial import about_z, rotations
from mrs_simulator.pictures import ground, robots, signs
from mrs_simulator.pictures.arms import arm_outlines, load_corners, load_outline, scene_arms
from mrs_simulator.pictures.camera import NEAR, clipped_segments
from mrs_simulator.pictures.drawing import Drawing, Paths, with_opacity
from mrs_simulator.pictures.moving_parts import Motion
from mrs_simulator.pictures.palette import LIGHT
from mrs_simulator.pictures.solids import kind_model, obstacle_models, reaches
from mrs_simulator.pictures.view import View
from mrs_simulator.scenario.surroundings.obstacles import is_flat
from mrs_simulator.state.columns import JOINTS, LOAD, ORIENTATION

ROOM = 0.9  # [-] of a picture's sides for what is framed: numbers are around it
LEAST_ROOM, NUMBERS = 0.5, 22.0  # [-], and [px] around what is framed
# [m], and [-] of a team's longer side: obstacles so near to it are framed with it
LEAST_NEAR, NEAR_TEAM = 1.5, 0.35
# [-] opacity of trails; of ghosts, of their paths, and of rings where these end
TRAIL_SHOWN, GHOST_SHOWN, PATH_SHOWN, END_SHOWN = 0.9, 0.45, 0.45, 0.75
TRAIL, PLUMB = 1.6, 1.2  # [px] widths of lines
BEAM, HIT = 1.0, 1.6  # [px] width of a sensor's ray, radius of where it met something
SPACING = 3.0  # [px] between points of a trail
RING, RING_RADIUS, RING_CORNERS = 3.0, 1.35, 48  # [px] wide; [-] of a robot's reach; corners
MOST_HIDDEN = 0.4  # [-] of an edge at each end, that the body there hides
COVERED = 0.7  # [-] of a robot's reach, within which its body covers its target
FLIES = 2.0  # [-] of a robot's height: above it there is a plumb line


class Ghosts(NamedTuple):
    """m robots as they may be, or as they were in another run, drawn faintly, and the ways of k of them."""

    kinds: Tuple[Any, ...]
    place: Any  # (m, 3) [m]
    turn: Any  # (m, 3, 3), into the common frame
    shades: Any  # (m, 3)
    paths: Tuple[Any, ...] = ()  # (p, 3) [m] each
    path_shades: Any = ()  # (k, 3)
    ringed: bool = False  # whether a ring is where each path ends


class Beams(NamedTuple):
    """What one sensor has measured, as lines in space."""

    segments: Any  # (m, 2, 3) [m]
    opacity: Any  # (m,)
    hits: Any  # (k, 3) [m], where a ray met something
    shade: Any  # (3,)


def ghosts_at(kinds, pose, heights, shades, paths=(), path_shades=()):
    """Return the ``Ghosts`` of upright robots at ``pose`` (m, 3) and ``heights`` (m,) [m]."""
    place = np.column_stack([pose[:, :2], heights])
    turn = about_z(pose[:, 2])
    return Ghosts(tuple(kinds), place, turn, np.asarray(shades), tuple(paths), path_shades)


class Scene(NamedTuple):
    """A team of n robots at one time, and what is around it."""

    kinds: Tuple[Any, ...]  # a ``Kind`` each
    state: Any  # a ``StateTable`` of the robots at one time
    shades: Any  # (n, 3) the robots' colours, red, green, blue in 0..1
    trails: Tuple[Any, ...] = ()  # (k, 3) [m] each, one for each robot
    targets: Any = None  # (n, 3) [m]
    edges: Any = ()  # (receiver, sender, weight), robots by their rows
    directed: bool = True  # whether edges show their direction
    obstacles: Tuple[Any, ...] = ()
    numbered: bool = True
    # the ``load.Load`` that they carry together, seen where the state has its pose
    load: Any = None

    chosen: Any = None  # the row of a robot that is picked out
    # (n, 3) [m, m, rad] that the robots have gone along and across their headings, and turned, on wheels
    rolled: Any = None
    ghosts: Tuple[Any, ...] = ()  # ``Ghosts``
    beams: Tuple[Any, ...] = ()  # ``Beams`` of sensors

    @property
    def place(self):
        """Return the robots' positions (n, 3) [m]."""
        return np.column_stack([self.state.pose[:, :2], self.state.heights])

    @property
    def turn(self):
        """Return the robots' rotation matrices (n, 3, 3), from their frames into the common frame."""
        if self.state.has(ORIENTATION):
            return rotations(self.state.orientation)
        return about_z(self.state.pose[:, 2])

    @property
    def motion(self):
        """Return the ``Motion`` of the robots, which their wheels and rotors follow."""
        n, has_joints = len(self.kinds), self.state.has(JOINTS)
        rolled = np.zeros((n, 3)) if self.rolled is None else self.rolled
        steering = self.state.joints.reshape(n, -1)[:, 0] if n and has_joints else None
        return Motion(self.place, rolled, steering, self.state.time or 0.0)

    @property
    def carried(self):
        """Return the load and its ``LoadState``, None where there is none or its pose is unknown."""
        return (self.load, self.state.load) if self.load and self.state.has(LOAD) else None

    @property
    def on_water(self):
        """Return whether the ground is water: all robots float or fly, or some obstacle is land."""
        if any(is_flat(obstacle) for obstacle in self.obstacles):
            return True
        return {kind.module.MEDIUM for kind in set(self.kinds)} - {"air"} == {"water"}


def framed(scene, camera, width, height, whole=True):
    """Return ``camera``, looking as it does, with robots and targets in view.

    ``whole``: all trails and obstacles too, else those obstacles alone that are near.
    """
    points = [_room_of_robots(scene), *(each.place for each in scene.ghosts)]
    if scene.targets is not None:
        points.append(scene.targets)
    if scene.carried is not None:
        points.append(load_corners(*scene.carried))
    for arms in scene_arms(scene):
        points.append(arms.links[:, :, :3, 3].reshape(-1, 3))
    # A coast may be far longer than the team's way.
    around = _corners(tuple(each for each in scene.obstacles if not is_flat(each)))
    if whole:
        points += [around, *(trail for trail in scene.trails if len(trail))]
    points = np.concatenate(points)
    points = points[np.isfinite(points).all(axis=1)]
    if not whole and len(points):
        points = np.concatenate([points, _near(around, points)])
    # In a low picture, too, there is room for the numbers.
    room = min(ROOM, max(LEAST_ROOM, 1.0 - 2.0 * NUMBERS / height))
    return camera.framed(points, width, height, room)


@functools.lru_cache(maxsize=8)
def _corners(obstacles):
    """Return the corners (k, 3) [m] of the tiles of ``obstacles``."""
    points = [np.empty((0, 3))]
    for obstacle in obstacles:
        for model, (x, y, yaw) in obstacle_models(obstacle, (*LIGHT.obstacle, 1.0)):
            points.append(model.vertices @ about_z([yaw])[0].T + (x, y, 0.0))
    return np.concatenate(points)


def _near(around, points):
    """Return those of ``around`` (k, 3) [m] that are near to the box about ``points`` (m, 3)."""
    least = LEAST_NEAR / NEAR_TEAM
    return around[are_near(around[:, :2], points[:, :2], NEAR_TEAM, least)]


def _above(scene, arms):
    """Return outlines (k, 2) [m] of ``arms``, and of the scene's load, as seen from straight above."""
    links = [links for each in arms for links in each.links]
    outlines = [outline for each in links for outline in arm_outlines(each)]
    return outlines if scene.carried is None else [*outlines, load_outline(*scene.carried)]


def _room_of_robots(scene):
    """Return corners of boxes in which the robots can turn, and where they are above, (9 n, 3) [m]."""
    reach = reaches(scene.kinds)
    signs = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (0, 1)]
    place = scene.place
    below = place * (1.0, 1.0, 0.0)  # where their shadows are
    return np.concatenate([below, *(place + np.outer(reach, sign) for sign in signs)])


def drawn_signs(scene, camera, width, height, palette=LIGHT):
    """Return the ``Drawing`` of what lies over a picture of the bodies: edges, signs and numbers."""
    view, place = View(camera, width, height, palette), scene.place
    team = robots.seen_robots(view, scene.kinds, scene.state.pose, place, scene.turn, scene.shades)
    layers = (
        _plumb_lines(view, scene, place),
        *_edges(view, scene, team),
        _hits(view, scene),
        _ends(view, scene),
        _starts(view, scene),
        _targets(view, scene, team),
        robots.marks(team, robots.LEAST_SEEN),  # over bodies that are larger they would hide them
        ground.unit(view),
        robots.numbers(view, team, scene.state.robots) if scene.numbered else None,
    )
    return Drawing(view.width, view.height, None, tuple(each for each in layers if each))


def drawn(scene, camera, width, height, palette=LIGHT):
    """Return the ``Drawing`` of ``scene`` seen by ``camera``, ``width`` by ``height`` [px]."""
    view, place, water = View(camera, width, height, palette), scene.place, scene.on_water
    team = robots.seen_robots(view, scene.kinds, scene.state.pose, place, scene.turn, scene.shades)
    land = [obstacle for obstacle in scene.obstacles if is_flat(obstacle)]
    arms = scene_arms(scene)
    layers = (
        ground.land(view, land),
        ground.grid(view, water),
        ground.sky(view),
        robots.shadows(view, team, _above(scene, arms)),
        _plumb_lines(view, scene, place),
        *_edges(view, scene, team),
        _beams(view, scene),
        _hits(view, scene),
        _ways(view, scene.trails, scene.shades, TRAIL_SHOWN),
        *(_ways(view, each.paths, each.path_shades, PATH_SHOWN) for each in scene.ghosts),
        _ends(view, scene),
        _starts(view, scene),
        _targets(view, scene, team),
        _ring(view, scene),
        *(robots.faint(view, each, GHOST_SHOWN) for each in scene.ghosts),
        robots.marks(team),
        robots.things(
            view,
            team,
            [each for each in scene.obstacles if not is_flat(each)],
            arms,
            scene.carried,
            scene.motion,
        ),
        ground.unit(view),
        robots.numbers(view, team, scene.state.robots) if scene.numbered else None,
    )
    colour = palette.water if water else palette.ground
    return Drawing(view.width, view.height, colour, tuple(each for each in layers if each))


def _ways(view, ways, shades, opacity):
    """Return the ``ways`` of robots, (k, 3) [m] each, in their ``shades``."""
    held = [len(way) for way in ways]
    if not sum(held):
        return None
    points, owner = np.concatenate(ways), np.repeat(np.arange(len(held)), held)
    screen, ahead = _ahead(view, points)
    # One that passes behind the eye is seen in pieces.
    piece = (np.cumsum(~ahead) * len(held) + owner)[ahead]
    if not len(screen):
        return None
    kept, begins = _spaced(screen, piece)
    counts = np.diff(np.r_[np.flatnonzero(begins[kept]), kept.sum()])
    colours = np.asarray(shades)[owner[ahead][begins]]
    return Paths(screen[kept], counts, with_opacity(colours, opacity), TRAIL)


def _beams(view, scene):
    """Return the rays of sensors."""
    if not scene.beams:
        return None
    segments = np.concatenate([each.segments for each in scene.beams])
    colours = [with_opacity([each.shade] * len(each.opacity), each.opacity) for each in scene.beams]
    return view.lines(segments, np.concatenate(colours), BEAM) if len(segments) else None


def _hits(view, scene):
    """Return a dot where each ray of a sensor met something."""
    if not scene.beams:
        return None
    places, ahead = _ahead(view, np.concatenate([each.hits for each in scene.beams]))
    shades = np.concatenate([np.tile(each.shade, (len(each.hits), 1)) for each in scene.beams])
    return signs.dots(places, with_opacity(shades[ahead], 1.0), HIT) if len(places) else None


def _ends(view, scene):
    """Return a ring where each path of ringed ghosts ends."""
    ringed = [each for each in scene.ghosts if each.ringed and len(each.paths)]
    if not ringed:
        return None
    places, ahead = _ahead(view, np.array([path[-1] for each in ringed for path in each.paths]))
    shades = np.concatenate([each.path_shades for each in ringed])[ahead]
    return signs.rings(places, with_opacity(shades, END_SHOWN), len(scene.kinds))


def _spaced(screen, piece):
    """Return which points ``screen`` (v, 2) of lines are drawn, and which begin a ``piece``, (v,) bool.

    Those nearer than ``SPACING`` to the one before them along the line are not.
    """
    begins = np.r_[True, np.diff(piece) != 0]
    ends = np.r_[begins[1:], True]
    steps = np.hypot(*np.diff(screen, axis=0, prepend=screen[:1]).T)
    marks = np.floor(np.cumsum(steps) / SPACING)
    return begins | ends | (np.diff(marks, prepend=marks[0]) > 0), begins


def _plumb_lines(view, scene, place):
    """Return the plumb lines of the robots in the air."""
    height = 0.5 * np.array([kind.body.height for kind in scene.kinds])
    aloft = place[place[:, 2] > FLIES * height]
    segments = np.stack([aloft, aloft * (1.0, 1.0, 0.0)], axis=1)
    colours = np.tile((*view.palette.lines, 0.45), (len(segments), 1))
    return view.lines(segments, colours, PLUMB)


def _ring(view, scene):
    """Return a ring on the ground about the robot that is picked out."""
    if scene.chosen is None or not np.isfinite(scene.place[scene.chosen]).all():
        return None
    reach = kind_model(scene.kinds[scene.chosen]).reach
    turn = np.linspace(0.0, 2.0 * np.pi, RING_CORNERS + 1)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
    corners = scene.place[scene.chosen] * (1.0, 1.0, 0.0) + RING_RADIUS * reach * circle
    segments = np.stack([corners[:-1], corners[1:]], axis=1)
    colours = np.tile((*np.asarray(scene.shades)[scene.chosen], 1.0), (RING_CORNERS, 1))
    return view.lines(segments, colours, RING)


def _edges(view, scene, team):
    """Yield the edges of the graph, from the body of the sender to that of the receiver."""
    table = np.array(list(scene.edges), dtype=float).reshape(-1, 3)
    receiver, sender = table[:, :2].astype(int).T
    height = 0.5 * np.array([kind.body.height for kind in scene.kinds])
    middle = scene.place + np.outer(height, (0.0, 0.0, 1.0))
    segments = np.stack([middle[sender], middle[receiver]], axis=1)
    known = np.isfinite(segments).all(axis=(1, 2))
    seen, left = clipped_segments(view.seen(segments[known]))
    begin, end = np.moveaxis(view.screen(seen), 1, 0)
    weight = table[known, 2][left]
    apart = end - begin
    length = np.maximum(np.hypot(*apart.T), 1e-9)
    bodies = [team.size[ends[known]][left] / length for ends in (sender, receiver)]
    first, last = (apart * np.minimum(each, MOST_HIDDEN)[:, np.newaxis] for each in bodies)
    begin, end = begin + first, end - last
    colour = (*view.palette.lines, 0.75)
    yield from signs.edges(begin, end, weight, colour, scene.directed)


def _starts(view, scene):
    """Return a dot where each trail begins, but below a robot that is still there."""
    rows = [row for row, trail in enumerate(scene.trails) if len(trail)]
    if not rows:
        return None
    first = np.array([scene.trails[row][0] for row in rows])
    away = np.linalg.norm(first - scene.place[rows], axis=1)
    first = first[~(away < reaches(scene.kinds)[rows])]
    places = _ahead(view, first)[0]
    return signs.starts(places, len(scene.kinds)) if len(places) else None


def _targets(view, scene, team):
    """Return a cross at each target, in its robot's colour, but below a robot that is there."""
    if scene.targets is None:
        return None
    places, ahead = _ahead(view, scene.targets)
    away = np.hypot(*(places - team.screen[ahead]).T)
    shown = ~(team.inside[ahead] & (away < COVERED * team.size[ahead]))
    places, shades = places[shown], np.asarray(scene.shades)[ahead][shown]
    return signs.crosses(places, shades, view.palette.text, len(ahead)) if len(places) else None


def _ahead(view, points):
    """Return where those ``points`` (m, 3) [m] that are ahead of the eye are in the picture, and which."""
    seen = view.seen(points)
    ahead = seen[:, 2] > NEAR  # not so of what is not known: NaN
    return view.screen(seen[ahead]), ahead
