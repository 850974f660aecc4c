"""What the map draws: the grid, obstacles, trails, robots, edges.

Each ``draw_`` function gets a painter, the ``Look`` of the widget and the ``Frame``; positions are
arrays, one point per row, in metres unless they are said to be on the screen [px].
"""

import math
from typing import NamedTuple

import numpy as np
from python_qt_binding.QtCore import QLineF, QPointF, QRect, QRectF, Qt
from python_qt_binding.QtGui import QBrush, QColor, QFont, QPainterPath, QPen, QPolygonF

from mrs_simulator.core.obstacles import Cylinder
from mrs_simulator.report.figures import START_COLOUR
from mrs_simulator.rqt_plugin.colours import colour
from mrs_simulator.rqt_plugin.map_geometry import (
    REACH,
    are_arrows,
    clearance,
    nice_step,
    outlines,
    placed,
)
from mrs_simulator.world.robots import pioneer3dx as pioneer

SOME_ROBOTS = 30  # [-] in view; beyond, marks and numbers are smaller
MANY_TRAILS = 120  # [-] in view; beyond, they are thin and not dashed
MANY_ROBOTS = 200  # [-] in view; beyond, they are drawn in one go
SOME_EDGES = 30  # [-] in view; beyond, they are paler
MANY_EDGES = 400  # [-] in view; beyond, they are drawn without smoothing
MOST_EDGES = 4000  # [-] drawn
EDGE_WIDTHS = (0.7, 6.0)  # [px], least and most; one of weight 1 is EDGE_WIDTH wide
EDGE_WIDTH = 1.4  # [px]

NOSE = ((0.175, 0.0), (0.055, 0.095), (0.055, -0.095))  # [m], the heading mark
TYRE = 0.05  # [m], its width
DETAILED_ROBOT = 22.0  # [px], the least that shows its wheels
FLASH = 2.0  # [s], how long a collision's ring is seen
HINT_FLAGS = int(Qt.AlignLeft | Qt.AlignTop | Qt.TextWordWrap)
DASHES = (5.0, 3.0)  # [-] of a trail, in widths of its line
ALARM = "#e01b24"


class Look(NamedTuple):
    """Colours and sizes of a widget."""

    base: QColor
    text: QColor
    highlight: QColor
    unit: float  # [px], 1 at the usual size of the font
    line: float  # [px], height of a line of text

    @classmethod
    def of(cls, widget):
        """Return the look that the palette and font of ``widget`` ask for."""
        palette, line = widget.palette(), widget.fontMetrics().height()
        base, text, highlight = palette.base(), palette.text(), palette.highlight()
        unit = max(1.0, line / 16.0)
        return cls(base.color(), text.color(), highlight.color(), unit, float(line))

    def mixed(self, share):
        """Return the colour that is ``share`` text and the rest background."""
        return mixed(self.base, self.text, share)

    def shade(self, number):
        """Return the colour of robot ``number``, lighter on a dark ground."""
        dark = self.base.lightness() < 128
        return mixed(colour(number), self.text, 0.22) if dark else colour(number)


def mixed(first, second, share):
    """Return the colour between ``first`` (share 0) and ``second`` (share 1)."""
    pairs = zip(first.getRgb()[:3], second.getRgb()[:3])
    return QColor(*(int(round(a + share * (b - a))) for a, b in pairs))


def faded(shade, opacity):
    """Return a copy of the colour ``shade`` with ``opacity`` between 0 and 1."""
    shade = QColor(shade)
    shade.setAlphaF(min(1.0, max(0.0, opacity)))
    return shade


# Shapes on the screen


def polygon(points):
    """Return ``points`` (m, 2) as a ``QPolygonF``."""
    result = QPolygonF(len(points))
    try:
        memory = result.data()
        memory.setsize(16 * len(points))
        np.frombuffer(memory, dtype=float).reshape(-1, 2)[:] = points
    except (AttributeError, TypeError, ValueError):  # bindings that do not show the memory
        result = QPolygonF([QPointF(x, y) for x, y in np.asarray(points).tolist()])
    return result


# The ground


def plot_area(widget, hint):
    """Return the part of ``widget`` that shows the plane; about it are axes, labels and ``hint``."""
    metrics, line = widget.fontMetrics(), widget.fontMetrics().height()
    left = metrics.horizontalAdvance("\u221200.0") + 1.6 * line
    top = 0.7 * line + _hint_height(metrics, widget.width(), hint)
    area = QRectF(widget.rect()).adjusted(left, top, -0.9 * line, -2.7 * line)
    return QRectF(area.x(), area.y(), max(1.0, area.width()), max(1.0, area.height()))


def _hint_height(metrics, width, hint):
    if not hint:
        return 0
    room = QRect(0, 0, int(width - 1.2 * metrics.height()), 100 * metrics.height())
    return metrics.boundingRect(room, HINT_FLAGS, hint).height()


def draw_grid(painter, look, frame):
    """Draw the lines of the grid, those through the origin a little stronger."""
    step, ticks = _ticks(frame, look)
    area = frame.area
    painter.setRenderHint(painter.Antialiasing, False)
    for axis in (0, 1):
        for tick in ticks[axis]:
            at = frame.to_screen(np.full(2, tick * step))[axis]
            painter.setPen(QPen(look.mixed(0.11 if tick else 0.3), 1))
            if axis:
                painter.drawLine(QLineF(area.left(), at, area.right(), at))
            else:
                painter.drawLine(QLineF(at, area.top(), at, area.bottom()))
    painter.setRenderHint(painter.Antialiasing, True)


def _ticks(frame, look):
    step = nice_step(4.2 * look.line / frame.scale)
    low, high = frame.bounds()
    return step, [
        range(math.ceil(begin / step), math.floor(end / step) + 1) for begin, end in zip(low, high)
    ]


def draw_axes(painter, look, frame):
    """Draw the frame about the area, its labels and the axes' names."""
    area, line = frame.area, look.line
    step, ticks = _ticks(frame, look)
    digits = max(0, -math.floor(math.log10(step) + 1e-9))
    painter.setPen(QPen(look.mixed(0.6), 1))
    painter.setBrush(Qt.NoBrush)
    painter.drawRect(QRectF(area.toRect()))
    painter.setPen(look.mixed(0.85))
    for tick in ticks[0]:
        x = frame.to_screen(np.full(2, tick * step))[0]
        box = QRectF(x - 4 * line, area.bottom() + 0.2 * line, 8 * line, line)
        painter.drawText(box, Qt.AlignCenter, _label(tick * step, digits))
    for tick in ticks[1]:
        y = frame.to_screen(np.full(2, tick * step))[1]
        box = QRectF(1.3 * line, y - 0.5 * line, area.left() - 1.65 * line, line)
        _draw_fitted(painter, box, _label(tick * step, digits))
    below = QRectF(area.left(), area.bottom() + 1.3 * line, area.width(), 1.2 * line)
    painter.drawText(below, Qt.AlignCenter, "x [m]")
    painter.save()
    painter.translate(0.25 * line, area.center().y())
    painter.rotate(-90.0)
    painter.drawText(QRectF(-4 * line, 0.0, 8 * line, 1.2 * line), Qt.AlignCenter, "y [m]")
    painter.restore()


def _label(value, digits):
    return "{:.{}f}".format(value, digits).replace("-", "\u2212")


def _draw_fitted(painter, box, text):
    """Draw ``text`` at the right of ``box``, in smaller letters where it is too long."""
    needed = painter.fontMetrics().horizontalAdvance(text)
    usual = painter.font()
    if needed > box.width():
        smaller = QFont(usual)
        smaller.setPointSizeF(max(1.0, painter.fontInfo().pointSizeF() * box.width() / needed))
        painter.setFont(smaller)
    painter.drawText(box, Qt.AlignRight | Qt.AlignVCenter, text)
    painter.setFont(usual)


def draw_scale_bar(painter, look, frame):
    """Draw a bar of a round length in the lower right corner."""
    area, line = frame.area, look.line
    length = nice_step(0.08 * area.width() / frame.scale)
    width, right, bottom = length * frame.scale, area.right() - 0.8 * line, area.bottom() - line
    label = "{:g} m".format(length) if length < 1e3 else "{:g} km".format(length / 1000.0)
    box = QRectF(right - width, bottom - 1.5 * line, width, 1.4 * line)
    painter.fillRect(box.adjusted(-0.4 * line, 0.0, 0.4 * line, 0.5 * line), faded(look.base, 0.8))
    painter.setPen(QPen(look.text, 1.5 * look.unit))
    painter.drawLine(QLineF(right - width, bottom, right, bottom))
    for x in (right - width, right):
        painter.drawLine(QLineF(x, bottom - 0.25 * line, x, bottom + 0.25 * line))
    painter.drawText(box.adjusted(-3 * line, 0, 3 * line, 0), Qt.AlignCenter, label)


def draw_hint(painter, look, frame, hint):
    """Draw ``hint``, what the mouse does, above the area."""
    right, bottom = frame.area.right() + 0.9 * look.line, frame.area.top() - 0.3 * look.line
    box = QRectF(0.6 * look.line, 0.3 * look.line, right - 1.2 * look.line, bottom)
    painter.setPen(look.mixed(0.75))
    painter.drawText(box, HINT_FLAGS, hint)


def draw_remark(painter, look, frame, remark):
    """Draw ``remark`` in the upper left corner."""
    line = look.line
    box = QRectF(frame.area.left() + 0.4 * line, frame.area.top() + 0.4 * line, 0.0, 1.25 * line)
    box.setWidth(painter.fontMetrics().horizontalAdvance(remark) + 0.8 * line)
    painter.fillRect(box, faded(look.base, 0.85))
    painter.setPen(look.mixed(0.75))
    painter.drawText(box, Qt.AlignCenter, remark)


def draw_obstacles(painter, look, frame, obstacles):
    """Draw boxes and cylinders to scale."""
    painter.setPen(QPen(look.mixed(0.55), look.unit))
    painter.setBrush(look.mixed(0.25))
    for obstacle in obstacles:
        middle = QPointF(*frame.to_screen((obstacle.x, obstacle.y)))
        if isinstance(obstacle, Cylinder):
            radius = obstacle.radius * frame.scale
            painter.drawEllipse(middle, radius, radius)
            continue
        half = 0.5 * np.array([obstacle.length, obstacle.width])
        corners = half * [(1, 1), (-1, 1), (-1, -1), (1, -1)]
        pose = np.array([[obstacle.x, obstacle.y, obstacle.yaw]])
        painter.drawPolygon(polygon(placed(corners, pose, frame)[0]))


# The team


def draw_trails(painter, look, frame, trails, now, numbers, rows):
    """Draw the dashed trails of the robots ``rows``, on to where they are ``now`` (n, 2) or None."""
    many = len(rows) > MANY_TRAILS
    painter.setRenderHint(painter.Antialiasing, not many)
    painter.setBrush(Qt.NoBrush)
    for row in rows:
        path = trails.path(row, trails.stride(row, frame.scale))
        if now is not None and np.isfinite(now[row]).all():
            path = np.concatenate([path, now[row : row + 1]])
        line = frame.to_screen(path)
        pen = _trail_pen(look, numbers[row], many)
        for begin, end in _parts_in_view(frame, line):
            if begin and not many:  # the dashes stay where they are when the view moves
                before = np.hypot(*np.diff(line[: begin + 1], axis=0).T).sum()
                pen.setDashOffset(before / pen.widthF() % sum(DASHES))
            painter.setPen(pen)
            painter.drawPolyline(polygon(line[begin:end]))
    painter.setRenderHint(painter.Antialiasing, True)


def _trail_pen(look, number, many):
    if many:
        return QPen(mixed(look.base, look.shade(number), 0.6), 1)
    pen = QPen(look.shade(number), 1.4 * look.unit)
    pen.setDashPattern(DASHES)
    pen.setCapStyle(Qt.FlatCap)
    return pen


def _parts_in_view(frame, line):
    """Return the (begin, end) of the stretches of ``line`` (m, 2) [px] that may be seen."""
    area = frame.area
    left, top = line[:, 0] < area.left(), line[:, 1] < area.top()
    right, bottom = line[:, 0] > area.right(), line[:, 1] > area.bottom()
    outside = np.stack([left, top, right, bottom])
    if not outside.any():
        return [(0, len(line))]
    # A step with both ends beyond the same side is not seen.
    seen = ~(outside[:, :-1] & outside[:, 1:]).any(axis=0)
    turns = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(np.int8)))
    return [(begin, end + 1) for begin, end in turns.reshape(-1, 2).tolist()]


def draw_starts(painter, look, frame, starts):
    """Draw red points where the robots began."""
    screen = frame.to_screen(starts)
    radius = _by_count(len(starts), 3.0, 2.2, 1.5) * look.unit
    painter.setPen(Qt.NoPen)
    painter.setBrush(QColor(START_COLOUR))
    for x, y in screen[frame.sees(screen, 9.0)].tolist():
        painter.drawEllipse(QPointF(x, y), radius, radius)


def _by_count(count, few, more, many):
    return few if count <= SOME_ROBOTS else more if count <= MANY_ROBOTS else many


def draw_targets(painter, look, frame, targets, numbers):
    """Draw a small cross at each desired position, in the colour of its robot."""
    screen = frame.to_screen(targets)
    size = _by_count(len(targets), 4.5, 3.0, 2.0) * look.unit
    shades = numbers if len(numbers) == len(targets) else None
    for row in np.flatnonzero(frame.sees(screen, size)):
        x, y = screen[row].tolist()
        shade = look.text if shades is None else mixed(look.shade(shades[row]), look.text, 0.25)
        painter.setPen(QPen(shade, 1.8 * look.unit))
        painter.drawLine(QLineF(x - size, y - size, x + size, y + size))
        painter.drawLine(QLineF(x - size, y + size, x + size, y - size))


def draw_edges(painter, look, segments, directed):
    """Draw the ``segments``, wide by weight, with a head at the robot that hears.

    Of very many only one in k is drawn; return k.
    """
    stride = max(1, -(-len(segments.place) // MOST_EDGES))
    _, weight, begin, end = (values[::stride] for values in segments)
    widths = np.clip(EDGE_WIDTH * weight, *EDGE_WIDTHS)
    many = len(weight) > MANY_EDGES
    shade = look.mixed(0.5 if len(weight) <= SOME_EDGES else 0.3)
    painter.setRenderHint(painter.Antialiasing, not many)
    widths = np.where(many, 1.0, look.unit * widths.round(1))
    for width in np.unique(widths):
        chosen = np.hstack([begin, end])[widths == width].tolist()
        painter.setPen(QPen(shade, float(width)))
        painter.drawLines([QLineF(*ends) for ends in chosen])
    painter.setRenderHint(painter.Antialiasing, True)
    if directed:
        _draw_heads(painter, look, begin, end, widths, shade)
    return stride


def _draw_heads(painter, look, begin, end, widths, shade):
    apart = end - begin
    length = np.maximum(np.hypot(*apart.T), 1e-9)
    size = np.minimum(7.0 * look.unit + 1.5 * widths, 0.6 * length)
    along = apart * (size / length)[:, np.newaxis]
    across = 0.42 * along[:, ::-1] * (-1.0, 1.0)
    # The point is a little beyond the line's blunt end, which it covers.
    heads = np.stack([end, end - along + across, end - along - across], axis=1)
    painter.setPen(Qt.NoPen)
    painter.setBrush(shade)
    for head in heads:
        painter.drawConvexPolygon(polygon(head))


def draw_robots(painter, look, frame, pose, numbers, fresh):
    """Draw the robots of ``pose`` (n, 3), all in view, each in its colour, stale ones in grey."""
    shapes = outlines(pose, frame, look.unit)
    if len(pose) > MANY_ROBOTS:
        _draw_many(painter, look, shapes, numbers, fresh)
        return
    detailed = pioneer.LENGTH * frame.scale >= DETAILED_ROBOT * look.unit
    wheels = [placed(wheel, pose, frame) for wheel in _wheels()] if detailed else []
    noses = None if are_arrows(frame, look.unit) else placed(NOSE, pose, frame)
    for row, shape in enumerate(shapes):
        shade = look.shade(numbers[row]) if fresh[row] else look.mixed(0.5)
        painter.setPen(QPen(mixed(shade, look.text, 0.35), look.unit))
        _draw_body(painter, look, polygon(shape), shade, fresh[row])
        painter.setPen(Qt.NoPen)
        if noses is not None:
            painter.setBrush(QColor("white") if fresh[row] else look.mixed(0.5))
            painter.drawConvexPolygon(polygon(noses[row]))
        painter.setBrush(mixed(QColor("#101010"), look.text, 0.25))
        for wheel in wheels:
            painter.drawConvexPolygon(polygon(wheel[row]))


def _draw_body(painter, look, shape, shade, fresh):
    if fresh:
        painter.setBrush(shade)
    else:
        painter.setBrush(look.mixed(0.12))
        painter.drawPolygon(shape)
        painter.setBrush(QBrush(shade, Qt.BDiagPattern))
    painter.drawPolygon(shape)


def _wheels():
    radius, half = pioneer.WHEEL_RADIUS, 0.5 * TYRE
    corners = np.array([(radius, half), (-radius, half), (-radius, -half), (radius, -half)])
    side = np.array([0.0, 0.5 * pioneer.WHEEL_TRACK])
    return corners + side, corners - side


def _draw_many(painter, look, shapes, numbers, fresh):
    """Draw many robots, all of one colour in one go."""
    paths = {}
    for row, shape in enumerate(shapes):
        shade = look.shade(numbers[row]) if fresh[row] else look.mixed(0.4)
        paths.setdefault(shade.rgb(), QPainterPath()).addPolygon(polygon(shape))
    painter.setPen(Qt.NoPen)
    for shade, path in paths.items():
        path.setFillRule(Qt.WindingFill)
        painter.setBrush(QColor(shade))
        painter.drawPath(path)


class NumberPlates:
    """The robots' numbers as outlines of letters, made once for a font."""

    def __init__(self):
        self._font, self._paths = None, {}

    def draw(self, painter, look, frame, pose, numbers):
        """Draw each number beside its robot, to the upper side of its heading."""
        font = QFont(painter.font())
        if len(pose) > SOME_ROBOTS:
            font.setPointSizeF(0.8 * painter.fontInfo().pointSizeF())
        if font != self._font:
            self._font, self._paths = font, {}
        side = np.stack([-np.sin(pose[:, 2]), np.cos(pose[:, 2])], axis=1)
        side *= np.where(side[:, 1:] < 0.0, -1.0, 1.0)
        away = clearance(pose, side, frame, look.unit) + 0.62 * look.line
        places = frame.to_screen(pose) + away[:, np.newaxis] * side * (1.0, -1.0)
        halo = QPen(faded(look.base, 0.85), 3.0 * look.unit)
        halo.setJoinStyle(Qt.RoundJoin)
        for number, (x, y) in zip(numbers, places.tolist()):
            path = self._path(number).translated(x, y)
            painter.strokePath(path, halo)
            painter.fillPath(path, look.text)

    def _path(self, number):
        if number not in self._paths:
            path = QPainterPath()
            path.addText(0.0, 0.0, self._font, str(number))
            middle = path.boundingRect().center()
            self._paths[number] = path.translated(-middle.x(), -middle.y())
        return self._paths[number]


def draw_selection(painter, look, frame, pose):
    """Draw a disc under the robot at ``pose`` (3,)."""
    radius = max(1.35 * REACH * frame.scale, 12.0 * look.unit)
    middle = pose[:2] + 0.5 * (pioneer.FRONT - pioneer.REAR) * np.array(
        [np.cos(pose[2]), np.sin(pose[2])]
    )
    painter.setPen(QPen(look.highlight, 2.0 * look.unit))
    painter.setBrush(faded(look.highlight, 0.25))
    painter.drawEllipse(QPointF(*frame.to_screen(middle)), radius, radius)


def draw_alarms(painter, look, frame, pose):
    """Outline in red the robots of ``pose`` (n, 3)."""
    pen = QPen(QColor(ALARM), 3.0 * look.unit)
    pen.setJoinStyle(Qt.MiterJoin)
    painter.setPen(pen)
    painter.setBrush(Qt.NoBrush)
    for shape in outlines(pose, frame, look.unit):
        painter.drawPolygon(polygon(shape))


def draw_flash(painter, look, frame, place, age):
    """Draw the ring of a collision ``age`` [s] ago at ``place`` (2,)."""
    share = age / FLASH
    radius = max(0.35 * frame.scale, 10.0 * look.unit) * (0.7 + 0.8 * share)
    painter.setPen(QPen(faded(QColor(ALARM), 1.0 - share), 4.0 * look.unit))
    painter.setBrush(Qt.NoBrush)
    painter.drawEllipse(QPointF(*frame.to_screen(place)), radius, radius)


def draw_band(painter, look, begin, end, reached):
    """Draw the edge being drawn from ``begin`` to ``end`` [px]: solid once it has a robot there."""
    pen = QPen(look.highlight, 2.0 * look.unit, Qt.SolidLine if reached else Qt.DashLine)
    painter.setPen(pen)
    painter.drawLine(QLineF(*begin, *end))
    if reached:
        ends = np.array([end]), np.array([begin])
        _draw_heads(painter, look, *ends, np.array([2.0 * look.unit]), look.highlight)
