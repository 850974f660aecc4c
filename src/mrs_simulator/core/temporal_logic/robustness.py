"""How robustly a formula holds: the quantitative semantics of Signal Temporal Logic (Donze and Maler 2010).

The robustness rho of ``s >= c`` is ``s - c``, that of a negation ``-rho``, of ``and`` and ``always`` the
minimum, of ``or`` and ``eventually`` the maximum, and for::

    (f until[a, b] g)(t) = max over t' in [t + a, t + b] of min(g(t'), min of f over [t, t'))

Its sign is the formula's truth; its size is how far the signals may move before that changes.  A bounded
window that reaches past the last sample leaves an interval: what is not known there is anything from
-inf to inf.  Unbounded operators reach to the end of the run.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.temporal_logic.deciding import decided_row
from mrs_simulator.core.temporal_logic.formula import (
    And,
    Each,
    Eventually,
    Not,
    Or,
    Predicate,
    Some,
    Until,
    children,
    predicates,
)
from mrs_simulator.core.temporal_logic.syntax import FormulaError, unknown_signal
from mrs_simulator.core.temporal_logic.units import UNITS
from mrs_simulator.core.temporal_logic.windows import Windows, least_from, until_within

GRADED = 20  # [-] of which one is among the smallest margins
MOST_AT_ONCE = 1 << 20  # [-] numbers of one array over robots, pairs or edges


class Signal(NamedTuple):
    """``values`` (m,) [unit] at m samples, or (k, m) of the k members of a ``domain``.

    ``labels``: the names of these members, such as "robot3", or a function that returns one's.
    """

    values: Any
    unit: str = ""
    domain: Any = None
    labels: Any = ()


class Bounds(NamedTuple):
    """Between which the robustness lies at each sample, (m,) or (k, m); one array where it is known."""

    low: Any
    high: Any

    @property
    def is_known(self):
        """Return whether both are the same."""
        return self.low is self.high

    def negated(self):
        """Return the bounds of the negation."""
        low = -self.high
        return Bounds(low, low if self.is_known else -self.low)

    def at(self, index):
        """Return the bounds [low, high] at one index."""
        return float(self.low[index]), float(self.high[index])


class Decided(NamedTuple):
    """The robustness of a formula at the first sample, between ``low`` and ``high``, and what decides it.

    It is in the unit of the formula's signals; those of formulas over several units are numbers, each
    comparison's margin divided by its constant.  ``predicate``: the text of the comparison that decides,
    or of its negation where the formula wants that, ``margin`` [``unit``] what this has to spare at
    ``time`` [s], ``member`` whose it is, such as "robot3", or "".  ``decided_at`` [s]: from when on the
    truth is certain.  While it is open, and of a formula about each of none, these are None.
    ``grade`` [``unit``]: the mean of the smallest margins, one sample in
    ``GRADED``, of that comparison and member, which still falls where the least of all does not;
    ``scale``: its constant, by which formulas may be compared with each other.
    """

    low: float
    high: float
    predicate: str = ""
    margin: Any = None
    unit: str = ""
    time: Any = None
    member: str = ""
    decided_at: Any = None
    grade: Any = None
    scale: float = 1.0

    @property
    def holds(self):
        """Return whether the formula holds, None where that is open."""
        if self.low >= 0.0:
            return True
        return False if self.high < 0.0 else None


def evaluate(formula, text, time, signals):
    """Return the :class:`Decided` of ``formula`` at the first of the samples at ``time`` (m,) [s].

    ``text``: that of the formula, for errors; ``signals``: :class:`Signal` by name.  Raises
    ``FormulaError`` for signals that do not exist, units that do not fit, and windows without a sample.
    """
    units = check(formula, text, signals)
    scaled = len(set(units.values())) > 1
    bound = _Evaluation(text, np.asarray(time, dtype=float), signals, scaled)
    low, high = bound.of(formula).at(0)
    found = Decided(low, high)
    if found.holds is None or math.isinf(low if found.holds else high):  # of no member at all
        return found
    side = "low" if found.holds else "high"
    predicate, row, member, own_side = bound.reason(formula, 0, side)
    margins, label = bound.margins(predicate, member)
    negated = own_side != side
    margins = -margins if negated else margins
    return found._replace(
        predicate="not ({})".format(predicate.text) if negated else predicate.text,
        margin=float(margins[row]),
        unit=units[predicate],
        time=float(bound.time[row]),
        member=label,
        decided_at=float(bound.time[decided_row(bound, formula, found.holds)]),
        scale=1.0 if scaled else _scale(predicate),
        grade=float(_smallest(margins, 1 + len(margins) // GRADED).mean()),
    )


def check(formula, text, signals):
    """Return the unit of each ``Predicate`` in ``formula``; ``FormulaError`` where ``signals`` do not fit.

    ``signals``: by name, with a ``unit`` and a ``domain``; values are not needed.
    """
    units = {each: _unit_of(each, text, signals) for each in predicates(formula)}
    _check_quantifiers(formula, text, signals, None)
    return units


def _check_quantifiers(formula, text, signals, outer):
    """Refuse `each` and `some` within ``outer``, one of them, and signals that its members do not have."""
    if isinstance(formula, Predicate):
        return _check_domain(formula, text, signals, outer)
    inner = outer
    if isinstance(formula, (Each, Some)):
        if outer is not None:
            message = (
                "`each` and `some` within `each {0}` or `some {0}`: wanted one of them".format(
                    outer.domain
                )
            )
            raise FormulaError(message, text, formula.position)
        inner = formula
    for child in children(formula):
        _check_quantifiers(child, text, signals, inner)


def _check_domain(predicate, text, signals, outer):
    for term in predicate.terms if outer is not None else ():
        domain = None if term.signal is None else signals[term.signal].domain
        if domain not in (None, outer.domain):
            within = "{} {}".format("each" if isinstance(outer, Each) else "some", outer.domain)
            message = (
                "`{}` is one of each {}, within `{}`: wanted a signal of each {}, or of the team"
            )
            message = message.format(term.signal, domain, within, outer.domain)
            raise FormulaError(message, text, term.position)


def _unit_of(predicate, text, signals):
    """Return the unit of the ``predicate``'s signals, which its constants have to fit."""
    unit, domain = None, None
    for term in predicate.terms:
        if term.signal is None:
            continue
        if term.signal not in signals:
            raise unknown_signal(text, term, signals)
        signal = signals[term.signal]
        if unit not in (None, signal.unit):
            message = "`{}` is in {}, the signal before it in {}"
            message = message.format(term.signal, signal.unit or "no unit", unit or "no unit")
            raise FormulaError(message, text, term.position)
        if signal.domain is not None and domain not in (None, signal.domain):
            message = "`{}` is one of each {}, the signal before it one of each {}"
            message = message.format(term.signal, signal.domain, domain)
            raise FormulaError(message, text, term.position)
        unit, domain = signal.unit, domain or signal.domain
    for term in predicate.terms:
        if term.unit is not None and UNITS[term.unit].dimension != unit:
            message = "{:g} {} beside a signal in {}".format(
                abs(term.factor), term.unit, unit or "no unit"
            )
            raise FormulaError(message, text, term.position)
    return unit


class _Evaluation:
    """Formulas over the samples at ``time`` (m,): of the team, or of some members of one domain."""

    def __init__(self, text, time, signals, scaled, domain=None, rows=None):
        """``scaled``: divide margins by constants.

        ``rows``: which members of the ``domain``, a slice; formulas then are (k, m), of one member (m,).
        """
        self.text, self.time, self.signals = text, time, signals
        self.scaled, self.domain, self.rows = scaled, domain, rows
        self._windows, self._kept = {}, {}

    def part(self, domain, rows):
        """Return the evaluation of the members ``rows`` of ``domain``: a slice, or one index."""
        result = _Evaluation(self.text, self.time, self.signals, self.scaled, domain, rows)
        result._windows = self._windows
        return result

    def of(self, formula):
        """Return the ``Bounds`` of ``formula``."""
        if isinstance(self.rows, slice):  # large, and needed once
            return self._of(formula)
        if id(formula) not in self._kept:
            self._kept[id(formula)] = formula, self._of(formula)
        return self._kept[id(formula)][1]

    def _of(self, formula):
        if isinstance(formula, Predicate):
            values = self._predicate(formula)
            return Bounds(values, values)
        if isinstance(formula, Not):
            return self.of(formula.operand).negated()
        if isinstance(formula, Or):
            return _largest([self.of(each) for each in formula.operands])
        if isinstance(formula, And):
            return _largest([self.of(each).negated() for each in formula.operands]).negated()
        if isinstance(formula, (Each, Some)):
            return self._quantified(formula)
        if isinstance(formula, Until):
            return self._until(formula)
        if isinstance(formula, Eventually):
            return self._eventually(self.of(formula.operand), formula)
        return self._eventually(self.of(formula.operand).negated(), formula).negated()

    def windows(self, formula):
        """Return the ``Windows`` of samples that the window [s] of ``formula`` means."""
        window = formula.window
        if window not in self._windows:
            try:
                self._windows[window] = Windows(self.time, window)
            except ValueError as error:
                raise FormulaError(str(error), self.text, formula.position) from None
        return self._windows[window]

    def _eventually(self, inner, formula):
        windows = self.windows(formula)
        cut = windows.cut
        low = windows.maximum(inner.low)
        if inner.is_known and not cut.any():
            return Bounds(low, low)
        high = low if inner.is_known else windows.maximum(inner.high)
        return Bounds(low, np.where(cut, np.inf, high))

    def _until(self, formula):
        left, right = self.of(formula.left), self.of(formula.right)
        windows = self.windows(formula)
        cut = windows.cut
        low = high = until_within(left.low, right.low, windows)
        if not (left.is_known and right.is_known):
            high = until_within(left.high, right.high, windows)
        elif not cut.any():
            return Bounds(low, low)
        beyond = np.maximum(high, least_from(np.broadcast_to(left.high, high.shape)))
        return Bounds(low, np.where(cut, beyond, high))

    def _quantified(self, formula):
        lows, highs, known = [], [], True
        for rows in self.chunks(formula.domain):
            bounds = self.part(formula.domain, rows).of(formula.operand)
            bounds = bounds if isinstance(formula, Some) else bounds.negated()
            known = known and bounds.is_known
            lows.append(np.max(np.atleast_2d(bounds.low), axis=0))
            highs.append(
                lows[-1] if bounds.is_known else np.max(np.atleast_2d(bounds.high), axis=0)
            )
        if not lows:  # of an empty domain: each holds, some does not
            lows = highs = [np.full(len(self.time), -np.inf)]
        low = np.max(lows, axis=0)
        bounds = Bounds(low, low if known else np.max(highs, axis=0))
        return bounds if isinstance(formula, Some) else bounds.negated()

    def chunks(self, domain):
        """Return slices that together are all members of ``domain``, few enough to be held at once."""
        count = self.members(domain)
        size = max(1, MOST_AT_ONCE // max(1, len(self.time)))
        return [slice(k, min(k + size, count)) for k in range(0, count, size)]

    def members(self, domain):
        """Return how many members ``domain`` has in the signals."""
        counts = [len(each.values) for each in self.signals.values() if each.domain == domain]
        return counts[0] if counts else 0

    def _predicate(self, predicate):
        """Return its margins: (m,), or (k, m) of members; of others' members the least, (m,)."""
        domain = self.domain_of(predicate)
        if domain in (None, self.domain):
            least = self._margins(predicate, self.rows if domain else None)
        else:
            parts = [self._margins(predicate, rows).min(axis=0) for rows in self.chunks(domain)]
            least = np.min(parts, axis=0) if parts else np.full(len(self.time), np.inf)
        return least / _scale(predicate) if self.scaled else least

    def domain_of(self, predicate):
        """Return the domain of whose members the ``predicate``'s signals are, None for the team's."""
        domains = {self.signals[name].domain for name in predicate.signals} - {None}
        return domains.pop() if domains else None

    def _margins(self, predicate, rows):
        """Return what the ``predicate`` has to spare [its unit], of the members ``rows`` of its domain."""
        total = 0.0
        for term in predicate.terms:
            if term.signal is None:
                total = total + _constant(term)
                continue
            signal = self.signals[term.signal]
            values = np.asarray(signal.values, dtype=float)
            values = values if signal.domain is None or rows is None else values[rows]
            total = total + term.factor * (np.abs(values) if term.absolute else values)
        return total

    # What decides it ----------------------------------------------------------------------------

    def reason(self, formula, row, side):
        """Return the predicate, sample and member of its domain on which the ``side`` of the bounds hangs,
        and the side of the predicate's own: the other one where the formula wants its negation.

        ``side``: "low" or "high".
        """
        if isinstance(formula, Predicate):
            return (*self._worst_member(formula, row), side)
        if isinstance(formula, Not):
            return self.reason(formula.operand, row, "high" if side == "low" else "low")
        if isinstance(formula, (And, Or)):
            values = [float(getattr(self.of(each), side)[row]) for each in formula.operands]
            best = np.argmax if isinstance(formula, Or) else np.argmin
            return self.reason(formula.operands[int(best(values))], row, side)
        if isinstance(formula, (Each, Some)):
            return self._deciding_member(formula, row, side)
        if isinstance(formula, Until):
            return self._until_reason(formula, row, side)
        windows = self.windows(formula)
        values = getattr(self.of(formula.operand), side)[windows.begin[row] : windows.end[row]]
        best = np.argmax if isinstance(formula, Eventually) else np.argmin
        return self.reason(formula.operand, int(windows.begin[row]) + int(best(values)), side)

    def _worst_member(self, predicate, row):
        domain = self.domain_of(predicate)
        if domain is None:
            return predicate, row, None
        if domain == self.domain:
            return predicate, row, self.rows
        values = [self._margins(predicate, rows)[:, row] for rows in self.chunks(domain)]
        return predicate, row, int(np.argmin(np.concatenate(values)))

    def _deciding_member(self, formula, row, side):
        values = []
        for rows in self.chunks(formula.domain):
            found = getattr(self.part(formula.domain, rows).of(formula.operand), side)
            values.append(np.broadcast_to(found, (rows.stop - rows.start, len(self.time)))[:, row])
        best = np.argmax if isinstance(formula, Some) else np.argmin
        member = int(best(np.concatenate(values)))
        return self.part(formula.domain, member).reason(formula.operand, row, side)

    def _until_reason(self, formula, row, side):
        windows = self.windows(formula)
        left, right = (getattr(self.of(each), side) for each in (formula.left, formula.right))
        first, end = int(windows.begin[row]), int(windows.end[row])
        held = np.minimum.accumulate(np.concatenate([[np.inf], left[row : end - 1]]))[first - row :]
        reached = np.minimum(right[first:end], held)
        best = reached.max(initial=-np.inf)
        if windows.cut[row] and left[row:].min() > best:  # what comes later may do
            return self.reason(formula.left, row + int(np.argmin(left[row:])), side)
        at = int(np.argmax(reached))
        if right[first + at] <= held[at]:
            return self.reason(formula.right, first + at, side)
        return self.reason(formula.left, row + int(np.argmin(left[row : first + at])), side)

    def margins(self, predicate, member):
        """Return what the ``predicate`` has to spare [its unit] at each sample, and whose it is."""
        values = self._margins(predicate, member)
        return values, "" if member is None else self.label(predicate, member)

    def label(self, predicate, member):
        """Return the name of the ``member`` of the domain of ``predicate``."""
        domain = self.domain_of(predicate)
        signal = next(
            self.signals[name] for name in predicate.signals if self.signals[name].domain == domain
        )
        labels = signal.labels
        return labels(member) if callable(labels) else labels[member]


def _largest(parts):
    """Return the ``Bounds`` of the largest of ``parts``."""
    low = parts[0].low
    for each in parts[1:]:
        low = np.maximum(low, each.low)
    if all(each.is_known for each in parts):
        return Bounds(low, low)
    high = parts[0].high
    for each in parts[1:]:
        high = np.maximum(high, each.high)
    return Bounds(low, high)


def _constant(term):
    """Return the number that a ``term`` without a signal adds, in the unit of the signals beside it."""
    return term.factor * (UNITS[term.unit].factor if term.unit else 1.0)


def _smallest(values, count):
    """Return the ``count`` smallest of ``values`` (m,), in their order."""
    return np.sort(np.partition(values, count - 1)[:count])


def _scale(predicate):
    """Return by what margins are divided beside those of other units: the constant, 1 where that is 0."""
    return abs(math.fsum(_constant(term) for term in predicate.terms if term.signal is None)) or 1.0
