"""Publisher of the emergency stop's topic, without Qt."""

import threading

import rospy
from std_msgs.msg import Bool


class StopTopic(rospy.SubscribeListener):
    """Tells everybody of a press and of a release; who comes later hears of a press alone.

    A latched release would let go, with nobody doing it, what somebody else has stopped since.
    """

    def __init__(self):
        super().__init__()
        self._lock, self._pressed = threading.Lock(), False
        self.publisher = None

    def advertise(self):
        """Begin to publish; not in a thread that must not wait for the master."""
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
        """Tell a new listener that the stop is pressed; rospy calls this."""
        with self._lock:
            if self._pressed:
                publish_to_it(Bool(data=True))
