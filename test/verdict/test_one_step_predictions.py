"""What verdicts compute for all samples at once is what they compute one command after the other."""

import numpy as np
import pytest
from protocol_fixtures import shipped

from mrs_simulator.protocols.making import make_control
from mrs_simulator.protocols.published.laws import Averaging, Published, exact_motion
from mrs_simulator.study.run.experiment import perform
from mrs_simulator.verdict.theory import exact_runs, one_step_predictions


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Return ten seconds of the paper's scenario, in which robots are at limits first, and the control."""
    run, _ = perform(shipped("paper", duration=10.0), str(tmp_path_factory.mktemp("paper")))
    return run, make_control(run.scenario)


@pytest.fixture
def followed(monkeypatch):
    """Return a function of control and run: what is predicted, None where samples do not show it."""

    def at_once(control, run):
        given = []

        def asked(*arguments):
            given.append(one_step_predictions.one_step_predictions(*arguments))

        monkeypatch.setattr(exact_runs, "one_step_predictions", asked)
        in_turn = exact_runs.robots_run(control, run)
        return given[0] if given else None, in_turn

    return at_once


def test_samples_predicted_at_once_are_the_motion_from_the_start(done, followed):
    run, control = done
    found, expected = followed(control, run)
    np.testing.assert_allclose(found.hand, expected.hand, atol=1e-9)
    np.testing.assert_allclose(found.command, expected.command, atol=1e-8)
    np.testing.assert_array_equal(found.limited, expected.meta["limited"])
    np.testing.assert_allclose(found.cut, expected.meta["cut"], atol=1e-9)
    turned = np.exp(1j * found.pose[..., 2]) - np.exp(1j * expected.pose[..., 2])
    assert np.abs(turned).max() < 1e-8 and expected.meta["limited"].any()


@pytest.mark.parametrize("off, met", [(1e-10, True), (1e-6, False), (np.nan, False)])
def test_samples_that_the_law_does_not_meet_are_not_its_motion(off, met, done, followed):
    run, control = done
    pose, hand = run.pose.copy(), run.hand.copy()
    pose[50, 2, 0] += off
    hand[50, 2, 0] += off
    found, _ = followed(control, run._replace(pose=pose, hand=hand))
    assert (found is not None) == met


@pytest.mark.parametrize("changes", [{"k": 0.9, "T": 0.01}, {"l": 0.01}])
def test_where_differences_can_grow_robots_are_followed_in_turn(changes, followed, tmp_path):
    """The gain overshoots, or a command moves the point by more than ``l``."""
    scenario = shipped("paper", duration=0.5)
    control = scenario.control
    control = control._replace(parameters={**control.parameters, **changes})
    run, _ = perform(scenario._replace(control=control), str(tmp_path))
    found, expected = followed(make_control(run.scenario), run)
    assert found is None and np.abs(expected.hand - run.hand).max() < 1e-6


@pytest.mark.parametrize("still", [(), (1,)])
@pytest.mark.parametrize("drift", [0.0, 0.1])
def test_the_exact_solution_by_doubling_is_that_step_by_step(still, drift):
    weights = np.array([[0.0, 2.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.5, 0.0]])
    law = Averaging(weights, 0.7, np.arange(6.0).reshape(3, 2), still)
    start = np.array([[3.0, 1.0], [-2.0, 0.0], [0.0, 5.0]])
    rows = np.array([0, 1, 1, 5, 40, 76])
    for found, expected in zip(
        law.motion(start, 0.1, rows, drift), Published.motion(law, start, 0.1, rows, drift)
    ):
        assert found.shape == (6, 3, 2)
        np.testing.assert_allclose(found, expected, atol=1e-12)


def test_an_exact_solution_whose_powers_overflow_goes_step_by_step():
    law = Averaging(np.array([[0.0, 1.0], [1.0, 0.0]]), 100.0)
    agreed = np.ones((2, 2))
    points, u = exact_motion(law, agreed, 1.0, np.arange(400.0))
    assert (points == 1.0).all() and (u == 0.0).all()
    assert not law.keeps_close(1.0) and law.keeps_close(0.01)


@pytest.mark.parametrize("name", ["consensus", "consensus_directed", "paper"])
def test_energies_of_many_states_are_those_of_each(name):
    scenario = shipped(name)
    control = make_control(scenario)
    energy = control.energy(control.points(scenario.starts))
    hand = np.random.default_rng(0).uniform(-5.0, 5.0, (4, scenario.n, 2))
    assert energy.stacks
    for found, of_one in ((energy.values, energy.of), (energy.losses, energy.spent)):
        expected = [of_one(points, None, 0.0) for points in hand]
        np.testing.assert_allclose(found(hand, None, np.zeros(4)), expected, rtol=1e-12)
