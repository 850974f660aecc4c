"""What to say of a comma in a number.  No Qt."""

import re

COMMA = re.compile(r"\s*[-+\u2212]?\d*,\d*\s*")  # a number but for its decimal comma


def comma_remark(text):
    """Return what to add to the error on ``text``, which is no number: "" where it has no decimal comma."""
    return ", with a point in place of the comma" if COMMA.fullmatch(str(text)) else ""
