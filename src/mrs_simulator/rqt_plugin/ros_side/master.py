"""Subscribes to stage and controller once there is a master, and to what other nodes publish."""

import threading

import rosgraph
import rospy
from rospy.impl.registration import Registration, get_registration_listeners
from std_msgs.msg import Bool, String

from mrs_simulator.ros.message_forms.messages import (
    Collision,
    ControlScenario,
    ControlStatus,
    Incident,
    StageStatus,
    TeamOdometry,
    TeamState,
)
from mrs_simulator.ros.node.master import Master
from mrs_simulator.ros.receive.withdrawal import withdraw

LOOK_PERIOD = 1.0  # [s] of wall time between queries of the master
LEAST_PERIOD = 0.1  # [s] of it when the selected sensors change

KEPT = (
    ("stage", "stage/status", StageStatus),
    ("scenario", "stage/scenario", String),
    ("control", "pioneer_control/status", ControlStatus),
    ("emergency", "emergency_stop", Bool),
)
QUEUED = (
    ("collisions", "stage/collisions", Collision),
    ("incidents", "stage/incidents", Incident),
    ("applied", "pioneer_control/scenario", ControlScenario),
    ("estimates", "pioneer_control/estimates", TeamOdometry),
)


class MasterWatch:
    """The only thread that subscribes and unsubscribes.

    Without a master rospy blocks, and the GUI must not.
    """

    def __init__(self, inbox, robots, sensors, diagnostics, emergency):
        """``inbox`` gets the messages of stage and controller; the others subscribe to their own topics."""
        self._inbox, self._robots, self._sensors = inbox, robots, sensors
        self._diagnostics, self._emergency = diagnostics, emergency
        self._ended, self.online = threading.Event(), False
        self.registered = frozenset()  # the names in KEPT that are published
        self._master, self.subscribers = Master(), {}  # the latter made once there is a master
        self.thread = threading.Thread(target=self._run, daemon=True)

    def end(self):
        """Ask the thread to unregister everything, and to end."""
        self._ended.set()
        self._sensors.changed.set()  # wakes it

    def _run(self):
        while not self._ended.is_set():
            try:
                self.online = rosgraph.is_master_online()
                if self._inbox.is_fresh("state"):
                    self._robots.forget()
                if self.online:
                    self._follow_master()
            except Exception as error:  # a master on its way out
                rospy.logdebug("gui: querying the master: %s", error)
            self._sensors.changed.wait(LOOK_PERIOD)
            self._sensors.changed.clear()
            self._ended.wait(LEAST_PERIOD)
        self._withdraw()

    def _subscribe(self):
        self._emergency.advertise()
        subscribers = {
            "state": rospy.Subscriber(
                "stage/state",
                TeamState,
                self._inbox.keep_state,
                queue_size=None,  # a lost one may be the first with a command, where a run begins
                tcp_nodelay=True,
            )
        }
        # of a lost estimate, samples would get an older one in silence
        for name, topic, kind in QUEUED:
            subscribers[name] = rospy.Subscriber(
                topic, kind, self._inbox.add, name, queue_size=None, tcp_nodelay=True
            )
        for name, topic, kind in KEPT:
            subscribers[name] = rospy.Subscriber(topic, kind, self._inbox.keep, name, queue_size=1)
        self.subscribers = subscribers

    def _follow_master(self):
        if not self.subscribers:
            self._subscribe()
        published, subscribed, _ = map(dict, self._master.ask("getSystemState"))
        self._register_again(published, subscribed)
        self.registered = frozenset(
            name for name, _, _ in KEPT if published.get(self.subscribers[name].resolved_name)
        )
        stages, controllers = (
            published.get(self.subscribers[name].resolved_name) for name in ("state", "control")
        )
        alone, selected = not self._inbox.is_fresh("state"), not self._sensors.is_idle
        kinds = dict(self._master.ask("getTopicTypes")) if alone or selected else {}
        if alone:
            self._robots.follow(published, subscribed, kinds, stages, controllers)
        if selected:
            self._sensors.follow(published, subscribed, kinds, controllers)
        self._diagnostics.follow()

    def _register_again(self, published, subscribed):
        """Register again with a restarted master, which rospy itself does not."""
        known = {Registration.PUB: published, Registration.SUB: subscribed}
        topics = [
            *self.subscribers.values(),
            *self._robots.subscribers(),
            *self._sensors.subscribers(),
            *filter(None, [self._diagnostics.subscriber]),
        ]
        for topic in (*topics, self._emergency.publisher):
            if rospy.get_name() not in known[topic.reg_type].get(topic.resolved_name, ()):
                get_registration_listeners().notify_added(
                    topic.resolved_name, topic.type, topic.reg_type
                )

    def _withdraw(self):
        for subscriber in self.subscribers.values():
            withdraw(subscriber)
        self._robots.forget()
        self._sensors.close()
        self._diagnostics.close()
        if self._emergency.publisher is not None:
            self._emergency.publisher.unregister()
