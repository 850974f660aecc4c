"""Consensus: robots agree on a point by averaging over their neighbours."""

import numpy as np


def consensus(points, topology):
    """Return ``u_i = sum_j a_ij (p_j - p_i)``, (n, 2) [m/s], from ``points`` p (n, 2) [m].

    On a connected undirected graph the mean stays and disagreement decays at least as fast as
    ``exp(-lambda_2 t)``; on a directed graph with a spanning tree the limit is ``w^T p(0)``, ``w``
    the left null vector of L.  Olfati-Saber and Murray, 2004; Ren and Beard, 2005.
    """
    degree = topology.in_degree()[:, np.newaxis]
    return topology.neighbour_sum(points) - degree * points
