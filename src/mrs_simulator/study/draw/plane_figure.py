"""Robots' paths in the plane, with obstacles, starts and final poses."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import MaxNLocator

from mrs_simulator.core.neighbours import least_distance
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.scenario.surroundings.moving_obstacles import moves, obstacles_at
from mrs_simulator.scenario.surroundings.obstacles import corners, is_flat, with_obstacles
from mrs_simulator.study.draw.canvas import WIDTH, styled
from mrs_simulator.study.draw.figure_parts import (
    LEAST_EXTENT,
    PALETTE,
    START_COLOUR,
    draw_alike,
    emptied,
    extremes,
    legend_above,
    most_points,
    points_of,
    predicted_of,
    sized,
)

# in a legend, after paths
NAMED = "Theory", "Final pose", "Land", "Obstacle", "Arena", "Collision"
TRAJECTORY_COLOUR = "#1a8a34"
# Of paths; several where there are more kinds than colours.
DASHES = (0, (4, 2)), (0, (6, 1.5, 1, 1.5)), (0, (1.5, 1.5)), (0, (10, 2))
FINAL_COLOUR = "#0b3d91"
OBSTACLE_COLOUR, LAND_COLOUR = "#b8b8b8", "#f1ede2"
MOST_NUMBERED = 200  # above it the numbers at the starts would hide each other
TRAJECTORIES_HEIGHT = (3.2, 5.8)  # [in], least and most
ROBOT_LENGTH = 0.5  # [m], of the robot drawn at its final pose
ROBOT_SHARE = (0.012, 0.022)  # its least length as a share of the drawing: always, and with room
ROBOT_SHAPE = ((0.6, 0.0), (-0.4, 0.38), (-0.2, 0.0), (-0.4, -0.38))  # of length 1, heading along x
MARGIN = 0.08  # around all that is drawn, as a share of its larger side
REACH = 0.5  # how far around the team obstacles are drawn, as a share of its larger side


@styled
def draw_trajectories(figure, run, prediction=None, axes=None, others=()):
    """Draw the robots' paths in the plane on ``axes``, or on ``figure``, emptied first; return the axes.

    ``others``: further ``Run``s that are drawn there afterwards, in lines of their own, as this run's paths
    are, for which room is left.
    """
    axes = emptied(figure, 1)[0] if axes is None else axes
    points = points_of(run, prediction)
    _draw_obstacles(axes, run)
    paths = () if others else _draw_paths(axes, points, run.kinds)
    if prediction is not None:
        _draw_predicted_paths(axes, predicted_of(run, prediction)[1][:, :, :2])
    low, high = _extent(run, prediction, others)
    _draw_final_poses(axes, points[-1], run.pose[-1, :, 2], np.max(high - low))
    _draw_starts(axes, run.robots, points)
    _draw_collisions(axes, run)
    _frame_plane(axes, low, high)
    legend_above(axes, ("Start", *paths, *NAMED))
    return axes


def draw_ground(axes, run):
    """Draw obstacles and frame the plane as ``draw_trajectories`` does.

    Return its corners (2,) [m], and ``(obstacle, patch)`` of each obstacle that moves, for ``move``.
    """
    moving = _draw_obstacles(axes, run)
    low, high = _extent(run, None)
    _frame_plane(axes, low, high)
    return low, high, moving


def trajectories_height(run, prediction=None, page=WIDTH, others=()):
    """Return the height [in] at which a figure of width ``page`` [in] shows the plane without waste."""
    low, high = _extent(run, prediction, others)
    width, height = (high - low) + 2.0 * MARGIN * np.max(high - low)
    bounds = np.array(TRAJECTORIES_HEIGHT) * max(0.62, page / WIDTH)
    return float(np.clip((page - 0.7) * height / width + 0.8, *bounds))


def _draw_paths(axes, points, kinds):
    """Draw the paths, each of several ``kinds``, names (n,), in a look of its own; return their labels."""
    style = {"color": TRAJECTORY_COLOUR, "ls": DASHES[0], "lw": sized(points, 1.2, 0.7)}
    paths, names = _thin_paths(points), tuple(dict.fromkeys(kinds))
    if len(names) < 2:
        draw_alike(axes, paths, "Trajectory", **style)
        return ("Trajectory",)
    for place, name in enumerate(names):
        dash, colour = divmod(place, len(PALETTE))
        style.update(color=PALETTE[colour], ls=DASHES[dash % len(DASHES)])
        draw_alike(axes, paths[np.array(kinds) == name], name, **style)
    return names


def _draw_predicted_paths(axes, hand):
    style = {"color": "k", "ls": (0, (3, 5)), "lw": sized(hand, 0.9, 0.5)}
    draw_alike(axes, _thin_paths(hand), "Theory", **style)


def _thin_paths(points):
    """Return the paths (n, 2, p) of ``points`` (m, n, 2), p no more than a drawing needs."""
    count = min(len(points), most_points(points.shape[1]))
    chosen = np.unique(np.linspace(0, len(points) - 1, count).round().astype(int))
    return points[chosen].transpose(1, 2, 0)


def _draw_final_poses(axes, points, theta, extent):
    """Draw each robot as an arrow head centred on its final point (n, 2), along its heading."""
    shapes = robot_shapes(points, theta, robot_length(points, extent))
    robots = PolyCollection(shapes, zorder=4)
    robots.set(facecolor=FINAL_COLOUR, edgecolor="none")
    axes.add_collection(robots)
    # The legend shows a robot, not the coloured box that it makes of a collection.
    look = {"marker": ROBOT_SHAPE, "ms": 9, "mew": 0, "color": FINAL_COLOUR}
    axes.plot([], [], ls="", label="Final pose", **look)


def robot_shapes(points, theta, length):
    """Return the corners (n, 4, 2) [m] of arrow heads ``length`` [m] long at ``points`` (n, 2)."""
    shape = length * np.array(ROBOT_SHAPE)
    cos, sin = np.cos(theta), np.sin(theta)
    turned = np.empty((len(points), len(shape), 2))
    turned[:, :, 0] = np.outer(cos, shape[:, 0]) - np.outer(sin, shape[:, 1])
    turned[:, :, 1] = np.outer(sin, shape[:, 0]) + np.outer(cos, shape[:, 1])
    return turned + points[:, np.newaxis]


def robot_length(points, extent):
    """Return how long to draw a robot [m]: to scale, or longer where it could not be seen."""
    least, room = ROBOT_SHARE[0] * extent, ROBOT_SHARE[1] * extent
    if len(points) > 1:
        room = min(room, 0.8 * least_distance(points))
    return max(ROBOT_LENGTH, least, room)


def _draw_obstacles(axes, run):
    """Draw the scenario's boxes and cylinders in grey, and land, where only boats cannot go, lighter.

    Return ``(obstacle, patch)`` of each that moves, drawn where it begins.
    """
    named, moving = set(), []
    for obstacle in _obstacles(run):
        if hasattr(obstacle, "radius"):
            patch = Circle((obstacle.x, obstacle.y), obstacle.radius)
        else:
            patch = Polygon(corners(obstacle), closed=True)
        land = is_flat(obstacle)
        label = "Land" if land else "Obstacle"
        patch.set(facecolor=LAND_COLOUR if land else OBSTACLE_COLOUR, edgecolor="#7a7a7a")
        patch.set(linewidth=0.6, zorder=0.5 if land else 1)
        patch.set_label("_nolegend_" if label in named else label)
        named.add(label)
        axes.add_patch(patch)
        if moves(obstacle):
            moving.append((obstacle, patch))
            track = obstacle.track
            way = [(obstacle.x, obstacle.y), *track.to] + [(obstacle.x, obstacle.y)] * track.closed
            axes.plot(*zip(*way), color="#7a7a7a", linestyle=":", linewidth=1.0, zorder=1)
    for outline in _arena(run):
        style = {"edgecolor": "#7a7a7a", "linestyle": ":", "linewidth": 1.0, "label": "Arena"}
        axes.add_patch(Polygon(outline, closed=True, fill=False, zorder=1, **style))
    return moving


def move(moving, time):
    """Move the patches of ``moving``, as ``draw_ground`` returns it, to where they are at ``time`` [s]."""
    for obstacle, patch in moving:
        (now,) = obstacles_at((obstacle,), time)
        if hasattr(now, "radius"):
            patch.set_center((now.x, now.y))
        else:
            patch.set_xy(corners(now))


def _arena(run):
    """Return the corners, (4, 2) [m], of the arena that the safety filter keeps, in a list."""
    safety = getattr(getattr(run.scenario, "control", None), "safety", None)
    if not getattr(safety, "arena", ()):
        return []
    x_min, y_min, x_max, y_max = safety.arena
    return [np.array([[x_min, y_min], [x_max, y_min], [x_max, y_max], [x_min, y_max]])]


def _obstacles(run):
    return obstacles_of(run.scenario) if run.scenario is not None else ()


def _draw_collisions(axes, run):
    if run.collisions:
        places = np.array([(collision.x, collision.y) for collision in run.collisions])
        axes.plot(*places.T, "kx", ms=6, mew=1.4, zorder=6, label="Collision")


def _draw_starts(axes, robots, points):
    """Draw red points at the starts, each with its robot's number on the side away from its path."""
    style = {"color": START_COLOUR, "zorder": 5}
    axes.plot(*points[0].T, "o", ms=sized(points, 4.5, 2.5), label="Start", **style)
    if len(robots) > MOST_NUMBERED:
        return
    away = points[0] - points.mean(axis=0)
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    away = np.where(distance > 1e-6, away / np.maximum(distance, 1e-6), [0.0, 1.0])
    size = sized(points, 9.0, 5.0)
    style.update(textcoords="offset points", ha="center", va="center", fontsize=size)
    style["bbox"] = {"boxstyle": "square,pad=0.02", "fc": "white", "ec": "none", "alpha": 0.7}
    style["zorder"] = 4.5  # over the paths, under the points
    for robot, start, side in zip(robots, points[0], away):
        axes.annotate(str(robot), start, xytext=side * (size + 0.5), **style)


def _frame_plane(axes, low, high):
    margin = MARGIN * np.max(high - low)
    # The aspect may shrink an axis to what is drawn, but for the margin, where numbers stand.
    axes.update_datalim([low - margin, high + margin])
    # The aspect may widen limits that count as automatic; of others matplotlib 3.9 warns.
    axes.set_xlim(low[0] - margin, high[0] + margin, auto=True)
    axes.set_ylim(low[1] - margin, high[1] + margin, auto=True)
    axes.set_aspect("equal", adjustable="datalim")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
    axes.set_xlabel("$x$ [m]")
    axes.set_ylabel("$y$ [m]")


def _extent(run, prediction, others=()):
    """Return the lowest and highest (x, y) [m] of all that is drawn in the plane."""
    shown = [points_of(run, prediction), *_arena(run)]
    shown += [points_of(other, None) for other in others]
    if prediction is not None:
        shown.append(predicted_of(run, prediction)[1][:, :, :2])
    ends = [list(zip(*(extremes(part[..., axis]) for part in shown))) for axis in (0, 1)]
    low, high = np.array([(min(lows), max(highs)) for lows, highs in ends]).T
    side = max(LEAST_EXTENT, np.max(high - low))
    lacking = (side - np.max(high - low)) / 2.0
    return with_obstacles(low - lacking, high + lacking, _obstacles(run), REACH * side)
