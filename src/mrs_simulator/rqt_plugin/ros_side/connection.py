"""The GUI's ROS side, without Qt: callbacks store messages, the GUI's timers read them without blocking."""

import time

from mrs_simulator.ros.message_forms.messages import robot_specs
from mrs_simulator.rqt_plugin.connection import Connection
from mrs_simulator.rqt_plugin.received import SILENCE
from mrs_simulator.rqt_plugin.ros_side import controller_parameters, service_calls
from mrs_simulator.rqt_plugin.ros_side.diagnostics import DiagnosticsConnection
from mrs_simulator.rqt_plugin.ros_side.emergency_stop import StopTopic
from mrs_simulator.rqt_plugin.ros_side.inbox import Inbox
from mrs_simulator.rqt_plugin.ros_side.master import MasterWatch
from mrs_simulator.rqt_plugin.ros_side.robots import RobotsConnection
from mrs_simulator.rqt_plugin.ros_side.sensors import SensorsConnection
from mrs_simulator.rqt_plugin.ros_side.service_calls import CONTROLLER, MASTER, ServiceCalls
from mrs_simulator.state.columns import REAL

END_LIMIT = 2.0  # [s] of wall time that the last requests have
BEGINNINGS = ("reset", "set_team")  # services after which another run begins


class RosConnection(Inbox, Connection):
    """Subscribes to stage, controller and robots; calls services and sets parameters in the background."""

    absent = {"hold": "over ROS no robot is pushed from here: the window without ROS does so"}

    def __init__(self):
        super().__init__()
        self._calls, self._robots = ServiceCalls(), RobotsConnection()
        self._sensors, self._diagnostics = SensorsConnection(), DiagnosticsConnection()
        self._emergency = StopTopic()
        self.diagnostics = self._diagnostics.parts
        self.odometry_topics, self.first_stamp = self._robots.topics, self._robots.first_stamp
        others = self._robots, self._sensors, self._diagnostics, self._emergency
        self._master = MasterWatch(self, *others)
        self._master.thread.start()

    @property
    def master_online(self):
        return self._master.online

    @property
    def registered(self):
        return self._master.registered

    # What was received ---------------------------------------------------------------------------

    def take_results(self):
        return self._calls.take_results()

    def snapshot(self):
        """Return the newest ``StateTable``: of the stage, else of the robots' odometry; None before."""
        of_stage = super().snapshot()
        if of_stage is not None and self.is_fresh("state"):
            return of_stage
        robots = self._from_robots()
        return of_stage if robots is None else robots

    def sensor_readings(self):
        snapshot = self.snapshot()
        now = snapshot.time if snapshot is not None and self.is_fresh("state") else None
        return self._sensors.readings(
            now, snapshot.numbers_with(REAL) if snapshot is not None else ()
        )

    def take_samples(self):
        taken = super().take_samples()
        if not taken and not self.is_fresh("state"):
            robots = self._from_robots()
            taken = [robots] if robots is not None else []
        return taken

    def _from_robots(self):
        control = self.newest("control") if self.is_fresh("control") else None
        return self._robots.snapshot(SILENCE, control)

    # Requests ------------------------------------------------------------------------------------

    def ask(self, name, *arguments):
        begins = self.begin_run if name in BEGINNINGS else None
        first = self.begin_run if name == "start" else None  # robots may move before the answer
        self._calls.ask(name, arguments, begins, first)

    def set_team(self, poses, kinds, altitude=None):
        self.ask("set_team", robot_specs(kinds, poses, altitude))

    def set_topology(self, edges, directed):
        receivers, senders, weights = zip(*edges) if edges else ((), (), ())
        self.ask("set_topology", list(receivers), list(senders), list(weights), directed)

    def set_parameters(self, values):
        """Set the protocol's parameters through dynamic_reconfigure in the background."""
        self._calls.put(CONTROLLER, "parameters", lambda: service_calls.reconfigure(values))

    def begin_simulated_time(self):
        self._calls.put(MASTER, "simulated_time", service_calls.begin_simulated_time)

    def restore_simulated_time(self, before):
        self._calls.put(
            MASTER, "restored_time", lambda: service_calls.restore_simulated_time(before)
        )

    def pause_after(self, steps):
        self.ask("pause_after", steps)

    def set_emergency(self, on):
        # Until its own message comes back, the one before is not to show.
        self.put("emergency", bool(on))
        return self._emergency.set(on)

    def do(self, name, function):
        return self._calls.do(name, function)

    def watch_sensors(self, wanted):
        return self._sensors.watch(wanted)

    def watch_diagnostics(self, wanted):
        return self._diagnostics.watch(wanted)

    def set_starts(self, poses, in_space=False):
        return self._robots.set_starts(poses, in_space)

    def has_simulated_time(self):
        return controller_parameters.has_simulated_time()

    def controller_arguments(self, topics):
        return controller_parameters.controller_arguments(topics)

    def close(self):
        """Finish pending requests and unregister from all topics, within ``END_LIMIT``.

        A master that does not answer blocks a background thread, not the caller.
        """
        end = time.monotonic() + END_LIMIT
        self._master.end()
        self._calls.close(end)
        self._master.thread.join(max(0.0, end - time.monotonic()))
