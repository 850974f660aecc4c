"""Paints drawings of ``pictures`` with Qt."""

import functools

import numpy as np

from mrs_simulator.pictures.drawing import Lines, Paths, Polygons
from mrs_simulator.rqt_plugin.map.sprites import Sprites
from mrs_simulator.rqt_plugin.map.style import polygon
from mrs_simulator.rqt_plugin.qt.QtCore import QLineF, QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QBrush, QColor, QPainterPath, QPen

RIM = 0.7  # [px] width of the lines around faces
HALO = 2.5  # [px] around texts


def paint(painter, drawing, plates):
    """Paint ``drawing`` from the painter's origin on; ``plates``: a dict that keeps pictures of texts."""
    if drawing.ground is not None:
        area = QRectF(0, 0, drawing.width, drawing.height)
        painter.fillRect(area, _colour((*drawing.ground, 1.0)))
    for layer in drawing.layers:
        draw_layer(painter, layer, plates)


def draw_layer(painter, layer, plates=None):
    """Paint one ``layer`` of a drawing; ``plates`` as of :func:`paint`, which texts alone need."""
    if isinstance(layer, Polygons):
        fill(painter, layer)
    elif isinstance(layer, Lines):
        draw_lines(painter, layer)
    elif isinstance(layer, Paths):
        _draw_paths(painter, layer)
    else:
        _write(painter, layer, plates)


def _colour(parts):
    return QColor(*(int(round(255.0 * min(1.0, max(0.0, part)))) for part in parts))


def fill(painter, layer, rim=RIM):
    """Paint the ``Polygons``, with lines ``rim`` [px] wide around them."""
    every = polygon(layer.points)
    ends, last = np.cumsum(layer.counts), None
    looks = zip(_codes(layer.colours), _codes(layer.rims))
    for end, count, look in zip(ends.tolist(), layer.counts.tolist(), looks):
        if look != last:
            painter.setBrush(_brush(look[0]))
            painter.setPen(_pen(look[1], rim))
            last = look
        painter.drawConvexPolygon(every.mid(end - count, count))


def _codes(colours):
    """Return ``colours`` (m, 4) as numbers 0xAARRGGBB, a list: without indistinguishable ones."""
    parts = np.clip(np.round(255.0 * colours), 0, 255).astype(int)
    return (parts @ (1 << 16, 1 << 8, 1, 1 << 24)).tolist()


def _decoded(code):
    return QColor(code >> 16 & 255, code >> 8 & 255, code & 255, code >> 24)


@functools.lru_cache(maxsize=4096)
def _brush(code):
    return QBrush(_decoded(code))


@functools.lru_cache(maxsize=4096)
def _pen(code, width):
    return QPen(_decoded(code), width) if code >> 24 else QPen(Qt.NoPen)


def draw_lines(painter, layer):
    """Paint the ``Lines``, those of one colour together."""
    codes = np.array(_codes(layer.colours))
    for code in np.unique(codes):
        chosen = layer.segments[codes == code].reshape(-1, 4)
        painter.setPen(QPen(_decoded(int(code)), layer.width))
        painter.drawLines([QLineF(*ends) for ends in chosen.tolist()])


def _draw_paths(painter, layer):
    every = polygon(layer.points)
    painter.setBrush(Qt.NoBrush)
    ends = np.cumsum(layer.counts).tolist()
    for end, count, colour in zip(ends, layer.counts.tolist(), _codes(layer.colours)):
        painter.setPen(QPen(_decoded(colour), layer.width))
        painter.drawPolyline(every.mid(end - count, count))


def _write(painter, layer, plates):
    font, metrics = painter.font(), painter.fontMetrics()
    texts = list(layer.texts)
    widths = [metrics.horizontalAdvance(text) for text in texts]
    places = layer.places + (np.outer(widths, (0.5, 0.0)) if layer.left else 0.0)
    half = max([0.5 * metrics.height(), *(0.5 * width for width in widths)]) + HALO

    def write(on, text):
        path = QPainterPath()
        path.addText(-0.5 * metrics.horizontalAdvance(text), 0.35 * metrics.ascent(), font, text)
        halo = QPen(_colour(layer.halo), HALO)
        halo.setJoinStyle(Qt.RoundJoin)
        on.strokePath(path, halo)
        on.fillPath(path, QBrush(_colour(layer.colour)))

    pictures = plates.setdefault(layer.left, Sprites())
    pictures.put(painter, (layer.colour, font.key()), half, places, texts, write)
