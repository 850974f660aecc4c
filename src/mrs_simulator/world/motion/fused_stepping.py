"""A world moved over several steps in one compiled call, by the loops of ``stretches``."""

import functools

from mrs_simulator.core.compiled_terms import kernel
from mrs_simulator.core.compiling import jit
from mrs_simulator.core.kinematics import UNICYCLE_AXES
from mrs_simulator.world.motion import flight_stretches, stretches
from mrs_simulator.world.motion.rolling_steps import (
    compiled_roll_step,
    roll_step,
    rolling_stretch,
)


@functools.lru_cache(maxsize=None)
def compiled_stretch(law, loops):
    """Return ``loops``, a stretch, under the function ``law`` of the points, compiled."""
    made = None
    if loops is flight_stretches.flight_stretch:
        made = flight_stretches.kernels()
    elif loops is rolling_stretch:
        made = {roll_step: compiled_roll_step()}
    # Whoever records writes meanwhile.
    return kernel(law, loops, jit(), jit(cache=True, nogil=True), made)


def loops_for(world):
    """Return the loops of ``stretches`` that move the robots of ``world``."""
    if world.fidelity == "point_mass":
        return stretches.point_stretch
    if world.team.is_spatial:
        return flight_stretches.flight_stretch
    if world.fidelity == "dynamic":
        return rolling_stretch
    unicycles = world.team.axes == UNICYCLE_AXES
    return stretches.stretch if unicycles else stretches.sliding_stretch


class FusedStepping:
    """A ``World`` of one drive that moves by several steps at once under a law that is asked meanwhile."""

    def __init__(self, world, law, given, every, l, saturation, dimension=2):
        """``law(points, *given)`` returns velocities (n, d); it is asked every ``every`` steps.

        ``l`` [m] is the hand length, ``saturation`` one of ``SCOPES``, ``dimension`` d.
        """
        self._world, self._every = world, every
        self._law, self._function = law, None
        points = dimension if world.team.is_spatial else l  # those that fly are the centres
        self._given = points, stretches.SCOPES.index(saturation), *given

    def advance(self, steps, ahead, between, kept):
        """Move by up to ``steps`` steps; return how many were made, how many samples kept, why it ended.

        A sample is put into ``kept`` (m, 3 + a, n), pose and command, after ``ahead`` steps and after every
        ``between`` from then on.  ``NEAR``: the next step is to be made by ``World.step``; ``ODD``: a
        command is due that the law is to be asked for; ``FAR``: a sample is due that cannot be one.  A
        command due after the last step is given, too, but for ``NEAR`` and ``ODD``.  The first time it is
        compiled.
        """
        if self._function is None:
            self._function = compiled_stretch(self._law, loops_for(self._world))
        plan = steps, self._every, ahead, between
        return self._world.fuse_steps(plan, self._function, kept, *self._given)
