"""A load between the tools of robots, without forces of motion: what robots feel of it, and whether they
keep hold of it.

It rests where the grips' springs, all alike, are in balance, so that the misfit ``d_i`` of robot i's tool
from its grasp costs the internal force ``K d_i``; and its weight is shared by ``G+ w`` (``core.grasps``).
How far the weight bends the springs is left out, and so are the forces of acceleration.
"""

import numpy as np

from mrs_simulator.core import grasps
from mrs_simulator.state.columns import LoadState

REACH = 0.1  # [m] from its grasp, at which a robot may take hold


class LoadError(ValueError):
    """A load that the robots cannot take hold of; the message names the robot and the reason."""


class CarriedLoad:
    """A ``Load`` carried by n robots."""

    def __init__(self, load, points):
        """``points`` (n, 3) [m]: the robots' tools as they take hold.  Raises ``LoadError``."""
        self.load, self.grasps = load, np.array(load.grasps)
        self.held = np.ones(len(self.grasps), dtype=bool)
        self.state = self._balanced(points)
        misfit = np.linalg.norm(self._misfit(points), axis=1)
        row = int(np.argmax(misfit))
        if misfit[row] > REACH:
            text = "load: the tool of robot{} is {:.3f} m from its grasp, wanted within {:g} m"
            raise LoadError(text.format(row + 1, misfit[row], REACH))

    def _misfit(self, points):
        return points - grasps.grasp_points(self.grasps, self.state.place, self.state.orientation)

    def _balanced(self, points):
        """Return the load's state between the tools at ``points`` (n, 3) that hold it."""
        held, force = self.held, np.zeros_like(self.grasps)
        place, turn = grasps.fitted_pose(self.grasps[held], points[held])
        at = grasps.grasp_points(self.grasps[held], place, turn)
        misfit = points[held] - at
        force[held] = (
            grasps.least_forces(at - place, self.load.weight) + self.load.stiffness * misfit
        )
        return LoadState(place, turn, force)

    def update(self, points):
        """Move the robots' tools to ``points`` (n, 3) [m]; return the rows of robots that let go.

        The robot whose grip would have to hold more than it can, and the most, lets go; where those left
        are fewer than three, or on a line, the load falls.
        """
        gone = []
        while self.held.any():
            state = self._balanced(points)
            size = np.linalg.norm(state.force, axis=1)
            row = int(np.argmax(size))
            if size[row] <= self.load.grip:
                self.state = state
                break
            self.held[row] = False
            gone.append(row)
            if not grasps.are_noncollinear(self.grasps[self.held]):
                self.fall()
        return gone

    def fall(self):
        """Put the load, which no robot holds, on the ground below."""
        self.held[:] = False
        place = self.state.place.copy()
        place[2] = 0.5 * min(self.load.size)
        _, _, z, w = self.state.orientation
        level = np.array([0.0, 0.0, z, w]) / max(np.hypot(z, w), 1e-12)
        self.state = LoadState(place, level, np.zeros_like(self.grasps))
