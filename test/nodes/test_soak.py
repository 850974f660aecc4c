"""The soak's judgements: of memory, gaps, rate and robots that stand."""

import json
import os
import sys

import numpy as np

sys.path.insert(
    0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "faults")
)

import soak
from motion import Motion

GOOD = {
    "grown": {"stage": (0.001, 1e5)},
    "ended": [],
    "rate": 1.0,
    "missing from run.csv": 0,
    "missing from the bag": 0,
    "stood": 0.0,
}


def test_each_figure_can_be_wrong():
    assert soak.judged(GOOD) == []
    for key, value, said in [
        ("grown", {"GUI": (0.05, 5e6)}, "GUI grew by 5.0%, 5.0 MB"),
        ("ended", ["stage"], "stage ended"),
        ("rate", 0.9, "simulated time went at 0.900 of wall time"),
        ("missing from run.csv", 3, "3 samples missing from run.csv"),
        ("missing from the bag", 2, "2 samples missing from the bag"),
        ("stood", 4.0, "robots stood for 4 s"),
    ]:
        assert soak.judged(dict(GOOD, **{key: value})) == [said]


def test_memory_grows_where_it_stays_grown():
    when = np.arange(0.0, 1000.0, 5.0)
    level = 1e8 + 1e6 * (when < 100.0)
    assert abs(soak.grown(list(zip(when, level)), 200.0)[0]) < 1e-9
    leak = level + 1e4 * when
    assert soak.grown(list(zip(when, leak)), 200.0)[0] > 0.05
    peak = level + 5e7 * (when == 700.0)
    assert soak.grown(list(zip(when, peak)), 200.0)[0] == 0.0


def test_missing_samples_are_counted():
    stamps = np.arange(100) * 0.1
    assert soak.gaps(stamps, 0.1) == 0
    assert soak.gaps(np.delete(stamps, [5, 50, 51]), 0.1) == 3


def test_robots_that_stand_are_seen(tmp_path):
    path = tmp_path / "motion"

    def motion_of(x):
        lines = [[s, s, [0.2 * s, at], [0.0, 3.0]] for s, at in zip(np.arange(0.0, 10.0, 0.1), x)]
        path.write_text("".join(json.dumps(line) + "\n" for line in lines))
        return Motion(str(path))

    driving = 0.2 * np.arange(0.0, 10.0, 0.1)
    assert soak.stood(motion_of(driving)) == 0.0
    assert 2.0 <= soak.stood(motion_of(np.minimum(driving, 1.2))) <= 4.0


def test_a_program_s_memory_is_that_of_all_it_started():
    class Self:
        pid = os.getpid()

    assert soak.memory(Self) > 1e7 and os.getpid() in soak.family(os.getpid())
