"""Newest reading of each sensor that a law asks for: written by subscriber threads, read by the loop."""

import functools
import math
import threading
import time
from collections import deque

import rospy

from mrs_simulator.core.step_rates import steps_between
from mrs_simulator.ros.message_forms.messages import MessageError
from mrs_simulator.ros.message_forms.sensor_messages import (
    listen,
    listened_topic,
    others_of,
    parts_of,
    stamp_of,
)
from mrs_simulator.ros.node.node_parameters import SENSOR_TIMEOUT, SENSOR_TOPIC
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.ros.node.senders import Senders
from mrs_simulator.ros.receive.intake import Intake
from mrs_simulator.ros.receive.odometry_inbox import MOST_NAMED, clock_at, silence
from mrs_simulator.sensors.readings import frozen
from mrs_simulator.sensors.types import TYPES

MISSED = 2.5  # [-] periods of a sensor after which its reading is stale, where that is longer
MOST_KEPT = 200  # [-] readings of a sensor that wait to be taken
CLOSE = 1e-6  # [s] within which times are equal
UNKNOWN = "unknown"  # publisher of a connection of rospy's that is not made yet
PARTS_KEPT = 4  # [-] newest of each part of a reading, until the others of its time are there


class SensorInbox:
    """Subscribes to the sensors ``names`` of every robot, and finds which are stale."""

    def __init__(self, names, mounts, kinds, real=(), step=0.0, wake=lambda: None, kept=()):
        """``mounts``, ``kinds``: of each robot, a tuple of its ``Mount`` and its ``Kind``.

        ``real``: rows of the real robots; ``step`` [s] of the world of the others; ``wake()`` is called
        whenever a reading has come; ``kept``: names of sensors whose readings are kept until ``take``.
        Raises ``ValueError`` for an impossible ``~sensor_topic``.
        """
        pattern, self._least = read(SENSOR_TOPIC), read(SENSOR_TIMEOUT)
        self._wake, self._lock, self._senders = wake, threading.Lock(), Senders()
        self._cached = None  # the last answer of ``readings``
        self._kept, self._waiting = frozenset(kept), []
        self._inlets = [
            self._inlet(row, next(mount for mount in own if mount.name == name), kind, real, step)
            for name in names
            for row, (own, kind) in enumerate(zip(mounts, kinds))
        ]
        self._rows = range(len(mounts))
        self._subscribers = {inlet: self._subscribed(inlet, pattern) for inlet in self._inlets}

    def _inlet(self, row, mount, kind, real, step):
        is_real = row in real
        period = 1.0 / mount.rate if is_real else steps_between(mount.rate, step) * step
        return _Inlet(row, mount, kind, is_real, period, self._least)

    def _subscribed(self, inlet, pattern):
        forms = {}  # by topic
        for part, form in enumerate(inlet.all_forms):
            name = listened_topic(pattern, inlet.row + 1, form)
            inlet.topics[part] = rospy.resolve_name(name)
            forms.setdefault(name, []).append(form)
        most = MOST_KEPT if inlet.form.mount.name in self._kept else 1
        take = functools.partial(self._take, inlet)
        refuse = functools.partial(self._refuse, inlet)
        options = dict(queue_size=most, tcp_nodelay=True)
        return [listen(name, own, take, refuse, **options) for name, own in forms.items()]

    def _take(self, inlet, message, form):
        self.put(message, inlet, inlet.all_forms.index(form))

    def _refuse(self, inlet, form, why):
        with self._lock:
            inlet.intake.refuse(inlet.all_forms.index(form), why)

    def put(self, message, inlet, part=0):
        """Take in a message of one sensor; what cannot be now, or is not the mount's, is refused.

        ``part``: which of the ``inlet``'s forms it is.
        """
        stamp = stamp_of(message)
        seconds = stamp.to_sec()
        now = rospy.get_time() if inlet.is_real else clock_at(seconds, inlet.timeout)
        arrival = time.monotonic()
        with self._lock:
            self._senders.note(inlet.topics[part], message)
            stamped = hasattr(message, "header")  # others count as of now: they have no clock
            if stamped and not inlet.intake.accepts_stamp(part, seconds, now, arrival):
                return
        try:
            reading = inlet.all_forms[part].reading(message, seconds)
        except MessageError as error:
            with self._lock:
                inlet.intake.refuse(part, str(error))
            return
        with self._lock:
            stamp, reading = inlet.completed(part, stamp, reading)
            if reading is None:
                return
            frozen(reading)
            seconds = stamp.to_sec()
            if inlet.is_real and abs(now - seconds) > inlet.timeout:
                stamp = rospy.Time.from_sec(now)  # its clock is another
            known = inlet.keep(
                reading, stamp.to_nsec(), arrival if inlet.is_real else min(now, seconds)
            )
            if not known and inlet.form.mount.name in self._kept:
                del self._waiting[: -MOST_KEPT * len(self._inlets)]
                self._waiting.append((stamp.to_nsec(), inlet, reading))
        self._wake()

    def readings(self, begun):
        """Return the newest readings, ``{row: {name: reading}}``; their stamps are since ``begun`` [s].

        It is the same mapping as before while nothing new has come.
        """
        with self._lock:
            newest = [inlet.newest for inlet in self._inlets]
        cached = self._cached
        if (
            cached is None
            or cached[0] != begun
            or any(a is not b for a, b in zip(newest, cached[1]))
        ):
            result, origin = {row: {} for row in self._rows}, int(round(begun * 1e9))
            for inlet, kept in zip(self._inlets, newest):
                if kept is not None:
                    reading, stamp = kept
                    since = (stamp - origin) * 1e-9
                    result[inlet.row][inlet.form.mount.name] = reading._replace(stamp=since)
            self._cached = cached = begun, newest, result
        return cached[2]

    def take(self):
        """Return the readings that have come since the last call of the sensors that are ``kept``.

        ``[(stamp, name, [(row, reading)])]`` with stamps in ns, by ROS time.
        """
        with self._lock:
            taken, self._waiting = self._waiting, []
        found = {}
        for stamp, inlet, reading in taken:
            found.setdefault((stamp, inlet.form.mount.name), []).append((inlet.row, reading))
        return [(stamp, name, sorted(rows, key=_row)) for (stamp, name), rows in found.items()]

    def missing(self, now):
        """Return which sensors are silent or refused at ``now`` [s] in ROS time, in words, or ""."""
        with self._lock:
            late = [(inlet, inlet.age(now)) for inlet in self._inlets]
        return self._silence_text([(i, age) for i, age in late if not age <= i.timeout])

    def unconnected(self):
        """Return which sensors have no publisher yet, in words, or ""."""
        apart = [i for i, own in self._subscribers.items() if not all(map(is_connected, own))]
        with self._lock:
            return self._silence_text([(inlet, inlet.age(0.0)) for inlet in apart])

    def awaited(self, stamp, begun):
        """Return what is still to come of what was measured up to ``stamp`` [s], in words, or "".

        For a simulation in lockstep, whose law began at ``begun`` [s].
        """
        if not self._inlets:
            return ""
        with self._lock:
            late = [inlet for inlet in self._inlets if inlet.is_awaited(stamp, begun)]
            return self._silence_text([(inlet, inlet.age(stamp)) for inlet in late])

    def _silence_text(self, late):
        texts = []
        for name in dict.fromkeys(inlet.form.mount.name for inlet, _ in late):
            own = [(inlet, age) for inlet, age in late if inlet.form.mount.name == name]
            reasons = {
                i.row + 1: min(i.intake.reasons.items())[1] for i, _ in own if i.intake.reasons
            }
            texts.append(silence({i.row + 1: age for i, age in own}, name, reasons))
        lacking = [topic for inlet, _ in late for topic in inlet.lacking]
        if lacking:
            texts.append("nothing came on " + ", ".join(lacking[:MOST_NAMED]))
        return "; ".join(texts)

    def stale(self, now):
        """Return the rows of the robots of which a reading is stale."""
        with self._lock:
            return sorted({i.row for i in self._inlets if not i.age(now) <= i.timeout})

    def rates(self):
        """Return ``(topic, rate wanted, messages so far, refused so far)`` of each sensor; rates in Hz."""
        with self._lock:
            return [
                (i.topics[0], 1.0 / i.period, i.count, sum(i.intake.refused)) for i in self._inlets
            ]

    def doubled(self):
        """Return ``{topic: [nodes]}`` of the topics on which several nodes publish."""
        return self._senders.doubled()

    def forget(self):
        """Learn the clocks of real robots anew: a person has said that they are right."""
        with self._lock:
            for inlet in self._inlets:
                inlet.intake.forget()


def is_connected(subscriber):
    """Return whether a publisher has accepted the ``subscriber``; rospy counts it before that."""
    connections = subscriber.impl.connections
    return any(getattr(each, "callerid_pub", UNKNOWN) != UNKNOWN for each in connections)


def _row(item):
    return item[0]


def _gap_to(stamp):
    return lambda other: abs((other[0] - stamp).to_sec())


class _Inlet:
    """What has come of one sensor of one robot."""

    def __init__(self, row, mount, kind, is_real, period, least):
        self.row, self.is_real, self.period = row, is_real, period
        self.forms = parts_of(mount, kind)
        self.all_forms = self.forms + (others_of(mount, kind) if is_real else [])
        self.form, self.topics = self.forms[0], [""] * len(self.all_forms)
        self.timeout = mount.latency + max(least, MISSED * period)
        self.intake = Intake([is_real] * len(self.all_forms), self.timeout)
        self._parts = [deque(maxlen=PARTS_KEPT) for _ in self.forms]
        self._joined = None  # what other forms have provided so far
        self._apart = 0.5 * period if is_real else CLOSE  # [s] that parts of a reading may be
        self.newest, self.count, self._received = None, 0, -math.inf
        self._is_late = self._is_put_off = False  # of the next sample, in lockstep
        looks_back = TYPES[mount.type].LOOKS_BACK
        self._first = mount.latency + (period if looks_back else 0.0)  # [s] since it is listened to

    def completed(self, part, stamp, reading):
        """Return stamp and reading that the ``reading`` of a ``part`` completes, None where others lack.

        Of real robots' drivers, whose parts may bear other stamps, the nearest in time belong together.
        """
        if part >= len(self.forms):
            form = self.all_forms[part]
            self._joined = form.joined(reading, self._joined)
            return stamp, self._joined if form.SUFFICES else None
        if len(self.forms) == 1:
            return stamp, reading
        own = self._parts[part]
        if own and stamp < own[0][0]:  # time began anew
            for each in self._parts:
                each.clear()
        own.appendleft((stamp, reading))
        for begun, whole in self._parts[0]:
            others = [min(each, key=_gap_to(begun), default=None) for each in self._parts[1:]]
            if all(each and abs((each[0] - begun).to_sec()) <= self._apart for each in others):
                if reading is not (whole if part == 0 else others[part - 1][1]):
                    break  # it was complete without this one
                filled = zip(self.forms[1:], others)
                fields = {
                    name: getattr(of, name) for form, (_, of) in filled for name in form.FILLS
                }
                return begun, whole._replace(**fields)
        return stamp, None

    @property
    def lacking(self):
        """Return the topics on which nothing came, while something did on others of the sensor."""
        empty = [not own for own in self._parts] if len(self.forms) > 1 else [False]
        return [] if all(empty) else [t for t, is_empty in zip(self.topics, empty) if is_empty]

    def keep(self, reading, stamp, received):
        """Keep a ``reading`` of ``stamp`` [ns], received at a time [s]: of wall time from a real robot.

        Return whether it was known before: a new subscriber receives the newest again.
        """
        known = self.newest is not None and self.newest[1] == stamp
        self.newest, self._received = (reading, stamp), received
        # What is repeated while more is waited for is all that there is.
        self._is_put_off = known and (self._is_late or self._is_put_off)
        self._is_late = False
        self.count += 1
        return known

    def age(self, now):
        """Return how old the newest is at ``now`` [s] in ROS time, inf before the first."""
        if self.newest is None:
            return math.inf
        return (time.monotonic() if self.is_real else now) - self._received

    def is_awaited(self, stamp, begun):
        """Return whether a sample up to ``stamp`` [s] is still to come.

        None is if the newest was repeated since: a reset has put off the next.
        """
        if self.newest is None:
            return stamp - begun + CLOSE >= self._first
        following = self.newest[1] * 1e-9 + self.period + self.form.mount.latency
        self._is_late = following <= stamp + CLOSE and not self._is_put_off
        return self._is_late
