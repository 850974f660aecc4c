"""Garbage collection of programs that run for long."""

import gc


def spare_garbage_collection():
    """Have later collections of garbage pass over everything that is there now, since most of it stays.

    To be called once a node has started up, and where its team has changed.  Looking through what 1000
    robots' topics consist of takes 50 ms and more, during which no thread runs.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()
