"""How sure one may be that runs drawn at random keep their requirements."""

import math


def clean_runs(share, confidence):
    """Return how many runs without a failure show that at least ``share`` of all keep it.

    The least n with ``share^n <= 1 - confidence``: were fewer than ``share`` good, n good ones in a row
    had a smaller chance than that (exact binomial).  299 for 0.99 and 0.95.
    """
    return math.ceil(math.log(1.0 - confidence) / math.log(share) - 1e-12)


def log_evidence(good, runs, share):
    """Return the logarithm of the evidence, after ``good`` of ``runs``, that more than ``share`` are good.

    The mixture martingale ``M = B(1 + k, 1 + n - k) / (p^k (1 - p)^(n - k))`` with a uniform prior, p the
    ``share``: if at most p were good, it exceeded ``1/alpha`` at any time with probability at most
    ``alpha`` (Ville 1939), so one may look after each run and stop.
    """
    bad = runs - good
    beta = math.lgamma(1 + good) + math.lgamma(1 + bad) - math.lgamma(2 + runs)
    return beta - good * math.log(share) - bad * math.log1p(-share)


def lower_bound(good, runs, confidence):
    """Return the largest share that the evidence excludes from above at any time; 0 for no runs.

    The lower end of the confidence sequence: of all shares p below ``good / runs`` the largest for which
    ``log_evidence`` is at least ``-log(1 - confidence)``.
    """
    wanted, low, high = -math.log(1.0 - confidence), 0.0, good / runs if runs else 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        enough = 0.0 < middle < 1.0 and log_evidence(good, runs, middle) >= wanted
        low, high = (middle, high) if enough else (low, middle)
    return low


def interval(good, runs, confidence=0.95):
    """Return the exact two-sided interval (Clopper and Pearson 1934) of a share, ``good`` of ``runs``."""
    if not runs:
        return 0.0, 1.0
    tail = 0.5 * (1.0 - confidence)
    low = 0.0 if good == 0 else _solve(lambda p: _at_least(good, runs, p) - tail)
    high = 1.0 if good == runs else _solve(lambda p: tail - _at_least(runs - good, runs, 1.0 - p))
    return low, high


def _at_least(good, runs, share):
    """Return the chance of at least ``good`` successes in ``runs`` of probability ``share``."""
    if share <= 0.0 or share >= 1.0:
        return float(share >= 1.0 or good == 0)
    terms = [
        math.lgamma(runs + 1)
        - math.lgamma(k + 1)
        - math.lgamma(runs - k + 1)
        + k * math.log(share)
        + (runs - k) * math.log1p(-share)
        for k in range(good, runs + 1)
    ]
    return min(1.0, math.fsum(map(math.exp, terms)))


def _solve(rising):
    """Return where the function ``rising`` on [0, 1] is zero, by bisection."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if rising(middle) > 0.0 else (middle, high)
    return 0.5 * (low + high)
