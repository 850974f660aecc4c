"""Runs of which no file is written: the same samples, facts and verdict as of those that are."""

import os

import numpy as np
import pytest
from protocol_fixtures import as_points, shipped

from mrs_simulator import PioneerControl
from mrs_simulator.record.recording import InMemory, RunError
from mrs_simulator.state.layout import basic_layout
from mrs_simulator.study.run.experiment import played
from mrs_simulator.study.run.simulating import simulate
from mrs_simulator.verdict.judging import judged


class Fails(PioneerControl):
    """Ahead for a second, and then an error."""

    def pointMassLaw(self, hand):
        if self.time >= 1.0:
            raise ValueError("far enough")
        return 0.0 * hand + 0.2


class Raises(PioneerControl):
    def pointMassLaw(self, hand):
        raise ValueError("no law")


MADE = {
    "points": lambda: as_points(shipped("consensus", duration=3.0)),
    "paper": lambda: shipped("paper", duration=2.0),
    "sensors": lambda: shipped("limited_visibility", duration=1.0),
    "above the ground": lambda: shipped("crazyflies_distances", duration=0.5),
    "collisions": lambda: shipped(
        "consensus", robots=2, poses=[[0, 0, 0], [1.5, 0, 3.14]], topology={"edges": [[1, 2]]},
        fidelity="kinematic", duration=6.0,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MADE)
def test_a_run_without_files_is_that_with_them(name, tmp_path, monkeypatch):
    scenario = MADE[name]()
    written = simulate(scenario, out=str(tmp_path / "out"))
    monkeypatch.chdir(tmp_path)
    run, control = played(scenario)
    assert os.listdir(tmp_path) == ["out"]
    for column in ("time", "pose", "hand", "command"):
        np.testing.assert_array_equal(getattr(run, column), getattr(written.run, column))
    assert [*run.collisions] == [*written.run.collisions]
    assert bool(run.collisions) == (name == "collisions")
    measured = {**written.verdict, "real_time_factor": None}
    # That theory leads bodies together is foretold to who waits for a run.
    told = [each for each in measured["warnings"] if not each.startswith("theory leads")]
    assert judged(run, control)[0] == {**measured, "warnings": told}


@pytest.mark.parametrize("law", [Fails, Raises])
def test_a_law_that_fails_ends_a_run_without_files_as_one_with_them(law):
    scenario = {"poses": [[0, 0, 0], [3, 0, 0]], "duration": 2.0}
    written = simulate(scenario, protocol=law)
    run, control = played(written.run.scenario, law)
    np.testing.assert_array_equal(run.pose, written.run.pose)
    assert "the law failed" in run.meta["ended"] and run.meta["ended"] == written.verdict["ended"]
    assert judged(run, control)[0] == {**written.verdict, "real_time_factor": None}


def test_a_run_without_files_needs_samples():
    with pytest.raises(RunError, match="at least one sample"):
        InMemory([1, 2], 0.1, basic_layout(), 5).run_with(None, [], {})
