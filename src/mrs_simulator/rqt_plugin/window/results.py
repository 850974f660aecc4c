"""Saves a run with a progress banner, and shows the verdict."""

import functools
import os
import time

import numpy as np

from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.scenario.reading import reason
from mrs_simulator.verdict.verdict_file import read_verdict

SHORTEST_KEPT = 2.0  # [s] of commands, of an unsaved run that is kept
TITLE = "Save results to a new directory"


class Results:
    """Data, figures, verdict and scenario of the run in ``history``."""

    def __init__(self, panels, study, history, files):
        self._panels, self._study, self._history, self._files = panels, study, history, files
        self._since = None  # [s], when the saving that is under way began
        self.directory = None  # of the run saved last

    def can_be_saved(self):
        """Return whether there is a run, and no saving is under way."""
        return bool(len(self._history.time)) and self._since is None

    def ask_where(self, more=()):
        """Ask for the directory to save to; ``more``: options of ``report`` for what else is saved."""
        if not self._nothing_to_save():
            start = os.path.join(
                self._study.files.results_directory(),
                self._study.files.suggested_name(self._history),
            )
            save = functools.partial(self.save, more=more) if more else self.save
            self._files.ask(TITLE, start, "", save, saves=True)

    def judge(self):
        """Save the run on the shelf, and show the verdict."""
        if not self._nothing_to_save():
            self.save(self._study.files.shelf_directory(self._history))

    def save(self, directory, more=()):
        """Save data, figures (PNG, PDF, SVG), verdict and scenario of the run to ``directory``.

        ``more``: options of ``report``.
        """
        if not self._nothing_to_save():
            self._panels.say("saving to {}".format(directory))
            self._history.saved = self._history.moved
            self._since = time.monotonic()
            self._study.files.save(self._history, directory, more)
            self.show_progress()

    def _nothing_to_save(self):
        if self._since is not None:
            text = "not saved: the last results are still being saved"
            return self._panels.say(ErrorMessage(text))
        nothing = ErrorMessage("nothing to save: no data of robots received")
        return not len(self._history.time) and self._panels.say(nothing)

    def show_progress(self):
        """Show the progress of saving."""
        if self._since is None:
            self._panels.banners.clear("saving")
            return
        elapsed = time.monotonic() - self._since
        text = "Saving: {}, {:.0f} s".format(self._study.files.saving, elapsed)
        self._panels.banners.notify("saving", "aside", text, ("Cancel", self._study.files.cancel))

    def ended(self, success, answer):
        """Handle the end of saving; show the verdict, and return whether all was saved."""
        self._since = None
        if success:
            self._show_verdict(answer)
        else:
            self._history.saved = -np.inf  # it is not, or not wholly
        return success

    def _show_verdict(self, path):
        self.directory = os.path.dirname(path)
        self._panels.say("saved to {}".format(self.directory))
        try:
            self._panels.verdict.set_verdict(read_verdict(path))
        except (ValueError, OSError) as error:
            text = "the verdict is saved, but cannot be shown: {}: {}"
            self._panels.say(ErrorMessage(text.format(path, reason(error))))
            return
        self._panels.results_tabs.setCurrentWidget(self._panels.verdict)

    def keep_unsaved(self):
        """Keep the data of an unsaved run in the background, before it is cleared."""
        if self._history.is_unsaved(SHORTEST_KEPT):
            self._panels.say("keeping the previous run, which was not saved")
            self._study.files.keep_aside(self._history)

    def close(self):
        """Keep the data of an unsaved run before the GUI ends."""
        self._study.files.wait_kept()
        if self._history.is_unsaved(SHORTEST_KEPT):
            self._panels.say(self._study.files.keep(self._history))
