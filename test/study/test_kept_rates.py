"""Rates that whole steps cannot keep become the nearest ones that they can, and are named."""

import numpy as np
import pytest

from mrs_simulator.core.step_rates import rate_note, steps_between
from mrs_simulator.nodes.record import node
from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.verdict.verdict import _ended


@pytest.mark.parametrize(
    "rate, step, steps, said",
    [
        (10.0, 0.02, 5, ""),
        (15.0, 0.02, 3, "x at 16.667 Hz, every 3 steps of 0.02 s; wanted 15 Hz"),
        (30.0, 0.02, 2, "x at 25 Hz, every 2 steps of 0.02 s; wanted 30 Hz"),
        (300.0, 0.02, 1, "x at 50 Hz, every 1 steps of 0.02 s; wanted 300 Hz"),
        (33.2, 0.01, 3, ""),  # 33.333 Hz: within a hundredth
    ],
)
def test_the_nearest_period_of_whole_steps_is_kept_and_named(rate, step, steps, said):
    assert steps_between(rate, step) == steps and rate_note("x", rate, step) == said


def given(**more):
    return scenario_from_dict({"poses": [[0.0, 0.0, 0.0]], "duration": 0.6, **more})


def test_a_scenario_names_the_rate_that_it_cannot_keep():
    assert given().warnings() == []
    assert given(record_rate=15.0).warnings() == [
        "record_rate at 16.667 Hz, every 3 steps of 0.02 s; wanted 15 Hz"
    ]
    turned = given(poses=[[0.0, 0.0, 90.0]], record_rate=15.0).warnings()
    assert len(turned) == 2 and "wanted radians" in turned[0]
    assert "record_rate at 16.667 Hz" in Experiment(given(record_rate=15.0)).warnings[0]


def test_headless_and_over_ros_samples_come_at_the_same_times():
    """15 Hz with steps of 0.02 s: every 0.06 s in both."""
    scenario = given(record_rate=15.0)
    headless = [stamp for stamp, _, _ in Experiment(scenario).samples()]
    assert headless == pytest.approx(0.06 * np.arange(11), abs=1e-9)

    recorder, taken = Recorder(scenario), []
    for step in range(31):
        recorder.elapsed = 0.02 * step
        if node.RunRecorder._is_due(recorder):
            taken.append(recorder.elapsed)
    assert taken == pytest.approx(headless, abs=1e-9)


class Recorder:
    """What ``RunRecorder`` looks at to tell whether a sample of a stage is due."""

    def __init__(self, scenario):
        self.scenario, self.source = scenario, self
        self._next, self.PACED = 0.0, False


def test_a_run_to_its_last_kept_sample_is_not_cut_short():
    scenario = given(record_rate=300.0, duration=0.61)
    time = np.arange(0.0, 0.601, 0.02)
    zeros = np.zeros((len(time), 1, 3))
    run = Run(time, (1,), zeros, zeros[..., :2], zeros[..., :2], [], scenario, {}, ())
    assert _ended(run) == "complete"
    assert _ended(run._replace(time=time[:-2])) == "cut short"
