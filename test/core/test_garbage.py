"""Tests of when garbage is collected."""

import gc
import subprocess
import sys

import pytest

from mrs_simulator.core.garbage import collected_later, loading, loading_more


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


@pytest.mark.parametrize("spares", [False, True])
def test_what_is_loaded_later_is_passed_over_in_programs_that_do_so(spares):
    gc.unfreeze()
    if spares:
        gc.freeze()
    before = gc.get_freeze_count()
    with loading_more():
        loaded = [[] for _ in range(100)]
    assert gc.get_freeze_count() >= before + len(loaded) if spares else not gc.get_freeze_count()


@pytest.mark.parametrize("spares", [False, True])
def test_numba_is_passed_over_where_what_was_loaded_before_is(spares):
    pytest.importorskip("numba")
    code = (
        "import gc; from mrs_simulator.core import compiling; {}; before = gc.get_freeze_count(); "
        "compiling.jit(); print(gc.get_freeze_count() - before)"
    ).format("gc.freeze()" if spares else "pass")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout) > 10000 if spares else int(done.stdout) == 0
