"""Garbage collection of programs that run for long, or make many objects at once."""

import contextlib
import gc


def spare_garbage_collection(anew=False):
    """Have later collections of garbage pass over everything that is there now, since most of it stays.

    To be called once a node has started up, and ``anew`` where its team has changed: then what was spared
    before is looked through once more.  Looking through what 1000 robots' topics consist of takes 50 ms
    and more, during which no thread runs.
    """
    if anew:
        gc.unfreeze()
    gc.collect()
    gc.freeze()


@contextlib.contextmanager
def loading():
    """Collect no garbage while modules are imported, since most of it stays, and pass over it from then on.

    Looking through it again and again takes an eighth of what imports take, and is part of each short run.
    """
    with collected_later():
        yield
        gc.freeze()


@contextlib.contextmanager
def collected_later():
    """Have no garbage collected while the context lasts, in which more objects are made than are dropped.

    Looking through 1000 positions and Twists, again and again until they are dropped, takes an eighth of
    what a law takes to make them.
    """
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def loading_more():
    """Return :func:`loading` in a program that passes over what it has loaded, else a context that does
    nothing: whose objects a library finds may become garbage.

    For what is loaded in the midst of a run and stays.
    """
    return loading() if gc.get_freeze_count() else contextlib.nullcontext()
