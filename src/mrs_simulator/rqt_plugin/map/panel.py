"""The map with its buttons: mouse modes and visible layers."""

from mrs_simulator.rqt_plugin.ahead.bar import AheadBar
from mrs_simulator.rqt_plugin.map.axes import plot_area
from mrs_simulator.rqt_plugin.map.mode_menu import ModeMenu
from mrs_simulator.rqt_plugin.map.obstacle_fields import ObstacleFields
from mrs_simulator.rqt_plugin.map.obstacle_keys import HELP
from mrs_simulator.rqt_plugin.map.scene import HINTS
from mrs_simulator.rqt_plugin.map.sensor_drawing import MOST_ROBOTS
from mrs_simulator.rqt_plugin.map.view import MapView
from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QKeySequence, QPalette
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QCheckBox,
    QFrame,
    QLabel,
    QMenu,
    QShortcut,
    QToolButton,
    QWidget,
)
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.colours import CHECKED
from mrs_simulator.rqt_plugin.widgets.flow_layout import FlowLayout
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.overlay import Overlay

MODES = (
    ("look", "Look", "Drag to pan, wheel to zoom, F to fit"),
    (
        "poses",
        "Poses",
        "Drag a robot to its initial pose; with Shift, turn it. Its menu aligns and distributes",
    ),
    ("edges", "Edges", "Drag from robot i to robot j: {}. Click an edge to delete it"),
    (
        "ahead",
        "What if",
        "Drag a robot, click on an edge or move a gain, and see how the run would go on",
    ),
    ("push", "Push", "Push or hold a robot with the mouse while a simulation runs"),
    ("measure", "Measure", "Drag from one point or robot to another: distance and direction"),
    ("obstacles", "Obstacles", "Draw, move, resize, turn and delete obstacles.\n" + HELP),
)
SHOWN = (
    ("trails", "Trails", "trajectories"),
    ("forecast", "Prediction", "where theory has the robots go, before a run"),
    ("targets", "Targets", "targets of the robots"),
    ("edges", "Graph", "edges of the graph"),
    ("numbers", "Numbers", "the robots' numbers"),
    ("legend", "Legend", "legend"),
    (
        "sensors",
        "Sensors",
        "sensor readings, in 3D also what cameras see; of more than {} robots, those of the robot "
        "selected".format(MOST_ROBOTS),
    ),
)
DIRECTED = {True: "j receives from i", False: "they become neighbours"}  # what an edge is
HINT_ALPHA = 190  # [-] of 255, of the colour of the window below a hint
HIDDEN = ("sensors",)  # at first: sensors are subscribed to only while shown
MODE_KEY = "Ctrl+{}"  # of the first mode, the second and so on
TIPS = {
    mode: "{}\n({})".format(tip, MODE_KEY.format(digit))
    for digit, (mode, _, tip) in enumerate(MODES, 1)
}


@guarded
class MapPanel(QWidget):
    """Owns the ``map``; its buttons are in ``modes`` and ``shown``, by name."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self._chosen, self._hidden = 0, set()  # the robot clicked, and those without a trail
        self.map, self.modes, self.shown = MapView(), {}, {}
        self._row = FlowLayout()
        self.obstacles, self.ahead = ObstacleFields(self.map), AheadBar()
        self._build_help()
        self.map.changed.connect(guarded(self.obstacles.show_selected))
        self.map.directed_changed.connect(guarded(lambda: self._say_hint(self.map.mode)))
        self._build_modes()
        self._build_shown()
        self._build_trail()
        self._fit = fit = QToolButton(text="Fit", clicked=guarded(lambda *_: self.map.fit()))
        fit.setToolTip("Fit the team and what is near it into view (F)")
        self._row.addWidget(fit)
        column_of(self._row, (self.map, 1), owner=self, margins=0)

    def _build_modes(self):
        self._group = group = QWidget()
        group.setMinimumWidth(1)  # else no window is narrow enough to fold them
        self._row.addWidget(group)
        for mode, text, _ in MODES:
            button = QToolButton(text=text, toolTip=TIPS[mode], checkable=True, styleSheet=CHECKED)
            button.setAutoExclusive(True)
            button.toggled.connect(guarded(lambda on, m=mode: on and self._set_mode(m)))
            self.modes[mode] = button
        self.lesser = ModeMenu(self.modes)
        parts = *self.modes.values(), self.lesser
        row_of(*parts, owner=group, margins=(0, 0, 12, 0), spacing=0)
        self._say_hint("look")
        self.modes["look"].setChecked(True)
        self.lesser.fold(True)  # lest a narrow window is widened before it is first shown

    def bind_keys(self, owner):
        """Let Ctrl and a digit choose what the mouse does, while the focus is in ``owner``."""
        for digit, mode in enumerate(self.modes, 1):
            key = QShortcut(QKeySequence(MODE_KEY.format(digit)), owner)
            key.setContext(Qt.WidgetWithChildrenShortcut)
            key.activated.connect(guarded(lambda m=mode: self._choose_mode(m)))

    def _choose_mode(self, mode):
        if self.modes[mode].isEnabled():
            self.modes[mode].setChecked(True)

    def _build_help(self):
        """Build what modes offer, over the map's lower axis, and their hints, above it; the view stays."""
        self.help, self.hint = QFrame(self.map, autoFillBackground=True), QLabel(self.map, margin=2)
        self.help.setFrameShape(QFrame.StyledPanel)
        self.hint.setWordWrap(True)
        column_of(self.obstacles, self.ahead, owner=self.help, margins=(4, 1, 4, 1), spacing=1)
        Overlay(self.help, self.map, self.map.rect)
        # What lies below a hint can be seen, and clicked.
        self._tint_hint()
        self.hint.setAttribute(Qt.WA_TransparentForMouseEvents)
        self._over = Overlay(self.hint, self.map, self._above_help)
        self.help.installEventFilter(self._over)
        self.map.covered = self._covered
        self._show_help("look")

    def _above_help(self):
        """Return the part of the map's plot that is not below what the mode offers."""
        area = plot_area(self.map).toRect()
        if not self.help.isHidden():
            area.setBottom(min(area.bottom(), self.help.geometry().top() - 1))
        return area

    def _covered(self):
        """Return the height [px] of the map's plot that lies below a hint and what the mode offers."""
        area = self._above_help()
        top = area.bottom() + 1 - (0 if self.hint.isHidden() else self.hint.height())
        return max(0, plot_area(self.map).toRect().bottom() + 1 - top)

    def _tint_hint(self):
        """Give the hint the window's colour, through which the map is seen."""
        palette, ground = self.hint.palette(), self.palette().color(QPalette.Window)
        ground.setAlpha(HINT_ALPHA)
        palette.setColor(QPalette.Window, ground)
        self.hint.setPalette(palette)
        self.hint.setAutoFillBackground(True)

    def changeEvent(self, event):
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.PaletteChange and hasattr(self, "hint"):
            self._tint_hint()

    def _show_help(self, mode):
        self.obstacles.setVisible(mode == "obstacles")
        self.ahead.setVisible(mode == "ahead")
        self.help.setVisible(mode in ("obstacles", "ahead"))
        self.hint.setVisible(bool(HINTS[mode]))
        self._say_hint(mode)
        self.map.update()  # legend and scale are above them

    def _say_hint(self, mode):
        edges = DIRECTED[self.map.edges.directed]
        self.hint.setText(HINTS[mode].format(edges))
        self._over.place()
        if "edges" in self.modes:
            self.modes["edges"].setToolTip(TIPS["edges"].format(edges))

    def _build_shown(self):
        for name, text, tip in SHOWN:
            button = QCheckBox(text, toolTip="Show or hide " + tip, checked=name not in HIDDEN)
            self._row.addWidget(button)
            button.toggled.connect(guarded(lambda on, layer=name: self.map.set_shown(layer, on)))
            self.shown[name] = button
        self._build_layers()

    def _build_layers(self):
        """Build a menu of what is shown, in place of the boxes where these would take another line."""
        self.layers, menu = QToolButton(text="Show"), QMenu(self, toolTipsVisible=True)
        self.layers.setToolTip("Show or hide parts of the map")
        self.layers.setPopupMode(QToolButton.InstantPopup)
        for box in self.shown.values():
            entry = menu.addAction(box.text())
            entry.setToolTip(box.toolTip())
            entry.setCheckable(True)
            entry.setChecked(box.isChecked())
            entry.toggled.connect(box.setChecked)
            box.toggled.connect(entry.setChecked)
        self.layers.setMenu(menu)
        self.layers.hide()
        self._row.addWidget(self.layers)

    def resizeEvent(self, event):
        """Put boxes and buttons where there is room for them."""
        super().resizeEvent(event)
        self.lesser.fold(self._least_width() > self.width())
        # That of the trail too, whether a robot is selected or not: else the map would move.
        row = [*self.shown.values(), self._group, self._fit, self.trail]
        wide = sum(each.sizeHint().width() + self._row.spacing() for each in row)
        for box in self.shown.values():
            box.setVisible(wide <= self.width())
        self.layers.setVisible(wide > self.width())
        self._show_trail()

    def _least_width(self):
        """Return the width [px] of a row with the buttons of all modes, and a menu of layers."""
        modes = sum(button.sizeHint().width() for button in self.modes.values())
        rest = (self.layers, self._fit)
        return modes + sum(each.sizeHint().width() + 3 * self._row.spacing() for each in rest)

    def _build_trail(self):
        self.trail = QCheckBox("Trail of ...", visible=False, toggled=self._on_trail)
        self.trail.setToolTip("Show or hide the trajectory of the robot selected")
        self._row.addWidget(self.trail)
        self._trail_entry = self.layers.menu().addAction(self.trail.text())
        self._trail_entry.setCheckable(True)
        self._trail_entry.setVisible(False)
        self._trail_entry.toggled.connect(self.trail.setChecked)
        self.trail.toggled.connect(self._trail_entry.setChecked)

    def _set_mode(self, mode):
        self.map.set_mode(mode)
        self._show_help(mode)
        if self.isVisible():
            self.map.setFocus()  # which takes the keys of the mode

    def set_editable(self, mode, editable, why=""):
        """Let poses or obstacles be edited or not; ``why`` not, in the tooltip."""
        button, tip = self.modes[mode], TIPS[mode]
        button.setEnabled(editable)
        button.setToolTip(tip if editable else "{}\nNot now: {}".format(tip, why))
        if not editable and button.isChecked():
            self.modes["look"].setChecked(True)

    def choose(self, number):
        """Highlight the robot ``number``, 0 for none, and offer its trail."""
        self._chosen = number
        self.map.select(number)
        self.trail.setText("Trail of {}".format(number))
        self.trail.blockSignals(True)
        self.trail.setChecked(number not in self._hidden)
        self.trail.blockSignals(False)
        self._trail_entry.setText(self.trail.text())
        self._trail_entry.setChecked(self.trail.isChecked())
        self._show_trail()

    def _show_trail(self):
        """Offer the trail of the robot selected in the row, or in the menu where layers are in that."""
        self.trail.setVisible(self._chosen > 0 and self.layers.isHidden())
        self._trail_entry.setVisible(self._chosen > 0)

    def _on_trail(self, shown):
        (self._hidden.discard if shown else self._hidden.add)(self._chosen)
        self.map.set_trail_shown(self._chosen, shown)
