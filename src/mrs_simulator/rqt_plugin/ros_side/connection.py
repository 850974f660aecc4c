"""The GUI's ROS side, without Qt: callbacks store, the GUI's timers take; nothing here blocks them."""

import threading
import time
from collections import deque

import numpy as np
import rosgraph
import rospy
from rospy.impl.registration import Registration, get_registration_listeners
from std_msgs.msg import Bool, String

from mrs_simulator.core.controller_log import Interruptions
from mrs_simulator.ros.messages import (
    Collision,
    ControlStatus,
    StageStatus,
    TeamState,
    is_commanded,
    read_collision,
    read_control_status,
    read_stage_status,
    read_state,
    robot_specs,
)
from mrs_simulator.rqt_plugin.ros_side import service_calls
from mrs_simulator.rqt_plugin.ros_side.diagnostics import DiagnosticsConnection
from mrs_simulator.rqt_plugin.ros_side.robots import RobotsConnection
from mrs_simulator.rqt_plugin.ros_side.sensors import SensorsConnection
from mrs_simulator.rqt_plugin.ros_side.service_calls import CONTROLLER, MASTER, ServiceCalls
from mrs_simulator.rqt_plugin.ros_side.stop_topic import StopTopic
from mrs_simulator.rqt_plugin.run.history import Snapshot

SAMPLE_PERIOD = 0.05  # [s] of simulated time between samples kept for the curves
AT_ONCE = 20  # [-] states of a fast simulation that may come together, and none is missed
MOST_WAITING = 4000  # [-] samples kept while the GUI is busy
SILENCE = 1.5  # [s] of wall time after which the stage, the controller or a robot counts as silent
LOOK_PERIOD = 1.0  # [s] of wall time between looks at the master
LEAST_PERIOD = 0.1  # [s] of it when other sensors are looked at in between
END_LIMIT = 2.0  # [s] of wall time that the last requests have

BEGINNINGS = ("reset", "set_team", "start")  # services after which another run begins
KEPT = (
    ("stage", "stage/status", StageStatus),
    ("scenario", "stage/scenario", String),
    ("control", "pioneer_control/status", ControlStatus),
    ("emergency", "emergency_stop", Bool),
)
READERS = {"stage": read_stage_status, "control": read_control_status}


class RosConnection:
    """Listens to stage, controller and robots; asks services and sets parameters in the background."""

    def __init__(self):
        self._lock = threading.Lock()
        self._newest, self._heard, self._moves = {}, {}, False
        self._samples, self._collisions = deque(maxlen=MOST_WAITING), deque(maxlen=1000)
        self._calls, self._robots, self._emergency = (
            ServiceCalls(),
            RobotsConnection(),
            StopTopic(),
        )
        self._sensors, self._diagnostics = SensorsConnection(), DiagnosticsConnection()
        self.watch_sensors = self._sensors.watch
        self.watch_diagnostics = self._diagnostics.watch
        self.diagnostics = self._diagnostics.parts
        self.controller = Interruptions()
        self._told = None, False, (), None  # the last snapshot, after what it was made of
        self.first_stamp = self._robots.first_stamp
        self.set_starts, self.odometry_topics = self._robots.set_starts, self._robots.topics
        self.do, self.take_results = self._calls.do, self._calls.take_results
        self.set_emergency = self._emergency.set
        self._ended, self.master_online = threading.Event(), False
        self.registered = frozenset()  # of the names in KEPT: those that somebody publishes
        self._subscribers = {}  # made once there is a master
        # It alone joins topics and leaves them: without a master rospy would wait for one, and so
        # would the GUI.
        self._looking = threading.Thread(target=self._look, daemon=True)
        self._looking.start()

    # What came in --------------------------------------------------------------------------------

    def _keep(self, message, name):
        told = READERS[name](message) if name in READERS else message
        with self._lock:
            if name == "control":
                self.controller.note(told.stamp, told.running, told.trouble)
            self._newest[name], self._heard[name] = told, time.monotonic()

    def _on_state(self, message):
        stamp = message.header.stamp.to_sec()
        with self._lock:
            last = self._newest.get("state")
            self._newest["state"], self._heard["state"] = message, time.monotonic()
            # The curves need less than every step of a fast simulation.
            kept = self._newest.get("kept", -1.0)
            if last is not None and (last.stage, last.run) != (message.stage, message.run):
                self._samples.append(None)  # a reset, another team, another stage: another run
            due = last is None or stamp < kept or stamp >= kept + SAMPLE_PERIOD - 1e-9
            stood, self._moves = not self._moves, is_commanded(message)
            if due or (stood and self._moves):  # a run begins with its very first command
                self._newest["kept"] = stamp
                self._samples.append(message)

    def newest(self, name):
        """Return the newest message called ``name``: stage, control, scenario, emergency; or None."""
        with self._lock:
            return self._newest.get(name)

    def forget(self, name):
        """Count ``name`` as never heard until it is heard again."""
        with self._lock:
            self._heard.pop(name, None)
            self._newest.pop(name, None)

    def silence(self, name):
        """Return the wall time [s] since ``name`` was heard, None if it never was."""
        with self._lock:
            return time.monotonic() - self._heard[name] if name in self._heard else None

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

    def heard_sensors(self):
        """Return the ``Heard`` of each sensor that is looked at, ``{(number, name): Heard}``."""
        snapshot = self.snapshot()
        now = snapshot.time if snapshot is not None and self.is_fresh("state") else None
        return self._sensors.heard(now, snapshot.real if snapshot is not None else ())

    def begin_run(self):
        """Count what is heard from now on as another run."""
        with self._lock:
            self._samples.append(None)

    def take_samples(self):
        """Return the snapshots for the curves since the last call, None where a run begins."""
        with self._lock:
            messages = list(self._samples)
            self._samples.clear()
        taken = [message and _from_state(message, True) for message in messages]
        if not taken and not self.is_fresh("state"):
            robots = self._from_robots()
            taken = [robots] if robots is not None else []
        return taken

    def _from_robots(self):
        control = self.newest("control") if self.is_fresh("control") else None
        return self._robots.snapshot(SILENCE, control)

    def take_collisions(self):
        """Return the ``core.recording.Collision``s since the last call."""
        taken = []
        while self._collisions:
            taken.append(read_collision(self._collisions.popleft()))
        return taken

    # What is asked for ---------------------------------------------------------------------------

    def ask(self, name, *arguments):
        """Call service ``name`` in the background; ``take_results`` has the answer."""
        self._calls.ask(name, arguments, self.begin_run if name in BEGINNINGS else None)

    def set_team(self, poses, kinds, altitude=None):
        """Ask the stage for a new team; ``poses`` (n, 3), ``altitude`` (n,) [m] or None: on the ground."""
        self.ask("set_team", robot_specs(kinds, poses, altitude))

    def set_topology(self, edges, directed):
        """Ask the controller for another topology; ``edges``: ``(i, j, weight)``."""
        hears, heard, weight = zip(*edges) if edges else ((), (), ())
        self.ask("set_topology", list(hears), list(heard), list(weight), directed)

    def set_parameters(self, values):
        """Set the protocol's parameters through dynamic_reconfigure in the background."""
        self._calls.put(CONTROLLER, "parameters", lambda: service_calls.reconfigure(values))

    def begin_simulated_time(self):
        """Set ``/use_sim_time``; the result ``simulated_time`` has what it was, None if not set."""
        self._calls.put(MASTER, "simulated_time", service_calls.begin_simulated_time)

    def restore_simulated_time(self, before):
        """Set ``/use_sim_time`` to what it was ``before``."""
        self._calls.put(
            MASTER, "restored_time", lambda: service_calls.restore_simulated_time(before)
        )

    # The master ----------------------------------------------------------------------------------

    def _look(self):
        while not self._ended.is_set():
            try:
                self.master_online = rosgraph.is_master_online()
                if self.is_fresh("state"):
                    self._robots.forget()
                if self.master_online:
                    self._follow_master()
            except Exception as error:  # a master on its way out
                rospy.logdebug("gui: looking at the master: %s", error)
            self._sensors.changed.wait(LOOK_PERIOD)
            self._sensors.changed.clear()
            self._ended.wait(LEAST_PERIOD)
        self._withdraw()

    def _join(self):
        self._emergency.advertise()
        subscribers = {
            "state": rospy.Subscriber(
                "stage/state", TeamState, self._on_state, queue_size=AT_ONCE, tcp_nodelay=True
            ),
            "collisions": rospy.Subscriber("stage/collisions", Collision, self._collisions.append),
        }
        for name, topic, kind in KEPT:
            subscribers[name] = rospy.Subscriber(topic, kind, self._keep, name, queue_size=1)
        self._subscribers = subscribers

    def _follow_master(self):
        if not self._subscribers:
            self._join()
        master = rosgraph.Master(rospy.get_name())
        published, subscribed, _ = map(dict, master.getSystemState())
        self._register_again(published, subscribed)
        self.registered = frozenset(
            name for name, _, _ in KEPT if published.get(self._subscribers[name].resolved_name)
        )
        stages, controllers = (
            published.get(self._subscribers[name].resolved_name) for name in ("state", "control")
        )
        alone, looked_at = not self.is_fresh("state"), not self._sensors.is_idle
        kinds = dict(master.getTopicTypes()) if alone or looked_at else {}
        if alone:
            self._robots.follow(published, subscribed, kinds, stages, controllers)
        if looked_at:
            self._sensors.follow(published, subscribed, kinds, controllers)
        self._diagnostics.follow()

    def _register_again(self, published, subscribed):
        """Tell a master that was restarted of the topics here; rospy itself tells one master only."""
        known = {Registration.PUB: published, Registration.SUB: subscribed}
        topics = [
            *self._subscribers.values(),
            *self._robots.subscribers(),
            *self._sensors.subscribers(),
            *filter(None, [self._diagnostics.subscriber]),
        ]
        for topic in (*topics, self._emergency.publisher):
            if rospy.get_name() not in known[topic.reg_type].get(topic.resolved_name, ()):
                get_registration_listeners().notify_added(
                    topic.resolved_name, topic.type, topic.reg_type
                )

    def close(self):
        """Let what was asked for be done and withdraw from everything, within ``END_LIMIT``.

        A master that has gone silent keeps a thread waiting, not the one that calls this.
        """
        end = time.monotonic() + END_LIMIT
        self._ended.set()
        self._sensors.changed.set()  # wakes the one that looks
        self._calls.close(end)
        self._looking.join(max(0.0, end - time.monotonic()))

    def _withdraw(self):
        for subscriber in self._subscribers.values():
            subscriber.unregister()
        self._robots.forget()
        self._sensors.close()
        self._diagnostics.close()
        if self._emergency.publisher is not None:
            self._emergency.publisher.unregister()


def _from_state(message, fresh, silent=()):
    state = read_state(message)
    return Snapshot(
        state.stamp,
        state.robots,
        state.pose,
        state.twist,
        state.command,
        np.array([fresh and number not in silent for number in state.robots], dtype=bool),
        frozenset(number for number, real in zip(state.robots, state.real) if real),
        state.axes,
        state.joints if state.all_joints.shape[1] == 1 else state.all_joints,
        state.spatial,
    )
