"""Formulas of Signal Temporal Logic as trees, over signals of a team.

A *signal* is a number at each sample of a run.  Signals of the ``DOMAINS`` have one for each robot, pair
of robots or edge of the graph.
"""

import math
from typing import Any, NamedTuple, Optional, Tuple

ROBOT, PAIR, EDGE = "robot", "pair", "edge"
DOMAINS = (ROBOT, PAIR, EDGE)
UNBOUNDED = (0.0, math.inf)  # [s]: to the end of the run


class Term(NamedTuple):
    """``factor`` times a signal, or its absolute value; with no ``signal`` a constant."""

    factor: float
    signal: Optional[str] = None
    absolute: bool = False
    unit: Optional[str] = None  # of a constant; None: that of the signals
    position: int = 0  # in the formula's text


class Predicate(NamedTuple):
    """The sum of ``terms`` is at least 0; ``threshold``: the size of its constant [unit of the signals]."""

    terms: Tuple[Term, ...]
    text: str

    @property
    def signals(self):
        """Return the names of its signals."""
        return tuple(term.signal for term in self.terms if term.signal is not None)


class Not(NamedTuple):
    """``operand`` does not hold."""

    operand: Any


class And(NamedTuple):
    """All ``operands`` hold."""

    operands: Tuple[Any, ...]


class Or(NamedTuple):
    """At least one of ``operands`` holds."""

    operands: Tuple[Any, ...]


class Always(NamedTuple):
    """``operand`` holds at all times in ``window`` [s] from now on."""

    operand: Any
    window: Tuple[float, float] = UNBOUNDED
    position: int = 0  # of the window, in the formula's text


class Eventually(NamedTuple):
    """``operand`` holds at some time in ``window`` [s] from now on."""

    operand: Any
    window: Tuple[float, float] = UNBOUNDED
    position: int = 0  # of the window, in the formula's text


class Until(NamedTuple):
    """``right`` holds at some time in ``window`` [s] from now on, and ``left`` at all times before it."""

    left: Any
    right: Any
    window: Tuple[float, float] = UNBOUNDED
    position: int = 0  # of the window, in the formula's text


class Each(NamedTuple):
    """``operand`` holds for each one of the ``domain``."""

    domain: str
    operand: Any
    position: int = 0  # of the domain, in the formula's text


class Some(NamedTuple):
    """``operand`` holds for at least one of the ``domain``."""

    domain: str
    operand: Any
    position: int = 0  # of the domain, in the formula's text


def children(formula):
    """Return the formulas of which ``formula`` is made."""
    if isinstance(formula, Predicate):
        return ()
    if isinstance(formula, (And, Or)):
        return formula.operands
    if isinstance(formula, Until):
        return formula.left, formula.right
    return (formula.operand,)


def predicates(formula):
    """Return all ``Predicate``s in ``formula``, from left to right."""
    if isinstance(formula, Predicate):
        return [formula]
    return [each for child in children(formula) for each in predicates(child)]


def ending(formula, duration):
    """Return ``formula`` as it is of a run that goes on to ``duration`` [s].

    There windows that reach to the end are bounded, and leave open what is not known yet.
    """
    if isinstance(formula, Predicate):
        return formula
    if isinstance(formula, (And, Or)):
        return type(formula)(tuple(ending(each, duration) for each in formula.operands))
    names = ("left", "right") if isinstance(formula, Until) else ("operand",)
    changed = {name: ending(getattr(formula, name), duration) for name in names}
    begin, end = getattr(formula, "window", (0.0, 0.0))
    if math.isinf(end):
        changed["window"] = begin, max(begin, duration)
    return formula._replace(**changed)
