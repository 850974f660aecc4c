"""Publisher of the emergency stop's topic, without Qt."""

import threading

import rospy
from std_msgs.msg import Bool


class StopTopic(rospy.SubscribeListener):
    """Publishes presses and releases; to later subscribers it repeats a press only.

    A latched release would undo a stop that another node has commanded since.
    """

    def __init__(self):
        super().__init__()
        self._lock, self._pressed = threading.Lock(), False
        self.publisher = None

    def advertise(self):
        """Begin to publish; this may block while the master does not answer."""
        self.publisher = rospy.Publisher(
            "emergency_stop", Bool, subscriber_listener=self, queue_size=1
        )

    def set(self, on):
        """Press or release the emergency stop of all controllers."""
        with self._lock:
            self._pressed = on
            if self.publisher is not None:
                self.publisher.publish(Bool(data=on))

    def peer_subscribe(self, _topic, _publish, publish_to_it):
        """Publish a press to a new subscriber; rospy calls this."""
        with self._lock:
            if self._pressed:
                publish_to_it(Bool(data=True))
