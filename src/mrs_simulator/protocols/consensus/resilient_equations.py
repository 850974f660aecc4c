"""Resilient consensus: agreement among those who follow the law, whatever some others do."""

import numpy as np

from mrs_simulator.core.edge_terms import edge_sum, weighted

MOST_CHECKED = 12  # [-] robots up to which all pairs of sets are looked at: 4^n of them


def resilient_consensus(points, topology, F):
    """Return W-MSR's velocities ``u_i = sum_(j kept) a_ij (p_j - p_i)``, (n, d) [m/s].

    ``points`` p (n, d) [m].  Of the values it receives, robot i drops, for each coordinate by itself,
    the F largest of those above its own and the F smallest of those below.  With at most F robots
    that do as they like, normal robots stay within the box of their initial points; they agree iff
    the topology is (F+1, F+1)-robust.  LeBlanc, Zhang, Koutsoukos and Sundaram, 2013.
    """
    receiver, sender, weights = topology.arcs
    kept = np.array([_kept(values, receiver, sender, F) for values in points.T])
    return edge_sum(weighted, topology.arcs, points, weights * kept)


def _kept(values, receiver, sender, F):
    """Return which of the edges are kept, (m,) bool, as for one coordinate ``values`` (n,)."""
    above = values[sender] - values[receiver]
    order = np.lexsort((above, receiver))  # robot by robot, what it receives in ascending order
    rows, place = receiver[order], np.arange(len(receiver))
    from_low = place - np.searchsorted(rows, rows, "left")
    from_high = np.searchsorted(rows, rows, "right") - 1 - place
    ranked = above[order]
    dropped = (ranked < 0.0) & (from_low < F) | (ranked > 0.0) & (from_high < F)
    kept = np.empty(len(receiver), dtype=bool)
    kept[order] = ~dropped
    return kept


def is_robust(topology, r, s):
    """Return whether the graph is (r, s)-robust; None if that is too much to find out.

    Of any two disjoint sets of robots, all of one, all of the other, or s of both together must
    receive from r robots or more outside of their own set.  Beyond ``MOST_CHECKED`` robots only a
    sufficient condition is looked at: all receive from ``floor(n/2) + r + s - 2`` others or more.
    """
    adjacent = topology.adjacency() > 0.0
    if topology.n > MOST_CHECKED:
        # It makes the graph (r + s - 1)-robust, which implies (r, s)-robust.
        enough = topology.n // 2 + r + s - 2
        return True if adjacent.sum(axis=1).min() >= enough else None
    code = np.arange(1, 2**topology.n)
    member = (code[:, np.newaxis] >> np.arange(topology.n)) & 1
    reached = (member * ((1 - member) @ adjacent.T >= r)).sum(axis=1)
    weak = (reached < member.sum(axis=1)) & (reached < s)
    code, reached = code[weak], reached[weak]
    return not any(
        np.any(((code & one) == 0) & (reached + count < s)) for one, count in zip(code, reached)
    )
