"""Topics by which drivers report whether motors are on, and are commanded to switch them on."""

import rospy
from genpy.dynamic import generate_dynamic
from std_msgs.msg import Bool

from mrs_simulator.core.doc_links import explained_by

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
