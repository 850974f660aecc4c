"""Resilient consensus: agreement among those who follow the law, whatever some others do."""

import numpy as np

MOST_CHECKED = 12  # [-] robots up to which all pairs of sets are looked at: 4^n of them


def resilient_consensus(points, topology, F):
    """Return W-MSR's velocities ``u_i = sum_(j kept) a_ij (p_j - p_i)``, (n, d) [m/s].

    ``points`` p (n, d) [m].  Of the values it hears, robot i drops, for each coordinate by itself,
    the F largest of those above its own and the F smallest of those below.  With at most F robots
    that do as they like, normal robots stay within the box of their initial points; they agree iff
    the topology is (F+1, F+1)-robust.  LeBlanc, Zhang, Koutsoukos and Sundaram, 2013.
    """
    adjacency = topology.adjacency()
    columns = [_kept_flow(column, adjacency, F) for column in points.T]
    return np.stack(columns, axis=1)


def _kept_flow(values, adjacency, F):
    # Robots that are not heard differ by 0 here, so that they are never among those dropped.
    apart = np.where(adjacency > 0.0, values[np.newaxis, :] - values[:, np.newaxis], 0.0)
    order = np.argsort(apart, axis=1, kind="stable")
    apart = np.take_along_axis(apart, order, axis=1)
    weights = np.take_along_axis(adjacency, order, axis=1)
    few = min(F, len(values))
    apart[:, :few] = np.maximum(apart[:, :few], 0.0)
    apart[:, len(values) - few :] = np.minimum(apart[:, len(values) - few :], 0.0)
    return np.sum(weights * apart, axis=1)


def is_robust(topology, r, s):
    """Return whether the graph is (r, s)-robust; None if that is too much to find out.

    Of any two disjoint sets of robots, all of one, all of the other, or s of both together must
    hear r robots or more outside of their own set.  Beyond ``MOST_CHECKED`` robots only a
    sufficient condition is looked at: all hear ``floor(n/2) + r + s - 2`` others or more.
    """
    heard = topology.adjacency() > 0.0
    if topology.n > MOST_CHECKED:
        # It makes the graph (r + s - 1)-robust, which implies (r, s)-robust.
        enough = topology.n // 2 + r + s - 2
        return True if heard.sum(axis=1).min() >= enough else None
    code = np.arange(1, 2**topology.n)
    member = (code[:, np.newaxis] >> np.arange(topology.n)) & 1
    reached = (member * ((1 - member) @ heard.T >= r)).sum(axis=1)
    weak = (reached < member.sum(axis=1)) & (reached < s)
    code, reached = code[weak], reached[weak]
    return not any(
        np.any(((code & one) == 0) & (reached + count < s)) for one, count in zip(code, reached)
    )
