"""Messages on errors, and the texts of exceptions in them.  No Qt."""

import re

from mrs_simulator.core.doc_links import named, with_page

# A line, and below it a pointer to one of its characters, which is beside it in a font of the window.
POINTED = re.compile(r"(?m)^( .*)\n( +)\^")
HERE = "\u25b8"  # before that character instead


class ErrorMessage(str):
    """A message on an error, shown as such; plain texts are shown as information."""

    __slots__ = ()


def reason(error):
    """Return the text of an error for a message, with the documentation page on it where there is one.

    An ``error`` without a text of the package's own is named by its class.
    """
    worded = isinstance(error, (ValueError, OSError))
    text = with_page(error) if worded else named(error)
    return POINTED.sub(_marked, text)


def _marked(found):
    line, at = found[1], len(found[2])
    return line[:at] + HERE + line[at:]
