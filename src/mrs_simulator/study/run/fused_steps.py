"""Experiments that go from sample to sample, or over many samples, by one compiled call."""

import numpy as np

from mrs_simulator.control.array_law import form_of
from mrs_simulator.control.twists import ControlError
from mrs_simulator.core import compiling
from mrs_simulator.world.motion.fused_stepping import FusedStepping
from mrs_simulator.world.motion.stretches import NEAR, ODD

RAISED, REFUSED = -1, -2  # why fused steps ended: the law raised, or cannot be compiled


class FusedSteps:
    """The steps of an ``Experiment``, of which ``FusedStepping`` makes all that it can."""

    def __init__(self, experiment, most):
        """``most``: how many samples a call makes at most; it changes no bit of them."""
        self._experiment, self._world, self._most = experiment, experiment.world, most
        scenario, control = experiment.scenario, experiment.control
        self._every, self._between = scenario.steps_per_command, scenario.steps_per_record
        form = form_of(control)
        points = control.l, control.saturation, control.dimension
        self._stepping = FusedStepping(self._world, *form, self._every, *points)
        self._by_step = 0  # the step up to which the world makes each by itself

    def blocks(self, steps):
        """Go on to ``steps``; yield ``(stamps, poses, commands)`` of the samples, which begin now.

        ``stamps``: m of them [s]; ``poses`` (m, n, 3) and ``commands`` (m, n, a), the caller's own.  The
        experiment is at the last of them.
        """
        experiment, between = self._experiment, self._between
        step = max(0, experiment.step)
        while True:
            if step % between == 0 and step > experiment.step:
                experiment.step = step
                stamp, pose, command = experiment.sample()
                yield [stamp], pose[np.newaxis], command[np.newaxis]
            if step == steps:
                return
            ahead = between - step % between
            end = min(steps, step + ahead + (self._most - 1) * between)
            kept = np.empty((self._most, 3 + self._world.command.shape[1], self._world.n))
            done, filled, why = self._fuse(step, end, ahead, kept)
            if filled:
                sampled = range(step + ahead, step + done + 1, between)[:filled]
                experiment.step = sampled[-1]
                stamps = [each * self._world.step_size for each in sampled]
                rows = kept[:filled].transpose(0, 2, 1)
                yield stamps, rows[:, :, :3], rows[:, :, 3:]
            step = self._went_on(step + done, why)

    def _fuse(self, step, end, ahead, kept):
        """Return what ``FusedStepping.advance`` does, or ``(0, 0, RAISED)`` where the law raises.

        It will raise again step by step, where it is known when; before, sample by sample.
        """
        if step < self._by_step:
            return 0, 0, RAISED
        try:
            return self._stepping.advance(end - step, ahead, self._between, kept)
        except Exception as error:
            why = compiling.compile_failure(error)
            if why:
                self._by_step = np.inf
                self._refuse(why)
                return 0, 0, REFUSED
        if self._most == 1:
            self._by_step = step + ahead
            return 0, 0, RAISED
        self._most = 1
        return self._fuse(step, min(end, step + ahead), ahead, kept)

    def _refuse(self, why):
        """Warn of a law that cannot be compiled; ``LawFailed`` where the environment wants it to be."""
        experiment = self._experiment
        text = "{}: numba cannot compile pointMassLaw: {}; ".format(
            type(experiment.control).__name__, why
        )
        if compiling.is_chosen():
            text += "wanted what it compiles, or {}=0".format(compiling.VARIABLE)
            experiment.asked(_raise, text)
        experiment.warnings.append(text + "robots go step by step")

    def _went_on(self, step, why):
        """Do what fused steps that ended at ``step`` left undone; return at which step that is."""
        if why in (NEAR, RAISED, REFUSED):
            self._experiment.advance()
            step += 1
        elif why != ODD:
            return step
        if step % self._every == 0:
            self._experiment.command_all()
        return step


def _raise(text):
    raise ControlError(text)
