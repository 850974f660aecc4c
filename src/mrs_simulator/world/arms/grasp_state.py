"""The grasps of a team with arms, and the joints that are at their ends."""

import numpy as np

from mrs_simulator.scenario.incidents import ARM_END, FELL, LET_GO
from mrs_simulator.world.arms.carrying import CarriedLoad, LoadError
from mrs_simulator.world.checks import WorldError
from mrs_simulator.world.part import Part


def refuse_load(load, team, poses, hand_length):
    """Raise ``WorldError`` if a ``team`` at ``poses`` (n, 3) cannot take hold of ``load``, or None."""
    if load is None:
        return
    if not team.has_arms or any(each.arm is None for each in team.kinds):
        raise WorldError("load: wanted robots that all have an arm")
    if team.n != len(load.grasps):
        text = "load: {} grasps, wanted one for each of {} robots"
        raise WorldError(text.format(len(load.grasps), team.n))
    try:
        CarriedLoad(load, team.tools(poses, team.rest_joints, hand_length))
    except LoadError as error:
        raise WorldError(str(error)) from None


class GraspState(Part):
    """The grasps of the tools, and incidents of arms and load."""

    def __init__(self, team, motion, faults, hand_length, load):
        """``load``: a ``scenario.team.load.Load`` of which all take hold, or None."""
        self._team, self._motion, self._faults = team, motion, faults
        self._hand_length = hand_length
        self._ended = set()  # (row, joint) of those that have been at their ends
        carry = getattr(motion, "carry", CarriedLoad)
        self.load = None if load is None else carry(load, self._tools())  # as it is carried

    def columns(self):
        """Return the load's state, where there is a load."""
        return {"load": self.load.state} if self.load else {}

    def _tools(self):
        return self._team.tools(self._motion.pose, self._motion.joints(), self._hand_length)

    def after_step(self):
        """Report the joints that have come to an end and the grasps that let go in this step."""
        ended = set(map(tuple, np.argwhere(self._motion.ended).tolist()))
        for row, joint in sorted(ended - self._ended):
            self._faults.report(row, ARM_END, joint + 1)
        self._ended |= ended
        if self.load:
            for row in self.load.update(self._tools()):
                self._faults.report(row, LET_GO if self.load.held.any() else FELL)
