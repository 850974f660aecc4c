"""The GUI's ROS side, without Qt: callbacks store, the GUI's timers take; nothing here blocks them."""

import queue
import threading
import time
from collections import deque

import numpy as np
import rosgraph
import rospy
from geometry_msgs.msg import Pose2D
from rospy.impl.registration import Registration, get_registration_listeners
from sensor_msgs.msg import Image
from std_msgs.msg import Bool, String
from std_srvs.srv import SetBool, Trigger

from mrs_simulator.msg import Camera, Collision, ControlStatus, RobotSpec, StageStatus, TeamState
from mrs_simulator.rqt_plugin.robots_link import RobotsLink
from mrs_simulator.rqt_plugin.study import Snapshot
from mrs_simulator.srv import SetSpeed, SetTeam, SetTopology, StepStage

SAMPLE_PERIOD = 0.05  # [s] of simulated time between samples kept for the curves
MOST_WAITING = 4000  # [-] samples kept while the GUI is busy
SILENCE = 1.5  # [s] of wall time after which the stage, the controller or a robot counts as silent
LOOK_PERIOD = 1.0  # [s] of wall time between looks at the master
SERVICE_LIMIT = 5.0  # [s] a caller waits for a service to appear
END_LIMIT = 2.0  # [s] of wall time that the last requests have
SIMULATED_TIME = "/use_sim_time"

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

KEPT = (
    ("stage", "stage/status", StageStatus),
    ("scenario", "stage/scenario", String),
    ("control", "pioneer_control/status", ControlStatus),
    ("emergency", "emergency_stop", Bool),
)


class RosLink:
    """Listens to stage, controller and robots; asks services and sets parameters in the background."""

    def __init__(self):
        self._lock = threading.Lock()
        self._newest, self._heard = {}, {}
        self._samples, self._collisions = deque(maxlen=MOST_WAITING), deque(maxlen=1000)
        self._results, self._work = queue.Queue(), queue.Queue()
        self._robots = RobotsLink()
        self._told = None, False, (), None  # the last snapshot, after what it was made of
        self.set_starts, self.odometry_topics = self._robots.set_starts, self._robots.topics
        self._ended = threading.Event()
        self.master_online = False
        self._subscribers = {
            "state": rospy.Subscriber(
                "stage/state", TeamState, self._on_state, queue_size=1, tcp_nodelay=True
            ),
            "collisions": rospy.Subscriber("stage/collisions", Collision, self._collisions.append),
        }
        for name, topic, kind in KEPT:
            self._subscribers[name] = rospy.Subscriber(topic, kind, self._keep, name, queue_size=1)
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

    def newest(self, name):
        """Return the newest message called ``name``: stage, control, scenario, emergency; or None."""
        with self._lock:
            return self._newest.get(name)

    def forget(self, name):
        """Count ``name`` as silent until it is heard again."""
        with self._lock:
            self._heard.pop(name, None)

    def is_fresh(self, name):
        """Return whether ``name`` was heard within the last ``SILENCE`` [s] of wall time."""
        with self._lock:
            return time.monotonic() - self._heard.get(name, -SILENCE) < SILENCE

    def snapshot(self):
        """Return the newest ``Snapshot``: of the stage, else of the robots' odometry; None before."""
        state, stage, fresh = self.newest("state"), self.newest("stage"), self.is_fresh("state")
        robots = None if state is not None and fresh else self._from_robots()
        if robots is not None or state is None:
            return robots
        silent = tuple(stage.real_silent) if fresh and stage is not None else ()
        # Asked for many times between two messages, of which each takes a while to take apart.
        if self._told[0] is not state or self._told[1:3] != (fresh, silent):
            self._told = state, fresh, silent, _from_state(state, fresh, silent)
        return self._told[3]

    def take_samples(self):
        """Return the snapshots for the curves since the last call."""
        with self._lock:
            taken, messages = [], list(self._samples)
            self._samples.clear()
        taken = [_from_state(message, True) for message in messages]
        if not taken and not self.is_fresh("state"):
            robots = self._from_robots()
            taken = [robots] if robots is not None else []
        return taken

    def _from_robots(self):
        control = self.newest("control") if self.is_fresh("control") else None
        return self._robots.snapshot(SILENCE, control)

    def take_collisions(self):
        """Return the collisions since the last call: ``(first, second, x, y)``."""
        taken = []
        while self._collisions:
            message = self._collisions.popleft()
            taken.append((message.first, message.second, message.x, message.y))
        return taken

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

    def begin_simulated_time(self):
        """Set ``/use_sim_time``; the result ``simulated_time`` has what it was, None if not set."""
        self._work.put(("simulated_time", _begin_simulated_time))

    def restore_simulated_time(self, before):
        """Set ``/use_sim_time`` to what it was ``before``."""
        self._work.put(("restored_time", lambda: _restore_simulated_time(before)))

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
        """Run ``function`` in the background; its ``(success, message)`` is a result called ``name``.

        In a thread of its own: no service, least of all ``stop``, waits for it.
        """
        threading.Thread(target=self._answer, args=(name, function), daemon=True).start()

    def take_results(self):
        """Return the answers since the last call: ``(name, success, message)``."""
        taken = []
        while True:
            try:
                taken.append(self._results.get_nowait())
            except queue.Empty:
                return taken

    def _call(self, name, arguments):
        if self._ended.is_set():
            return False, "the GUI is closing"
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
        while True:
            name, work = self._work.get()
            if work is None:
                self._withdraw()
                return
            self._answer(name, work)

    def _answer(self, name, work):
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
                    self._robots.forget()
                if self.master_online:
                    self._follow_master()
            except Exception as error:  # a master on its way out
                rospy.logdebug("gui: looking at the master: %s", error)

    def _follow_master(self):
        master = rosgraph.Master(rospy.get_name())
        published, subscribed, _ = map(dict, master.getSystemState())
        self._register_again(published, subscribed)
        self._follow_camera()
        if not self.is_fresh("state"):
            state, control = (self._subscribers[n].resolved_name for n in ("state", "control"))
            kinds = dict(master.getTopicTypes())
            self._robots.follow(
                published, subscribed, kinds, published.get(state), published.get(control)
            )

    def _register_again(self, published, subscribed):
        """Tell a master that was restarted of the topics here; rospy itself tells one master only."""
        known = {Registration.PUB: published, Registration.SUB: subscribed}
        topics = [*self._subscribers.values(), *self._robots.subscribers()]
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

    def close(self):
        """Let what was asked for be done and withdraw from everything, within ``END_LIMIT``.

        A master that has gone silent keeps a thread waiting, not the one that calls this.
        """
        self._ended.set()
        self._work.put(("end", None))
        for thread in self._threads:
            thread.join(END_LIMIT)

    def _withdraw(self):
        # Or it might still register what is withdrawn here.
        self._threads[0].join()
        for subscriber in self._subscribers.values():
            subscriber.unregister()
        self._robots.forget()
        if self._pictures is not None:
            self._pictures.unregister()
        self._camera.unregister()
        self._emergency.unregister()


def _begin_simulated_time():
    before = rospy.get_param(SIMULATED_TIME, None)
    rospy.set_param(SIMULATED_TIME, True)
    return True, before


def _restore_simulated_time(before):
    if before is not None:
        rospy.set_param(SIMULATED_TIME, before)
    elif rospy.has_param(SIMULATED_TIME):
        rospy.delete_param(SIMULATED_TIME)
    return True, ""


def _from_state(message, fresh, silent=()):
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
        np.array([fresh and number not in silent for number in message.robot], dtype=bool),
        frozenset(number for number, real in zip(message.robot, message.real) if real),
    )
