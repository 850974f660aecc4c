"""The camera node: images of the stage, in space.

A process of its own, so that rendering slows neither the stage nor the control.
"""

import time

import numpy as np
import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import String

from mrs_simulator.pictures.camera import Camera as Pinhole
from mrs_simulator.pictures.moving_parts import Odometer
from mrs_simulator.pictures.scene import Scene, drawn, framed
from mrs_simulator.ros.message_forms.messages import Camera, TeamState, read_camera_view, read_state
from mrs_simulator.ros.node.arguments import parse
from mrs_simulator.ros.node.diagnostics import OK, Diagnostics, Health, Rates
from mrs_simulator.ros.node.lifecycle import run, start_node
from mrs_simulator.ros.node.node_parameters import PICTURES
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.scenario.scenario import scenario_from_yaml
from mrs_simulator.scenario.surroundings.moving_obstacles import obstacles_at, scene_time
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.draw.figure_parts import robot_colours
from mrs_simulator.study.draw.paint import pixels
from mrs_simulator.vehicles.portable import team_from_message

LARGEST, SIZE = 1280, (640, 480)  # [px] of a picture's side, and by default
NAP = 0.02  # [s] of wall time


class CameraNode:
    """Listens to the stage; publishes ``~image`` while there is a subscriber."""

    def __init__(self):
        self._period = 1.0 / read(PICTURES)
        self._newest, self._wanted = None, None
        self._scenario = None  # the ``Team`` and the obstacles
        self._aimed, self._framed = None, None  # the camera, and what team it was framed for
        self._publisher = rospy.Publisher("~image", Image, queue_size=1)
        self._subscribers = [
            rospy.Subscriber("stage/state", TeamState, self._on_state, queue_size=1),
            rospy.Subscriber("stage/scenario", String, self._on_scenario, queue_size=1),
            rospy.Subscriber("~look", Camera, self._on_look, queue_size=1),
        ]

        self._shown, self._rates = 0, Rates()
        self._odometer = Odometer()
        self._diagnostics = Diagnostics(self._health)

    def _health(self):
        """Return how many pictures there are, for ``/diagnostics``."""
        rates = self._rates.of({"pictures [Hz]": self._shown})
        known = self._newest is not None and self._scenario is not None
        return [Health("", OK, "ready" if known else "no stage yet", rates)]

    def _on_state(self, message):
        self._newest = message

    def _on_look(self, message):
        self._wanted = read_camera_view(message)

    def _on_scenario(self, message):
        try:
            scenario = scenario_from_yaml(message.data, "stage/scenario")
            self._scenario = team_from_message(scenario), scenario.obstacles, scenario.load
        except ValueError as error:
            rospy.logerr_throttle(5.0, "camera: no pictures: stage/scenario: {}".format(error))

    def spin(self):
        """Render until ROS shuts down; naps are of wall time, a picture does not wait for the clock."""
        due = time.monotonic()
        while not rospy.is_shutdown():
            time.sleep(NAP)
            state, shown = self._newest, self._scenario
            if time.monotonic() < due or state is None or shown is None:
                continue
            seen = read_state(state)
            poses = seen.pose
            if self._publisher.get_num_connections() and len(poses) == shown[0].n:
                begun = time.monotonic()
                self._shown += 1
                self._publisher.publish(self._picture(seen, state.header, shown))
                # At most half of a core, however slow the renderer is here.
                due = time.monotonic() + max(self._period, time.monotonic() - begun)

    def _picture(self, seen, header, shown):
        team, obstacles, load = shown
        scene = Scene(
            kinds=team.kinds,
            state=seen,
            shades=robot_colours(range(1, team.n + 1))[:, :3],
            obstacles=obstacles_at(obstacles, scene_time(seen.time)),
            load=load,
            rolled=self._odometer.at(seen.robots, seen.pose),
        )
        look, width, height = self._wanted, *SIZE
        if look is not None:
            width, height = np.clip(look.size, 64, LARGEST).tolist()
        if shown is not self._framed:
            self._aimed, self._framed = framed(scene, Pinhole(), width, height), shown
        camera = self._aimed if look is None else _aimed(look, scene.place, self._aimed)
        image = Image(height=height, width=width, encoding="rgb8", step=3 * width)
        image.header = header
        image.data = pixels(drawn(scene, camera, width, height)).tobytes()
        return image


def _aimed(look, places, camera):
    """Return the ``camera`` as ``look`` wants it; as it is where that is no place to look from."""
    numbers = (*look.target, look.distance, look.yaw, look.pitch)
    if not np.isfinite(numbers).all() or look.distance <= 0.0:
        return camera
    target = (*look.target, 0.0)
    if 1 <= look.follow <= len(places):
        target = places[look.follow - 1]
    wanted = Pinhole(yaw=look.yaw, pitch=look.pitch or camera.pitch).turned(0.0, 0.0)
    return wanted._replace(distance=look.distance).zoomed(1.0).at(target)


def main():
    """Run the node ``camera``."""
    with refusing_bad_input("camera"):
        parse("Pictures of the stage.", {}, node="camera")
        start_node("camera")
        camera = CameraNode()
    run(camera.spin)
