"""Messages on errors, and the texts of exceptions in them.  No Qt."""

from mrs_simulator.core.doc_links import named, with_page


class ErrorMessage(str):
    """A message on an error, shown as such; plain texts are shown as information."""

    __slots__ = ()


def reason(error):
    """Return the text of an error for a message, with the documentation page on it where there is one.

    An ``error`` without a text of the package's own is named by its class.
    """
    worded = isinstance(error, (ValueError, OSError))
    return with_page(error) if worded else named(error)
