"""What runs report to people on stderr, or to who makes many of them and says it once."""

import contextlib
import sys
import threading

_thread = threading.local()


@contextlib.contextmanager
def reports_kept():
    """Give the list of the texts that this thread reports meanwhile; they are not written."""
    before, _thread.kept = getattr(_thread, "kept", None), []
    try:
        yield _thread.kept
    finally:
        _thread.kept = before


def report(text):
    """Write the lines of ``text`` to stderr, or keep them."""
    kept = getattr(_thread, "kept", None)
    if kept is not None:
        kept.append(text)
    else:  # at once, since others may write beside
        sys.stderr.write(text + "\n")
