"""What a node does once it has started up."""

import gc
import weakref

from mrs_simulator.ros.lifecycle import spare_garbage_collection


class Ring:
    def __init__(self):
        self.me = self


def test_what_is_there_is_spared_until_the_next_time():
    gc.unfreeze()
    try:
        ring = Ring()
        spare_garbage_collection()
        assert gc.get_freeze_count() > 0
        gone = weakref.ref(ring)
        del ring
        gc.collect()
        assert gone() is not None
        spare_garbage_collection()
        assert gone() is None
    finally:
        gc.unfreeze()
