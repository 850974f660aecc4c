"""Cosines and sines in compiled code: numpy's to the bit."""

import ctypes

import numpy as np
import pytest

from mrs_simulator.core import compiled_cos_sin
from mrs_simulator.core.compiled_cos_sin import cosines, loop_of, sines
from mrs_simulator.core.compiled_terms import linked
from mrs_simulator.core.compiling import NotInstalled, jit

ANGLES = np.random.default_rng(0).uniform(-7.0, 7.0, 4099)


def both(angles, cos, sin):
    cosines(angles, cos)
    sines(angles, sin)


@pytest.mark.parametrize("n", [0, 1, 2, 7, 64, 4099])
@pytest.mark.parametrize("is_compiled", [False, True])
def test_the_bits_are_numpys(n, is_compiled):
    function = both
    if is_compiled:
        pytest.importorskip("numba")
        function = linked(both, jit())
    cos, sin, angles = np.empty(n), np.empty(n), ANGLES[4099 - n :].copy()
    function(angles, cos, sin)
    np.testing.assert_array_equal(cos, np.cos(angles))
    np.testing.assert_array_equal(sin, np.sin(angles))


def test_a_numpy_that_keeps_its_loops_elsewhere_is_refused(monkeypatch):
    assert loop_of(np.sin) != loop_of(np.cos)

    class Other(ctypes.Structure):
        _fields_ = (("added", ctypes.c_int), *compiled_cos_sin.Ufunc._fields_)

    monkeypatch.setattr(compiled_cos_sin, "Ufunc", Other)
    with pytest.raises(NotInstalled, match="loops of numpy"):
        loop_of(np.sin)
