"""Catches exceptions in slots, events and timers; one that escapes aborts all of rqt."""

import functools
import logging

LOG = logging.getLogger("rosout.mrs_simulator.gui")


def guarded(function):
    """Return ``function`` with every exception logged instead of raised; it then returns None.

    Of a class these are the methods that Qt calls: slots, ``_on_...``, and handlers, ``...Event``.
    """
    if isinstance(function, type):
        for name, method in list(vars(function).items()):
            if name.startswith("_on_") or name.endswith("Event"):
                setattr(function, name, guarded(method))
        return function

    @functools.wraps(function)
    def call(*args, **kwargs):
        try:
            return function(*args, **kwargs)
        except Exception:
            LOG.exception("in %s", function.__qualname__)
            return None

    return call
