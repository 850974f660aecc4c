"""``/diagnostics`` of the nodes: activity, rates, lateness and faults."""

import math
import threading
import time
from collections import deque
from typing import NamedTuple

import rospy

from mrs_simulator.core.fields import counted
from mrs_simulator.ros.message_forms.defined_types import (
    DiagnosticArray,
    DiagnosticStatus,
    KeyValue,
)

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
PERIOD = 1.0  # [s] of wall time
LOOKS = 5  # [-] looks that a rate is of
KEPT = 0.9  # [-] of a rate that counts as kept
MOST_MISSED = 0.05  # [-] of command periods, from which on a run is not judged


class Health(NamedTuple):
    """How one part of a node is."""

    part: str  # "" for the node itself
    level: int  # OK, WARN or ERROR
    message: str
    values: dict  # plain values by name


class Diagnostics:
    """Publishes once a second what ``report()`` returns, a list of ``Health``, while there is a subscriber.

    It has a thread of its own: a node whose main loop hangs repeats its last report.
    """

    def __init__(self, report):
        self._report, self._name = report, rospy.get_name().lstrip("/")
        self._publisher = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=10)
        threading.Thread(target=self._run, daemon=True).start()

    def publish(self):
        """Publish now, if there is a subscriber."""
        if self._publisher.get_num_connections():
            self._publisher.publish(array(self._name, self._report()))

    def _run(self):
        while not rospy.is_shutdown():
            time.sleep(PERIOD)
            try:
                self.publish()
            except rospy.ROSException:  # the node ends
                return
            except Exception as error:  # an error in a report never ends the node
                rospy.logerr_throttle(
                    60.0, "diagnostics: {}: {}".format(type(error).__name__, error)
                )


def array(name, parts):
    """Return the ``DiagnosticArray`` of a node called ``name`` with ``parts``, ``Health`` each."""
    message = DiagnosticArray()
    message.header.stamp = rospy.get_rostime()
    message.status = [
        DiagnosticStatus(
            level=each.level,
            name="{}: {}".format(name, each.part) if each.part else name,
            message=each.message,
            hardware_id=name,
            values=[KeyValue(key, _text(value)) for key, value in each.values.items()],
        )
        for each in parts
    ]
    return message


def _text(value):
    return "{:.6g}".format(value) if isinstance(value, float) else str(value)


class Rates:
    """Turns counts that grow into rates over the last few looks, in 1/s of its clock."""

    def __init__(self, clock=time.monotonic):
        self._clock, self._looks = clock, deque(maxlen=LOOKS + 1)
        self.window = 0.0  # [s] that the last answer is of

    def of(self, counts):
        """Return the rates of ``counts``, whole numbers by name; 0 at the first look."""
        now = self._clock()
        self._looks.append((now, dict(counts)))
        begun, before = self._looks[0]
        self.window = max(0.0, now - begun)
        rate = 1.0 / self.window if self.window else 0.0
        return {key: rate * (count - before.get(key, 0)) for key, count in counts.items()}


def stage_health(facts):
    """Return the ``Health`` of a stage with the ``facts`` of its status, fields by name."""
    level, message = OK, "paused" if facts["paused"] else "running"
    speed, factor = facts["speed"], facts["real_time_factor"]
    missed = facts["missed_periods"] / max(1, facts["command_periods"])
    if facts["waiting_for"]:
        message = "waits for commands to " + counted(len(facts["waiting_for"]), "robot")
    elif speed and factor < KEPT * speed and not facts["paused"]:
        level, message = WARN, "simulated time at {:.2f}, wanted {:g}".format(factor, speed)
    elif missed > MOST_MISSED:
        level, message = WARN, "{:.0%} of command periods without a command".format(missed)
    elif facts["timed_out"]:
        level, message = WARN, counted(len(facts["timed_out"]), "robot") + " without commands stand"
    elif facts["real_silent"]:
        level, message = WARN, "{} real robots are silent".format(len(facts["real_silent"]))
    if facts["trouble"]:
        level, message = ERROR, facts["trouble"]
    names = (
        "robots",
        "speed",
        "real_time_factor",
        "missed_periods",
        "command_periods",
        "collisions",
    )
    values = {name: facts[name] for name in names}
    values["refused_commands"] = sum(facts["refused"])
    return Health("", level, message, values)


def control_health(facts):
    """Return the ``Health`` of a control node with the ``facts`` of its status, fields by name."""
    level, message = OK, "running"
    if facts["trouble"]:
        level, message = ERROR if facts["running"] else WARN, facts["trouble"]
    elif not facts["running"]:
        level, message = WARN, "not started"
    elif facts["stopped"]:
        level, message = ERROR, "stopped: robots {}".format(list(facts["stopped"]))
    elif facts["warnings"]:
        level, message = WARN, facts["warnings"][0]
    names = "protocol", "period", "compute_time", "latency", "missed_periods"
    values = {name: facts[name] for name in names}
    return Health("", level, message, dict(values, refused_messages=sum(facts["refused"])))


def preflight_health(checks, silent):
    """Return the ``Health`` of a preflight with its ``checks``, None while it listens.

    ``silent``: numbers of the robots from which nothing comes.
    """
    values = {"silent_robots": len(silent)}
    if checks is None:
        return Health("", OK, "listening", values)
    wrong = [check for check in checks if not check.passed]
    values.update(("not OK {}".format(k + 1), check.subject) for k, check in enumerate(wrong))
    values["checks"] = len(checks)
    message = "{} of {} checks not OK".format(len(wrong), len(checks)) if wrong else "ready"
    return Health("", ERROR if wrong else OK, message, values)


def too_slow(received, wanted, window):
    """Return the texts on what is ``received`` at less than its ``wanted`` rate, [Hz] by name.

    Over ``window`` [s]; one message more or less does not count.
    """
    text = "{}: {:.3g} Hz, wanted {:.3g}"
    one = 1.0 / window if window >= PERIOD else math.inf
    return [
        text.format(name, rate, wanted[name])
        for name, rate in received.items()
        if rate + one < KEPT * wanted[name]
    ]


def sensors_health(rates, slow):
    """Return the ``Health`` of sensors, ``rates`` by name [Hz of wall time], and texts on ``slow`` ones."""
    values = {name + " [Hz]": rate for name, rate in rates.items()}
    values.update(("slow {}".format(k + 1), text) for k, text in enumerate(slow))
    message = slow[0] if slow else "{} in use".format(len(rates))
    return Health("sensors", WARN if slow else OK, message, values)
