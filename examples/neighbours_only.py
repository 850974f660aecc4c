"""A law that sees its neighbours alone, in its robot's own frame.

``neighbourLaw`` gets relative positions and nothing else; with LOCAL_FRAMES there is no common compass, so
the law is distributed by construction. Neighbours go to their wanted distance, as if springs joined them.
Run: python3 examples/neighbours_only.py
"""

import math

import numpy as np

from mrs_simulator import Parameter, PioneerControl, simulate
from mrs_simulator.core.claims import Condition, ends_at

SCENARIO = {
    "poses": [[4, 0, 0], [1, 4, 1], [-4, 2, 2], [-3, -3, 3], [2, -4, 4]],
    "topology": {"preset": "ring"},
    "limits": {"v_max": 1.5, "omega_max": 6.0},
    "duration": 40,
}


class Springs(PioneerControl):
    """Each robot keeps its distance to those that it hears."""

    LOCAL_FRAMES = True
    PARAMETERS = (
        Parameter("gain", 0.5, "1/s", low=0.0, meaning="of each spring"),
        Parameter("length", 2.0, "m", low=0.1, meaning="of a spring at rest"),
        Parameter("l", 0.3, "m", low=0.01, meaning="to the hand point"),
    )

    def neighbourLaw(self, robot, theta, neighbours):
        shares = [self.gain * (1.0 - self.length / math.hypot(n.x, n.y)) for n in neighbours]
        x = sum(share * n.x for share, n in zip(shares, neighbours))
        return x, sum(share * n.y for share, n in zip(shares, neighbours))

    def claims(self, start):
        first, second = self.topology.arcs[:2]

        def stretch(hand):
            apart = np.linalg.norm(hand[:, first] - hand[:, second], axis=2)
            return np.abs(apart - self.length).max(axis=1)

        return [
            Condition("connected", self.topology.has_spanning_tree()),
            ends_at(stretch, 0.0, 0.05, "largest stretch at the end [m]"),
        ]


def study(out, **changes):
    """Run it, draw it to ``out``, and return the run."""
    run = simulate(SCENARIO, protocol=Springs, out=out, **changes)
    run.trajectories().savefig("{}/neighbours_only.png".format(out))
    return run


if __name__ == "__main__":
    print(study("runs/neighbours_only"))
