"""Who called a command: a shell, ``mrs-simulator`` or a GUI."""

import contextlib

# A GUI may crash or be killed: what it started sees that its parent is gone, and ends.
PARENT = "MRS_SIMULATOR_PARENT"
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
