"""Closes windows on signals from the event loop: Qt must not run inside a Python signal handler."""

import signal

from mrs_simulator.rqt_plugin.qt.QtCore import QTimer


def from_event_loop(handler):
    """Return a signal handler that has ``handler`` called by Qt's event loop, a moment later.

    Python calls a handler between any two instructions of the main thread.  A window that is closed
    while it is painted leaves Qt painting widgets that are gone.
    """

    def later(*arguments):
        QTimer.singleShot(0, lambda: handler(*arguments))

    later.handler = handler
    return later


def defer_interrupts():
    """Have the host's own handler of SIGINT, if it has one, called by the event loop."""
    handler = signal.getsignal(signal.SIGINT)
    if callable(handler) and handler is not signal.default_int_handler:
        signal.signal(signal.SIGINT, from_event_loop(getattr(handler, "handler", handler)))
