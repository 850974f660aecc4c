"""Sensors of the robots over ROS, each subscribed to only while somebody looks at it."""

import math
import threading
import time
from collections import deque

import rospy

from mrs_simulator.ros.message_forms.messages import MessageError
from mrs_simulator.ros.message_forms.sensor_messages import forms_of, others_of, stamp_of
from mrs_simulator.rqt_plugin.sensing.received import Heard

PROMPT = dict(queue_size=1, tcp_nodelay=True)
COUNTED = 20  # [-] messages over which a rate is taken


class SensorsConnection:
    """``watch`` says which sensors are looked at; ``follow`` and ``close`` are for one thread alone."""

    def __init__(self):
        self._lock = threading.Lock()
        self._wanted = {}  # (Mount, Kind, index of its form) by (number, name)
        self._ears = {}  # _Ear by (number, name)
        self.changed = threading.Event()  # set when others are looked at than before

    def watch(self, wanted):
        """Look at the sensors ``wanted`` and no others, ``{(number, name): (Mount, Kind)}``.

        A third number, by default 0, says which of ``forms_of`` a mount is listened to.
        """
        wanted = {key: (*of, 0) if len(of) == 2 else of for key, of in wanted.items()}
        with self._lock:
            if wanted != self._wanted:
                self._wanted = dict(wanted)
                self.changed.set()

    @property
    def is_idle(self):
        """Return whether nothing is looked at, and nothing subscribed to."""
        with self._lock:
            return not self._wanted and not self._ears

    def follow(self, published, subscribed, kinds, controllers):
        """Subscribe to what is looked at, as far as somebody publishes it; leave everything else.

        ``published``, ``subscribed``: the nodes by topic; ``kinds`` of message by topic; ``controllers``:
        names of these nodes, None for none.
        """
        with self._lock:
            wanted, ears = dict(self._wanted), dict(self._ears)
        for key, ear in list(ears.items()):
            if wanted.get(key) != ear.of:
                ear.close()
                del ears[key]
        for key, of in wanted.items():
            if key not in ears:
                ears[key] = _Ear(*of)
            told = published, subscribed, kinds, controllers
            ears[key].listen(_topics_of(key[0], ears[key], told))
        with self._lock:
            self._ears = ears

    def heard(self, now, real=()):
        """Return the ``Heard`` of what is looked at, ``{(number, name): Heard}``.

        ``now`` [s] of simulated time, None without a simulation; ``real``: numbers of the real robots.
        """
        with self._lock:
            wanted, ears = set(self._wanted), dict(self._ears)
        none = Heard()
        return {
            key: ears[key].told(None if key[0] in real else now) if key in ears else none
            for key in wanted
        }

    def subscribers(self):
        """Return the subscribers."""
        with self._lock:
            return [each for ear in self._ears.values() for each in ear.subscribers]

    def close(self):
        """Leave all topics."""
        with self._lock:
            ears, self._ears, self._wanted = self._ears, {}, {}
        for ear in ears.values():
            ear.close()


def _topics_of(number, ear, told):
    """Return ``{topic: form}`` of what tells the sensor of ``ear``: its own form, or those of drivers."""
    for forms in [ear.form], ear.others:
        topics = {topic_in(number, form, *told): form for form in forms}
        topics.pop("", None)
        if any(form.SUFFICES for form in topics.values()):
            return topics
    return {}


def topic_in(number, form, published, subscribed, kinds, controllers=None):
    """Return the topic on which the sensor of ``form`` of the robot ``number`` is told, "" if none is.

    It is of the form's type, below ``/robotN/``, and ends in the sensor's name, as in
    ``/robot1/RosAria/sonar``; of several that to which the controller listens comes first, then the
    shortest.  One with another name is taken only where the controller listens to it.
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


class _Ear:
    """Listens to one sensor; what is heard is read only when it is asked for."""

    def __init__(self, mount, kind, form=0):
        self.of, self.form = (mount, kind, form), forms_of(mount, kind)[form]
        self.others = others_of(mount, kind) if form == 0 else []
        self._ears, self._lock = {}, threading.Lock()  # form and subscriber, by topic
        self._newest, self._times = None, deque(maxlen=COUNTED)
        self._parts = {}  # the newest message of each of several forms, and its stamp
        self._counted = None  # the form whose rate is told
        self._read = None, Heard()  # the message that was read last, and what it says

    @property
    def subscribers(self):
        """Return the subscribers."""
        return [subscriber for _, subscriber in self._ears.values()]

    @property
    def _topic(self):
        return next(iter(self._ears), "")

    def listen(self, topics):
        """Listen to ``topics``, ``{topic: form}``."""
        if {topic: form for topic, (form, _) in self._ears.items()} == topics:
            return
        self.close()
        self._ears = {
            topic: (form, rospy.Subscriber(topic, form.MESSAGE, self._keep, form, **PROMPT))
            for topic, form in topics.items()
        }

    def _keep(self, message, form):
        stamp = stamp_of(message).to_sec()
        with self._lock:
            if self._times and stamp < self._times[-1]:  # another run
                self._times.clear()
            if form is self._counted:  # the first is what a new listener gets, between two samples
                self._times.append(stamp)
            if form.SUFFICES:
                self._counted = self._counted or form
                self._newest = message, stamp, time.monotonic()
            self._parts[form] = message, stamp

    def told(self, now):
        """Return the ``Heard`` at ``now`` [s], None: of a real robot, by wall time."""
        with self._lock:
            newest, times = self._newest, list(self._times)
        if newest is None:
            return Heard(topic=self._topic)
        message, stamp, received = newest
        if self._read[0] is not message:
            self._read = message, self._taken(stamp)
        age = time.monotonic() - received if now is None else max(0.0, now - stamp)
        return self._read[1]._replace(age=age, rate=_rate(times))

    def _taken(self, stamp):
        """Return the ``Heard`` of the newest messages."""
        with self._lock:
            parts = list(self._parts.items())
        reading = None
        try:
            for form, (message, _) in sorted(parts, key=lambda part: part[1][1]):
                reading = form.joined(form.reading(message, stamp), reading)
        except MessageError as error:
            return Heard(topic=self._topic, trouble=str(error))
        return Heard(reading, topic=self._topic)

    def close(self):
        """Listen no more."""
        for subscriber in self.subscribers:
            subscriber.unregister()
        with self._lock:
            self._ears, self._parts = {}, {}
            self._newest = self._counted = None
            self._times.clear()


def _rate(times):
    span = times[-1] - times[0] if times else 0.0
    return (len(times) - 1) / span if span > 0.0 else math.nan
