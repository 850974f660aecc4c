"""Topics of the load that robots carry together: where it is, and how each grips it."""

import rospy
from geometry_msgs.msg import PoseStamped, Vector3, WrenchStamped

from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.ros.message_forms.messages import load_pose

POSE, WRENCH = "/load/pose", "/robot{}/grasp/wrench"


class LoadTopics(StagePart):
    """``/load/pose`` and each robot's ``grasp/wrench``, the force that it exerts on the load, no torque."""

    def __init__(self, world, frame):
        """``frame``: the name of the common frame."""
        self._world, self._frame = world, frame
        self._pose, self._wrenches = None, []

    def follow_team(self, scenario):
        for topic in [self._pose, *self._wrenches]:
            if topic is not None:
                topic.unregister()
        self._pose, self._wrenches = None, []
        if self._world.load is None:
            return
        self._pose = rospy.Publisher(POSE, PoseStamped, queue_size=10, tcp_nodelay=True)
        for number in range(1, self._world.n + 1):
            name = WRENCH.format(number)
            opened = rospy.Publisher(name, WrenchStamped, queue_size=10, tcp_nodelay=True)
            self._wrenches.append(opened)

    def publish(self, stamp):
        if self._pose is None or self._world.load is None:
            return
        carried = self._world.load.state
        if self._pose.get_num_connections():
            self._pose.publish(self._stamped(PoseStamped(pose=load_pose(carried)), stamp))
        for topic, force in zip(self._wrenches, carried.force.tolist()):
            if topic.get_num_connections():
                message = WrenchStamped()
                message.wrench.force = Vector3(*force)
                topic.publish(self._stamped(message, stamp))

    def _stamped(self, message, stamp):
        message.header.stamp, message.header.frame_id = stamp, self._frame
        return message
