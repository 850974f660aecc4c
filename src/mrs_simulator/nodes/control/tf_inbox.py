"""Newest transform of each robot, looked up in tf on request of the control loop."""

import time

import rospy
import tf2_ros
from geometry_msgs.msg import Pose

from mrs_simulator.ros.receive.odometry_inbox import Inbox, lifted, planar, quaternion_length


class TransformInbox(Inbox):
    """Poses from tf: the transform from a common frame to each robot's base."""

    def __init__(self, numbers, bounds, real, timeout, world, base):
        """``world``: the common frame; ``base``: pattern of the robots' frames, ``{}``: the number."""
        super().__init__(numbers, bounds, real, timeout)
        self.topic = "/tf from {} to {}".format(world, base)
        self._world = world
        self._frames = [base.replace("{}", str(number)) for number in self._numbers]
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)

    def stale(self, now, timeout):
        """Look all transforms up; return ``{number: age}`` [s] of those without news for ``timeout``.

        A static transform is always news.
        """
        for row, frame in enumerate(self._frames):
            try:
                found = self._buffer.lookup_transform(self._world, frame, rospy.Time(0))
            except tf2_ros.TransformException as error:
                text = "/tf from {} to {}: {}".format(self._world, frame, error)
                rospy.logwarn_throttle(10.0, text)
                continue
            self._take(row, found, self._times(now)[row])
        return super().stale(now, timeout)

    def _take(self, row, found, now):
        stamp, move = found.header.stamp, found.transform
        if not stamp.is_zero() and stamp.to_nsec() == self._stamp[row]:
            return
        pose = Pose(position=move.translation, orientation=move.rotation)
        where, length = planar(pose), quaternion_length(pose)
        arrival, seconds = time.monotonic(), stamp.to_sec()
        with self._changed:
            if not self.intake.accepts_place(row, *where[:2], length, pose.position.z):
                return
            # A static transform has no stamp, and holds for ever.
            if stamp.is_zero() or self.intake.accepts_stamp(
                row, seconds, rospy.get_time(), arrival
            ):
                self._stamp[row], self._received[row] = stamp.to_nsec(), now
                self._lift[row] = lifted(pose)
                self._tracks.take(row, where, (now, seconds), pose.position.z)
