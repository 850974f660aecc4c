"""The markers node: the team's bodies, numbers and trajectories for RViz."""

import sys
import time
from collections import deque

import numpy as np
import rospy
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from mrs_simulator.core.kinematics import DEFAULT_HAND_LENGTH, hand_points
from mrs_simulator.msg import TeamState
from mrs_simulator.nodes.lifecycle import start_node
from mrs_simulator.nodes.parameters import number_parameter
from mrs_simulator.world.robots import pioneer3dx

RATE = 10.0  # [Hz] of wall time
TRAIL_STEP = 0.05  # [m] between two points of a trajectory
TRAIL_MOST = 2000  # [-] points of one trajectory
RED, BLACK = ColorRGBA(0.75, 0.1, 0.1, 1.0), ColorRGBA(0.1, 0.1, 0.1, 1.0)
GREEN = ColorRGBA(0.1, 0.6, 0.2, 0.9)
WHEEL_WIDTH = 0.05  # [m]
PARTS = 5  # markers of one robot


class Markers:
    """Listens to the stage's states; publishes markers at a display's rate."""

    def __init__(self):
        self._hand_length = number_parameter("~l", DEFAULT_HAND_LENGTH, above=0.0)
        self._newest, self._trails, self._shown = None, {}, 0
        self._publisher = rospy.Publisher("stage/markers", MarkerArray, queue_size=1)
        self._subscriber = rospy.Subscriber("stage/state", TeamState, self._keep, queue_size=1)

    def _keep(self, state):
        self._newest = state

    def spin(self):
        """Run until ROS shuts down; naps are of wall time, a display does not stop with the clock."""
        while not rospy.is_shutdown():
            time.sleep(1.0 / RATE)
            state = self._newest
            if state is not None and self._publisher.get_num_connections():
                self._publisher.publish(self._markers(state))

    def _markers(self, state):
        pose = np.array([state.x, state.y, state.theta]).T
        hand = hand_points(pose, self._hand_length)
        markers = []
        for number, (x, y, theta), point in zip(state.robot, pose.tolist(), hand.tolist()):
            made = _robot(number, x, y, theta) + [self._trail(number, point)]
            for part, marker in enumerate(made):
                marker.header, marker.id = state.header, number * PARTS + part
            markers += made
        gone = range(len(state.robot) + 1, self._shown + 1)
        markers += [
            Marker(header=state.header, ns="robots", id=n * PARTS + part, action=Marker.DELETE)
            for n in gone
            for part in range(PARTS)
        ]
        self._shown = len(state.robot)
        return MarkerArray(markers=markers)

    def _trail(self, number, point):
        trail = self._trails.setdefault(number, deque(maxlen=TRAIL_MOST))
        here = Point(point[0], point[1], 0.01)
        if not trail or abs(trail[-1].x - here.x) + abs(trail[-1].y - here.y) > TRAIL_STEP:
            trail.append(here)
        marker = _marker(Marker.LINE_STRIP, (0.03, 0.0, 0.0), GREEN)
        marker.points = list(trail) + [here]
        return marker


def _robot(number, x, y, theta):
    body = _marker(
        Marker.CUBE, (pioneer3dx.LENGTH, 0.75 * pioneer3dx.WIDTH, 0.6 * pioneer3dx.HEIGHT), RED
    )
    ahead = 0.5 * (pioneer3dx.FRONT - pioneer3dx.REAR)
    _place(body, x, y, theta, ahead, 0.0, 0.6 * pioneer3dx.HEIGHT)
    wheels = []
    for side in (0.5, -0.5):
        wheel = _marker(
            Marker.CUBE,
            (2.0 * pioneer3dx.WHEEL_RADIUS, WHEEL_WIDTH, 2.0 * pioneer3dx.WHEEL_RADIUS),
            BLACK,
        )
        _place(wheel, x, y, theta, 0.0, side * pioneer3dx.WHEEL_TRACK, pioneer3dx.WHEEL_RADIUS)
        wheels.append(wheel)
    label = _marker(Marker.TEXT_VIEW_FACING, (0.0, 0.0, 0.4), BLACK)
    label.text = str(number)
    _place(label, x, y, 0.0, 0.0, 0.0, 2.5 * pioneer3dx.HEIGHT)
    return [body] + wheels + [label]


def _marker(kind, scale, color):
    marker = Marker(ns="robots", type=kind, action=Marker.ADD, color=color)
    marker.scale.x, marker.scale.y, marker.scale.z = scale
    marker.pose.orientation.w = 1.0
    return marker


def _place(marker, x, y, theta, ahead, left, up):
    cos, sin = np.cos(theta), np.sin(theta)
    position = marker.pose.position
    position.x, position.y = x + cos * ahead - sin * left, y + sin * ahead + cos * left
    position.z = up
    marker.pose.orientation.z = np.sin(0.5 * theta)
    marker.pose.orientation.w = np.cos(0.5 * theta)


def main():
    """Run the node ``markers``."""
    start_node("markers")
    try:
        markers = Markers()
    except ValueError as error:
        print("markers: {}".format(error), file=sys.stderr)
        sys.exit(2)
    markers.spin()


if __name__ == "__main__":
    main()
