"""String stability: typed-out gains, the threshold 2 kappa tau = 1, and chains on both sides of it."""

import numpy as np
import pytest
from protocol_fixtures import check, shipped, verdict_of

from mrs_simulator.protocols.marching.platoon import Platoon
from mrs_simulator.protocols.marching.string_equations import (
    amplitudes,
    held_link,
    held_link_gain,
    link_gain,
    worst_frequency,
)

AMPLIFIED = "amplification from robot to robot"


def test_gains_typed_out():
    # omega = kappa = 1, tau = 0.75: |j + e^(-0.75j)|^2 = 2 - 2 sin 0.75 = 0.63672.
    assert link_gain(1.0, 1.0, 0.75) == pytest.approx(1.0 / np.sqrt(0.636723), rel=1e-5)
    assert link_gain(1.0, 1.0, 0.75, "state") == pytest.approx(np.sqrt(0.5))
    assert link_gain(1.0, 1.0, 0.4) == pytest.approx(1.0 / np.sqrt(2.0 - 2.0 * np.sin(0.4)))


def test_the_threshold_is_two_kappa_tau():
    omega = np.linspace(1e-4, 20.0, 20001)
    for product, stable in ((0.8, True), (0.999, True), (1.001, False), (1.5, False)):
        for gain in (0.5, 2.0):
            tau = 0.5 * product / gain
            assert (link_gain(gain * omega, gain, tau).max() <= 1.0) is np.bool_(stable)
            assert link_gain(gain * omega, gain, tau, "state").max() <= 1.0
    assert worst_frequency(1.0, 0.4) == (0.0, 1.0)
    omega, worst = worst_frequency(1.0, 0.75)
    assert 1.0 < omega < 1.5 and worst > 1.2


def test_held_commands_approach_the_theorem():
    held = held_link_gain(1.0, 1.0, 1e-4, 7500)
    assert held == pytest.approx(link_gain(1.0, 1.0, 0.75), rel=1e-3)


def test_amplitudes_of_sines():
    time = np.arange(0.0, 20.0, 0.1)
    values = np.stack([0.3 * np.sin(1.1 * time + 1.0) + 2.0, 0.1 * np.cos(1.1 * time)], axis=1)
    np.testing.assert_allclose(amplitudes(time, values, 1.1), [0.3, 0.1])


@pytest.mark.parametrize(
    "tau, delayed, grows",
    [(0.75, "difference", True), (0.4, "difference", False), (0.75, "state", False)],
)
def test_an_error_grows_down_the_chain_or_does_not(tau, delayed, grows, tmp_path):
    scenario = shipped("platoon", {"tau": tau, "delayed": delayed}, duration=60.0)
    verdict = verdict_of(scenario, tmp_path)
    assert verdict["passed"], verdict["checks"]
    found = check(verdict, AMPLIFIED)
    theory = link_gain(1.0, 1.0, tau, delayed)
    assert found["measured"] == pytest.approx(theory, rel=0.06)
    assert (found["measured"] > 1.0) is grows
    margin = {"difference": 1.0 - 2.0 * tau, "state": 1.0}[delayed]
    assert verdict["string_margin"] == pytest.approx(margin)
    assert (verdict["worst_amplification"] > 1.0) is grows


def test_a_law_that_forgets_the_delay_fails(tmp_path):
    class Prompt(Platoon):
        def law(self, hand):
            u = super().law(hand)
            errors = hand - self._first
            u[:-1] = self.gain * (errors[1:] - errors[:-1])
            return u

    verdict = verdict_of(shipped("platoon"), tmp_path, Prompt)
    assert check(verdict, AMPLIFIED)["passed"] is False


class HearsTheNextAtOnce(Platoon):
    """As much from robot to robot, but sooner by tau."""

    def law(self, hand):
        late = super().law(hand)
        errors = hand - self._first
        then = self._history[0] if len(self._history) > self.delay_steps else 0.0 * errors
        late[:-1] = self.gain * (errors[1:] - then[:-1])
        return late


class SwaysLess(Platoon):
    def _sway(self, time):
        return 0.98 * super()._sway(time)


@pytest.mark.parametrize(
    "law, wrong",
    [(HearsTheNextAtOnce, "phase from robot to robot"), (SwaysLess, "sway of the leader over")],
)
def test_phase_and_amplitude_are_claimed_where_the_ratio_shows_nothing(tmp_path, law, wrong):
    verdict = verdict_of(shipped("platoon"), tmp_path, law)
    assert check(verdict, AMPLIFIED)["passed"], verdict["checks"]
    assert check(verdict, wrong)["passed"] is False


@pytest.mark.parametrize(
    "delayed, tau", [("difference", 0.75), ("difference", 0.2), ("state", 0.75)]
)
def test_held_commands_lower_the_threshold_of_stability(delayed, tau):
    """At 10 Hz, by the roots of ``z - 1 + a z^-m``, or of ``z - 1 + a``, a = gain Tc."""
    steps = int(round(10.0 * tau)) if delayed == "difference" else 0
    law = Platoon(range(1, 4), period=0.1, parameters={"tau": tau, "delayed": delayed})
    for share, holds in ((0.999, True), (1.001, False)):
        a = share * 2.0 * np.sin(np.pi / (4 * steps + 2))
        polynomial = np.zeros(steps + 2)
        polynomial[:2], polynomial[-1] = (1.0, -1.0), polynomial[-1] + a
        if not steps:
            polynomial = np.array([1.0, a - 1.0])
        assert (np.abs(np.roots(polynomial)).max() < 1.0) == holds
        law.set_parameters({"tau": tau, "delayed": delayed, "gain": 10.0 * a})
        conditions = [c for c in law.claims(np.zeros((3, 2))) if c.name.startswith("gain Tc")]
        assert [c.holds for c in conditions] == [holds]


def test_the_phase_of_a_link_is_that_of_its_transfer_function():
    # omega = kappa = 1, tau = 0.75: 1/G = 1 + j e^(0.75 j) = 1 - sin 0.75 + j cos 0.75.
    held = held_link(1.0, 1.0, 1e-4, 7500)
    assert np.angle(held) == pytest.approx(-np.arctan2(np.cos(0.75), 1.0 - np.sin(0.75)), abs=1e-3)
    assert abs(held) == held_link_gain(1.0, 1.0, 1e-4, 7500)


def test_a_short_run_is_not_judged(tmp_path):
    verdict = verdict_of(shipped("platoon", duration=10.0), tmp_path)
    assert "too short for amplitudes" in check(verdict, AMPLIFIED)["note"]
