"""The poses that the control node estimated, beside the samples of a run."""

import threading
import time
from collections import deque

import rospy

from mrs_simulator.nodes.control.common_frame import LocalisedFrame
from mrs_simulator.nodes.control.estimated_poses import TOPIC
from mrs_simulator.ros.message_forms.messages import MessageError, TeamOdometry, read_odometry
from mrs_simulator.verdict.estimation import OLDEST, UNKNOWN

CONNECTED, NAP = 15.0, 0.02  # [s] of wall time
PATIENCE = 1.0  # [s] of wall time that a sample waits for the estimates of its time
KEPT = 500  # [-] newest messages
REPORT = 5.0  # [s] of wall time between two reports of samples that are left out


class EstimatesSource:
    """Adds to the samples of a source the estimates that the control knew then."""

    def __init__(self, make, n):
        """``make()`` makes the source of samples of ``n`` robots, once the control node is connected."""
        self._n, self._received = n, deque(maxlen=KEPT)
        self._came = threading.Condition()
        self._held, self._since = None, 0.0
        self._lost, self._begun = 0, False
        self._subscriber = rospy.Subscriber(TOPIC, TeamOdometry, self._put, tcp_nodelay=True)
        self._wait()
        self._source = make()
        frame = getattr(self._source, "frame", None)
        self._truth_unknown = frame is not None and not isinstance(frame, LocalisedFrame)

    def _wait(self):
        """Wait for the control node: a stage may begin as soon as its state has subscribers."""
        end = time.monotonic() + CONNECTED
        while not self._subscriber.get_num_connections() and time.monotonic() < end:
            if rospy.is_shutdown():
                return
            time.sleep(NAP)

    def __getattr__(self, name):
        return getattr(self._source, name)

    def _put(self, message):
        try:
            numbers, pose, _, _ = read_odometry(message)
        except MessageError as error:
            rospy.logerr_throttle(REPORT, "record: estimates: {}".format(error))
            return
        if list(numbers) != list(range(1, self._n + 1)):
            return
        with self._came:
            self._received.append((message.header.stamp.to_sec(), pose))
            self._came.notify()

    def begin(self):
        """Leave out from now on what has no estimates, also of robots that are not commanded."""
        self._begun = True
        self._source.begin()

    def next(self, seconds):
        """Return the next ``StateTable`` with its estimates; None after ``seconds`` [s] without any."""
        if self._held is None:
            self._held, self._since = self._source.next(seconds), time.monotonic()
        sample = self._held
        if sample is None:
            return None
        estimate, is_final = self._at(sample.time, seconds)
        waited = time.monotonic() - self._since > PATIENCE
        wanted = sample.commanded.any() or self._begun
        if not (is_final or waited or not wanted and estimate is None):
            return None
        self._held = None
        if estimate is None and wanted:
            self._lost += 1
            text = "record: no estimates of {:.3f} s: the sample is left out"
            rospy.logerr_throttle(REPORT, text.format(sample.time))
            return None
        pose = sample.pose if estimate is None or not self._truth_unknown else estimate
        return sample.replace(pose=pose, estimate=estimate)

    def _at(self, stamp, seconds):
        """Return the estimates that held at ``stamp`` [s] or None, and whether later ones are there.

        Of real robots, whose samples are of now, the newest are all that there are.
        """
        with self._came:
            if not self._source.PACED and not self._is_past(stamp):
                self._came.wait(seconds)
            held = [each for each in self._received if stamp - OLDEST <= each[0] <= stamp + 1e-6]
            is_final = self._source.PACED or self._is_past(stamp)
        return (held[-1][1] if held else None), is_final

    def _is_past(self, stamp):
        return bool(self._received) and self._received[-1][0] >= stamp - 1e-6

    def meta(self):
        """Return what else is known of the run: of real robots the truth is not."""
        facts = dict(self._source.meta())
        if self._truth_unknown:
            facts["truth_unknown"] = True
        return facts

    def warnings(self):
        """Return what is missing, a list of texts."""
        text = "{} samples are left out: the control node published no estimates of their time"
        lost = [text.format(self._lost)] if self._lost else []
        return self._source.warnings() + lost + ([UNKNOWN] if self._truth_unknown else [])
