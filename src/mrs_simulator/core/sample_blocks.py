"""Blocks of samples, so that evaluating a long run takes little memory, and maps of samples in files."""

import mmap
import weakref

AT_ONCE = 1 << 15  # [-] robots, over all samples of a block: what a processor's cache holds
MOST_SEEN = 1 << 20  # [-] robots, over all samples, between two times that pages are released

_maps, _seen = [], 0  # weak references


def blocks(samples, robots):
    """Yield slices of ``samples`` of so many ``robots``, in order, each of at least one sample."""
    size = max(1, AT_ONCE // max(robots, 1))
    for row in range(0, samples, size):
        yield slice(row, min(row + size, samples))
        note_seen(size * robots)


def release_of(memory):
    """Let :func:`release` release the pages of ``memory``, an ``mmap`` of a file, while that is there."""
    _maps[:] = [each for each in _maps if each() is not None] + [weakref.ref(memory)]


def release():
    """Let the pages of maps go, which stay in their files: they count as memory of this process."""
    global _seen
    _seen = 0
    for each in tuple(_maps):
        memory = each()
        if memory is not None:
            memory.madvise(mmap.MADV_DONTNEED)


def note_seen(robots):
    """Release pages when more ``robots``, over all samples, have been looked at than ``MOST_SEEN``."""
    global _seen
    _seen += robots
    if _seen > MOST_SEEN:
        release()
