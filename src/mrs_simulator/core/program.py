"""How a command was called, for its usage: alone, as under ROS, or below ``mrs-simulator``."""

import contextlib

_above = ""  # the command and a blank


@contextlib.contextmanager
def below(command):
    """Prefix what ``program`` returns by ``command`` inside the block."""
    global _above
    _above = command + " "
    try:
        yield
    finally:
        _above = ""


def program(name):
    """Return how the command ``name`` was called."""
    return _above + name
