"""What the curves of one run are drawn from, and how those of compared runs differ; without Qt."""

import numpy as np

from mrs_simulator.rqt_plugin.curves.quantities import Curve, ErrorCurve, positive

USUAL_AXES = ("linear.x", "angular.z")
LONGEST = 30  # [characters] of a run's name in a legend


class Source:
    """A run's ``history``, its formation error beside theory's, and its name among others."""

    def __init__(self, history, name=""):
        self.history, self.name = history, name
        self.error, self.theory = ErrorCurve(), None
        # axes of the commands, and whether the team leaves the ground
        self.team = USUAL_AXES, False

    def set_prediction(self, time, error):
        """Take theory's ``error`` [m] at ``time`` [s] of the run; None, None: no theory."""
        theory = None
        if time is not None and error is not None:
            theory = np.array(time, dtype=float), positive(np.array(error, dtype=float))
            if theory[0].ndim != 1 or theory[0].shape != theory[1].shape:
                raise ValueError("times {}, errors {}".format(*(part.shape for part in theory)))
        self.theory = theory

    @property
    def begin(self):
        """Return the time [s] at which the run begins, 0 before it does."""
        return self.history.begin

    @property
    def lasts(self):
        """Return how long [s] the run has lasted, 0 before it begins."""
        time = self.history.time
        return float(time[-1]) - self.begin if len(time) else 0.0

    @property
    def short_name(self):
        """Return the name as a legend has it."""
        cut = self.name[: LONGEST - 3] + "..."
        return self.name if len(self.name) <= LONGEST else cut

    def is_complete(self):
        """Go on with the formation error; return whether it is known of all samples."""
        history = self.history
        return self.error.update(history.numbers, history.time, history.pose)

    def error_curve(self, style):
        """Return the ``Curve`` of the error against the time since the run began; None without any."""
        values = positive(self.error.values)
        if not len(values):
            return None
        time = self.history.time[: len(values)] - self.begin
        return Curve(self.name, time, values, style, self.short_name)

    def state_curves(self, values, chosen, styles_of):
        """Return the ``Curve``s of ``values`` (of a state: (m, n)) of the robots that are ``chosen``.

        Against the time since the run began; ``styles_of(shown, numbers)``: their styles.
        """
        history = self.history
        rows = [row for row, number in enumerate(history.numbers) if chosen(number)]
        if not rows or not len(history.time):
            return []
        table, time = values(history.state), history.time - self.begin
        shown = [history.numbers[row] for row in rows]
        names = ["Robot {}".format(number) for number in shown]
        names = ["{}, {}".format(each, self.name) for each in names] if self.name else names
        run, found = self.short_name, zip(names, rows, styles_of(shown, history.numbers))
        return [
            Curve(name, time, table[:, row], style, run, history.numbers[row])
            for name, row, style in found
        ]
