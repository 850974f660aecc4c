"""The whole GUI as one widget: team, protocol, topology, map, curves, verdict, and the run."""

import html
import json
import math
import os
import time

from python_qt_binding.QtCore import QEventLoop, QSize, Qt, QTimer
from python_qt_binding.QtWidgets import (
    QApplication,
    QFrame,
    QLabel,
    QScrollArea,
    QSizePolicy,
    QSplitter,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from mrs_simulator.control.laws import HOMES
from mrs_simulator.core.scenario import Scenario, load_scenario, scenario_from_yaml
from mrs_simulator.rqt_plugin.curves.panel import CurvesPanel
from mrs_simulator.rqt_plugin.map.panel import MapPanel
from mrs_simulator.rqt_plugin.protocol.panel import ProtocolPanel
from mrs_simulator.rqt_plugin.run.autosave import told as time_of
from mrs_simulator.rqt_plugin.run.bar import RunBar
from mrs_simulator.rqt_plugin.run.history import History
from mrs_simulator.rqt_plugin.run.preflight_panel import PreflightPanel
from mrs_simulator.rqt_plugin.run.study_run import StudyRun
from mrs_simulator.rqt_plugin.run.trouble import Trouble, reason
from mrs_simulator.rqt_plugin.team.panel import TeamPanel
from mrs_simulator.rqt_plugin.team.topology_panel import TopologyPanel
from mrs_simulator.rqt_plugin.verdict.panel import VerdictPanel
from mrs_simulator.rqt_plugin.view.panel import ViewPanel
from mrs_simulator.rqt_plugin.widgets.banners import Banners
from mrs_simulator.rqt_plugin.widgets.file_dialog import FileDialog
from mrs_simulator.rqt_plugin.widgets.flow_layout import FlowLayout
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.messages import Faults, MessageList
from mrs_simulator.study.law_answers import Prediction
from mrs_simulator.study.report import from_anywhere

SIZE = (1180, 720)  # [px] that shows everything
FRAME = 33  # [ms] of wall time between two pictures of the map
MOST_PAINTING = 0.35  # of the time that the map may take; beyond, it is painted less often
TICK = 100  # [ms] between two looks at everything else
GRAPH_REST = (
    5.0  # [s] after the controller's answer, beyond which its graph is shown whatever it is
)
SCENARIOS = "Scenarios (*.yaml *.yml)"
SHORTEST_KEPT = 2.0  # [s] of commands, of a run that is kept though nobody has saved it
LATCHED = (
    "EMERGENCY STOP: every controller is stopped and none can start. To release it, press RELEASE STOP; "
    "then press Start controller for the robots to move again."
)
TEAM_REST = 0.4  # [s] after the last change of the team until the stage is asked for it


class StudyWidget(QWidget):
    """Everything a coordination study needs; ``close_study`` ends what was started here."""

    def __init__(self, connection, processes, scenario, autosave=None, parent=None):
        """``connection``: ``RosConnection``; ``scenario``: what to begin with; ``autosave``, if any."""
        super().__init__(parent)
        self.setObjectName("MrsSimulator")
        self.setWindowTitle("Multi-robot simulator")
        self.connection = connection
        self.study = StudyRun(connection, processes, scenario)
        self.history = History()
        self.history.before_clearing = guarded(self._keep_unsaved)
        self._autosave, self._kept_text, self._kept = autosave, None, scenario
        self._orphans = autosave.orphans() if autosave else []
        self._faults = Faults()
        self._saving_since, self._predicted_from = None, None
        self._closed, self._given_up = False, False
        self._directory = os.getcwd()  # where files are opened
        self.study.laws.waiting = self._while_law_is_tried
        self.study.laws.waited = self._after_law_was_tried
        self._graph_wanted, self._graph_changed_at = None, 0.0  # (edges, directed) asked for
        self._team_changed_at, self._last_control, self._last_image = None, None, None
        self._told_trouble = ""  # by the controller
        self._awaits_team = False  # whether the stage has not answered yet
        self._last_frame = 0.0, None  # when the map last got a snapshot, and which
        self._build()
        self.show_scenario(scenario)
        self._offer_orphan()
        self._start_timer(FRAME, self._on_frame)
        self._start_timer(TICK, self._on_tick)
        self._on_tick()

    def sizeHint(self):
        """Return the size that a dock of rqt, or a window, begins with."""
        return QSize(*SIZE)

    def _start_timer(self, period, slot):
        timer = QTimer(self)
        timer.timeout.connect(slot)
        timer.start(period)

    # Building ------------------------------------------------------------------------------------

    def _build(self):
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.setSpacing(4)
        self.bar = RunBar(self)
        self.bar.asked.connect(self._on_asked)
        self.bar.speed_chosen.connect(self._on_speed)
        self.bar.emergency.connect(self._on_emergency)
        layout.addWidget(self.bar)
        self.banners = Banners()
        layout.addWidget(self.banners)
        self._right = QSplitter(Qt.Vertical)
        self._right.addWidget(self._build_map())
        self._right.addWidget(self._build_results())
        self._right.setStretchFactor(0, 3)
        self._right.setStretchFactor(1, 2)
        self._right.setSizes([400, 290])
        self._across = QSplitter(Qt.Horizontal)
        self._across.addWidget(self._build_settings())
        self._across.addWidget(self._right)
        self._across.setStretchFactor(1, 1)
        layout.addWidget(self._across, 1)
        layout.addLayout(self._build_status())

    def _build_settings(self):
        self.team, self.protocol, self.topology = TeamPanel(), ProtocolPanel(), TopologyPanel()
        self.team.team_changed.connect(self._on_team)
        self.team.arranged.connect(guarded(lambda *_: self.map.fit()))
        self.team.open_requested.connect(self._on_open)
        self.team.save_requested.connect(self._on_save_scenario)
        self.protocol.set_protocols(sorted(HOMES))
        self.protocol.protocol_chosen.connect(self._on_protocol)
        self.protocol.parameters_changed.connect(self._on_parameters)
        self.protocol.file_requested.connect(self._on_protocol_file)
        self.topology.topology_changed.connect(self._on_topology)
        tabs = QTabWidget()
        for widget, title in (
            (self.team, "Team"),
            (self.protocol, "Protocol"),
            (self.topology, "Topology"),
        ):
            tabs.addTab(_scrolled(widget), title)
        self.settings_tabs = tabs
        return tabs

    def _build_map(self):
        panel = MapPanel()
        self.map, self.modes, self.shown = panel.map, panel.modes, panel.shown
        self.map.pose_edited.connect(self._on_pose)
        self.map.edge_added.connect(self._on_edge_added)
        self.map.edge_removed.connect(self._on_edge_removed)
        self._map_panel = panel
        return panel

    def _build_results(self):
        self.curves = CurvesPanel()
        self.curves.set_history(self.history)
        self.view = ViewPanel()
        self.view.switched.connect(self._on_view)
        self.view.look_changed.connect(self._on_look)
        self.preflight, self.verdict = PreflightPanel(), VerdictPanel()
        self.preflight.start_asked.connect(self._on_start_anyway)
        self.messages = MessageList()
        self.messages.unseen_changed.connect(self._on_unseen)
        tabs = QTabWidget()
        for widget, title in (
            (self.curves, "Curves"),
            (self.view, "3D view"),
            (self.preflight, "Preflight"),
            (self.verdict, "Verdict"),
            (self.messages, "Messages"),
        ):
            tabs.addTab(widget, title)
        self.results_tabs = tabs
        return tabs

    def _build_status(self):
        row = FlowLayout()
        row.setSpacing(16)
        self.status = {}
        for name in ("master", "stage", "controller", "robots", "time"):
            label = QLabel()
            label.setTextFormat(Qt.RichText)
            # However long the trouble is, the window stays as wide as it is.
            label.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)
            self.status[name] = label
            row.addWidget(label)
        return row

    # The scenario --------------------------------------------------------------------------------

    @property
    def scenario(self) -> Scenario:
        """Return the scenario as edited so far."""
        return self.study.scenario

    def show_scenario(self, scenario):
        """Take in ``scenario``: team, protocol, parameters, topology, obstacles.

        Whatever its protocol raises is raised, and the old scenario stays.
        """
        self.study.take(scenario)
        self._show_scenario()

    def _show_scenario(self):
        """Show the scenario in force."""
        self._show_team()
        self.map.show_obstacles(self.scenario.obstacles)
        self.map.fit()
        self.bar.set_speed(self.scenario.speed)
        self._show_protocol()

    def _show_team(self):
        """Show the team in force."""
        self.team.set_team(self.scenario.poses, self.scenario.kinds)
        self.map.show_team(self.scenario.poses)
        self._show_kinds()
        self._show_robots_to_follow()

    def _show_kinds(self):
        team = self.study.team()
        self.map.show_kinds(team.kinds)
        self.curves.set_axes(team.axes)

    def _show_robots_to_follow(self):
        self.view.set_team(range(1, self.scenario.n + 1), self.scenario.poses[:, :2])

    def _show_protocol(self):
        """Show the protocol in force, its parameters and its graph."""
        self.protocol.set_protocol(self.scenario.control.protocol)
        self.protocol.set_parameters(self.study.derived.parameters, self.study.derived.values)
        self._show_derived()

    def _show_derived(self):
        derived = self.study.derived
        self.banners.clear("error")  # an edit was taken up
        self.connection.set_starts(self.study.starts())
        self.protocol.set_warnings(derived.warnings)
        topology = derived.topology
        self.topology.set_team(self.scenario.poses[:, :2])
        self.topology.set_settling("...")
        self.topology.set_topology(topology.edges, topology.directed)
        self.map.show_topology(topology.edges, topology.directed)
        if not self.connection.is_fresh("control"):  # which says where it wants them
            self.map.show_targets(None if self.connection.is_fresh("state") else derived.targets)
        self.curves.set_error(self.study.error_function(), background=self.study.is_users_law)
        self.curves.set_prediction(None, None)  # that of what was

    def load(self, path):
        """Open the scenario file at ``path``; what is wrong with it is said, the old one stays."""
        try:
            self.show_scenario(load_scenario(path))
        except Exception as error:  # its protocol may raise anything
            self.say(Trouble("not opened: {}".format(reason(error))))
            return
        self._begin_anew()
        self._kept_text = self._text()
        self.say("opened {}".format(path))
        self.say(self.study.follow_protocol())
        self.say(self.study.what_the_stage_keeps())
        self._team_changed_at = time.monotonic()

    def _ask_file(self, title, start, kinds, chosen, saves=False):
        """Open a dialog in place of one that is open; ``chosen`` is called with the path."""
        for dialog in self.findChildren(FileDialog):
            dialog.close()
        # Where the GUI was started, or where the last file was: not where Qt has been last.
        start = os.path.join(self._directory, start)

        def taken(path):
            self._directory = os.path.dirname(path)
            chosen(path)

        FileDialog(self, title, start, kinds, taken, saves)

    @guarded
    def _on_open(self):
        self._ask_file("Open scenario", "", SCENARIOS, self._open_chosen)

    def _open_chosen(self, path):
        if self.study.is_controlled():  # since the dialog was opened
            self.say(Trouble("not opened: stop the controller to open another scenario"))
        else:
            self.load(path)

    @guarded
    def _on_save_scenario(self):
        self._ask_file("Save scenario", "scenario.yaml", SCENARIOS, self.save_scenario, saves=True)

    def save_scenario(self, path):
        """Write the scenario as edited so far to the file at ``path``."""
        try:
            with open(path, "w", encoding="utf-8") as file:
                file.write(from_anywhere(self.scenario).to_yaml())
        except OSError as error:
            self.say(Trouble("not saved: {}".format(error)))
            return
        self._kept_text = self._text()
        self.say("saved {}".format(path))

    @guarded
    def _on_protocol_file(self, directory):
        kinds = "Python files (*.py)"
        self._ask_file("Open a protocol", directory, kinds, self.protocol.take_file)

    @guarded
    def _on_team(self):
        self._change_team()
        self.map.show_team(self.scenario.poses)
        self._show_kinds()

    @guarded
    def _on_pose(self, number, x, y, theta):
        self.team.set_pose(number, x, y, theta)
        self._change_team()

    def _change_team(self):
        if self.say(self.study.set_team(self.team.poses(), self.team.kinds())):
            self._show_team()
            return
        self._team_changed_at = time.monotonic()
        self._begin_anew()
        self._show_robots_to_follow()
        self._show_derived()

    def _begin_anew(self):
        """Put away what is shown of a run: the team beside it is another one now."""
        self.verdict.clear()
        if not self.connection.is_fresh("state"):  # else the stage begins a run with the new team
            self.connection.forget("state")
            self.history.clear()
            self.map.clear_trails()

    @guarded
    def _on_protocol(self, name):
        if self.say(self.study.set_protocol(name)):
            self.protocol.set_protocol(self.scenario.control.protocol)
            return
        self.say(self.study.follow_protocol())
        self._show_protocol()

    @guarded
    def _on_parameters(self, values):
        if self.say(self.study.set_parameters(values)):
            self._show_protocol()
        else:
            self._show_derived()

    @guarded
    def _on_topology(self, edges, directed):
        refused = self.say(self.study.set_topology(edges, directed))
        if not refused and self.study.state.has_control():
            self._graph_wanted, self._graph_changed_at = (sorted(edges), directed), math.inf
        self._show_protocol()

    @guarded
    def _on_edge_added(self, i, j):
        self.topology.add_edge(i, j)

    @guarded
    def _on_edge_removed(self, i, j):
        self.topology.remove_edge(i, j)

    # The run -------------------------------------------------------------------------------------

    @guarded
    def _on_asked(self, name):
        if name == "save":
            self._on_save()
            return
        before = self.scenario
        self.say(self.study.do(name, self.bar.speed()))
        if self.scenario is not before:  # that of a stage that was started elsewhere
            self._show_scenario()
        self._show_checking()

    @guarded
    def _on_start_anyway(self):
        self.say(self.study.start_anyway())
        self._show_checking()

    def _show_checking(self):
        if self.study.preflight.running:
            self.preflight.set_running(self.study.preflight.starting)
            self.results_tabs.setCurrentWidget(self.preflight)

    @guarded
    def _on_emergency(self, on):
        self.connection.set_emergency(on)
        self.study.preflight.cancel()
        self._show_alarm()

    @guarded
    def _on_speed(self, speed):
        self.say(self.study.set_speed(speed))

    def _on_save(self):
        if not self._nothing_to_save():
            suggested = os.path.join(self.study.results_directory(), self.study.suggested_name())
            title = "Save results to a new directory"
            self._ask_file(title, suggested, "", self.save_results, saves=True)

    def save_results(self, directory):
        """Save data, figures (PNG, PDF, SVG), verdict and scenario of the run to ``directory``."""
        if not self._nothing_to_save():
            self.say("saving to {}".format(directory))
            self.history.saved = self.history.moved
            self._saving_since = time.monotonic()
            self.study.save(self.history, directory)
            self._show_saving()

    def _show_saving(self):
        """Tell how far the saving has come."""
        if self._saving_since is None:
            self.banners.clear("saving")
            return
        text = "Saving: {}, {:.0f} s".format(
            self.study.saving, time.monotonic() - self._saving_since
        )
        self.banners.tell("saving", "aside", text, ("Cancel", self.study.cancel_save))

    def _nothing_to_save(self):
        if self._saving_since is not None:
            return self.say(Trouble("not saved: the last results are still being saved"))
        nothing = Trouble("nothing to save: no robot has been heard")
        return not len(self.history.time) and self.say(nothing)

    def _keep_unsaved(self):
        """Keep the data of a run that nobody has saved, before it is forgotten."""
        if self.history.is_unsaved(SHORTEST_KEPT):
            self.say(self.study.keep(self.history))

    @guarded
    def _on_view(self, on):
        self.study.show_camera(on)
        self._on_look()

    @guarded
    def _on_look(self):
        view, picture = self.view, self.view.picture
        self.connection.look(
            x=view.x,
            y=view.y,
            distance=view.distance,
            yaw=view.yaw,
            pitch=view.pitch,
            follow=view.follow(),
            width=max(64, picture.width()),
            height=max(64, picture.height()),
        )

    def say(self, text):
        """Show ``text`` among the messages, a ``Trouble`` in the bar too; return whether there was any."""
        if text:
            trouble = isinstance(text, Trouble)
            self.messages.add(text, trouble)
            if trouble:
                buttons = ("Messages", self._show_messages), ("Close", self._close_error)
                self.banners.tell("error", "error", text, *buttons)
        return bool(text)

    def _show_messages(self):
        self.results_tabs.setCurrentWidget(self.messages)

    def _close_error(self):
        self.banners.clear("error")

    @guarded
    def _on_unseen(self, count):
        title = "Messages ({})".format(count) if count else "Messages"
        self.results_tabs.setTabText(self.results_tabs.indexOf(self.messages), title)

    # A law that is being tried, and edits that are kept ------------------------------------------

    def _while_law_is_tried(self, seconds):
        """Keep the window alive; nothing but the emergency stop and giving up works meanwhile."""
        if self._across.isEnabled():
            self._across.setEnabled(False)
            self._given_up = False
            self._show_possible()
        text = "Trying the protocol: {:.0f} of at most {:g} s".format(
            seconds, self.study.laws.limit
        )
        self.banners.tell("law", "aside", text, ("Give up", self._give_up))
        QApplication.processEvents(QEventLoop.AllEvents, 20)
        if self._given_up or self._closed:
            raise ValueError("given up after {:.0f} s".format(seconds))

    def _give_up(self):
        self._given_up = True

    def _after_law_was_tried(self):
        self.banners.clear("law")
        self._across.setEnabled(True)

    def _text(self):
        return from_anywhere(self.scenario).to_yaml()

    def _keep_edits(self):
        """Keep the scenario where a crash leaves it, if it is neither a file's nor the first one."""
        if self._autosave is None or self.scenario is self._kept:
            return
        self._kept, text = self.scenario, self._text()
        try:
            if text == self._kept_text:
                self._autosave.forget()
            else:
                self._autosave.keep(text)
        except OSError as error:
            self._autosave = None
            self.say(Trouble("edits are not kept for the case of a crash: {}".format(error)))

    def _offer_orphan(self):
        """Offer edits that a GUI which ended without a word has left, the newest first."""
        if not self._orphans:
            self.banners.clear("edits")
            return
        text = "The GUI ended unexpectedly; edits of {} were not saved.".format(
            time_of(self._orphans[0])
        )
        buttons = ("Restore", self._restore_orphan), ("Discard", self._discard_orphan)
        self.banners.tell("edits", "warning", text, *buttons)

    def _restore_orphan(self):
        orphan = self._orphans.pop(0)
        try:
            self.show_scenario(scenario_from_yaml(orphan.text, "edits"))
        except Exception as error:  # its protocol may raise anything
            self.say(Trouble("not restored, still in {}: {}".format(orphan.path, reason(error))))
        else:
            self._begin_anew()
            self._team_changed_at = time.monotonic()
            self._keep_edits()
            self._autosave.discard(orphan)
        self._offer_orphan()

    def _discard_orphan(self):
        self._autosave.discard(self._orphans.pop(0))
        self._offer_orphan()

    # Timers --------------------------------------------------------------------------------------

    @guarded
    def _on_frame(self):
        snapshot, now = self.connection.snapshot(), time.monotonic()
        rested = now - self._last_frame[0] >= self.map.cost / MOST_PAINTING
        # Robots placed by hand are not where the stage has them until it has taken them over.
        settled = not self._team_changed_at and not self._awaits_team
        if settled and rested and snapshot is not None and snapshot is not self._last_frame[1]:
            self._last_frame = now, snapshot
            self.map.show_snapshot(snapshot)
        for collision in self.connection.take_collisions():
            self.history.collisions.append(collision)
            self.map.flash_collision(collision.x, collision.y)
        image = self.connection.newest("image")
        if image is not self._last_image and self.view.isVisible():
            self._last_image = image
            self.view.show_image(image.width, image.height, image.data)

    @guarded
    def _on_tick(self):
        for snapshot in self.connection.take_samples():
            if snapshot is None:  # a run begins
                self.history.clear()
                self.study.missed.begin()
                self.map.clear_trails()
            else:
                self.history.append(snapshot)
        self._predict_from_start()
        for name, success, message in self.connection.take_results():
            self._on_result(name, success, message)
        for text in self.study.ended_processes():
            self.say(text)
        for text in self._faults.take():
            self.say(Trouble(text))
        self._show_saving()
        self._follow_prediction()
        if self._team_changed_at and time.monotonic() - self._team_changed_at > TEAM_REST:
            self._team_changed_at = None
            if self.connection.is_fresh("state"):
                self._awaits_team = not self.study.is_controlled()
                self.say(self.study.send_team())
        if self.study.state.is_emergency():
            self.study.preflight.cancel()
        self._follow_control()
        self._show_status()

    def _predict_from_start(self):
        """Let theory begin where the robots of a run that has begun really stood."""
        begun = self.history.begun
        if begun is not None and begun != self._predicted_from:
            self.study.predict_from(self.history.pose[self.history.first_row()])
        self._predicted_from = begun

    def _follow_prediction(self):
        """Show theory's error and settling time once they are there."""
        found = self.study.take_prediction()
        if found is None:
            return
        when, predicted, settling = found[0] or Prediction(None, None, "")
        self.topology.set_settling(settling)
        if found[1] is None:
            self.curves.set_prediction(when, predicted)
        else:
            self.say(Trouble("no prediction: {}".format(reason(found[1]))))

    def _on_result(self, name, success, answer):
        if name == "set_topology":
            self._graph_changed_at = time.monotonic() if success else -math.inf
        if name == "set_team":
            self._awaits_team = False
        if name == "save":
            self._saving_since = None
            if success:
                self._show_verdict(answer)
                return
            self.history.saved = -math.inf  # it is not, or not wholly
        self.say(self.study.take_result(name, success, answer))
        if name == "preflight":
            check = self.study.preflight
            self.preflight.set_findings(
                check.findings, check.passed, check.outcome, check.may_judge()
            )

    def _show_verdict(self, path):
        with open(path, encoding="utf-8") as file:
            self.verdict.set_verdict(json.load(file))
        self.results_tabs.setCurrentWidget(self.verdict)
        self.say("saved to {}".format(os.path.dirname(path)))

    def _follow_control(self):
        """Show what the running controller says of its places and its graph."""
        control = self.connection.newest("control")
        if not self.connection.is_fresh("control"):
            if self._last_control is not None and self.connection.is_fresh("state"):
                self.map.show_targets(None)  # nobody wants them there any more
                self._last_control = None
            return
        if control is self._last_control:
            return
        self._last_control = control
        self._tell_trouble(control)
        self.map.show_targets(control.targets if len(control.targets) else None)
        self._follow_graph(control)

    def _follow_graph(self, control):
        """Show the controller's graph; what it said before it took in the one drawn here is old."""
        edges = list(control.edges)
        if self._graph_wanted is not None:
            taken_in = (sorted(edges), control.directed) == self._graph_wanted
            if not taken_in and time.monotonic() < self._graph_changed_at + GRAPH_REST:
                return
            self._graph_wanted = None
        self.map.show_topology(edges, control.directed)
        if len(control.command) == self.scenario.n:  # the panel edits the scenario's graph
            self.topology.set_topology(edges, control.directed)

    def _tell_trouble(self, control):
        """Say once why a controller, here or elsewhere, stopped all robots or some of them."""
        if control.trouble != self._told_trouble and (not control.running or control.stopped):
            self.say(control.trouble and Trouble("controller: {}".format(control.trouble)))
        self._told_trouble = control.trouble

    def _show_status(self):
        for name, (good, text) in self.study.state.lines().items():
            colour = {True: "#2e8b57", False: "#c00000", None: "#888888"}[good]
            self.status[name].setText(
                "<span style='color:{}'>\u25cf</span> {}".format(colour, html.escape(text))
            )
            self.status[name].setToolTip(text)
            self.status[name].setVisible(bool(text))
        stage = self.connection.newest("stage")
        self.bar.set_paused(stage is not None and stage.paused)
        self.bar.set_recording(self.study.processes.is_running("rosbag"))
        if self.connection.newest("emergency") is not None:
            self.bar.set_emergency(self.study.state.is_emergency())
        self._show_possible()

        self._show_alarm()
        self._show_alerts()
        self._keep_edits()

    def _show_alarm(self):
        """Say across the window that the emergency stop is latched, and how it is released."""
        self.bar.listen_in(self.window())
        if self.bar.is_emergency():
            self.banners.tell("emergency", "alarm", LATCHED)
        else:
            self.banners.clear("emergency")

    def _show_alerts(self):
        """Say across the window what is wrong with the controller, or with the timing."""
        hangs = self.study.state.hangs()
        if hangs and self.study.processes.is_running("control"):
            text = "The controller {}: its law hangs, or takes too long.".format(hangs)
            kill = "Kill controller", lambda: self.say(self.study.do("kill"))
            self.banners.tell("hangs", "error", text, kill)
        elif hangs:
            text = "The controller {}. It was started elsewhere: end it there.".format(hangs)
            self.banners.tell("hangs", "error", text)
        else:
            self.banners.clear("hangs")
        degraded = self.study.note_timing()
        if degraded:
            text = "{}. This run is not judged; choose a slower speed, or begin at it.".format(
                degraded[0].upper() + degraded[1:]
            )
            self.banners.tell("timing", "warning", text)
        else:
            self.banners.clear("timing")

    @guarded
    def showEvent(self, event):
        """Take the keys from the start, not only once somebody has clicked here."""
        super().showEvent(event)
        self.bar.listen_in(self.window())
        if QApplication.focusWidget() is None:
            self.map.setFocus()

    def _show_possible(self):
        """Offer what can be done now, and say why the rest cannot."""
        actions = self.study.state.actions()
        if len(self.history.time) and self._saving_since is None:
            actions["save"] = True, ""
        if not self._across.isEnabled():
            actions = dict.fromkeys(actions, (False, "a protocol is being tried"))
        self.view.set_possible(*actions.pop("view"))
        for name, (possible, remark) in actions.items():
            self.bar.set_enabled(name, possible, remark)
        why, alone = self.study.state.team_locked(), self.study.state.real_alone()
        self.team.set_editable(not why, why, may_open=alone and not self.study.is_controlled())
        self.team.set_real(self.study.state.real())
        why = self.study.state.poses_locked(self.scenario.n)
        self._map_panel.set_poses_editable(not why, why)

    # The end -------------------------------------------------------------------------------------

    def close_study(self):
        """Stop the timers, of the panels too, end what was started here, withdraw from ROS."""
        for timer in self.findChildren(QTimer):
            timer.stop()
        self._closed = True
        self._keep_unsaved()
        if self._autosave is not None:
            self._autosave.forget()
        self._faults.close()
        self.bar.forget_key()
        self.study.close()
        self.connection.close()

    def save_settings(self):
        """Return what is to survive a restart, as texts by name."""
        return {
            "scenario": from_anywhere(self.scenario).to_yaml(),
            "across": " ".join(map(str, self._across.sizes())),
            "down": " ".join(map(str, self._right.sizes())),
            "shown": " ".join(name for name, button in self.shown.items() if button.isChecked()),
        }

    def restore_settings(self, settings):
        """Take in what ``save_settings`` returned; anything that is not right is left out."""
        try:
            if settings.get("scenario"):
                self.show_scenario(scenario_from_yaml(str(settings["scenario"]), "last scenario"))
        except Exception as error:  # its protocol may raise anything
            self.say(Trouble("the last scenario is not taken up: {}".format(reason(error))))
        for key, splitter in (("across", self._across), ("down", self._right)):
            sizes = str(settings.get(key, "")).split()
            if len(sizes) == 2 and all(s.isdigit() and 20 <= int(s) <= 10000 for s in sizes):
                splitter.setSizes([int(s) for s in sizes])
        if settings.get("shown") is not None:
            wanted = str(settings["shown"]).split()
            for name, button in self.shown.items():
                button.setChecked(name in wanted)


def _scrolled(widget):
    """Return ``widget`` in an area that scrolls where there is less room than it needs."""
    area = QScrollArea()
    area.setWidgetResizable(True)
    area.setFrameShape(QFrame.NoFrame)
    area.setWidget(widget)
    return area
