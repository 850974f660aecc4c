"""What the picker shows of each scenario, read and drawn in a thread."""

import queue
import re
import threading
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.fields import counted
from mrs_simulator.protocols import HOMES, shipped
from mrs_simulator.protocols.making import make_control
from mrs_simulator.rqt_plugin.map.style import mixed
from mrs_simulator.rqt_plugin.qt.QtCore import QLineF, QPointF, QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QImage, QPainter, QPen, QPolygonF
from mrs_simulator.rqt_plugin.widgets.colours import shade
from mrs_simulator.rqt_plugin.widgets.guard import LOG
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.scenario.surroundings.obstacles import Cylinder, corners, is_flat

FINE = 2  # [-] pixels of a picture for one of its size
SIZE = (136, 102)  # [px] at the usual size of the font
RIM = 0.12  # [-] of a picture
MOST_EDGES = 200  # [-] drawn
DOT, CROSS = 4.2, 2.8  # [px] radii of a robot and of a target


class Card(NamedTuple):
    """A scenario as it is offered."""

    path: str
    title: str
    about: str  # law, number and kinds of robots
    theorem: str  # the first sentence of the law's theorem, "" of a user's law
    image: Any  # a ``QImage``, None where there is none
    wrong: str = ""  # why the file cannot be read


def card_of(path, ground, text):
    """Return the ``Card`` of the scenario file at ``path``, in any thread.

    ``ground``, ``text``: the ``QColor`` of background and text.
    """
    try:
        scenario = load_scenario(path)
    except (ValueError, OSError) as error:
        return Card(path, "", "", "", None, str(error))
    law = scenario.control.protocol
    kinds = ", ".join(dict.fromkeys(scenario.kinds))
    about = " \u00b7 ".join((law, counted(scenario.n, "robot"), kinds))
    is_own = law in HOMES
    theorem = theorem_of(law) if is_own else ""
    targets = _targets(scenario) if is_own else None  # a user's law is not run to be offered
    return Card(path, scenario.title, about, theorem, picture(scenario, targets, ground, text))


def theorem_of(name):
    """Return the first sentence of a shipped protocol's theorem."""
    for part in re.split(r"\n\s*\n", shipped(name).__doc__.strip()):
        text = " ".join(part.split()).replace("``", "")
        if text.startswith("Theorem: "):
            text = text.partition(": ")[2].partition(". ")[0].rstrip(".") + "."
            return text[0].upper() + text[1:]
    return ""


def _targets(scenario):
    try:
        control = make_control(scenario)
        return control.targets(control.points(scenario.starts))
    except Exception:  # a picture without them says enough
        LOG.debug("no targets of %s", scenario.title, exc_info=True)
        return None


def picture(scenario, targets, ground, text):
    """Return a ``QImage`` of a scenario's start, with its graph, obstacles and ``targets`` (n, d)."""
    image = QImage(FINE * SIZE[0], FINE * SIZE[1], QImage.Format_RGB32)
    image.fill(ground)
    starts = scenario.poses[:, :2]
    targets = None if targets is None or len(targets) != scenario.n else targets[:, :2]
    to_pixels = _fitting(starts if targets is None else np.vstack([starts, targets]), image)
    painter = QPainter(image)
    try:
        painter.setRenderHint(QPainter.Antialiasing)
        _draw_obstacles(painter, obstacles_of(scenario), to_pixels, ground, text)
        at = to_pixels(starts)
        edges = scenario.topology.edges[:MOST_EDGES] if scenario.topology else ()
        painter.setPen(QPen(mixed(ground, text, 0.3), FINE))
        painter.drawLines([QLineF(*at[i - 1], *at[j - 1]) for i, j, *_ in edges] or [QLineF()])
        hues = [shade(number, scenario.n, ground) for number in range(1, scenario.n + 1)]
        if targets is not None:
            _draw_ways(painter, at, to_pixels(targets), hues)
        painter.setPen(Qt.NoPen)
        for place, hue in zip(at, hues):
            painter.setBrush(hue)
            painter.drawEllipse(QPointF(*place), FINE * DOT, FINE * DOT)
    finally:
        painter.end()
    return image


def _draw_ways(painter, starts, ends, hues):
    size = FINE * CROSS
    for begin, (x, y), hue in zip(starts, ends, hues):
        painter.setPen(QPen(hue, FINE, Qt.DotLine))
        painter.drawLine(QLineF(*begin, x, y))
        painter.setPen(QPen(hue, 1.3 * FINE))
        painter.drawLine(QLineF(x - size, y - size, x + size, y + size))
        painter.drawLine(QLineF(x - size, y + size, x + size, y - size))


def _draw_obstacles(painter, obstacles, to_pixels, ground, text):
    painter.setPen(Qt.NoPen)
    for each in obstacles:
        painter.setBrush(mixed(ground, text, 0.1 if is_flat(each) else 0.3))
        if isinstance(each, Cylinder):
            (low, high) = to_pixels(
                [
                    (each.x - each.radius, each.y + each.radius),
                    (each.x + each.radius, each.y - each.radius),
                ]
            )
            painter.drawEllipse(QRectF(QPointF(*low), QPointF(*high)))
        else:
            painter.drawPolygon(QPolygonF([QPointF(*p) for p in to_pixels(corners(each))]))


def _fitting(points, image):
    """Return a function from points (m, 2) [m] to a list of (x, y) [px] in which ``points`` fit."""
    size = np.array([image.width(), image.height()])
    points = points[np.isfinite(points).all(axis=1)]
    low, high = points.min(axis=0), points.max(axis=0)
    scale = np.min((1.0 - 2.0 * RIM) * size / np.maximum(high - low, 1.0))
    middle = 0.5 * (low + high)
    return lambda each: (
        0.5 * size + (np.asarray(each, dtype=float)[:, :2] - middle) * scale * (1.0, -1.0)
    ).tolist()


class Cards:
    """Makes cards in a thread, one after the other, until it is closed."""

    def __init__(self, paths, ground, text):
        self._made, self._ends = queue.SimpleQueue(), threading.Event()
        arguments = list(paths), QColor(ground), QColor(text)
        self._thread = threading.Thread(target=self._work, args=arguments, daemon=True)
        self._thread.start()

    def take(self):
        """Return the cards made since the last call."""
        taken = []
        while not self._made.empty():
            taken.append(self._made.get())
        return taken

    def is_done(self):
        """Return whether no more will come."""
        return not self._thread.is_alive() and self._made.empty()

    def close(self):
        """End the thread once its present card is made."""
        self._ends.set()

    def _work(self, paths, ground, text):
        for path in paths:
            if self._ends.is_set():
                return
            try:
                self._made.put(card_of(path, ground, text))
            except Exception:
                LOG.exception("in a picture of %s", path)
