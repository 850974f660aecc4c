"""The map: a team of robots seen from above, in metres, and its editing with the mouse."""

import math
from typing import NamedTuple

import numpy as np

from mrs_simulator.rqt_plugin.map.arranging import snapped
from mrs_simulator.rqt_plugin.map.frame import nice_step
from mrs_simulator.rqt_plugin.map.geometry import REACH
from mrs_simulator.rqt_plugin.map.map_menu import open_map_menu
from mrs_simulator.rqt_plugin.map.obstacle_keys import ObstacleKeys
from mrs_simulator.rqt_plugin.map.obstacle_shapes import described, obstacle_at
from mrs_simulator.rqt_plugin.map.painted_map import PaintedMap
from mrs_simulator.rqt_plugin.map.scene import EDGE_MODES
from mrs_simulator.rqt_plugin.map.style import MapStyle
from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QToolTip
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.state.columns import Z

CLICK = 4.0  # [px] that the mouse may move within a click
ZOOM = 1.2  # [-] of one notch of the wheel


class Drag(NamedTuple):
    """What the mouse does while a button is down."""

    kind: str  # pan, move, turn, edge, ahead, push, obstacle, band (a selection) or measure
    row: int  # of the robot pressed, -1 for none
    press: np.ndarray  # (2,) [px]
    grip: np.ndarray  # (2,) [m] from the cursor to the robot
    button: int


@guarded
class MapView(PaintedMap):
    """A map with mouse and keys: signals for edits and clicked robots."""

    pose_edited = Signal(int, float, float, float)  # number, x [m], y [m], theta [rad]
    poses_edited = Signal(object)  # of several robots: the team's (n, 3) [m, m, rad]
    follow_asked = Signal(int)  # robot whose 3D view is asked for
    robot_held = Signal(int, object)  # number, and (x, y) [m] where it is held, None: let go
    ahead_moved = Signal(int, float, float)  # number, x [m], y [m]: what if it were there
    ahead_cut = Signal(object)  # the edge (i, j, weight) without which to look ahead
    edge_added = Signal(int, int)  # i receives from j
    edge_removed = Signal(int, int)
    edge_hovered = Signal(object)  # (i, j, weight) under the mouse while edges are edited, or None
    robot_clicked = Signal(int)  # number, 0 of a click on the floor
    obstacles_edited = Signal(object)  # all that may be edited, a tuple
    changed = Signal()  # of the obstacle that is edited
    undo_asked = Signal()
    redo_asked = Signal()

    def __init__(self, parent=None):
        super().__init__(parent)
        self.setFocusPolicy(Qt.StrongFocus)
        self.setMouseTracking(True)
        self.keys = ObstacleKeys(self)

    def _on_obstacles(self, own):
        self.obstacles_edited.emit(own)

    def _on_edit(self):
        self.changed.emit()
        self.update()

    def mousePressEvent(self, event):
        at = _place(event)
        row = self.robot_at(at)
        kind = self._kind_of_drag(event, row)
        grip = self.team.pose[row, :2] - self.frame.to_plane(at) if row >= 0 else np.zeros(2)
        if kind == "choose":
            self.chosen.toggle(self.team.numbers[row])
            return
        self._cursor, self._moved = at, kind == "push"  # held where it is until the mouse goes on
        self.drag = Drag(kind, row, at, grip, event.button()) if kind else None
        if kind in ("turn", "push"):
            self._drag_to(at)
        elif kind == "obstacle":
            other = bool(event.modifiers() & Qt.ShiftModifier)
            self.editor.press(self.frame.to_plane(at), self.reach, other)
        elif kind == "measure":
            self.ruler.begin(row, self.frame.to_plane(at))
            self.update()

    def _kind_of_drag(self, event, row):
        """Return what a press on the robot ``row`` begins, None for nothing."""
        button = event.button()
        if self.mode == "poses" and button in (Qt.LeftButton, Qt.RightButton):
            return self._pose_drag(row, button == Qt.RightButton, event.modifiers())
        if row >= 0 and self.mode in ("ahead", "push") and button == Qt.LeftButton:
            return self.mode
        if self.mode == "measure" and button == Qt.LeftButton:
            return "measure"
        if row >= 0 and self.mode == "edges" and button == Qt.LeftButton:
            return "edge"
        if self.mode == "obstacles" and button == Qt.LeftButton:
            return "obstacle"
        return "pan" if button in (Qt.LeftButton, Qt.MiddleButton) else None

    @staticmethod
    def _pose_drag(row, is_right, held):
        """Return what a press in the mode for poses begins, with the keys ``held``, None for nothing."""
        if row < 0:
            is_band = held & (Qt.ShiftModifier | Qt.ControlModifier)
            return None if is_right else "band" if is_band else "pan"
        if is_right or held & Qt.ShiftModifier:
            return "turn"
        return "choose" if held & Qt.ControlModifier else "move"

    def mouseMoveEvent(self, event):
        at = _place(event)
        if self.drag is not None:
            self._moved = self._moved or np.hypot(*(at - self.drag.press)) > CLICK
            if self._moved:
                self._drag_to(at, event.modifiers())
        else:
            self.setCursor(self._cursor_at(at))
            self._hover(at)
        self._cursor = at

    def leaveEvent(self, event):
        """Hover over no edge any more."""
        super().leaveEvent(event)
        self._hover(None)

    def _hover(self, at):
        """Take note of the edge at ``at`` (2,) [px], None for outside, where a click would remove it."""
        edits = self.mode in EDGE_MODES and at is not None and self.robot_at(at) < 0
        edge = self.edge_at(at) if edits else None
        if edge != self.hovered:
            self.hovered, self.hover_text = edge, ""
            self.edge_hovered.emit(edge)
            self.update()

    def show_hover_text(self, text):
        """Show ``text`` on the edge under the mouse."""
        if text != self.hover_text:
            self.hover_text = text
            self.update()

    def _cursor_at(self, at):
        """Return the cursor for what a press at ``at`` would do."""
        if self.mode == "obstacles":
            return self.keys.cursor_at(self.frame.to_plane(at))
        return Qt.ArrowCursor if self.robot_at(at) < 0 else Qt.PointingHandCursor

    @property
    def reach(self):
        """Return the distance [m] from the cursor within which a handle is grabbed."""
        return REACH * MapStyle.of(self).unit / self.frame.scale

    @property
    def grain(self):
        """Return a round length [m] of about a pixel, of which what is drawn has whole multiples."""
        return nice_step(1.0 / self.frame.scale)

    def _drag_to(self, at, held=Qt.NoModifier):
        kind, row, press, grip, _ = self.drag
        if kind == "pan":
            self.frame.pan(at - self._cursor)
            self.untouched = False
        elif kind == "move":
            self._move(row, self.frame.to_plane(at) + grip, bool(held & Qt.ControlModifier))
        elif kind == "turn":
            toward = self.frame.to_plane(at) - self.team.pose[row, :2]
            if np.hypot(*toward) * self.frame.scale > CLICK:
                self._edit(row, self.team.pose[row, :2], math.atan2(toward[1], toward[0]))
        elif kind == "obstacle":
            self.editor.drag(self.frame.to_plane(at), self.grain, bool(held & Qt.ShiftModifier))
        elif kind in ("ahead", "push"):
            place = (self.frame.to_plane(at) + grip).tolist()
            number = self.team.numbers[row]
            if kind == "push":
                self.robot_held.emit(number, tuple(place))
            else:
                self.ahead_moved.emit(number, *place)
        elif kind == "measure":
            self.ruler.lead(self.robot_at(at), self.frame.to_plane(at))
        self.update()

    def _move(self, row, position, snaps):
        """Put the robot in ``row`` to ``position`` (2,) [m]; others selected move along."""
        pose = np.array([[*position, self.team.pose[row, 2]]])
        pose = snapped(pose) if snaps else pose
        rows = self.chosen.rows_with(row)
        if len(rows) == 1:
            self._edit(row, pose[0, :2], pose[0, 2])
        else:
            self.edit_poses(rows, self.team.pose[rows] + pose - self.team.pose[row])

    def edit_poses(self, rows, poses):
        """Put the robots in ``rows`` to ``poses`` (k, 3) [m, m, rad], as one edit."""
        self.team.edit(rows, poses)
        self._begin_anew = True
        self.poses_edited.emit(self.team.pose.copy())
        self.update()

    def _edit(self, row, position, theta):
        pose = (*position.tolist(), theta)
        self.team.edit(row, pose)
        self._begin_anew = True
        self.pose_edited.emit(self.team.numbers[row], *pose)

    def mouseReleaseEvent(self, event):
        drag = self.drag
        if drag is None or event.button() != drag.button:
            return
        at, self.drag = _place(event), None
        if drag.kind == "push":
            self.robot_held.emit(self.team.numbers[drag.row], None)
        elif drag.kind == "edge":
            self._join(drag.row, self.robot_at(at))
        elif drag.kind == "obstacle":
            self.editor.release()
        elif drag.kind == "band":
            self.chosen.take_band(drag.press, at)
        elif drag.kind == "turn" and drag.button == Qt.RightButton and not self._moved:
            self.chosen.open_menu(self.team.numbers[drag.row], event.globalPos())
        elif drag.kind == "pan" and drag.button == Qt.LeftButton and not self._moved:
            self._click(drag.row, at)
        self.update()

    def _join(self, row, other):
        if other < 0 or other == row:
            return
        # Drawn as it will be: from the sender to the receiver.
        pair = self.team.numbers[other], self.team.numbers[row]
        if not self.edges.holds(*pair):
            self.edge_added.emit(*pair)

    def _click(self, row, at):
        if self.mode == "look":  # on the floor: none
            self.robot_clicked.emit(self.team.numbers[row] if row >= 0 else 0)
        elif self.mode in EDGE_MODES:
            edge = self.edge_at(at)
            if edge is not None and self.mode == "ahead":
                self.ahead_cut.emit(edge)
            elif edge is not None:
                self.edge_removed.emit(*edge[:2])
            self._hover(at)

    def mouseDoubleClickEvent(self, event):
        at = _place(event)
        on_edge = self.mode in EDGE_MODES and self.edge_at(at) is not None
        if self.mode == "obstacles":
            self.mousePressEvent(event)
        elif event.button() == Qt.LeftButton and self.robot_at(at) < 0 and not on_edge:
            self.fit()
        else:
            self.mousePressEvent(event)

    def wheelEvent(self, event):
        # Qt before 5.14 has no position().
        at = event.position() if hasattr(event, "position") else event.posF()
        self.frame.zoom(ZOOM ** (event.angleDelta().y() / 120.0), (at.x(), at.y()))
        self.untouched = False
        self.update()
        event.accept()

    def keyPressEvent(self, event):
        if event.key() == Qt.Key_F:
            self.fit()
        elif self._escapes(event):
            self.drag = None
            self.editor.cancel()
        elif self._keys is not None and self._keys.press(event):
            event.accept()
        else:
            super().keyPressEvent(event)

    def _escapes(self, event):
        """Return whether the key cancels drawing an edge, an obstacle or a selection."""
        drawing = self.drag is not None and self.drag.kind in ("edge", "obstacle", "band")
        return event.key() == Qt.Key_Escape and drawing

    def _takes(self, event):
        """Return whether the map handles the key, even if it is a shortcut elsewhere."""
        return self._escapes(event) or (self._keys is not None and self._keys.knows(event))

    @property
    def _keys(self):
        """Return what takes the keys of the mode, None for nothing."""
        return {"obstacles": self.keys, "poses": self.chosen}.get(self.mode)

    def contextMenuEvent(self, event):
        """Offer what can be done there; of a robot in the mode for poses, once it is not turned."""
        row = self.robot_at(np.array([event.pos().x(), event.pos().y()], dtype=float))
        if self.mode == "obstacles":
            self.keys.open_menu(event)
        elif self.mode == "poses" and (row < 0 or event.reason() == event.Keyboard):
            self.chosen.open_menu(0, event.globalPos())
        elif self.mode != "poses":
            open_map_menu(self, row, event.globalPos())

    def event(self, event):
        """Show a tooltip, or keep a key of the map from being a shortcut."""
        if event.type() == QEvent.ShortcutOverride and self._takes(event):
            event.accept()
            return True
        if event.type() == QEvent.ToolTip:
            self._show_tooltip(event)
            return True
        return super().event(event)

    @guarded
    def _show_tooltip(self, event):
        at = np.array([event.pos().x(), event.pos().y()], dtype=float)
        row, text = self.robot_at(at), ""
        if row >= 0:
            x, y, theta = self.team.pose[row]
            text = "Robot {}: x = {:.3f} m, y = {:.3f} m, {}\u03b8 = {:.1f}\u00b0{}".format(
                self.team.numbers[row],
                x,
                y,
                "z = {:.3f} m, ".format(self.team.state.z[row]) if self.team.state.has(Z) else "",
                math.degrees(math.remainder(theta, 2.0 * math.pi)),
                ("\nA real robot" if self.team.numbers[row] in self.team.real else "")
                + ("" if self.team.fresh[row] else "\nNo recent data"),
            )
        else:
            edge = self.edge_at(at)
            obstacles = self._standing + self._moving
            found = obstacle_at(obstacles, self.frame.to_plane(at), 0.0)
            if edge is not None and not self.hover_text:
                text = self.edges.described(edge)
            elif found >= 0:
                text = described(obstacles[found])
        QToolTip.showText(event.globalPos(), text, self)


def _place(event):
    return np.array([event.localPos().x(), event.localPos().y()])
