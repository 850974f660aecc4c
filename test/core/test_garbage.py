"""Tests of when garbage is collected."""

import gc

import pytest

from mrs_simulator.core.garbage import collected_later, loading


@pytest.fixture(autouse=True)
def as_before():
    yield
    gc.enable()
    gc.unfreeze()


@pytest.mark.parametrize("collects", [False, True])
def test_collection_goes_on_as_it_was(collects):
    (gc.enable if collects else gc.disable)()
    with pytest.raises(KeyError), collected_later(), collected_later():
        assert not gc.isenabled()
        raise KeyError
    assert gc.isenabled() is collects


def test_what_was_loaded_is_passed_over():
    with loading():
        assert not gc.isenabled()
        before, loaded = gc.get_freeze_count(), [[] for _ in range(100)]
    assert gc.isenabled()
    assert gc.get_freeze_count() >= before + len(loaded)
