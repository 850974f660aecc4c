"""The whole GUI as one widget: team, protocol, topology, map, curves, verdict, and the run."""

from mrs_simulator.rqt_plugin.qt.QtCore import QTimer
from mrs_simulator.rqt_plugin.qt.QtWidgets import QApplication
from mrs_simulator.rqt_plugin.run.bar import EXPORT
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.run.history import History
from mrs_simulator.rqt_plugin.run.study_run import StudyRun
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.messages import ErrorLog
from mrs_simulator.rqt_plugin.window.comparison import Comparison
from mrs_simulator.rqt_plugin.window.course import Course
from mrs_simulator.rqt_plugin.window.disturbance import Disturbance
from mrs_simulator.rqt_plugin.window.edge_lens import EdgeLens
from mrs_simulator.rqt_plugin.window.export import Export
from mrs_simulator.rqt_plugin.window.law_trial import LawTrial
from mrs_simulator.rqt_plugin.window.live_run import LiveRun
from mrs_simulator.rqt_plugin.window.opened_run import JUDGE, OpenedRun
from mrs_simulator.rqt_plugin.window.panels import StudyPanels
from mrs_simulator.rqt_plugin.window.past_run import PastRun
from mrs_simulator.rqt_plugin.window.pending import PendingGraph, PendingTeam
from mrs_simulator.rqt_plugin.window.program_control import ProgramControl
from mrs_simulator.rqt_plugin.window.replay import Replay
from mrs_simulator.rqt_plugin.window.results import Results
from mrs_simulator.rqt_plugin.window.saved_layout import restore_layout, saved_layout
from mrs_simulator.rqt_plugin.window.scenario_editing import ScenarioEditing
from mrs_simulator.rqt_plugin.window.scenario_files import ScenarioFiles
from mrs_simulator.rqt_plugin.window.search import SearchControl
from mrs_simulator.rqt_plugin.window.selection import Selection
from mrs_simulator.rqt_plugin.window.sensing import Sensing
from mrs_simulator.rqt_plugin.window.shelf import ShelfControl
from mrs_simulator.rqt_plugin.window.start import Start
from mrs_simulator.rqt_plugin.window.status import Status
from mrs_simulator.rqt_plugin.window.sweep import SweepControl
from mrs_simulator.rqt_plugin.window.unsaved_edits import UnsavedEdits
from mrs_simulator.rqt_plugin.window.what_if import KEEP, WhatIf
from mrs_simulator.rqt_plugin.window.whole_run import WholeRun
from mrs_simulator.scenario.scenario import Scenario, scenario_from_yaml

FRAME = 33  # [ms] of wall time between two pictures of the map
TICK = 100  # [ms] between two looks at everything else
OLD_POSE = "{}; the table shows the old value again, with which another click starts"
STARTING = ("run", "simulate", "control")  # actions that use what is edited


@guarded
class StudyWidget(StudyPanels):
    """The window of a coordination study; ``close_study`` ends what was started here."""

    def __init__(self, connection, processes, scenario, autosave=None, parent=None):
        """``connection``: ``RosConnection``; ``scenario``: what to begin with; ``autosave``, if any."""
        super().__init__(parent)
        self.connection = connection
        self.study = StudyRun(connection, processes, scenario)
        self.history, self._errors = History(), ErrorLog()
        self.curves.set_history(self.history)
        self.trial = LawTrial(self, self.study.edited.laws, self._show_possible)
        self.pending_team, self.pending_graph = PendingTeam(self.study), PendingGraph()
        pending = self.pending_team, self.pending_graph
        self.live = LiveRun(self, self.study, self.history, *pending)
        self.replay = Replay(self, self.study, self.history, self.live)
        self.show_time_line(self.replay.cursor)
        self.editing = ScenarioEditing(self, self.study, self.live, *pending)
        self.files = ScenarioFiles(self, self.study, self.editing, self.live, self.pending_team)
        self.load, self.save_scenario = self.files.load, self.files.save
        self.selection = Selection(self)
        self.sensing = Sensing(self, self.study, self.history)
        self.program_control = ProgramControl(self, self.study)
        self.results = Results(self, self.study, self.history, self.files)
        self.save_results = self.results.save
        self.opened = OpenedRun(self, self.study, self.live, self.replay, self.editing)
        self.results.opened = self.opened
        processes = self.study.processes
        self.course = Course(self, self.study, self.history, self.live, self.opened)
        self.comparison_control = Comparison(
            self, self.study, self.history, self.replay, self.opened, self.results
        )
        given = self.results, self.files, processes, self.opened, self.comparison_control
        self.export = Export(self, *given)
        self.curves.export_asked.connect(guarded(self.export.do))
        self.sweep_control = SweepControl(self, self.study, self.opened)
        given = self.files, self.opened, self.results, self.sweep_control
        self.shelf_control = ShelfControl(self, self.study.shelf, *given)
        self.search_control = SearchControl(
            self, self.study, self.opened, self.replay, self.files, self.shelf_control
        )
        self.history.before_clearing = guarded(self.results.keep_unsaved)
        self.disturbance = Disturbance(self, self.study)
        self.edge_lens = EdgeLens(self, self.study, self.opened, self.replay)
        self.what_if = WhatIf(self, self.study, self.history, self.live, self.replay, self.opened)
        given = self.results, self.pending_team, self.say
        self.whole = WholeRun(self.study, self.history, *given)
        self.past = PastRun(self, self.study, self.history, self.opened)
        given = self.results, self.trial, self.whole, self.past
        self.status_line = Status(self, self.study, *given)
        self._refused = ""  # why a number of an obstacle was, when it was taken over
        self.map_panel.obstacles.refused.connect(self._on_refused)
        self.bar.asked.connect(self._on_asked)
        self.bar.speed_chosen.connect(self._on_speed)
        self.bar.emergency.connect(self._on_emergency)
        self.preflight.start_asked.connect(self._on_start_anyway)
        self.hide_absent(connection.absent)
        self.editing.take(scenario)
        self.files.saved_text = self.files.text()
        self.start = Start(self, self.files, self.shelf_control)
        self.edits = UnsavedEdits(autosave, self, self.study, self.files, self._restored)
        self._start_timer(FRAME, self._on_frame)
        self._start_timer(TICK, self.tick)
        self.tick()

    def _start_timer(self, period, slot):
        timer = QTimer(self, timeout=slot)
        timer.start(period)

    @property
    def scenario(self) -> Scenario:
        """Return the scenario as edited so far."""
        return self.study.scenario

    def _restored(self, scenario):
        """Open edits recovered after a crash."""
        self.editing.take(scenario)
        self.live.put_away()
        self.pending_team.changed()

    def _show_possible(self):
        self.status_line.show_possible()

    # The run -------------------------------------------------------------------------------------

    def _on_asked(self, name):
        if name == "save":
            self.results.ask_where()
            return
        if name.startswith(EXPORT):
            self.export.do(name[len(EXPORT) :])
            return
        self.close_error()  # that of what was done before
        if name in (*STARTING, "reset", "end"):
            self.saved.forget()
        if name in STARTING and not self._finish_edits():
            return
        before = self.scenario
        if name == "run":
            self.say(self.whole.begin(self.bar.speed()))
        else:
            self.say(self.study.do(name, self.bar.speed()))
        if name in ("reset", "end", "stop"):
            self.whole.give_up()
        if self.scenario is not before:  # that of a stage that was started elsewhere
            self.editing.show()
        self._show_begun()

    def _finish_edits(self):
        """Take over what is being typed; show and say what is refused, and return whether nothing is."""
        self._refused = ""
        focused = QApplication.focusWidget()
        if focused is not None and self.isAncestorOf(focused):
            focused.clearFocus()  # by which its field takes the text over
            # Without a focus in the window its keys would sleep.
            (focused if focused.isVisible() else self.map).setFocus()
        page, why = self._refusal()
        if why:
            self.bring_forward(page)
            self.protocol.show_refused()
            self.say(ErrorMessage("not started: {}".format(why)))
        return not why

    def _refusal(self):
        """Return the page with what is refused, and why it is; two empty texts where nothing is."""
        why = self.protocol.finish()
        if why:
            return "Protocol", "a parameter is refused: {}".format(why)
        if self.bar.duration.why:
            return "", self.bar.duration.why
        why = self.team.take_refusal()
        if why:
            return "Team", OLD_POSE.format(why)
        if not self.study.state.real():  # which are where they are
            why = self.study.edited.no_start()
        return ("Team", why) if why else ("", self._refused)

    def _on_refused(self, why):
        self._refused = why

    def _on_start_anyway(self):
        self.close_error()  # that of the check which held the start
        self.say(self.study.control.start_anyway())
        self._show_begun()

    def _show_begun(self):
        if self.study.preflight.running:
            self.preflight.set_running(self.study.preflight.starting)
            self.results_tabs.setCurrentWidget(self.preflight)
        self._show_possible()  # a click on Stop may follow before the next tick

    def _on_emergency(self, on):
        self.connection.set_emergency(on)
        self.study.preflight.cancel()
        self.status_line.show_alarm()

    def _on_speed(self, speed):
        self.say(self.study.stage.set_speed(speed))

    # Timers --------------------------------------------------------------------------------------

    def _on_frame(self):
        self.replay.show_frame()
        self.opened.show_frame()
        self.live.show_frame()
        self.what_if.show_frame()
        self.comparison_control.show_frame()

    @guarded
    def tick(self):
        """Take what was received and what has ended, and show it."""
        self.live.take_samples()
        for name, success, answer in self.connection.take_results():
            self._on_result(name, success, answer)
        for text in self.study.ended_processes():
            self.say(text)
        self.whole.follow()
        self.program_control.follow()
        for text in self._errors.take():
            self.say(ErrorMessage(text))
        self.results.show_progress()
        self.live.show_prediction()
        self.course.follow()
        self.edge_lens.follow()
        self.say(self.pending_team.send())
        if self.study.state.is_emergency():
            self.study.preflight.cancel()
        self.live.follow_control()
        self.sensing.show()
        for part in (self.opened, self.past, self.comparison_control, self.shelf_control):
            part.follow()
        self.sweep_control.follow()
        self.search_control.follow()
        self.status_line.show()
        self.edits.keep()

    def _on_result(self, name, success, answer):
        """Handle the ``answer`` to the request ``name``."""
        if name == "set_topology":
            self.pending_graph.answered(success)
        if name == "set_team":
            self.pending_team.answered(success)
        self.whole.answered(name, success)
        if name == KEEP and self.what_if.kept(success, answer):
            self.shelf_control.look()
            return
        if name in ("save", "keep", JUDGE):
            self.shelf_control.look()
        if name == JUDGE:
            self.opened.judged(success, answer)
            return
        if name == "save" and self.results.ended(success, answer):
            self.shelf_control.add(answer)
            return
        self.say(answer if name == "keep" else self.study.take_result(name, success, answer))
        if name == "preflight":
            check = self.study.preflight
            shown = check.findings, check.passed, check.outcome, check.may_judge()
            self.preflight.set_findings(*shown)

    def showEvent(self, event):
        """Take the keys from the start, without a first click."""
        super().showEvent(event)
        self.bar.bind_keys(self.window())
        if QApplication.focusWidget() is None:
            self.map.setFocus()

    # The end -------------------------------------------------------------------------------------

    def close_study(self):
        """Stop the timers, of the panels too, end what was started here, withdraw from ROS."""
        for timer in self.findChildren(QTimer):
            timer.stop()
        for part in (self.trial, self.edge_lens, self.course, self.what_if, self.results):
            part.close()
        for part in (self.replay, self.opened, self.comparison_control):
            part.end()
        self.shelf_control.close()
        self.sweep_control.close()
        self.files.keep_unsaved()
        self.edits.forget()
        self._errors.close()
        self.bar.release_keys()
        self.study.close()
        self.connection.close()

    def save_settings(self):
        """Return what survives a restart, texts by name."""
        programs = self.program_control.programs.kept()
        return dict(saved_layout(self), scenario=self.files.text(), programs=programs)

    def restore_settings(self, settings):
        """Restore what ``save_settings`` returned; invalid parts are left out."""
        try:
            if settings.get("scenario"):
                self.editing.take(scenario_from_yaml(str(settings["scenario"]), "last scenario"))
        except Exception as error:  # its protocol may raise anything
            self.say(ErrorMessage("the last scenario was not restored: {}".format(reason(error))))
        restore_layout(self, settings)
        self.program_control.programs.take_up(settings.get("programs"))
