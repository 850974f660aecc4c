import contextlib
import math
import random as random_module

import numpy as np
import pytest
from random_formulas import (
    by_definition,
    has_unbounded,
    horizon,
    is_whole,
    random_formula,
    random_signals,
)

from mrs_simulator.core.temporal_logic.formula import (
    UNBOUNDED,
    Always,
    And,
    Each,
    Eventually,
    Not,
    Or,
    Until,
    ending,
)
from mrs_simulator.core.temporal_logic.robustness import Signal, evaluate
from mrs_simulator.core.temporal_logic.syntax import FormulaError, parse
from mrs_simulator.core.temporal_logic.windows import Windows

TIME = np.arange(6.0)
X = Signal([3.0, 1.0, -2.0, 0.5, 4.0, 2.0], "m")
Y = Signal([-1.0, -1.0, 2.0, -1.0, -1.0, 5.0], "m")
SPEED = Signal([0.2, 0.5, 0.1, 0.0, 0.0, 0.0], "m/s")
GAP = Signal(
    [[3.0, 2.0, 1.0, 2.0, 3.0, 3.0], [2.0, 2.0, 0.5, 0.4, 1.0, 3.0]], "m", "pair", ("1-2", "1-3")
)
REACHED = Signal(
    [[-1.0, 2.0, -1, -1, -1, -1], [-1, -1, -1, 3.0, -1, -1]], "m", "robot", ("robot1", "robot2")
)
SIGNALS = {"x": X, "y": Y, "speed": SPEED, "distance": GAP, "reached": REACHED}


def found(text, time=TIME, signals=SIGNALS):
    return evaluate(parse(text), text, time, signals)


def robustness(text):
    result = found(text)
    assert result.low == result.high
    return result.low


def test_formulas_of_the_page_are_read():
    text = "eventually[0, 60] always(error < 0.05 m)"
    formula = parse(text)
    assert isinstance(formula, Eventually) and formula.window == (0.0, 60.0)
    assert isinstance(formula.operand, Always) and formula.operand.window == UNBOUNDED
    constant = formula.operand.operand.terms[0]
    assert (constant.factor, constant.unit) == (0.05, "m")
    assert isinstance(parse("always(each pair(distance >= 0.6 m))").operand, Each)


def test_and_binds_before_or_and_or_before_implies():
    formula = parse("x > 0 or y > 0 and speed > 0 implies not x > 1")
    left, right = formula.operands
    assert isinstance(formula, Or) and isinstance(left, Not) and isinstance(right, Not)
    assert isinstance(left.operand, Or) and isinstance(left.operand.operands[1], And)
    assert isinstance(parse("x > 0 until[1 s, 500 ms] y > 0".replace("1 s", "0.1 s")), Until)


@pytest.mark.parametrize(
    "text, value",
    [
        ("x >= 1 m", 2.0),
        ("x >= 50 cm", 2.5),
        ("2*x + 1 m > y", 8.0),
        ("0 m < x < 10 m", 3.0),
        ("abs(x) <= 2 m", -1.0),
        ("always(x > 0)", -2.0),
        ("always[0, 1](x > 0)", 1.0),
        ("eventually(y > 0)", 5.0),
        ("eventually[1 s, 3 s] y > 0", 2.0),
        ("not always x > 0", 2.0),
        ("x > 0 until y > 0", 1.0),  # y at 2 s, x before it at least 1
        ("x > 0 until[0, 2] y > 0", 1.0),
        ("x > 0 until[3, 5] y > 0", -2.0),
        ("always(each pair(distance >= 0.6))", -0.2),
        ("always(distance >= 0.6)", -0.2),  # each, where nothing is said
        ("always(some pair(distance >= 1.5))", -0.5),
        ("each robot(eventually reached > 0)", 2.0),
        ("eventually(each robot(reached > 0))", -1.0),
        ("eventually(some robot(reached > 0))", 3.0),
        ("y > 0 implies x > 0", 3.0),
    ],
)
def test_robustness_of(text, value):
    assert robustness(text) == pytest.approx(value, abs=1e-12)


def test_it_says_when_where_and_by_what_it_was_decided():
    result = found("always(each pair(distance >= 0.6 m))")
    assert result.holds is False
    assert (result.time, result.member) == (3.0, "1-3")
    assert result.decided_at == 2.0  # 0.5 m then, though the worst came later
    assert result.margin == pytest.approx(-0.2) and result.unit == "m"
    kept = found("eventually always[0, 0](x > 3.5)")
    assert kept.holds and kept.decided_at == 4.0
    assert found("always x > -3").decided_at == 5.0  # to the end of the run
    near = found("always not each pair(distance >= 0.6 m)")
    assert near.holds is False and near.margin == near.high < 0.0
    assert near.predicate == "not (distance >= 0.6 m)"


def test_a_window_past_the_end_leaves_it_open():
    result = found("eventually[0, 9](x > 5)")
    assert result.holds is None and result.low == -1.0 and result.high == math.inf
    assert result.decided_at is None
    assert found("eventually[0, 9](x > 3)").holds is True
    assert found("always[0, 9](x > 0)").holds is False
    assert found("always[0, 9](x > -9)").holds is None
    assert found("always[0, 5](x > -9)").holds is True


def test_comparisons_in_several_units_are_divided_by_their_constants():
    result = found("always(x > -4 m and speed < 0.4 m/s)")
    assert result.low == pytest.approx((0.4 - 0.5) / 0.4)
    assert result.margin == pytest.approx(-0.1) and result.unit == "m/s"
    assert result.predicate == "speed < 0.4 m/s"


def test_samples_need_not_be_evenly_apart():
    time = np.array([0.0, 0.1, 0.5, 2.0, 2.1, 7.0])
    assert found("eventually[0, 2](y > 0)", time).low == 2.0
    assert found("always[0, 0.3](x > 0)", time).low == 1.0


@pytest.mark.parametrize(
    "text, message, position",
    [
        ("always(distanc > 1)", "did you mean 'distance'", 7),
        ("always(x > 1", "wanted `)`", 12),
        ("always x >", "wanted the name of a signal, a number", 10),
        ("x", "wanted `<` or `>` behind `x`", 1),
        ("always[3, 1] x > 0", "from 3 s to 1 s", 6),
        ("x > 1 m/s", "1 m/s beside a signal in m", 4),
        ("x > speed", "`speed` is in m/s", 4),
        ("each wheel(x > 1)", "one of robot, pair, edge", 5),
        ("x > 1 & y > 1", "a character that no formula has", 6),
        ("x > 1 y > 1", "wanted `and`", 6),
        ("1 > 2", "no signal is compared", 0),
        ("distance > reached", "one of each robot", 11),
        ("each robot(each pair(distance > 0))", "wanted one of them", 16),
        ("some pair(x > 0 or reached < 1)", "within `some pair`: wanted a signal of each pair", 19),
        (
            "each pair(always(distance > 1 or abs(reached) < 1))",
            "`reached` is one of each robot",
            33,
        ),
        ("always[0.2, 0.4] x > 0", "no sample lies within", 6),
        ("always[0, 1] eventually[0.2, 0.4] x > 0", "no sample lies within", 23),
        ("x > 0 until[0.2, 0.4] y > 0", "no sample lies within", 11),
        ("some robot(each pair(distance > 0)) or each pair(distance > 1)", "wanted one", 16),
        ("alwyas(x > 1)", "operator: unknown 'alwyas'; did you mean 'always'?", 0),
        ("not (eventualy[0, 2] x > 1)", "did you mean 'eventually'?", 5),
        ("nto x > 1", "did you mean 'not'?", 0),
        ("whenever(x > 1)", "operator: unknown 'whenever' (known: abs, always,", 0),
        ("x > 1 untill y > 1", "did you mean 'until'?", 6),
        ("always(x > 1 meter)", "unit: unknown 'meter' (known: %, 1/s, Hz", 13),
        ("always(x > 1 m/s^3)", "unit: unknown 'm/s^3'; did you mean 'm/s^2'?", 13),
        ("eventually[0, 2 sec] x > 0", "unit: unknown 'sec'", 16),
        ("x == 1", "no formula has, wanted `<=` or `>=`, got `=`", 2),
        ("eventually[0, 2 m] x > 0", "wanted a time in seconds", 17),
    ],
)
def test_errors_name_what_came_and_point_at_it(text, message, position):
    with pytest.raises(FormulaError) as caught:
        found(text)
    assert message in str(caught.value)
    assert str(caught.value).splitlines()[-1] == "  " + " " * position + "^"


def test_a_formula_too_long_or_too_deep_is_refused():
    with pytest.raises(FormulaError, match="2 characters; wanted|characters; wanted 2000"):
        parse("x > 1 and " * 1000 + "x > 1")
    with pytest.raises(FormulaError, match="more than 50 levels deep"):
        parse("not " * 60 + "x > 1")


def test_no_text_crashes_the_reader():
    random = random_module.Random(3)
    words = (
        "always eventually until not and or implies each some robot pair",
        "( ) [ ] , 1 2.5 m x < > - + * %",
    )
    pieces = " ".join(words).split()
    for _ in range(3000):
        text = " ".join(random.choice(pieces) for _ in range(random.randrange(12)))
        with contextlib.suppress(FormulaError):
            parse(text)


def test_random_formulas_agree_with_the_definition():
    random, done = np.random.default_rng(8), 0
    while done < 150:
        formula = random_formula(random)
        if not is_whole(formula) or horizon(formula) >= 18:
            continue
        values = random_signals(random, 20)
        wanted = by_definition(formula, values, 0)
        signals = {name: Signal(each) for name, each in values.items()}
        result = evaluate(formula, "", np.arange(20.0), signals)
        assert result.low == result.high == pytest.approx(wanted, abs=1e-12)
        assert result.margin == pytest.approx(wanted, abs=1e-12)
        known = int(result.decided_at) + 1  # whatever comes later, the truth stays
        later = {
            k: np.concatenate([v[:known], 3.0 * random.normal(size=20 - known)])
            for k, v in values.items()
        }
        assert (by_definition(formula, later, 0) >= 0.0) == (wanted >= 0.0)
        done += 1


def test_what_is_open_could_still_end_either_way():
    random, open_ones = np.random.default_rng(9), 0
    for _ in range(300):
        formula = random_formula(random, 2)
        if has_unbounded(formula) or not 4 < horizon(formula) < 12:
            continue
        values = {k: v[:5] for k, v in random_signals(random, 5).items()}
        signals = {name: Signal(each) for name, each in values.items()}
        result = evaluate(formula, "", np.arange(5.0), signals)
        assert result.low <= result.high
        for _ in range(20):
            more = {k: np.concatenate([v, 9.0 * random.normal(size=10)]) for k, v in values.items()}
            assert result.low - 1e-12 <= by_definition(formula, more, 0) <= result.high + 1e-12
        open_ones += result.holds is None
    assert open_ones > 10


@pytest.mark.parametrize("even", [True, False])
def test_a_formula_is_decided_at_the_first_sample_at_which_it_is(even):
    """Of a run that goes on, cut there it holds or does not, and cut one sample before it is open."""
    random, seen = np.random.default_rng(12), 0
    for _ in range(400):
        formula = random_formula(random, 2)
        time = np.arange(24.0) if even else np.cumsum(random.uniform(0.3, 1.2, 24))
        time = time - time[0]
        values = {k: np.round(v, 1) for k, v in random_signals(random, 24).items()}

        def until(samples, text=formula, time=time, values=values):
            cut = {name: Signal(each[:samples]) for name, each in values.items()}
            with contextlib.suppress(FormulaError):  # a window between two samples
                return evaluate(ending(text, 1e3), "[", time[:samples], cut).holds

        signals = {name: Signal(each) for name, each in values.items()}
        try:
            result = evaluate(formula, "[", time, signals)
        except FormulaError:
            continue
        if result.decided_at is None or result.decided_at == time[-1]:
            continue
        known = int(np.searchsorted(time, result.decided_at)) + 1
        assert until(known) is result.holds
        assert known == 1 or until(known - 1) is None
        seen += known > 1
    assert seen > 50


@pytest.mark.parametrize(
    "first, last", [(0.0, 0.0), (0.0, 3.0), (2.0, 7.5), (1.3, 40.0), (50.0, 60.0)]
)
@pytest.mark.parametrize("period", [1.0, 0.02, None])
def test_windows_hold_the_samples_that_they_say(first, last, period):
    random = np.random.default_rng(3)
    time = np.cumsum(random.uniform(0.5, 1.5, 31)) if period is None else period * np.arange(31)
    scale = period or 1.0
    first, last, values = scale * first, scale * last, random.normal(size=(2, 31))
    try:
        windows = Windows(time, (first, last))
    except ValueError:
        assert period is None or first % scale
        return
    found = windows.maximum(values)
    for row, now in enumerate(time):
        inside = (time >= now + first - 1e-7) & (time <= now + last + 1e-7)
        assert found[:, row] == pytest.approx(values[:, inside].max(axis=1, initial=-np.inf))
        assert windows.cut[row] == (now + last > time[-1] + 1e-7)
