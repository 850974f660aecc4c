"""Numbers with their units, as panels show them."""

import math

MINUS, DEGREE = "\u2212", "\u00b0"
MOST_SEEN = 6  # [-] robots or beacons that are listed


def number(value, digits, unit=""):
    """Return ``value`` with its unit; a dash for NaN."""
    if not math.isfinite(value):
        return "\u2013" if math.isnan(value) else "\u221e"
    return "{:.{}f}".format(value, digits).replace("-", MINUS) + unit


def degrees(value):
    """Return an angle [rad] in degrees."""
    return number(math.degrees(value), 1, DEGREE)


def listed_text(what, reading):
    """Return numbers, ranges and bearings of a ``reading`` of things, ``what``, in words."""
    if not len(reading.numbers):
        return "sees no {}".format(what)
    parts = [
        "{} {}: {}{}".format(what, int(k), number(far, 2, " m"), _at(way))
        for k, far, way in zip(reading.numbers, reading.ranges, reading.bearings)
    ]
    more = len(parts) - MOST_SEEN
    return "; ".join(parts[:MOST_SEEN] + (["{} more".format(more)] if more > 0 else []))


def _at(way):
    return " at {}".format(degrees(way)) if math.isfinite(way) else ""
