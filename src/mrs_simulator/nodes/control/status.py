"""The status, the scenario in force and the diagnostics of a control node."""

import math
import time

import rospy

from mrs_simulator.nodes.control.guards import top_speeds
from mrs_simulator.protocols.loading import from_anywhere
from mrs_simulator.record.run_changes import SPEEDS, TOP_SPEEDS, controller_settings
from mrs_simulator.ros.message_forms.messages import (
    ControlScenario,
    ControlStatus,
    control_scenario,
    control_status,
)
from mrs_simulator.ros.node.diagnostics import Rates, control_health, sensors_health, too_slow

STATUS_PERIOD = 0.5  # [s] of wall time


class StatusPublisher:
    """Publishes ``~status``: every half second, and at once when the robots start, stop or recover."""

    def __init__(self, axes):
        """``axes``: those of the team's commands."""
        self._axes = axes
        self._publisher = rospy.Publisher("~status", ControlStatus, queue_size=1, latch=True)
        self._last, self._reported = 0.0, None
        self.facts = None  # the fields of the last status by name, None before the first

    def is_due(self, running, trouble):
        """Return whether a status is to be published now; if so, it counts as published."""
        reported = (running, bool(trouble))
        if time.monotonic() - self._last < STATUS_PERIOD and reported == self._reported:
            return False
        self._last, self._reported = time.monotonic(), reported
        return True

    def publish(self, facts, command, edges, targets):
        """Publish ``facts``, fields by name, with the ``command`` (n, a) and the graph's ``edges``.

        ``targets`` (n, d) [m]: where the points are wanted, or None.
        """
        self.facts = facts
        message = control_status(command, self._axes, edges, targets, **facts)
        message.header.stamp = rospy.get_rostime()
        self._publisher.publish(message)


class ControlHealth:
    """How the control and what it receives are, for ``/diagnostics``."""

    def __init__(self, status, inbox, sensors, estimates):
        """``status``: a ``StatusPublisher``; ``sensors`` and ``estimates``: None where there are none."""
        self._status, self._inbox = status, inbox
        self._sensors, self._estimates = sensors, estimates
        self._rates, self._sensor_rates = Rates(), Rates(rospy.get_time)

    def report(self, sent):
        """Return a list of ``Health``, empty before the first status; ``sent``: commands so far."""
        if self._status.facts is None:
            return []
        own = control_health(self._status.facts)
        if self._estimates is not None:
            own.values["readings too late for estimates"] = self._estimates.late
        rates = self._rates.of(dict(commands=sent, odometry=self._inbox.accepted))
        own.values.update({"{} [Hz]".format(name): rate for name, rate in rates.items()})
        return [own] if self._sensors is None else [own, self._of_sensors()]

    def _of_sensors(self):
        sensors = self._sensors.rates()
        received = self._sensor_rates.of({topic: count for topic, _, count, _ in sensors})
        late = self._sensors.missing(rospy.get_time())
        wanted = {topic: rate for topic, rate, _, _ in sensors}
        slow = too_slow(received, wanted, self._sensor_rates.window)
        return sensors_health(received, [late] * bool(late) + slow)


class ObeyedPublisher:
    """Publishes ``~scenario``, latched: what the commands follow from, whenever that is something else.

    What is set while robots stand is published with the first commands that follow from it.
    """

    def __init__(self, scenario):
        """``scenario``: the control's, with its rate and saturation, before its highest speeds."""
        self._scenario, self._last = from_anywhere(scenario), None
        speeds = zip(SPEEDS, top_speeds(scenario.n))
        self._speeds = {name: each for name, each in speeds if math.isfinite(each)}
        self._publisher = rospy.Publisher("~scenario", ControlScenario, queue_size=10, latch=True)

    def note(self, law, now, begins):
        """Take in that commands at ``now`` [s] followed from ``law``, which ``begins`` with them or not."""
        obeyed = law.parameters, law.other_topology
        if not begins and obeyed == self._last:
            return
        self._last = obeyed
        parameters, topology = obeyed
        control = self._scenario.control._replace(parameters=parameters)
        scenario = self._scenario._replace(control=control)
        if topology is not None:
            scenario = scenario._replace(topology=topology)
        speeds = {TOP_SPEEDS: self._speeds} if self._speeds else {}
        message = control_scenario({**controller_settings(scenario), **speeds})
        message.header.stamp = rospy.Time(0, int(round(1e9 * now)))
        self._publisher.publish(message)
