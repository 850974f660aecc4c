"""Foreground of the map: robots, edges, targets and marks.

Each ``draw_`` function gets a painter, the ``Look`` of the widget and the ``Frame``; positions are
arrays, one point per row, in metres unless they are said to be on the screen [px].
"""

from typing import NamedTuple, Tuple

import numpy as np
from python_qt_binding.QtCore import QLineF, QPointF, QRectF, Qt
from python_qt_binding.QtGui import QBrush, QColor, QFont, QPainterPath, QPen, QPolygonF

from mrs_simulator.rqt_plugin.map.geometry import (
    ARROW,
    apart,
    are_arrows,
    clearance,
    outlines,
    placed,
)
from mrs_simulator.rqt_plugin.map.shapes import Shapes
from mrs_simulator.rqt_plugin.widgets import colours
from mrs_simulator.study.figures import START_COLOUR

SOME_ROBOTS = 30  # [-] in view; beyond, marks and numbers are smaller, robots are sprites
HEADINGS = 120  # [-] of a robot's sprites
MOST_SPRITE = 40.0  # [px] that a robot may reach as a sprite
MANY_ROBOTS = 200  # [-] in view; beyond, marks are smaller still and there are no numbers
SOME_EDGES = 30  # [-] in view; beyond, they are paler
MANY_EDGES = 400  # [-] in view; beyond, they are drawn without smoothing
MOST_EDGES = 4000  # [-] drawn
EDGE_WIDTHS = (0.7, 6.0)  # [px], least and most; one of weight 1 is EDGE_WIDTH wide
EDGE_WIDTH = 1.4  # [px]

DETAILED_ROBOT = 22.0  # [px], the least that shows its wheels
FLASH = 2.0  # [s], how long a collision's ring is seen
ALARM = "#e01b24"
LEGEND = {  # in the order of the map's words
    "start": "start",
    "trail": "path so far",
    "target": "wanted place",
    "hears": "to the robot that hears",
    "edge": "robots that hear each other",
    "real": "real robot",
    "stale": "not heard lately",
}


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


def draw_robots(painter, look, frame, pose, numbers, fresh, shapes, sprites):
    """Draw the robots of ``pose`` (n, 3), all in view, each in its colour, stale ones in grey.

    ``shapes``: theirs.  Of many robots each is one of the ``sprites``: on whole pixels, at one of
    some headings.
    """
    half = max(shapes.farthest * frame.scale, ARROW * look.unit) + 2.0 * look.unit
    if len(pose) <= SOME_ROBOTS or half > MOST_SPRITE:
        _draw_each(painter, look, frame, pose, numbers, fresh, shapes)
        return
    local, many = frame.about_origin(), len(look.shades) + 1
    of_place = dict(zip(look.places(numbers).tolist(), numbers))
    turns = np.round(pose[:, 2] * HEADINGS / (2.0 * np.pi)).astype(int) % HEADINGS
    places = np.where(fresh, look.places(numbers), many - 1)
    keys = turns + HEADINGS * (places + many * shapes.which)

    def paint(brush, key):
        rest, turn = divmod(key, HEADINGS)
        which, place = divmod(rest, many)
        pose = np.array([[0.0, 0.0, turn * 2.0 * np.pi / HEADINGS]])
        own = Shapes.of_kinds([shapes.distinct[which]])
        fresh = place < many - 1
        _draw_each(brush, look, local, pose, [of_place.get(place, 1)], [fresh], own)

    kind = look, frame.scale, shapes.distinct
    sprites.put(painter, kind, half, frame.to_screen(pose), keys.tolist(), paint)


def _draw_each(painter, look, frame, pose, numbers, fresh, shapes):
    outlined = outlines(pose, frame, look.unit, shapes)
    arrows = are_arrows(frame, look.unit, shapes)
    detailed = shapes.length * frame.scale >= DETAILED_ROBOT * look.unit
    for rows, shape in shapes.by_kind():
        wheels = [placed(wheel, pose[rows], frame) for wheel in shape.wheels]
        noses = placed(shape.nose, pose[rows], frame)
        for place, row in enumerate(rows.tolist()):
            shade = look.shade(numbers[row]) if fresh[row] else look.mixed(0.5)
            painter.setPen(QPen(mixed(shade, look.text, 0.35), look.unit))
            _draw_body(painter, look, polygon(outlined[row]), shade, fresh[row])
            painter.setPen(Qt.NoPen)
            if not arrows[row]:
                painter.setBrush(QColor("white") if fresh[row] else look.mixed(0.5))
                painter.drawConvexPolygon(polygon(noses[place]))
            painter.setBrush(mixed(QColor("#101010"), look.text, 0.25))
            for wheel in wheels if detailed[row] else ():
                painter.drawConvexPolygon(polygon(wheel[place]))


def _draw_body(painter, look, shape, shade, fresh):
    if fresh:
        painter.setBrush(shade)
    else:
        painter.setBrush(look.mixed(0.12))
        painter.drawPolygon(shape)
        painter.setBrush(QBrush(shade, Qt.BDiagPattern))
    painter.drawPolygon(shape)


def draw_numbers(painter, look, frame, pose, numbers, shapes, sprites):
    """Draw each number beside its robot, to the upper side of its heading, by ``sprites``.

    Only those numbers are drawn that do not cover another.
    """
    font = QFont(painter.font())
    if len(pose) > SOME_ROBOTS:
        font.setPointSizeF(0.8 * painter.fontInfo().pointSizeF())
    side = np.stack([-np.sin(pose[:, 2]), np.cos(pose[:, 2])], axis=1)
    side *= np.where(side[:, 1:] < 0.0, -1.0, 1.0)
    away = clearance(pose, side, frame, look.unit, shapes) + 0.62 * look.line
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
    rows = apart(places, 0.48 * look.line * longest, 0.7 * look.line)
    places, numbers = places[rows], [numbers[row] for row in rows]
    sprites.put(painter, (look, font), half, places, numbers, paint)


def draw_selection(painter, look, frame, pose, shapes):
    """Draw a disc under the robots of ``pose`` (n, 3)."""
    painter.setPen(QPen(look.highlight, 2.0 * look.unit))
    painter.setBrush(faded(look.highlight, 0.25))
    _draw_rings(painter, frame, pose, shapes, 1.35, 12.0 * look.unit)


def draw_real(painter, look, frame, pose, shapes):
    """Draw a ring about the robots of ``pose`` (n, 3), which are real ones."""
    painter.setPen(QPen(look.text, 2.0 * look.unit))
    painter.setBrush(Qt.NoBrush)
    _draw_rings(painter, frame, pose, shapes, 1.15, 10.0 * look.unit)


def _draw_rings(painter, frame, pose, shapes, factor, least):
    """Draw a circle of ``factor`` times its reach, at least ``least`` [px], about each robot's middle."""
    heading = np.stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])], axis=1)
    ahead = 0.5 * (shapes.front - shapes.rear)
    middles = frame.to_screen(pose[:, :2] + ahead[:, np.newaxis] * heading)
    radii = np.maximum(factor * shapes.reach * frame.scale, least)
    for (x, y), radius in zip(middles.tolist(), radii.tolist()):
        painter.drawEllipse(QPointF(x, y), radius, radius)


def draw_legend(painter, look, frame, shown):
    """Say in the lower left corner what the signs of the map mean: those in ``shown``, names."""
    area, line = frame.area, look.line
    entries = [name for name in LEGEND if name in shown]
    width = 2.6 * line + max(
        [painter.fontMetrics().horizontalAdvance(LEGEND[name]) for name in entries] + [0]
    )
    height = (1.2 * len(entries) + 0.3) * line
    if not entries or 2.5 * width > area.width() or 2.0 * height > area.height():
        return  # there is no room for words
    left, top = area.left() + 0.4 * line, area.bottom() - 0.4 * line - height
    painter.setPen(QPen(look.mixed(0.25), 1))
    painter.setBrush(faded(look.base, 0.85))
    painter.drawRect(QRectF(left, top, width, height))
    for place, name in enumerate(entries):
        y = top + (1.2 * place + 0.75) * line
        _draw_sign(painter, look, name, QPointF(left + 1.1 * line, y))
        painter.setPen(look.text)
        box = QRectF(left + 2.1 * line, y - line, width, 2.0 * line)
        painter.drawText(box, Qt.AlignLeft | Qt.AlignVCenter, LEGEND[name])


def _draw_sign(painter, look, name, at):
    """Draw the sign called ``name`` about the point ``at``."""
    unit, reach = look.unit, 0.65 * look.line
    x, y = at.x(), at.y()
    painter.setBrush(Qt.NoBrush)
    if name == "start":
        painter.setPen(Qt.NoPen)
        painter.setBrush(QColor(START_COLOUR))
        painter.drawEllipse(at, 3.0 * unit, 3.0 * unit)
    elif name == "target":
        painter.setPen(QPen(look.mixed(0.8), 1.8 * unit))
        size = 4.0 * unit
        painter.drawLine(QLineF(x - size, y - size, x + size, y + size))
        painter.drawLine(QLineF(x - size, y + size, x + size, y - size))
    elif name == "trail":
        painter.setPen(QPen(look.mixed(0.8), 1.4 * unit, Qt.DashLine))
        painter.drawLine(QLineF(x - reach, y, x + reach, y))
    elif name in ("hears", "edge"):
        begin, end = np.array([[x - reach, y]]), np.array([[x + reach, y]])
        painter.setPen(QPen(look.mixed(0.5), EDGE_WIDTH * unit))
        painter.drawLine(QLineF(x - reach, y, x + reach, y))
        if name == "hears":
            width = np.array([EDGE_WIDTH * unit])
            _draw_heads(painter, look, begin, end, width, look.mixed(0.5))
    elif name == "real":
        painter.setPen(QPen(look.text, 2.0 * unit))
        painter.drawEllipse(at, 0.45 * look.line, 0.45 * look.line)
    elif name == "stale":
        painter.setPen(Qt.NoPen)
        painter.setBrush(QBrush(look.mixed(0.5), Qt.BDiagPattern))
        painter.drawRect(QRectF(x - 0.5 * reach, y - 0.5 * reach, reach, reach))


def draw_alarms(painter, look, frame, pose, shapes):
    """Outline in red the robots of ``pose`` (n, 3)."""
    pen = QPen(QColor(ALARM), 3.0 * look.unit)
    pen.setJoinStyle(Qt.MiterJoin)
    painter.setPen(pen)
    painter.setBrush(Qt.NoBrush)
    for shape in outlines(pose, frame, look.unit, shapes):
        painter.drawPolygon(polygon(shape))


def draw_flash(painter, look, frame, place, age):
    """Draw the ring of a collision ``age`` [s] ago at ``place`` (2,); of many robots a small, thin one."""
    share, few = age / FLASH, look.count <= SOME_ROBOTS
    least, width = (10.0, 4.0) if few else (5.0, 1.5)
    radius = max((0.35 if few else 0.2) * frame.scale, least * look.unit) * (0.7 + 0.8 * share)
    painter.setPen(QPen(faded(QColor(ALARM), 1.0 - share), width * look.unit))
    painter.setBrush(Qt.NoBrush)
    painter.drawEllipse(QPointF(*frame.to_screen(place)), radius, radius)


def draw_band(painter, look, begin, end, reached, text):
    """Draw the edge being drawn from ``begin`` to ``end`` [px], with its head there, and ``text``.

    It is solid once it has ``reached`` a robot.
    """
    pen = QPen(look.highlight, 2.0 * look.unit, Qt.SolidLine if reached else Qt.DashLine)
    painter.setPen(pen)
    painter.drawLine(QLineF(*begin, *end))
    ends = np.array([begin]), np.array([end])
    _draw_heads(painter, look, *ends, np.array([2.0 * look.unit]), look.highlight)
    width = painter.fontMetrics().horizontalAdvance(text) + 0.8 * look.line
    box = QRectF(end[0] + 0.8 * look.line, end[1] - 1.6 * look.line, width, 1.3 * look.line)
    painter.fillRect(box, faded(look.base, 0.9))
    painter.setPen(look.text)
    painter.drawText(box, Qt.AlignCenter, text)
