"""Draws the robots and their numbers.

Each ``draw_`` function gets a painter, the ``MapStyle`` of the widget and the ``Frame``; poses are (n, 3),
one robot per row.
"""

import numpy as np

from mrs_simulator.rqt_plugin.map.geometry import (
    ARROW,
    apart,
    are_arrows,
    clearance,
    outlines,
    placed,
)
from mrs_simulator.rqt_plugin.map.shapes import Shapes
from mrs_simulator.rqt_plugin.map.style import SOME_ROBOTS, faded, mixed, polygon
from mrs_simulator.rqt_plugin.qt.QtCore import Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QBrush, QColor, QFont, QPainterPath, QPen

HEADINGS = 120  # [-] of a robot's sprites
MOST_SPRITE = 40.0  # [px] that a robot may reach as a sprite
DETAILED_ROBOT = 22.0  # [px], the least that shows its wheels


def draw_robots(painter, style, frame, pose, numbers, fresh, shapes, sprites):
    """Draw the robots of ``pose`` (n, 3), all in view, each in its colour, stale ones in grey.

    ``shapes``: theirs.  Of many robots each is one of the ``sprites``: on whole pixels, at one of
    some headings.
    """
    half = max(shapes.farthest * frame.scale, ARROW * style.unit) + 2.0 * style.unit
    if len(pose) <= SOME_ROBOTS or half > MOST_SPRITE:
        _draw_each(painter, style, frame, pose, numbers, fresh, shapes)
        return
    local, many = frame.about_origin(), len(style.shades) + 1
    of_place = dict(zip(style.places(numbers).tolist(), numbers))
    turns = np.round(pose[:, 2] * HEADINGS / (2.0 * np.pi)).astype(int) % HEADINGS
    places = np.where(fresh, style.places(numbers), many - 1)
    keys = turns + HEADINGS * (places + many * shapes.which)

    def paint(brush, key):
        rest, turn = divmod(key, HEADINGS)
        which, place = divmod(rest, many)
        pose = np.array([[0.0, 0.0, turn * 2.0 * np.pi / HEADINGS]])
        own = Shapes.of_kinds([shapes.distinct[which]])
        fresh = place < many - 1
        _draw_each(brush, style, local, pose, [of_place.get(place, 1)], [fresh], own)

    # Arrows are as large at any scale.
    scale = None if are_arrows(frame, style.unit, shapes).all() else frame.scale
    kind = style, scale, shapes.distinct
    sprites.put(painter, kind, half, frame.to_screen(pose), keys.tolist(), paint)


def _draw_each(painter, style, frame, pose, numbers, fresh, shapes):
    outlined = outlines(pose, frame, style.unit, shapes)
    arrows = are_arrows(frame, style.unit, shapes)
    detailed = shapes.length * frame.scale >= DETAILED_ROBOT * style.unit
    for rows, shape in shapes.by_kind():
        wheels = [placed(wheel, pose[rows], frame) for wheel in shape.wheels]
        noses = placed(shape.nose, pose[rows], frame)
        for place, row in enumerate(rows.tolist()):
            shade = style.shade(numbers[row]) if fresh[row] else style.mixed(0.5)
            painter.setPen(QPen(mixed(shade, style.text, 0.35), style.unit))
            _draw_body(painter, style, polygon(outlined[row]), shade, fresh[row])
            painter.setPen(Qt.NoPen)
            if not arrows[row]:
                painter.setBrush(QColor("white") if fresh[row] else style.mixed(0.5))
                painter.drawConvexPolygon(polygon(noses[place]))
            painter.setBrush(mixed(QColor("#101010"), style.text, 0.25))
            for wheel in wheels if detailed[row] else ():
                painter.drawConvexPolygon(polygon(wheel[place]))


def _draw_body(painter, style, shape, shade, fresh):
    if fresh:
        painter.setBrush(shade)
    else:
        painter.setBrush(style.mixed(0.12))
        painter.drawPolygon(shape)
        painter.setBrush(QBrush(shade, Qt.BDiagPattern))
    painter.drawPolygon(shape)


def draw_numbers(painter, style, frame, pose, numbers, shapes, sprites):
    """Draw each number beside its robot, to the upper side of its heading, by ``sprites``.

    Only those numbers are drawn that do not cover another.
    """
    font = _font(painter, 1.0 if len(pose) <= SOME_ROBOTS else 0.8)
    side = np.stack([-np.sin(pose[:, 2]), np.cos(pose[:, 2])], axis=1)
    side *= np.where(side[:, 1:] < 0.0, -1.0, 1.0)
    _draw_texts(painter, style, frame, pose, numbers, shapes, sprites, font, side)


def draw_heights(painter, style, frame, pose, shapes, heights, sprites):
    """Draw the texts ``heights`` below their robots, as ``draw_numbers`` does."""
    font = _font(painter, 0.85 if len(pose) <= SOME_ROBOTS else 0.7)
    side = np.tile([0.0, -1.0], (len(pose), 1))
    _draw_texts(painter, style, frame, pose, heights, shapes, sprites, font, side)


def height_text(z):
    """Return how the height ``z`` [m] is written: in steps that are seen to change, few enough to keep."""
    return "{:.{}f} m".format(z, 2 if z < 0.995 else 1 if z < 9.95 else 0)


def _font(painter, share):
    font = QFont(painter.font())
    font.setPointSizeF(share * painter.fontInfo().pointSizeF())
    return font


def _draw_texts(painter, style, frame, pose, texts, shapes, sprites, font, side):
    away = clearance(pose, side, frame, style.unit, shapes) + 0.62 * style.line
    places = frame.to_screen(pose) + away[:, np.newaxis] * side * (1.0, -1.0)

    def paint(brush, text):
        path = QPainterPath()
        path.addText(0.0, 0.0, font, str(text))
        middle = path.boundingRect().center()
        path.translate(-middle.x(), -middle.y())
        halo = QPen(faded(style.base, 0.85), 3.0 * style.unit)
        halo.setJoinStyle(Qt.RoundJoin)
        brush.strokePath(path, halo)
        brush.fillPath(path, style.text)

    longest = max([len(str(text)) for text in texts] + [1])
    half = 0.5 * style.line * max(1.0, 0.6 * longest) + 2.0 * style.unit
    rows = apart(places, 0.48 * style.line * longest, 0.7 * style.line)
    places, texts = places[rows], [texts[row] for row in rows]
    sprites.put(painter, (style, font), half, places, texts, paint)
