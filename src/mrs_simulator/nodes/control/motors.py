"""Enables the robots' motors before they are driven, by services or by drivers' topics."""

import threading

import rospy
from genpy.dynamic import generate_dynamic
from std_msgs.msg import Bool
from std_srvs.srv import Empty

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.ros.node.node_parameters import ENABLE_MOTORS, MOTORS_STATE
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.ros.receive.odometry_inbox import MOST_NAMED

PATIENCE = 1.0  # [s] of wall time after which a missing service is looked for again
AGAIN = 0.2  # [s] of wall time between two calls of a service that failed
BOOL, P2OS = "std_msgs/Bool", "p2os_msgs/MotorState"
TYPES = (BOOL, P2OS)


@explained_by("docs/robots.md#p2os-instead-of-rosaria")
def split_topic(pattern, number, default=""):
    """Return the name of robot ``number``'s topic and its type, of a pattern ``NAME [TYPE]``.

    ``default``: the type where the pattern has none.  ``ValueError`` for a type that is not known here.
    """
    name, _, kind = pattern.strip().partition(" ")
    kind = kind.strip() or default
    if kind and kind not in TYPES:
        text = "{!r}: unknown type of message {!r}, wanted one of {}"
        raise ValueError(text.format(pattern, kind, ", ".join(TYPES)))
    return name.replace("{}", str(number)), kind


def is_on(message):
    """Return whether a message of one of ``TYPES`` says that motors are on."""
    return bool(message.data if isinstance(message, Bool) else message.state)


def message_class(kind):
    """Return the class of the messages of type ``kind``.

    That of p2os is made here: the driver's package need not be installed on the controller's host.
    """
    return Bool if kind == BOOL else _P2OS_STATE


_P2OS_STATE = generate_dynamic(P2OS, "int32 state\n")[P2OS]


class MotorSwitch:
    """A topic on which a robot is commanded to switch its motors on."""

    def __init__(self, name, kind):
        """``name`` of the topic; its type ``kind``, one of ``TYPES``."""
        self._message = Bool(True) if kind == BOOL else message_class(kind)(1)
        self._publisher = rospy.Publisher(name, message_class(kind), queue_size=1)

    def switch_on(self):
        """Publish that; return why no robot can have received it, or ""."""
        if not self._publisher.get_num_connections():
            return "has no listener"
        self._publisher.publish(self._message)
        return ""


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
