"""A team that flies, whose controlled points have a height that the law moves, too."""

import numpy as np

from mrs_simulator.vehicles.arms.team import ArmedTeam, ArmedTeamInSpace, has_arms
from mrs_simulator.vehicles.team import Team

CLIMB = "linear.z"


class TeamInSpace(Team):
    """A ``Team`` of which all points move in space, d = 3.

    Places are poses (..., n, 4), with the heights z [m] in their last column; of poses (..., n, 3) the
    robots are on the ground.  Across, each drive does what it does in the plane; up and down the point
    goes as the command's ``linear.z`` says.
    """

    dimension = 3

    def __init__(self, kinds, limits="firmware", relative_to="", own=None):
        """As ``Team``.  Raises ``ValueError`` that names a robot which does not fly."""
        super().__init__(kinds, limits, relative_to, own)
        climbs = [CLIMB in kind.axes for kind in self.kinds]
        if not all(climbs):
            row = climbs.index(False)
            text = "control.dimension: 3, but robot{}, a {}, stays at its height; wanted 2"
            raise ValueError(text.format(row + 1, self.kinds[row].title))
        self._climb = self.axes.index(CLIMB)

    def point(self, pose, joints, l, pointing=None):
        """Return the controlled points (..., n, 3) [m] of robots at ``pose`` (..., n, 4)."""
        result = np.zeros(pose.shape[:-1] + (3,), order="F")
        result[..., :2] = super().point(pose[..., :3], joints, l, pointing)
        if pose.shape[-1] > 3:
            result[..., 2] = pose[..., 3]
        return result

    def velocity(self, command, pose, joints, l, period):
        across = super().velocity(command, pose, joints, l, period)
        return np.column_stack([across, command[:, self._climb]])

    def command(self, velocity, pose, joints, l, period, pointing=None):
        result = super().command(velocity, pose, joints, l, period, pointing)
        result[:, self._climb] = velocity[:, 2]
        return result

    def velocities_in(self, command, pose, points, l, period):
        across = super().velocities_in(command, pose, points[..., :2], l, period)
        return np.concatenate([across, command[..., self._climb, np.newaxis]], axis=-1)


def team_of(scenario, limits="scenario", dimension=2):
    """Return the team of ``scenario`` whose points have ``dimension`` coordinates."""
    team = Team.from_scenario(scenario, limits)
    flat, spatial = (ArmedTeam, ArmedTeamInSpace) if has_arms(team.kinds) else (Team, TeamInSpace)
    wanted = spatial if dimension == 3 else flat
    return team if wanted is Team else wanted.from_scenario(scenario, limits)
