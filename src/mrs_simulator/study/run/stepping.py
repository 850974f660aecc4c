"""Experiments whose law is Python's, and whose steps from one command to the next are one compiled call."""

import numpy as np

from mrs_simulator.control.array_law import has_plain_loop, is_bare
from mrs_simulator.core.compiling import is_chosen, is_kept, same_bits
from mrs_simulator.world.motion.commanded_steps import (
    BY_STEP,
    COMMAND,
    DUE,
    ENOUGH,
    FAR,
    NOTHING,
    ODD,
    SAMPLE,
    CommandedSteps,
    compiled_steps,
)

APART = 0.25  # [-] of what a compiled step saves where robots touch it saves of those that do not


class Stepping:
    """The steps of an ``Experiment``, of which ``CommandedSteps`` make all that they can.

    They have the bits of ``Experiment.go_on``, so that it is free when they begin.
    """

    @staticmethod
    def fits(experiment):
        """Return whether an ``Experiment`` can go on so."""
        if not (has_plain_loop(experiment.control) and experiment.can_fuse_between_readings):
            return False
        return CommandedSteps.fit(experiment.world, experiment.scenario.steps_per_command)

    def __init__(self, experiment, most):
        """``most``: how many samples a call makes at most; it changes no bit of them."""
        self._experiment, self._world, self._most = experiment, experiment.world, most
        scenario = experiment.scenario
        self._every, self._between = scenario.steps_per_command, scenario.steps_per_record
        control = experiment.control
        self._is_bare = is_bare(control)  # else control has the law's commands limited, and changed
        safety, by_points = control.safety_filter, control.runner.is_by_points
        self._by_points = self._is_bare and by_points
        # Whether its law is given points, by which the filter finds commands.
        self._is_filtered = by_points and safety.acts and safety.limits_velocities
        self._sees_points = self._by_points or self._is_filtered
        self._moved = None  # the ``CommandedSteps``
        self._made = None  # whether these need not be compiled

    def is_worth(self):
        """Return whether robots are to go on by compiled steps now, since they have done without for long.

        Where they do not touch that saves too little to wait until numba has compiled them.
        """
        if self._moved is None:
            touch = bool(self._world.motion.contacts())
            if not touch and self._experiment.step % self._between:
                return False  # looked at seldom
            step = same_bits(compiled_steps, size=self._between * (1.0 if touch else APART))
            if step is None or not (touch or self._is_made(step)):
                return False
            control, rates = self._experiment.control, (self._every, self._between)
            l = control.l if self._sees_points else None
            scope = control.saturation if self._is_bare else "none"
            self._moved = CommandedSteps(self._world, step, l, self._by_points, scope, rates)
        return self._moved.has_room

    def _is_made(self, step):
        """Return whether ``step`` is compiled already, or is to be in any case."""
        if self._made is None:
            self._made = is_chosen() or is_kept(step)
        return self._made

    def block(self, steps):
        """Go on towards ``steps``; yield samples as ``FusedSteps.blocks`` does, or nothing.

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
        experiment, moved, sensors = self._experiment, self._moved, self._experiment.sensors
        due = experiment.step < 0
        reading = self._read(max(0, experiment.step)) if due else sensors.next_due(experiment.step)
        seen, first, wanted = due and self._seen(self._world.pose), NOTHING, None
        while True:
            if due:
                wanted, first = experiment.asked(self._asked, seen), COMMAND
            why, due = moved.advance(min(steps, reading), first, wanted), False
            is_read = moved.now == reading and why in (DUE, ENOUGH)
            if is_read:
                reading = self._read(reading)
            if why == DUE:
                due, seen = True, moved.pose
                if self._sees_points:
                    seen = self._with_points(seen, moved.points)
            if why == DUE or is_read:
                first = NOTHING
                continue
            self._give_back()
            if why not in (FAR, ODD, BY_STEP):
                return
            first, due = SAMPLE, False
            if why == FAR:
                experiment.sample()  # which raises
            elif why == ODD:
                self._give(wanted)
            else:
                experiment.advance()
                experiment.step += 1
                reading = self._read(experiment.step)
                due = experiment.step % self._every == 0
                seen = due and self._seen(self._world.pose)
                steps = steps if moved.has_room else experiment.step
            moved.begin(self._kept[self._filled :])

    def _read(self, step):
        """Read the sensors that are due at ``step``; return when some are next."""
        sensors = self._experiment.sensors
        if not sensors.is_idle:
            sensors.update(step, self._moved.sensed if self._moved.is_on else self._world.sensed)
        return sensors.next_due(step)

    def _seen(self, pose):
        """Return what the law sees of robots at ``pose`` (n, 3): their points (n, 2), or this, or both."""
        if not self._sees_points:
            return pose
        return self._with_points(pose, self._experiment.control.points(pose))

    def _with_points(self, pose, points):
        return (pose, points) if self._is_filtered else points

    def _asked(self, seen):
        """Return what the law wants (n, 2), velocities of points or commands, or its commands as control
        has them; where it raises, the world is there."""
        sensors, control = self._experiment.sensors, self._experiment.control
        runner, time = control.runner, self._moved.time
        if not sensors.is_idle:
            runner.sense(sensors.readings(time))
        try:
            if self._is_bare:
                law = runner.velocities if self._by_points else runner.unlimited_commands
                return law(seen, time)
            if self._is_filtered:
                return runner.commands(np.array(seen[0], order="F"), time, None, None, seen[1])
            return control.commands(np.array(seen, order="F"), time)  # the filter may keep them
        except BaseException:
            self._give_back()
            raise

    def _give(self, wanted):
        """Give the robots the commands (n, 2) of what the law ``wanted``."""
        experiment = self._experiment
        if not self._is_bare:
            experiment.give(wanted)
            return
        if self._by_points:
            wanted = experiment.control.commands_for(wanted, self._world.pose)
        experiment.command_within(wanted)

    def _give_back(self):
        """Let world and experiment be where robots have come to."""
        if self._moved.is_on:
            self._filled += self._moved.end()
            self._experiment.take_collisions()
            self._experiment.step = self._world.steps
