"""Circle a target, evenly spaced.

Each robot keeps the distance R to the target and moves around it, faster where the gap to the next one is
wider than its share: u = a (R - r) e_r + (v + b R (gap - 2 pi/n)) e_t. The gaps become even.
Run: python3 examples/circumnavigation.py
"""

import numpy as np

from mrs_simulator import Parameter, PioneerControl, simulate
from mrs_simulator.core.claims import ends_at

TARGET = np.array([1.0, 0.5])  # [m]
POSES = [[6, 0, 0], [5, 4, 0], [2, 7, 0], [-5, 1, 0], [0, -6, 0]]
SCENARIO = {"poses": POSES, "limits": {"v_max": 1.5, "omega_max": 6.0}, "duration": 40}


def radius(hand):
    return np.linalg.norm(hand - TARGET, axis=-1)


def gaps(hand):  # angles [rad] to the robot ahead, in the order around the target
    angle = np.sort(np.arctan2(*(hand - TARGET)[..., ::-1].T).T, axis=-1)
    return np.diff(angle, axis=-1, append=angle[..., :1] + 2 * np.pi)


class Circle(PioneerControl):
    PARAMETERS = (
        Parameter("R", 4.0, "m", low=0.5, meaning="distance to the target"),
        Parameter("v", 0.3, "m/s", meaning="speed on the circle"),
        Parameter("a", 0.5, "1/s", low=0.0, meaning="of the distance"),
        Parameter("b", 0.15, "1/s", low=0.0, meaning="of the gaps"),
        Parameter("l", 0.3, "m", low=0.01),
    )

    def pointMassLaw(self, hand):
        out = (hand - TARGET) / radius(hand)[:, np.newaxis]
        around = out @ [[0, 1], [-1, 0]]
        ahead = gaps(hand)[np.argsort(np.argsort(np.arctan2(out[:, 1], out[:, 0])))]
        along = self.v + self.b * self.R * (ahead - 2 * np.pi / len(hand))
        return (self.a * (self.R - radius(hand)) * out.T + along * around.T).T

    def claims(self, start):
        return [
            ends_at(lambda hand: radius(hand).max(axis=1), self.R, 0.05, "distance at the end [m]"),
            ends_at(lambda hand: np.ptp(gaps(hand), axis=1), 0.0, 0.05, "unevenness [rad]"),
        ]


def study(out, **changes):
    """Run it, draw it to ``out``, and return the run."""
    run = simulate(SCENARIO, protocol=Circle, out=out, **changes)
    run.trajectories().savefig("{}/circumnavigation.png".format(out))
    return run


if __name__ == "__main__":
    print(study("runs/circumnavigation"))
