"""Draws sensor readings: sonar cones, laser rays, lines to detected robots, and pressed bumpers.

Each ``draw_`` function gets a painter, the ``MapStyle`` of the widget, the ``Frame``, a robot's pose (3,),
its colour, and the reading.
"""

import math

import numpy as np

from mrs_simulator.rqt_plugin.map.marks import ALARM
from mrs_simulator.rqt_plugin.map.style import faded, polygon
from mrs_simulator.rqt_plugin.qt.QtCore import QPointF, QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QPainterPath, QPen
from mrs_simulator.sensors.types.bumper import BumperReading
from mrs_simulator.sensors.types.range_bearing import RangeBearingReading
from mrs_simulator.sensors.types.ranging import RangeReading

DRAWN = ("sonar", "laser", "range_bearing", "bumper")  # types of sensors that are drawn
MOST_ROBOTS = 12  # [-] whose sensors are drawn; of larger teams only those of the robot selected
FELT, SILENT = 0.15, 0.04  # opacities of where something was met, and of where nothing was
HIT = 1.6  # [px] radius of a point that a ray has met


def draw_reading(painter, style, frame, pose, body, shade, reading, whole=True):
    """Draw one ``reading``; ``body``: reach of the robot and how far ahead its middle lies [m].

    ``whole``: where nothing was met, too.
    """
    if isinstance(reading, RangeReading):
        draw = draw_cones if reading.cone > 0.0 else draw_rays
        draw(painter, style, frame, pose, shade, reading, whole)
    elif isinstance(reading, RangeBearingReading):
        draw_seen(painter, style, frame, pose, shade, reading)
    elif isinstance(reading, BumperReading):
        draw_pressed(painter, style, frame, pose, body, reading)


def signs_of(readings):
    """Return the legend's names of the signs drawn for ``readings``, a dict."""
    values = [received.reading for received in readings.values()]
    ranges = [each for each in values if isinstance(each, RangeReading)]
    signs = {"cone" if each.cone > 0.0 else "rays" for each in ranges}
    signs |= {"seen" for each in values if isinstance(each, RangeBearingReading)}
    pressed = (each for each in values if isinstance(each, BumperReading))
    return signs | {"pressed" for each in pressed if np.any(each.front) or np.any(each.rear)}


def draw_cones(painter, style, frame, pose, shade, reading, whole):
    """Draw the cone of each transducer, up to its echo with an arc there; paler without an echo."""
    origins = frame.to_screen(in_plane(pose, reading.places[:, :2]))
    headings = np.degrees(pose[2] + reading.places[:, 2])
    half = math.degrees(reading.cone)
    for (x, y), heading, far in zip(origins.tolist(), headings.tolist(), reading.ranges.tolist()):
        has_echo = math.isfinite(far)
        if math.isnan(far) or not (has_echo or whole):
            continue
        radius = (far if has_echo else reading.most) * frame.scale
        box = QRectF(x - radius, y - radius, 2.0 * radius, 2.0 * radius)
        cone = QPainterPath(QPointF(x, y))
        cone.arcTo(box, heading - half, 2.0 * half)
        cone.closeSubpath()
        painter.fillPath(cone, faded(shade, FELT if has_echo else SILENT))
        if has_echo:
            painter.setPen(QPen(shade, 1.6 * style.unit))
            painter.drawArc(box, round(16 * (heading - half)), round(32 * half))


def draw_rays(painter, style, frame, pose, shade, reading, whole):
    """Draw the area that rays have crossed, and a point where each has met something."""
    ranges = np.asarray(reading.ranges, dtype=float)
    met = np.isfinite(ranges)
    free = reading.most if whole else 0.0
    reached = np.where(met, ranges, np.where(np.isnan(ranges), 0.0, free))
    points = frame.to_screen(in_plane(pose, reading._replace(ranges=reached).points))
    origin = frame.to_screen(in_plane(pose, reading.places[:1, :2]))
    painter.setPen(Qt.NoPen)
    painter.setBrush(faded(shade, 2.0 * SILENT))
    painter.drawPolygon(polygon(np.concatenate([origin, points])))
    painter.setBrush(shade)
    radius = HIT * style.unit
    for x, y in points[met].tolist():
        painter.drawEllipse(QPointF(x, y), radius, radius)


def draw_seen(painter, style, frame, pose, shade, reading):
    """Draw a line to the measured position of each robot, and a ring there."""
    begin = QPointF(*frame.to_screen(in_plane(pose, np.array([reading.place])))[0].tolist())
    painter.setPen(QPen(shade, 1.2 * style.unit, Qt.DotLine))
    painter.setBrush(Qt.NoBrush)
    for x, y in frame.to_screen(in_plane(pose, reading.points)).tolist():
        painter.drawLine(begin, QPointF(x, y))
        painter.drawEllipse(QPointF(x, y), 3.0 * style.unit, 3.0 * style.unit)


def draw_pressed(painter, style, frame, pose, body, reading):
    """Draw a red arc about the robot at each section of its bumpers that is pressed."""
    reach, ahead = body
    x, y = frame.to_screen(in_plane(pose, np.array([[ahead, 0.0]])))[0].tolist()
    radius = max(1.1 * reach * frame.scale, 9.0 * style.unit)
    box = QRectF(x - radius, y - radius, 2.0 * radius, 2.0 * radius)
    pen = QPen(QColor(ALARM), 3.5 * style.unit)
    pen.setCapStyle(Qt.FlatCap)
    painter.setPen(pen)
    heading = math.degrees(pose[2])
    # Front sections go clockwise from the left, those behind counterclockwise.
    for sections, turn in ((reading.front, -1.0), (reading.rear, 1.0)):
        for k in np.flatnonzero(sections).tolist():
            width = 180.0 / len(sections)
            begin = heading + 90.0 + turn * k * width
            painter.drawArc(box, round(16 * begin), round(16 * turn * width))


def in_plane(pose, points):
    """Return ``points`` (k, 2) [m] of the robot's frame in the common frame, the robot at ``pose`` (3,)."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    x, y = np.asarray(points, dtype=float).T
    return np.column_stack([pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y])
