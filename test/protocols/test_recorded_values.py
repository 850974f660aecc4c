"""Shipped scenarios give the values that they gave: to the bit on a like machine, else closely."""

import pytest
from recorded_values import FIRST, cases, changes, load, machine, run_values

RECORDED = load()
SAME_MACHINE = machine() == RECORDED["machine"]


def test_every_shipped_scenario_is_recorded():
    assert {"{} {}".format(*case) for case in cases()} == set(RECORDED["runs"])


@pytest.mark.parametrize("name, fidelity", cases())
def test_values_are_those_recorded(name, fidelity, tmp_path):
    recorded = RECORDED["runs"]["{} {}".format(name, fidelity)]
    values = run_values(name, fidelity, tmp_path, longest=FIRST[fidelity])
    if "outcome" in recorded:
        assert values == recorded["outcome"]
        return
    assert not isinstance(values, str), values
    changed = changes(values, recorded, SAME_MACHINE)
    assert not changed, "other values than recorded on {}".format(RECORDED["machine"])
