"""Messages on what went wrong, told apart from those on what was done.  No Qt."""


class Trouble(str):
    """A message on something that went wrong; plain texts tell what was done."""

    __slots__ = ()


def reason(error):
    """Return for a message why something was refused: the kind of an ``error`` that nobody worded."""
    worded = isinstance(error, (ValueError, OSError))
    return str(error) if worded else "{}: {}".format(type(error).__name__, error)
