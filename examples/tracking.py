"""Track a moving leader.

Robot 1 drives a circle and tells its velocity; the others keep places behind it, each by the robots that
it hears: u_i = v + g sum_j ((p_j - d_j) - (p_i - d_i)). With a path from the leader to everyone the errors
go to zero. Run: python3 examples/tracking.py
"""

import numpy as np

from mrs_simulator import Parameter, PioneerControl, simulate
from mrs_simulator.core.claims import Condition, ends_at

PLACES = np.array([[0.0, 0.0], [-1.5, 1.0], [-1.5, -1.0], [-3.0, 2.0], [-3.0, -2.0]])  # [m]
SCENARIO = {
    "poses": [[6, 0, 1.6], [3, 3, 0], [3, -3, 1], [0, 5, 0], [0, -5, 0]],
    "topology": {"edges": [[2, 1], [3, 1], [4, 2], [5, 3]], "directed": True},
    "limits": {"v_max": 1.5, "omega_max": 6.0},
    "duration": 30,
}


class Track(PioneerControl):
    """Followers keep their places around a leader that drives a circle."""

    PARAMETERS = (
        Parameter("gain", 0.6, "1/s", low=0.0, meaning="of each edge"),
        Parameter("radius", 6.0, "m", low=0.1, meaning="of the leader's circle"),
        Parameter("speed", 0.4, "m/s", meaning="of the leader"),
        Parameter("l", 0.3, "m", low=0.01, meaning="to the hand point"),
    )

    def pointMassLaw(self, hand):
        angle = self.time * self.speed / self.radius
        lead = self.speed * np.array([-np.sin(angle), np.cos(angle)])
        return lead - self.gain * self.topology.laplacian() @ (hand - PLACES)

    def claims(self, start):
        def error(hand):
            apart = (hand - PLACES) - (hand - PLACES)[:, :1]
            return np.linalg.norm(apart, axis=2).max(axis=1)

        return [
            Condition("everyone hears of the leader", self.topology.has_spanning_tree()),
            ends_at(error, 0.0, 0.05, "largest error at the end [m]"),
        ]


def study(out, **changes):
    """Run it, draw it to ``out``, and return the run."""
    run = simulate(SCENARIO, protocol=Track, out=out, **changes)
    run.trajectories().savefig("{}/tracking.png".format(out))
    return run


if __name__ == "__main__":
    print(study("runs/tracking"))
