"""A study's run: the edited scenario, the programs started for it, and its saved results; without Qt."""

import os
import re
import shutil
import threading
import time

import numpy as np

from mrs_simulator.control.laws import HOMES
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.missed_periods import MissedPeriods
from mrs_simulator.core.parameters import checked_values
from mrs_simulator.core.recording import write_facts
from mrs_simulator.core.scenario import scenario_from_dict, scenario_from_yaml
from mrs_simulator.rqt_plugin.ros_side.preflight_run import Finding, PreflightRun, who_is_real
from mrs_simulator.rqt_plugin.run.study_state import StudyState, named
from mrs_simulator.rqt_plugin.run.trouble import Trouble, reason
from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker
from mrs_simulator.study.law_process import LawProcess
from mrs_simulator.study.report import VERDICT_FILE, begin_run, write_scenario
from mrs_simulator.vehicles import KINDS, Team
from mrs_simulator.vehicles.team import on_axes

CANCELLED = "cancelled; what was written is in {}"
REPORT_LIMIT = 300.0  # [s] of wall time for figures and verdict
RECORDED = "/clock|/tf|/tf_static|/stage/.*|/pioneer_control/status|/robot[0-9]+/.*"
# What a stage has from its start.
OF_THE_STAGE = ("fidelity", "odometry", "limits", "obstacles", "step", "cmd_vel_timeout")
SAME_PLACE = 1e-3  # [m, rad] within which a robot starts where the scenario has it
KEPT = "unsaved"  # the directory of runs that were not saved when another one began
MOST_KEPT = 20  # [-] of them
PREDICTION_REST = 0.25  # [s] after the last edit until theory's error is computed


class StudyRun:
    """The scenario under the user's hands, and the programs that run it."""

    def __init__(self, connection, processes, scenario):
        self.connection, self.processes, self.scenario = connection, processes, scenario
        self.derived = None  # law_answers.Facts of the scenario, since it was taken up
        # A user's law runs in neither thread of the GUI: one process for edits, which somebody waits
        # for, one for what takes longer.
        self.laws, self._background = LawProcess(), LawProcess()
        self._prediction = DebouncedWorker(PREDICTION_REST)
        self.take_prediction = self._prediction.take
        self.preflight = PreflightRun(connection, processes)
        self.state = StudyState(connection, processes, self.preflight)
        self.is_controlled = self.state.is_controlled
        self.missed = MissedPeriods()
        self.saving, self._cancelled = "", threading.Event()  # what a save is at
        self._speed = None  # at which a stage is about to start
        self._lockstep = False  # whether the stage that was started here waits for commands
        self._swapped = None  # [what /use_sim_time was before a stage was started here]

    # The scenario --------------------------------------------------------------------------------

    def take(self, scenario):
        """Take up ``scenario``; whatever its protocol raises is raised, and the old one stays."""
        self.derived = self.laws.ask("facts", scenario)
        self.scenario = scenario
        self.predict(scenario)

    def predict(self, scenario):
        """Compute the prediction for ``scenario`` in the background, for ``take_prediction``."""
        self._prediction.ask(lambda: self._background.ask("prediction", scenario))

    def predict_from(self, poses):
        """Predict the run that has begun at ``poses`` (n, 3), if these are not the scenario's own."""
        known = len(poses) == self.scenario.n and np.isfinite(poses).all()
        if known and not np.allclose(poses, self.scenario.poses, atol=SAME_PLACE):
            self.predict(self.scenario._replace(poses=poses.copy()))

    def _try(self, scenario):
        """Take up ``scenario``; return what is wrong with it, or ""."""
        try:
            self.take(scenario)
        except Exception as error:  # a file of one's own may raise anything
            return Trouble("not taken up: {}".format(reason(error)))
        return ""

    def set_team(self, poses, kinds):
        """Take in a team; edges of robots that are gone go with them.  Return what is wrong, or ""."""
        topology = self.scenario.topology
        if topology is not None and topology.n != len(poses):
            edges = [edge for edge in topology.edges if max(edge[:2]) <= len(poses)]
            topology = Topology(len(poses), edges, topology.directed)
        return self._try(self.scenario._replace(poses=poses, kinds=tuple(kinds), topology=topology))

    def team(self):
        """Return the ``Team`` of the scenario's robots."""
        return Team.from_scenario(self.scenario)

    def set_protocol(self, name):
        """Take another protocol with its defaults; return what is wrong with it, or ""."""
        scenario = self.scenario.with_protocol(name)
        if scenario.topology is None:
            scenario = scenario._replace(topology=Topology.preset("cycle", scenario.n))
        return self._try(scenario)

    def set_parameters(self, values):
        """Take other values; a controller that is there gets them at once.  Return what is wrong, or ""."""
        try:
            checked = checked_values(self.derived.parameters, values, self.derived.protocol)
        except ValueError as error:
            return Trouble(error)
        control = self.scenario.control._replace(parameters=checked)
        wrong = self._try(self.scenario._replace(control=control))
        if not wrong and self.state.has_control():
            self.connection.set_parameters(checked)
        return wrong

    def set_topology(self, edges, directed):
        """Take another graph; a controller that is there gets it at once.  Return what is wrong, or ""."""
        topology = Topology(self.scenario.n, edges, directed)
        try:
            parameters = self.laws.ask("parameters_with", self.scenario, topology)
        except Exception as error:  # a file of one's own may raise anything
            return Trouble("not taken up: {}".format(reason(error)))
        changed = self.scenario.control._replace(parameters=parameters)
        wrong = self._try(self.scenario._replace(topology=topology, control=changed))
        if not wrong and self.state.has_control():
            self.connection.set_topology(edges, directed)
        return wrong

    def starts(self):
        """Return where the robots' odometry is zero in the common frame, (n, 3), None: at its origin."""
        return self.scenario.poses if self.scenario.odometry == "wheel" else None

    @property
    def is_users_law(self):
        """Return whether the protocol is not a shipped one."""
        return self.scenario.control.protocol not in HOMES

    def error_function(self):
        """Return a function of poses (m, n, 3) that gives the largest target error (m,), or None.

        That of a user's law may take long, and is for a thread of its own.
        """
        if self.derived.targets is None:
            return None
        scenario = self.scenario
        return lambda pose: self._background.ask("errors", scenario, pose)

    # The run -------------------------------------------------------------------------------------

    def do(self, name, speed=1.0):
        """Do what the button called ``name`` says; return a message, or ""."""
        try:
            return getattr(self, "_do_" + name)(speed)
        except OSError as error:  # a full disk, a directory that may not be written
            return Trouble("{}: {}".format(name, error))

    def _do_simulate(self, speed):
        if self.connection.is_fresh("stage"):
            return self._attach()
        try:
            scenario_from_dict(self.scenario.to_dict(), "scenario")
        except ValueError as error:
            return Trouble(error)
        if self._speed is None:
            self.connection.begin_simulated_time()  # then take_result starts the stage
        self._speed = speed
        return ""

    def _attach(self):
        """Take up the scenario of the stage that runs; its law only if that is a shipped one."""
        attached = "attached to the stage that runs"
        if self.processes.is_running("control"):  # for that scenario, and perhaps another law
            return attached
        try:
            runs = self._stage_scenario()
        except ValueError as error:
            return Trouble("not attached: {}".format(error))
        if runs is None:
            return Trouble("not attached: the stage has not told its scenario yet")
        if not set(runs.kinds) <= set(KINDS):  # nor does it open files
            return Trouble(
                "not attached: its robots are of a kind in a file; open the stage's scenario here"
            )
        if runs.control.protocol not in HOMES:  # a name that comes in a topic runs no code
            runs = runs._replace(control=self.scenario.control, path=self.scenario.path)
        return self._try(runs._replace(speed=self.connection.newest("stage").speed)) or attached

    def _stage_scenario(self):
        """Return the scenario of the stage that runs, None before it is known."""
        told = self.connection.newest("scenario")
        if told is None or not self.connection.is_fresh("stage"):
            return None
        return scenario_from_yaml(told.data, "stage/scenario")

    def _start_stage(self, success, before):
        speed, self._speed = self._speed, None
        if not success:
            return Trouble("simulation not started: {}".format(before))
        self._swapped = [before]
        self.connection.begin_run()
        # Else a controller that cannot keep up would drive another experiment.
        self._lockstep = speed != 1.0
        options = ["_speed:={:g}".format(speed), _lockstep_option(self._lockstep)]
        self.processes.start("stage", "stage", "--scenario", self._written(), *options)
        return "simulation started"

    def _restore_time(self):
        """Leave ``/use_sim_time`` as it was before a stage was started here."""
        if self._swapped is not None:
            self.connection.restore_simulated_time(*self._swapped)
            self._swapped = None

    def _do_pause(self, _):
        stage = self.connection.newest("stage")
        self.connection.ask("pause", not (stage is not None and stage.paused))
        return ""

    def _do_step(self, _):
        self.connection.ask("step", 1)
        return ""

    def _do_reset(self, _):
        self.connection.ask("reset")
        return ""

    def _do_end(self, _):
        self.preflight.cancel()
        self.processes.stop("control")
        self.processes.stop("stage")
        self._restore_time()
        return "simulation ended"

    def _do_control(self, _):
        if not self.state.real():
            return self._start_control()
        self.preflight.begin(self._written(), self._own_findings(), accepted=frozenset())
        return "some robots are real: they are checked before the controller starts"

    def start_anyway(self):
        """Start the controller in spite of what the last check found; what is new keeps it from it."""
        accepted = self.preflight.keys()
        self.preflight.begin(self._written(), self._own_findings(), accepted)
        return "the robots are checked again; then the controller starts unless there is more"

    def _start_control(self):
        ending = self.processes.is_ending("control")  # it would answer, and go
        if self.connection.is_fresh("control") and self._control_fits() and not ending:
            self.connection.ask("start")
            return ""
        if self.state.real() and self.state.started_elsewhere():
            # Its remappings and limits are not known here: it is not to be replaced.
            return Trouble(
                "not started: the controller that runs is for another team than this scenario's"
            )
        self._launch_control()
        return "controller started: {}".format(self.scenario.control.protocol)

    def _launch_control(self):
        self.connection.begin_run()
        arguments = ["--scenario", self._written()] + who_is_real(self.connection)
        stage = self.connection.newest("stage")
        waits = stage.lockstep if stage is not None else self._lockstep
        arguments.append(_lockstep_option(waits and not self.state.real()))
        arguments.append("_autostart:=true")  # somebody pressed start, and real robots are checked
        self.processes.start("control", "pioneer_control", *arguments)

    def _do_stop(self, _):
        if self.preflight.cancel():
            return "the controller does not start"
        self.connection.ask("stop")
        return ""

    def _do_kill(self, _):
        self.processes.kill("control")
        return "controller killed: its robots stop by themselves for want of commands"

    def _do_preflight(self, _):
        self.preflight.begin(self._written(), self._own_findings())
        return ""

    def _own_findings(self):
        """Return what the GUI knows and the command ``preflight`` does not."""
        found, control, stage = (
            [],
            self.connection.newest("control"),
            self.connection.newest("stage"),
        )
        wanted = self.derived.protocol
        if self.state.started_elsewhere() and control.protocol != wanted:
            found.append(Finding("", "controller", "runs " + control.protocol, wanted))
        if self.state.real() and self.connection.is_fresh("stage") and stage.speed != 1.0:
            found.append(Finding("", "speed", "{:g}".format(stage.speed), "1, as real robots go"))
        return found

    def take_result(self, name, success, answer):
        """Take in the answer called ``name``; return a message, or ""."""
        if name == "simulated_time":
            return self._start_stage(success, answer)
        if name == "preflight":
            return self._after_preflight(success, answer)
        return str(answer) if success else Trouble("{} failed: {}".format(name, answer))

    def _after_preflight(self, success, answer):
        preflight = self.preflight
        if preflight.ended(success, answer):
            why = self.state.no_start()
            preflight.outcome = "" if why else preflight.outcome
            return Trouble("not started: {}".format(why)) if why else self._start_control()
        refused = ", the controller is not started" if preflight.outcome == "refused" else ""
        text = "robots checked, findings: {}{}".format(len(preflight.findings), refused)
        return Trouble(text) if refused else text

    def _do_bag(self, _):
        if self.processes.is_running("rosbag"):
            self.processes.stop("rosbag")
            return "bag ended"
        folder = self.results_directory()
        os.makedirs(folder, exist_ok=True)
        path = os.path.join(folder, self.suggested_name() + ".bag")
        options = ["--tcpnodelay", "-O", path, "-e", RECORDED]
        self.processes.start("rosbag", "record", *options, package="rosbag")
        return "recording {}".format(path)

    def set_speed(self, speed):
        """Ask a running stage for ``speed``."""
        self.scenario = self.scenario._replace(speed=speed)
        if not self.connection.is_fresh("stage"):
            return ""
        self.connection.ask("set_speed", speed)
        real = self.state.real() if speed != 1.0 else ()
        return "{}: real, at 1 \u00d7 whatever the speed".format(named(real)) if real else ""

    def note_timing(self):
        """Take in how many command periods were missed; return that the timing is degraded, or ""."""
        stage = self.connection.newest("stage")
        if stage is not None and self.is_controlled():
            self.missed.note(stage.stamp, stage.robots, stage.missed_periods, stage.command_periods)
        return self.missed.text()

    def send_team(self):
        """Ask the stage for the team as it stands; a controller of another team ends.

        Robots that are under way are not put elsewhere: for what was edited before they went.
        """
        if self.is_controlled():
            return Trouble("the team is not sent: stop the controller to change it")
        if self.processes.is_running("control") and not self._control_fits():
            self.processes.stop("control")
        self.connection.set_team(self.scenario.poses, self.scenario.kinds)
        real = self.state.real()
        return "{}: real, not moved".format(named(real)) if real else ""

    def _control_fits(self):
        control = self.connection.newest("control")
        size = 0 if control is None else len(control.command)
        return size == self.scenario.n and not control.stale

    def follow_protocol(self):
        """Let a controller started here, if one runs, follow the scenario; return a message, or ""."""
        if not self.processes.is_running("control"):
            return ""
        goes_on = self.is_controlled() and not self.state.real()
        self.processes.stop("control")
        if goes_on:
            self._launch_control()
            return ""
        # Robots that stand are not set going by a choice, nor real ones without a check.
        return "controller ended: start it for the new protocol"

    def what_the_stage_keeps(self):
        """Return a message on what a running stage does not take over from the scenario, or ""."""
        runs = self._stage_scenario()
        if runs is None:
            return ""
        kept = [
            name for name in OF_THE_STAGE if getattr(runs, name) != getattr(self.scenario, name)
        ]
        other = "the simulation goes on with its own {}: end it first for the scenario's"
        return other.format(", ".join(kept)) if kept else ""

    def _written(self):
        return write_scenario(self.scenario, self.processes.directory)

    def show_camera(self, on):
        """Start or end the camera's pictures."""
        self.connection.watch(on)
        if on:
            self.processes.start("camera", "camera")
        else:
            self.processes.stop("camera")

    def ended_processes(self):
        """Return messages on the programs that ended by themselves."""
        ended = self.processes.take_ended()
        names = {name.partition(" ")[0] for name, _, _ in ended}
        if "control" in names:  # its last status is not that of a controller that could be started
            self.connection.forget("control")
            if self.processes.is_running("control"):  # one has taken over, and gives commands alone
                self.connection.begin_run()
        if "stage" in names:  # nor is its last state that of a simulation to attach to
            self.connection.forget("stage")
            self.connection.forget("state")
        if any(name == "stage" for name, _, _ in ended):
            self._restore_time()
        return [
            Trouble("{} {}".format(name, _how_ended(code, output.strip()[-500:])))
            for name, code, output in ended
            if code not in (0, -2, 130)  # ended in good order
        ]

    # Results -------------------------------------------------------------------------------------

    @staticmethod
    def results_directory():
        """Return where results are suggested to go."""
        return os.path.join(os.path.expanduser("~"), "mrs_runs")

    def suggested_name(self):
        """Return a name of the run: its title and the time."""
        title = re.sub(r"[^a-z0-9]+", "_", (self.scenario.title or "run").lower()).strip("_")
        return "{}_{}".format(title[:40], time.strftime("%Y%m%d_%H%M%S"))

    def save(self, history, directory):
        """Write ``run.csv``, scenario, figures and verdict to ``directory``, in the background."""
        write = self._writing(history, directory)
        self._cancelled.clear()

        def work():
            self.saving = "writing run.csv"
            path = write()
            self.saving = "making figures and the verdict"
            if self._cancelled.is_set():
                return False, CANCELLED.format(directory)
            arguments = [path, "--out", directory, "--formats", "png,pdf,svg"]
            code, said = self.processes.run("report", "report", *arguments, limit=REPORT_LIMIT)
            if self._cancelled.is_set():
                return False, CANCELLED.format(directory)
            verdict = os.path.join(directory, VERDICT_FILE)
            return (True, verdict) if code in (0, 1) and os.path.exists(verdict) else (False, said)

        self.saving = "preparing"
        self.connection.do("save", work)

    def cancel_save(self):
        """Save no more than the data; the answer of ``save`` says so."""
        self._cancelled.set()
        self.processes.cancel("report")

    def keep(self, history):
        """Write the data of a run that nobody has saved beside the other results; return a message."""
        folder = os.path.join(self.results_directory(), KEPT)
        directory = os.path.join(folder, self.suggested_name())
        try:
            os.makedirs(directory, exist_ok=True)
            path = self._writing(history, directory)()
            runs = sorted(os.scandir(folder), key=lambda entry: entry.stat().st_mtime)
            for entry in runs[:-MOST_KEPT]:
                shutil.rmtree(entry.path, ignore_errors=True)
        except OSError as error:
            return Trouble("the run before was not saved, and is lost: {}".format(error))
        return "the run before was not saved; its data is kept in {}".format(path)

    def _writing(self, history, directory):
        """Return a function that writes a run's data, and returns its path; from any thread."""
        # The run begins with the first command, as it does for the recorder.
        begin = history.first_row()
        when, pose = history.time[begin:].copy(), history.pose[begin:].copy()
        command, joints = history.command[begin:].copy(), history.joints[begin:].copy()
        twist = history.twist[begin:].copy()
        axes = history.axes
        numbers, scenario = history.numbers, self.scenario
        collisions = [
            c._replace(time=c.time - when[0]) for c in history.collisions if c.time >= when[0]
        ]
        meta = self._told(when[0], when[-1], history.real.issuperset(numbers))
        if history.begun is None:
            meta["uncommanded"] = True
        elif self.missed.text():
            meta["degraded"] = self.missed.text()
        scenario = scenario._replace(duration=max(float(when[-1] - when[0]), 1e-3), poses=pose[0])
        team = Team.from_scenario(scenario._replace(kinds=_kinds_of(scenario, numbers)))

        def write():
            columns = team.record_columns
            with begin_run(scenario, directory, numbers, columns=columns) as file:
                samples = zip(when - when[0], pose, command, joints, twist)
                for stamp, poses, given, inner, speeds in samples:
                    points = team.point(poses, inner, scenario.hand_length)
                    given = on_axes(given, axes, team.axes)
                    file.sample(round(float(stamp), 9), poses, given, points, speeds, inner)
            write_facts(file.path, collisions, meta)
            return file.path

        return write

    def _told(self, begin, end, real):
        """Return what is known of a run from ``begin`` to ``end`` [s], of robots that are all ``real``."""
        controller, origin = (
            self.connection.controller,
            self.connection.first_stamp() if real else 0.0,
        )
        meta = {"warnings": controller.warnings(origin + begin, origin + end)}
        ended = controller.ended(origin + begin)
        meta.update({"ended": ended} if ended else {})
        # Nobody tells of real robots' collisions.
        return dict(meta, collisions_unknown=True) if real else meta

    # The end -------------------------------------------------------------------------------------

    def close(self):
        """End what was started here, and leave the master as it was."""
        self.preflight.cancel()
        self._prediction.ask(None)
        self.laws.close()
        self._background.close()
        self.processes.close()
        self._restore_time()


def _lockstep_option(waits):
    return "_lockstep:={}".format(str(bool(waits)).lower())


def _how_ended(code, output):
    how = "ended with {}".format(code) if code >= 0 else "killed by signal {}".format(-code)
    return "{}: {}".format(how, output) if output else how


def _kinds_of(scenario, numbers):
    """Return the kinds of the robots ``numbers`` of ``scenario``."""
    kinds = scenario.kinds
    return (
        kinds
        if len(kinds) == len(numbers)
        else tuple(kinds[min(n, len(kinds)) - 1] for n in numbers)
    )
