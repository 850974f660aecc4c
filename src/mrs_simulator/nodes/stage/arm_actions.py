"""The action ``follow_joint_trajectory`` of the simulated arms, as ros_controllers offer it.

Its packages, ``actionlib`` and ``control_msgs``, are not everywhere: whoever imports this has them.
"""

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryResult

from mrs_simulator.ros.receive.withdrawal import withdraw

NAME = "/robot{}/arm_controller/follow_joint_trajectory"
NAP = 0.01  # [s] of wall time between two looks at how far an arm has come


class ArmAction:
    """The action of one arm; its goals are followed as trajectories on the arm's topic are."""

    def __init__(self, row, put, outcome):
        """``put(row, trajectory)`` begins one, None stops the arm; ``outcome(row)`` says how it went.

        None while it goes on, "" when it has ended, else why it was refused or broken off.
        """
        self._row, self._put, self._outcome = row, put, outcome
        self._server = actionlib.SimpleActionServer(
            NAME.format(row + 1), FollowJointTrajectoryAction, self._follow, auto_start=False
        )
        self._server.start()

    def _follow(self, goal):
        self._put(self._row, goal.trajectory)
        while not rospy.is_shutdown():
            if self._server.is_preempt_requested():
                self._put(self._row, None)
                self._server.set_preempted()
                return
            outcome = self._outcome(self._row)
            if outcome is not None:
                break
            rospy.rostime.wallsleep(NAP)
        else:
            return
        result = FollowJointTrajectoryResult(error_string=outcome)
        if outcome:
            result.error_code = FollowJointTrajectoryResult.INVALID_GOAL
            self._server.set_aborted(result, outcome)
        else:
            self._server.set_succeeded(result)

    def unregister(self):
        """Withdraw the action's topics."""
        server = self._server.action_server
        for topic in (server.goal_sub, server.cancel_sub):
            withdraw(topic)
        for topic in (server.status_pub, server.result_pub, server.feedback_pub):
            topic.unregister()
