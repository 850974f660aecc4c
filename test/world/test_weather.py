"""Gusts and waves are what they are said to be, whatever the step."""

import numpy as np
import pytest

from mrs_simulator.world.motion.wind_and_waves import Gusts, Waves

MANY = range(400)


@pytest.mark.parametrize("step", [0.02, 0.5])
def test_gusts_have_their_deviation_at_any_time(step):
    gusts = Gusts(1.5, 2.0, step, 7, MANY)
    seen = np.array([gusts.speed] + [gusts.advance() for _ in range(200)])
    # Of 400 robots: within four standard errors of a standard deviation.
    assert abs(seen[0].std() - 1.5) < 4.0 * 1.5 / np.sqrt(2.0 * 400)
    assert abs(seen[-1].std() - 1.5) < 4.0 * 1.5 / np.sqrt(2.0 * 400)
    # After 2 s 1/e of it is left.
    later = int(round(2.0 / step))
    assert (seen[later] * seen[0]).mean() / 1.5**2 == pytest.approx(np.exp(-1.0), abs=0.25)


def test_waves_have_their_deviation_and_their_period():
    waves = Waves(4.0, 0.1, 7, MANY)
    seen = np.array([waves.advance() for _ in range(400)])
    assert seen.shape == (400, 400, 2)
    np.testing.assert_allclose(seen.std(axis=(0, 1)), 1.0, atol=0.03)
    # Half a period later it is the other way round, a whole one later the same, damped.
    correlation = [(seen[lag:] * seen[: len(seen) - lag]).mean() for lag in (20, 40)]
    np.testing.assert_allclose(correlation, [-0.73, 0.53], atol=0.06)


@pytest.mark.parametrize(
    "make", [lambda rows: Gusts(1.0, 2.0, 0.1, 3, rows), lambda rows: Waves(4.0, 0.1, 3, rows)]
)
def test_what_a_robot_feels_is_its_own(make):
    few, many = make([1, 4]), make(range(6))
    for _ in range(100):
        a, b = few.advance(), many.advance()
        np.testing.assert_array_equal(a, b[[1, 4]])
    anew = make(range(6))
    again = [anew.advance() for _ in range(100)][-1]
    np.testing.assert_array_equal(again, b)
