"""Rows of numbers as text, each with the fewest digits that read back to the same value.

``orjson``, where it is installed, writes them six times as fast as Python's own ``repr``.  Its
exponents differ, ``1e-7`` for ``1e-07`` and ``0.00001`` for ``1e-05``: Python's are brought to its form, so
that files are the same to the byte.  A release of orjson that writes other digits is not used.  Where numba
is in use, its loops write whole lines in a third of the time.
"""

import functools
import itertools
import re

import numpy as np

from mrs_simulator.core.compiling import same_bits
from mrs_simulator.core.kinematics import max_abs

LARGE = 1e16  # from which on releases of orjson differ, and Python writes
# [-] rows: their texts stay in the processor's cache, and in memory that is used again
AT_ONCE = 500
WRITTEN = 150  # [-] rows that are written in 0.1 ms
EXPONENT = re.compile(r"(\d)(?:\.(\d+))?e-(\d+)")
TRICKY = np.array(  # numbers that writers print differently
    [0.0, -0.0, 1.0, -1e-4, 9.999e-5, 1.5e-5, -1e-5, 1e-7, 2.5e-10, 5e-324, 0.1 + 0.2]
    + [1e15, 1234567890123456.7, -9.9e15, 10.00001, 0.00010000123, 1 / 3]
)


class Lines:
    """The lines of samples: a stamp, a robot's number, other numbers, and what ends its lines."""

    def __init__(self, robots, ends):
        """``robots``: their numbers; ``ends``: what ends the lines of each, such as ``,kind``."""
        self._given, self._filler = (list(robots), ends), None
        ends = [end.replace("%", "%%") for end in ends]
        forms = ["\0,{},%s{}\n".format(*each) for each in zip(robots, ends)]
        parts = [forms[begin : begin + AT_ONCE] for begin in range(0, len(forms), AT_ONCE)]
        self._forms = [("".join(part), len(part)) for part in parts]

    @property
    def are_compiled(self):
        """Return whether compiled loops have written lines."""
        return self._filler is not None

    def filled(self, stamps, tables, points=None):
        """Return what :meth:`texts` does as bytes, which last until the next call, and where in them each
        sample ends, (k,).

        ``points``: of the hand points that are put into ``tables`` before, as
        ``compiled_rows.place_points`` has it.  None unless compiled loops are to write lines, and can.
        """
        rows = tables.shape[0] * tables.shape[1]
        loops = same_bits(_compiled, size=1 + rows // WRITTEN, loading=False)
        if loops is None:
            return None
        if self._filler is None:
            self._filler = loops(*self._given)
        return self._filler.filled(stamps, tables, points)

    def texts(self, stamps, tables):
        """Return the lines of samples at ``stamps`` (k,) [s] of ``tables`` (k, n, c): texts of each."""
        table = tables.reshape(-1, tables.shape[2])
        parts = (rows_text(table[at : at + AT_ONCE]) for at in range(0, len(table), AT_ONCE))
        rows = itertools.chain.from_iterable(parts)
        return [
            [
                form.replace("\0", stamp) % tuple(itertools.islice(rows, n))
                for form, n in self._forms
            ]
            for stamp in map(repr, stamps)
        ]


def rows_text(table):
    """Return one text for each row of ``table`` (n, c): its numbers with commas between them."""
    table = np.ascontiguousarray(table, dtype=float)
    if not max_abs(table) < LARGE:  # nor is nan
        return python_rows(table)
    return _writer()(table)


def python_rows(table):
    """Return the texts as Python writes them, with exponents as orjson has them."""
    rows = [",".join(map(repr, row)) for row in table.tolist()]
    return [EXPONENT.sub(_short_exponent, row) if "e" in row else row for row in rows]


@functools.lru_cache(maxsize=None)
def _compiled():
    """Return ``compiled_rows.Filler``; ``ValueError`` without numba."""
    from mrs_simulator.record import compiled_rows  # takes some ms

    compiled_rows.compiled_lines()
    return compiled_rows.Filler


@functools.lru_cache(maxsize=None)
def _writer():
    """Return the quickest function that writes rows as ``python_rows`` does."""
    try:
        import orjson  # optional
    except ImportError:
        return python_rows

    def rows(table):
        text = orjson.dumps(table, option=orjson.OPT_SERIALIZE_NUMPY).decode("ascii")
        return text[2:-2].split("],[")

    return rows if rows(TRICKY[np.newaxis]) == python_rows(TRICKY[np.newaxis]) else python_rows


def _short_exponent(found):
    first, more, exponent = found.groups()
    if exponent == "05":
        return "0.0000{}{}".format(first, more or "")
    return "{}{}e-{}".format(first, "." + more if more else "", exponent.lstrip("0"))
