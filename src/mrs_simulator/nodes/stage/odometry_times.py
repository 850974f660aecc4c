"""When a stage publishes odometry, and when periods of commands end."""

from mrs_simulator.core.step_rates import steps_between
from mrs_simulator.nodes.stage.starting import odometry_rate
from mrs_simulator.vehicles.odometry_rates import OdometrySchedule, odometry_notes, odometry_steps


class OdometryTimes:
    """The steps of a stage after which odometry of each robot is due, each at its own rate."""

    def __init__(self, world, scenario, usual):
        """``usual`` [Hz]: of odometry where neither ``scenario`` nor ``~odom_rate`` says another."""
        self._world, self._rate = world, odometry_rate(scenario, usual)
        self._steps_between_commands = steps_between(scenario.control.rate, world.step_size)
        self.begin(0)

    def begin(self, step):
        """Begin anew at ``step`` with the robots that the world has now."""
        self.begun, size = step, self._world.step_size
        self._schedule = OdometrySchedule(odometry_steps(self._world.team, self._rate, size))
        self._steps_per_command = max(self._schedule.shortest, self._steps_between_commands)
        self.command_period = size * self._steps_per_command  # [s]

    def due(self, step):
        """Return the rows of the robots whose odometry is due after ``step``."""
        return self._schedule.due(step - self.begun)

    def ends_period(self, step):
        """Return whether a period of commands ends with ``step``."""
        return step % self._steps_per_command == 0

    def notes(self):
        """Return notes for users on rates that steps do not allow, a list of texts."""
        return odometry_notes(self._world.team, self._rate, self._world.step_size)
