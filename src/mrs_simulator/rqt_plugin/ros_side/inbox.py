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

SAMPLE_PERIOD = 0.05  # [s] of simulated time between samples kept for the curves
MOST_WAITING = 4000  # [-] samples kept while the GUI is busy
MOST_COLLISIONS = 1000  # [-] kept meanwhile
READERS = {
    "stage": read_stage_status,
    "control": read_control_status,
    "scenario": operator.attrgetter("data"),
    "emergency": operator.attrgetter("data"),
}


class Inbox(Received):
    """The newest message of each name, and queues of what must not be missed, such as samples."""

    def __init__(self):
        super().__init__()
        self._moves = False
        self._samples = deque(maxlen=MOST_WAITING)
        self._collisions = deque(maxlen=MOST_COLLISIONS)
        self._incidents = deque(maxlen=MOST_COLLISIONS)
        self._estimates, self._applied = deque(maxlen=MOST_WAITING), deque(maxlen=MOST_WAITING)
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
            if due or (stood and self._moves):  # a run begins with its very first command
                self._newest["kept"] = stamp
                self._samples.append(message)

    def keep_collision(self, message):
        """Keep a collision."""
        self._collisions.append(message)

    def keep_incident(self, message):
        """Keep an incident."""
        self._incidents.append(message)

    def keep_estimates(self, message):
        """Keep the poses that a controller estimates."""
        self._estimates.append(message)

    def keep_applied(self, message):
        """Keep the scenario that a controller applies."""
        self._applied.append(message)

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

    def take_collisions(self):
        """Return the ``recording.Collision``s since the last call."""
        taken = []
        while self._collisions:
            taken.append(read_collision(self._collisions.popleft()))
        return taken

    def take_incidents(self):
        """Return the ``incidents.Incident``s since the last call, without unreadable ones."""
        taken = []
        while self._incidents:
            try:
                taken.append(read_incident(self._incidents.popleft()))
            except MessageError:  # of another version
                continue
        return taken

    def take_applied(self):
        """Return what controllers applied since the last call, a list of ``(stamp [s], {key: value})``."""
        taken = []
        while self._applied:
            with contextlib.suppress(MessageError):  # of another version
                taken.append(read_control_scenario(self._applied.popleft()))
        return taken

    def take_estimates(self):
        """Return the estimates since the last call, a list of ``(stamp [s], numbers, pose (n, 3))``."""
        taken = []
        while self._estimates:
            message = self._estimates.popleft()
            try:
                numbers, pose = read_odometry(message)[:2]
            except MessageError:  # of another version
                continue
            taken.append((message.header.stamp.to_sec(), tuple(numbers), pose))
        return taken


def _from_state(message, fresh, silent=()):
    state = read_state(message)
    known = [fresh and number not in silent for number in state.robots]
    return state.replace(fresh=np.array(known, dtype=bool))
