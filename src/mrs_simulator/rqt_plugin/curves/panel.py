"""The curves panel: curves under the mouse, which zooms, pans and names them."""

import math

import numpy as np
from matplotlib.colors import to_hex

from mrs_simulator.rqt_plugin.curves.drawn import DrawnCurves
from mrs_simulator.rqt_plugin.curves.plot import DPI, CurvesPlot
from mrs_simulator.rqt_plugin.curves.quantities import ERROR, QUANTITIES
from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QFontInfo, QPalette
from mrs_simulator.rqt_plugin.qt.QtWidgets import QFrame, QLabel, QMenu
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.study.draw.canvas import HEIGHT, STYLE, WIDTH, save

ZOOM = 0.8  # of one step of the wheel
PAPER = (1.0, 1.0, 1.0), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)  # around and in the axes; text


@guarded
class CurvesPanel(DrawnCurves):
    """Curves that are zoomed by the wheel and panned by a drag; the one under the mouse is named."""

    time_chosen = Signal(float)  # [s] of the history, by a click
    robot_clicked = Signal(int)  # the number of the robot whose curve was clicked
    export_asked = Signal(str)  # a name of ``run.bar.EXPORTS``

    def __init__(self, parent=None):
        super().__init__(parent)
        self._grip, self._pointer = None, None  # [pixels] where the mouse drags, and points
        # [pixels] of a click; [s] of the line, None for none
        self._pressed, self.moment = None, None
        self.label, self._dot = QLabel(self.canvas), QLabel(self.canvas)
        self._line = QFrame(self.canvas)
        for sign in (self.label, self._dot, self._line):
            sign.setAttribute(Qt.WA_TransparentForMouseEvents)
            sign.hide()
        connect = self.canvas.mpl_connect
        connect("scroll_event", self._on_wheel)
        connect("button_press_event", self._on_press)
        connect("motion_notify_event", self._on_motion)
        connect("button_release_event", self._on_release)
        connect("figure_leave_event", self._on_leave)
        self.menu = None
        self.canvas.setContextMenuPolicy(Qt.CustomContextMenu)
        self.canvas.customContextMenuRequested.connect(self._on_menu)

    def as_csv(self):
        """Return the curves shown as CSV: a column of times [s], and one for each curve."""
        found, quantity = self._data()[0], QUANTITIES[self._index()]
        time = np.unique(np.concatenate([curve.time for curve in found] or [[]]))
        head = ["{} {} [{}]".format(curve.name, quantity.tab, quantity.unit) for curve in found]
        table = np.full((len(time), len(found)), np.nan)
        for column, curve in enumerate(found):
            table[np.searchsorted(time, curve.time), column] = curve.values
        rows = [",".join("" if math.isnan(v) else "{:.9g}".format(v) for v in row) for row in table]
        lines = [",".join(["time [s]", *head])]
        lines += ["{:.9g},{}".format(*pair) for pair in zip(time, rows)]
        return "\n".join(lines) + "\n"

    def save_picture(self, path):
        """Write the curves shown to ``path``, ``.png``, ``.pdf`` or ``.svg``, as a page wide."""
        self._prepare()
        shown, self.plot = self.plot, CurvesPlot((WIDTH, HEIGHT))
        try:
            pixels = STYLE["font.size"] / 72.0 * DPI
            self.plot.take_look(
                STYLE["font.serif"][0], pixels, *PAPER, math=STYLE["mathtext.fontset"]
            )
            self._show_data()
            save(self.plot.figure, path)
        finally:
            self.plot = shown

    def _on_drawn(self):
        self._point_out()
        self._place_line()

    def _on_menu(self, place):
        """Offer what can be done with the curves, and with the one at ``place`` (a ``QPoint``)."""
        ratio = self.canvas.devicePixelRatioF()
        at = place.x() * ratio, (self.canvas.height() - place.y()) * ratio
        found = self.plot.nearest(*at) if self._drawn is not None else None
        self.menu = menu = QMenu(self)
        menu.setAttribute(Qt.WA_DeleteOnClose)
        for text, action in self._entries(found[0].robot if found else 0):
            menu.addAction(text).triggered.connect(guarded(lambda *_, do=action: do()))
        menu.popup(self.canvas.mapToGlobal(place))

    def _entries(self, robot):
        """Return the menu's texts, and what they do; ``robot``: the number of that of a curve, or 0."""
        if robot:
            yield "Select robot {}".format(robot), lambda: self.robot_clicked.emit(robot)
            yield "Robot {} alone".format(robot), lambda: self.field.setText(str(robot))
        if self.field.text():
            yield "All robots", self.field.clear
        yield "Whole run", self.see_all
        if not self.follow.isChecked():
            yield "Follow the newest", lambda: self.follow.setChecked(True)
        yield "Copy the curves", lambda: self.export_asked.emit("table")
        yield "Picture of the curves...", lambda: self.export_asked.emit("curves")
        yield "Compose a figure...", lambda: self.export_asked.emit("figure")

    def show_moment(self, time):
        """Show a line at ``time`` [s] of the history, None for none."""
        moment = None if time is None else time - self.source.begin
        if moment != self.moment:
            self.moment = moment
            self._place_line()

    def _place_line(self):
        """Put the line where its moment is, if that is in view; the figure is not drawn anew."""
        axes, ratio = self.plot.axes, self.canvas.devicePixelRatioF()
        low, high = axes.get_xlim()
        drawn = self.moment is not None and self._drawn is not None
        seen = drawn and bool(low <= self.moment <= high)
        self._line.setVisible(seen)
        if seen:
            x = axes.transData.transform((self.moment, axes.get_ylim()[0]))[0] / ratio
            box, wide = axes.bbox, max(1, QFontInfo(self.font()).pixelSize() // 8)
            top = self.canvas.height() - box.y1 / ratio
            self._line.setGeometry(int(x - wide / 2), int(top), wide, int(box.height / ratio))
            hue = self.palette().color(QPalette.Highlight).name()
            self._line.setStyleSheet("background: {};".format(hue))

    def _point_out(self):
        """Name the curve nearest to the mouse, in a label beside it."""
        found = None
        if self._pointer is not None and self._grip is None and self._drawn is not None:
            found = self.plot.nearest(*self._pointer)
        self.label.setVisible(found is not None)
        self._dot.setVisible(found is not None)
        if found is None:
            return
        curve, place, time = found
        value = np.interp(time, curve.time, curve.values)
        unit = QUANTITIES[self._index()].unit
        self.label.setText("{}:  {:.2f} s,  {:.4g} {}".format(curve.name, time, value, unit))
        self._set_signs(place, to_hex(curve.style["color"]))

    def _set_signs(self, place, hue):
        """Put dot and label at ``place`` [pixels], whole, in the curve's colour."""
        ratio, em = self.canvas.devicePixelRatioF(), QFontInfo(self.font()).pixelSize()
        x, y = int(place[0] / ratio), int(self.canvas.height() - place[1] / ratio)
        half = max(3, em // 3)
        self._dot.setStyleSheet("border: 2px solid {}; border-radius: {}px;".format(hue, half))
        self._dot.setGeometry(x - half, y - half, 2 * half, 2 * half)
        base, text = (self.palette().color(role).name() for role in (QPalette.Base, QPalette.Text))
        sheet = "color: {}; background: {}; border: 1px solid {}; padding: 2px;"
        self.label.setStyleSheet(sheet.format(text, base, hue))
        self.label.adjustSize()
        left, above = x + em, y - em - self.label.height()
        if left + self.label.width() > self.plot.axes.bbox.x1 / ratio:
            left = max(0, x - em - self.label.width())
        self.label.move(left, above if above >= 0 else y + em)

    def _see(self, left, low, right, high):
        """Show what lies between these pixels now."""
        follow, data = self.follow.isChecked(), self.plot.axes.transData.inverted()
        x, y = data.transform([[left, low], [right, high]]).T
        log = self._index() == ERROR
        fine = np.isfinite([x, y]).all() and 1e-3 < x[1] - x[0] < 1e8
        if not fine or y[1] - y[0] < 1e-9 * np.abs(y).max() or np.abs(y).max() > 1e15:
            return
        if log and not 1e-200 < y[0] * 1.01 < y[1]:
            return
        self._xlim, self._ylim = tuple(x), None if follow else tuple(y)
        self.plot.axes.set_xlim(x)
        if not follow:
            self.plot.axes.set_ylim(y)
        self._renew()

    def see_all(self):
        """Show the whole run."""
        self._xlim, self._ylim = None, None
        self._renew()

    def _on_wheel(self, event):
        box, follow = self.plot.axes.bbox, self.follow.isChecked()
        factor = ZOOM ** float(np.clip(event.step, -3, 3))
        across = factor if event.x >= box.x0 else 1.0
        along = factor if event.y >= box.y0 and not follow else 1.0
        x, y = box.x1 if follow else event.x, event.y
        low, high = y + (box.y0 - y) * along, y + (box.y1 - y) * along
        self._see(x + (box.x0 - x) * across, low, x + (box.x1 - x) * across, high)

    def _on_press(self, event):
        if event.dblclick:
            self.see_all()
        elif event.button == 1 and self.plot.axes.bbox.contains(event.x, event.y):
            self._grip = self._pressed = event.x, event.y

    def _on_motion(self, event):
        self._pointer = event.x, event.y
        if self._grip is not None:
            x, y = self._grip[0] - event.x, self._grip[1] - event.y
            if self.follow.isChecked() and np.hypot(x, y) < self._reach():
                return  # a click of an unsteady hand
            self.follow.setChecked(False)
            box = self.plot.axes.bbox
            self._see(box.x0 + x, box.y0 + y, box.x1 + x, box.y1 + y)
            self._grip = self._pointer
        self._point_out()

    def _on_release(self, event):
        self._grip, pressed, self._pressed = None, self._pressed, None
        if pressed is None or np.hypot(event.x - pressed[0], event.y - pressed[1]) > self._reach():
            return
        found = self.plot.nearest(*pressed)
        if found is not None and found[0].robot:
            self.robot_clicked.emit(found[0].robot)
        time = self.plot.axes.transData.inverted().transform(pressed)[0]
        self.time_chosen.emit(float(time) + self.source.begin)

    def _reach(self):
        """Return how far [pixels] an unsteady hand moves the mouse in a click."""
        return 0.4 * self.plot.em()

    def _on_leave(self, _event):
        self._pointer = None
        self._point_out()
