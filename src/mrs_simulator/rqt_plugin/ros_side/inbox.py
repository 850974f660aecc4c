"""What stage and controller said last; callbacks of rospy put it in, the GUI's timers take it out."""

import contextlib
import threading
import time
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
from mrs_simulator.rqt_plugin.run.history import Snapshot

SAMPLE_PERIOD = 0.05  # [s] of simulated time between samples kept for the curves
MOST_WAITING = 4000  # [-] samples kept while the GUI is busy
MOST_COLLISIONS = 1000  # [-] kept meanwhile
SILENCE = 1.5  # [s] of wall time after which the stage, the controller or a robot counts as silent
READERS = {"stage": read_stage_status, "control": read_control_status}


class Inbox:
    """The newest message of each name, and samples and collisions since they were last taken."""

    def __init__(self):
        self._lock = threading.Lock()
        self._newest, self._heard, self._moves = {}, {}, False
        self._samples = deque(maxlen=MOST_WAITING)
        self._collisions = deque(maxlen=MOST_COLLISIONS)
        self._incidents = deque(maxlen=MOST_COLLISIONS)
        self._estimates, self._obeyed = deque(maxlen=MOST_WAITING), deque(maxlen=MOST_WAITING)
        self._told = None, False, (), None  # the last snapshot, after what it was made of
        self.controller = Interruptions()

    # What comes in -------------------------------------------------------------------------------

    def keep(self, message, name):
        """Keep a ``message`` called ``name``."""
        told = READERS[name](message) if name in READERS else message
        with self._lock:
            if name == "control":
                self.controller.note(told.stamp, told.running, told.trouble)
            self._newest[name], self._heard[name] = told, time.monotonic()

    def keep_state(self, message):
        """Keep a ``TeamState``, and now and then a sample for the curves."""
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

    def keep_collision(self, message):
        """Keep a collision."""
        self._collisions.append(message)

    def keep_incident(self, message):
        """Keep an incident."""
        self._incidents.append(message)

    def keep_estimates(self, message):
        """Keep the poses that a controller has estimated."""
        self._estimates.append(message)

    def keep_obeyed(self, message):
        """Keep what a controller obeys."""
        self._obeyed.append(message)

    def begin_run(self):
        """Count what is heard from now on as another run."""
        with self._lock:
            self._samples.append(None)

    # What is taken -------------------------------------------------------------------------------

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
        """Return the ``Snapshot`` of the newest state, None before the first."""
        state, stage, fresh = self.newest("state"), self.newest("stage"), self.is_fresh("state")
        if state is None:
            return None
        silent = tuple(stage.real_silent) if fresh and stage is not None else ()
        # Asked for many times between two messages, of which each takes a while to take apart.
        if self._told[0] is not state or self._told[1:3] != (fresh, silent):
            self._told = state, fresh, silent, _from_state(state, fresh, silent)
        return self._told[3]

    def take_samples(self):
        """Return the snapshots for the curves since the last call, None where a run begins."""
        with self._lock:
            messages = list(self._samples)
            self._samples.clear()
        return [message and _from_state(message, True) for message in messages]

    def take_collisions(self):
        """Return the ``core.recording.Collision``s since the last call."""
        taken = []
        while self._collisions:
            taken.append(read_collision(self._collisions.popleft()))
        return taken

    def take_incidents(self):
        """Return the ``core.incidents.Incident``s since the last call; what is none is left out."""
        taken = []
        while self._incidents:
            try:
                taken.append(read_incident(self._incidents.popleft()))
            except MessageError:  # of another version
                continue
        return taken

    def take_obeyed(self):
        """Return what controllers obeyed since the last call, ``(stamp [s], {key: value})`` of each."""
        taken = []
        while self._obeyed:
            with contextlib.suppress(MessageError):  # of another version
                taken.append(read_control_scenario(self._obeyed.popleft()))
        return taken

    def take_estimates(self):
        """Return the estimates since the last call, ``(stamp [s], numbers, pose (n, 3))`` of each time."""
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
        state.load,
    )
