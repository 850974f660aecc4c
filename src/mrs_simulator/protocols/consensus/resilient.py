"""Resilient consensus as a protocol, with what theory claims of its runs."""

import numpy as np

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.claims import Condition, ends_at, extent, stays_below
from mrs_simulator.core.fields import Parameter
from mrs_simulator.protocols.common import AGREED, attracting, below
from mrs_simulator.protocols.consensus.law import GAIN, never_grows
from mrs_simulator.protocols.consensus.published import Resilient
from mrs_simulator.protocols.consensus.resilient_equations import is_robust, resilient_consensus
from mrs_simulator.protocols.published.laws import weights_of

TRIMMED = Parameter(
    "F", 1, low=0, high=1000, meaning="values dropped at each end, of each coordinate"
)
ADVERSARIES = Parameter(
    "adversaries",
    1,
    low=0,
    high=1000,
    meaning="how many robots, the last, move as they like",
    why="the theorem allows F",
)
SPEED = Parameter("speed", 0.5, "m/s", low=-10.0, high=10.0, meaning="of the adversaries")
TURN = Parameter(
    "turn", 0.5, "rad/s", low=-10.0, high=10.0, meaning="of the adversaries' circles; 0: straight"
)
EDGE = 1e-6  # [m] by which rounding may leave a box


class ResilientConsensus(PioneerControl):
    """W-MSR: ``u_i = gain sum_(j kept) a_ij (p_j - p_i)``: LeBlanc et al., 2013.

    The last ``adversaries`` robots drive level circles instead, starting along the x axis.

    Theorem: over an (F+1, F+1)-robust graph with at most F adversaries the normal robots agree, inside
    the box in which they started, whatever the others do.
    """

    PARAMETERS = (GAIN, TRIMMED, ADVERSARIES, SPEED, TURN)
    DIMENSIONS = (2, 3)

    def published(self):
        """Return the law as published, and the adversaries' circles."""
        weights = weights_of(self.topology)
        return Resilient(weights, self.gain, self.F, self.normal, self.speed, self.turn)

    @property
    def normal(self):
        """Return how many robots, the first, follow the law."""
        return max(len(self.numbers) - self.adversaries, 0)

    def pointMassLaw(self, hand):
        u = self.gain * resilient_consensus(hand, self.topology, self.F)
        angle = self.turn * self.time
        u[self.normal :] = 0.0
        u[self.normal :, :2] = self.speed * np.array([np.cos(angle), np.sin(angle)])
        return u

    def claims(self, start):
        """Return agreement of the normal robots, inside the box that they started in."""
        degree = float(np.max(self.topology.in_degree()))
        robust = is_robust(self.topology, self.F + 1, self.F + 1)
        unknown = "too many robots to find out, and too few edges to be sure"
        conditions = [
            Condition("a normal robot", self.normal > 0, "all are adversaries"),
            Condition("adversaries <= F", self.adversaries <= self.F, "more than are dropped"),
            Condition(
                "(F+1, F+1)-robust", bool(robust), unknown if robust is None else "it is not"
            ),
            attracting(self.gain),
            below("gain Tc max degree < 1", self.gain * self.period * degree, 1.0),
        ]
        if not self.normal > 0:
            return conditions
        return conditions + [
            ends_at(self._extent, 0.0, AGREED, "final extent of the normal robots [m]", free=True),
            stays_below(self._outside(start), 0.0, "way out of the box of their starts [m]", EDGE),
            never_grows(self._extent, "growth of their extent [-]", self.period),
        ]

    def _extent(self, hand):
        return extent(hand[:, : self.normal])

    def _outside(self, start):
        """Return the quantity of how far the farthest normal robot is outside of the box, (m,) [m]."""
        low = start[: self.normal].min(axis=0)
        high = start[: self.normal].max(axis=0)

        def outside(hand):
            points = hand[:, : self.normal]
            return np.maximum(low - points, points - high).clip(min=0.0).max(axis=(1, 2))

        return outside
