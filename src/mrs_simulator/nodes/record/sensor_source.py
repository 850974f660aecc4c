"""Readings of robots' sensors as they come over ROS, written beside the run."""

import functools
import math
import threading
import time
from collections import deque

import rospy

from mrs_simulator.ros.message_forms.messages import MessageError
from mrs_simulator.ros.message_forms.sensor_messages import (
    forms_of,
    listen,
    listened_topic,
    others_of,
)
from mrs_simulator.ros.node.node_parameters import SENSOR_TOPIC
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.ros.receive.withdrawal import withdraw
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.study.run.sensor_files import SensorFiles, lines_of, recorded_sensors
from mrs_simulator.study.run.sensor_sizes import with_sizes
from mrs_simulator.vehicles import Team

CONNECTED, NAP = 2.0, 0.02  # [s] of wall time
KEPT = 4  # [-] newest messages of each sensor before the run begins
REFUSED = 5.0  # [s] of wall time between two reports of messages that cannot be read
ROUNDING = 2e-9  # [s] by which the difference of two stamps may be wrong


def recorded_of(scenario):
    """Return the ``Recorded`` of ``scenario``, and ``{(name, number): form}`` of what is listened to."""
    team = Team.from_scenario(scenario)
    mounts = fitted_mounts(team, scenario.sensors)
    sensors = recorded_sensors(scenario.record, mounts, team.kinds)
    forms = {
        (mount.name, row + 1): forms_of(mount, team.kinds[row])[0]
        for row, own in enumerate(mounts)
        for mount in own
        if mount.name in scenario.record
    }
    return sensors, forms


class SensorSource:
    """Listens to the sensors that a scenario's ``record`` names; real robots' by the time of arrival."""

    def __init__(self, scenario, out, report):
        """Write to the directory ``out``; ``report`` is called with a text on each file's size."""
        sensors, forms = recorded_of(scenario)
        known = scenario, Team.from_scenario(scenario), obstacles_of(scenario), lines_of
        for each in with_sizes(sensors, *known):
            report(each.summary(scenario.duration))
        self._files = SensorFiles(sensors, out)
        pictures = {each.name for each in sensors if not each.columns}
        forms = {key: form for key, form in forms.items() if key[0] not in pictures}
        self._duration, self._simulated = scenario.duration, rospy.get_param("/use_sim_time", False)
        self._start, self._lock = None, threading.Lock()
        self._early = {key: deque(maxlen=KEPT) for key in forms}
        self._last = {}  # stamp [s] by sensor: a new subscriber receives the newest again
        self.count = 0  # readings that were written
        self._joined = {}  # what several messages have provided so far, by sensor
        self._subscribers = {key: self._subscribed(key, form) for key, form in forms.items()}

    def _subscribed(self, key, form):
        """Return the subscribers of the sensor ``key``, name and number, on all its topics."""
        forms, topics = [form], {}
        if not self._simulated:
            forms += others_of(form.mount, form.kind)
        for each in forms:
            topics.setdefault(listened_topic(read(SENSOR_TOPIC), key[1], each), []).append(each)
        take, refuse = functools.partial(self._put, key), functools.partial(self._refuse, key)
        return [listen(name, own, take, refuse, tcp_nodelay=True) for name, own in topics.items()]

    def wait(self, limit=CONNECTED):
        """Wait until every sensor has a publisher, at most ``limit`` [s] of wall time."""
        end = time.monotonic() + limit
        while time.monotonic() < end and not rospy.is_shutdown():
            connected = (any(each.get_num_connections() for each in own) for own in self._all())
            if all(connected):
                return
            time.sleep(NAP)

    def _all(self):
        return self._subscribers.values()

    def begin(self, start):
        """Write what was measured from the time ``start`` [s] on, by the clock of the run."""
        with self._lock:
            self._start = start
            for (name, number), early in self._early.items():
                for stamp, reading in early:
                    self._write(name, number, stamp, reading)
                early.clear()

    def _refuse(self, key, _, why):
        text = "record: {} of robot{} is not recorded: {}".format(*key, why)
        rospy.logerr_throttle(REFUSED, text)

    def _put(self, key, message, form):
        stamp = message.header.stamp.to_sec() if self._simulated else rospy.get_time()
        try:
            reading = form.reading(message, stamp)
        except MessageError as error:
            return self._refuse(key, form, error)
        with self._lock:
            if form.PROVIDES:
                reading = self._joined[key] = form.joined(reading, self._joined.get(key))
                since = stamp - self._last.get(key, -math.inf)
                if not form.SUFFICES or since < 0.5 / form.mount.rate:
                    return None  # several messages make up a reading
            if self._last.get(key) == stamp:
                return None
            self._last[key] = stamp
            if self._start is None:
                self._early[key].append((stamp, reading))
            else:
                self._write(*key, stamp, reading)
        return None

    def _write(self, name, number, stamp, reading):
        since = stamp - self._start
        if self._files is not None and -ROUNDING <= since <= self._duration + ROUNDING:
            self._files.add(name, number, max(0.0, since), reading)
            self.count += 1

    def close(self):
        """Stop to listen, write what waits, and return what is missing, a list of texts."""
        for own in self._all():
            for subscriber in own:
                withdraw(subscriber)
        with self._lock:
            files, self._files = self._files, None
        files.close()
        return files.warnings()
