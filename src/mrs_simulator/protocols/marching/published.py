"""The platoon as published, for verdicts: see :mod:`protocols.published.laws`."""

import numpy as np

from mrs_simulator.protocols.published.laws import Published


class Chain(Published):
    """``u_i = gain (e_(i+1) - e_i)``, late by tau, behind robot n, which sways along x.

    ``e`` is how far a robot is from its start; of the state alone ``e_i`` is not late.
    """

    SEES = "past"

    def __init__(self, gain, steps, both_late, sway, period):
        self.gain, self.steps, self.both_late = gain, steps, both_late
        self.sway, self.period = sway, period

    def begin(self, start):
        """Return the points of the last ``steps + 1`` commands, the oldest first, and the start."""
        return [start] * (self.steps + 1), start

    def velocity(self, points, time, memory):
        past, start = memory
        past = past[1:] + [points]
        late, u = past[0] - start, np.zeros_like(points)
        for i in range(len(points) - 1):
            own = late[i] if self.both_late else points[i] - start[i]
            u[i] = self.gain * (late[i + 1] - own)
        u[-1, 0] = (self.sway(time + self.period) - self.sway(time)) / self.period
        return u, (past, start)
