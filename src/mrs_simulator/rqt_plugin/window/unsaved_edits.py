"""Autosaves an edited scenario, and offers to restore edits after a crash."""

from mrs_simulator.rqt_plugin.run.autosave import time_of
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.scenario.scenario import scenario_from_yaml


class UnsavedEdits:
    """The edits of this GUI, and those that a crash has left."""

    def __init__(self, autosave, panels, study, files, restored):
        """``autosave``: an ``Autosave``, None for none; ``restored(scenario)`` opens edits."""
        self._autosave, self._panels, self._study = autosave, panels, study
        self._files, self._restored = files, restored
        self._kept = study.scenario  # as of the last look
        self._orphans = autosave.orphans() if autosave else []
        self._offer()

    def keep(self):
        """Keep the scenario if it is neither a file's nor the first one."""
        if self._autosave is None or self._study.scenario is self._kept:
            return
        self._kept, text = self._study.scenario, self._files.text()
        try:
            if text == self._files.saved_text:
                self._autosave.forget()
            else:
                self._autosave.keep(text)
        except OSError as error:
            self._autosave = None
            text = "edits cannot be saved for recovery after a crash: {}".format(error)
            self._panels.say(ErrorMessage(text))

    def forget(self):
        """Remove the autosaved edits: the GUI ends normally."""
        if self._autosave is not None:
            self._autosave.forget()

    def _offer(self):
        """Offer the newest edits that a crash has left."""
        if not self._orphans:
            self._panels.banners.clear("edits")
            return
        text = "The GUI ended unexpectedly; edits of {} were not saved.".format(
            time_of(self._orphans[0])
        )
        buttons = ("Restore", self._restore), ("Discard", self._discard)
        self._panels.banners.notify("edits", "warning", text, *buttons)

    def _restore(self):
        orphan = self._orphans.pop(0)
        try:
            self._restored(scenario_from_yaml(orphan.text, "edits"))
        except Exception as error:  # its protocol may raise anything
            text = "not restored, still in {}: {}".format(orphan.path, reason(error))
            self._panels.say(ErrorMessage(text))
        else:
            self.keep()
            self._autosave.discard(orphan)
        self._offer()

    def _discard(self):
        self._autosave.discard(self._orphans.pop(0))
        self._offer()
