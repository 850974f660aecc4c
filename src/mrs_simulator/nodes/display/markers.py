"""The markers node: robots, numbers, trajectories and obstacles for RViz, and the robots' descriptions."""

import threading
import time
from collections import deque

import numpy as np
import rospy
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, String
from visualization_msgs.msg import Marker, MarkerArray

from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.core.spatial import upright
from mrs_simulator.nodes.display.arms import MOST_OF_ARM, arm_markers, load_marker
from mrs_simulator.nodes.display.descriptions import Descriptions
from mrs_simulator.nodes.display.solids import model, solids
from mrs_simulator.ros.message_forms.messages import TeamState, read_state
from mrs_simulator.ros.node.arguments import parse
from mrs_simulator.ros.node.diagnostics import OK, Diagnostics, Health, Rates
from mrs_simulator.ros.node.lifecycle import run, start_node
from mrs_simulator.ros.node.node_parameters import HAND_LENGTH
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.scenario.scenario import DEFAULT_KIND, scenario_from_yaml
from mrs_simulator.scenario.surroundings.moving_obstacles import obstacles_at, scene_time
from mrs_simulator.scenario.surroundings.obstacles import Cylinder, is_flat
from mrs_simulator.state.columns import LOAD, SPATIAL
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.draw.figure_parts import PALETTE
from mrs_simulator.vehicles import kind
from mrs_simulator.vehicles.portable import team_from_message
from mrs_simulator.vehicles.shape import MOST_PARTS
from mrs_simulator.vehicles.top_view import TYRE, wheel_places

MOST_MARKERS = MOST_PARTS + 10  # [-] of a robot
MOST_SOLIDS = 400  # [-] of all robots; of more each is drawn as its outline and wheels
RATE = 10.0  # [Hz] of wall time
TRAIL_STEP = 0.05  # [m] between two points of a trajectory
TRAIL_MOST = 2000  # [-] points of one trajectory
TRAILS_MOST = 20000  # [-] points of all trajectories: they are sent whole each time
TRAIL_WIDTH = 0.06  # [m]
JUMP = 1.0  # [m] farther than it can have driven: the robot was put there
BLACK, GREY = ColorRGBA(0.1, 0.1, 0.1, 1.0), ColorRGBA(0.55, 0.55, 0.6, 1.0)
SAND, SLAB = ColorRGBA(0.76, 0.72, 0.6, 1.0), 0.02  # land: colour, thickness [m]
LABEL_HEIGHT, LABEL_OFFSET = 0.6, 0.6  # [m] of letters; from the robot to its number


class Markers:
    """Listens to the stage's states; publishes markers at a display's rate."""

    def __init__(self):
        self._hand_length = read(HAND_LENGTH)
        self._newest, self._header, self._obstacles, self._shown = None, None, (), {}
        self._kinds, self._load = (), None  # the robots' ``Kind``s, and what they carry
        self._trails, self._lock = Trails(), threading.Lock()
        self._descriptions = Descriptions()
        self._publisher = rospy.Publisher("stage/markers", MarkerArray, queue_size=1)
        self._published, self._rates = 0, Rates()
        self._diagnostics = Diagnostics(self._health)
        self._subscribers = [
            rospy.Subscriber("stage/state", TeamState, self._keep, queue_size=1),
            rospy.Subscriber("stage/scenario", String, self._begin, queue_size=1),
        ]

    def _begin(self, message):
        try:
            scenario = scenario_from_yaml(message.data, "stage/scenario")
            kinds = team_from_message(scenario).kinds
        except ValueError as error:
            text = "markers: robots are drawn as of the default kind: stage/scenario: {}"
            rospy.logerr_throttle(5.0, text.format(error))
            return
        with self._lock:
            # The stage publishes its scenario again after a reset too.
            self._obstacles, self._trails = scenario.obstacles, Trails()
            self._kinds, self._load = kinds, scenario.load
        self._descriptions.follow(kinds)

    def _keep(self, message):
        state = read_state(message)
        hand = hand_points(state.pose, self._hand_length)
        with self._lock:
            self._trails.add(state, hand, state.heights)
            self._newest, self._header = state, message.header

    def _health(self):
        """Return how often robots are drawn, for ``/diagnostics``."""
        rates = self._rates.of({"pictures [Hz]": self._published})
        return [Health("", OK, "no stage yet" if self._newest is None else "ready", rates)]

    def spin(self):
        """Run until ROS shuts down; naps are of wall time, a display does not stop with the clock."""
        while not rospy.is_shutdown():
            time.sleep(1.0 / RATE)
            if self._newest is not None and self._publisher.get_num_connections():
                self._publisher.publish(MarkerArray(markers=self._markers()))
                self._published += 1

    def _markers(self):
        with self._lock:
            state, header, kinds, load = self._newest, self._header, self._kinds, self._load
            obstacles = obstacles_at(self._obstacles, scene_time(state.time))
            trails = self._trails.lines()
        markers = []
        if len(kinds) != len(state.robots):  # the scenario of this team is still to come
            kinds = (kind(DEFAULT_KIND),) * len(state.robots)
        spatial = state.spatial if state.has(SPATIAL) else upright(state.pose[:, 2])
        solid = sum(len(model(each).forms) for each in kinds) <= MOST_SOLIDS
        for row, number in enumerate(state.robots):
            each, pose, z = kinds[row], state.pose[row].tolist(), float(spatial.z[row])
            parts = _signs(each, number, *pose) + ([] if solid else _outline(each, number, *pose))
            parts = _raised(parts, z) + trails[row : row + 1]
            if solid:
                where = (*pose[:2], z), spatial.orientation[row]
                parts += solids(model(each), *where, _colour(number))
            markers += _named("robots", number * MOST_MARKERS, parts)
        where = np.column_stack([state.pose[:, :2], spatial.z]), spatial.orientation
        joints = state.joints.reshape(len(kinds), -1)
        for row, arm in arm_markers(kinds, *where, joints, solid):
            markers += _named("arms", state.robots[row] * MOST_OF_ARM, arm)
        if load is not None and state.has(LOAD):
            markers += _named("load", 0, [load_marker(load, state.load)])
        markers += _named("obstacles", 0, [_obstacle(obstacle) for obstacle in obstacles])
        for marker in markers:
            marker.header = header
        return markers + self._gone(markers)

    def _gone(self, markers):
        """Return what deletes the markers that were shown and are not among ``markers``."""
        now = {(marker.ns, marker.id): marker for marker in markers}
        gone = [self._shown[key] for key in self._shown if key not in now]
        self._shown = now
        for marker in gone:
            marker.action = Marker.DELETE
        return gone


class Trails:
    """The ways of the hand points so far; they begin anew when robots are put elsewhere."""

    def __init__(self):
        self._last, self._ways = None, []
        self._points = self._ends = np.empty((0, 3))  # now, and the last points of the ways

    def add(self, state, hand, z):
        """Go on to the hand points ``hand`` (n, 2) of ``state``, at heights ``z`` (n,)."""
        if self._last is None or _put_elsewhere(self._last, state):
            n = len(state.robots)
            most = min(TRAIL_MOST, max(2, TRAILS_MOST // max(1, n)))
            self._ways = [deque(maxlen=most) for _ in range(n)]
            self._ends = np.full((n, 3), np.inf)
        points = np.column_stack([hand, z + 0.01])
        far = np.abs(points - self._ends).max(axis=1) > TRAIL_STEP
        for row in np.flatnonzero(far).tolist():
            self._ways[row].append(Point(*points[row].tolist()))
        self._ends[far] = points[far]
        self._last, self._points = state, points

    def lines(self):
        """Return a marker for each robot of the newest state."""
        lines = []
        for row, point in enumerate(self._points.tolist()):
            colour = _colour(self._last.robots[row])
            line = _marker(Marker.LINE_STRIP, (TRAIL_WIDTH, 0.0, 0.0), colour)
            line.points = list(self._ways[row]) + [Point(*point)]
            lines.append(line)
        return lines


def _put_elsewhere(before, after):
    """Return whether no drive leads from the state ``before`` to ``after``."""
    elapsed = after.time - before.time
    if before.robots != after.robots or elapsed < 0.0:
        return True
    moved = np.hypot(*(after.pose - before.pose)[:, :2].T)
    speed = np.maximum(*(np.hypot(*state.twist[:, :2].T) for state in (before, after)))
    # At high speeds of simulation not every state gets here.
    return bool(np.any(moved > JUMP + elapsed * speed))


def _outline(kind, number, x, y, theta):
    """Return the markers of one robot's body and wheels."""
    shape, height = kind.body, 0.6 * kind.body.height
    solid = Marker.CYLINDER if shape.round else Marker.CUBE
    wheels = [_wheel(kind.numbers.radius, x, y, theta, *at) for at in wheel_places(kind)]
    inside = 0.75 if wheels and not shape.round else 1.0  # of the width, between the wheels
    body = _marker(solid, (shape.length, inside * shape.width, height), _colour(number))
    _place(body, x, y, theta, 0.5 * (shape.front - shape.rear), 0.0, height)
    return [body] + wheels


def _signs(kind, number, x, y, theta):
    """Return the markers of one robot's heading and number."""
    shape = kind.body
    heading = _marker(Marker.ARROW, (0.05, 0.16, 0.18), BLACK)  # shaft, head, length of head
    heading.points = [Point(0.0, 0.0, 0.0), Point(shape.length, 0.0, 0.0)]
    _place(heading, x, y, theta, 0.0, 0.0, 1.1 * shape.height)
    label = _marker(Marker.TEXT_VIEW_FACING, (0.0, 0.0, LABEL_HEIGHT), BLACK)
    label.text = str(number)
    _place(label, x, y + LABEL_OFFSET, 0.0, 0.0, 0.0, 2.5 * shape.height)
    return [heading, label]


def _raised(parts, z):
    """Return the markers ``parts``, raised by ``z`` [m]."""
    for part in parts:
        part.pose.position.z += z
    return parts


def _wheel(radius, x, y, theta, ahead, left):
    wheel = _marker(Marker.CUBE, (2.0 * radius, TYRE * radius, 2.0 * radius), BLACK)
    _place(wheel, x, y, theta, ahead, left, radius)
    return wheel


def _obstacle(obstacle):
    if isinstance(obstacle, Cylinder):
        kind, yaw, size = Marker.CYLINDER, 0.0, (2.0 * obstacle.radius, 2.0 * obstacle.radius)
    else:
        kind, yaw, size = Marker.CUBE, obstacle.yaw, (obstacle.length, obstacle.width)
    # RViz paints what has no height black: land is a slab just below the ground.
    flat = is_flat(obstacle)
    height = SLAB if flat else obstacle.height
    marker = _marker(kind, size + (height,), SAND if flat else GREY)
    _place(marker, obstacle.x, obstacle.y, yaw, 0.0, 0.0, -0.6 * SLAB if flat else 0.5 * height)
    return marker


def _colour(number):
    """Return the colour of robot ``number``, the same as in figures and GUI."""
    name = PALETTE[(number - 1) % len(PALETTE)]
    return ColorRGBA(*[int(name[at : at + 2], 16) / 255.0 for at in (1, 3, 5)], 1.0)


def _named(group, first, markers):
    """Return ``markers``, named ``first`` and following in their ``group``."""
    for number, marker in enumerate(markers, first):
        marker.ns, marker.id = group, number
    return markers


def _marker(kind, scale, color):
    marker = Marker(type=kind, action=Marker.ADD, color=color)
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
    with refusing_bad_input("markers"):
        parse("Robots, trails and obstacles for RViz.", {}, node="markers")
        start_node("markers")
        markers = Markers()
    run(markers.spin)
