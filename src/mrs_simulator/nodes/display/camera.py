"""The camera node: images of the stage from pybullet's software renderer.

A process of its own, so that rendering slows neither the stage nor the control.
"""

import time

import numpy as np
import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import String

from mrs_simulator.core.parameters import shown
from mrs_simulator.core.scenario import ScenarioError, scenario_from_yaml
from mrs_simulator.ros.lifecycle import run, start_node
from mrs_simulator.ros.messages import Camera, TeamState, read_look, read_state
from mrs_simulator.ros.parameters import number_parameter
from mrs_simulator.study.programs import refusing_bad_input
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.registry import file_named
from mrs_simulator.world.view import PITCH, YAW, View

LARGEST = 1280  # [px] of a picture's side
NAP = 0.02  # [s] of wall time


class CameraNode:
    """Listens to the stage; publishes ``~image`` while somebody looks."""

    def __init__(self):
        self._period = 1.0 / number_parameter("~rate", 10.0, above=0.0, high=100.0)
        self._newest, self._wanted, self._scenario = None, None, None
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
        except ScenarioError as error:
            rospy.logerr_throttle(5.0, "camera: {}".format(error))
            return
        named = file_named(scenario)  # which a topic does not open
        if named:
            text = "camera: no pictures of robots whose kind is in a file: {}"
            rospy.logerr_throttle(5.0, text.format(shown(named)))
            return
        self._scenario = scenario

    def spin(self):
        """Render until ROS shuts down; naps are of wall time, a picture does not wait for the clock."""
        due = time.monotonic()
        while not rospy.is_shutdown():
            time.sleep(NAP)
            state, scenario = self._newest, self._scenario
            if time.monotonic() < due or state is None or scenario is None:
                continue
            poses = read_state(state).pose
            if self._publisher.get_num_connections() and len(poses) == scenario.n:
                begun = time.monotonic()
                self._publisher.publish(self._picture(poses, state.header, scenario))
                # At most half of a core, however slow the renderer is here.
                due = time.monotonic() + max(self._period, time.monotonic() - begun)
        if self._view is not None:
            self._view.close()

    def _picture(self, poses, header, scenario):
        if scenario is not self._shown:
            if self._view is not None:
                self._view.close()
            self._view = View(Team.from_scenario(scenario), poses, scenario.obstacles)
            self._shown = scenario
        self._view.show(poses)
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
        start_node("camera")
        camera = CameraNode()
    run(camera.spin)


if __name__ == "__main__":
    main()
