"""Shows the current run: robots, samples, collisions, theory, and the controller's status."""

import math
import time

import numpy as np

from mrs_simulator.protocols import HOMES
from mrs_simulator.record.run_changes import changed_by, read_changes
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.run.study_state import BY_REQUEST, EMERGENCY
from mrs_simulator.rqt_plugin.widgets import pacing
from mrs_simulator.rqt_plugin.window.disturbance import IncidentTexts
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.run.law_answers import Prediction

MOST_WAITING = 0.3  # [s] of wall time, of pictures of the map for what was painted between
JUMP = 0.3  # [s] of a run between two pictures from which on trails lead through its samples
MOST_PASSED = 100  # [-] of these samples


class LiveRun:
    """Passes what the connection received to map, curves and history."""

    def __init__(self, panels, study, history, pending_team, pending_graph):
        self._panels, self._study, self._history = panels, study, history
        self._connection = study.connection
        self._team, self._graph = pending_team, pending_graph
        self._last_frame = 0.0, None  # when the map last got a snapshot, and which
        self.is_held = False  # whether the map shows a moment that has passed
        self.runs = 0  # [-] that have begun or were put away
        self._last_control = None
        self._is_obeyed = False  # whether targets and graph that are shown are a controller's
        self._reported_trouble = ""  # by the controller
        # its warnings last shown, and those that the user closed
        self._warned, self._dismissed = (), ()
        self.ran = None  # the scenario that the run began with, and facts of it, once it has begun
        self._incidents = IncidentTexts()
        self._forecast = None  # where theory has the robots of the scenario go, (k, n, 2) [m]
        self._of_run, self._until = False, math.inf  # whether theory is of the run; [s] until when

    def put_away(self):
        """Clear what is shown of a run, because the team has changed."""
        self._panels.verdict.clear()
        self.runs += 1
        if not self._connection.is_fresh("state"):  # else the stage begins a run with the new team
            self._connection.forget("state")
            self._history.clear()
            self._panels.map.clear_trails()

    # Robots --------------------------------------------------------------------------------------

    def show_frame(self):
        """Show the newest poses and collisions."""
        if not self.is_held:
            self._show_newest()
        for collision in self._connection.take("collisions"):
            self._history.collisions.append(collision)
            if not self.is_held:
                self._panels.map.flashes.add(collision.x, collision.y)
        for incident in self._connection.take("incidents"):
            self._history.incidents.append(incident)
            self._panels.say(self._incidents.text(incident))

    def go_on(self, state):
        """Show the newest poses again, after ``state``, the newest that is recorded."""
        self.is_held, self._last_frame, self._last_control = False, (0.0, state), None

    def _show_newest(self):
        if self._has_ended():
            self._show_start()
        snapshot, now = self._connection.snapshot(), time.monotonic()
        self.take_samples()  # of a run that has begun the trails do, too
        panels, beside = self._panels, self._panels.beside.is_beside
        share = pacing.MAP if beside else pacing.MAP_ALONE
        shown, robots = panels.map, len(panels.map.team.numbers)
        # What is painted besides counts too, but for long drags of the view.
        spent = min(pacing.pause(shown.spent, share, robots), MOST_WAITING)
        wait = max(pacing.pause(shown.cost, share, robots), spent)
        rested = now - self._last_frame[0] >= wait
        # Robots moved by the user differ from the stage's until it has applied their poses.
        settled = self._team.is_settled()
        if settled and rested and snapshot is not None and snapshot is not self._last_frame[1]:
            passed = self._passed(snapshot.time)
            self._last_frame, shown.spent = (now, snapshot), 0.0
            self._panels.map.show_snapshot(snapshot, passed)

    def _has_ended(self):
        """Return whether the simulation is gone whose robots are shown."""
        if self._last_frame[1] is None:
            return False
        connection = self._connection
        if connection.snapshot() is None:
            return True
        here = self._study.processes.is_running("stage")
        gone = not (here or connection.is_fresh("state") or "stage" in connection.registered)
        if gone and not self._study.state.real():
            connection.forget("stage")
            connection.forget("state")
        return connection.snapshot() is None

    def _show_start(self):
        """Show the robots where the next run puts them, the one that has ended below, faintly."""
        scenario, shown = self._study.scenario, self._panels.map
        self._last_frame = 0.0, None
        shown.put_aside()
        shown.show_team(scenario.poses, scenario.altitude)
        self._show_targets()

    def _show_targets(self):
        """Show the targets of the scenario, none while there are robots without a controller."""
        snapshot, derived = self._connection.snapshot(), self._study.edited.derived
        self._panels.map.show_targets(derived.targets if snapshot is None else None)

    def _show_graph(self):
        """Show the graph of the scenario: that of the controller may be of the one before."""
        graph = self._study.edited.derived.topology
        self._panels.map.show_topology(graph.edges, graph.directed)
        self._panels.topology.set_topology(graph.edges, graph.directed)

    def _passed(self, until):
        """Return the samples between the last picture and ``until`` [s], thinned; None in slow runs."""
        shown = self._last_frame[1]
        since = -math.inf if shown is None or until < shown.time else shown.time
        if until - since < JUMP:
            return None
        time = self._history.time
        first, last = np.searchsorted(time, since, side="right"), np.searchsorted(time, until)
        rows = slice(first, last, max(1, math.ceil((last - first) / MOST_PASSED)))
        return self._history.kept(rows).state if last > first else None

    def take_samples(self):
        """Add the newest samples to the history; a new run begins it anew."""
        for snapshot in self._connection.take_samples():
            if not isinstance(snapshot, StateTable):  # a run begins
                self._history.begin_run(snapshot)
                self.runs += 1
                self._study.missed.begin()
                self._panels.map.clear_trails()
                self._last_frame = 0.0, None  # of the run's trails none is drawn yet
            else:
                self._history.append(snapshot)
        self._history.take_estimates(self._connection.take("estimates"))
        settings = self._connection.take("applied")
        for applied in settings:
            self._history.applied.note(*applied)
        self._follow_run(bool(settings))

    # Theory --------------------------------------------------------------------------------------

    def show_theory(self):
        """Show beside the curves the theory of the edited scenario, unless a run has begun.

        Later edits concern a run only once its controller applies them.
        """
        self._forecast = None  # that of what was
        if not self._of_run:
            edited = self._study.edited
            self._panels.curves.set_error(edited.error_function(), background=edited.is_users_law)
            self._panels.curves.set_prediction(None, None)  # that of what was

    def _follow_run(self, is_changed):
        """Show theory of a run that has begun, from the actual initial poses.

        ``is_changed``: whether a controller applied other settings.
        """
        history, study = self._history, self._study
        if history.begun is None:
            self.ran = None
            if self._of_run:
                self._of_run = False
                self.show_theory()
                study.edited.predict_run(None, ())
                study.edited.predict(study.scenario)
            return
        begins = history.scenario is None
        if begins:
            staged, stage = map(self._connection.newest, ("scenario", "stage"))
            speed = study.scenario.speed if stage is None else stage.speed
            history.scenario = study.scenario._replace(speed=speed)
            history.staged = staged
        if begins or is_changed:
            self._of_run = True
            self._show_theory_of_run()

    def _show_theory_of_run(self):
        """Measure the error from the current targets; show theory until the first change."""
        history, edited = self._history, self._study.edited
        self.ran = self._study.files.ran(history)
        ran, facts = self.ran
        changes = read_changes(facts.get("changes", []))
        now, known = changed_by(ran, changes), "unknown_law" not in facts
        foreign = now.control.protocol not in HOMES
        self._until = changes[0].time if changes else math.inf
        self._panels.curves.set_error(edited.error_function(now) if known else None, foreign)
        edited.predict_run(ran if known else None, history.pose[history.first_row()])

    def show_prediction(self):
        """Show theory's error and settling time once they are there."""
        found = self._study.edited.take_prediction()
        if found is not None:
            answer = self._answer(found)
            self._panels.topology.set_convergence_time(answer.settling)
            if not self._of_run:
                self._panels.curves.set_prediction(answer.time, answer.error)
        self._show_forecast()
        found = self._study.edited.take_run_prediction()
        if found is not None and self._of_run:
            when, error, _ = self._answer(found)
            rows = None if when is None else np.asarray(when) <= self._until
            shown = (None, None) if rows is None else (when[rows], error[rows])
            self._panels.curves.set_prediction(*shown)

    def _show_forecast(self):
        """Show where theory has the robots go, until they do."""
        found, shown = self._study.edited.take_forecast(), self._panels.map
        if found is not None:
            self._forecast = found[0]  # of an error the prediction speaks
        moves = shown.is_past or (self._of_run and not shown.is_at_rest)
        shown.show_forecast(None if moves else self._forecast)

    def _answer(self, found):
        """Return the ``Prediction`` found; an empty one, with a message, where there was an error."""
        if found[1] is not None:
            self._panels.say(ErrorMessage("no prediction: {}".format(reason(found[1]))))
        return found[0] or Prediction(None, None, "")

    # Controller ----------------------------------------------------------------------------------

    def follow_control(self):
        """Show targets, graph and warnings of the running controller."""
        control, panels = self._connection.newest("control"), self._panels
        if not self._connection.is_fresh("control"):
            panels.banners.clear("warnings")
            self._last_control = None
            if self._is_obeyed and not self.is_held:
                self._is_obeyed = False
                self._show_targets()
                self._show_graph()
            return
        if control is self._last_control:
            return
        self._last_control, self._is_obeyed = control, True
        self._report_trouble(control)
        self.show_warnings(control)
        if not self.is_held:
            snapshot = self._connection.snapshot()
            shown = 0 if snapshot is None else len(snapshot.robots)
            # A controller may go on after the simulation of some of its robots.
            panels.map.show_targets(control.targets if 0 < len(control.targets) == shown else None)
        self._follow_graph(control)

    def _follow_graph(self, control):
        """Show the controller's graph, unless it is older than the one edited here."""
        edges = list(control.edges)
        if self._graph.is_old(edges, control.directed):
            return
        if not self.is_held:
            self._panels.map.show_topology(edges, control.directed)
        if len(control.command) == self._study.scenario.n:  # the panel edits the scenario's graph
            self._panels.topology.set_topology(edges, control.directed)

    def _report_trouble(self, control):
        """Report once why a controller stopped all robots or some of them."""
        if control.trouble != self._reported_trouble and (not control.running or control.stopped):
            text = control.trouble and "controller: {}".format(control.trouble)
            # Of the emergency stop there is a bar of its own; the other was wanted.
            expected = control.trouble in (EMERGENCY, BY_REQUEST)
            self._panels.say(text if expected else ErrorMessage(text))
        self._reported_trouble = control.trouble

    def show_warnings(self, control):
        """Show the warnings of a running controller in a banner, such as a deadlock."""
        warnings = control.warnings if control.running else ()
        if not warnings or warnings == self._dismissed:
            self._panels.banners.clear("warnings")
            return
        self._warned, text = warnings, "\n".join(warnings)
        self._panels.banners.notify("warnings", "warning", text, ("Close", self._dismiss_warnings))

    def _dismiss_warnings(self):
        self._dismissed = self._warned
        self._panels.banners.clear("warnings")
