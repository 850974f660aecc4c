"""The command that finds thresholds without theory, and what it compares them with."""

import math

import pytest
from documentation import loaded


@pytest.fixture(scope="module")
def thresholds():
    return loaded("benchmarks", "thresholds")


def test_sampled_thresholds_approach_those_of_continuous_time(thresholds):
    for name, case in thresholds.CASES.items():
        if math.isfinite(case.continuous):
            assert case.sampled(2000.0) == pytest.approx(case.continuous, rel=0.01), name
            assert case.sampled(10.0) != pytest.approx(case.continuous, rel=0.02), name


def test_what_is_off_is_said(thresholds):
    right = [("delay", 10.0, 2.0, 2.01, 2.3, 9), ("delay", 100.0, 2.2, 2.2, 2.3, 9)]
    assert thresholds.wrong(right) == []
    off = [("delay", 10.0, 2.0, 2.05, 2.3, 9), ("delay", 100.0, 1.9, 1.9, 2.3, 9)]
    first, second = thresholds.wrong(off)
    assert "2.4 % off" in first and "farther from continuous time" in second


def test_a_threshold_is_bisected_by_what_runs_show(thresholds, monkeypatch):
    monkeypatch.setattr(thresholds, "FINE", 0.02)
    case = thresholds.CASES["held commands"]._replace(span=(5.0, 7.0))
    found, runs = thresholds.found_threshold(case, 10.0)
    assert found == pytest.approx(case.sampled(10.0), rel=0.02) and runs < 8
    with pytest.raises(ValueError, match="does not hold below and break above"):
        thresholds.found_threshold(case._replace(span=(6.5, 7.0)), 10.0)
