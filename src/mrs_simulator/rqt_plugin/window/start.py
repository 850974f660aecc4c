"""The first minute: picker of scenarios, tour, and files dropped onto the window."""

import os

from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QObject
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.start.picker import ScenarioPicker
from mrs_simulator.rqt_plugin.start.tour import Tour, steps_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded

SCENARIOS, PROTOCOLS, RUNS = (".yaml", ".yml"), (".py",), (".csv", ".bag")
WRONG = "{}: wanted a scenario (.yaml, .yml), a protocol (.py), a run or a sweep"


@guarded
class Start(QObject):
    """Opens picker and tour, and what is dropped."""

    def __init__(self, panels, files, shelf):
        """``files``: the ``ScenarioFiles``; ``shelf``: the ``ShelfControl``."""
        super().__init__(panels)
        self._panels, self._files, self._shelf = panels, files, shelf
        self.picker = self.tour = None
        panels.team.open_requested.connect(self.show_picker)
        panels.setAcceptDrops(True)
        panels.installEventFilter(self)

    def begin(self):
        """Show picker and tour unless the user wants neither any more."""
        if self._files.memory.kept()["picker"]:
            self.show_picker()
            self.picker.finished.connect(self._begin_tour)
        else:
            self._begin_tour()

    @guarded
    def show_picker(self):
        """Show the picker, once."""
        if self.picker is not None and self.picker.isVisible():
            self.picker.raise_()
            return
        self.picker = ScenarioPicker(self._files.memory, self._panels)
        self.picker.chosen.connect(self._files.open_unless_controlled)
        self.picker.browse_asked.connect(self._files.ask_to_open)
        self.picker.finished.connect(self.picker.deleteLater)
        self.picker.finished.connect(self._on_picker_closed)
        self.picker.show()

    def _on_picker_closed(self, *_):
        self.picker = None

    @guarded
    def _begin_tour(self, *_):
        if self.tour is None and self._files.memory.kept()["tour"]:
            self.show_tour()

    def show_tour(self):
        """Show the tour from its beginning."""
        self.tour = Tour(self._panels, steps_of(self._panels))
        self.tour.ended.connect(self._on_tour_ended)

    def _on_tour_ended(self):
        self.tour = None
        self._panels.map.setFocus()  # else the window's keys would sleep until a click
        self._files.memory.change(tour=False)

    def eventFilter(self, watched, event):
        """Take files that are dropped onto the window."""
        if event.type() == QEvent.DragEnter and event.mimeData().hasUrls():
            event.acceptProposedAction()
            return True
        if event.type() == QEvent.Drop:
            self._drop(event)
            return True
        return False

    @guarded
    def _drop(self, event):
        event.acceptProposedAction()
        paths = [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]
        for path in paths[:1]:
            kind = os.path.splitext(path)[1].lower()
            if kind in SCENARIOS:
                self._files.open_unless_controlled(path)
            elif kind in PROTOCOLS:
                self._panels.protocol.take_file(path)
            elif kind in RUNS or os.path.isdir(path):
                self._shelf.open(path)
            else:
                self._panels.say(ErrorMessage(WRONG.format(path)))
