"""The GUI's back end without ROS: it talks to the program of ``engine``, without Qt."""

import contextlib
import os
import queue
import shutil
import tempfile
import threading
import uuid
from collections import deque
from multiprocessing.connection import Listener

from mrs_simulator.record.controller_log import Interruptions
from mrs_simulator.rqt_plugin.connection import Connection
from mrs_simulator.rqt_plugin.received import Received
from mrs_simulator.rqt_plugin.run.error_message import reason
from mrs_simulator.rqt_plugin.run.staged import read_ahead
from mrs_simulator.rqt_plugin.sensing.readings import ReceivedReading

NO_ROS = "without ROS: real robots and bags need mrs_gui, or rqt"
PATIENCE = 10.0  # [s] of wall time that the simulation has to finish a run's files
SEEN = "in this window"  # where readings come from


class LocalConnection(Received, Connection):
    """Keeps what the engine sends, and sends it requests."""

    absent = dict.fromkeys(
        ("master", "preflight", "bag", "record", "rosbag", "rosrun", "diagnostics"), NO_ROS
    )
    master_online = True

    def __init__(self):
        super().__init__()
        self.controller = Interruptions()
        self._samples, self._results = deque(), deque()
        names = "collisions", "incidents", "applied", "estimates", "control_ended"
        self._queues = {"result": self._results, **{name: deque() for name in names}}
        self._wanted, self._readings = {}, (0.0, {})
        self._engine, self._sending = None, threading.Lock()
        self._awaited = {}  # queues of one answer each, by tokens
        self._directory = tempfile.mkdtemp(prefix="mrs_simulator_link_")  # its user's alone
        windows = os.name == "nt"
        self._listener = Listener(None if windows else os.path.join(self._directory, "engine"))
        self.address = self._listener.address  # where the engine is to connect
        threading.Thread(target=self._receive, daemon=True).start()

    def _receive(self):
        """Take what engines send, one after the other."""
        with contextlib.suppress(OSError):  # the listener is closed
            while True:
                engine = self._listener.accept()
                self._engine = engine
                if self._wanted:  # since before it began
                    self._ask_for_readings()
                with contextlib.suppress(EOFError, OSError):
                    while True:
                        name, value = engine.recv()
                        if name == "scenario":
                            read_ahead(value)
                        self._take(name, value)
                self._give_up(engine)

    def _give_up(self, engine):
        """Release who waits for answers of an ``engine`` that has ended."""
        with self._sending:
            self._engine = None if self._engine is engine else self._engine
            awaited, self._awaited = self._awaited, {}
        for answer in awaited.values():
            answer.put(None)

    def _take(self, name, value):
        with self._lock:
            if name == "state":
                state, is_sample, estimate = value
                self._put(name, state)
                if is_sample:
                    self._samples.append(state)
                    if estimate is not None:
                        self._queues["estimates"].append((state.time, state.robots, estimate))
            elif name == "run":
                self._samples.append(value)
            elif name == "written":
                token, sizes = value
                if token in self._awaited:
                    self._awaited.pop(token).put(sizes)
            elif name == "readings":
                self._readings = value
            elif name in self._queues:
                self._queues[name].extend(value if isinstance(value, list) else [value])
            else:
                if name == "control":
                    self.controller.note(value.stamp, value.running, value.trouble)
                self._put(name, value)

    def _taken(self, waiting):
        with self._lock:
            taken = list(waiting)
            waiting.clear()
        return taken

    # What is there -------------------------------------------------------------------------------

    @property
    def registered(self):
        return frozenset(name for name in ("stage", "control") if self.is_fresh(name))

    def snapshot(self):
        return self.newest("state")

    def sensor_readings(self):
        now, readings = self._readings
        return {key: _received(key, of, now, readings) for key, of in self._wanted.items()}

    # What was received since the last call -------------------------------------------------------

    def take_samples(self):
        return self._taken(self._samples)

    def take(self, name):
        """As ``Connection.take``; control_ended: what is said of controllers that ended, "" for well."""
        return self._taken(self._queues[name])

    def take_results(self):
        return self._taken(self._results)

    # Requests ------------------------------------------------------------------------------------

    def ask(self, name, *arguments):
        try:
            with self._sending:
                if self._engine is None:
                    raise OSError("no simulation runs")
                self._engine.send((name, arguments))
        except OSError as error:  # it has ended
            self._results.append((name, False, str(error)))

    def finish_record(self, directory):
        answer, token = queue.Queue(), uuid.uuid4().hex
        try:
            with self._sending:
                if self._engine is None:
                    return None
                self._awaited[token] = answer
                self._engine.send(("write", (token, directory)))
            return answer.get(timeout=PATIENCE)
        except (OSError, queue.Empty):
            return None

    def set_team(self, poses, kinds, altitude=None):
        self.ask("set_team", poses, tuple(kinds), altitude)

    def hold(self, number, place):
        self.ask("hold", number - 1, place)

    def set_topology(self, edges, directed):
        self.ask("set_topology", list(edges), directed)

    def set_parameters(self, values):
        self.ask("set_parameters", values)

    def set_emergency(self, on):
        self.put("emergency", bool(on))
        if self._engine is not None:
            self.ask("emergency", bool(on))

    def pause_after(self, steps):
        self._results.append(("pause_after", True, ""))  # every run pauses where its duration ends

    def begin_run(self):
        with self._lock:
            self._samples.append(None)

    def begin_simulated_time(self):
        self._results.append(("simulated_time", True, None))  # time is no one else's

    def restore_simulated_time(self, before):
        pass

    def do(self, name, function):
        threading.Thread(target=self._do, args=(name, function), daemon=True).start()

    def _do(self, name, function):
        try:
            success, answer = function()
        except Exception as error:  # reported as the answer
            success, answer = False, reason(error)
        self._results.append((name, success, answer))

    def watch_sensors(self, wanted):
        wanted = {key: of[:2] for key, of in wanted.items()}
        if wanted != self._wanted:
            self._wanted = wanted
            if self._engine is not None:
                self._ask_for_readings()

    def _ask_for_readings(self):
        rows = {}
        for number, name in self._wanted:
            rows.setdefault(number - 1, []).append(name)
        self.ask("watch", rows)

    def watch_diagnostics(self, wanted):
        pass

    def set_starts(self, poses, in_space=False):
        pass

    def close(self):
        self._listener.close()
        shutil.rmtree(self._directory, ignore_errors=True)


def _received(key, of, now, readings):
    """Return the ``ReceivedReading`` of a sensor ``key``, a robot's number and a name."""
    reading = readings.get(key[0] - 1, {}).get(key[1])
    if reading is None:
        return ReceivedReading(topic=SEEN)
    return ReceivedReading(reading, max(0.0, now - reading.stamp), of[0].rate, SEEN)
