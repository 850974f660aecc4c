"""Messages on what went wrong, told apart from those on what was done.  No Qt."""

from mrs_simulator.core.doc_links import named, with_page


class ErrorMessage(str):
    """A message on something that went wrong; plain texts tell what was done."""

    __slots__ = ()


def reason(error):
    """Return for a message why something was refused, and the page that explains it where there is one.

    Of an ``error`` that nobody worded, its kind is told.
    """
    worded = isinstance(error, (ValueError, OSError))
    return with_page(error) if worded else named(error)
