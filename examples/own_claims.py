"""Claims of your own: what theory says of a run, and what the verdict makes of it.

Consensus over a directed graph: each robot follows the ones it hears. Theory gives the place where all
meet, the mean weighted by the left null vector of the Laplacian, and the rate, the least real part of its
other eigenvalues; both need a spanning tree. Run: python3 examples/own_claims.py
"""

import numpy as np

from mrs_simulator import Parameter, PioneerControl, simulate
from mrs_simulator.core.claims import Condition, converges_to, disagreement, rate
from mrs_simulator.core.spectra import laplacian_eigenvalues, left_null_vector

SCENARIO = {
    "poses": [[4, 0, 0], [1, 3, 0], [-4, 2, 0], [-3, -4, 0], [2, -3, 0]],
    "topology": {"edges": [[1, 2], [2, 3], [3, 1], [4, 3], [5, 4], [3, 4]], "directed": True},
    "fidelity": "point_mass",
    "limits": "none",
    "duration": 40,
}


class Agree(PioneerControl):
    """Consensus, with the claims of its theorem."""

    MEMORYLESS = True  # it knows positions alone, so claims hold from any moment on
    PARAMETERS = (Parameter("gain", 0.5, "1/s", low=0.0, meaning="of each edge"),)

    def pointMassLaw(self, hand):
        return -self.gain * self.topology.laplacian() @ hand

    def claims(self, start):
        slowest = np.sort(laplacian_eigenvalues(self.topology).real)[1]
        return [
            Condition("a spanning tree", self.topology.has_spanning_tree(), necessary=True),
            converges_to(left_null_vector(self.topology) @ start, tolerance=0.01),
            rate(self.gain * slowest, disagreement, tolerance=0.1),
        ]


def study(out, **changes):
    """Run it, draw it to ``out``, and return the run."""
    run = simulate(SCENARIO, protocol=Agree, out=out, **changes)
    run.states("x").savefig("{}/own_claims.png".format(out))
    return run


if __name__ == "__main__":
    print(study("runs/own_claims"))
