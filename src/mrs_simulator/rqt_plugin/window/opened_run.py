"""Shows a recorded run in place of the one of now, with time line, map, curves and verdict."""

import os
import tempfile

from mrs_simulator.rqt_plugin.curves.quantities import ErrorCurve
from mrs_simulator.rqt_plugin.curves.source import Source
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.run.loaded_run import load_run
from mrs_simulator.rqt_plugin.shelf.entry import data_of, run_at
from mrs_simulator.rqt_plugin.shelf.run_row import when_text
from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.study.results.report import VERDICT_FILE
from mrs_simulator.vehicles import Team
from mrs_simulator.verdict.verdict_file import read_verdict

LOOKING = "look", "ahead", "measure"  # modes of the mouse that edit nothing
JUDGE, JUDGE_LIMIT = "judge_opened", 300.0  # name of the request; [s] of wall time


class OpenedRun:
    """One recorded run at a time; an edit, or a run that begins, shows the window's own again."""

    def __init__(self, panels, study, live, replay, editing):
        self._panels, self._study, self._live = panels, study, live
        self._replay, self._editing = replay, editing
        self._worker, self._asked = DebouncedWorker(0.0), ""
        self.run, self.source = None, None  # the ``LoadedRun`` that is shown, and its ``Source``
        self._own_verdict, self._begun = None, (None, 0)
        self._row, self._facts = -1, None  # of the sample whose targets and graph are shown
        panels.time_line.close_asked.connect(guarded(self.close))

    @property
    def path(self):
        """Return the path of the run that is shown or being read, "" for none."""
        return self._asked or (self.run.path if self.run is not None else "")

    def open(self, path):
        """Show the run at ``path``, a folder, its ``run.csv`` or a bag, once it is read."""
        try:
            path = run_at(path)
        except ValueError as error:
            self._panels.say(ErrorMessage(reason(error)))
            return
        if path == self.path:
            return
        self._asked, ask = path, self._study.edited.ask_apart
        self._worker.ask(lambda: load_run(path, data_of(path), ask))

    def follow(self):
        """Show what was read by now; close what an edit, or a new run, has overtaken."""
        found = self._worker.take()
        if found is not None:
            path, self._asked = self._asked, ""
            run, error = found
            if error is not None:
                text = "not opened: {}: {}".format(path, reason(error))
                self._panels.say(ErrorMessage(text))
            else:
                self._show(run)
        if self.run is not None and self._overtaken():
            self.close()
        if self.run is not None:
            self._panels.time_line.set_opened(self._title())  # it may be renamed

    def _title(self):
        """Return the name and the time of the run that is shown."""
        path = self.run.path
        about = self._panels.shelf.list.runs.about(path)
        try:
            name, when = about or (os.path.basename(path), os.path.getmtime(data_of(path)))
        except OSError:  # it was deleted
            return os.path.basename(path)
        return "{}, {}".format(name, when_text(when))

    def show_frame(self):
        """Show targets and graph of the moment that is shown."""
        row, run, shown = self._replay.cursor.row, self.run, self._panels.map
        if run is None or row == self._row:
            return
        self._row, facts = row, run.facts_at(row)
        shown.show_targets(run.targets_at(row))
        if facts is not self._facts:
            self._facts, graph = facts, facts.topology
            shown.show_topology(graph.edges, graph.directed)

    def _overtaken(self):
        shown = self._panels.map
        return (
            not self._stands()
            or shown.mode not in LOOKING
            or (self._replay.is_shown and not shown.is_past)
        )

    def _stands(self):
        """Return whether nothing was edited, and no run has begun, since the run was shown."""
        scenario, runs = self._begun
        return scenario is self._study.scenario and runs == self._live.runs

    # Showing -------------------------------------------------------------------------------------

    def _show(self, run):
        panels = self._panels
        if self.run is None:
            self._own_verdict = panels.verdict.verdict
        self._row, self._facts = -1, None
        self.run, self._begun = run, (self._study.scenario, self._live.runs)
        panels.modes["look"].setChecked(True)
        self.source = source_of(run, "")
        self._show_on_map(run)
        panels.curves.show_source(self.source)
        self._replay.show_run(run.history)
        panels.time_line.set_opened(self._title())
        if run.verdict is not None:
            panels.verdict.set_verdict(run.verdict)
        else:
            panels.verdict.clear()
            self._judge(run)
        for trouble in run.troubles:
            panels.say("{}: {}".format(os.path.basename(run.path), trouble))
        self._replay.show_frame()
        self.show_frame()
        panels.map.fit(whole=True)

    def _show_on_map(self, run):
        """Show the team and the obstacles of ``run``; graph and targets are those of a moment."""
        shown, scenario = self._panels.map, run.scenario
        if scenario is None:
            shown.show_obstacles(())
        else:
            shown.show_kinds(Team.from_scenario(scenario).kinds)
            shown.show_obstacles(obstacles_of(scenario))
        shown.show_load(None if scenario is None else scenario.load)
        shown.show_topology(())

    def _judge(self, run):
        """Judge a run without a verdict in the background; a run of the shelf keeps its verdict."""
        of_shelf = self._study.shelf.holds(run.path) and os.path.isdir(run.path)
        processes = self._study.processes

        def work():
            out = run.path if of_shelf else tempfile.mkdtemp(dir=processes.directory)
            arguments = [run.path, "--out", out, "--formats", ""]
            code, output = processes.run(JUDGE, "report", *arguments, limit=JUDGE_LIMIT)
            path = os.path.join(out, VERDICT_FILE)
            if code not in (0, 1) or not os.path.exists(path):
                return False, (run.path, output)
            return True, (run.path, read_verdict(path))

        self._study.connection.do(JUDGE, work)

    def judged(self, success, answer):
        """Take the answer of the request ``JUDGE``."""
        if not success:
            what = answer[1] if isinstance(answer, tuple) else answer
            self._panels.say(ErrorMessage("the run was not judged: {}".format(what)))
        elif self.run is not None and self.run.path == answer[0]:
            self.run = self.run._replace(verdict=answer[1])
            self._panels.verdict.set_verdict(answer[1])

    def keep_own_verdict(self, verdict):
        """Take the ``verdict`` on the window's own run, which is shown once this one is closed."""
        self._own_verdict = verdict

    def close(self):
        """Show the window's own run and scenario again."""
        if self.run is None:
            return
        panels, self.run, self.source = self._panels, None, None
        panels.time_line.set_opened("")
        panels.curves.show_source(None)
        self._replay.show_run(None)
        self._editing.show_on_map()
        if self._study.connection.snapshot() is not None and self._replay.cursor.span is not None:
            self._replay.show_newest()
        if self._own_verdict is None or not self._stands():
            panels.verdict.clear()
        else:
            panels.verdict.set_verdict(self._own_verdict)
        self._own_verdict = None

    def end(self):
        """End the thread."""
        self._worker.ask(None)


def source_of(run, name):
    """Return the ``Source`` of a ``LoadedRun`` called ``name``."""
    source = Source(run.history, name)
    source.error = ErrorCurve(run.error, run.is_users_law)
    if run.prediction is not None:
        source.set_prediction(run.prediction.time, run.prediction.error)
    if run.scenario is not None:
        team = Team.from_scenario(run.scenario)
        source.team = team.axes, team.is_spatial
    else:
        source.team = run.history.axes, bool(run.history.state.heights.any())
    return source
