"""Sensors of the robots over ROS, each subscribed to only while it is shown."""

import math
import threading
import time
from collections import deque

import rospy

from mrs_simulator.ros.message_forms.messages import MessageError
from mrs_simulator.ros.message_forms.sensor_messages import forms_of, others_of, stamp_of
from mrs_simulator.ros.receive.withdrawal import withdraw
from mrs_simulator.rqt_plugin.sensing.readings import ReceivedReading

PROMPT = dict(queue_size=1, tcp_nodelay=True)
COUNTED = 20  # [-] messages over which a rate is taken


class SensorsConnection:
    """``watch`` selects the sensors; ``follow`` and ``close`` are called by one thread only."""

    def __init__(self):
        self._lock = threading.Lock()
        self._wanted = {}  # (Mount, Kind, index of its form) by (number, name)
        self._subscriptions = {}  # SensorSubscription by (number, name)
        self.changed = threading.Event()  # set when the selection changes

    def watch(self, wanted):
        """Select the sensors ``wanted`` and no others, ``{(number, name): (Mount, Kind)}``.

        An optional third item is the index of the message's form in ``forms_of``, by default 0.
        """
        wanted = {key: (*of, 0) if len(of) == 2 else of for key, of in wanted.items()}
        with self._lock:
            if wanted != self._wanted:
                self._wanted = dict(wanted)
                self.changed.set()

    @property
    def is_idle(self):
        """Return whether nothing is selected, and nothing subscribed to."""
        with self._lock:
            return not self._wanted and not self._subscriptions

    def follow(self, published, subscribed, kinds, controllers):
        """Subscribe to the selected sensors that are published; unsubscribe from all others.

        ``published``, ``subscribed``: the nodes by topic; ``kinds`` of message by topic; ``controllers``:
        names of these nodes, None for none.
        """
        with self._lock:
            wanted, subscriptions = dict(self._wanted), dict(self._subscriptions)
        for key, subscription in list(subscriptions.items()):
            if wanted.get(key) != subscription.of:
                subscription.close()
                del subscriptions[key]
        for key, of in wanted.items():
            if key not in subscriptions:
                subscriptions[key] = SensorSubscription(*of)
            nodes = published, subscribed, kinds, controllers
            subscriptions[key].listen(topics_of(key[0], subscriptions[key], nodes))
        with self._lock:
            self._subscriptions = subscriptions

    def readings(self, now, real=()):
        """Return ``{(number, name): ReceivedReading}`` of the selected sensors.

        ``now`` [s] of simulated time, None without a simulation; ``real``: numbers of the real robots.
        """
        with self._lock:
            wanted, subscriptions = set(self._wanted), dict(self._subscriptions)
        none = ReceivedReading()
        return {
            key: subscriptions[key].newest(None if key[0] in real else now)
            if key in subscriptions
            else none
            for key in wanted
        }

    def subscribers(self):
        """Return the subscribers."""
        with self._lock:
            return [
                each
                for subscription in self._subscriptions.values()
                for each in subscription.subscribers
            ]

    def close(self):
        """Unsubscribe from all topics."""
        with self._lock:
            subscriptions, self._subscriptions, self._wanted = self._subscriptions, {}, {}
        for subscription in subscriptions.values():
            subscription.close()


def topics_of(number, subscription, nodes):
    """Return ``{topic: form}`` of a sensor's messages: in the package's own form, or a driver's."""
    for forms in [subscription.form], subscription.others:
        topics = {topic_in(number, form, *nodes): form for form in forms}
        topics.pop("", None)
        if any(form.SUFFICES for form in topics.values()):
            return topics
    return {}


def topic_in(number, form, published, subscribed, kinds, controllers=None):
    """Return the topic that publishes the sensor of ``form`` of the robot ``number``, "" for none.

    It is of the form's type, below ``/robotN/``, and ends in the sensor's name, as in
    ``/robot1/RosAria/sonar``; of several one that the controller subscribes to comes first, then the
    shortest.  One with another name is taken only where the controller subscribes to it.
    """
    own, name = "/robot{}/".format(number), form.mount.name + form.SUFFIX
    followed = set(controllers or ())
    found = []
    for topic in published:
        if topic.startswith(own) and kinds.get(topic) == form.MESSAGE._type:
            is_followed = bool(followed & set(subscribed.get(topic, ())))
            is_named = topic.rpartition("/")[2] == name
            if is_followed or is_named:
                found.append((not is_named, not is_followed, len(topic), topic))
    return min(found)[-1] if found else ""


class SensorSubscription:
    """Subscribers of one sensor; messages are read only on demand."""

    def __init__(self, mount, kind, form=0):
        self.of, self.form = (mount, kind, form), forms_of(mount, kind)[form]
        self.others = others_of(mount, kind) if form == 0 else []
        self._subscriptions, self._lock = {}, threading.Lock()  # form and subscriber, by topic
        self._newest, self._times = None, deque(maxlen=COUNTED)
        self._parts = {}  # the newest message of each of several forms, and its stamp
        self._counted = None  # the form whose rate is measured
        self._read = None, ReceivedReading()  # the message read last, and its reading

    @property
    def subscribers(self):
        """Return the subscribers."""
        return [subscriber for _, subscriber in self._subscriptions.values()]

    @property
    def _topic(self):
        return next(iter(self._subscriptions), "")

    def listen(self, topics):
        """Subscribe to ``topics``, ``{topic: form}``, and to no others."""
        if {topic: form for topic, (form, _) in self._subscriptions.items()} == topics:
            return
        self.close()
        self._subscriptions = {
            topic: (form, rospy.Subscriber(topic, form.MESSAGE, self.on_message, form, **PROMPT))
            for topic, form in topics.items()
        }

    def on_message(self, message, form):
        """Keep a ``message`` in ``form``."""
        stamp = stamp_of(message).to_sec()
        with self._lock:
            if self._times and stamp < self._times[-1]:  # another run
                self._times.clear()
            if form is self._counted:  # a new subscriber gets the last one at once, out of step
                self._times.append(stamp)
            if form.SUFFICES:
                self._counted = self._counted or form
                self._newest = message, stamp, time.monotonic()
            self._parts[form] = message, stamp

    def newest(self, now):
        """Return the ``ReceivedReading`` at ``now`` [s], None: of a real robot, by wall time."""
        with self._lock:
            newest, times = self._newest, list(self._times)
        if newest is None:
            return ReceivedReading(topic=self._topic)
        message, stamp, received = newest
        if self._read[0] is not message:
            self._read = message, self._joined(stamp)
        age = time.monotonic() - received if now is None else max(0.0, now - stamp)
        return self._read[1]._replace(age=age, rate=_rate(times))

    def _joined(self, stamp):
        """Return the ``ReceivedReading`` of the newest messages of all forms."""
        with self._lock:
            parts = list(self._parts.items())
        reading = None
        try:
            for form, (message, _) in sorted(parts, key=lambda part: part[1][1]):
                reading = form.joined(form.reading(message, stamp), reading)
        except MessageError as error:
            return ReceivedReading(topic=self._topic, trouble=str(error))
        return ReceivedReading(reading, topic=self._topic)

    def close(self):
        """Unsubscribe."""
        for subscriber in self.subscribers:
            withdraw(subscriber)
        with self._lock:
            self._subscriptions, self._parts = {}, {}
            self._newest = self._counted = None
            self._times.clear()


def _rate(times):
    span = times[-1] - times[0] if times else 0.0
    return (len(times) - 1) / span if span > 0.0 else math.nan
