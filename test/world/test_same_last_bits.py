"""No run or verdict asks numpy for sines of arrays with gaps, or the like: last bits are up to the heap.

Where the gaps of the argument reach into the memory of the result, numpy takes them for overlapping and
calls the C library instead of its vector library; what lies beside what differs from process to process.
"""

import os
import traceback

import numpy as np
import pytest
from recorded_values import SCENARIOS

from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.study.run.experiment import run_experiment

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
# All of whose calls of these functions stand in lines that the other scenarios reach, too.
ALIKE = """
    ardrones_formation ardrones_step bearing_formation bearing_leaders burgers_by_laser consensus_delays
    consensus_directed consensus_drops coverage_bay crazyflies_bearings crazyflies_cube
    crazyflies_distances crazyflies_flocking crazyflies_marching cyclic_pursuit_inwards delayed_consensus
    discrete_consensus displacement_formation distance_formation estimated_formation formation_lossy
    formation_omnidirectional formation_safely formation_switching lab_four lossy_consensus marching
    marching_lag paper paper_four paper_literal paper_theory reynolds second_order_consensus
    sensed_following station_keeping_integral switching_consensus trajectory
"""


def has_gaps(array):
    """Return whether the floats of ``array`` lie apart; numpy counts the stride of a single one, too."""
    if not isinstance(array, np.ndarray) or array.dtype != float or array.ndim == 0:
        return False
    return not array.flags.forc or (array.size == 1 and min(array.strides) > array.itemsize)


def is_complex(array):
    """Return whether ``array`` has phases, which ``np.angle`` takes of parts that lie apart."""
    return isinstance(array, np.ndarray) and array.dtype == complex and array.ndim > 0


class Watched:
    """A function of numpy that notes where it is given arrays with gaps, or ``wrong`` ones."""

    def __init__(self, function, found, wrong=has_gaps):
        self._function, self._found, self._wrong = function, found, wrong

    def __call__(self, *arguments, **options):
        """Return what the function does."""
        if any(map(self._wrong, arguments[: getattr(self._function, "nin", 1)])):
            at = traceback.extract_stack(limit=2)[0]
            self._found.add("{}:{}: {}".format(at.filename, at.lineno, at.line))
        return self._function(*arguments, **options)

    def __getattr__(self, name):
        """Return what the function has besides, as ``outer``."""
        return getattr(self._function, name)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.release] * (name in ALIKE.split())) for name in NAMES],
)
def test_no_sine_is_taken_of_an_array_with_gaps(name, tmp_path, monkeypatch):
    found = set()
    for each in FUNCTIONS:
        monkeypatch.setattr(np, each, Watched(getattr(np, each), found))
    monkeypatch.setattr(np, "angle", Watched(np.angle, found, is_complex))
    scenario = load_scenario(os.path.join(SCENARIOS, name + ".yaml"))
    scenario = scenario._replace(fidelity="kinematic", duration=DURATION)
    verdict = run_experiment(scenario, str(tmp_path), formats=())
    assert verdict["duration"] == pytest.approx(DURATION) and not found
