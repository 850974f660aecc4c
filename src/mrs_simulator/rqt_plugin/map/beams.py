"""Sensor readings in space: the rays of lasers and sonars up to what they met, and what cameras see."""

import math

import numpy as np

from mrs_simulator.pictures.scene import Beams
from mrs_simulator.rqt_plugin.map.sensor_drawing import in_plane
from mrs_simulator.sensors.types.range_bearing import RangeBearingReading
from mrs_simulator.sensors.types.ranging import RangeReading

MOST_RAYS = 60  # [-] of one reading that are drawn; hits are drawn all
ARC = 6  # [-] pieces of a cone's arc
# [-] opacity: of rays with and without an echo, of a camera's view
MET, FREE, VIEW = 0.4, 0.12, 0.45
SEEN = 1.5  # [m] along a camera's axis, that of its view is drawn at most


def of_reading(pose, height, reading, shade, whole):
    """Return the ``Beams`` of a robot's ``reading``, None for one that is not drawn in space.

    ``pose`` (3,) of the robot; ``height`` [m] of its sensor; ``whole``: rays without an echo, too.
    """
    if isinstance(reading, RangeReading):
        rays = _cones(reading, whole) if reading.cone > 0.0 else _rays(reading, whole)
    elif isinstance(reading, RangeBearingReading):
        points = reading.points[np.isfinite(reading.points).all(axis=1)]
        begin = np.broadcast_to(reading.place, points.shape)
        rays = np.stack([begin, points], axis=1), np.full(len(points), MET), points
    else:
        return None
    segments, opacity, hits = rays
    placed = in_plane(pose, segments.reshape(-1, 2)), in_plane(pose, hits)
    ends, hits = (np.column_stack([each, np.full(len(each), height)]) for each in placed)
    return Beams(ends.reshape(-1, 2, 3), opacity, hits, shade)


def _reached(reading, whole):
    """Return the ranges (K,) [m] up to which rays are drawn, NaN for none, and which met something."""
    ranges = np.asarray(reading.ranges, dtype=float)
    met = np.isfinite(ranges)
    return np.where(met, ranges, np.where(np.isinf(ranges) & whole, reading.most, np.nan)), met


def _rays(reading, whole):
    reached, met = _reached(reading, whole)
    points = reading._replace(ranges=reached).points
    begins = np.broadcast_to(reading.places[:, :2], points.shape)
    segments = np.stack([begins, points], axis=1)
    stride = -(-len(reached) // MOST_RAYS)
    drawn = np.isfinite(reached) & (np.arange(len(reached)) % stride == 0)
    return segments[drawn], np.where(met, MET, FREE)[drawn], points[met]


def _cones(reading, whole):
    """Return the sides of each cone and the arc at its end as rays; no hits, whose place is not known."""
    reached, met = _reached(reading, whole)
    turns = np.linspace(-reading.cone, reading.cone, ARC + 1)
    segments, opacity = [np.empty((0, 2, 2))], [np.empty(0)]
    for far, has_echo, (x, y, way) in zip(reached, met, reading.places):
        if not np.isfinite(far):
            continue
        arc = (x, y) + far * np.column_stack([np.cos(way + turns), np.sin(way + turns)])
        corners = np.concatenate([[(x, y)], arc, [(x, y)]])
        segments.append(np.stack([corners[:-1], corners[1:]], axis=1))
        opacity.append(np.full(len(corners) - 1, MET if has_echo else FREE))
    return np.concatenate(segments), np.concatenate(opacity), np.empty((0, 2))


def of_camera(pose, altitude, mount, shade):
    """Return the ``Beams`` along the edges of what the camera of a ``Mount`` sees, level as it stands.

    ``pose`` (3,) and ``altitude`` [m] of the robot.
    """
    settings, (x, y, z, yaw) = mount.settings, mount.place
    far, half = min(settings.most, SEEN), math.tan(0.5 * settings.view)
    tall = half * settings.height / settings.width
    across, up = far * half * np.array([1, -1, -1, 1]), far * tall * np.array([1, 1, -1, -1])
    cos, sin = math.cos(settings.down), math.sin(settings.down)
    ahead, above = far * cos + up * sin, up * cos - far * sin
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    flat = (x, y) + np.column_stack([ahead, across]) @ turn.T
    corners = np.column_stack([in_plane(pose, flat), altitude + z + above])
    eye = np.append(in_plane(pose, np.array([(x, y)]))[0], altitude + z)
    edges = np.stack([np.broadcast_to(eye, corners.shape), corners], axis=1)
    rim = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    segments = np.concatenate([edges, rim])
    return Beams(segments, np.full(len(segments), VIEW), np.empty((0, 3)), shade)
