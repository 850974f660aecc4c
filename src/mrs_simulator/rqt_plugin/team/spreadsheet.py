"""Reads poses that are typed, or pasted from a spreadsheet.  No Qt."""

import math

from mrs_simulator.rqt_plugin.widgets.commas import comma_remark
from mrs_simulator.scenario.scenario import FARTHEST

HEADERS = ("robot", "x [m]", "y [m]", "heading [deg]", "kind")
LONGEST_QUOTE = 30  # [characters] of what was typed


def read_number(text, where):
    """Return ``text`` as a finite float within ``FARTHEST``; else ``ValueError``."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not abs(value) <= FARTHEST:
        text = str(text)
        quote = text if len(text) <= LONGEST_QUOTE else text[: LONGEST_QUOTE - 3] + "..."
        wanted = "wanted a number within {:g}{}".format(FARTHEST, comma_remark(text))
        raise ValueError("{}: {!r}, {}".format(where, quote, wanted))
    return value


def read_rows(text):
    """Return lists [x, y] or [x, y, heading] of pasted ``text``; raises ``ValueError`` for bad values."""
    rows = []
    for number, line in enumerate(text.rstrip().splitlines(), 1):
        where = "pasted row {}".format(number)
        cells = [cell.strip() for cell in line.rstrip().split("\t" if "\t" in line else ",")]
        if len(cells) not in (2, 3):
            raise ValueError(
                "{}: {} values, wanted x [m], y [m] and, if any, heading [deg], "
                "separated by tabs or commas".format(where, len(cells) if line.strip() else 0)
            )
        names = ("{}, {}".format(where, name) for name in HEADERS[1:])
        rows.append([read_number(cell, name) for cell, name in zip(cells, names)])
    return rows
