"""The simulated time of a world."""


class Clock:
    """Counts whole steps, so that time does not drift."""

    def __init__(self, step_size):
        """``step_size`` [s] of one step."""
        self.step_size = step_size
        self.steps = 0  # made so far
        self.begun = 0  # the step at which the run began, after a reset or a take-off
        self.waits = False  # whether the run has not begun: robots still take off

    @property
    def time(self):
        """Return the simulated time [s]."""
        return self.steps * self.step_size

    def since(self, step):
        """Return the time [s] since ``step``, or since each of an array of steps."""
        return (self.steps - step) * self.step_size

    def rewind(self):
        """Begin again at 0."""
        self.steps = self.begun = 0
