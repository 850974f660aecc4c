"""Small pictures of runs' trajectories, drawn in a thread."""

import queue
import threading

import numpy as np

from mrs_simulator.rqt_plugin.qt.QtCore import QPointF, QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QImage, QPainter, QPen, QPolygonF
from mrs_simulator.rqt_plugin.shelf.entry import BAG, is_run
from mrs_simulator.rqt_plugin.shelf.tracks import tracks_of
from mrs_simulator.rqt_plugin.widgets.colours import shade
from mrs_simulator.rqt_plugin.widgets.guard import LOG
from mrs_simulator.study.draw.figure_parts import START_COLOUR
from mrs_simulator.study.run.sweep_plan import read_table, swept, values_of
from mrs_simulator.verdict.verdict import FAILED, PASSED

FINE = 2  # [-] pixels of the picture for one of its size
RIM = 0.08  # [-] of the picture
LINE, DOT = 1.3, 1.8  # [px]
OF_OUTCOME, UNJUDGED = {PASSED: "#4393c3", FAILED: "#d6604d"}, "#b0b0b0"  # of a sweep's cells


def thumbnail(path, width, height, ground):
    """Return a ``QImage`` of the trajectories in the ``run.csv`` at ``path``; may be made in any thread.

    ``width``, ``height`` [px]; ``ground``: the ``QColor`` of the background.  Starts are red points, ends
    points of the robots' colours.  Raises ``OSError`` and ``ValueError``.
    """
    image = QImage(FINE * width, FINE * height, QImage.Format_RGB32)
    image.fill(QColor(ground))
    tracks = {
        number: track for number, track in tracks_of(path).items() if np.isfinite(track).all()
    }
    if not tracks:
        return image
    to_pixels, count = _fitting(tracks.values(), image.width(), image.height()), max(tracks)
    painter = QPainter(image)
    try:
        painter.setRenderHint(QPainter.Antialiasing)
        for number, track in tracks.items():
            _draw(painter, to_pixels(track), shade(number, count, ground))
    finally:
        painter.end()
    return image


def sweep_thumbnail(path, width, height, ground):
    """Return a ``QImage`` of the cells of the sweep at ``path`` by what came of them.

    As :func:`thumbnail`; blue has passed, red has not, grey was not judged.
    """
    image = QImage(FINE * width, FINE * height, QImage.Format_RGB32)
    image.fill(QColor(ground))
    rows = read_table(path)
    if not rows:
        return image
    columns, lines = _grid(rows)
    wide, high = image.width() / len(columns), image.height() / len(lines)
    painter = QPainter(image)
    try:
        for row, (x, y) in zip(rows, _places(rows)):
            cell = QRectF(
                columns.index(x) * wide, (len(lines) - 1 - lines.index(y)) * high, wide, high
            )
            painter.fillRect(cell, QColor(OF_OUTCOME.get(row["outcome"], UNJUDGED)))
    finally:
        painter.end()
    return image


def _places(rows):
    """Return the first two values of each of a sweep's ``rows``; of one key the second is 0."""
    keys = swept(rows)
    values = (list(values_of(row, keys).values()) for row in rows)
    return [tuple((each + [0, 0])[:2]) for each in values]


def _grid(rows):
    """Return the values along x and along y, numbers ascending."""
    places = _places(rows)
    return [sorted({each[axis] for each in places}, key=_order) for axis in (0, 1)]


def _order(value):
    return (0, value, "") if isinstance(value, (int, float)) else (1, 0, value)


def _fitting(tracks, width, height):
    """Return a function from points (m, 2) [m] to pixels in which all ``tracks`` fit, to one scale."""
    points, size = np.concatenate(list(tracks)), np.array([width, height])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = np.min((1.0 - 2.0 * RIM) * size / np.maximum(high - low, 1e-3))
    middle = 0.5 * (low + high)
    return lambda track: 0.5 * size + (track - middle) * scale * (1.0, -1.0)


def _draw(painter, line, hue):
    painter.setPen(QPen(hue, FINE * LINE, Qt.SolidLine, Qt.RoundCap, Qt.RoundJoin))
    painter.setBrush(Qt.NoBrush)
    painter.drawPolyline(QPolygonF([QPointF(x, y) for x, y in line.tolist()]))
    painter.setPen(Qt.NoPen)
    for place, colour in ((line[0], QColor(START_COLOUR)), (line[-1], hue)):
        painter.setBrush(colour)
        painter.drawEllipse(QPointF(*place.tolist()), FINE * DOT, FINE * DOT)


class Thumbnails:
    """Draws pictures in a thread; each once, until its run or its look changes."""

    def __init__(self):
        self._wanted, self._made = queue.LifoQueue(), queue.SimpleQueue()
        self._images, self._thread = {}, None

    def of(self, entry, width, height, ground):
        """Return the picture of an ``Entry``, None until it is made, and of a bag."""
        if entry.path.endswith(BAG):
            return None
        look = entry.time, width, height, ground.rgb()
        kept, image = self._images.get(entry.path, (None, None))
        if kept != look:
            # the one before stays until the new one is there
            self._images[entry.path] = (look, image)
            self._wanted.put((entry.path, entry.data, look))
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, daemon=True)
                self._thread.start()
        return image

    def take(self):
        """Take in what was made; return whether there was any."""
        taken = False
        while not self._made.empty():
            path, look, image = self._made.get()
            if self._images.get(path, (None,))[0] == look:
                self._images[path] = look, image
                taken = True
        return taken

    def close(self):
        """End the thread."""
        self._wanted.put(None)

    def _work(self):
        for path, data, look in iter(self._wanted.get, None):
            _, width, height, ground = look
            try:
                draw, source = (thumbnail, data) if is_run(path) else (sweep_thumbnail, path)
                image = draw(source, width, height, QColor(ground))
            except (OSError, ValueError, KeyError):
                continue  # of a run that is being written, or is broken: it is listed without one
            except Exception:
                LOG.exception("in a picture of %s", data)
                continue
            self._made.put((path, look, image))
