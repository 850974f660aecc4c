"""The sweep map in the window: starts the command ``sweep``, follows its cells, opens their runs."""

import os
import re
import time

from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.run.long_command import jobs
from mrs_simulator.rqt_plugin.run.study_run import last_lines
from mrs_simulator.rqt_plugin.sweep.axes import key_of, read_texts, swept_keys
from mrs_simulator.rqt_plugin.sweep.cells import SweepCells, read_news
from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.window.command_control import CommandControl
from mrs_simulator.study.bad_input import BAD_INPUT
from mrs_simulator.study.results.report import write_scenario

EVERY = 0.5  # [s] of wall time between two looks for cells that have ended
SLOWLY = 3.0  # [s] the same, of a sweep that was started elsewhere
BUSY = "{}: not opened: cancel the sweep that runs, or wait for its end"
TWICE = "wanted another parameter than along x"
FOLDER = "in {}"
COMBINATION = re.compile("^.* with (?:[^ =]+=[^ ]+ ?)+: ")  # of values, which a refusal begins with


@guarded
class SweepControl(CommandControl):
    """One sweep at a time, of the scenario as it is edited when it starts."""

    def __init__(self, panels, study, opened):
        """``opened``: the ``OpenedRun``."""
        super().__init__(panels, study, panels.sweep, "sweep")
        self._opened = opened
        self._reader, self._reads, self._looked_at = DebouncedWorker(0.0), False, 0.0
        self._planned, self._known, self._last_look = False, set(), False
        self.cells, self.directory = None, ""
        panel = panels.sweep
        panel.start_asked.connect(self._on_start)
        panel.map.cell_asked.connect(
            guarded(lambda run: opened.open(os.path.join(self.directory, run)))
        )

    # Starting ------------------------------------------------------------------------------------

    def _keys(self):
        derived = self._study.edited.derived
        return swept_keys(self._study.scenario, derived.parameters, derived.values)

    def _on_start(self):
        panel, keys = self._panel, self._keys()
        read = [read_texts(axis.texts(), keys) for axis in panel.axes]
        paths = [key_of(axis.texts().name.strip(), keys).path for axis in panel.axes]
        if paths[0] == paths[1]:
            read[1][2].setdefault("name", TWICE)
        for axis, (_, _, errors) in zip(panel.axes, read):
            axis.show_errors(errors)
        if any(errors for _, _, errors in read) or self._process.is_running:
            return
        try:
            self._start([word for word, _, _ in read])
        except OSError as error:
            panel.note.say("not started: {}".format(reason(error)), "error")
            return
        self.cells = SweepCells(paths, {p: values for p, (_, values, _) in zip(paths, read)})
        self._begin_reading()
        panel.set_running(True)
        self._show()

    def open(self, directory):
        """Show the map of the sweep in ``directory``, made earlier or elsewhere."""
        panel = self._panel
        self._panels.bring_forward(panel.objectName())
        if self._process.is_running:
            self._panels.say(ErrorMessage(BUSY.format(directory)))
            return
        self.directory, self.cells = directory, None
        self._begin_reading()
        self._last_look = True
        panel.show_cells(None)
        panel.note.say("")
        panel.place.say("")

    def _begin_reading(self):
        """Forget what was read of the sweep before."""
        self._planned, self._known, self._last_look = False, set(), False
        self._reader.ask(None)
        self._reads = False
        self._panel.forget_quantities()

    def _start(self, words):
        """Begin the process; what it writes goes to a new folder beside other results."""
        self.directory = self._study.files.new_folder("sweep")
        path = write_scenario(self._study.scenario, self.directory)
        axes = [each for word in words for each in ("--sweep", word)]
        options = "--out", self.directory, "--jobs", jobs(), "--plan"
        self._process.start("experiment", path, *axes, *options)

    # Following -----------------------------------------------------------------------------------

    def follow(self):
        """Show the cells that have ended by now, and what there is to vary."""
        self._take_news()
        self._follow_process()
        if self._is_due() and not self._reads:
            self._reads, self._looked_at = True, time.monotonic()
            self._last_look = self._process.is_running and self._last_look
            out, known, planned = self.directory, set(self._known), self._planned
            self._reader.ask(lambda: read_news(out, known, planned))
        if self.cells is not None:
            folder, run = os.path.split(self._opened.path)
            self._panel.map.show_opened(run if folder == self.directory else "")

    def _offer(self):
        self._panel.offer(self._keys())

    def _is_due(self):
        """Return whether it is time to look for cells that have ended."""
        passed = time.monotonic() - self._looked_at
        grows = self._planned and self.cells is not None and not self.cells.are_known()
        elsewhere = grows and self._panel.isVisible() and passed >= SLOWLY
        return self._last_look or elsewhere or (self._process.is_running and passed >= EVERY)

    def _take_news(self):
        found = self._reader.take()
        if found is None:
            return
        self._reads = False
        news, error = found
        if error is not None:
            self._panels.say(ErrorMessage("sweep: {}".format(reason(error))))
            return
        plan, verdicts = news
        if plan is not None and not self._take_plan(plan):
            return
        if self._planned:
            self._known.update(verdicts)
            self.cells.take_verdicts(verdicts)
        if plan is not None or verdicts:
            self._show()

    def _take_plan(self, plan):
        """Take in the ``plan``; return whether it is one of a map."""
        try:
            if self.cells is None:  # of a sweep that was opened
                self.cells = SweepCells.of_plan(plan)
            else:
                self.cells.take_plan(plan)
        except ValueError as error:
            self._panel.note.say("{}: {}".format(self._place(), error), "error")
            return False
        self._planned = True
        return True

    def _place(self):
        return self._study.files.short_path(self.directory)

    def _show(self):
        panel = self._panel
        panel.show_cells(self.cells)
        panel.note.say(self.cells.summary(), "aside")
        panel.place.say(FOLDER.format(self._place()))

    def _end(self, code):
        """Show how the process has ended with ``code``, and look once more for cells."""
        self._last_look = True
        output = last_lines(self._process.output())
        if self._process.is_cancelled:
            self._panels.say("sweep cancelled; what has ended is in {}".format(self.directory))
        elif code == BAD_INPUT and not self._planned:
            self._refuse(output.rpartition("experiment: ")[2])
        elif code not in (0, 1, 3):
            self._panels.say(ErrorMessage("sweep ended with {}: {}".format(code, output)))
        else:
            self._panels.say("sweep: {}".format(self.directory))

    def _refuse(self, why):
        """Say beside the axis that it names, or below both, why no sweep could begin."""
        panel, self.cells, why = self._panel, None, COMBINATION.sub("", why)
        words = [axis.name.currentText().rpartition(".")[2] for axis in panel.axes]
        named = [axis for axis, word in zip(panel.axes, words) if word in why]
        if len(named) == 1:
            named[0].show_errors({"name": why})
        panel.show_cells(None)
        panel.note.say("" if len(named) == 1 else why, "error")
        panel.place.say("")

    def close(self):
        """Read nothing more; the process ends with the others."""
        self._reader.ask(None)
