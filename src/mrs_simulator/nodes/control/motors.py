"""Enables the robots' motors before they are driven."""

import threading

import rospy
from std_srvs.srv import Empty

from mrs_simulator.nodes.control.motor_messages import (
    BOOL,
    MotorSwitch,
    is_on,
    message_class,
    split_topic,
)
from mrs_simulator.ros.node.node_parameters import ENABLE_MOTORS, MOTORS_STATE
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.ros.receive.odometry_inbox import MOST_NAMED

PATIENCE = 1.0  # [s] of wall time after which a missing service is looked for again
AGAIN = 0.2  # [s] of wall time between two calls of a service that failed


class Motors:
    """Calls the service ``~enable_motors`` of every robot, each in a thread of its own.

    Where a type of message follows the name it is a topic, and published to instead.  It listens to the
    robots' ``~motors_state`` too, where there is one: an emergency button switches a robot's motors off.
    """

    def __init__(self, numbers, dry_run=False):
        """``numbers``: the robots' numbers; in a dry run no motor is touched."""
        pattern = read(ENABLE_MOTORS)
        pattern = "" if dry_run else pattern
        topics = [split_topic(pattern, number) for number in numbers if pattern]
        self._names = [name for name, _ in topics]
        self._switches = {name: MotorSwitch(name, kind) for name, kind in topics if kind}
        self._lock = threading.Lock()
        self._waiting, self._round = {}, 0
        self._switching = False  # from a start on until the motors of all are on
        self._off, self._state_subscribers = set(), []
        pattern = read(MOTORS_STATE)
        for row, number in enumerate(numbers if pattern else ()):
            topic, kind = split_topic(pattern, number, BOOL)
            subscriber = rospy.Subscriber(
                topic, message_class(kind), self._on_state, row, queue_size=1
            )
            self._state_subscribers.append(subscriber)

    def off(self):
        """Return the rows of the robots that say that their motors are off, ascending."""
        return sorted(self._off)

    def _on_state(self, message, row):
        (self._off.discard if is_on(message) else self._off.add)(row)

    def enable(self):
        """Ask every robot to switch its motors on; ``missing`` returns who has not answered yet."""
        with self._lock:
            self._round += 1
            self._switching = True
            self._waiting = dict.fromkeys(self._names, "has not answered yet")
            threads = [
                threading.Thread(target=self._call, args=(name, self._round), daemon=True)
                for name in self._names
            ]
        for thread in threads:
            thread.start()

    def forget(self):
        """Ask no longer: the robots were stopped."""
        with self._lock:
            self._round += 1
            self._waiting, self._switching = {}, False

    def missing(self):
        """Return which robots' motors are not known to be on, or ""."""
        with self._lock:
            waiting = sorted(self._waiting.items())
            answered = self._switching and not waiting
            # A driver reports that they are on with its next packet from the robot.
            waiting += [
                (self._state_subscribers[row].resolved_name, "still says that they are off")
                for row in (self.off() if answered else ())
            ]
            self._switching = bool(waiting)
        more = ", and {} more".format(len(waiting) - MOST_NAMED) if waiting[MOST_NAMED:] else ""
        shown = ", ".join("{} {}".format(name, why) for name, why in waiting[:MOST_NAMED])
        return "motors: " + shown + more if shown else ""

    def _call(self, name, number):
        while number == self._round and not rospy.is_shutdown():
            try:
                why = self._switch_on(name, number)
            except rospy.ROSInterruptException:
                return
            self._note(name, number, why)
            if not why:
                return
            # A wall-clock nap: simulated time may stand still.
            threading.Event().wait(AGAIN)

    def _switch_on(self, name, number):
        """Call the service ``name`` once, or publish on the topic; return why that failed, or ""."""
        if name in self._switches:
            return self._switches[name].switch_on() if number == self._round else ""
        try:
            rospy.wait_for_service(name, PATIENCE)
        except rospy.ROSInterruptException:
            raise
        except rospy.ROSException:
            return "is missing"
        if number == self._round:  # else the robots were stopped meanwhile
            try:
                rospy.ServiceProxy(name, Empty)()
            except (rospy.ROSException, rospy.ServiceException) as error:
                return "failed: {}".format(error)
        return ""

    def _note(self, name, number, why):
        with self._lock:
            if number != self._round:
                return
            if self._waiting.get(name) != why:
                text = "motors: {} {}".format(name, why or "is on")
                (rospy.logerr if why else rospy.loginfo)("pioneer_control: %s", text)
            self._waiting.pop(name, None)
            if why:
                self._waiting[name] = why
