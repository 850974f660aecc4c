"""Catches exceptions in slots, events and timers; one that escapes aborts all of rqt."""

import functools
import logging

LOG = logging.getLogger("rosout.mrs_simulator.gui")


def guarded(function):
    """Return ``function`` with every exception logged instead of raised; it then returns None."""

    @functools.wraps(function)
    def call(*args, **kwargs):
        try:
            return function(*args, **kwargs)
        except Exception:
            LOG.exception("in %s", function.__qualname__)
            return None

    return call
