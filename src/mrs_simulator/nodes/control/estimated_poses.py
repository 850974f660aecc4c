"""Poses that the control estimates from odometry and sensors, as the scenario's ``estimates`` say."""

import numpy as np
import rospy

from mrs_simulator.nodes.control.common_frame import LocalisedFrame
from mrs_simulator.ros.message_forms.messages import TeamOdometry, team_odometry
from mrs_simulator.sensors.pose_filter.estimation import Estimator
from mrs_simulator.vehicles import Team

TOPIC = "pioneer_control/estimates"  # name as its listeners resolve it
ATTEMPTS = 5  # [-] at reading poses and stamps between two messages


class EstimatedPoses:
    """Runs the ``Estimator`` of a scenario on what a ``CommonFrame`` and a ``SensorInbox`` have received.

    It begins where odometry is first received, and begins anew if simulated time goes back.
    """

    def __init__(self, scenario, frame, sensors):
        """``sensors``: the inbox, None for an estimator that asks for none.

        Raises ``ValueError`` for sensors that robots lack, and where something else localises them.
        """
        if isinstance(frame, LocalisedFrame):
            text = "estimates: {}, and robots localised by ~frame_source; wanted one of them"
            raise ValueError(text.format(scenario.estimates.source))
        self._scenario, self._frame, self._sensors = scenario, frame, sensors
        self._begin()
        self._publisher = rospy.Publisher(TOPIC, TeamOdometry, queue_size=100, latch=True)

    def _begin(self):
        scenario = self._scenario
        self._estimator = Estimator.of_scenario(scenario, Team.from_scenario(scenario))
        self._newest = None

    def update(self):
        """Take in what has come, and publish the poses if odometry has."""
        stamps, pose = self._odometry()
        if not np.isfinite(pose).all():
            return
        if self._newest is not None and (stamps < self._newest).any():
            self._begin()
        readings = self._sensors.take() if self._sensors else []
        self._estimator.update(stamps, pose, readings)
        if self._newest is None or (stamps > self._newest).any():
            self._newest = stamps
            stamp = rospy.Time(*divmod(int(stamps.max()), 10**9))
            numbers = self._frame.numbers
            self._publisher.publish(team_odometry(numbers, self._estimator.pose, stamp=stamp))

    def _odometry(self):
        """Return when odometry was true, (n,) [ns], and the poses (n, 3) that it has."""
        inbox = self._frame.inbox
        for _ in range(ATTEMPTS):
            stamps = inbox.true_times()
            pose = self._frame.pose()
            if np.array_equal(stamps, inbox.true_times()):
                break
        return stamps, pose

    def pose(self):
        """Return the poses (n, 3) as they are estimated, nan before odometry of all came."""
        return (
            np.full((self._scenario.n, 3), np.nan) if self._newest is None else self._estimator.pose
        )

    def restart(self, rows):
        """Accept the next odometry of robots ``rows``: a person has put them there."""
        self._estimator.restart(rows)

    @property
    def late(self):
        """Return how many readings so far came too late to be taken in."""
        return self._estimator.late
