"""Shortest ways over cells by a loop that numba compiles, as long as numpy's to the bit.

Each is the least of sums, from its beginning on, over all ways to a cell: in whatever order ways are found.
"""

import functools

import numpy as np

from mrs_simulator.core.compiled_terms import kept


def lengths(passable, width, begin, straight, slanted):
    """Return how far (k,) [m] all cells are from the cell ``begin``, inf where no way leads.

    ``passable``: (k,) bool, row after row of ``width`` cells, with a border that is not; ``straight`` and
    ``slanted`` [m]: how long steps are, the latter along both axes and not past a corner.
    """
    far, count = np.full(len(passable), np.inf), 1
    queue, waits = np.empty(len(passable), dtype=np.int64), np.zeros(len(passable), dtype=np.bool_)
    far[begin], queue[0], first = 0.0, begin, 0
    while count > 0:
        at, first, count = queue[first], (first + 1) % len(queue), count - 1
        waits[at] = False
        for row in (-width, 0, width):
            for column in (-1, 0, 1):
                to = at + row + column
                if not (passable[to] and passable[at + row] and passable[at + column]):
                    continue
                length = far[at] + (slanted if row != 0 and column != 0 else straight)
                if length < far[to]:
                    far[to] = length
                    if not waits[to]:
                        waits[to] = True
                        queue[(first + count) % len(queue)] = to
                        count += 1
    return far


@functools.lru_cache(maxsize=None)
def compiled_lengths():
    """Return :func:`lengths` compiled; ``NotInstalled`` without numba."""
    return kept(lengths)
