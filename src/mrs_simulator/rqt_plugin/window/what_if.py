"""What if: shows how the run goes on from the moment shown with a robot, an edge or a gain otherwise."""

import os
import shutil
from typing import Any, NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.graphs import edges_without
from mrs_simulator.record.recording import facts_path
from mrs_simulator.rqt_plugin.map.look_ahead import LookAhead
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.scenario.reading import read_json
from mrs_simulator.study.results.report import RUN_FILE
from mrs_simulator.study.run.ahead import FIDELITIES, Edit
from mrs_simulator.study.run.law_process import LawProcess

KEEP = "keep_ahead"  # name of the request
LIMIT, KEEP_LIMIT = 120.0, 300.0  # [s] of wall time for one look, or for a run that is kept
FIRST, NEXT = 0.1, 0.1  # [s] of wall time for the first picture of a look, and between two
MODE = "ahead"  # of the map


class Subject(NamedTuple):
    """The run that is looked ahead of, at the moment that is shown."""

    key: Tuple  # the same for one run alone
    scenario: Any
    changes: Tuple  # during the run, as run.json has them
    moment: float  # [s] since it began
    pose: Any  # (n, 3) of then


@guarded
class WhatIf:
    """Asks how the run goes on, in a process apart, and draws it as ghosts."""

    def __init__(self, panels, study, history, live, replay, opened):
        self._panels, self._study, self._history = panels, study, history
        self._live, self._replay, self._opened = live, replay, opened
        self._laws, self._worker = LawProcess(LIMIT), DebouncedWorker(0.0)
        self._subject, self._waits, self._can_keep = None, False, False
        self._moved, self._gains, self._gone, self._shown = {}, {}, [], None
        bar = panels.map_panel.ahead
        panels.map.ahead_moved.connect(self._on_moved)
        panels.map.ahead_cut.connect(self._on_cut)
        panels.modes[MODE].toggled.connect(self._on_mode)
        bar.gain_moved.connect(self._on_gain)
        bar.clear_asked.connect(guarded(self.clear))
        bar.keep_asked.connect(self._on_keep)

    # What is otherwise ---------------------------------------------------------------------------

    def _on_mode(self, on):
        if on:
            run, facts = self._opened.run, self._study.edited.derived
            facts = facts if run is None else run.facts_at(self._replay.cursor.row)
            given = ((), {}) if facts is None else (facts.parameters, facts.values)
            self._panels.map_panel.ahead.set_gains(*given)
        self.clear()

    def _on_moved(self, number, x, y):
        subject = self._begin()
        if subject is not None and 0 < number <= len(subject.pose):
            self._moved[number - 1] = (x, y)
            self._ask()

    def _on_gain(self, name, value):
        if self._begin() is not None:
            self._gains[name] = value
            self._ask()

    def _on_cut(self, edge):
        """Leave out the edge clicked, or take it in again."""
        if self._begin() is not None:
            (self._gone.remove if edge in self._gone else self._gone.append)(edge)
            self._ask()

    def _begin(self):
        """Return the ``Subject`` of this look, None where there can be none, which is said."""
        if self._subject is None:
            why = self.no_look()
            if why:
                self._panels.map_panel.ahead.show_state("Not now: " + why, False, why)
                return None
            self._subject = self._now()
        return self._subject

    def no_look(self):
        """Return why there can be no look ahead now, or ""."""
        run, ran = self._opened.run, self._live.ran
        if run is None and self._study.state.real():
            return "real robots are not simulated: open the recorded run on the list, or its simulation"
        scenario = self._study.scenario if ran is None else ran[0]
        scenario = scenario if run is None else run.scenario
        if scenario is None or (run is None and ran is not None and "unknown_law" in ran[1]):
            return "the law of the run is not known"
        if scenario.fidelity not in FIDELITIES:
            return "with forces (fidelity: {}) no robot can be put elsewhere".format(
                scenario.fidelity
            )
        return ""

    def _now(self):
        """Return the ``Subject`` of the moment that is shown."""
        run = self._opened.run
        if run is not None:
            facts = facts_path(os.path.join(run.path, RUN_FILE))
            changes = read_json(facts).get("changes", []) if os.path.exists(facts) else []
            return self._of(("opened", run.path), run.scenario, changes, run.history, run.begin)
        history, ran = self._history, self._live.ran
        if ran is None or history.begun is None:
            scenario = self._study.scenario
            pose = np.array(scenario.poses, dtype=float)
            return Subject(("edited", scenario.to_yaml()), scenario, (), 0.0, pose)
        changes = ran[1].get("changes", [])
        key = "own", history.cleared, len(changes)
        return self._of(key, ran[0], changes, history, history.begun)

    def _of(self, key, scenario, changes, history, begun):
        cursor = self._replay.cursor
        row = cursor.row if cursor.is_past else len(history.time) - 1
        first = int(np.searchsorted(history.time, begun))
        row = max(first, row)
        scenario = scenario._replace(poses=history.pose[first].copy())
        moment = float(history.time[row] - begun)
        return Subject(key, scenario, tuple(changes), moment, history.pose[row].copy())

    def _edit(self):
        """Return what is otherwise, as an ``Edit``."""
        edges = self._panels.map.edges
        topology = None
        if self._gone:
            left = edges_without(edges.list, self._gone, edges.directed)
            topology = left, edges.directed
        subject = self._subject
        given = dict(self._moved), dict(self._gains), topology
        return Edit(subject.moment, subject.pose, *given)

    def clear(self):
        """Change nothing, and look no further."""
        self._worker.ask(None)
        self._subject, self._waits, self._can_keep = None, False, False
        self._moved, self._gains, self._gone, self._shown = {}, {}, [], None
        self._panels.map.show_ahead(None)
        self._panels.curves.show_ahead(None, None)
        bar = self._panels.map_panel.ahead
        bar.take_back()
        bar.show_state("", False)

    # Looking -------------------------------------------------------------------------------------

    def _ask(self):
        subject, edit, ask = self._subject, self._edit(), self._laws.ask
        given = subject.scenario, subject.key, list(subject.changes)

        def look():
            scenario, key, changes = given
            while not ask("ahead", scenario, "prepare_ahead", key, changes, edit.time, NEXT):
                pass
            return edit, ask("ahead", scenario, "look_ahead", key, changes, edit, FIRST)

        self._waits, self._can_keep = True, False
        self._panels.map_panel.ahead.keep.setEnabled(False)
        self._worker.ask(look)
        if self._shown is None:
            self._panels.map_panel.ahead.show_state(self._said(edit) + " ...", False)

    def show_frame(self):
        """Show how far the look ahead is by now; a run that is gone is looked ahead of no more."""
        if self._subject is not None and self._is_gone():
            self.clear()
            return
        found = self._worker.take() if self._waits else None
        if found is None:
            return
        self._waits = False
        (edit, future), error = found[0] or (None, None), found[1]
        if error is not None:
            text = "Not to be had: {}".format(reason(error))
            self._panels.map_panel.ahead.show_state(text, False)
            return
        self._show(edit, future)
        if not future.is_whole:
            ask, scenario = self._laws.ask, self._subject.scenario
            self._waits = True
            self._worker.ask(lambda: (edit, ask("ahead", scenario, "look_further", NEXT)))

    def _is_gone(self):
        kind, of = self._subject.key[:2]
        if kind == "own":
            return self._opened.run is not None or of != self._history.cleared
        if kind == "opened":
            return self._opened.run is None or self._opened.run.path != of
        return self._history.begun is not None or self._opened.run is not None

    def _show(self, edit, future):
        self._shown = edit, future
        self._panels.map.show_ahead(LookAhead(future.pose, tuple(edit.places)))
        self._panels.curves.show_ahead(future.time, future.error)
        self._can_keep = future.is_whole
        text = "{}: {}".format(self._said(edit), _outcome(future))
        self._panels.map_panel.ahead.show_state(text, self._can_keep)

    def _said(self, edit):
        """Return what is otherwise in ``edit``, and from when on, in words."""
        return "From {:.1f} s, {}".format(edit.time, self._changed(edit))

    def _changed(self, edit):
        """Return what is otherwise in ``edit``, in words."""
        gains = ["{} = {:.4g}".format(name, value) for name, value in edit.parameters.items()]
        moved = [
            "robot {} at ({:.2f}, {:.2f})".format(row + 1, *at) for row, at in edit.places.items()
        ]
        gone = ["without {}\u2013{}".format(*edge[:2]) for edge in self._gone]
        return ", ".join(gains + moved + gone) or "as it was"

    # Keeping -------------------------------------------------------------------------------------

    def _on_keep(self):
        subject, edit = self._subject, self._edit()
        path = self._study.shelf.new_directory("{} what if".format(subject.scenario.title or "run"))
        scenario, changes, said = subject.scenario, list(subject.changes), self._said(edit)
        name = "what if at {:.1f} s: {}".format(edit.time, self._changed(edit))
        listed = self._panels.shelf.list.runs
        origin = listed.about(listed.shown) or (scenario.title or "run", 0.0)

        def work():
            laws = LawProcess(KEEP_LIMIT)
            try:
                laws.ask("ahead", scenario, "keep_ahead", changes, edit, path)
                return True, (path, said, name, origin)
            except Exception as error:  # of a law, which may raise anything
                shutil.rmtree(path, ignore_errors=True)
                return False, reason(error)
            finally:
                laws.close()

        self._panels.say("keeping the run: {}".format(said))
        self._panels.map_panel.ahead.show_state("Keeping {} ...".format(said), False)
        self._study.connection.do(KEEP, work)

    def kept(self, success, answer):
        """Take the answer to the request ``KEEP``; return True, since nothing more is to be said."""
        bar = self._panels.map_panel.ahead
        if success:
            path, said, name, origin = answer
            self._study.shelf.mark(path, name=name, note=said)
            self._study.shelf.note_origin(path, *origin)
            self._panels.say("kept in {}".format(path))
            bar.show_state("Kept as {}, on the list of runs".format(os.path.basename(path)), False)
        else:
            self._panels.say(ErrorMessage("not kept: {}".format(answer)))
            bar.show_state("Not kept: {}".format(answer), False)
        return True

    def close(self):
        """End the process and the thread."""
        self._worker.ask(None)
        self._laws.close()


def _outcome(future):
    """Return what comes of a ``Future``, in words."""
    if future.trouble:
        return future.trouble
    until = "after {:.1f} s".format(future.time[-1])
    until += "" if future.is_whole else ", and on"
    if future.error is None:
        return until
    return "error {:.3g} m {}".format(future.error[-1], until)
