"""Random formulas and signals, and the quantitative semantics once more, straight from its definition."""

import math

from mrs_simulator.core.temporal_logic.formula import (
    Always,
    And,
    Eventually,
    Not,
    Or,
    Predicate,
    Term,
    Until,
    children,
)

SIGNALS = ("x", "y", "z")
DEPTH = 3
LONGEST = 6  # [s] of a window
SAMPLES = 60  # [-] of signals one second apart: no bounded window reaches past them


def random_formula(random, depth=DEPTH):
    """Return a formula over ``SIGNALS``, samples one second apart."""
    if depth == 0 or random.random() < 0.15:
        name, sign = random.choice(SIGNALS), random.choice([-1.0, 1.0])
        threshold = round(float(random.normal()), 3)
        return Predicate((Term(sign, str(name)), Term(-sign * threshold)), "{}".format(name))
    inner = [random_formula(random, depth - 1) for _ in range(2)]
    kind = random.choice([Not, And, Or, Always, Eventually, Until])
    if kind is Not:
        return Not(inner[0])
    if kind in (And, Or):
        return kind(tuple(inner))
    first = int(random.integers(0, LONGEST))
    window = (float(first), float(random.integers(first, LONGEST + 1)))
    window = (0.0, math.inf) if random.random() < 0.3 else window
    return kind(*inner, window) if kind is Until else kind(inner[0], window)


def random_signals(random, samples=SAMPLES):
    """Return values (samples,) by the names of ``SIGNALS``."""
    return {name: random.normal(size=samples) for name in SIGNALS}


def by_definition(formula, values, t):
    """Return the robustness of ``formula`` at the sample ``t``, one second apart, by its definition."""
    if isinstance(formula, Predicate):
        return sum(e.factor * (values[e.signal][t] if e.signal else 1.0) for e in formula.terms)
    if isinstance(formula, Not):
        return -by_definition(formula.operand, values, t)
    if isinstance(formula, (And, Or)):
        return (min if isinstance(formula, And) else max)(
            by_definition(each, values, t) for each in formula.operands
        )
    last = len(values["x"]) - 1
    first = t + int(formula.window[0])
    times = range(
        first, (last if math.isinf(formula.window[1]) else t + int(formula.window[1])) + 1
    )
    if isinstance(formula, Until):
        return max(_until_at(formula, values, t, end) for end in times)
    best = min if isinstance(formula, Always) else max
    return best(by_definition(formula.operand, values, k) for k in times)


def _until_at(formula, values, t, end):
    before = [by_definition(formula.left, values, k) for k in range(t, end)]
    return min([by_definition(formula.right, values, end), *before])


def horizon(formula):
    """Return how many samples after the first ``formula`` looks at, bounded windows alone."""
    last = getattr(formula, "window", (0.0, 0.0))[1]
    width = 0 if math.isinf(last) else int(last)
    return width + max(map(horizon, children(formula)), default=0)


def is_whole(formula):
    """Return whether no bounded window within an unbounded one reaches past the end."""
    endless = math.isinf(getattr(formula, "window", (0.0, 0.0))[1])
    return all(is_whole(each) and not (endless and horizon(each)) for each in children(formula))


def has_unbounded(formula):
    """Return whether an operator of ``formula`` reaches to the end of the run."""
    endless = math.isinf(getattr(formula, "window", (0.0, 0.0))[1])
    return endless or any(has_unbounded(each) for each in children(formula))
