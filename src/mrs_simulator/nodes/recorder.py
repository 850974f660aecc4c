"""The record node: writes a run as it happens; at its end the figures and the verdict."""

import math
import os
import queue
import sys
import time

import numpy as np
import rospy

from mrs_simulator.core import recording
from mrs_simulator.core.verdict import verdict_text
from mrs_simulator.msg import Collision, StageStatus, TeamState
from mrs_simulator.nodes.arguments import RUN_ARGUMENTS, parse, scenario_from
from mrs_simulator.nodes.lifecycle import start_node
from mrs_simulator.nodes.parameters import number_parameter
from mrs_simulator.reporting import make_control, write_report, write_scenario

SILENCE = 10.0  # [s] of wall time without a state after which the run counts as ended
NAP = 0.2  # [s] of wall time

LOCAL = dict(RUN_ARGUMENTS, out="directory for run.csv, figures and verdict.json")


class RunRecorder:
    """Records the stage's states from the first command on, for the scenario's duration."""

    def __init__(self, scenario, out):
        """Write to the directory ``out``."""
        self.scenario, self.out = scenario, out
        self.control = make_control(scenario)  # for its claims
        self.silence = number_parameter("~silence", SILENCE, above=0.0)
        self.csv_path = os.path.join(out, "run.csv")
        numbers = range(1, scenario.n + 1)
        self._file = recording.Recorder(self.csv_path, numbers, scenario.hand_length)
        write_scenario(scenario, out)
        self._queue = queue.Queue()
        self._start, self._next = None, 0.0
        self._collisions = []
        self._closest = math.inf
        self._wall_start = None
        self.ended = "interrupted"
        self.elapsed = 0.0
        self._subscribers = [
            rospy.Subscriber("stage/state", TeamState, self._queue.put, tcp_nodelay=True),
            rospy.Subscriber("stage/collisions", Collision, self._on_collision),
            rospy.Subscriber("stage/status", StageStatus, self._on_status),
        ]

    def spin(self):
        """Record until the duration is over, the stage falls silent, or ROS shuts down."""
        heard = time.monotonic()
        while not rospy.is_shutdown():
            try:
                state = self._queue.get(timeout=NAP)
            except queue.Empty:
                if self._start is not None and time.monotonic() - heard > self.silence:
                    self.ended = "the stage fell silent"
                    rospy.logerr("record: no state for %g s; the run ends here", self.silence)
                    return
                continue
            heard = time.monotonic()
            self._take(state)
            if self.elapsed >= self.scenario.duration - 1e-6:
                self.ended = "complete"
                return

    def _take(self, state):
        stamp = state.header.stamp.to_sec()
        if self._start is None:
            if not any(state.commanded):
                return
            self._begin(state, stamp)
        self.elapsed = stamp - self._start
        if self.elapsed < self._next - 1e-6:
            return
        self._next = self.elapsed + 1.0 / self.scenario.record_rate
        pose = np.array([state.x, state.y, state.theta]).T
        command = np.array([state.command_v, state.command_omega]).T
        if len(pose) != self.scenario.n:
            rospy.logerr_throttle(
                5.0, "record: {} robots, wanted {}".format(len(pose), self.scenario.n)
            )
            return
        # Stamps carry whole nanoseconds: what is finer is their rounding.
        self._file.sample(round(self.elapsed, 9), pose, command)

    def _begin(self, state, stamp):
        self._start, self._wall_start = stamp, time.monotonic()
        begun = np.array([state.x, state.y]).T
        if begun.shape == (self.scenario.n, 2):
            away = np.max(np.abs(begun - self.scenario.poses[:, :2]))
            if away > 0.05:
                rospy.logwarn("record: robots began %.2f m away from the scenario's poses", away)
        rospy.loginfo("record: recording %g s to %s", self.scenario.duration, self.csv_path)

    def _on_collision(self, message):
        if self._start is not None:
            elapsed = message.header.stamp.to_sec() - self._start
            self._collisions.append(
                recording.Collision(elapsed, message.first, message.second, message.x, message.y)
            )

    def _on_status(self, message):
        if self._start is not None:
            self._closest = min(self._closest, message.closest_approach)

    def finish(self):
        """Write figures and verdict of what was recorded; return the verdict, None if nothing was."""
        self._file.close()
        if self._start is None:
            return None
        wall = time.monotonic() - self._wall_start
        run = recording.read_run_csv(
            self.csv_path,
            self.scenario,
            self._collisions,
            {
                "real_time_factor": self.elapsed / wall,
                "closest_approach": self._closest,
                "ended": self.ended,
            },
        )
        return write_report(run, self.out, control=self.control)


def main():
    """Run the node ``record``; exits with 0 passed, 1 failed verdict, 2 bad input."""
    try:
        arguments = parse("Record a run; at its end write figures and verdict.", LOCAL)
        scenario = scenario_from(arguments)
        if not arguments.out:
            raise ValueError("--out: nothing given, wanted a directory for the results")
        start_node("record")
        recorder = RunRecorder(scenario, os.path.abspath(arguments.out))
    except (ValueError, OSError) as error:
        print("record: {}".format(error), file=sys.stderr)
        sys.exit(2)
    recorder.spin()
    verdict = recorder.finish()
    if verdict is None:
        print("record: nothing was recorded: no command reached the robots", file=sys.stderr)
        sys.exit(1)
    print(verdict_text(verdict))
    print("  figures and data: {}".format(recorder.out))
    sys.stdout.flush()
    sys.exit(0 if verdict["passed"] else 1)


if __name__ == "__main__":
    main()
