"""What the GUI does about a run: the scenario as edited, programs started, results saved.  No Qt."""

import os
import re
import time

import numpy as np
import rospy

from mrs_simulator.control.loading import load_protocol
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.core.recording import Recorder
from mrs_simulator.core.scenario import scenario_from_dict
from mrs_simulator.reporting import make_control, write_scenario

REPORT_LIMIT = 300.0  # [s] of wall time for figures and verdict
RECORDED = "/clock|/tf|/tf_static|/stage/.*|/pioneer_control/status|/robot[0-9]+/.*"
PREDICTED_SAMPLES = 400  # [-] of the prediction drawn


class StudyRun:
    """The scenario under the user's hands, and the programs that run it."""

    def __init__(self, link, processes, scenario):
        self.link, self.processes, self.scenario = link, processes, scenario

    # The scenario --------------------------------------------------------------------------------

    def control(self):
        """Return the control of the scenario as it stands."""
        return make_control(self.scenario)

    def warnings(self, control):
        """Return theory's warnings by the parameter that causes them."""
        texts = control.warnings(self.scenario.poses)
        return {"T" if hasattr(control, "T") else "": "; ".join(texts)} if texts else {}

    def set_team(self, poses, kinds):
        """Take in a team; edges of robots that are gone go with them."""
        topology = self.scenario.topology
        if topology is not None and topology.n != len(poses):
            edges = [edge for edge in topology.edges if max(edge[:2]) <= len(poses)]
            topology = Topology(len(poses), edges, topology.directed)
        self.scenario = self.scenario._replace(poses=poses, kinds=tuple(kinds), topology=topology)

    def set_protocol(self, name):
        """Take another protocol with its defaults; return what is wrong with it, or ""."""
        before = self.scenario
        try:
            load_protocol(name, beside=self.scenario.path)
            self.scenario = self.scenario.with_protocol(name)
            if self.scenario.topology is None:
                self.scenario = self.scenario._replace(
                    topology=Topology.preset("cycle", self.scenario.n)
                )
            self.control()
        except Exception as error:  # a file of one's own may raise anything
            self.scenario = before
            return "protocol {}: {}".format(name, error)
        return self._restart_control()

    def set_parameters(self, values):
        """Take other values; a running controller gets them at once.  Return what is wrong, or ""."""
        try:
            checked = self.control().checked_parameters(values)
        except ValueError as error:
            return str(error)
        control = self.scenario.control._replace(parameters=checked)
        self.scenario = self.scenario._replace(control=control)
        if self.is_controlled():
            self.link.set_parameters(checked)
        return ""

    def set_topology(self, edges, directed):
        """Take another graph; a running controller gets it at once.  Return what is wrong, or ""."""
        topology = Topology(self.scenario.n, edges, directed)
        control = make_control(self.scenario)
        control.set_topology(topology)
        changed = self.scenario.control._replace(parameters=dict(control.parameters))
        self.scenario = self.scenario._replace(topology=topology, control=changed)
        if self.is_controlled():
            self.link.set_topology(edges, directed)
        return ""

    def error_function(self, control):
        """Return a function of poses (m, n, 3) that gives the largest target error (m,), or None."""
        if control.targets(hand_points(self.scenario.poses, control.l)) is None:
            return None

        def error(pose):
            hands = hand_points(pose, control.l)
            if hands.shape[1] != len(control.numbers):
                return np.full(len(hands), np.nan)
            return np.array(
                [np.linalg.norm(hand - control.targets(hand), axis=1).max() for hand in hands]
            )

        return error

    def predicted_error(self, control):
        """Return theory's ``(time, error)`` for the error curve, ``(None, None)`` without one."""
        start = hand_points(self.scenario.poses, control.l)
        when = np.linspace(0.0, self.scenario.duration, PREDICTED_SAMPLES)
        if control.targets(start) is None:
            return None, None
        track = control.prediction(start, when)
        if track is None:
            return None, None
        errors = [np.linalg.norm(hand - control.targets(hand), axis=1).max() for hand in track]
        return when, np.array(errors)

    # The run -------------------------------------------------------------------------------------

    def do(self, name, speed=1.0):
        """Do what the button called ``name`` says; return a message, or ""."""
        return getattr(self, "_do_" + name)(speed)

    def _do_simulate(self, speed):
        if self.link.is_fresh("stage"):
            self.send_team()
            return "attached to the stage that runs"
        try:
            scenario_from_dict(self.scenario.to_dict(), "scenario")
        except ValueError as error:
            return str(error)
        rospy.set_param("/use_sim_time", True)
        self.processes.start(
            "stage", "stage", "--scenario", self._written(), "_speed:={:g}".format(speed)
        )
        return "simulation started"

    def _do_pause(self, _):
        stage = self.link.newest("stage")
        self.link.ask("pause", not (stage is not None and stage.paused))
        return ""

    def _do_step(self, _):
        self.link.ask("step", 1)
        return ""

    def _do_reset(self, _):
        self.link.ask("reset")
        return ""

    def _do_end(self, _):
        self.processes.stop("control")
        self.processes.stop("stage")
        return "simulation ended"

    def _do_control(self, _):
        if self.link.is_fresh("control") and self._control_fits():
            self.link.ask("start")
            return ""
        self.processes.start("control", "pioneer_control", "--scenario", self._written())
        return "controller started: {}".format(self.scenario.control.protocol)

    def _do_stop(self, _):
        self.link.ask("stop")
        return ""

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
        if self.link.is_fresh("stage"):
            self.link.ask("set_speed", speed)
        return ""

    def send_team(self):
        """Ask the stage for the team as it stands; a controller of another team ends."""
        if self.processes.is_running("control") and not self._control_fits():
            self.processes.stop("control")
        self.link.set_team(self.scenario.poses, self.scenario.kinds)

    def _control_fits(self):
        control = self.link.newest("control")
        snapshot = self.link.snapshot()
        size = self.scenario.n if snapshot is None else len(snapshot.numbers)
        return control is not None and not control.stale and size == self.scenario.n

    def _restart_control(self):
        if self.processes.is_running("control"):
            return self._do_restart()
        return ""

    def _do_restart(self):
        self.processes.stop("control")
        self.processes.start("control", "pioneer_control", "--scenario", self._written())
        return ""

    def _written(self):
        path = os.path.join(self.processes.directory, "scenario.yaml")
        scenario = self.scenario
        # A protocol's file named beside the scenario is named from here.
        if scenario.path and ".py" in scenario.control.protocol:
            beside = os.path.join(os.path.dirname(scenario.path), scenario.control.protocol)
            if os.path.exists(beside.partition(":")[0]):
                scenario = scenario._replace(control=scenario.control._replace(protocol=beside))
        with open(path, "w", encoding="utf-8") as file:
            file.write(scenario.to_yaml())
        return path

    def show_camera(self, on):
        """Start or end the camera's pictures."""
        self.link.watch(on)
        if on:
            self.processes.start("camera", "camera")
        else:
            self.processes.stop("camera")

    def ended_processes(self):
        """Return messages on the programs that ended by themselves."""
        return [
            "{} ended with {}: {}".format(name, code, output.strip()[-500:])
            for name, code, output in self.processes.take_ended()
            if code not in (0, -2, 130)  # ended in good order
        ]

    def is_controlled(self):
        """Return whether a controller runs and gives commands."""
        control = self.link.newest("control")
        return self.link.is_fresh("control") and control is not None and control.running

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
        # The run begins with the first command, as it does for the recorder.
        begin = int(np.argmax(np.any(history.command != 0.0, axis=(1, 2))))
        when, pose = history.time[begin:].copy(), history.pose[begin:].copy()
        command = history.command[begin:].copy()
        numbers, scenario = history.numbers, self.scenario
        scenario = scenario._replace(duration=max(float(when[-1] - when[0]), 1e-3), poses=pose[0])

        def work():
            with Recorder(
                os.path.join(directory, "run.csv"), numbers, scenario.hand_length
            ) as file:
                for stamp, poses, commands in zip(when - when[0], pose, command):
                    file.sample(round(float(stamp), 9), poses, commands)
            write_scenario(scenario, directory)
            table = os.path.join(directory, "run.csv")
            command_line = ["rosrun", "mrs_simulator", "report", table, "--out", directory]
            code, said = self.processes.run(
                command_line + ["--formats", "png,pdf,svg"], "report", REPORT_LIMIT
            )
            return code in (0, 1), said

        self.link.do("save", work)

    # What is so ----------------------------------------------------------------------------------

    def states(self):
        """Return ``name: (good, text)`` of master, stage, controller, robots and time."""
        link = self.link
        stage, control = link.newest("stage"), link.newest("control")
        alive = link.is_fresh("stage")
        return {
            "master": (link.master_online, "master" if link.master_online else "no master"),
            "stage": self._stage_state(stage, alive),
            "controller": self._control_state(control),
            "robots": self._robots_state(),
            "time": self._time_state(stage, alive),
        }

    def _stage_state(self, stage, alive):
        if not alive:
            return (
                (False, "stage starting")
                if self.processes.is_running("stage")
                else (None, "no stage")
            )
        where = "" if self.processes.is_running("stage") else ", started elsewhere"
        return True, "stage: {}{}{}".format(
            stage.fidelity, " (paused)" if stage.paused else "", where
        )

    def _control_state(self, control):
        if control is None or not self.link.is_fresh("control"):
            return None, "no controller"
        if control.running and not control.trouble:
            return True, "controller: {}".format(control.protocol)
        return False, "controller: {}".format(control.trouble or "stopped")

    def _robots_state(self):
        snapshot = self.link.snapshot()
        if snapshot is None:
            return None, "no robots"
        stale = [n for n, fresh in zip(snapshot.numbers, snapshot.fresh) if not fresh]
        if stale:
            return False, "{} robots, {} stale".format(len(snapshot.numbers), len(stale))
        return True, "{} robots fresh".format(len(snapshot.numbers))

    def _time_state(self, stage, alive):
        snapshot = self.link.snapshot()
        if snapshot is None:
            return None, ""
        factor = ", {:.1f} \u00d7 real time".format(stage.real_time_factor) if alive else ""
        return (True if alive else None), "t = {:.1f} s{}".format(snapshot.time, factor)

    def enabled(self):
        """Return which actions make sense now."""
        stage = self.link.newest("stage")
        alive = self.link.is_fresh("stage")
        robots = self.link.snapshot() is not None
        paused = alive and stage is not None and stage.paused
        return {
            "simulate": self.link.master_online and not self.processes.is_running("stage"),
            "pause": alive,
            "step": paused,
            "reset": alive,
            "end": self.processes.is_running("stage"),
            "control": robots and not self.is_controlled(),
            "stop": self.is_controlled(),
            "bag": self.link.master_online,
            "save": robots,
        }

    def close(self):
        """End what was started here."""
        self.processes.close()
