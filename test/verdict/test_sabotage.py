"""A physical fault of one robot on full dynamics fails the run, and its wheel is named."""

import os
import sys

import pytest
from protocol_fixtures import check

pytest.importorskip("pybullet")
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "benchmarks"))
import sabotage  # noqa: E402 (beside the package)


@pytest.mark.parametrize(
    "fault, line, said",
    [
        ("slow wheel", "gain", "robot3, left wheel"),
        ("creeping", "bias", "robot3"),
        (None, "gain", ""),
    ],
)
def test_a_fault_of_one_robot_is_named(fault, line, said):
    verdict = sabotage.verdict_of(sabotage.scenario_of("paper_dynamic", 9.0), fault)
    one = check(verdict, line + " of wheels and axes")
    assert one["passed"] is (fault is None) and said in one["note"], one
