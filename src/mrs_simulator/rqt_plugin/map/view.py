"""The map: a team of robots seen from above, in metres, and its editing with the mouse."""

import collections
import math
import time
from typing import NamedTuple

import numpy as np
from python_qt_binding.QtCore import QEvent, QSize, Qt, QTimer, Signal
from python_qt_binding.QtGui import QPainter
from python_qt_binding.QtWidgets import QSizePolicy, QToolTip, QWidget

from mrs_simulator.core.scenario import DEFAULT_KIND
from mrs_simulator.rqt_plugin.map import axes, drawing, geometry
from mrs_simulator.rqt_plugin.map.ground import Ground
from mrs_simulator.rqt_plugin.map.shapes import Shapes
from mrs_simulator.rqt_plugin.map.sprites import Sprites
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.vehicles import kind
from mrs_simulator.world.bodies import Bodies

HINTS = {
    "look": "",
    "poses": "Drag a robot to move it, with Shift or the right button to turn it",
    "edges": "Drag from robot i to robot j: j hears i.  Click on an edge to remove it",
}
CLICK = 4.0  # [px] that the mouse may move within a click
ZOOM = 1.2  # [-] of one notch of the wheel
ROOM = 0.3  # around a moving team when the view follows it, as a share of its larger side
FLASH_PERIOD = 40  # [ms]
MOST_FLASHES = 50
MOST_EDGES = 40000  # [-] looked at when painting


class Drag(NamedTuple):
    """What the mouse does while a button is down."""

    kind: str  # pan, move, turn or edge
    row: int  # of the robot pressed, -1 for none
    press: np.ndarray  # (2,) [px]
    grip: np.ndarray  # (2,) [m] from the cursor to the robot
    button: int


class MapView(QWidget):
    """Robots, targets, trails, obstacles and edges in the plane; robots are numbered from 1."""

    pose_edited = Signal(int, float, float, float)  # number, x [m], y [m], theta [rad]
    edge_added = Signal(int, int)  # i hears j
    edge_removed = Signal(int, int)
    robot_clicked = Signal(int)

    def __init__(self, parent=None):
        super().__init__(parent)
        self._frame, self._ground = geometry.Frame(), Ground()
        self._robots, self._plates, self._crosses = Sprites(), Sprites(), Sprites()
        self._mode, self._drag, self._cursor, self._moved = "look", None, None, False
        self._shown = dict.fromkeys(("trails", "targets", "edges", "numbers", "legend"), True)
        self._hidden_trails, self._selected = set(), 0
        self._targets, self._obstacles = None, ()
        self._edges = geometry.Edges()
        self._flashes = collections.deque(maxlen=MOST_FLASHES)
        self._untouched = True  # the view is still the one that fit() chose
        self.cost = 0.0  # [s] that the last picture took
        self._kinds = ()
        self._begin_team((), np.empty((0, 3)))
        self._timer = QTimer(self, interval=FLASH_PERIOD)
        self._timer.timeout.connect(self._fade)
        self.setFocusPolicy(Qt.StrongFocus)
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Expanding)

    # What is shown -------------------------------------------------------------------------------

    def show_kinds(self, kinds):
        """Draw robots 1..n as their ``Kind``s are; a team of another number as the first of them."""
        self._kinds = tuple(kinds)
        self._take_shapes()
        self.update()

    def _take_shapes(self):
        known = len(self._kinds) == len(self._numbers)
        usual = self._kinds[:1] or (kind(DEFAULT_KIND),)
        self._shapes = Shapes.of_kinds(self._kinds if known else usual * len(self._numbers))
        self._overlapping = None

    def show_team(self, poses):
        """Show robots 1..n at rest at ``poses`` (n, 3) [m, m, rad]; their next run begins there."""
        poses = np.array(poses, dtype=float).reshape(-1, 3)
        numbers = tuple(range(1, len(poses) + 1))
        if numbers != self._numbers:
            self._begin_team(numbers, poses)
            self.fit()
        elif not np.allclose(poses, self._pose, atol=1e-3, equal_nan=True):
            self._begin_anew = True
        self._place(poses, np.ones(len(poses), dtype=bool))
        self._at_rest = True
        self._follow()
        self.update()

    def show_snapshot(self, snapshot):
        """Show the newest poses of a run; one of another team or an earlier time begins anew."""
        numbers = tuple(int(number) for number in snapshot.numbers)
        poses = np.array(snapshot.pose, dtype=float).reshape(-1, 3)
        changed = numbers != self._numbers
        if changed:
            self._begin_team(numbers, poses)
        elif self._begin_anew or snapshot.time < self._time:
            self.clear_trails()
        self._time, self._begin_anew, self._at_rest = snapshot.time, False, False
        self._place(poses, np.array(snapshot.fresh, dtype=bool), snapshot.real)
        self._trails.add(poses[:, :2])
        if changed:
            self.fit()
        self._follow()
        self.update()

    def _begin_team(self, numbers, poses):
        self._numbers, self._drag = numbers, None
        self._take_shapes()
        self._time, self._begin_anew, self._at_rest = -math.inf, False, True
        self._trails = geometry.Trails(len(numbers))
        self._flashes.clear()
        self._place(poses, np.ones(len(poses), dtype=bool))

    def _place(self, poses, fresh, real=frozenset()):
        self._pose, self._fresh, self._overlapping, self._real = poses, fresh, None, real
        self._known = np.isfinite(poses).all(axis=1)

    def show_targets(self, points):
        """Show the desired positions ``points`` (n, 2) [m], None for none."""
        self._targets = None if points is None else np.array(points, dtype=float).reshape(-1, 2)
        self.update()

    def show_topology(self, edges, directed=True):
        """Show ``edges``, a list of (i, j, weight): robot i hears robot j."""
        self._edges = geometry.Edges(edges, directed)
        self.update()

    def show_obstacles(self, obstacles):
        """Show ``obstacles``, ``Box`` and ``Cylinder``."""
        self._obstacles = tuple(obstacles)
        self.update()

    def flash_collision(self, x, y):
        """Show for two seconds that there was a collision at (x, y) [m]."""
        self._flashes.append((time.monotonic(), np.array([x, y], dtype=float)))
        self._timer.start()
        self.update()

    @guarded
    def _fade(self, *_):
        while self._flashes and time.monotonic() - self._flashes[0][0] >= drawing.FLASH:
            self._flashes.popleft()
        if not self._flashes:
            self._timer.stop()
        self.update()

    def clear_trails(self):
        """Forget where the robots have been; new trails begin with the next snapshot."""
        self._trails, self._time = geometry.Trails(len(self._numbers)), -math.inf
        self.update()

    def select(self, number):
        """Highlight robot ``number``, 0 for none."""
        self._selected = int(number)
        self.update()

    def set_trails_shown(self, shown):
        """Show or hide all trails."""
        self._set_shown("trails", shown)

    def set_trail_shown(self, number, shown):
        """Show or hide the trail of robot ``number``."""
        (self._hidden_trails.discard if shown else self._hidden_trails.add)(int(number))
        self.update()

    def set_targets_shown(self, shown):
        """Show or hide the desired positions."""
        self._set_shown("targets", shown)

    def set_edges_shown(self, shown):
        """Show or hide the edges of the topology."""
        self._set_shown("edges", shown)

    def set_numbers_shown(self, shown):
        """Show or hide the robots' numbers."""
        self._set_shown("numbers", shown)

    def set_legend_shown(self, shown):
        """Show or hide what the signs mean."""
        self._set_shown("legend", shown)

    def _set_shown(self, what, shown):
        self._shown[what] = bool(shown)
        self.update()

    def set_mode(self, mode):
        """Choose what the mouse does: ``look``, edit ``poses`` or edit ``edges``."""
        if mode not in HINTS:
            raise ValueError("mode {!r}: wanted one of {}".format(mode, ", ".join(HINTS)))
        if mode != self._mode:
            self._mode, self._drag = mode, None
            self._measure()
            self.update()

    @property
    def mode(self):
        """Return the mode."""
        return self._mode

    @property
    def overlapping(self):
        """Return the set of the numbers of robots that overlap another."""
        if self._overlapping is None:
            rows = np.flatnonzero(self._known)
            hit = []
            if len(rows) > 1:
                first, second = self._bodies(rows).overlaps(self._pose[rows])[:2]
                hit = rows[np.union1d(first, second).astype(int)]
            self._overlapping = {self._numbers[row] for row in hit}
        return self._overlapping

    def _bodies(self, rows):
        return Bodies([self._shapes.distinct[which] for which in self._shapes.which[rows].tolist()])

    # The view ------------------------------------------------------------------------------------

    def fit(self):
        """Bring the whole team, its targets and trails into view."""
        self._untouched = True
        self._look_at(self._bounds(everything=True), self._shapes.farthest)

    def _bounds(self, everything):
        """Return the corners (k, 2) of the team, with ``everything`` of targets and trails too."""
        parts = [self._pose[self._known, :2]]
        if everything and self._targets is not None and self._shown["targets"]:
            parts.append(self._targets[np.isfinite(self._targets).all(axis=1)])
        if everything and self._shown["trails"]:
            parts.append(self._trails.bounds())
        return np.concatenate(parts)

    def _look_at(self, points, room):
        if len(points):
            low, high = points.min(axis=0) - room, points.max(axis=0) + room
            self._frame.look_at(low, high, self.fontMetrics().height())  # numbers need room too
        self.update()

    def _follow(self):
        """Widen an untouched view once a robot leaves it, with room so that it stays for a while."""
        if not self._untouched or self._drag is not None:
            return
        position = self._bounds(everything=False)
        if not self._frame.sees(self._frame.to_screen(position)).all():
            points = self._bounds(everything=True)
            self._look_at(points, self._shapes.farthest + ROOM * np.ptp(points, axis=0).max())

    def to_screen(self, x, y):
        """Return where the point (x, y) [m] is in the widget, (x, y) [px]."""
        return tuple(self._frame.to_screen((x, y)).tolist())

    def to_plane(self, x, y):
        """Return the point (x, y) [m] that is at (x, y) [px] in the widget."""
        return tuple(self._frame.to_plane((x, y)).tolist())

    def sizeHint(self):
        """Return a size for the eye; any other does."""
        line = self.fontMetrics().height()
        return QSize(40 * line, 32 * line)

    def minimumSizeHint(self):
        """Return the least size at which something is to be seen."""
        line = self.fontMetrics().height()
        return QSize(14 * line, 12 * line)

    @guarded
    def resizeEvent(self, event):
        self._measure()

    @guarded
    def changeEvent(self, event):
        if event.type() == QEvent.FontChange:
            self._measure()
        super().changeEvent(event)

    def _measure(self):
        self._frame.area = axes.plot_area(self, HINTS[self._mode])
        if self._untouched:
            self.fit()

    # Where things are ----------------------------------------------------------------------------

    def _robot_at(self, at):
        """Return the row of the robot at ``at`` (2,) [px], -1 for none."""
        return geometry.robot_at(
            self._pose, self._frame, drawing.Look.of(self).unit, at, self._shapes
        )

    def _edge_at(self, at):
        """Return the edge (i, j, weight) at ``at`` (2,) [px], None for none."""
        if not self._shown["edges"]:
            return None
        unit = drawing.Look.of(self).unit
        return self._edges.at(self._numbers, self._pose, self._frame, unit, at, self._shapes)

    # The mouse -----------------------------------------------------------------------------------

    @guarded
    def mousePressEvent(self, event):
        at = _place(event)
        row = self._robot_at(at)
        kind = self._kind_of_drag(event, row)
        grip = self._pose[row, :2] - self._frame.to_plane(at) if row >= 0 else np.zeros(2)
        self._cursor, self._moved = at, False
        self._drag = Drag(kind, row, at, grip, event.button()) if kind else None
        if kind == "turn":
            self._drag_to(at)

    def _kind_of_drag(self, event, row):
        """Return what a press on the robot ``row`` begins, None for nothing."""
        button = event.button()
        if row >= 0 and self._mode == "poses" and button in (Qt.LeftButton, Qt.RightButton):
            turns = button == Qt.RightButton or event.modifiers() & Qt.ShiftModifier
            return "turn" if turns else "move"
        if row >= 0 and self._mode == "edges" and button == Qt.LeftButton:
            return "edge"
        return "pan" if button in (Qt.LeftButton, Qt.MiddleButton) else None

    @guarded
    def mouseMoveEvent(self, event):
        at = _place(event)
        if self._drag is not None:
            self._moved = self._moved or np.hypot(*(at - self._drag.press)) > CLICK
            if self._moved:
                self._drag_to(at)
        else:
            self.setCursor(Qt.ArrowCursor if self._robot_at(at) < 0 else Qt.PointingHandCursor)
        self._cursor = at

    def _drag_to(self, at):
        kind, row, press, grip, _ = self._drag
        if kind == "pan":
            self._frame.pan(at - self._cursor)
            self._untouched = False
        elif kind == "move":
            self._edit(row, self._frame.to_plane(at) + grip, self._pose[row, 2])
        elif kind == "turn":
            toward = self._frame.to_plane(at) - self._pose[row, :2]
            if np.hypot(*toward) * self._frame.scale > CLICK:
                self._edit(row, self._pose[row, :2], math.atan2(toward[1], toward[0]))
        self.update()

    def _edit(self, row, position, theta):
        pose = self._pose.copy()
        pose[row] = position[0], position[1], theta
        self._place(pose, self._fresh, self._real)
        self._begin_anew = True
        self.pose_edited.emit(self._numbers[row], *pose[row].tolist())

    @guarded
    def mouseReleaseEvent(self, event):
        drag = self._drag
        if drag is None or event.button() != drag.button:
            return
        at, self._drag = _place(event), None
        if drag.kind == "edge":
            self._join(drag.row, self._robot_at(at))
        elif drag.kind == "pan" and drag.button == Qt.LeftButton and not self._moved:
            self._click(drag.row, at)
        self.update()

    def _join(self, row, other):
        if other < 0 or other == row:
            return
        # Drawn as it will be: from the robot that is heard to the one that hears.
        pair = self._numbers[other], self._numbers[row]
        if not self._edges.holds(*pair):
            self.edge_added.emit(*pair)

    def _click(self, row, at):
        if self._mode == "look" and row >= 0:
            self.robot_clicked.emit(self._numbers[row])
        elif self._mode == "edges":
            edge = self._edge_at(at)
            if edge is not None:
                self.edge_removed.emit(*edge[:2])

    @guarded
    def mouseDoubleClickEvent(self, event):
        at = _place(event)
        on_edge = self._mode == "edges" and self._edge_at(at) is not None
        if event.button() == Qt.LeftButton and self._robot_at(at) < 0 and not on_edge:
            self.fit()
        else:
            self.mousePressEvent(event)

    @guarded
    def wheelEvent(self, event):
        # Qt before 5.14 has no position().
        at = event.position() if hasattr(event, "position") else event.posF()
        self._frame.zoom(ZOOM ** (event.angleDelta().y() / 120.0), (at.x(), at.y()))
        self._untouched = False
        self.update()
        event.accept()

    @guarded
    def keyPressEvent(self, event):
        if event.key() == Qt.Key_F:
            self.fit()
        elif self._escapes(event):
            self._drag = None
            self.update()
        else:
            super().keyPressEvent(event)

    def _escapes(self, event):
        """Return whether the key gives up the edge that is being drawn."""
        drawing_edge = self._drag is not None and self._drag.kind == "edge"
        return event.key() == Qt.Key_Escape and drawing_edge

    def event(self, event):
        """Answer the question for a tooltip, keep a key from being a shortcut; all else as usual."""
        if event.type() == QEvent.ShortcutOverride and self._escapes(event):
            event.accept()
            return True
        if event.type() == QEvent.ToolTip:
            self._tell(event)
            return True
        return super().event(event)

    @guarded
    def _tell(self, event):
        at = np.array([event.pos().x(), event.pos().y()], dtype=float)
        row, text = self._robot_at(at), ""
        if row >= 0:
            x, y, theta = self._pose[row]
            text = "Robot {}: x = {:.3f} m, y = {:.3f} m, \u03b8 = {:.1f}\u00b0{}".format(
                self._numbers[row],
                x,
                y,
                math.degrees(math.remainder(theta, 2.0 * math.pi)),
                ("\nA real robot" if self._numbers[row] in self._real else "")
                + ("" if self._fresh[row] else "\nNot heard lately"),
            )
        else:
            edge = self._edge_at(at)
            if edge is not None:
                how = "hears robot" if self._edges.directed else "and robot"
                text = "Robot {0} {3} {1}, weight a({0}, {1}) = {2:g}".format(*edge, how)
        QToolTip.showText(event.globalPos(), text, self)

    # Painting ------------------------------------------------------------------------------------

    @guarded
    def paintEvent(self, event):
        look, painter = drawing.Look.of(self, self._team_size()), QPainter(self)
        begun = time.perf_counter()
        try:
            self._paint_ground(painter, look)
            painter.setFont(self.font())
            painter.setRenderHint(QPainter.Antialiasing)
            painter.setClipRect(self._frame.area)
            axes.draw_scale_bar(painter, look, self._frame)
            remark = self._paint_edges(painter, look)
            if self._shown["targets"] and self._targets is not None:
                team = self._targets, self._numbers
                drawing.draw_targets(painter, look, self._frame, *team, self._crosses)
            self._paint_robots(painter, look)
            if self._shown["legend"]:
                drawing.draw_legend(painter, look, self._frame, self._legend())
            self._paint_passing(painter, look)
            if remark:
                axes.draw_remark(painter, look, self._frame, remark)
        finally:
            painter.end()
        self.cost = time.perf_counter() - begun

    def _team_size(self):
        return max(self._numbers, default=1)

    def _paint_ground(self, painter, look):
        """Paint the ground with the trails."""
        trails = self._trails if self._shown["trails"] else None
        now = None if self._begin_anew else self._pose[:, :2]  # robots may have been put elsewhere
        obstacles, hint, numbers = self._obstacles, HINTS[self._mode], self._numbers
        arguments = obstacles, hint, trails, now, numbers, self._hidden_trails
        self._ground.draw(painter, self, look, self._frame, *arguments)

    def _paint_edges(self, painter, look):
        """Paint the edges; return a remark where some are left out."""
        if not self._shown["edges"]:
            return ""
        segments, stride = self._edges.segments(
            self._numbers, self._pose, self._frame, look.unit, self._shapes, MOST_EDGES
        )
        stride *= drawing.draw_edges(painter, look, segments, self._edges.directed)
        return "" if stride == 1 else "One edge in {} is drawn".format(stride)

    def _paint_robots(self, painter, look):
        frame, scale = self._frame, self._frame.scale
        screen = frame.to_screen(self._pose)
        margin = max(self._shapes.farthest * scale, geometry.ARROW * look.unit) + 2.0 * look.line
        with np.errstate(invalid="ignore"):
            rows = np.flatnonzero(self._known & frame.sees(screen, margin))
        pose, numbers = self._pose[rows], [self._numbers[row] for row in rows]
        shapes, fresh = self._shapes.of(rows), self._fresh[rows]

        def of(chosen):
            places = [row for row, number in enumerate(numbers) if number in chosen]
            return pose[places], shapes.of(places)

        drawing.draw_selection(painter, look, frame, *of({self._selected}))
        drawing.draw_robots(painter, look, frame, pose, numbers, fresh, shapes, self._robots)
        drawing.draw_real(painter, look, frame, *of(self._real))
        if (self._at_rest or self._mode == "poses") and self.overlapping:
            drawing.draw_alarms(painter, look, frame, *of(self.overlapping))
        if self._shown["numbers"] and len(rows) <= drawing.MANY_ROBOTS:
            drawing.draw_numbers(painter, look, frame, pose, numbers, shapes, self._plates)

    def _paint_passing(self, painter, look):
        """Paint what is there for a moment: collisions, the edge that is being drawn."""
        now = time.monotonic()
        for begun, place in self._flashes:
            drawing.draw_flash(painter, look, self._frame, place, now - begun)
        if self._drag is not None and self._drag.kind == "edge" and self._moved:
            row = self._robot_at(self._cursor)
            begin = self._frame.to_screen(self._pose[self._drag.row])
            reached = row >= 0 and row != self._drag.row
            end = self._frame.to_screen(self._pose[row]) if reached else self._cursor
            text = self._told_of_edge(self._drag.row, row if reached else -1)
            drawing.draw_band(painter, look, begin, end, reached, text)

    def _told_of_edge(self, row, other):
        """Return in words what the edge drawn from robot ``row`` to ``other``, -1 for none, means."""
        hears = "robot {}".format(self._numbers[other]) if other >= 0 else "..."
        between = "and {} hear each other" if not self._edges.directed else "{} hears robot {}"
        if self._edges.directed:
            return between.format(hears, self._numbers[row])
        return "robot {} {}".format(self._numbers[row], between.format(hears))

    def _legend(self):
        """Return the names of the signs that are to be seen."""
        shown = set()
        if self._shown["trails"] and self._trails.begun:
            shown |= {"start", "trail"}
        if self._shown["targets"] and self._targets is not None:
            shown.add("target")
        if self._shown["edges"] and self._edges.list:
            shown.add("hears" if self._edges.directed else "edge")
        if self._real:
            shown.add("real")
        if not self._fresh.all():
            shown.add("stale")
        return shown


def _place(event):
    return np.array([event.localPos().x(), event.localPos().y()])
