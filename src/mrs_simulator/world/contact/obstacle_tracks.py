"""Obstacles of a world that move on their tracks."""

from mrs_simulator.scenario.surroundings.moving_obstacles import obstacles_at
from mrs_simulator.world.part import Part


class ObstacleTracks(Part):
    """Moves obstacles on tracks, whatever is in their way."""

    def __init__(self, motion, clock, obstacles):
        """``obstacles`` as they begin."""
        self._motion, self._clock, self._obstacles = motion, clock, obstacles

    def before_step(self, command):
        """Let obstacles be where they are after this step; return ``command``."""
        then = (self._clock.steps + 1) * self._clock.step_size
        self._motion.move_obstacles(obstacles_at(self._obstacles, then))
        return command
