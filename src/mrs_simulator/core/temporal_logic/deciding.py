"""From which sample on the truth of a formula is certain, whatever comes after it.

The earliest such sample obeys the formula's own semantics: a conjunction is certain with the last of its
parts, a disjunction with the first, and a window at the earliest where all of it has been seen.  So the
numbers of samples take the place of margins, and each formula is gone through once.
"""

import numpy as np

from mrs_simulator.core.temporal_logic.formula import (
    Always,
    And,
    Each,
    Not,
    Or,
    Predicate,
    Some,
    Until,
)
from mrs_simulator.core.temporal_logic.windows import least_from, until_within


def decided_row(evaluation, formula, holds):
    """Return the row of the first sample after which nothing changes that ``formula`` ``holds``, or not.

    ``evaluation``: that of the run in ``robustness``.  The last one where only the run's end decides.
    """
    row = _certain(evaluation, formula, holds, not holds)[0]
    return int(row) if 0.0 <= row < np.inf else len(evaluation.time) - 1 if row > 0.0 else 0


def _certain(evaluation, formula, true, strictly):
    """Return from which sample on each one, (m,) or (k, m), is sure to be above 0, inf where it is not.

    Below 0 if not ``true``; ``strictly``: 0 itself is neither.
    """

    def of(each):
        return _certain(evaluation, each, true, strictly)

    if isinstance(formula, Predicate):
        values = evaluation.of(formula).low
        compare = {(True, False): np.greater_equal, (True, True): np.greater}
        compare.update({(False, False): np.less_equal, (False, True): np.less})
        return np.where(compare[true, strictly](values, 0.0), np.arange(values.shape[-1]), np.inf)
    if isinstance(formula, Not):
        return _certain(evaluation, formula.operand, not true, strictly)
    if isinstance(formula, (And, Or)):
        join = np.maximum if isinstance(formula, And) is true else np.minimum
        parts = [of(each) for each in formula.operands]
        found = parts[0]
        for part in parts[1:]:
            found = join(found, part)
        return found
    if isinstance(formula, (Each, Some)):
        return _of_members(evaluation, formula, true, strictly)
    windows = evaluation.windows(formula)
    # of windows that are seen to their end
    known = np.inf if windows.unbounded else np.where(windows.cut, np.inf, windows.known)
    if isinstance(formula, Until):
        left, right = of(formula.left), of(formula.right)
        if true:
            return -until_within(-left, -right, windows)
        return np.maximum(until_within(left, right, windows), np.minimum(known, least_from(left)))
    if isinstance(formula, Always) is true:
        return np.maximum(windows.maximum(of(formula.operand)), known)
    return -windows.maximum(-of(formula.operand))


def _of_members(evaluation, formula, true, strictly):
    """Return the same of each or some member of a domain, (m,)."""
    all_of_them = isinstance(formula, Each) is true
    found = np.full(len(evaluation.time), -np.inf if all_of_them else np.inf)
    for rows in evaluation.chunks(formula.domain):
        part = evaluation.part(formula.domain, rows)
        members = np.atleast_2d(_certain(part, formula.operand, true, strictly))
        best = members.max(axis=0) if all_of_them else members.min(axis=0)
        found = np.maximum(found, best) if all_of_them else np.minimum(found, best)
    return found
