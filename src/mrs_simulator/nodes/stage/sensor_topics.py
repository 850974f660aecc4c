"""Topics of the simulated robots' sensors, each read and published only while there is a subscriber."""

import math
import time

import rospy
from std_msgs.msg import Header

from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.nodes.stage.world_topics import stamp_at
from mrs_simulator.ros.message_forms.sensor_forms.form import BASE, OPTICAL, OPTICAL_FRAME, OWN
from mrs_simulator.ros.message_forms.sensor_messages import forms_of, topic_of
from mrs_simulator.ros.nonblocking_publisher import prompt_publisher
from mrs_simulator.sensors.suite import Suite

OWN_TOPICS = ("base_link", "cmd_vel", "motors_state", "odom")  # of a robot, or its frames
KEPT = 0.9  # [-] of its rate that a sensor keeps without a word
LATELY = 5.0  # [s] of wall time
MOST_SHOWN = 8  # [-] texts in one status


class SensorTopics(StagePart, rospy.SubscribeListener):
    """``/robotN/SENSOR`` of every sensor of the simulated robots."""

    def __init__(self, world, frames, absent=()):
        """``frames``: ``robot_topics.Frames``; ``absent``: rows of robots whose sensors are real."""
        self._world, self._frames, self._absent = world, frames, frozenset(absent)
        self._topics = {}  # by name and class of message
        self._of = {}  # lists of them by row and mount
        self._suite = None
        self._changed = False  # whether who listens has changed
        self._published = {}  # reading that was published last, by sensor
        self.counts = {}  # readings that were published so far, by the sensors' names

    def follow_team(self, scenario):
        """Open or withdraw topics, so that every robot of the world has those of its sensors."""
        self._suite = Suite.of_scenario(scenario, *self._world.senses)
        wanted = self._wanted(self._world.team)
        for key in set(self._topics).difference(wanted):
            self._topics.pop(key).close()
        self._of = {}
        for key, (row, form) in wanted.items():
            topic = self._topics[key] = self._topics.get(key) or _Topic(*key, self)
            topic.form, topic.frame = form, self._frame(row, form)
            self._of.setdefault((row, form.mount.name), []).append(topic)
        self._begin()

    def _wanted(self, team):
        """Return ``(row, form)`` by name of the topic and class of message."""
        wanted, forms = {}, {}
        for row, mounts in enumerate(self._suite.mounts):
            for mount in mounts if row not in self._absent else ():
                if mount.name in OWN_TOPICS:
                    text = "robot{}: a sensor called {}, as a topic or frame of the robot's own"
                    raise ValueError(text.format(row + 1, mount.name))
                key = mount, team.kinds[row]
                if key not in forms:
                    forms[key] = forms_of(*key)
                for form in forms[key]:
                    wanted[topic_of(row + 1, form), form.MESSAGE] = row, form
        return wanted

    def _frame(self, row, form):
        own = self._frames.mount(row + 1, form.mount.name)
        known = {OWN: own, OPTICAL: own + OPTICAL_FRAME, BASE: self._frames.base(row + 1)}
        return known.get(form.FRAME, self._frames.world)

    def fixed_frames(self):
        """Return ``(parent, child, place)`` of each mount that publishes in frames of its own.

        ``place``: x, y, z [m] and yaw [rad]; of optical frames x, y, z [m] and the quaternion x, y, z, w.
        """
        found = []
        for (row, name), topics in sorted(self._of.items()):
            form, own = topics[0].form, self._frames.mount(row + 1, name)
            if form.FRAME in (OWN, OPTICAL):
                found.append((self._frames.base(row + 1), own, form.frame))
            if form.FRAME == OPTICAL:
                found.append((own, own + OPTICAL_FRAME, (0.0, 0.0, 0.0, *form.optics)))
        return found

    def begin_run(self):
        """Publish what is known at the world's present step, from which samples are counted."""
        self._begin()
        self.after_step()

    def _begin(self):
        self._suite.begin(self._world.steps)
        self._published, self._changed = {}, True

    # Called by threads of rospy.
    def peer_subscribe(self, *_):
        """Note a new subscriber."""
        self._changed = True

    def peer_unsubscribe(self, *_):
        """Note that a subscriber left."""
        self._changed = True

    def idle(self):
        """Publish to new subscribers what is known."""
        self.after_step()

    def after_step(self):
        """Publish what has become known by the world's present step."""
        world = self._world
        if self._changed:
            self._changed = False
            self._heed_listeners()
        if self._suite.is_idle:
            return
        self._suite.update(world.steps, world.sensed)
        for sensor in self._suite.active:
            reading = sensor.known(world.time)
            if reading is not None and reading is not self._published.get(sensor):
                self._published[sensor] = reading
                self.counts[sensor.mount.name] = self.counts.get(sensor.mount.name, 0) + 1
                self._publish(sensor, reading)

    def repeat(self):
        """Publish the newest of each sensor again: it shows subscribers that wait that there is no more."""
        for topic in self._topics.values():
            if topic.has_subscribers:
                topic.repeat()

    def _heed_listeners(self):
        """Read what has subscribers now, and publish to new ones what is known already."""
        world, (wanted, new) = self._world, self._listened()
        self._suite.activate_from(wanted, world.steps, world.sensed)
        active = self._suite.active
        self._published = {
            sensor: self._published[sensor] for sensor in active if sensor in self._published
        }
        for sensor, reading in self._published.items():
            self._publish(sensor, reading, new)

    def _listened(self):
        """Return the names of the sensors with subscribers, by row, and the topics new to that."""
        wanted, new = {}, set()
        for (row, name), topics in self._of.items():
            for topic in topics:
                before = topic.has_subscribers
                if topic.look():
                    wanted.setdefault(row, set()).add(name)
                    new.update(() if before else (topic,))
        return wanted, new

    def _publish(self, sensor, reading, only=None):
        """Publish ``reading`` on the topics that are listened to, or on those among ``only``."""
        rows, stamp = {}, stamp_at(reading.stamp)
        for k, row in enumerate(sensor.rows.tolist() if only is None or only else ()):
            for topic in self._of.get((row, sensor.mount.name), ()):
                if topic.has_subscribers if only is None else topic in only:
                    form = topic.form
                    if form not in rows:
                        rows[form] = form.rows(reading)
                    topic.publish(form.message(rows[form][k], Header(0, stamp, topic.frame)))

    def slow(self, speed, factor):
        """Return which sensors do not keep their rates, texts.

        ``speed``, ``factor``: simulated over wall time, wanted and achieved.
        """
        if self._suite.is_idle:
            return []
        texts = self._suite.active_notes
        if speed and factor < KEPT * speed:
            text = "{}: {:.3g} Hz of wall time, wanted {:.3g}: simulated time is late"
            rates = {sensor.mount.name: sensor.mount.rate for sensor in self._suite.active}
            texts += [
                text.format(name, rate * factor, rate * speed) for name, rate in rates.items()
            ]
        for (name, _), topic in self._topics.items():
            lost = topic.lately_left_out() if topic.has_subscribers else 0
            if lost:
                texts.append("{}: a listener was too slow for {} messages".format(name, lost))
        return texts[:MOST_SHOWN]


class _Topic:
    """One topic of one sensor."""

    def __init__(self, name, kind, listener):
        self.form, self.frame, self.has_subscribers = None, "", False
        self._newest, self._left_out, self._lost = None, 0, -math.inf
        self._publisher = prompt_publisher(name, kind, lambda: self._newest, listener)

    def look(self):
        """Return whether anybody listens now, and remember it."""
        self.has_subscribers = self._publisher.get_num_connections() > 0
        if not self.has_subscribers:
            self._newest = None  # it grows old
        return self.has_subscribers

    def publish(self, message):
        """Publish ``message``; a later listener begins with it."""
        self._newest = message
        self._publisher.publish(message)

    def repeat(self):
        """Publish the newest message again, if there is one."""
        if self._newest is not None:
            self._publisher.publish(self._newest)

    def lately_left_out(self):
        """Return how many messages so far did not reach a listener, 0 if none lately."""
        connections = list(self._publisher.impl.connections)
        total, now = sum(getattr(each, "left_out", 0) for each in connections), time.monotonic()
        if total > self._left_out:
            self._lost = now
        self._left_out = total
        return total if now - self._lost < LATELY else 0

    def close(self):
        """Withdraw the topic."""
        self._publisher.unregister()
