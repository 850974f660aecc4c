"""The camera node: images of the stage from pybullet's software renderer.

A process of its own, so that rendering slows neither the stage nor the control.
"""

import time

import numpy as np
import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import String

from mrs_simulator.core.scenario import scenario_from_yaml
from mrs_simulator.ros.arguments import parse
from mrs_simulator.ros.lifecycle import run, start_node
from mrs_simulator.ros.messages import Camera, TeamState, read_look, read_state
from mrs_simulator.ros.node_parameters import PICTURES
from mrs_simulator.ros.parameters import read
from mrs_simulator.study.programs import refusing_bad_input
from mrs_simulator.vehicles.portable import told_team
from mrs_simulator.world.view import PITCH, YAW, View

LARGEST = 1280  # [px] of a picture's side
NAP = 0.02  # [s] of wall time


class CameraNode:
    """Listens to the stage; publishes ``~image`` while somebody looks."""

    def __init__(self):
        self._period = 1.0 / read(PICTURES)
        self._newest, self._wanted = None, None
        self._told = None  # the ``Team`` and the obstacles
        self._view, self._shown = None, None
        self._publisher = rospy.Publisher("~image", Image, queue_size=1)
        self._subscribers = [
            rospy.Subscriber("stage/state", TeamState, self._on_state, queue_size=1),
            rospy.Subscriber("stage/scenario", String, self._on_scenario, queue_size=1),
            rospy.Subscriber("~look", Camera, self._on_look, queue_size=1),
        ]

    def _on_state(self, message):
        self._newest = message

    def _on_look(self, message):
        self._wanted = read_look(message)

    def _on_scenario(self, message):
        try:
            scenario = scenario_from_yaml(message.data, "stage/scenario")
            self._told = told_team(scenario), scenario.obstacles
        except ValueError as error:
            rospy.logerr_throttle(5.0, "camera: no pictures: stage/scenario: {}".format(error))

    def spin(self):
        """Render until ROS shuts down; naps are of wall time, a picture does not wait for the clock."""
        due = time.monotonic()
        while not rospy.is_shutdown():
            time.sleep(NAP)
            state, told = self._newest, self._told
            if time.monotonic() < due or state is None or told is None:
                continue
            seen = read_state(state)
            poses = seen.pose
            if self._publisher.get_num_connections() and len(poses) == told[0].n:
                begun = time.monotonic()
                self._publisher.publish(self._picture(seen, state.header, told))
                # At most half of a core, however slow the renderer is here.
                due = time.monotonic() + max(self._period, time.monotonic() - begun)
        if self._view is not None:
            self._view.close()

    def _picture(self, seen, header, told):
        poses = seen.pose
        if told is not self._shown:
            if self._view is not None:
                self._view.close()
            team, obstacles = told
            self._view, self._shown = View(team, poses, obstacles), told
        self._view.show(poses, seen.spatial)
        look = self._wanted
        width, height = 640, 480
        if look is not None:
            width, height = np.clip(look.size, 64, LARGEST).tolist()
            self._aim(look, poses)
        pixels = self._view.picture(width, height)
        image = Image(height=height, width=width, encoding="rgb8", step=3 * width)
        image.header = header
        image.data = pixels.tobytes()
        return image

    def _aim(self, look, poses):
        numbers = (*look.target, look.distance, look.yaw, look.pitch)
        if not np.isfinite(numbers).all() or look.distance <= 0.0:
            return
        target = look.target
        if 1 <= look.follow <= len(poses):
            target = poses[look.follow - 1, :2]
        self._view.look_at(target, look.distance, look.yaw or YAW, look.pitch or PITCH)


def main():
    """Run the node ``camera``."""
    with refusing_bad_input("camera"):
        parse("Pictures of the stage.", {}, node="camera")
        start_node("camera")
        camera = CameraNode()
    run(camera.spin)


if __name__ == "__main__":
    main()
