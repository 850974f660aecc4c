"""Rows of numbers as text, each with the fewest digits that read back to the same value.

``orjson``, where it is installed, writes them six times as fast as Python's own ``repr``.  It places
exponents otherwise: these are brought to Python's form, so that a file is the same to the byte whoever
wrote it.  A release of orjson that writes yet otherwise is not used.
"""

import functools
import re

import numpy as np

# Patterns that begin with what they look for are searched ten times as fast.
EXPONENT = re.compile(r"e(-?)(\d+)")  # 1e-7, which Python writes 1e-07
TINY = re.compile(r"0\.0000(\d)(\d*)")  # 0.000012, which Python writes 1.2e-05
ODD = np.array(  # numbers in which writers differ
    [0.0, -0.0, 1.0, -1e-4, 9.999e-5, 1.5e-5, -1e-5, 1e-7, 2.5e-10, 5e-324, 1.7e308, 0.1 + 0.2]
    + [1e15, 123456789012345680.0, 1e16, 1.5e16, -1e17, 1e22, 1e23, 10.00001, 0.00010000123, 1 / 3]
)


def rows_text(table):
    """Return one text for each row of ``table`` (n, c): its numbers with commas between them."""
    table = np.ascontiguousarray(table, dtype=float)
    if not np.isfinite(table).all():  # no JSON has such numbers
        return python_rows(table)
    return _writer()(table)


def python_rows(table):
    """Return the texts as Python writes them."""
    return [",".join(map(repr, row)) for row in table.tolist()]


@functools.lru_cache(maxsize=None)
def _writer():
    """Return the quickest function that writes rows as ``python_rows`` does."""
    try:
        import orjson  # optional
    except ImportError:
        return python_rows

    def rows(table):
        text = orjson.dumps(table, option=orjson.OPT_SERIALIZE_NUMPY).decode("ascii")[2:-2]
        if "e" in text:
            text = EXPONENT.sub(_python_exponent, text)
        if "0.0000" in text:
            text = TINY.sub(_python_tiny, text)
        return text.split("],[")

    return rows if rows(ODD[np.newaxis]) == python_rows(ODD[np.newaxis]) else python_rows


def _python_exponent(found):
    sign, digits = found.groups()
    return "e{}{:0>2}".format(sign or "+", digits)


def _python_tiny(found):
    begin = found.start()
    if begin and found.string[begin - 1].isdigit():  # 10.00001
        return found.group()
    first, more = found.groups()
    return "{}{}e-05".format(first, "." + more if more else "")
