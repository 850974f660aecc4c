"""Avoid obstacles by potential fields.

Each robot goes down U = a |p - goal| + sum_k b/2 (1/d_k - 1/reach)^2, the second term within ``reach`` of
an obstacle (Khatib, 1986). It may stop in a local minimum. Run: python3 examples/potential_fields.py
"""

import numpy as np

from mrs_simulator import Parameter, PioneerControl, simulate
from mrs_simulator.core.claims import converges_to, stays_above

POSTS = np.array([[0.0, 0.5, 1.0], [1.0, -4.0, 0.8], [-1.0, 4.0, 0.6]])  # x, y, radius [m]
GOALS = np.array([[7.0, 3.0], [7.0, 0.0], [7.0, -3.0]])
SCENARIO = {
    "poses": [[-7, 3, 0], [-7, 0, 0], [-7, -3, 0]],
    "obstacles": [dict(type="cylinder", center=[x, y], radius=r) for x, y, r in POSTS.tolist()],
    "limits": {"v_max": 1.5, "omega_max": 6.0},
    "duration": 50,
}


def clearance(hand):  # distance [m] of each point to each post, (..., n, 3)
    return np.linalg.norm(hand[..., np.newaxis, :] - POSTS[:, :2], axis=-1) - POSTS[:, 2]


class Field(PioneerControl):
    """Robots go to their goals down a potential that rises at obstacles."""

    PARAMETERS = (
        Parameter("a", 0.6, "m/s", low=0.0, meaning="attraction"),
        Parameter("b", 1.0, "m^3/s", low=0.0, meaning="repulsion"),
        Parameter("reach", 2.0, "m", low=0.1, meaning="of the repulsion"),
        Parameter("l", 0.3, "m", low=0.01),
    )

    def pointMassLaw(self, hand):
        to_goal = GOALS - hand
        pull = self.a * to_goal / np.maximum(np.linalg.norm(to_goal, axis=1, keepdims=True), 0.5)
        distance = clearance(hand)
        away = (hand[:, np.newaxis] - POSTS[:, :2]) / (distance + POSTS[:, 2])[..., np.newaxis]
        near = np.maximum(1.0 / distance - 1.0 / self.reach, 0.0) / distance**2
        return pull + self.b * (near[..., np.newaxis] * away).sum(axis=1)

    def claims(self, start):
        return [
            converges_to(GOALS, tolerance=0.1),
            stays_above(lambda hand: clearance(hand).min(axis=(1, 2)), 0.0, "least clearance [m]"),
        ]


def study(out, **changes):
    """Run it, draw it to ``out``, and return the run."""
    run = simulate(SCENARIO, protocol=Field, out=out, **changes)
    run.trajectories().savefig("{}/potential_fields.png".format(out))
    return run


if __name__ == "__main__":
    print(study("runs/potential_fields"))
