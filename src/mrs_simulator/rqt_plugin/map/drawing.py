"""Foreground of the map: robots, edges, targets and marks.

Each ``draw_`` function gets a painter, the ``Look`` of the widget and the ``Frame``; positions are
arrays, one point per row, in metres unless they are said to be on the screen [px].
"""

from typing import NamedTuple, Tuple

import numpy as np
from python_qt_binding.QtCore import QLineF, QPointF, QRectF, Qt
from python_qt_binding.QtGui import QBrush, QColor, QFont, QPainterPath, QPen, QPolygonF

from mrs_simulator.core.scenario import DEFAULT_KIND
from mrs_simulator.rqt_plugin.map.geometry import (
    ARROW,
    REACH,
    apart,
    are_arrows,
    clearance,
    outlines,
    placed,
)
from mrs_simulator.rqt_plugin.widgets import colours
from mrs_simulator.study.figures import START_COLOUR
from mrs_simulator.vehicles import kind

DRAWN = kind(DEFAULT_KIND)
SOME_ROBOTS = 30  # [-] in view; beyond, marks and numbers are smaller, robots are sprites
HEADINGS = 120  # [-] of a robot's sprites
MOST_SPRITE = 40.0  # [px] that a robot may reach as a sprite
MANY_ROBOTS = 200  # [-] in view; beyond, marks are smaller still and there are no numbers
SOME_EDGES = 30  # [-] in view; beyond, they are paler
MANY_EDGES = 400  # [-] in view; beyond, they are drawn without smoothing
MOST_EDGES = 4000  # [-] drawn
EDGE_WIDTHS = (0.7, 6.0)  # [px], least and most; one of weight 1 is EDGE_WIDTH wide
EDGE_WIDTH = 1.4  # [px]

NOSE = ((0.175, 0.0), (0.055, 0.095), (0.055, -0.095))  # [m], the heading mark
TYRE = 0.05  # [m], its width
DETAILED_ROBOT = 22.0  # [px], the least that shows its wheels
FLASH = 2.0  # [s], how long a collision's ring is seen
ALARM = "#e01b24"


class Look(NamedTuple):
    """Colours and sizes of a widget."""

    base: QColor
    text: QColor
    highlight: QColor
    unit: float  # [px], 1 at the usual size of the font
    line: float  # [px], height of a line of text
    count: int  # of robots in the team
    shades: Tuple[QColor, ...]  # the robots' distinct colours

    @classmethod
    def of(cls, widget, count=1):
        """Return the look that palette and font of ``widget`` ask for, with a team of ``count`` robots."""
        palette, line = widget.palette(), widget.fontMetrics().height()
        base, text, highlight = palette.base(), palette.text(), palette.highlight()
        unit = max(1.0, line / 16.0)
        base, text, highlight = base.color(), text.color(), highlight.color()
        look = base, text, highlight, unit, float(line), count
        return cls(*look, colours.shades(count, base))

    def mixed(self, share):
        """Return the colour that is ``share`` text and the rest background."""
        return mixed(self.base, self.text, share)

    def shade(self, number):
        """Return the colour of robot ``number``."""
        return self.shades[self.places([number])[0]]

    def places(self, numbers):
        """Return the places of the robots ``numbers`` among the ``shades``."""
        return colours.places(numbers, self.count)


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


# The team


def draw_starts(painter, look, frame, starts, team=None):
    """Draw red points where the robots began, of the size that suits all ``team``, if given."""
    screen = frame.to_screen(starts)
    radius = _by_count(len(starts if team is None else team), 3.0, 2.2, 1.5) * look.unit
    painter.setPen(Qt.NoPen)
    painter.setBrush(QColor(START_COLOUR))
    for x, y in screen[frame.sees(screen, 9.0)].tolist():
        painter.drawEllipse(QPointF(x, y), radius, radius)


def _by_count(count, few, more, many):
    return few if count <= SOME_ROBOTS else more if count <= MANY_ROBOTS else many


def draw_targets(painter, look, frame, targets, numbers, sprites):
    """Draw a small cross at each desired position, in the colour of its robot."""
    screen = frame.to_screen(targets)
    size = _by_count(len(targets), 4.5, 3.0, 2.0) * look.unit
    rows = np.flatnonzero(frame.sees(screen, size))
    keys = np.full(len(rows), -1)
    if len(numbers) == len(targets):
        keys = look.places(np.array(numbers)[rows])

    def paint(brush, key):
        shade = look.text if key < 0 else mixed(look.shades[key], look.text, 0.25)
        brush.setPen(QPen(shade, 1.8 * look.unit))
        brush.drawLine(QLineF(-size, -size, size, size))
        brush.drawLine(QLineF(-size, size, size, -size))

    sprites.put(painter, (look, size), size + 1.8 * look.unit, screen[rows], keys.tolist(), paint)


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
    if directed:
        _draw_heads(painter, look, begin, end, widths, shade)
    painter.setRenderHint(painter.Antialiasing, True)
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


def draw_robots(painter, look, frame, pose, numbers, fresh, sprites):
    """Draw the robots of ``pose`` (n, 3), all in view, each in its colour, stale ones in grey.

    Of many robots each is one of the ``sprites``: on whole pixels, at one of some headings.
    """
    half = max(REACH * frame.scale, ARROW * look.unit) + 2.0 * look.unit
    if len(pose) <= SOME_ROBOTS or half > MOST_SPRITE:
        _draw_each(painter, look, frame, pose, numbers, fresh)
        return
    local, many = frame.about_origin(), len(look.shades)
    of_place = dict(zip(look.places(numbers).tolist(), numbers))
    turns = np.round(pose[:, 2] * HEADINGS / (2.0 * np.pi)).astype(int) % HEADINGS
    keys = turns + HEADINGS * np.where(fresh, look.places(numbers), many)

    def paint(brush, key):
        place, turn = divmod(key, HEADINGS)
        pose = np.array([[0.0, 0.0, turn * 2.0 * np.pi / HEADINGS]])
        _draw_each(brush, look, local, pose, [of_place.get(place, 1)], [place < many])

    kind = look, frame.scale
    sprites.put(painter, kind, half, frame.to_screen(pose), keys.tolist(), paint)


def _draw_each(painter, look, frame, pose, numbers, fresh):
    shapes = outlines(pose, frame, look.unit)
    detailed = DRAWN.body.length * frame.scale >= DETAILED_ROBOT * look.unit
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
    radius, half = DRAWN.numbers.radius, 0.5 * TYRE
    corners = np.array([(radius, half), (-radius, half), (-radius, -half), (radius, -half)])
    side = np.array([0.0, 0.5 * DRAWN.numbers.track])
    return corners + side, corners - side


def draw_numbers(painter, look, frame, pose, numbers, sprites):
    """Draw each number beside its robot, to the upper side of its heading, by ``sprites``.

    Of many robots only those numbers are drawn that do not cover another.
    """
    font = QFont(painter.font())
    if len(pose) > SOME_ROBOTS:
        font.setPointSizeF(0.8 * painter.fontInfo().pointSizeF())
    side = np.stack([-np.sin(pose[:, 2]), np.cos(pose[:, 2])], axis=1)
    side *= np.where(side[:, 1:] < 0.0, -1.0, 1.0)
    away = clearance(pose, side, frame, look.unit) + 0.62 * look.line
    places = frame.to_screen(pose) + away[:, np.newaxis] * side * (1.0, -1.0)

    def paint(brush, number):
        path = QPainterPath()
        path.addText(0.0, 0.0, font, str(number))
        middle = path.boundingRect().center()
        path.translate(-middle.x(), -middle.y())
        halo = QPen(faded(look.base, 0.85), 3.0 * look.unit)
        halo.setJoinStyle(Qt.RoundJoin)
        brush.strokePath(path, halo)
        brush.fillPath(path, look.text)

    longest = max([len(str(number)) for number in numbers] + [1])
    half = 0.5 * look.line * max(1.0, 0.6 * longest) + 2.0 * look.unit
    if len(pose) > SOME_ROBOTS:
        rows = apart(places, 0.48 * look.line * longest, 0.7 * look.line)
        places, numbers = places[rows], [numbers[row] for row in rows]
    sprites.put(painter, (look, font), half, places, numbers, paint)


def draw_selection(painter, look, frame, pose):
    """Draw a disc under the robot at ``pose`` (3,)."""
    radius = max(1.35 * REACH * frame.scale, 12.0 * look.unit)
    middle = pose[:2] + 0.5 * (DRAWN.body.front - DRAWN.body.rear) * np.array(
        [np.cos(pose[2]), np.sin(pose[2])]
    )
    painter.setPen(QPen(look.highlight, 2.0 * look.unit))
    painter.setBrush(faded(look.highlight, 0.25))
    painter.drawEllipse(QPointF(*frame.to_screen(middle)), radius, radius)


def draw_real(painter, look, frame, pose):
    """Draw a ring about the robots of ``pose`` (n, 3), which are real ones."""
    radius = max(1.15 * REACH * frame.scale, 10.0 * look.unit)
    painter.setPen(QPen(look.text, 2.0 * look.unit))
    painter.setBrush(Qt.NoBrush)
    heading = np.stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])], axis=1)
    middles = frame.to_screen(pose[:, :2] + 0.5 * (DRAWN.body.front - DRAWN.body.rear) * heading)
    for x, y in middles.tolist():
        painter.drawEllipse(QPointF(x, y), radius, radius)


def draw_legend(painter, look, frame):
    """Say in the lower left corner what the ring about a robot means."""
    area, line, text = frame.area, look.line, "real robot"
    box = QRectF(area.left() + 0.4 * line, area.bottom() - 1.75 * line, 0.0, 1.35 * line)
    box.setWidth(painter.fontMetrics().horizontalAdvance(text) + 2.2 * line)
    painter.fillRect(box, faded(look.base, 0.85))
    painter.setPen(QPen(look.text, 2.0 * look.unit))
    painter.setBrush(Qt.NoBrush)
    middle = QPointF(box.left() + 0.9 * line, box.center().y())
    painter.drawEllipse(middle, 0.45 * line, 0.45 * line)
    painter.drawText(box.adjusted(1.7 * line, 0.0, 0.0, 0.0), Qt.AlignLeft | Qt.AlignVCenter, text)


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
