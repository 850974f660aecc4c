"""The GUI's ROS side, without Qt: callbacks store, the GUI's timers take; nothing here blocks them."""

import queue
import re
import threading
import time
from collections import deque

import numpy as np
import rosgraph
import rospy
from geometry_msgs.msg import Pose2D
from nav_msgs.msg import Odometry
from rospy.impl.registration import Registration, get_registration_listeners
from sensor_msgs.msg import Image
from std_msgs.msg import Bool, String
from std_srvs.srv import SetBool, Trigger

from mrs_simulator.msg import Camera, Collision, ControlStatus, RobotSpec, StageStatus, TeamState
from mrs_simulator.rqt_plugin.study import Snapshot
from mrs_simulator.srv import SetSpeed, SetTeam, SetTopology, StepStage

SAMPLE_PERIOD = 0.05  # [s] of simulated time between samples kept for the curves
MOST_WAITING = 4000  # [-] samples kept while the GUI is busy
SILENCE = 1.5  # [s] of wall time after which the stage, the controller or a robot counts as silent
LOOK_PERIOD = 1.0  # [s] of wall time between looks at the master
SERVICE_LIMIT = 5.0  # [s] a caller waits for a service to appear
ODOM = re.compile(r"^/robot(\d+)/odom$")

SERVICES = {
    "pause": ("stage/pause", SetBool),
    "step": ("stage/step", StepStage),
    "reset": ("stage/reset", Trigger),
    "set_speed": ("stage/set_speed", SetSpeed),
    "set_team": ("stage/set_team", SetTeam),
    "start": ("pioneer_control/start", Trigger),
    "stop": ("pioneer_control/stop", Trigger),
    "set_topology": ("pioneer_control/set_topology", SetTopology),
}


class RosLink:
    """Listens to stage, controller and robots; asks services and sets parameters in the background."""

    def __init__(self):
        self._lock = threading.Lock()
        self._newest, self._heard = {}, {}
        self._samples, self._collisions = deque(maxlen=MOST_WAITING), deque(maxlen=1000)
        self._results, self._work = queue.Queue(), queue.Queue()
        self._robots = {}
        self._odometry_subscribers = {}
        self._ended = threading.Event()
        self.master_online = False
        self._subscribers = [
            rospy.Subscriber(
                "stage/state", TeamState, self._on_state, queue_size=1, tcp_nodelay=True
            ),
            rospy.Subscriber("stage/status", StageStatus, self._keep, "stage", queue_size=1),
            rospy.Subscriber("stage/scenario", String, self._keep, "scenario", queue_size=1),
            rospy.Subscriber("stage/collisions", Collision, self._collisions.append),
            rospy.Subscriber("pioneer_control/status", ControlStatus, self._keep, "control"),
            rospy.Subscriber("emergency_stop", Bool, self._keep, "emergency"),
        ]
        self._camera = rospy.Publisher("camera/look", Camera, queue_size=1, latch=True)
        self._watching, self._pictures = False, None
        self._emergency = rospy.Publisher("emergency_stop", Bool, queue_size=1, latch=True)
        self._threads = [
            threading.Thread(target=target, daemon=True) for target in (self._look, self._serve)
        ]
        for thread in self._threads:
            thread.start()

    # What came in --------------------------------------------------------------------------------

    def _keep(self, message, name):
        with self._lock:
            self._newest[name], self._heard[name] = message, time.monotonic()

    def _on_state(self, message):
        stamp = message.header.stamp.to_sec()
        with self._lock:
            last = self._newest.get("state")
            self._newest["state"], self._heard["state"] = message, time.monotonic()
            # The curves need less than every step of a fast simulation.
            kept = self._newest.get("kept", -1.0)
            if last is None or stamp < kept or stamp >= kept + SAMPLE_PERIOD - 1e-9:
                self._newest["kept"] = stamp
                self._samples.append(message)

    def _on_odometry(self, message, number):
        pose = message.pose.pose
        theta = 2.0 * np.arctan2(pose.orientation.z, pose.orientation.w)
        twist = message.twist.twist
        with self._lock:
            self._robots[number] = (
                message.header.stamp.to_sec(),
                (pose.position.x, pose.position.y, theta),
                (twist.linear.x, twist.linear.y, twist.angular.z),
                time.monotonic(),
            )

    def newest(self, name):
        """Return the newest message called ``name``: stage, control, scenario, emergency; or None."""
        with self._lock:
            return self._newest.get(name)

    def is_fresh(self, name):
        """Return whether ``name`` was heard within the last ``SILENCE`` [s] of wall time."""
        with self._lock:
            return time.monotonic() - self._heard.get(name, -SILENCE) < SILENCE

    def snapshot(self):
        """Return the newest ``Snapshot``: of the stage, else of the robots' odometry; None before."""
        state = self.newest("state")
        if state is not None and self.is_fresh("state"):
            return _from_state(state, fresh=True)
        return self._from_robots() or (state and _from_state(state, fresh=False))

    def take_samples(self):
        """Return the snapshots for the curves since the last call."""
        with self._lock:
            taken, messages = [], list(self._samples)
            self._samples.clear()
        taken = [_from_state(message, fresh=True) for message in messages]
        if not taken and not self.is_fresh("state"):
            robots = self._from_robots()
            taken = [robots] if robots is not None else []
        return taken

    def take_collisions(self):
        """Return the collisions since the last call: ``(first, second, x, y)``."""
        taken = []
        while self._collisions:
            message = self._collisions.popleft()
            taken.append((message.first, message.second, message.x, message.y))
        return taken

    def _from_robots(self):
        with self._lock:
            robots = dict(self._robots)
        if not robots:
            return None
        numbers, now = tuple(sorted(robots)), time.monotonic()
        stamps, poses, twists, heard = zip(*(robots[number] for number in numbers))
        fresh = now - np.array(heard) < SILENCE
        commands = np.zeros((len(numbers), 2))
        return Snapshot(max(stamps), numbers, np.array(poses), np.array(twists), commands, fresh)

    # What is asked for ---------------------------------------------------------------------------

    def ask(self, name, *arguments):
        """Call service ``name`` of ``SERVICES`` in the background; ``take_results`` has the answer."""
        self._work.put((name, lambda: self._call(name, arguments)))

    def set_team(self, poses, kinds):
        """Ask the stage for a new team; ``poses`` (n, 3)."""
        robots = [
            RobotSpec(kind=kind, pose=Pose2D(*map(float, p))) for kind, p in zip(kinds, poses)
        ]
        self.ask("set_team", robots)

    def set_topology(self, edges, directed):
        """Ask the controller for another topology; ``edges``: ``(i, j, weight)``."""
        hears, heard, weight = zip(*edges) if edges else ((), (), ())
        self.ask("set_topology", list(hears), list(heard), list(weight), directed)

    def set_parameters(self, values):
        """Set the protocol's parameters through dynamic_reconfigure in the background."""
        self._work.put(("parameters", lambda: self._reconfigure(values)))

    def set_emergency(self, on):
        """Latch, or release, the emergency stop of all controllers."""
        self._emergency.publish(Bool(data=on))

    def look(self, **values):
        """Tell the camera where to look from: the fields of ``Camera``."""
        self._camera.publish(Camera(**values))

    def watch(self, on):
        """Listen to the camera's pictures, kept as ``image``, or no longer."""
        # The thread subscribes: without a master rospy would wait for one, and the GUI with it.
        self._watching = on

    def do(self, name, function):
        """Run ``function`` in the background; its ``(success, message)`` is a result called ``name``."""
        self._work.put((name, function))

    def take_results(self):
        """Return the answers since the last call: ``(name, success, message)``."""
        taken = []
        while True:
            try:
                taken.append(self._results.get_nowait())
            except queue.Empty:
                return taken

    def _call(self, name, arguments):
        service, kind = SERVICES[name]
        rospy.wait_for_service(service, SERVICE_LIMIT)
        answer = rospy.ServiceProxy(service, kind)(*arguments)
        return answer.success, answer.message

    def _reconfigure(self, values):
        from dynamic_reconfigure.client import Client  # slow to import, wanted seldom

        client = Client("pioneer_control", timeout=SERVICE_LIMIT)
        try:
            in_force = client.update_configuration(values)
        finally:
            client.close()
        refused = [name for name, value in values.items() if in_force.get(name) != value]
        if refused:
            return False, "refused: " + ", ".join(refused)
        return True, "parameters set"

    def _serve(self):
        while not self._ended.is_set():
            name, work = self._work.get()
            if work is None:
                return
            try:
                success, message = work()
            except Exception as error:  # the answer says it; the thread goes on
                success, message = False, "{}: {}".format(type(error).__name__, error)
            self._results.put((name, success, message))

    # The master ----------------------------------------------------------------------------------

    def _look(self):
        while not self._ended.wait(LOOK_PERIOD):
            try:
                self.master_online = rosgraph.is_master_online()
                if self.is_fresh("state"):
                    self._forget_robots()
                if self.master_online:
                    self._follow_master()
            except Exception as error:  # a master on its way out
                rospy.logdebug("gui: looking at the master: %s", error)

    def _follow_master(self):
        published, subscribed, _ = rosgraph.Master(rospy.get_name()).getSystemState()
        self._register_again(dict(published), dict(subscribed))
        self._follow_camera()
        if not self.is_fresh("state"):
            self._listen_to_robots(topic for topic, _ in published)

    def _register_again(self, published, subscribed):
        """Tell a master that was restarted of the topics here; rospy itself tells one master only."""
        known = {Registration.PUB: published, Registration.SUB: subscribed}
        topics = self._subscribers + list(self._odometry_subscribers.values())
        topics += [self._camera, self._emergency] + ([self._pictures] if self._pictures else [])
        for topic in topics:
            if rospy.get_name() not in known[topic.reg_type].get(topic.resolved_name, ()):
                get_registration_listeners().notify_added(
                    topic.resolved_name, topic.type, topic.reg_type
                )

    def _follow_camera(self):
        if self._watching and self._pictures is None:
            self._pictures = rospy.Subscriber(
                "camera/image", Image, self._keep, "image", queue_size=1
            )
        elif not self._watching and self._pictures is not None:
            self._pictures.unregister()
            self._pictures = None

    def _listen_to_robots(self, topics):
        """Without a stage, listen to every ``/robotN/odom`` there is: the robots may be real."""
        for topic in topics:
            match = ODOM.match(topic)
            if match and topic not in self._odometry_subscribers:
                self._odometry_subscribers[topic] = rospy.Subscriber(
                    topic, Odometry, self._on_odometry, int(match.group(1)), queue_size=1
                )

    def _forget_robots(self):
        for topic in list(self._odometry_subscribers):
            self._odometry_subscribers.pop(topic).unregister()
        with self._lock:
            self._robots.clear()

    def close(self):
        """Withdraw from everything."""
        self._ended.set()
        self._work.put(("end", None))
        # Or it might still register what is withdrawn here.
        self._threads[0].join(LOOK_PERIOD)
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._forget_robots()
        if self._pictures is not None:
            self._pictures.unregister()
        self._camera.unregister()
        self._emergency.unregister()


def _from_state(message, fresh):
    table = np.array(
        [message.x, message.y, message.theta, message.vx, message.vy, message.omega]
        + [message.command_v, message.command_omega]
    ).T.reshape(len(message.robot), 8)
    return Snapshot(
        message.header.stamp.to_sec(),
        tuple(message.robot),
        table[:, :3],
        table[:, 3:6],
        table[:, 6:],
        np.full(len(table), fresh),
    )
