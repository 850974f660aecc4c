"""What is made of a long run takes little memory beside the run itself."""

import tracemalloc

import numpy as np
import pytest
from protocol_fixtures import shipped

from mrs_simulator.core import sample_blocks
from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import Run
from mrs_simulator.study.draw.plane_figure import trajectories_height
from mrs_simulator.verdict import judging
from mrs_simulator.verdict.energy_balance import balance_of
from mrs_simulator.verdict.impossible_poses import first_jump
from mrs_simulator.verdict.law.published_checks import at_limit

SAMPLES, ROBOTS = 3000, 60


@pytest.fixture(scope="module")
def study():
    """Return a run of robots that creep, its control and energy."""
    scenario = shipped("paper").overridden(robots=ROBOTS)
    control = make_control(scenario)
    time = np.arange(SAMPLES) / scenario.record_rate
    pose = np.repeat(scenario.starts[np.newaxis], SAMPLES, axis=0)
    pose[:, :, 0] += 1e-3 * time[:, np.newaxis]
    hand = hand_points(pose.reshape(-1, 3), control.l).reshape(SAMPLES, ROBOTS, 2)
    command = np.full((SAMPLES, ROBOTS, 2), 1e-3)
    robots = np.arange(1, ROBOTS + 1)
    run = Run(time, robots, pose, hand, command, scenario=scenario, meta={"lockstep": True})
    return run, control, control.energy(hand[0])


WORK = {
    "balance": lambda run, control, energy: balance_of(control, energy, run),
    "dissipation": lambda run, control, energy: balance_of(control, energy, run),
    "limits": lambda run, control, energy: at_limit(control, run),
    "jumps": lambda run, control, energy: first_jump(run.time, run.pose, np.full(ROBOTS, 1.5)),
    "settling": lambda run, control, energy: control.measures(run),
    "extent": lambda run, control, energy: trajectories_height(run),
}


@pytest.mark.parametrize("what", WORK)
def test_a_long_run_is_looked_at_in_blocks(what, study, monkeypatch):
    run, *others = study
    monkeypatch.setattr(sample_blocks, "AT_ONCE", 50 * ROBOTS)
    if what == "dissipation":  # as where the law takes too long to compute
        monkeypatch.setattr("mrs_simulator.verdict.energy_balance.MOST_PAIRS", 0.0)
    tracemalloc.start()
    try:
        WORK[what](run, *others)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 0.4 * run.hand.nbytes


def test_theory_of_a_long_run_is_drawn_at_some_samples(study, monkeypatch):
    run, control, _ = study
    faults = []
    whole = judging._track(control, run, faults)
    assert whole.shape == run.hand.shape
    monkeypatch.setattr(judging, "LONG", SAMPLES * ROBOTS - 1)
    monkeypatch.setattr(judging, "MOST_DRAWN", 100)
    some = judging._track(control, run, faults)
    rows = np.searchsorted(run.time, some["time"])
    assert len(rows) == 100 and rows[0] == 0 and rows[-1] == SAMPLES - 1 and not faults
    np.testing.assert_array_equal(some["hand"], whole[rows])
