"""The memory that a call takes."""

import tracemalloc


def peak_of(function):
    """Return the most memory [bytes] that ``function`` holds at once."""
    tracemalloc.start()
    try:
        function()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
