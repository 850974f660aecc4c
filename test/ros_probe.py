"""A node for tests: listens to the simulator, drives robots, answers expressions on its input.

One line of input is a Python expression over the names below; one line of output its value as JSON.
"""

import contextlib
import json
import math
import signal
import sys
import threading
import time

import rospy
from geometry_msgs.msg import Pose2D, PoseStamped, Twist  # noqa: F401 expressions name it
from nav_msgs.msg import MapMetaData, OccupancyGrid, Odometry  # noqa: F401
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu, LaserScan, PointCloud  # noqa: F401
from std_msgs.msg import Bool, String  # noqa: F401
from std_srvs.srv import Empty, EmptyResponse, SetBool, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from mrs_simulator.msg import Collision, ControlStatus, RobotSpec, StageStatus, TeamState
from mrs_simulator.ros.message_forms.defined_types import DiagnosticArray
from mrs_simulator.srv import SetSpeed, SetTeam, SetTopology, StepStage

newest, counts, stamps, transforms, collisions = {}, {}, {}, {}, []
markers, marker_repeated = {}, False
clock_went_back, clock_repeats = False, 0  # repeats: how often the newest time was told
driven, gates, unstamped, diagnostics, greatest = {}, {}, set(), {}, {}


def keep(message, name):
    newest[name] = message
    counts[name] = counts.get(name, 0) + 1
    if hasattr(message, "header"):
        stamps.setdefault(name, []).append(message.header.stamp.to_sec())


def on_clock(message):
    global clock_went_back, clock_repeats
    last = newest.get("clock")
    clock_repeats = clock_repeats + 1 if last and message.clock == last.clock else 0
    clock_went_back = clock_went_back or (last is not None and message.clock < last.clock)
    keep(message, "clock")


def on_transforms(message):
    for move in message.transforms:
        transforms[move.child_frame_id] = move


def parents():
    """Return the parent of each frame that transforms have told of."""
    return {child: move.header.frame_id for child, move in transforms.items()}


def on_diagnostics(message):
    for status in message.status:
        values = {each.key: each.value for each in status.values}
        diagnostics[status.name] = [status.level, status.message, values]


def watch_diagnostics():
    subscribers.append(rospy.Subscriber("/diagnostics", DiagnosticArray, on_diagnostics))
    return True


def on_collision(message):
    collisions.append([message.first, message.second, message.x, message.y])


def on_markers(message):
    """Keep what a display would show."""
    global marker_repeated
    named = {(marker.ns, marker.id): marker for marker in message.markers}
    marker_repeated = marker_repeated or len(named) < len(message.markers)
    markers.update(named)
    for name in [name for name in markers if markers[name].action == Marker.DELETE]:
        del markers[name]


def watch_markers():
    subscribers.append(rospy.Subscriber("/stage/markers", MarkerArray, on_markers))
    return True


def shown(kind):
    """Return the markers of one kind as plain values."""
    return [
        {
            "text": marker.text,
            "place": [marker.pose.position.x, marker.pose.position.y],
            "size": [marker.scale.x, marker.scale.y, marker.scale.z],
            "points": [[point.x, point.y] for point in marker.points],
        }
        for _, marker in sorted(markers.items(), key=lambda item: item[0])
        if marker.type == getattr(Marker, kind)
    ]


def on_commands(message):
    aside = message.command_vy or [0.0] * len(message.robot)
    for number, v, vy in zip(message.robot, message.command_v, aside):
        before = greatest.get(number, (0.0, 0.0))
        greatest[number] = max(before[0], math.hypot(v, vy)), max(before[1], abs(vy))


def watch_commands():
    """Keep the greatest speed, and that aside, to which each robot is commanded from now on."""
    subscribers.append(rospy.Subscriber("/stage/state", TeamState, on_commands, queue_size=None))
    return True


def listen(name, kind):
    subscribers.append(rospy.Subscriber(name, kind, keep, name, queue_size=1, tcp_nodelay=True))
    return True


def now():
    return newest["clock"].clock.to_sec() if "clock" in newest else None


def plain(name):
    """Return the newest message called ``name`` as plain values, {} before the first."""
    message = newest.get(name)
    if message is None:
        return {}
    values = {key: getattr(message, key) for key in message.__slots__ if key != "header"}
    return {k: list(v) if isinstance(v, (tuple, list)) else v for k, v in values.items()}


def state(key):
    return plain("/stage/state").get(key)


def stamp():
    """Return the simulated time of the newest state [s]."""
    return newest["/stage/state"].header.stamp.to_sec()


def status_stamp():
    """Return the simulated time of the newest status [s]."""
    return newest["/stage/status"].header.stamp.to_sec()


def status(key):
    return plain("/stage/status").get(key)


def control(key):
    return plain("/pioneer_control/status").get(key)


def odom(robot):
    m = newest.get("/robot{}/odom".format(robot))
    return m and {
        "stamp": m.header.stamp.to_nsec(),
        "frame": m.header.frame_id,
        "child": m.child_frame_id,
        "pose": [m.pose.pose.position.x, m.pose.pose.position.y, m.pose.pose.orientation.z],
        "twist": [m.twist.twist.linear.x, m.twist.twist.linear.y, m.twist.twist.angular.z],
        "covariance": list(m.pose.covariance),
    }


def sent(robot):
    m = newest.get("/robot{}/cmd_vel".format(robot))
    return m and [m.linear.x, m.angular.z]


def drive(robots, v, omega):
    """Command the robots until told otherwise, at 20 Hz of wall time."""
    message = Twist()
    message.linear.x, message.angular.z = v, omega
    for robot in robots:
        name = "/robot{}/cmd_vel".format(robot)
        old = driven.get(robot)
        publisher = old[0] if old else rospy.Publisher(name, Twist, queue_size=1, tcp_nodelay=True)
        driven[robot] = (publisher, message)
    return True


def stand_in(robot, pose, twist=(0.0, 0.0), topic="/robot{}/odom"):
    """Be the odometry of a real robot at ``pose`` (x, y, yaw), at 20 Hz until ``fall_silent``."""
    message = Odometry()
    message.pose.pose.position.x, message.pose.pose.position.y = pose[:2]
    message.pose.pose.orientation.z = math.sin(0.5 * pose[2])
    message.pose.pose.orientation.w = math.cos(0.5 * pose[2])
    message.twist.twist.linear.x, message.twist.twist.angular.z = twist
    name = topic.format(robot)
    old = driven.get(name)
    publisher = old[0] if old else rospy.Publisher(name, Odometry, queue_size=1, tcp_nodelay=True)
    driven[name] = (publisher, message)
    return True


def stand_in_imu(robot, rate):
    """Be the inertial sensor ``imu`` of a real robot that turns at ``rate`` [rad/s], likewise."""
    name = "/robot{}/imu".format(robot)
    message = Imu()
    message.angular_velocity.z = rate
    driven[name] = (rospy.Publisher(name, Imu, queue_size=1, tcp_nodelay=True), message)
    return True


def fall_silent(robot):
    del driven["/robot{}/odom".format(robot)]
    return True


def switch(service):
    """Call a service without an answer."""
    rospy.wait_for_service(service, 20.0)
    rospy.ServiceProxy(service, Empty)()
    return True


def offer(service):
    """Offer a service without an answer, which waits until ``gates[service]`` is set."""
    gates[service] = threading.Event()

    def answer(_):
        gates[service].wait()
        return EmptyResponse()

    subscribers.append(rospy.Service(service, Empty, answer))
    return True


def release():
    driven.clear()
    return True


def repeat():
    while not rospy.core._shutdown_flag:
        for publisher, message in list(driven.values()):
            if hasattr(message, "header") and publisher.resolved_name not in unstamped:
                message.header.stamp = rospy.Time.from_sec(time.time())  # a real robot's
            with contextlib.suppress(rospy.ROSException):  # closing
                publisher.publish(message)
        threading.Event().wait(0.05)


def press(on):
    emergency.publish(Bool(data=on))
    return True


def call(name, kind, *arguments):
    answer = rospy.ServiceProxy(name, kind)(*arguments)
    return [answer.success, answer.message]


def set_team(poses):
    robots = [RobotSpec(kind="", pose=Pose2D(*pose)) for pose in poses]
    return call("/stage/set_team", SetTeam, robots)


rospy.init_node("probe", anonymous=True, disable_signals=True)
emergency = rospy.Publisher("/emergency_stop", Bool, queue_size=1, latch=True)
subscribers = [
    rospy.Subscriber("/clock", Clock, on_clock, queue_size=100),
    rospy.Subscriber("/tf", TFMessage, on_transforms),
    rospy.Subscriber("/tf_static", TFMessage, on_transforms),
    rospy.Subscriber("/stage/collisions", Collision, on_collision),
]
listen("/stage/state", TeamState)
listen("/stage/status", StageStatus)
listen("/pioneer_control/status", ControlStatus)
threading.Thread(target=repeat, daemon=True).start()
SERVICES = (Empty, SetBool, SetSpeed, SetTopology, StepStage, Trigger, Odometry)  # for expressions
signal.signal(signal.SIGINT, signal.SIG_DFL)
print("ready", flush=True)
for line in sys.stdin:
    try:
        answer = {"value": eval(line)}  # from this test's own pipe
        text = json.dumps(answer)
    except Exception as error:
        text = json.dumps({"error": "{}: {}".format(type(error).__name__, error)})
    print(text, flush=True)
