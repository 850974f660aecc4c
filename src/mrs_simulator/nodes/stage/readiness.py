"""What a stage waits for before its first step."""

from mrs_simulator.nodes.stage.recorders import Recorders
from mrs_simulator.ros.node.node_parameters import WAIT_FOR_CONTROL, WAIT_FOR_RECORDERS
from mrs_simulator.ros.node.parameters import read


class Readiness:
    """Waits for commands and recorders, as the node's parameters say."""

    def __init__(self):
        self._control = read(WAIT_FOR_CONTROL)
        self._recorders = Recorders(read(WAIT_FOR_RECORDERS))

    def missing(self, stage):
        """Return what is missing, a list of texts, to be asked until there is nothing."""
        lockstep = stage.lockstep
        waits = []
        silent = stage.topics.uncommanded() if (self._control or lockstep) else []
        if silent:
            waits.append("commands for {} of {} robots".format(len(silent), stage.world.n))
        if lockstep and stage.topics.unlistened():
            waits.append("a listener to each robot's odometry")
        elif lockstep and not lockstep.settled():
            waits.append("the first commands")
        missing = self._recorders.missing(*stage.topics.recorders())
        waits += [missing] if missing else []
        return waits
