"""The bodies of a scene from straight above, for maps: robots, their arms, their load, obstacles.

They are the bodies that ``scene`` draws in space.  Each convex part is one polygon: its outline.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.pictures.arms import (
    DARK,
    LIGHT,
    WOOD,
    arm_outlines,
    convex_hull,
    load_outline,
    scene_arms,
)
from mrs_simulator.pictures.drawing import Polygons, taken, with_opacity
from mrs_simulator.pictures.solids import TOUCH, arrow_on, kind_parts, own_shares, solid_of
from mrs_simulator.scenario.surroundings.obstacles import Cylinder, corners, is_flat
from mrs_simulator.state.columns import FRESH

# [-] share of the text's colour in lines around parts, and in a robot's other parts
RIM, PART = 0.35, 0.25
SEEN_THROUGH = 0.55  # [-] opacity of a load: robots below it are seen
PALE = 0.4  # [-] opacity of robots without recent data
ON_DARK, ON_LIGHT = (0.95, 0.95, 0.95), (0.12, 0.12, 0.12)  # colours of arrows
ROUND = np.linspace(0.0, 2.0 * np.pi, 96, endpoint=False)  # [rad] corners of what is round
# [-] shares of the text's colour in obstacles and in the lines around them, and in land, which is lighter.
STANDING, LAND = (0.25, 0.55), (0.08, 0.3)
LIGHT_SHADE = 1.5  # [-] of red, green and blue together


class Plan(NamedTuple):
    """One kind from above: p polygons from the lowest part to the highest, then an arrow ahead."""

    points: Any  # (v, 2) [m], robot's frame
    counts: Any  # (p + 1,)
    colours: Any  # (p + 1, 3)
    own: Any  # (p + 1,) bool: in the robot's own colour
    arrow: Any  # (p + 1,) bool: the last one


class _Layer(NamedTuple):
    """Polygons at heights by which they hide each other."""

    points: Any  # (v, 2) [m]
    counts: Any  # (m,)
    colours: Any  # (m, 4)
    rims: Any  # (m, 4)
    heights: Any  # (m,) [m]


@functools.lru_cache(maxsize=64)
def kind_plan(kind):
    """Return the ``Plan`` of a ``Kind``, without parts that lie below a single other one."""
    parts = kind_parts(kind)
    solids = [solid_of(part) for part in parts]
    own = own_shares(parts, solids) > 0.0
    order = np.argsort([solid.vertices[:, 2].max() for solid in solids], kind="stable")
    outlines = [convex_hull(solids[place].vertices[:, :2]) for place in order]
    hidden = [
        any(_covers(other, outline) for other in outlines[place + 1 :])
        for place, outline in enumerate(outlines)
    ]
    order = order[~np.array(hidden)]
    outlines = [outline for outline, is_hidden in zip(outlines, hidden) if not is_hidden]
    outlines.append(arrow_on([solid for solid, is_own in zip(solids, own) if is_own])[:, :2])
    return Plan(
        np.concatenate(outlines),
        np.array([len(outline) for outline in outlines]),
        np.array([parts[place].colour[:3] for place in order] + [ON_DARK]),
        np.append(own[order], False),
        np.arange(len(outlines)) == len(outlines) - 1,
    )


def _covers(outline, points):
    """Return whether all ``points`` (k, 2) are within a convex ``outline`` (h, 2), counter-clockwise."""
    x, y = (np.roll(outline, -1, axis=0) - outline).T
    apart = points[:, np.newaxis] - outline
    return bool((x * apart[..., 1] - y * apart[..., 0] >= -TOUCH).all())


def bodies(scene, to_screen, shown, text=(0.0, 0.0, 0.0)):
    """Return the ``Polygons`` of robots, their arms and load; None without any.

    ``to_screen``: returns points (v, 2) [m] in pixels; ``shown`` (n,) bool: which robots; of the others
    there are the arms alone; ``text`` (3,): a colour that differs from the ground's.
    """
    text = np.asarray(text)
    found = [*_robots(scene, shown, text), *_arms(scene), *_load(scene, text)]
    if not any(len(each.counts) for each in found):
        return None
    points, counts, colours, rims, heights = (np.concatenate(each) for each in zip(*found))
    if np.ptp(heights) > 0.0:
        order = np.argsort(heights, kind="stable")
        points, counts = taken(points, counts, order), counts[order]
        colours, rims = colours[order], rims[order]
    return Polygons(to_screen(points), counts, colours, rims)


def obstacle_outline(obstacle):
    """Return the outline (k, 2) [m] of an obstacle."""
    if isinstance(obstacle, Cylinder):
        return np.stack(cos_sin(ROUND), axis=1) * obstacle.radius + [obstacle.x, obstacle.y]
    return corners(obstacle)


def obstacle_bodies(obstacles, to_screen, base, text):
    """Return the ``Polygons`` of ``obstacles``; None without any.

    ``to_screen``: as of :func:`bodies`; ``base``, ``text`` (3,): the ground's colour, and one that differs.
    """
    if not obstacles:
        return None
    outlines = [obstacle_outline(obstacle) for obstacle in obstacles]
    shares = np.array([LAND if is_flat(obstacle) else STANDING for obstacle in obstacles])
    mixed = _mixed(np.asarray(base), np.asarray(text), shares[..., np.newaxis])  # (m, 2, 3)
    colours, rims = (with_opacity(each, 1.0) for each in (mixed[:, 0], mixed[:, 1]))
    counts = np.array([len(outline) for outline in outlines])
    return Polygons(to_screen(np.concatenate(outlines)), counts, colours, rims)


@functools.lru_cache(maxsize=64)
def _team_plan(kinds):
    """Return the ``Plan`` of all robots, and the rows of robots of its points (v,) and polygons (m,)."""
    plans = [kind_plan(kind) for kind in kinds]
    whole = Plan(*map(np.concatenate, zip(*plans)))
    rows = np.arange(len(plans))
    of_points = np.repeat(rows, [len(plan.points) for plan in plans])
    return whole, of_points, np.repeat(rows, [len(plan.counts) for plan in plans])


def _robots(scene, shown, text):
    state, shades = scene.state, np.asarray(scene.shades)
    known = shown & np.isfinite(state.pose).all(axis=1) & np.isfinite(state.heights)
    if not known.any():
        return
    plan, of_points, rows = _team_plan(scene.kinds)
    cos, sin = (each[of_points] for each in cos_sin(state.pose[:, 2]))
    x, y = plan.points.T
    points = np.stack([cos * x - sin * y, sin * x + cos * y], axis=1) + state.pose[of_points, :2]
    own = plan.own[:, np.newaxis]
    colours = np.empty((len(rows), 4))
    colours[:, :3] = np.where(own, shades[rows], _mixed(plan.colours, text, PART))
    is_light = (shades.sum(axis=1) >= LIGHT_SHADE)[rows, np.newaxis]
    colours[plan.arrow, :3] = np.where(is_light, ON_LIGHT, ON_DARK)[plan.arrow]
    colours[:, 3] = np.where(state.fresh, 1.0, PALE)[rows] if state.has(FRESH) else 1.0
    rims = np.where(own, _rims(colours, text), 0.0)
    found = _Layer(points, plan.counts, colours, rims, state.heights[rows])
    if known.all():
        yield found
    else:
        yield _Layer(points[known[of_points]], *(each[known[rows]] for each in found[1:]))


def _arms(scene):
    for arms in scene_arms(scene):
        outlines = np.array([arm_outlines(links) for links in arms.links])
        heights = arms.links[:, 1:, 2, 3]
        known = np.isfinite(outlines).all(axis=(1, 2, 3))
        points, heights = outlines[known].reshape(-1, 2), heights[known].ravel()
        colours, rims = np.tile(LIGHT, (len(heights), 1)), np.tile(DARK, (len(heights), 1))
        yield _Layer(points, np.full(len(heights), 4), colours, rims, heights)


def _load(scene, text):
    if scene.carried is not None:
        load, state = scene.carried
        outline, wood = load_outline(load, state), with_opacity([WOOD[:3]], SEEN_THROUGH)
        yield _Layer(outline, np.array([len(outline)]), wood, _rims(wood, text), state.place[2:])


def _rims(colours, text):
    return np.column_stack([_mixed(colours[:, :3], text, RIM), colours[:, 3]])


def _mixed(colours, other, share):
    return colours + share * (other - colours)
