"""Shipped scenarios give the values that they gave: to the bit on a like machine, else closely."""

import numpy as np
import pytest
from recorded_values import (
    SMALL,
    cases,
    differing,
    digests,
    kept,
    load,
    machine,
    run_values,
    unpacked,
)

RECORDED = load()
SAME_MACHINE = machine() == RECORDED["machine"]


def test_every_shipped_scenario_is_recorded():
    assert {"{} {}".format(*case) for case in cases()} == set(RECORDED["runs"])


@pytest.mark.parametrize("name, fidelity", cases())
def test_values_are_those_recorded(name, fidelity, tmp_path):
    recorded = RECORDED["runs"]["{} {}".format(name, fidelity)]
    values = run_values(name, fidelity, tmp_path)
    if "outcome" in recorded:
        assert values == recorded["outcome"]
        return
    assert not isinstance(values, str), values
    if SAME_MACHINE:
        changed = {
            column
            for column, digest in digests(values).items()
            if digest != recorded["digests"][column]
        }
        assert not changed, "other values than recorded on {}".format(RECORDED["machine"])
    else:
        wanted = unpacked(recorded["kept"])
        far = differing(kept(values)[: len(wanted)], wanted, SMALL)
        names = list(values)
        where = {names[column] for column in np.nonzero(far)[2]}
        assert not where, "{} differ from those recorded".format(sorted(where))
