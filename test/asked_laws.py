"""Laws of three robots as functions, and what asking them finds."""

import numpy as np

from mrs_simulator.core.graphs import Topology
from mrs_simulator.verdict.derived.law_probe import Probe, facts_of

PATH = Topology(3, [(1, 2), (2, 3)], directed=False).laplacian()
STARTS = np.array([[0.2, 0.1], [3.2, 0.0], [1.0, 1.8]])


def facts(law, starts=STARTS):
    """Return the ``Facts`` of a law ``u(hand, time, call, theta)``."""

    def ask(points, theta, time, fresh):
        rows = enumerate(zip(points, theta))
        return np.array([law(at, time, 0 if fresh else row, own) for row, (at, own) in rows])

    return facts_of(Probe(ask, starts))
