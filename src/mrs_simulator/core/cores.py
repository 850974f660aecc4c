"""How many cores there are to use."""

import os


def cores():
    """Return how many cores this process may use: on Linux those that a scheduler or container left it."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
