"""Shortest ways over cells, by a loop that Python goes through or numba compiles, with the same bits.

A way is as long as the sum of its steps from its beginning on, and of all ways to a cell the shortest
counts: in whatever order they are found.
"""

import functools

import numpy as np

from mrs_simulator.core.compiled_terms import kept


def lengths(passable, first, steps):
    """Return how far (k,) [m] all cells are from the cell ``first``, inf where no way leads.

    ``passable``: (k,) bool, row after row, with a border that is not; ``steps``: how many cells a step
    leads along rows and columns together, which lead past no corner, and how long it is [m].
    """
    far = [np.inf] * len(passable)  # Python reads lists faster than arrays
    far[first], reached = 0.0, [first]
    while len(reached) > 0:
        nearer = []
        for at in reached:
            for row, column, size in steps:
                to, length = at + row + column, far[at] + size
                free = length < far[to] and passable[to]
                if free and passable[at + row] and passable[at + column]:
                    far[to] = length
                    nearer.append(to)
        reached = nearer
    return np.array(far)


@functools.lru_cache(maxsize=None)
def compiled_lengths():
    """Return :func:`lengths` compiled; ``NotInstalled`` without numba."""
    return kept(lengths)
