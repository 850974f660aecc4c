"""The shelf of runs in the window: looks for runs in the background, and does what its panel asks for."""

import math
import os
import time

from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.shelf.entry import is_run, is_sweep
from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.study.results.report import SCENARIO_FILE

SEEN, HIDDEN = 2.0, 20.0  # [s] between two looks for runs while the list is seen, or is not
RUNS = "Runs (run.csv *.bag)"
GONE = "the shelf holds {:g} GB at most: {} old {} made room: {}"
MOST_NAMED = 5


@guarded
class ShelfControl:
    """Keeps the list of runs up to date, and marks, deletes and adds runs."""

    def __init__(self, panels, shelf, files, opened, results, sweeps):
        """``shelf``: the ``Shelf``; ``files``: the ``ScenarioFiles``; ``opened``: the ``OpenedRun``.

        ``results``: the window's ``Results``, which know where its own run was saved; ``sweeps``: the
        ``SweepControl``.
        """
        self._sweeps = sweeps
        self._panels, self._shelf, self._files = panels, shelf, files
        self._opened, self._results = opened, results
        self._worker, self._looks = DebouncedWorker(0.0), False
        self._looked_at = -math.inf  # [s] of wall time
        self._chosen = ""  # the path of a run that becomes the current one once it is listed
        self._deleted = []  # what can be brought back, the newest last
        panel = panels.shelf
        panel.mark_asked.connect(self._on_mark)
        panel.delete_asked.connect(self._on_delete)
        panel.undo_asked.connect(self._on_undo)
        panel.add_asked.connect(self._on_add)
        panel.unwatch_asked.connect(self._on_unwatch)
        panel.size_chosen.connect(self._on_size)
        panel.list.dropped.connect(self._on_dropped)
        panel.list.show_asked.connect(self._on_show)
        panel.list.folded.connect(guarded(self.look))
        panel.scenario_asked.connect(self._on_scenario)

    # Looking -------------------------------------------------------------------------------------

    def look(self):
        """Look for runs at the next opportunity."""
        self._looked_at = -math.inf

    def follow(self):
        """Show the runs that are there, and their pictures."""
        panel = self._panels.shelf
        panel.list.follow()
        path = self._opened.path or self._results.of_run()
        if panel.list.set_shown(path) and panel.list.current() is None:
            self._chosen = self._chosen or path  # it is not listed yet
        found = self._worker.take()
        if found is not None:
            self._looks = False
            self._show(*found)
        pause = SEEN if panel.isVisible() else HIDDEN
        if not self._looks and time.monotonic() - self._looked_at >= pause:
            self._looks, self._looked_at = True, time.monotonic()
            unfolded = frozenset(panel.list.runs.unfolded)
            self._worker.ask(lambda: self._looked(unfolded))

    def _looked(self, unfolded):
        """Return entries, settings, the size of the user's folder and what made room; in a thread."""
        shelf, gone = self._shelf, []
        entries, settings = shelf.scan(unfolded), shelf.settings()
        own = shelf.own(entries)
        if sum(entry.size for entry in own) > settings["most_bytes"]:
            gone = shelf.make_room([own[0].path])  # the newest, however large
            entries = shelf.scan(unfolded) if gone else entries
            own = shelf.own(entries)
        return entries, settings, sum(entry.size for entry in own), gone

    def _show(self, found, error):
        if error is not None:
            self._panels.say(ErrorMessage("runs: {}".format(reason(error))))
            return
        entries, settings, own, gone = found
        self._panels.shelf.show_entries(entries, settings, own)
        if self._chosen and self._panels.shelf.list.choose(self._chosen):
            self._chosen = ""  # a look that began before it was there has it not
        if gone:
            named = ", ".join(gone[:MOST_NAMED]) + (", ..." if len(gone) > MOST_NAMED else "")
            runs = "run" if len(gone) == 1 else "runs"
            self._panels.say(GONE.format(settings["most_bytes"] / 1e9, len(gone), runs, named))

    # What the panel asks for ---------------------------------------------------------------------

    def _do(self, what, *arguments, **named):
        """Return what a method of the shelf returns; where it raises, say why, and return None."""
        self.look()
        try:
            return what(*arguments, **named)
        except (OSError, ValueError) as error:
            self._panels.say(ErrorMessage(reason(error)))
            return None

    def open(self, path):
        """List and show the run at ``path``, a folder, its ``run.csv`` or a bag, or a sweep's map."""
        path = self._do(self._shelf.add, path)
        if path is not None:
            self._panels.bring_forward(self._panels.shelf.objectName())
            self._chosen = path
            self._on_show(path)

    def _on_show(self, path):
        if is_sweep(path) and not is_run(path):
            self._sweeps.open(path)
        elif path == self._results.of_run():  # which the window has
            self._opened.close()
        else:
            self._opened.open(path)

    def _on_scenario(self, path):
        self._files.open_unless_controlled(os.path.join(path, SCENARIO_FILE))

    def add(self, path):
        """List the run whose folder has the file ``path``, such as its verdict; no copy of a listed run."""
        folder, original = os.path.dirname(path), self._results.original
        if self._do(self._shelf.add, folder) is not None and original not in ("", folder):
            self._do(self._shelf.note_copy, folder, original)

    def _on_mark(self, path, marks):
        self._do(self._shelf.mark, path, **marks)

    def _on_delete(self, path):
        deleted = self._do(self._shelf.delete, path)
        if deleted is not None:
            self._deleted.append(deleted)
            self._panels.shelf.undo.setVisible(True)
            kept = "" if deleted[1] else "; its files stay"
            self._panels.say("{} is off the list{}".format(os.path.basename(path), kept))

    def _on_undo(self):
        if self._deleted and self._do(self._shelf.restore, self._deleted[-1]) is not None:
            self._deleted.pop()
        self._panels.shelf.undo.setVisible(bool(self._deleted))

    def _on_dropped(self, paths):
        for path in paths:
            added = self._do(self._shelf.add, path)
            if added is not None and len(paths) == 1:
                self._chosen = added
                self._on_show(added)

    def _on_add(self, name):
        if name == "run":
            self._files.ask("Add a run", "", RUNS, lambda path: self._on_dropped([path]))
        else:
            chosen = self._watch if name == "watch" else self._keep_in
            self._files.ask("Choose a folder", "", "", chosen)

    def _watch(self, path):
        self._do(self._shelf.add, path)

    def _keep_in(self, path):
        self._do(self._shelf.keep_in, path)

    def _on_unwatch(self, path):
        watched = [each for each in self._shelf.settings()["watched"] if each != path]
        self._do(self._shelf.change, watched=watched)

    def _on_size(self, size):
        self._do(self._shelf.change, most_bytes=int(size))

    def close(self):
        """End the threads; what was deleted is gone now."""
        self._worker.ask(None)
        self._panels.shelf.list.thumbnails.close()
        self._do(self._shelf.empty, self._deleted)
