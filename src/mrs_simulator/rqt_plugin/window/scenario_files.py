"""Opens and saves scenarios and protocols by dialogs."""

import os

from mrs_simulator.protocols.loading import from_anywhere
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.start.memory import StartMemory
from mrs_simulator.rqt_plugin.widgets.file_dialog import FileDialog
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import shipped_scenarios

SCENARIOS = "Scenarios (*.yaml *.yml)"
PROTOCOLS = "Python files (*.py)"


@guarded
class ScenarioFiles:
    """Asks for files, one dialog at a time, beginning where the last one was."""

    def __init__(self, panels, study, editing, live, pending_team):
        self._panels, self._study, self._editing = panels, study, editing
        self._live, self._team = live, pending_team
        # Where the GUI was started, or where the last file was: not where Qt has been last.
        self.directory = os.getcwd()
        self.memory = StartMemory()
        self.saved_text = None  # what the scenario's file holds, as far as is known
        panels.team.save_requested.connect(self.ask_to_save)
        panels.protocol.file_requested.connect(self._on_protocol_file)

    def text(self):
        """Return the scenario as edited so far, as YAML."""
        return from_anywhere(self._study.scenario).to_yaml()

    def load(self, path):
        """Open the scenario file at ``path``; on an error, show it and keep the old scenario."""
        say = self._panels.say
        self.keep_unsaved()
        try:
            self._editing.take(load_scenario(path))
        except Exception as error:  # its protocol may raise anything
            say(ErrorMessage("not opened: {}".format(reason(error))))
            return
        self._live.put_away()
        self._panels.shelf.list.clear_compared()
        self._panels.map.fit(whole=True)  # without the trails of the run before
        self.saved_text = self.text()
        self.memory.opened(path, self.saved_text)
        say("opened {}".format(path))
        say(self._study.control.follow_protocol())
        say(self._study.stage.kept())
        self._team.changed()

    def keep_unsaved(self):
        """Keep edits that no file has in one of their own, which the picker offers."""
        text = self.text()
        if self.saved_text in (None, text) or self.memory.is_saved(text):
            return
        try:
            path = self.memory.keep_edits(text, self._study.scenario.title)
        except OSError as error:
            self._panels.say(ErrorMessage("unsaved edits were not kept: {}".format(error)))
        else:
            self._panels.say("unsaved edits are kept in {}".format(path))

    def save(self, path):
        """Write the scenario as edited so far to the file at ``path``."""
        text = self.text()
        try:
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        except OSError as error:
            self._panels.say(ErrorMessage("not saved: {}".format(error)))
            return
        self.saved_text = text
        self.memory.opened(path, text)
        self._panels.say_saved(path)

    def ask(self, title, start, kinds, chosen, saves=False):
        """Open a dialog in place of one that is open; ``chosen`` is called with the path."""
        for dialog in self._panels.findChildren(FileDialog):
            dialog.close()

        def taken(path):
            self.directory = os.path.dirname(path)
            chosen(path)

        start = os.path.join(self.directory, start)
        places = [os.getcwd(), os.path.expanduser("~")]
        places += [] if saves else [shipped_scenarios()]
        FileDialog(self._panels, title, start, kinds, taken, saves, places)

    @guarded
    def ask_to_open(self):
        """Ask for a scenario to open."""
        self.ask("Open scenario", "", SCENARIOS, self.open_unless_controlled)

    @guarded
    def open_unless_controlled(self, path):
        """Open the scenario file at ``path``, unless a controller runs."""
        if (
            self._study.is_controlled() and not self._study.state.is_over()
        ):  # since the dialog was opened
            text = "not opened: stop the controller to open another scenario"
            self._panels.say(ErrorMessage(text))
        else:
            self.load(path)

    @guarded
    def ask_to_save(self):
        """Ask where to save the scenario."""
        self.ask("Save scenario", "scenario.yaml", SCENARIOS, self.save, saves=True)

    def _on_protocol_file(self, directory):
        take_file = self._panels.protocol.take_file
        self.ask("Open a protocol", directory, PROTOCOLS, take_file)
