"""How long a run lasts: the service ``pause_after`` of a stage."""

from mrs_simulator.nodes.stage.part import StagePart


class RunLength(StagePart):
    """Counts the steps of a run from the first command that moves a robot on, where that is asked for."""

    def __init__(self, world):
        self._world = world
        self._wanted, self._left = 0, None  # steps of the run; left of them, None before it begins

    def ask(self, steps):
        """Let the run that has not begun yet, or goes on, last for so many ``steps``; 0: without an end."""
        self._wanted, self._left = steps, None

    def follow_team(self, scenario):
        """Let the next run, of robots that were put back or changed, go on without an end."""
        self.ask(0)

    def before_step(self):
        """Begin to count with the first command that moves a robot."""
        if self._wanted and self._left is None and self._world.command.any():
            self._left = self._wanted

    def after_step(self):
        """Count a step."""
        if self._left is not None:
            self._left -= 1

    def take_end(self):
        """Return whether the run is over, once."""
        if self._left != 0:
            return False
        self.ask(0)
        return True
