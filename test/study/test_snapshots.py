"""Runs that are taken back to a moment go on from there to the same bits, or say why they cannot."""

import itertools

import numpy as np
import pytest
from snapshot_runs import NAMES, goes_on_alike, rest_of, shipped

from mrs_simulator import PioneerControl
from mrs_simulator.core.snapshots import NotCopied
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.study.run.snapshots import Copied, NotRepeated, Repeated

CALLS = []


class Drawing(PioneerControl):
    def pointMassLaw(self, hand):
        return np.random.normal(0.0, 0.1, hand.shape)


class Generating(PioneerControl):
    def start(self):
        self.speeds = (0.01 * k for k in itertools.count())

    def pointMassLaw(self, hand):
        return np.full_like(hand, next(self.speeds))


class Unrepeatable(PioneerControl):
    once = (k for k in range(10**6))

    def pointMassLaw(self, hand):
        return np.full_like(hand, 1e-3 * next(self.once))


class Counting(PioneerControl):
    def pointMassLaw(self, hand):
        CALLS.append(len(hand))
        return np.full_like(hand, 1e-3 * len(CALLS))


class Remembering(PioneerControl):
    def start(self):
        self.seen = []

    def pointMassLaw(self, hand):
        self.seen.append(hand)
        return self.seen[0] - hand


def short(name="paper", duration=0.4, **changes):
    return shipped(name, duration=duration, record_rate=10.0, **changes)


def at_middle(protocol=None, scenario=None):
    """Return an experiment that has made two samples."""
    experiment = Experiment(short() if scenario is None else scenario, protocol)
    rest_of(experiment, 2)
    return experiment


@pytest.mark.parametrize("name", NAMES)
def test_every_shipped_scenario_goes_on_alike(name):
    assert goes_on_alike(short(name, 0.3))


@pytest.mark.parametrize("name", ["vicsek", "formation_boats", "formation_crazyflies"])
def test_robots_under_forces_go_on_alike(name):
    assert goes_on_alike(short(name, 0.3, fidelity="dynamic"))


@pytest.mark.parametrize("law", [Drawing, Generating, Remembering])
def test_users_laws_go_on_alike(law):
    assert goes_on_alike(short(), law)


def test_what_cannot_be_copied_is_run_again():
    experiment = at_middle(Generating)
    assert isinstance(experiment.snapshot(), Repeated)
    assert "generator" in experiment.snapshot().why
    assert isinstance(at_middle().snapshot(), Copied)
    pybullet = pytest.importorskip("pybullet")
    solved = at_middle(scenario=short(fidelity="dynamic"))
    assert "pybullet" in solved.snapshot().why
    with pytest.raises(NotCopied, match="pybullet"):
        solved.world.snapshot()
    solved.world.close()
    assert pybullet


def test_a_run_that_is_not_the_same_again_is_refused():
    experiment = at_middle(Unrepeatable)
    kept = experiment.snapshot()
    with pytest.raises(NotRepeated, match="not the same again at 0.100 s.*Unrepeatable.once"):
        experiment.restore(kept)


def test_a_law_that_keeps_its_state_in_its_module_is_refused():
    experiment = at_middle(Counting)
    kept = experiment.snapshot()
    rest_of(experiment, 1)
    with pytest.raises(NotRepeated, match="CALLS has changed since.*wanted it in self"):
        experiment.restore(kept)


def test_parameters_changed_meanwhile_are_taken_back():
    experiment = at_middle()
    kept, k = experiment.snapshot(), experiment.control.k
    alike = rest_of(experiment)
    experiment.restore(kept)
    experiment.control.set_parameters({**experiment.control.parameters, "k": 2.0 * k})
    assert rest_of(experiment) != alike
    experiment.restore(kept)
    assert experiment.control.k == k and rest_of(experiment) == alike


def test_an_iterator_of_samples_goes_on_from_where_it_is_taken_back_to():
    experiment = Experiment(short())
    samples = experiment.samples()
    next(samples)
    kept = experiment.snapshot()
    told = [next(samples)[0] for _ in range(2)]
    experiment.restore(kept)
    assert [next(samples)[0] for _ in range(2)] == told == pytest.approx([0.1, 0.2])


def test_before_the_first_sample_a_run_is_taken_back_to_its_start():
    experiment = Experiment(short("noisy_consensus"))
    kept = experiment.snapshot()
    whole = rest_of(experiment)
    experiment.restore(kept)
    assert rest_of(experiment) == whole and len(whole[0]) == 5


def test_sensors_that_are_recorded_to_files_are_not_taken_back(tmp_path):
    experiment = Experiment(short("formation_by_sonar", record=("sonar",)))
    files = experiment.record_sensors(str(tmp_path), lambda text: None)
    with pytest.raises(NotCopied, match="recorded to files"):
        experiment.snapshot()
    files.close()
