"""No run asks numpy for sines and the like of arrays with gaps, whose last bits are up to the heap.

Where the gaps of the argument reach into the memory of the result, numpy takes them for overlapping and
calls the C library instead of its vector library; what lies beside what differs from process to process.
"""

import os
import traceback

import numpy as np
import pytest
from recorded_values import SCENARIOS, run_values

# Whose two routines differ in the last bit.
FUNCTIONS = [
    "sin",
    "cos",
    "tan",
    "arcsin",
    "arccos",
    "arctan",
    "arctan2",
    "sinh",
    "cosh",
    "tanh",
    "exp",
    "exp2",
    "expm1",
    "log",
    "log2",
    "log10",
    "log1p",
    "power",
    "cbrt",
]
DURATION = 0.5  # [s] of each run
NAMES = sorted(name[:-5] for name in os.listdir(SCENARIOS) if name.endswith(".yaml"))


def has_gaps(array):
    """Return whether the floats of ``array`` lie apart; numpy counts the stride of a single one, too."""
    if not isinstance(array, np.ndarray) or array.dtype != float or array.ndim == 0:
        return False
    return not array.flags.forc or (array.size == 1 and min(array.strides) > array.itemsize)


class Watched:
    """A function of numpy that notes where it is given arrays with gaps."""

    def __init__(self, function, found):
        self._function, self._found = function, found

    def __call__(self, *arguments, **options):
        """Return what the function does."""
        if any(has_gaps(each) for each in arguments[: self._function.nin]):
            at = traceback.extract_stack(limit=2)[0]
            self._found.add("{}:{}: {}".format(at.filename, at.lineno, at.line))
        return self._function(*arguments, **options)

    def __getattr__(self, name):
        """Return what the function has besides, as ``outer``."""
        return getattr(self._function, name)


@pytest.mark.parametrize("name", NAMES)
def test_no_sine_is_taken_of_an_array_with_gaps(name, tmp_path, monkeypatch):
    found = set()
    for each in FUNCTIONS:
        monkeypatch.setattr(np, each, Watched(getattr(np, each), found))
    run_values(name, "kinematic", tmp_path, longest=DURATION)
    assert not found
