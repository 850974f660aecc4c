"""Edits of obstacles on the map: applied to the study, which may refuse them."""

from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.scenario.surroundings.maps import obstacles_of


@guarded
class ObstacleEditing:
    """The obstacles in force, and edits of them."""

    def __init__(self, panels, study, changed):
        """``changed()`` is called after each edit that was applied."""
        self._panels, self._study, self._changed = panels, study, changed
        panels.map.obstacles_edited.connect(self._on_edited)
        refused = panels.map_panel.obstacles.refused
        refused.connect(guarded(lambda text: panels.say(ErrorMessage(text))))

    def begin(self):
        """Start from the scenario in force, with nothing to undo."""
        self._study.edited.undo.clear()
        self.show()

    def show(self):
        """Show the obstacles in force, and whether edits can be undone."""
        scenario = self._study.scenario
        self._panels.map.show_obstacles(obstacles_of(scenario), len(scenario.obstacles))
        undo = self._study.edited.undo
        self._panels.map_panel.obstacles.set_undoable(bool(undo.done), bool(undo.undone))
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

    def _on_edited(self, obstacles):
        if self._take(obstacles):
            self.show()
            self._changed()
