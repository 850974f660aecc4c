"""The ground of a picture: a grid of known width that fades with the distance, and the horizon."""

import math

import numpy as np

from mrs_simulator.pictures.camera import clipped_polygon
from mrs_simulator.pictures.drawing import Polygons, with_opacity
from mrs_simulator.scenario.surroundings.obstacles import corners

# [-] grid lines to each side of the target, and parts of each line to fade it
REACH, PIECES = 30, 20
WIDTH = 55.0  # [px] between two lines at the target, at least
STRENGTH, ON_WATER = 0.45, 0.55  # [-] opacity of the nearest lines
STEPS = 6  # [-] of fading: lines of one colour are painted together


def step(view):
    """Return the distance [m] of the grid's lines: 1, 2 or 5 times a power of ten."""
    least = WIDTH * view.camera.distance / view.scale
    power = 10.0 ** math.floor(math.log10(least))
    return next(each * power for each in (1.0, 2.0, 5.0, 10.0) if each * power >= least)


def grid(view, water):
    """Return the grid's lines about the camera's target."""
    wide, target = step(view), np.asarray(view.camera.target[:2])
    middle = wide * np.round(target / wide)[:, np.newaxis]
    across = middle + wide * np.arange(-REACH, REACH + 1)
    along = middle + wide * np.linspace(-REACH, REACH, PIECES + 1)
    segments = np.concatenate([_parallels(across, along, axis) for axis in (0, 1)])
    away = np.linalg.norm(segments.mean(axis=1)[:, :2] - target, axis=1)
    strength = np.ceil(STEPS * np.clip(1.0 - away / (REACH * wide), 0.0, 1.0)) / STEPS
    left = strength > 0.0
    colours = np.tile(view.palette.lines, (int(left.sum()), 1))
    opacity = (ON_WATER if water else STRENGTH) * strength[left]
    return view.lines(segments[left], with_opacity(colours, opacity), 1.0)


def land(view, obstacles):
    """Return the ground of flat boxes, land in the water; None where none is in view."""
    points, counts = [], []
    for box in obstacles:
        seen = clipped_polygon(view.seen(np.column_stack([corners(box), np.zeros(4)])))
        if len(seen):
            points.append(view.screen(seen))
            counts.append(len(seen))
    if not counts:
        return None
    colours = with_opacity(np.tile(view.palette.ground, (len(counts), 1)), 1.0)
    return Polygons(np.concatenate(points), np.array(counts), colours, colours)


def _parallels(across, along, axis):
    """Return the pieces (m, 2, 3) [m] of the lines at ``across`` of one ``axis``."""
    ends = np.stack([along[1 - axis][:-1], along[1 - axis][1:]], axis=1)
    lines = np.zeros((across.shape[1], len(ends), 2, 3))
    lines[..., axis] = across[axis][:, np.newaxis, np.newaxis]
    lines[..., 1 - axis] = ends
    return lines.reshape(-1, 2, 3)


def sky(view):
    """Return the sky; None where the camera looks below the horizon."""
    horizon = 0.5 * view.height - view.scale * math.tan(math.radians(-view.camera.pitch))
    if horizon <= 0.0:
        return None
    corners = [(0.0, 0.0), (view.width, 0.0), (view.width, horizon), (0.0, horizon)]
    colour = with_opacity([view.palette.sky], 1.0)
    return Polygons(np.array(corners), np.array([4]), colour, colour)


def unit(view):
    """Return a text with the grid's spacing."""
    place = np.array([(8.0, view.height - 12.0)])
    return view.texts(place, ("grid {:g} m".format(step(view)),), left=True)
