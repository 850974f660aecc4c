"""Sums over edges: a law states the term of one edge, and each robot gets the sum over its edges.

A *term* is that statement, a function of arrays that hold one edge per column.  Its first argument is
``apart`` (d, m), ``x_j - x_i`` of each edge over which robot i receives from j, d = 2 or 3; what else
belongs to an edge, such as its weight, has the shape (m,), or (d, m) for a vector; what all edges share is
a number.  It returns what robot i gets, (d, m).  A term is written with arithmetic and elementwise
functions of numpy, :func:`inner` and :func:`unit`, and neither knows how many edges or dimensions there
are nor how they are summed: what evaluates it is free to choose.
"""

import functools
from typing import Any, Callable, NamedTuple, Optional, Tuple

import numpy as np

from mrs_simulator.core import compiling


@functools.lru_cache(maxsize=None)
def compiled():
    """Return the module ``compiled_terms`` where the environment enables it, else None."""
    if not compiling.is_wanted():
        return None
    from mrs_simulator.core import compiled_terms  # only where it is wanted

    return compiled_terms


def edge_sum(term, arcs, values, *given):
    """Return ``sum_j term(x_j - x_i, *given)`` over the edges of each robot i, (n, d).

    ``arcs``: rows i (m,) and j (m,), i receives from j, and more, as of ``Topology.arcs``;
    ``values`` x (n, d).
    """
    if compiled():
        return compiled().edge_sum(term, arcs, values, *given)
    return gathered(term(apart(values, arcs), *given), arcs[0], len(values))


def pair_sum(term, pairs, values, *given):
    """Return the sum over undirected ``pairs``, (n, d): the term for i, its opposite for j.

    ``pairs``: rows i (m,) and j (m,), each pair once.  Each robot gets the terms of pairs in which it comes
    first, less those in which it comes second, so that they add up to zero over the team.
    """
    if compiled():
        return compiled().pair_sum(term, pairs, values, *given)
    flow, n = term(apart(values, pairs), *given), len(values)
    return gathered(flow, pairs[0], n) - gathered(flow, pairs[1], n)


def difference_sum(values, topology):
    """Return the sum of the linear term :func:`weighted`, ``-L x``, (n, d), of ``values`` x (n, d).

    As ``A x - D x``: sums of weighted values take half of the memory that differences take.
    """
    if compiled():
        return compiled().edge_sum(weighted, topology.arcs, values, topology.arcs[2])
    return topology.neighbour_sum(values) - topology.in_degree()[:, np.newaxis] * values


def from_mean(values, topology):
    """Return ``x_i - sum_j a_ij x_j / sum_j a_ij``, (n, d); 0 for robots without neighbours.

    The opposite of the linear term's sum, with weights that add up to 1.
    """
    if compiled():
        return 0.0 - compiled().edge_sum(weighted, topology.arcs, values, topology.shares)
    return values - topology.neighbour_mean(values)


def weighted_differences(weight, points, values, *given):
    """Return ``sum_j w_ij (x_j - x_i)`` over all others, (n, d), of ``values`` x (n, d).

    ``weight(apart, *given)`` returns w of the differences ``p_j - p_i`` of ``points`` p (n, d), by columns
    as a term does.  As ``W x - (W 1) x`` with the matrix of all weights.
    """
    if compiled():
        return compiled().weighted_differences(weight, points, values, *given)
    columns = np.asarray(points).T
    weights = weight(columns[:, np.newaxis, :] - columns[:, :, np.newaxis], *given)
    return weights @ values - weights.sum(axis=1)[:, np.newaxis] * values


class Flow(NamedTuple):
    """A law that is one sum over edges: ``u_i = gain sum_j term(x_j - x_i, *given)``, ``x = p - places``.

    ``summed(x)`` is numpy's sum of the terms, (n, d); loops take ``term``, ``arcs`` and ``given``.
    """

    gain: float
    term: Callable
    arcs: Tuple[np.ndarray, ...]  # rows i (m,) and j (m,), i receives from j
    given: Tuple[Any, ...]
    summed: Callable
    places: Optional[np.ndarray] = None  # (n, d) [m]
    still: Tuple[int, ...] = ()  # rows of robots that get nothing, such as leaders
    # whether ``arcs`` are pairs, each once, of which j gets the opposite of i's term
    mutual: bool = False

    def velocity(self, points):
        """Return the velocities u (n, d) at ``points`` p (n, d) [m]."""
        u = self.gain * self.summed(points if self.places is None else points - self.places)
        if self.still:
            u[list(self.still)] = 0.0
        return u

    def edges(self):
        """Return ``(i, j, given)``: rows (m,) of all edges over which robots get something.

        What ``given`` holds of edges is that of these alone.  Of mutual terms, which are odd, it holds
        numbers alone.
        """
        (first, second), given = self.arcs, self.given
        if self.mutual:
            first, second = np.append(first, second), np.append(second, first)
        if self.still:
            kept = ~np.isin(first, self.still)
            first, second = first[kept], second[kept]
            given = tuple(each[..., kept] if np.ndim(each) else each for each in given)
        return first, second, given


def edge_flow(gain, term, arcs, *given, places=None):
    """Return the ``Flow`` of any term, as :func:`edge_sum` sums it."""

    def summed(values):
        return edge_sum(term, arcs, values, *given)

    return Flow(gain, term, arcs[:2], given, summed, places)


def pair_flow(gain, term, pairs, *given):
    """Return the ``Flow`` of an odd term over undirected ``pairs``, as :func:`pair_sum` sums it."""

    def summed(values):
        return pair_sum(term, pairs, values, *given)

    return Flow(gain, term, tuple(pairs), given, summed, mutual=True)


def difference_flow(gain, topology, places=None):
    """Return the ``Flow`` of ``-gain L x``, as :func:`difference_sum` sums it."""
    summed = functools.partial(difference_sum, topology=topology)
    return Flow(gain, weighted, topology.arcs[:2], (topology.arcs[2],), summed, places)


def flow_to_mean(gain, topology, places=None):
    """Return the ``Flow`` of ``-gain (x_i - sum_j a_ij x_j / sum_j a_ij)``, see :func:`from_mean`."""
    summed = functools.partial(from_mean, topology=topology)
    return Flow(-gain, away, topology.arcs[:2], (topology.shares,), summed, places)


def weighted(apart, weight):
    """Return the linear term ``a_ij (x_j - x_i)``, (d, m)."""
    return weight * apart


def away(apart, share):
    """Return the opposite of :func:`weighted`, the term of :func:`from_mean`, (d, m)."""
    return -share * apart


def apart(values, arcs):
    """Return ``x_j - x_i``, (d, m), over ``arcs``, rows i (m,) and j (m,), of ``values`` x (n, d)."""
    columns = np.asarray(values).T
    return columns.take(arcs[1], axis=1) - columns.take(arcs[0], axis=1)


def gathered(flow, rows, n):
    """Return the sums (n, d) of the columns of ``flow`` (d, m) that belong to each of ``rows`` (m,).

    They are added in the order in which they come.
    """
    total = np.empty((len(flow), n))
    for axis, values in enumerate(flow):
        total[axis] = np.bincount(rows, values, n)
    return total.T


def inner(a, b):
    """Return the inner products (m,) of the columns of ``a`` and ``b`` (d, m)."""
    return (a * b).sum(axis=0)


def unit(a):
    """Return the columns of ``a`` (d, m) as unit vectors; those that are zero stay zero."""
    length = np.sqrt(inner(a, a))
    return a / np.where(length > 0.0, length, 1.0)
