"""The newest messages of stage and controller: rospy's callbacks store, the GUI's timers read them."""

import contextlib
import operator
from collections import deque

import numpy as np

from mrs_simulator.record.controller_log import Interruptions
from mrs_simulator.ros.message_forms.messages import (
    MessageError,
    is_commanded,
    read_collision,
    read_control_scenario,
    read_control_status,
    read_incident,
    read_odometry,
    read_stage_status,
    read_state,
)
from mrs_simulator.rqt_plugin.received import Received
from mrs_simulator.rqt_plugin.run.staged import read_ahead

SAMPLE_PERIOD = 0.05  # [s] of simulated time between samples kept for the curves
MOST_WAITING = 4000  # [-] kept of each kind while the GUI is busy


def _read_scenario(message):
    read_ahead(message.data)
    return message.data


READERS = {
    "stage": read_stage_status,
    "control": read_control_status,
    "scenario": _read_scenario,
    "emergency": operator.attrgetter("data"),
}


def _read_estimates(message):
    numbers, pose = read_odometry(message)[:2]
    return message.header.stamp.to_sec(), tuple(numbers), pose


QUEUED = {  # what must not be missed, and how it is read
    "collisions": read_collision,
    "incidents": read_incident,
    "applied": read_control_scenario,
    "estimates": _read_estimates,
}


class Inbox(Received):
    """The newest message of each name, and queues of what must not be missed, such as samples."""

    def __init__(self):
        super().__init__()
        self._moves, self._stands = False, False  # whether robots do, and time does
        self._samples = deque(maxlen=MOST_WAITING)
        self._queues = {name: deque(maxlen=MOST_WAITING) for name in QUEUED}
        self._cached = None, False, (), None  # what the last snapshot was made of, and that
        self.controller = Interruptions()

    # Callbacks -----------------------------------------------------------------------------------

    def keep(self, message, name):
        """Keep a ``message`` called ``name``."""
        value = READERS[name](message)
        with self._lock:
            if name == "control":
                self.controller.note(value.stamp, value.running, value.trouble)
            self._put(name, value)

    def keep_state(self, message):
        """Keep a ``TeamState``, and now and then a sample for the curves."""
        stamp = message.header.stamp.to_sec()
        with self._lock:
            last = self._newest.get("state")
            self._put("state", message)
            # The curves need less than every step of a fast simulation.
            kept = self._newest.get("kept", -1.0)
            if last is not None and (last.stage, last.run) != (message.stage, message.run):
                self._begin()  # a reset, another team, another stage
            due = last is None or stamp < kept or stamp >= kept + SAMPLE_PERIOD - 1e-9
            stood, self._moves = not self._moves, is_commanded(message)
            before = None if last is None else last.header.stamp
            went, self._stands = not self._stands, before == message.header.stamp
            begins = stood and self._moves  # a run does, with its very first command
            if due or begins or (went and self._stands):  # or it is over
                self._newest["kept"] = stamp
                self._samples.append(message)

    def add(self, message, name):
        """Append a ``message`` to the queue ``name``, one of ``QUEUED``."""
        self._queues[name].append(message)

    def begin_run(self):
        """Count samples from now on as another run."""
        with self._lock:
            self._begin()

    def _begin(self):
        # Robots may move from its first state on, as they did at the end of the run before.
        self._samples.append(None)
        self._moves = False

    # Reading -------------------------------------------------------------------------------------

    def snapshot(self):
        """Return the ``StateTable`` of the newest state, None before the first."""
        state, stage, fresh = self.newest("state"), self.newest("stage"), self.is_fresh("state")
        if state is None:
            return None
        silent = tuple(stage.real_silent) if fresh and stage is not None else ()
        # Called many times between two messages, and reading one is slow.
        if self._cached[0] is not state or self._cached[1:3] != (fresh, silent):
            self._cached = state, fresh, silent, _from_state(state, fresh, silent)
        return self._cached[3]

    def take_samples(self):
        """Return the snapshots for the curves since the last call, None where a run begins."""
        with self._lock:
            messages = list(self._samples)
            self._samples.clear()
        return [message and _from_state(message, True) for message in messages]

    def take(self, name):
        """Return what ``Connection.take`` does, without messages of another version."""
        taken, waiting = [], self._queues[name]
        while waiting:
            with contextlib.suppress(MessageError):
                taken.append(QUEUED[name](waiting.popleft()))
        return taken


def _from_state(message, fresh, silent=()):
    state = read_state(message)
    known = [fresh and number not in silent for number in state.robots]
    return state.replace(fresh=np.array(known, dtype=bool))
