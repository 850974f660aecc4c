"""Draws obstacles, the robots, and their numbers.

Each ``draw_`` function gets a painter, the ``MapStyle`` of the widget and the ``Frame``; poses are (n, 3),
one robot per row.
"""

import numpy as np

from mrs_simulator.pictures.plan import bodies, obstacle_bodies
from mrs_simulator.pictures.scene import Scene
from mrs_simulator.pictures.signs import SOME_ROBOTS
from mrs_simulator.rqt_plugin.map.geometry import ARROW, apart, are_arrows, clearance, outlines
from mrs_simulator.rqt_plugin.map.shapes import Shapes
from mrs_simulator.rqt_plugin.map.sprites import Sprites
from mrs_simulator.rqt_plugin.map.style import faded, mixed, polygon
from mrs_simulator.rqt_plugin.qt.QtCore import Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QBrush, QColor, QFont, QPainterPath, QPen
from mrs_simulator.rqt_plugin.view.painting import fill
from mrs_simulator.state.state_table import StateTable

HEADINGS = 120  # [-] of a robot's sprites
MOST_SPRITE = 40.0  # [px] that a robot may reach as a sprite


def draw_obstacles(painter, style, frame, obstacles):
    """Draw ``obstacles`` to scale."""
    colours = (shade.getRgbF()[:3] for shade in (style.base, style.text))
    layer = obstacle_bodies(obstacles, frame.to_screen, *colours)
    if layer is not None:
        fill(painter, layer, style.unit)


def draw_robots(painter, style, frame, scene, shapes, shown, sprites):
    """Draw the robots of a ``Scene`` that are ``shown`` (n,), all in view, with their arms and load.

    ``shapes``: theirs.  Of many robots each is one of the ``sprites``: on whole pixels, at one of
    some headings.
    """
    half = max(shapes.farthest * frame.scale, ARROW * style.unit) + 2.0 * style.unit
    if np.count_nonzero(shown) <= SOME_ROBOTS or half > MOST_SPRITE:
        _draw_each(painter, style, frame, scene, shapes, shown)
        return
    rows = np.flatnonzero(shown)
    _put_sprites(painter, style, frame, scene, shapes.of(rows), rows, half, sprites)
    if scene.carried is not None or any(kind.arm is not None for kind in shapes.distinct):
        _fill_bodies(painter, style, frame, scene, np.zeros(len(shown), dtype=bool))


def draw_faint(painter, style, frame, scene, shapes, opacity, rows=None):
    """Draw the robots of a ``Scene``, with their ``shapes``, seen through; ``rows``: of these alone."""
    pose = scene.state.pose
    with np.errstate(invalid="ignore"):
        shown = frame.sees(frame.to_screen(pose), shapes.farthest * frame.scale)
    shown &= np.isfinite(pose).all(axis=1)
    if rows is not None:
        shown &= np.isin(np.arange(len(pose)), rows)
    painter.save()
    painter.setOpacity(opacity)
    draw_robots(painter, style, frame, scene, shapes, shown, Sprites())
    painter.restore()


def _put_sprites(painter, style, frame, scene, shapes, rows, half, sprites):
    local, pose = frame.about_origin(), scene.state.pose[rows]
    shades, which = np.unique(np.column_stack(_marks(scene, rows)), axis=0, return_inverse=True)
    turns = np.round(pose[:, 2] * HEADINGS / (2.0 * np.pi)).astype(int) % HEADINGS
    keys = turns + HEADINGS * (shapes.which + len(shapes.distinct) * which.ravel())

    alone = {}  # the ``Shapes`` of one robot of each kind

    def paint(brush, key):
        rest, turn = divmod(key, HEADINGS)
        place, which = divmod(rest, len(shapes.distinct))
        kinds = (shapes.distinct[which],)
        if which not in alone:
            alone[which] = Shapes.of_kinds(kinds)
        pose, fresh = np.array([[0.0, 0.0, turn * 2.0 * np.pi / HEADINGS]]), shades[place, 3:] > 0.0
        own = Scene(
            kinds, StateTable(None, (1,), pose=pose, fresh=fresh), shades[place, np.newaxis, :3]
        )
        _draw_each(brush, style, local, own, alone[which], np.ones(1, dtype=bool))

    # Arrows are as large at any scale.
    scale = None if are_arrows(frame, style.unit, shapes).all() else frame.scale
    kind = style, scale, shapes.distinct, shades.tobytes()
    sprites.put(painter, kind, half, frame.to_screen(pose), keys.tolist(), paint)


def _marks(scene, rows):
    """Return the colours (k, 3) of the robots in ``rows``, and which have recent data, (k,)."""
    return np.asarray(scene.shades)[rows], scene.state.fresh[rows]


def _fill_bodies(painter, style, frame, scene, shown):
    layer = bodies(scene, frame.to_screen, shown, style.text.getRgbF()[:3])
    if layer is not None:
        fill(painter, layer, style.unit)


def _draw_each(painter, style, frame, scene, shapes, shown):
    arrows, fresh = are_arrows(frame, style.unit, shapes), scene.state.fresh
    rows = np.flatnonzero(shown & (arrows | ~fresh))
    outlined = outlines(scene.state.pose[rows], frame, style.unit, shapes.of(rows))
    for row, outline in zip(rows.tolist(), map(polygon, outlined)):
        shade = QColor.fromRgbF(*scene.shades[row])
        painter.setPen(QPen(mixed(shade, style.text, 0.35), style.unit))
        _draw_outline(painter, style, outline, shade, fresh[row])
    _fill_bodies(painter, style, frame, scene, shown & ~arrows)


def _draw_outline(painter, style, outline, shade, fresh):
    if fresh:
        painter.setBrush(shade)
    else:
        painter.setBrush(style.mixed(0.12))
        painter.drawPolygon(outline)
        painter.setBrush(QBrush(shade, Qt.BDiagPattern))
    painter.drawPolygon(outline)


def draw_numbers(painter, style, frame, pose, numbers, shapes, sprites):
    """Draw each number beside its robot, to the upper side of its heading, by ``sprites``.

    Only those numbers are drawn that do not cover another.  Return their middles (m, 2) and size (2,) [px].
    """
    font = _font(painter, 1.0 if len(pose) <= SOME_ROBOTS else 0.8)
    side = np.stack([-np.sin(pose[:, 2]), np.cos(pose[:, 2])], axis=1)
    side *= np.where(side[:, 1:] < 0.0, -1.0, 1.0)
    return _draw_texts(painter, style, frame, pose, numbers, shapes, sprites, font, side)


def draw_heights(painter, style, frame, pose, shapes, heights, sprites, numbers):
    """Draw the texts ``heights`` below their robots, but where they cover ``numbers``, as returned."""
    font = _font(painter, 0.85 if len(pose) <= SOME_ROBOTS else 0.7)
    side = np.tile([0.0, -1.0], (len(pose), 1))
    _draw_texts(painter, style, frame, pose, heights, shapes, sprites, font, side, numbers)


def height_text(z):
    """Return how the height ``z`` [m] is written: in steps that are seen to change, few enough to keep."""
    return "{:.{}f} m".format(z, 2 if z < 0.995 else 1 if z < 9.95 else 0)


def _font(painter, share):
    font = QFont(painter.font())
    font.setPointSizeF(share * painter.fontInfo().pointSizeF())
    return font


def _draw_texts(painter, style, frame, pose, texts, shapes, sprites, font, side, others=None):
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
    size = np.array([0.48 * style.line * longest, 0.7 * style.line])
    rows = apart(places, *size)
    if others is not None:
        rows = [row for row in rows if not _meets(places[row], size, *others)]
    places, texts = places[rows], [texts[row] for row in rows]
    sprites.put(painter, (style, font), half, places, texts, paint)
    return places, size


def _meets(place, size, others, their_size):
    """Return whether a text about ``place`` (2,) covers one about any of ``others`` (m, 2), [px]."""
    return bool((np.abs(others - place) < 0.5 * (size + their_size)).all(axis=1).any())
