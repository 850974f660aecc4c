"""A study's run: the edited scenario, the programs that run it, and its files; without Qt."""

import functools
import os

from mrs_simulator.record.missed_periods import MissedPeriods
from mrs_simulator.rqt_plugin.run.answers import refused, without_own_files
from mrs_simulator.rqt_plugin.run.control_run import ControlRun
from mrs_simulator.rqt_plugin.run.edited_scenario import EditedScenario
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.run.preflight_run import PreflightRun
from mrs_simulator.rqt_plugin.run.programs import called
from mrs_simulator.rqt_plugin.run.run_files import RunFiles
from mrs_simulator.rqt_plugin.run.stage_run import StageRun
from mrs_simulator.rqt_plugin.run.study_state import StudyState
from mrs_simulator.rqt_plugin.shelf.folder import Shelf

RECORDED = "/clock|/tf|/tf_static|/stage/.*|/pioneer_control/(status|scenario)|/robot[0-9]+/.*"
WHOLE = "whole"  # the action that starts a simulation for one run from its beginning to its end
LONGEST_OUTPUT = 500  # [characters] that are shown of a program that failed


class StudyRun:
    """The edited scenario, and the programs that run it."""

    def __init__(self, connection, processes, scenario):
        self.connection, self.processes = connection, processes
        self.preflight = PreflightRun(connection, processes)
        self.state = StudyState(connection, processes, self.preflight)
        self.is_controlled = self.state.is_controlled
        self.edited = EditedScenario(scenario, connection, self.state)
        self.stage = StageRun(connection, processes, self.edited, self.state)
        self.control = ControlRun(
            connection, processes, self.edited, self.state, self.stage, self.preflight
        )
        self.missed = MissedPeriods()
        self.shelf = Shelf()
        self.files = RunFiles(connection, processes, self.edited, self.missed, self.shelf)
        self._resets, self._sends = False, False  # once the controller has stopped
        self._actions = {
            "simulate": self.stage.simulate,
            WHOLE: functools.partial(self.stage.simulate, whole=True),
            "pause": self.stage.pause,
            "step": self.stage.step,
            "reset": self._reset,
            "end": self._end,
            "control": self.control.start,
            "stop": self.control.stop,
            "kill": self.control.kill,
            "preflight": self.control.check,
            "bag": self._bag,
        }

    @property
    def scenario(self):
        """Return the scenario as edited so far."""
        return self.edited.scenario

    def do(self, name, speed=1.0):
        """Do the action of the button ``name``; return a message, or ""."""
        try:
            return self._actions[name](speed)
        except OSError as error:  # a full disk, a directory that may not be written
            return ErrorMessage("{}: {}".format(name, error))

    def take_result(self, name, success, answer):
        """Take in the answer called ``name``; return a message, or ""."""
        try:
            return self._take(name, success, answer)
        except OSError as error:  # what is to be started is written to a file
            return ErrorMessage("not started: {}".format(error))

    def _take(self, name, success, answer):
        if name == "simulated_time":
            return self.stage.start(success, answer)
        if name == "stop" and self._resets:
            self._resets = False
            self.stage.reset()
        if name == "stop" and self._sends:
            self._sends = False
            return self._put_team()
        if name == "preflight":
            return self.control.checked(success, answer)
        if success:
            return str(answer)
        return ErrorMessage(refused(name, answer, self.processes.directory))

    def _end(self, _):
        self.preflight.cancel()
        self.control.end()
        self.stage.end()
        return "simulation ended"

    def _reset(self, _):
        """Put the robots to where they began; a controller that would move them on stops before."""
        if self.is_controlled() and not self.state.real():
            self._resets = True
            return self.control.stop()
        return self.stage.reset()

    def _bag(self, _):
        if self.processes.is_running("rosbag"):
            self.processes.stop("rosbag")
            return "bag ended"
        folder = self.files.results_directory()
        os.makedirs(folder, exist_ok=True)
        path = os.path.join(folder, self.files.suggested_name() + ".bag")
        options = ["--tcpnodelay", "-O", path, "-e", RECORDED]
        self.processes.start("rosbag", "record", *options, package="rosbag")
        return "recording {}".format(path)

    def send_team(self):
        """Ask the stage for the team as it stands; a controller of another team ends.

        Robots that are under way are not put elsewhere: for what was edited before they went.
        """
        if self.state.drives():
            return ErrorMessage("the team is not sent: stop the controller to change it")
        if self.is_controlled():  # of a run that is over
            self._sends = True
            return self.control.stop()
        return self._put_team()

    def _put_team(self):
        self.control.end_unfit()
        return self.stage.set_team()

    def note_timing(self):
        """Count missed command periods; return a text where the timing is degraded, else ""."""
        stage = self.connection.newest("stage")
        if stage is not None and self.is_controlled():
            self.missed.note(stage.stamp, stage.robots, stage.missed_periods, stage.command_periods)
        return self.missed.text()

    def ended_processes(self):
        """Return messages on the programs that ended by themselves."""
        ended = self.processes.take_ended()
        names = {name.partition(" ")[0] for name, _, _ in ended}
        if "control" in names:  # its last status is not that of a controller that could be started
            self.connection.forget("control")
            if self.processes.is_running("control"):  # a new one has taken over
                self.connection.begin_run()
        if "stage" in names:  # nor is its last state that of a simulation to attach to
            self.connection.forget("stage")
            self.connection.forget("state")
            if not self.processes.is_running("control"):  # one without a simulation ends with it
                self.connection.forget("control")
        if any(name == "stage" for name, _, _ in ended):
            self.stage.restore_time()
        return [
            ErrorMessage("{} {}".format(called(name), self._how_ended(code, output)))
            for name, code, output in ended
            if code not in (0, -2, 130)  # ended normally
        ]

    def _how_ended(self, code, output):
        return without_own_files(how_ended(code, output), self.processes.directory)

    def close(self):
        """End what was started here, and leave the master as it was."""
        self.preflight.cancel()
        self.edited.close()
        self.processes.close()
        self.stage.restore_time()


def how_ended(code, output):
    """Return a text on how a program ended by itself; ``output``: what it has printed.

    A killed program prints nothing about it.
    """
    if code < 0:
        return "killed by signal {}; its output is in the tab Programs".format(-code)
    last = last_lines(output)
    return "ended with {}{}".format(code, ": " + last if last else "")


def last_lines(output):
    """Return the last whole lines of ``output``, without progress reports."""
    lines = [line for line in output.strip().splitlines() if not line.startswith("[INFO]")]
    while len(lines) > 1 and len("\n".join(lines)) > LONGEST_OUTPUT:
        del lines[0]
    return "\n".join(lines)[-LONGEST_OUTPUT:]
