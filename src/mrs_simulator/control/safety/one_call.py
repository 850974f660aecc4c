"""``OneCall``: the safety filter of unicycles that know places, in one compiled call."""

import numpy as np

from mrs_simulator.control.safety.compiled_passing import FREE, GIVEN, ODD, compiled_passing
from mrs_simulator.control.safety.nearest_velocities import NONE, extremes
from mrs_simulator.core.compiling import same_bits
from mrs_simulator.core.neighbours import DENSE
from mrs_simulator.scenario.control import SATURATIONS
from mrs_simulator.vehicles.courses import columns_of, instants_of

WORTH = 30000  # [-] robots of all calls, and FIXED of each, that take numpy as long as numba takes to load
FIXED = 10
ANY = np.empty((0, 2))  # where a law gives no velocities


class OneCall:
    """What the loop of ``compiled_passing`` takes of one team under one filter."""

    def __init__(self, control, around, way_out):
        """``around``: the ``Surroundings``; ``way_out``: the ``WayOut``, or None."""
        team, self._l, self._numbers = control.team, None, None
        self._loop = None
        alone = way_out is not None and way_out.ramps_alone and len(team.groups) == 1
        self.fits = bool(alone and team.is_of_unicycles and team.n <= DENSE and not around.fastest)
        self.fits = self.fits and not control.runner.replaces_loop
        if self.fits:
            limits, radii = team.groups[0].limits, control.safety_filter.body_radii
            arrays = (limits.top, limits.acceleration, team.speeds[:, 0], radii, *way_out.columns)
            self._robots = tuple(map(np.ascontiguousarray, arrays))
            period = float(control.period)
            self._scope = (period, columns_of(team.axes), *instants_of(period))

    def loop(self):
        """Return the loop where it pays, and from then on, else None."""
        if self._loop is None:
            self._loop = same_bits(compiled_passing, WORTH, FIXED + len(self._robots[2]))
        return self._loop

    def passed(self, loop, control, command, pose, unlimited, bounds, since):
        """Return the ``command`` (n, a), what the filter lets pass of it, and whether that is all.

        Not where something that stands may be in a robot's way: then the command has still to leave a way
        out.  ``command``: None for what limits leave of ``unlimited``; ``bounds``: those that do not come;
        ``since`` (n,) [s]: of the ``DeadlockDetector``, which is noted.
        """
        way_out, time = control.safety_filter.way_out, control.time
        inner, given, speeds, seconds = way_out.known(time)
        kept, result = self._kept(control), np.empty((2, len(pose)))
        inner, given = np.ascontiguousarray(inner), np.ascontiguousarray(given.T)
        known = inner, given, speeds, float(seconds), since, float(time)
        scope = GIVEN if command is not None else SATURATIONS.index(control.saturation)
        command = np.empty((len(pose), 2), order="F") if command is None else command
        given = [np.ascontiguousarray(each) for each in (pose[:, :3].T, command.T)]
        given.append(ANY if unlimited is None else np.ascontiguousarray(unlimited, dtype=float))
        around = bounds.robot, np.ascontiguousarray(bounds.way_out), bounds.gap, bounds.turns
        given += [known, self._robots, kept, around, (self._l, *self._scope), scope, result]
        end, inner, speeds = loop(*given)
        if end == ODD:  # which raises, or does what the loop does not
            limited = control.runner.limited_command(unlimited, pose)
            return self.passed(loop, control, limited, pose, unlimited, bounds, since)
        if end != FREE:
            return command, result.T, False
        way_out.note(inner, result.T.copy(order="F"), speeds, time)
        return command, result.T, True

    def _kept(self, control):
        """Return the distances that are kept, their ends and the worst brakes, and caps of speeds."""
        if control.l != self._l:
            safety, self._l, top = control.safety_filter, float(control.l), self._robots[2]
            distance, brakes, speed = safety.distance, safety.brakes, safety.speed
            ends = float(brakes.late.max()), float(brakes.slowness.max())
            caps = NONE, top
            if speed is not None:
                caps = np.array(speed, dtype=float), np.minimum(top, speed)
            self._numbers = (np.atleast_2d(distance), (*extremes(distance), *ends), *caps)
        return self._numbers
