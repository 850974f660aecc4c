"""Components of Twist that a robot does not obey: left out, counted, and said once."""

import numpy as np
import rospy

from mrs_simulator.core.kinematics import TWIST_AXES
from mrs_simulator.nodes.stage.part import StagePart


class IgnoredAxes(StagePart):
    """Takes from the Twists that came what each robot obeys."""

    def __init__(self, world):
        self._world, self._team, self._said = world, None, set()
        self.counts = np.zeros(0, dtype=int)  # of commands by robot

    def follow_team(self, scenario):
        """Count anew, for the world's robots."""
        team = self._world.team
        team = team.bases if team.has_arms else team  # arms obey no Twist
        self._team, self.counts, self._said = team, np.zeros(team.n, dtype=int), set()
        self._columns = [TWIST_AXES.index(axis) for axis in team.axes]
        self._obeyed = np.zeros((team.n, len(TWIST_AXES)), dtype=bool)
        self._obeyed[:, self._columns] = team.robot_axes

    def taken(self, rows, commands):
        twists = commands
        left_out = (twists != 0.0) & ~self._obeyed[rows]
        if left_out.any():
            self._note(np.asarray(rows), left_out)
            twists = np.where(left_out, 0.0, twists)
        return twists[:, self._columns]

    def _note(self, rows, left_out):
        self.counts[rows[left_out.any(axis=1)]] += 1
        for at, column in np.argwhere(left_out).tolist():
            row, axis = int(rows[at]), TWIST_AXES[column]
            if (row, axis) not in self._said:
                self._said.add((row, axis))
                kind = self._team.kinds[row]
                rospy.logwarn(
                    "stage: robot%d was commanded %s, which a %s does not obey; it obeys %s",
                    row + 1,
                    axis,
                    kind.title,
                    ", ".join(kind.axes),
                )
