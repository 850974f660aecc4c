"""Preflight node: listens to the robots and reports whether they can be driven."""

import argparse
import contextlib
import json
import logging
import os
import sys
import time

import numpy as np
import rosgraph
import rospy

from mrs_simulator.control.guards import checked_fence
from mrs_simulator.core.writing import printing, write_text
from mrs_simulator.nodes.control.common_frame import make_common_frame
from mrs_simulator.nodes.control.guards import going_on, slower, stopping_team, top_speeds
from mrs_simulator.nodes.real.real_robots import real_among
from mrs_simulator.protocols.making import make_control
from mrs_simulator.ros.node.arguments import RUN_ARGUMENTS, parse, scenario_from
from mrs_simulator.ros.node.diagnostics import Diagnostics, preflight_health
from mrs_simulator.ros.node.lifecycle import start_node
from mrs_simulator.ros.node.node_parameters import (
    GEOFENCE,
    LEAST_DISTANCE,
    PLACE_TOLERANCE,
    TIME_LIMIT,
)
from mrs_simulator.ros.node.parameters import is_given, read
from mrs_simulator.ros.receive.sensor_inbox import SensorInbox
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.run import preflight
from mrs_simulator.study.search.margin_checks import (
    margin_checks,
    read_margins,
    read_measured,
    scenario_check,
)
from mrs_simulator.vehicles import Team

LISTENING = 2.0  # [s] of wall time in which silences are measured
NAP = 0.02  # [s] of wall time
FLUSH = 0.1  # [s] of wall time for the last diagnostics to leave
INTERRUPTED = 130  # exit code
ARGUMENTS = dict(
    RUN_ARGUMENTS,
    json="file for the checks as JSON, beside the table",
    margins="of the scenario, what mrs-simulator margins wrote: a directory",
    measured="compare.json of a run of these robots, from report --compare, for the margins",
)


class Preflight:
    """Subscribes to every robot and checks what it receives."""

    def __init__(self, scenario, margins=None, measured=None, stated=None):
        """Take the bounds from the same parameters as the control node.

        ``margins``: the report of the scenario's, None without; ``measured``: values by key;
        ``stated``: the scenario that margins are of, as its file has it.
        """
        self._margins, self._measured, self._stated = margins, measured or {}, stated
        self.scenario, self._found = scenario, None
        self.fence = checked_fence(read(GEOFENCE))
        self.least = read(LEAST_DISTANCE)
        self.tolerance = read(PLACE_TOLERANCE)
        self.time_limit = read(TIME_LIMIT)
        self.slowed, self.speeds = slower(scenario), top_speeds(scenario.n)
        self.frame = make_common_frame(scenario)
        self.asked, self.sensors = (), None  # names of the sensors that the law asks for
        with contextlib.suppress(ValueError):  # the prediction reports a law that cannot be made
            self.asked = make_control(self.slowed).SENSORS
        if scenario.estimates is not None:
            self.asked = tuple(dict.fromkeys((*self.asked, *scenario.estimates.asked)))
        if self.asked:
            team = Team.from_scenario(scenario)
            mounts = fitted_mounts(team, scenario.sensors)
            known = self.asked, mounts, team.kinds, real_among(scenario.n), scenario.step
            self.sensors = SensorInbox(*known)

    def run(self):
        """Return a list of ``Check``, once all has been listened to; also on ``/diagnostics``."""
        diagnostics = Diagnostics(self._health)
        self._found = self._checks()
        diagnostics.publish()
        time.sleep(FLUSH)
        return self._found

    def _health(self):
        silent = self.frame.inbox.stale(rospy.get_time(), self.frame.odom_timeout)
        return [preflight_health(self._found, silent)]

    def _checks(self):
        ages = self._listen()
        frame, numbers = self.frame, self.frame.numbers
        checks = preflight.reception_checks(numbers, ages, frame.odom_timeout, frame.inbox.names())
        trouble = frame.missing(rospy.get_time())
        if self.sensors is not None:
            missing = self.sensors.missing(rospy.get_time())
            checks.append(preflight.sensor_check(self.asked, missing))
        pose = frame.pose()
        if trouble and np.isfinite(ages).all():
            checks.append(preflight.Check("poses", False, trouble))
        for row, jump in sorted(frame.jumped().items()):
            subject = "robot{} stands still".format(numbers[row])
            checks.append(preflight.Check(subject, False, frame.WHAT + " " + jump))
        if frame.ABSOLUTE:
            checks += preflight.place_checks(numbers, pose, self.scenario.poses, self.tolerance)
        places = frame.with_heights(pose)
        checks.append(preflight.distance_check(numbers, places, self.least))
        if self.fence is not None:
            checks.append(preflight.fence_check(numbers, pose, self.fence))
        checks.append(preflight.speed_check(self.scenario, self.speeds))
        checks += self._stopping(places)
        checks += self._within_margins(ages)
        return checks + preflight.predicted_checks(self.slowed, pose, self.least, self.fence)

    def _within_margins(self, ages):
        """Return whether rates, and what was measured before, lie within the scenario's margins."""
        if self._margins is None:
            return []
        # Commands go by the odometry received last, at no higher a rate than that.
        rates = [min(self.scenario.control.rate, 1.0 / max(age, NAP)) for age in ages]
        known = {"control.rate": rates, **self._measured}
        stated = self._stated
        own = scenario_check(self._margins, stated, slower(stated).limits)
        return [own, *margin_checks(self._margins, known)]

    def _stopping(self, places):
        team = stopping_team(self.scenario)
        top = Team.from_scenario(self.slowed).speeds[:, 0].max()
        hold = going_on(self.scenario, team, 1.0 / self.scenario.control.rate)
        # Without it the control node has no bound.
        least = self.least if is_given(LEAST_DISTANCE) else 0.0
        return preflight.stopping_check(team, hold, float(top), places, least, self.fence)

    def _listen(self):
        """Return the longest silence of each robot, (n,) [s], ``inf`` where never received."""
        end = time.monotonic() + self.time_limit
        while time.monotonic() < end and self._silent(rospy.get_time()):
            self._nap()
        ages = np.zeros(self.scenario.n)
        end = time.monotonic() + LISTENING
        while time.monotonic() < end:
            silent = self.frame.inbox.stale(rospy.get_time(), -np.inf)
            ages = np.maximum(ages, [silent.get(number, 0.0) for number in self.frame.numbers])
            self._nap()
        # One that was first received while the others were measured is late, not lost.
        late = np.isfinite(self.frame.inbox.pose()).all(axis=1) & np.isinf(ages)
        return np.where(late, LISTENING, ages)

    def _silent(self, now):
        return bool(self.frame.missing(now) or (self.sensors and self.sensors.missing(now)))

    @staticmethod
    def _nap():
        time.sleep(NAP)
        if rospy.is_shutdown():
            sys.exit(INTERRUPTED)


def _stated(arguments):
    """Return the scenario that ``arguments`` name, without what they say of robots' odometry and limits."""
    kept = {key: getattr(arguments, key) for key in ("scenario", "protocol", "robots")}
    return scenario_from(argparse.Namespace(**kept))


def _checked(scenario, *margins):
    """Return the checks, and forget the parameters, which would else hold for the next time too."""
    try:
        return Preflight(scenario, *margins).run()
    finally:
        with contextlib.suppress(KeyError):
            rospy.delete_param(rospy.get_name())


@printing
def main(argv=None):
    """Run the command ``preflight``; exits with 0 all OK, 1 something is not, 2 bad input."""
    argv = sys.argv[1:] if argv is None else argv
    with refusing_bad_input("preflight"):
        text = "Check that the robots stand ready; parameters as those of pioneer_control."
        arguments = parse(text, ARGUMENTS, argv, "preflight")
        scenario = scenario_from(arguments)
        margins = read_margins(arguments.margins) if arguments.margins else None
        measured = read_measured(arguments.measured) if arguments.measured else None
        if not rosgraph.is_master_online():
            raise OSError("no ROS master at {}".format(os.environ.get("ROS_MASTER_URI", "")))
        # rospy's, which some systems show among the lines of the table
        logging.disable(logging.INFO)
        start_node("preflight")
        checks = _checked(scenario, margins, measured, _stated(arguments))
        if arguments.json:
            write_text(arguments.json, json.dumps(preflight.as_rows(checks), indent=1))
    wrong = sum(not check.passed for check in checks)
    print(preflight.table(checks))
    print("{} of {} not OK".format(wrong, len(checks)) if wrong else "ready")
    rospy.signal_shutdown("done")
    sys.exit(1 if wrong else 0)
