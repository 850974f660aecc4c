"""Saves a run with a progress banner, and shows the verdict."""

import functools
import os
import time

import numpy as np

from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.run.run_files import FIGURES
from mrs_simulator.scenario.reading import reason
from mrs_simulator.verdict.verdict_file import read_verdict

SHORTEST_KEPT = 2.0  # [s] of commands, of an unsaved run that is kept
TITLE = "Save results to a new directory"
NOT_OWN = -1  # in place of the times that the history was cleared, of a run of the list


class Results:
    """Data, figures, verdict and scenario of the run in ``history``."""

    def __init__(self, panels, study, history, files):
        self._panels, self._study, self._history, self._files = panels, study, history, files
        self.opened = None  # the ``OpenedRun``, whose run is saved while it is shown
        self._since = None  # [s], when the saving that is under way began
        self.directory = None  # of the run saved last
        # Times that the history had been cleared when it was saved, and for what is being saved.
        self._cleared, self._saves = -1, history.cleared
        # What is to be saved next: how it begins, the same of it, and the path of the run it copies, None
        # for the one saved before.
        self._waiting = []
        self._copies, self.original = "", ""  # that path of what is being saved, and was saved last

    def can_be_saved(self):
        """Return whether a run is shown, and no saving is under way."""
        return bool(self._shown() or len(self._history.time)) and self._since is None

    def _shown(self):
        """Return the path of the run of the list that is shown, "" where it is the window's own."""
        return self.opened.run.path if self.opened.run is not None else ""

    def of_run(self):
        """Return the directory to which the run in the history was saved, "" where it was not."""
        return self.directory if self._cleared == self._history.cleared else ""

    def ask_where(self, more=()):
        """Ask for the directory to save to; ``more``: options of ``report`` for what else is saved."""
        if self._shown() or not self._nothing_to_save():
            start = os.path.join(self._study.files.results_directory(), self._suggested())
            save = functools.partial(self.save, more=more, path=self._shown())
            self._files.ask(TITLE, start, "", save, saves=True)

    def _suggested(self):
        """Return the name of a directory for the run that is shown."""
        if self._shown():
            return os.path.splitext(os.path.basename(self._shown()))[0] + "_figures"
        return self._study.files.suggested_name(self._history)

    def judge(self):
        """Save the run on the shelf, without figures, and show the verdict."""
        if not self._nothing_to_save():
            directory = self._study.files.shelf_directory(self._history)
            self._begin(self._study.files.saver(self._history, directory, ""))

    def save(self, directory, more=(), path=None):
        """Save data, figures (PNG, PDF, SVG), verdict and scenario of a run to ``directory``.

        ``more``: options of ``report``; ``path``: of a run of the list, "" for the window's own, None for
        the one shown.  What is being saved is finished before.
        """
        path = self._shown() if path is None else path
        if path:
            self._panels.say("saving to {}".format(directory))
            self._wait(self._study.files.saver_of(path, directory, more), NOT_OWN, path)
        elif not self._nothing_to_save():
            self._panels.say("saving to {}".format(directory))
            self._begin(self._study.files.saver(self._history, directory, FIGURES, more))

    def _begin(self, save):
        """Begin to ``save`` the window's own run, once nothing else is being saved."""
        is_saved = self._history.saved >= self._history.moved > -np.inf
        self._history.saved = self._history.moved
        self._wait(save, self._history.cleared, None if is_saved else "")

    def _wait(self, save, of, original):
        self._waiting.append((save, of, original))
        self._go_on()

    def _go_on(self):
        if self._since is None and self._waiting:
            save, self._saves, copies = self._waiting.pop(0)
            self._copies = self.of_run() if copies is None else copies
            self._since = time.monotonic()
            save()
            self.show_progress()

    def _nothing_to_save(self):
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
        self._since, self.original = None, self._copies
        if success:
            self._take_saved(answer)
        elif self._is_of_now():
            self._history.saved = -np.inf  # it is not, or not wholly
        self._go_on()
        return success

    def _is_of_now(self):
        """Return whether what was saved is the run in the history, and no earlier one."""
        return self._saves == self._history.cleared

    def _take_saved(self, path):
        self._panels.say_saved(os.path.dirname(path), "saved to {}")
        if self._saves != NOT_OWN and not self.original:
            self.directory, self._cleared = os.path.dirname(path), self._saves
        if self._is_of_now():
            self._show_verdict(path)

    def _show_verdict(self, path):
        """Show the verdict at ``path`` on the window's own run, once that is shown again."""
        try:
            verdict = read_verdict(path)
        except (ValueError, OSError) as error:
            text = "the verdict is saved, but cannot be shown: {}: {}"
            self._panels.say(ErrorMessage(text.format(path, reason(error))))
            return
        if self.opened.run is not None:
            self.opened.keep_own_verdict(verdict)
            return
        self._panels.verdict.set_verdict(verdict)
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
