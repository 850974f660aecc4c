"""Experiments whose law is Python's, and whose steps from one command to the next are one compiled call."""

import numpy as np

from mrs_simulator.control.array_law import is_bare
from mrs_simulator.core.compiling import same_bits
from mrs_simulator.world.motion.commanded_steps import (
    BY_STEP,
    COMMAND,
    DUE,
    FAR,
    NOTHING,
    ODD,
    SAMPLE,
    CommandedSteps,
    compiled_steps,
)


class Stepping:
    """The steps of an ``Experiment``, of which ``CommandedSteps`` make all that they can.

    They have the bits of ``Experiment.go_on``, so that it is free when they begin.
    """

    @staticmethod
    def fits(experiment):
        """Return whether an ``Experiment`` can go on so."""
        if not (is_bare(experiment.control) and experiment.can_leap):
            return False
        return CommandedSteps.fit(experiment.world, experiment.scenario.steps_per_command)

    def __init__(self, experiment, most):
        """``most``: how many samples a call makes at most; it changes no bit of them."""
        self._experiment, self._world, self._most = experiment, experiment.world, most
        scenario = experiment.scenario
        self._every, self._between = scenario.steps_per_command, scenario.steps_per_record
        self._moved = None  # the ``CommandedSteps``

    def is_worth(self):
        """Return whether robots are to go on by compiled steps now, since they have touched for long."""
        if self._moved is None:
            touched = self._between if self._world.motion.contacts() else 0
            step = same_bits(compiled_steps, size=touched)
            if step is None:
                return False
            control, rates = self._experiment.control, (self._every, self._between)
            self._moved = CommandedSteps(self._world, step, control.l, control.saturation, rates)
        return self._experiment.sensors.is_idle

    def block(self, steps):
        """Go on towards ``steps``; yield samples as ``Leaping.blocks`` does, or nothing.

        Raises what the law leads to, after the samples before it.
        """
        experiment, size = self._experiment, self._world.step_size
        first = experiment.step - experiment.step % self._between + self._between
        self._kept, self._filled = np.empty((self._most, 5, self._world.n)), 0
        self._moved.begin(self._kept)
        raised = None
        try:
            self._go_on(steps)
        except (Exception, KeyboardInterrupt) as error:
            raised = error
        self._give_back()
        if self._filled:
            sampled = range(first, first + self._filled * self._between, self._between)
            rows = self._kept[: self._filled].transpose(0, 2, 1)
            yield [each * size for each in sampled], rows[:, :, :3], rows[:, :, 3:]
        if raised is not None:
            raise raised

    def _go_on(self, steps):
        experiment, moved = self._experiment, self._moved
        due = experiment.step < 0
        points, first, velocity = due and experiment.control.points(self._world.pose), NOTHING, None
        while True:
            if due:
                velocity, first = experiment.asked(self._velocity, points), COMMAND
            why = moved.advance(steps, first, velocity)
            if why == DUE:
                points, due = moved.points, True
                continue
            self._give_back()
            if why not in (FAR, ODD, BY_STEP):
                return
            first, due = SAMPLE, False
            if why == FAR:
                experiment.sample()  # which raises
            elif why == ODD:
                experiment.command_as(velocity)
            else:
                experiment.advance()
                experiment.step += 1
                due = experiment.step % self._every == 0
                points = due and experiment.control.points(self._world.pose)
            moved.begin(self._kept[self._filled :])

    def _velocity(self, points):
        """Return the velocities (n, 2) [m/s] that the law wants; where it raises, the world is there."""
        try:
            return self._experiment.control.runner.velocities(points, self._moved.time)
        except BaseException:
            self._give_back()
            raise

    def _give_back(self):
        """Let world and experiment be where robots have come to."""
        if self._moved.is_on:
            self._filled += self._moved.end()
            self._experiment.collisions.extend(self._world.contacts.take())
            self._experiment.step = self._world.steps
