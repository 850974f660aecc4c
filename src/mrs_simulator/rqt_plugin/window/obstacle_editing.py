"""Edits of obstacles on the map: applied to the study, which may refuse them, with undo."""

from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.scenario.surroundings.maps import obstacles_of

MOST_UNDONE = 200  # [-] edits that can be undone


class ObstacleEditing:
    """Undo and redo of obstacles, and the obstacles in force."""

    def __init__(self, panels, study, changed):
        """``changed()`` is called after each edit that was applied."""
        self._panels, self._study, self._changed = panels, study, changed
        self._done, self._undone = [], []  # obstacles as they were before, and after
        panels.map.obstacles_edited.connect(self._on_edited)
        panels.map.undo_asked.connect(self._on_undo)
        panels.map.redo_asked.connect(self._on_redo)
        panels.map_panel.obstacles.refused.connect(self._on_refused)

    def begin(self):
        """Start from the scenario in force, with nothing to undo."""
        self._done, self._undone = [], []
        self.show()

    def show(self):
        """Show the obstacles in force, and whether edits can be undone."""
        scenario = self._study.scenario
        self._panels.map.show_obstacles(obstacles_of(scenario), len(scenario.obstacles))
        self._panels.map_panel.obstacles.set_undoable(bool(self._done), bool(self._undone))
        self._panels.map_panel.obstacles.show_selected()

    def _take(self, obstacles):
        """Apply ``obstacles``; return whether they are in force."""
        wrong = self._study.state.obstacles_locked()
        wrong = ErrorMessage(wrong) if wrong else self._study.edited.set_obstacles(obstacles)
        if self._panels.say(wrong):
            self.show()
            return False
        self._panels.say(self._study.control.follow_obstacles())
        return True

    @guarded
    def _on_edited(self, obstacles):
        before = self._study.scenario.obstacles
        if self._take(obstacles):
            self._done = [*self._done[1 - MOST_UNDONE :], before]
            self._undone = []
            self._show_taken()

    @guarded
    def _on_undo(self):
        self._exchange(self._done, self._undone)

    @guarded
    def _on_redo(self):
        self._exchange(self._undone, self._done)

    def _exchange(self, source, target):
        """Apply the last of ``source``; what was in force goes to ``target``."""
        before = self._study.scenario.obstacles
        if source and self._take(source[-1]):
            source.pop()
            target.append(before)
            self._show_taken()

    def _show_taken(self):
        self.show()
        self._changed()

    @guarded
    def _on_refused(self, text):
        self._panels.say(ErrorMessage(text))
