"""Writes a run's data, figures and verdict; without Qt."""

import functools
import os
import re
import shutil
import threading
import time

from mrs_simulator.record.run_changes import changed_by, to_plain
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.run.recorded_run import copy_recorded, describe, note_closest
from mrs_simulator.rqt_plugin.run.run_writing import estimated, write_run
from mrs_simulator.rqt_plugin.run.staged import staged_scenario
from mrs_simulator.rqt_plugin.shelf.folder import SAVED
from mrs_simulator.scenario.surroundings.moving_obstacles import scene_facts, scene_time
from mrs_simulator.study.results.report import VERDICT_FILE
from mrs_simulator.study.run.applied_scenario import what_ran
from mrs_simulator.verdict.estimation import UNKNOWN

FIGURES = "png,pdf,svg"  # formats of the figures that are saved
CANCELLED = "cancelled; what was written is in {}"
LOST = "{} samples are left out: the controller published no estimates for their times"
REPORT_LIMIT = 300.0  # [s] of wall time for figures and verdict
KEEP_LIMIT = 60.0  # [s] of wall time that the GUI waits at its end for a run to be kept


class RunFiles:
    """Saves runs, each with the scenario that ran, in the background."""

    def __init__(self, connection, processes, edited, missed, shelf):
        """``edited``: the ``EditedScenario``; ``missed``: the ``MissedPeriods`` of the run.

        ``shelf``: the ``Shelf``, on which runs are kept that are not saved elsewhere.
        """
        self._connection, self._processes, self._shelf = connection, processes, shelf
        self._edited, self._missed = edited, missed
        self.saving, self._cancelled = "", threading.Event()  # what a save is at
        self._keeping = []  # ``Event``s, set when an unsaved run is written

    @staticmethod
    def results_directory():
        """Return where results are suggested to go."""
        return os.path.join(os.path.expanduser("~"), SAVED)

    def suggested_name(self, history=None):
        """Return a name: the title of the run in ``history``, None for the next one, and the time."""
        scenario = self._edited.scenario if history is None else self.ran(history)[0]
        return _named(scenario)

    def new_folder(self, what):
        """Make and return a new folder beside other results, for a ``what`` of the edited scenario."""
        wanted = os.path.join(self.results_directory(), self.suggested_name() + "_" + what)
        path, count = wanted, 2
        while os.path.exists(path):
            path, count = "{}_{}".format(wanted, count), count + 1
        os.makedirs(path)
        return path

    def short_path(self, path):
        """Return the ``path`` of something as users write it: short among the results."""
        below = os.path.relpath(path, self.results_directory())
        return path if below.startswith(os.pardir) else os.path.join("~", SAVED, below)

    def save(self, history, directory, more=()):
        """Write ``run.csv``, scenario, figures and verdict to ``directory``, in the background.

        ``more``: options of ``report`` for what it is to write besides.
        """
        self.saver(history, directory, FIGURES, more)()

    def saver(self, history, directory, formats, more=()):
        """Return a function that begins to save the run as it is now; ``formats``: of figures, or ""."""
        done = functools.partial(self._describe, history.recorded, directory)
        return self._saver(self.writing(history, directory), directory, formats, more, done)

    def saver_of(self, path, directory, more=()):
        """As ``saver``, of the recorded run at ``path``, a folder or a bag, with figures."""

        def write(report):
            if os.path.isdir(path):
                shutil.copytree(path, directory, dirs_exist_ok=True)
            return path

        return self._saver(write, directory, FIGURES, more, lambda: None)

    @staticmethod
    def _describe(recorded, directory):
        """Describe a run in ``directory`` that a program has ``recorded`` to another one, if any."""
        if recorded is not None:
            note_closest(directory)
            describe(directory)

    def _saver(self, write, directory, formats, more, done):
        """Return a function that begins to save the run that ``write(report)`` writes; then ``done()``."""
        made = "figures and the verdict" if formats else "the verdict"

        def report(share):
            self.saving = "writing run.csv, {:.0%}".format(share)

        def work():
            report(0.0)
            path = _whole(write, directory, report)
            self.saving = "making " + made + (", and the video" if more else "")
            if self._cancelled.is_set():
                return False, CANCELLED.format(directory)
            arguments = [path, "--out", directory, "--formats", formats, *more]
            code, output = self._processes.run("report", "report", *arguments, limit=REPORT_LIMIT)
            if self._cancelled.is_set():
                return False, CANCELLED.format(directory)
            verdict = os.path.join(directory, VERDICT_FILE)
            if code not in (0, 1) or not os.path.exists(verdict):
                return False, output
            done()
            return True, verdict

        def begin():
            self._cancelled.clear()
            self.saving = "preparing"
            self._connection.do("save", work)

        return begin

    def cancel(self):
        """Cancel saving; data already written stays, as the answer of ``save`` reports."""
        self._cancelled.set()
        self._processes.cancel("report")

    def keep(self, history):
        """Write the data of an unsaved run beside the other results; return a message."""
        return self._to_keep(history)()

    def keep_aside(self, history):
        """As ``keep``, in the background: the result ``keep`` is the message."""
        write, written = self._to_keep(history), threading.Event()
        self._keeping = [each for each in self._keeping if not each.is_set()] + [written]

        def work():
            try:
                return True, write()
            finally:
                written.set()

        self._connection.do("keep", work)

    def wait_kept(self, limit=KEEP_LIMIT):
        """Wait until what is kept in the background is written, at most ``limit`` [s]."""
        end = time.monotonic() + limit
        for written in self._keeping:
            written.wait(max(0.0, end - time.monotonic()))

    def shelf_directory(self, history):
        """Return a new directory's path on the shelf for the run in ``history``."""
        return self._shelf.new_directory(self.ran(history)[0].title)

    def _to_keep(self, history):
        """Return a function that writes the data of an unsaved run to the shelf, and returns a message."""
        ran = self.ran(history)
        directory = self._shelf.new_directory(ran[0].title)
        write = self.writing(history, directory, ran)
        return lambda: self._kept(write, directory, history.recorded)

    @staticmethod
    def _kept(write, directory, recorded):
        try:
            path = _whole(write, directory)
        except OSError as error:
            left = _moved_out(recorded)
            rest = "; what was recorded of it is in {}".format(left) if left else ", and is lost"
            return ErrorMessage("the previous run was not saved{}: {}".format(rest, error))
        return "the previous run was not judged; its data is kept in {}".format(path)

    def ran(self, history):
        """Return the scenario that the run in ``history`` began with, and facts of it for ``run.json``.

        A law, a gain or a team that were edited since are not part of it.
        """
        scenario = self._edited.scenario if history.scenario is None else history.scenario
        applied, changes, staged = None, [], None
        if history.begun is not None:
            origin = self._origin(history)
            applied, changes = history.applied.during(
                origin + history.begun, origin + history.time[-1]
            )
        try:
            if history.staged is not None:
                staged = staged_scenario(history.staged)
            ran, unknown = what_ran(scenario, staged, applied)
            changed_by(ran, changes)
        except ValueError as error:
            return scenario, {
                "warnings": ["the scenario of the run is not known: {}".format(error)]
            }
        facts = {"changes": to_plain(changes), "unknown_law": unknown}
        return ran, {key: value for key, value in facts.items() if value}

    def _origin(self, history):
        """Return the ROS time [s] of zero in ``history``: of real robots alone it is another."""
        alone = history.real.issuperset(history.numbers)
        return self._connection.first_stamp() if alone else 0.0

    def writing(self, history, directory, ran=None):
        """Return a function that writes a run's data, and returns its path; from any thread.

        It calls ``report``, if given, with the share that is written, after each hundredth.  ``ran``: what
        :meth:`ran` returned, if it is known.
        """
        if history.recorded is not None:
            return self._copying(history.frozen(0), directory)
        # The run begins with the first command, as it does for the recorder.
        run, lost = estimated(history.frozen(history.first_row()))
        scenario, facts = self.ran(history) if ran is None else ran
        numbers, when = run.numbers, run.time
        meta = self._controller_facts(when[0], when[-1], history)
        meta.update(facts, warnings=meta["warnings"] + facts.get("warnings", []))
        incidents = [
            i._replace(time=i.time - when[0]) for i in history.incidents if i.time >= when[0]
        ]
        if incidents:
            meta["incidents"] = incidents
        if history.begun is None:
            meta["uncommanded"] = True
        elif self._missed.text():
            meta["degraded"] = self._missed.text()
        meta["warnings"] += [LOST.format(lost)] if lost else []
        if run.estimate is not None and run.real.issuperset(numbers):
            meta.update(truth_unknown=True, warnings=[*meta["warnings"], UNKNOWN])
        if not history.real.issuperset(numbers):
            meta.update(scene_facts(scenario.obstacles, scene_time(when[0])))
        return lambda report=lambda share: None: write_run(run, scenario, directory, meta, report)

    def _copying(self, run, directory):
        """As :meth:`writing`, of a ``History`` ``run`` that a program records."""

        def copied(report=lambda share: None):
            sizes = self._connection.finish_record(run.recorded)
            return copy_recorded(run.recorded, directory, sizes, run, report)

        return copied

    def _controller_facts(self, begin, end, history):
        """Return what is known of the run in ``history`` from ``begin`` to ``end`` [s]."""
        controller, origin = self._connection.controller, self._origin(history)
        meta = {"warnings": controller.warnings(origin + begin, origin + end)}
        meta.update(history.facts_of_real())
        ended = controller.ended(origin + begin) or controller.emergency(
            origin + begin, origin + end
        )
        return {**meta, "ended": ended} if ended else meta


def _whole(write, directory, *given):
    """Return what ``write(*given)`` does to ``directory``; a new one goes again where it has no room."""
    is_new = not os.path.exists(directory)
    try:
        os.makedirs(directory, exist_ok=True)
        return write(*given)
    except OSError:
        if is_new:
            shutil.rmtree(directory, ignore_errors=True)
        raise


def _moved_out(recorded):
    """Move the directory in which a program has recorded, if any, out of one that goes with the window.

    Return its new path, "" where that cannot be.  That takes no room.
    """
    if recorded is None:
        return ""
    path = "{}_{}".format(os.path.dirname(recorded), os.path.basename(recorded))
    try:
        os.rename(recorded, path)
    except OSError:
        return ""
    return path


def _named(scenario):
    """Return a directory's name: the scenario's title and the time."""
    title = re.sub(r"[^a-z0-9]+", "_", (scenario.title or "run").lower()).strip("_")
    return "{}_{}".format(title[:40], time.strftime("%Y%m%d_%H%M%S"))
