"""The record node: writes a run while it happens, and its figures and verdict at the end.

Of a stage in simulated time, else of real robots.
"""

import os
import sys
import time

import numpy as np
import rospy
from std_msgs.msg import String

from mrs_simulator.control.user_code import call
from mrs_simulator.core.step_rates import on_steps
from mrs_simulator.nodes.control.guards import slower
from mrs_simulator.nodes.record.run_sources import make_source
from mrs_simulator.nodes.record.sensor_source import SensorSource
from mrs_simulator.protocols.loading import from_anywhere
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record import recording
from mrs_simulator.record.controller_log import Interruptions, deadlock_in
from mrs_simulator.record.run_changes import ControllerRecord, changed_by, to_plain
from mrs_simulator.ros.message_forms.messages import (
    ControlScenario,
    ControlStatus,
    MessageError,
    read_control_scenario,
    read_control_status,
)
from mrs_simulator.ros.node.arguments import RUN_ARGUMENTS, parse, scenario_from
from mrs_simulator.ros.node.deferred_output import print_last
from mrs_simulator.ros.node.diagnostics import OK, WARN, Diagnostics, Health, Rates
from mrs_simulator.ros.node.lifecycle import run, start_node
from mrs_simulator.ros.node.node_parameters import SILENCE
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.scenario.scenario import scenario_from_yaml
from mrs_simulator.scenario.surroundings.moving_obstacles import scene_facts, scene_time
from mrs_simulator.state.columns import LOAD, TWIST
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.results.provenance import LOCKSTEP, ROBOTS, STAGE, write_provenance
from mrs_simulator.study.results.report import begin_run, write_report, write_scenario
from mrs_simulator.study.run.applied_scenario import what_ran
from mrs_simulator.verdict.requirements.step_trace import StepTrace
from mrs_simulator.verdict.verdict import exit_code, verdict_text

NAP = 0.2  # [s] of wall time
ROUNDING = 2e-9  # [s] by which the difference of two stamps may be wrong
COMPLETE, INTERRUPTED = "complete", "interrupted"  # how a run ended

LOCAL = dict(
    RUN_ARGUMENTS,
    out="directory for run.csv, figures and verdict.json",
    require_verdict="true: exit with 3 where the run could not be judged",
    last="true: print the verdict after all else that roslaunch prints, which ends with this node",
)


class RunRecorder:
    """Records a source's samples from the controller's first command on, for the scenario's duration.

    Where no controller reports its status, whatever commands the robots begins the run.
    """

    def __init__(self, scenario, out):
        """Write to the directory ``out``."""
        self.scenario, self.out = scenario, out
        self.control = make_control(scenario)  # for its claims
        self.silence = read(SILENCE)
        layout = self.control.team.layout(lambda column: column.over_ros and column.given(scenario))
        self._file = begin_run(scenario, out, report=_report, layout=layout)
        self._layout, self._real = layout, []  # numbers of the robots that are real
        self.sensors = SensorSource(scenario, out, rospy.loginfo) if scenario.record else None
        if self.sensors:
            self.sensors.wait()  # a stage may begin as soon as its state has subscribers
        self.source = make_source(scenario)
        self._trace = _trace_of(scenario)
        self._start, self._next = None, 0.0
        self._moved = False  # whether any robot was commanded to
        self._wall_start = None
        self.ended = INTERRUPTED
        self.elapsed = 0.0
        self.controller, self._stands = Interruptions(), False
        self._deadlock = ()  # by the controller's newest status
        self.samples, self._rates = 0, Rates()  # that were written
        self._diagnostics = Diagnostics(self._health)
        self._obeyed = ControllerRecord()
        self._staged = None  # the scenario, as YAML, of the stage in which the run began
        self._stage_scenario = rospy.Subscriber("stage/scenario", String, self._on_staged)
        self._preset = ""  # the stage's, "" where it is not known
        self._stage_preset = rospy.Subscriber("stage/preset", String, self._on_preset)
        self._status, self._controller_scenario = (
            rospy.Subscriber(name, kind, handler, tcp_nodelay=True)
            for name, kind, handler in (
                ("pioneer_control/status", ControlStatus, self._on_status),
                ("pioneer_control/scenario", ControlScenario, self._on_obeyed),
            )
        )

    def _on_obeyed(self, message):
        try:
            self._obeyed.note(*read_control_scenario(message))
        except MessageError as error:
            rospy.logerr("record: pioneer_control/scenario: %s", error)

    def _on_staged(self, message):
        if self._start is None or self._staged is None:
            self._staged = message.data

    def _on_preset(self, message):
        self._preset = message.data

    def _on_status(self, message):
        try:
            status = read_control_status(message)
        except MessageError as error:
            rospy.logerr_throttle(5.0, "record: pioneer_control/status: {}".format(error))
            return
        self._stands = not status.running
        self.controller.note(status.stamp, status.running, status.trouble)
        found = [deadlock_in(warning) for warning in status.warnings]
        self._deadlock = next(filter(None, found), ())

    def _health(self):
        """Return how the recording is, for ``/diagnostics``."""
        readings = self.sensors.count if self.sensors else 0
        rates = self._rates.of({"samples [Hz]": self.samples, "readings [Hz]": readings})
        values = dict(rates, samples=self.samples, readings=readings, elapsed=float(self.elapsed))
        message = "waiting for the first command" if self._start is None else "recording"
        warnings = self._file.warnings()
        return [Health("", WARN if warnings else OK, (warnings or [message])[0], values)]

    def spin(self):
        """Record until the duration is over, the source falls silent or breaks, or ROS shuts down."""
        rospy.loginfo("record: waiting for the robots' first command")
        received_at = time.monotonic()
        while not rospy.is_shutdown():
            sample = self.source.next(NAP)
            broken = self._failed() or (
                self._start is not None and self._broken(sample, received_at)
            )
            if broken:
                self.ended = broken
                rospy.logerr("record: the run ends here: %s", broken)
                return
            if sample is None:
                continue
            received_at = time.monotonic()
            self._take(sample)
            if self.elapsed >= self.scenario.duration - ROUNDING:
                self.ended = COMPLETE
                return

    def _failed(self):
        """Return when and how the law failed, or ""."""
        return self.controller.ended(np.inf if self._start is None else self._start)

    def _broken(self, sample, received_at):
        """Return why the run cannot go on, or ""."""
        silent = sample is None and time.monotonic() - received_at > self.silence
        return self.source.silence() if silent else self.source.broken()

    def _take(self, sample):
        if self._start is None:
            if not sample.commanded.any() or self._is_driven_otherwise():
                return
            self._begin(sample)
        self.elapsed = self._since_start(sample.time)
        if self._trace is not None and len(sample.pose) == self.scenario.n:
            self._trace.add(self._recorded(sample))
        if not self._is_due():
            return
        if len(sample.pose) != self.scenario.n:
            rospy.logerr_throttle(
                5.0, "record: {} robots, wanted {}".format(len(sample.pose), self.scenario.n)
            )
            return
        if self.scenario.load is not None and not sample.has(LOAD):
            rospy.logerr_throttle(5.0, "record: the stage has no load, wanted the scenario's")
            return
        self._file.sample(self.elapsed, self._recorded(sample))
        self.samples += 1
        self._moved = self._moved or bool(np.any(sample.command))

    def _since_start(self, stamp):
        """Return the time [s] of a ``stamp`` [s] since the run began, of a stage in whole steps."""
        # Stamps carry whole nanoseconds: what is finer is the rounding of their difference.
        since = round(stamp - self._start, 9)
        return since if self.source.PACED else on_steps(since, self.scenario.step)

    def _recorded(self, sample):
        """Return ``sample`` with the points that the controller controls."""
        return self.control.team.recorded(sample, self._obeyed.hand_length(self.control.l))

    def _is_driven_otherwise(self):
        """Return whether commands are another's, as a joystick's: a controller is there and not started."""
        return self._stands and self._status.get_num_connections() > 0

    def _is_due(self):
        """Return whether the sample at ``elapsed`` is to be recorded, as each of real robots is."""
        if not self.source.PACED and self.elapsed < self._next - 1e-6:
            return False
        self._next = self.elapsed + self.scenario.record_period
        return True

    def _begin(self, sample):
        self._start, self._wall_start = sample.time, time.monotonic()
        self.source.begin()
        if self.sensors:
            self.sensors.begin(sample.time)
        self._begin_file((np.flatnonzero(sample.real) + 1).tolist())
        begun = sample.pose[:, :2]
        if len(begun) == self.scenario.n:
            away = np.max(np.abs(begun - self.scenario.poses[:, :2]))
            if away > 0.05:
                rospy.logwarn("record: robots began %.2f m away from the scenario's poses", away)
        rospy.loginfo("record: recording %g s to %s", self.scenario.duration, self._file.path)

    def _begin_file(self, real):
        """Begin the file anew, with velocities, if robots are ``real``; note what is known of the run."""
        path, self._real = self._file.path, real
        if real:
            self._file.close()
            own = range(1, self.scenario.n + 1), self.scenario.hand_length, _report
            self._file = recording.Recorder(path, *own, self._layout.also(TWIST))
        known = {**self.source.meta(), **self._scene()}
        known.pop("closest_approach", None)  # it may come closer
        recording.begin_facts(path, real, **known)

    def _scene(self):
        """Return what is known of obstacles that move, by the names in ``recording.FACTS``."""
        if self.source.PACED:  # nothing reports what moves among real robots
            return {}
        return scene_facts(self.scenario.obstacles, scene_time(self._start))

    def finish(self):
        """Write figures and verdict of what was recorded; return the verdict, None if nothing was."""
        self._file.close()
        missing = self.sensors.close() if self.sensors else []
        if self._start is None:
            return None
        wall, end = time.monotonic() - self._wall_start, self._start + self.elapsed
        if self.ended in (COMPLETE, INTERRUPTED):
            self.ended = self.controller.emergency(self._start, end) or self.ended
        collisions = [c._replace(time=self._since_start(c.time)) for c in self.source.collisions]
        meta = {"real_time_factor": self.elapsed / wall, "ended": self.ended}
        meta["warnings"] = [*self.control.team.notes, *self._take_what_ran(meta)]
        if not self.source.PACED:
            meta["warnings"] += self.scenario.warnings()
        if self.control is not None:
            meta["warnings"] += self.control.foreseen
            meta["warnings"] += call(self.control.warnings, self.scenario.starts)
        meta["warnings"] += self.controller.warnings(self._start, end)
        meta["warnings"] += self._file.warnings() + missing + self.source.warnings()
        meta["deadlock"] = [list(each) for each in self._deadlock]
        meta.update(self.source.meta(), **self._scene())
        meta.update({"real": self._real} if self._real else {})
        incidents = [i._replace(time=self._since_start(i.time)) for i in self.source.incidents]
        if incidents:
            meta["incidents"] = incidents
        if not self._moved:  # zeros are what a controller says that never began
            meta["uncommanded"] = True
        if self._trace is not None and self.control is not None:
            known = self.scenario, self.control, collisions
            meta["requirements"] = self._trace.results(*known, begun=self._start)
        recording.write_facts(self._file.path, collisions, meta)
        run = recording.read_run_csv(self._file.path, self.scenario)
        verdict = write_report(run, self.out, control=self.control)
        recorded_of = LOCKSTEP if meta.get("lockstep") else STAGE
        recorded_of = ROBOTS if self.source.PACED else recorded_of
        told = {"preset": self._preset} if self._preset and not self.source.PACED else {}
        write_provenance(self.scenario, self.out, recorded_of=recorded_of, **told)
        return verdict

    def _take_what_ran(self, meta):
        """Take up what stage and controller ran in place of the scenario given; return warnings."""
        obeyed, changes = self._obeyed.during(self._start, self._start + self.elapsed)
        before = self.scenario
        try:
            staged = self._staged and scenario_from_yaml(self._staged, "stage/scenario")
            ran, unknown = what_ran(before, staged, obeyed)
            changed_by(ran, changes)
        except ValueError as error:
            text = "stage/scenario and pioneer_control/scenario are left out: {}"
            return [text.format(error)]
        meta.update({"changes": to_plain(changes)} if changes else {})
        meta.update({"unknown_law": unknown} if unknown else {})
        if ran is not before:
            same = ran.control.protocol == from_anywhere(before).control.protocol
            law = type(self.control) if same else None
            self.scenario, self.control = ran, None if unknown else make_control(ran, law)
            write_scenario(ran, self.out)
        return []


def _trace_of(scenario):
    """Return the ``StepTrace`` of a run, None where requirements are of sensors, known elsewhere."""
    wanted = scenario.requirements
    if not wanted or any(each.sensors for each in wanted):
        return None
    return StepTrace(wanted)


def _report(text):
    rospy.logerr("record: %s", text)


def main():
    """Run the node ``record``; exits with 2 for bad input, else with the verdict's code."""
    with refusing_bad_input("record"):
        arguments = parse(
            "Record a run; at its end write figures and verdict.", LOCAL, node="record"
        )
        scenario = scenario_from(arguments)
        if not arguments.out:
            raise ValueError("--out: nothing given, wanted a directory for the results")
        start_node("record")
        recorder = RunRecorder(slower(scenario), os.path.abspath(arguments.out))
    run(recorder.spin)
    with refusing_bad_input("record"):
        verdict = recorder.finish()
    if verdict is None:
        why = recorder.controller.failed() or ("", "no command reached the robots")
        print("record: nothing was recorded: {}".format(why[1]), file=sys.stderr)
        sys.exit(1)
    text = "{}\n  figures and data: {}".format(verdict_text(verdict), recorder.out)
    (print_last if _is_true(arguments.last) else print)(text)
    sys.stdout.flush()
    sys.exit(exit_code(verdict, _is_true(arguments.require_verdict)))


def _is_true(argument):
    return argument.lower() == "true"
