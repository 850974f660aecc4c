"""The picture of the 3D view, and the mouse on it."""

import time

import numpy as np

from mrs_simulator.pictures.camera import STEEPEST, Camera, on_screen
from mrs_simulator.pictures.moving_parts import Odometer
from mrs_simulator.pictures.palette import DARK, LIGHT
from mrs_simulator.pictures.scene import drawn, drawn_signs, framed
from mrs_simulator.rqt_plugin.qt.QtCore import QSize, Qt, QTimer, Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QPainter
from mrs_simulator.rqt_plugin.qt.QtWidgets import QSizePolicy, QWidget
from mrs_simulator.rqt_plugin.view.graphics_card import graphics_card
from mrs_simulator.rqt_plugin.view.painting import paint
from mrs_simulator.rqt_plugin.widgets.colours import DARK as DARK_GROUND
from mrs_simulator.rqt_plugin.widgets.guard import LOG, guarded

YAW, ASIDE = 20.0, (0, 15, -15, 30, -30, 45, -45)  # [deg] of the first view, and from there
TURN = 0.4  # [deg] of the camera for a pixel of the mouse
ZOOM = 1.15  # [-] for a notch of the wheel
CLOSE = 12.0  # [-] of its reach: how far from a robot one is that follows it
LEAST_RIM = 16.0  # [px]
NUMBER = 34.0  # [px] from a robot up to its number's upper edge
STILL, LEAST_HIT = 4, 10.0  # [px] of an unsteady click; about a robot that is far away
STILL_FOR = 0.5  # [s] without a change, after which a picture by software is made fine
RIM = 0.03  # [-] of the picture, in which a robot counts as having left it
TOO_FAR = 0.55  # [-] of its distance: a camera that could be so near to the team goes there
ROOM = 1.25  # [-] of the distance from which the team is just in view, once a robot has left


@guarded
class Canvas(QWidget):
    """Paints a ``Scene`` as its ``camera`` has it."""

    robot_clicked = Signal(int)  # number, 0 of a click beside all robots

    def __init__(self, parent=None):
        super().__init__(parent)
        self.camera = Camera(yaw=YAW)
        self.cost = 0.0  # [s] of processor time that the last picture took, in all threads
        self.scene, self._followed, self._last, self._plates = None, 0, None, {}
        self._odometer = Odometer()
        self._moved = 0.0  # [s] of wall time, when what is shown changed
        self.refining = QTimer(self, interval=int(1e3 * STILL_FOR), singleShot=True)
        self.refining.timeout.connect(self.update)
        self._pressed = None  # where a click or drag began
        self.card = graphics_card()
        self._aside = self.camera.yaw, self.camera.pitch  # [deg] before it looked straight down
        self._untouched = True  # the camera is still the one that fit() chose
        self.setMinimumSize(160, 100)
        self.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Expanding)
        self.setFocusPolicy(Qt.ClickFocus)

    def sizeHint(self):
        """Return the preferred size."""
        line = self.fontMetrics().height()
        return QSize(40 * line, 24 * line)

    def show_scene(self, scene):
        """Show ``scene``, a ``Scene``; its wheels turn by how far the robots went since the one before."""
        state = scene.state
        if self.scene is None or not np.array_equal(self.scene.place, scene.place):
            self._moved = time.monotonic()
        self.scene = scene._replace(rolled=self._odometer.at(state.robots, state.pose))
        self._keep_in_view()
        self.update()

    def _is_fine(self):
        """Return whether the picture is to be of fine edges; begin to wait for that where it is not yet.

        Where OpenGL runs on the processor half of a picture's cost are its edges.
        """
        still = time.monotonic() - self._moved >= STILL_FOR
        if still or not self.card.is_software:
            return True
        self.refining.start()
        return False

    def follow(self, number):
        """Keep robot ``number`` in the middle, none where it is 0."""
        if number and number != self._followed and self.scene is not None:
            reach = max(kind.body.reach for kind in self.scene.kinds)
            self.camera = self.camera._replace(distance=max(CLOSE * reach, 0.5))
        self._followed = number
        self._keep_in_view()
        self.update()

    def look_down(self):
        """Look straight down, north up; from there, as one did before."""
        camera = self.camera
        if camera.pitch > STEEPEST:
            self._aside = camera.yaw, camera.pitch
            self.camera = camera._replace(yaw=0.0, pitch=STEEPEST)
        else:
            yaw, pitch = self._aside
            self.camera = camera._replace(yaw=yaw, pitch=pitch)
        if self._untouched and not self._followed:
            self._frame(self.scene)
        self.update()

    def fit(self, anew=False):
        """Bring the team, its targets and what is near into view.

        ``anew``: from where they fill the picture, within ``ASIDE`` of the usual direction.
        """
        self._untouched = True
        if anew and self.scene is not None and self.camera.pitch > STEEPEST:
            ways = [self.camera._replace(yaw=YAW + each) for each in ASIDE]
            self.camera = min(ways, key=lambda way: self._framed(self.scene, way).distance)
        self._frame(self.scene)
        self.update()

    def _framed(self, scene, camera):
        return framed(scene, camera, self.width(), self.height(), whole=False)

    def _frame(self, scene, room=1.0):
        if scene is not None and len(scene.state.robots):
            self.camera = self._framed(scene, self.camera).zoomed(room)

    def _keep_in_view(self):
        """Aim at the robot that is followed, else step back once a robot leaves an untouched view."""
        scene = self.scene
        if scene is None or self._last is not None:
            return
        if self._followed in scene.state.robots:
            place = scene.place[scene.state.robots.index(self._followed)]
            if np.isfinite(place).all():
                self.camera = self.camera.at(place)
        elif self._untouched and len(scene.state.robots):
            self._reframe(scene)

    def _reframe(self, scene):
        """Step back where a robot leaves the view, come nearer where the team fills little of it."""
        if not self._sees(scene.place):
            self._frame(scene, ROOM)
        elif self._framed(scene, self.camera).distance < TOO_FAR * self.camera.distance:
            self._frame(scene)

    def _sees(self, place):
        """Return whether all of ``place`` (n, 3) [m] that is known is well within the picture."""
        seen = self.camera.seen(place[np.isfinite(place).all(axis=1)])
        if not (seen[:, 2] > 0.0).all():
            return False
        size = np.array([self.width(), self.height()])
        at = on_screen(seen, *size)
        rim = np.maximum(RIM * size, LEAST_RIM)
        low = np.maximum(rim, (0.0, NUMBER))
        return bool(((at >= low) & (at <= size - rim)).all())

    def paintEvent(self, _):
        """Paint the scene, or a text where there is none."""
        begun, painter = time.process_time(), QPainter(self)
        try:
            if self.scene is None or not len(self.scene.state.robots):
                painter.drawText(self.rect(), Qt.AlignCenter, "No robots")
                return
            dark = self.palette().base().color().lightnessF() < DARK_GROUND
            look = DARK if dark else LIGHT
            painter.setRenderHint(QPainter.Antialiasing)
            painter.setFont(self.font())
            self._paint_scene(painter, look)
        finally:
            painter.end()  # even if the traceback of an error holds it for a while
            self.cost = time.process_time() - begun

    def _paint_scene(self, painter, look):
        """Paint the scene, its bodies by the graphics card where there is one."""
        seen = self.scene, self.camera, self.width(), self.height(), look
        if self.card is None or not self.card.suits(self.scene):
            paint(painter, drawn(*seen), self._plates)
            return
        ratio = self.devicePixelRatioF()
        size = [max(1, int(ratio * side)) for side in (self.width(), self.height())]
        try:
            image = self.card.picture(self.scene, self.camera, size, look, self._is_fine())
        except Exception as error:  # whatever drivers do, the painter is there
            LOG.warning("the 3D view goes on without OpenGL: %s", error)
            self.card = None
            paint(painter, drawn(*seen), self._plates)
            return
        painter.drawImage(self.rect(), image)
        paint(painter, drawn_signs(*seen), self._plates)

    def resizeEvent(self, event):
        """Keep an untouched team in view."""
        super().resizeEvent(event)
        if self._untouched and not self._followed:
            self._frame(self.scene)

    def mousePressEvent(self, event):
        """Begin to orbit or pan."""
        self._last = self._pressed = event.pos()

    def mouseMoveEvent(self, event):
        """Orbit, or pan with Shift or a button other than the left one."""
        if self._last is None:
            return
        moved, self._last = event.pos() - self._last, event.pos()
        if event.buttons() == Qt.LeftButton and not event.modifiers() & Qt.ShiftModifier:
            self.camera = self.camera.turned(-TURN * moved.x(), -TURN * moved.y())
        else:
            self.camera = self.camera.panned(moved.x(), -moved.y(), self.height())
        self._untouched = False
        self.update()

    def mouseReleaseEvent(self, event):
        """End the drag; of a click choose the robot there."""
        self._last, pressed = None, self._pressed
        still = pressed is not None and (event.pos() - pressed).manhattanLength() <= STILL
        if still and event.button() == Qt.LeftButton:
            self.robot_clicked.emit(self.robot_at(event.x(), event.y()))

    def robot_at(self, x, y):
        """Return the number of the robot at (x, y) [px], the nearest to the eye, 0 for none."""
        scene = self.scene
        if scene is None or not len(scene.state.robots):
            return 0
        half = 0.5 * np.array([kind.body.height for kind in scene.kinds])
        seen = self.camera.seen(scene.place + np.outer(half, (0.0, 0.0, 1.0)))
        reach = np.array([kind.body.reach for kind in scene.kinds])
        with np.errstate(invalid="ignore", divide="ignore"):
            at = on_screen(seen, self.width(), self.height())
            aside = seen + np.outer(reach, (1.0, 0.0, 0.0))
            size = np.hypot(*(on_screen(aside, self.width(), self.height()) - at).T)
            away = np.hypot(*(at - (x, y)).T)
            hit = (seen[:, 2] > 0.0) & (away <= np.maximum(size, LEAST_HIT))
        rows = np.flatnonzero(hit)
        return int(scene.state.robots[rows[np.argmin(seen[rows, 2])]]) if len(rows) else 0

    def wheelEvent(self, event):
        """Zoom."""
        self._untouched = False
        self.camera = self.camera.zoomed(ZOOM ** (-event.angleDelta().y() / 120.0))
        event.accept()
        self.update()
