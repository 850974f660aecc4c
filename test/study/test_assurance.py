import math

import numpy as np
import pytest

from mrs_simulator.study.search.assurance import clean_runs, interval, log_evidence, lower_bound


def test_clean_runs_are_those_of_the_exact_binomial():
    assert clean_runs(0.99, 0.95) == 299
    assert clean_runs(0.9, 0.95) == 29
    assert clean_runs(0.5, 0.5) == 1


def test_evidence_is_the_mixture_over_all_shares():
    # Of 3 good and 1 bad: the integral of q^3 (1 - q) over [0, 1], 1/20, over 0.5^4.
    assert math.exp(log_evidence(3, 4, 0.5)) == pytest.approx((1.0 / 20.0) / 0.5**4)


def test_evidence_rarely_ever_exceeds_its_bound_where_too_few_are_good():
    """Ville's inequality under stopping at the first success: at most 5 %, by 2,000 sequences of 400."""
    random, share, wrong = np.random.default_rng(4), 0.9, 0
    outcomes = random.random((2000, 400)) < share
    good = np.cumsum(outcomes, axis=1)
    runs = np.arange(1, 401)
    table = {}
    for row in good:
        for k, n in zip(row[20::5], runs[20::5]):
            key = int(k), int(n)
            if key not in table:
                table[key] = log_evidence(*key, share) >= math.log(20.0) and k / n > share
            if table[key]:
                wrong += 1
                break
    assert wrong / 2000 <= 0.05
    assert log_evidence(100, 100, share) > math.log(20.0)  # and it does grow


def test_a_lower_bound_grows_with_the_evidence_and_stays_below_the_share():
    bounds = [lower_bound(n, n, 0.95) for n in (0, 10, 100, 1000)]
    assert bounds[0] == 0.0 and bounds == sorted(bounds) and 0.99 < bounds[-1] < 1.0
    assert lower_bound(90, 100, 0.95) < 0.9


def test_intervals_are_those_of_the_textbook():
    # Clopper and Pearson's own: 10 of 10, 95 %: 1 - 0.025^(1/10) excluded.
    assert interval(10, 10)[0] == pytest.approx(0.025 ** (1.0 / 10.0))
    low, high = interval(8, 10)
    assert (low, high) == (pytest.approx(0.4439, abs=1e-4), pytest.approx(0.9748, abs=1e-4))
    assert interval(0, 0) == (0.0, 1.0)
    mirrored = interval(2, 10)
    assert mirrored == (pytest.approx(1.0 - high), pytest.approx(1.0 - low))
