"""Keys, menu and cursor of the map's mode for obstacles."""

from mrs_simulator.rqt_plugin.map.obstacle_editor import COARSE, FINE
from mrs_simulator.rqt_plugin.qt.QtCore import QPoint, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QContextMenuEvent, QKeySequence
from mrs_simulator.rqt_plugin.qt.QtWidgets import QMenu
from mrs_simulator.rqt_plugin.widgets.guard import guarded

STEP, FINE_STEP = 0.1, 0.01  # [m] of a key, and with Shift
ARROWS = {Qt.Key_Left: (-1, 0), Qt.Key_Right: (1, 0), Qt.Key_Up: (0, 1), Qt.Key_Down: (0, -1)}
NEXT = {Qt.Key_PageDown: 1, Qt.Key_PageUp: -1}
GROW = {Qt.Key_Plus: 1, Qt.Key_Equal: 1, Qt.Key_Minus: -1}
DRAWN = {Qt.Key_B: "box", Qt.Key_C: "cylinder"}
HELP = (
    "B, C: place a box, a cylinder. Page down, up: select the next, the one before. Arrows: move, "
    "+ and -: resize, R: turn (Shift: finely). Del: delete. Ctrl+Z, Ctrl+Shift+Z: undo, redo. "
    "The middle button pans"
)


class KeyActions:
    """Keys that have actions; ``_action(event)`` returns that of a key, or None."""

    def press(self, event):
        """Do the action of the key; return whether it has one."""
        action = self._action(event)
        if action is not None:
            action()
        return action is not None

    def knows(self, event):
        """Return whether the key has an action."""
        return self._action(event) is not None


class ObstacleKeys(KeyActions):
    """What a person does to the obstacles of a ``MapView`` other than by dragging."""

    def __init__(self, view):
        self._view, self._editor, self.menu = view, view.editor, None

    def _action(self, event):
        key, editor = event.key(), self._editor
        if event.matches(QKeySequence.Undo):
            return self._view.undo_asked.emit
        if event.matches(QKeySequence.Redo) or _is_redo(event):
            return self._view.redo_asked.emit
        if event.modifiers() & ~(Qt.ShiftModifier | Qt.KeypadModifier):
            return None  # those of the window
        fine = bool(event.modifiers() & Qt.ShiftModifier)
        step = FINE_STEP if fine else STEP
        if key in DRAWN:
            return lambda: self.place(DRAWN[key])
        if key in NEXT:
            return lambda: editor.select_next(NEXT[key])
        if editor.current is None:
            return None
        if key in ARROWS:
            return lambda: editor.move_by([step * way for way in ARROWS[key]])
        if key in GROW:
            return lambda: editor.grow_by(step * GROW[key])
        return {
            Qt.Key_R: lambda: editor.turn_by(FINE if fine else COARSE),
            Qt.Key_Delete: editor.delete,
            Qt.Key_Backspace: editor.delete,
            Qt.Key_Escape: lambda: editor.select(""),
        }.get(key)

    def place(self, shape):
        """Place a new ``shape`` where there is room, near the middle of what is seen."""
        view = self._view
        middle = view.to_plane(0.5 * view.width(), 0.5 * view.height())
        self._editor.place(shape, middle, lambda found: not view.team.touches(found))

    def cursor_at(self, point):
        """Return the shape of the cursor at ``point`` (2,) [m]."""
        if self._editor.handle_at(point, self._view.reach):
            return Qt.PointingHandCursor
        found = self._editor.at(point, 0.5 * self._view.reach)
        return Qt.CrossCursor if found is None else Qt.SizeAllCursor

    def open_menu(self, event):
        """Open the menu of the obstacle at the cursor, by key that of the selected one."""
        view, editor = self._view, self._editor
        if event.reason() == QContextMenuEvent.Keyboard:
            if editor.current is not None:
                centre = view.to_screen(editor.current.x, editor.current.y)
                self._open(view.mapToGlobal(QPoint(*map(int, centre))))
            return
        found = editor.at(view.to_plane(event.pos().x(), event.pos().y()), 0.5 * view.reach)
        editor.select("" if found is None else found.name)
        if found is not None:
            self._open(event.globalPos())

    def _open(self, place):
        editor = self._editor
        self.menu = QMenu(self._view)
        self.menu.setAttribute(Qt.WA_DeleteOnClose)
        for text, action in (
            ("Duplicate", editor.duplicate),
            ("Turn by 90\u00b0", lambda: editor.turn_by(6.0 * COARSE)),
            ("Delete", editor.delete),
        ):
            self.menu.addAction(text).triggered.connect(guarded(lambda *_, do=action: do()))
        self.menu.popup(place)


def _is_redo(event):
    wanted = Qt.ControlModifier, Qt.ControlModifier | Qt.ShiftModifier
    return (event.key(), event.modifiers()) in ((Qt.Key_Y, wanted[0]), (Qt.Key_Z, wanted[1]))
