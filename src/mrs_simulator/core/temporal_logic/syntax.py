"""The text of a formula: ``eventually[0, 60] always(error < 0.05 m)``.

In the order in which they bind, loosest first::

    formula    = either ["implies" formula]
    either     = both {"or" both}
    both       = until {"and" until}
    until      = unary ["until" [window] unary]
    unary      = ("not" | ("always" | "eventually") [window] | ("each" | "some") domain) unary
               | "(" formula ")" | comparison
    window     = "[" number "," number "]"                                 # in seconds
    domain     = "robot" | "pair" | "edge"
    comparison = sum ("<" | "<=" | ">" | ">=") sum [("<" ...) sum]
    sum        = ["-"] term {("+" | "-") term}
    term       = number [unit] | [number "*"] (signal | "abs" "(" signal ")")

``<`` and ``<=`` mean the same: a signal of measured numbers never distinguishes them.
"""

import difflib
import math
import re

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.core.temporal_logic.formula import (
    DOMAINS,
    UNBOUNDED,
    Always,
    And,
    Each,
    Eventually,
    Not,
    Or,
    Predicate,
    Some,
    Term,
    Until,
)
from mrs_simulator.core.temporal_logic.units import UNITS

LONGEST = 2000  # [characters] of a formula
DEEPEST = 50  # [-] parts of a formula within one another
OPERATORS = ("not", "always", "eventually", "each", "some", "abs")
JOINING = ("and", "or", "implies", "until")
KEYWORDS = (*OPERATORS, *JOINING)
ELSEWHERE = {"=": "`<=` or `>=`", "&": "`and`", "|": "`or`", "!": "`not`"}  # and what formulas have
NO_UNIT = re.compile(r"([A-Za-z][\w/^]*)\s*(?:$|[\]),]|(?:and|or|implies|until)\b)")
TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_][A-Za-z0-9_.]*)"
    r"|(?P<sign><=|>=|<|>|[()\[\],*+/^%-]))"
)
UNIT = re.compile(
    r"\s*(" + "|".join(sorted(map(re.escape, UNITS), key=len, reverse=True)) + r")(?![\w/^])"
)


class FormulaError(ValueError):
    """A formula that cannot be read: says what came, what was wanted, and points at the character."""

    page = "docs/requirements.md"

    def __init__(self, message, text, position):
        """``position``: of the character in ``text``."""
        line = text.replace("\n", " ").replace("\t", " ")
        pointer = "\n  {}\n  {}^".format(line, " " * position) if line.strip() else ""
        super().__init__(message + pointer)
        self.position = position


def parse(text):
    """Return the formula that ``text`` states; ``FormulaError`` where it states none."""
    if not isinstance(text, str):
        raise FormulaError("wanted the text of a formula, got {!r}".format(text)[:200], "", 0)
    if len(text) > LONGEST:
        message = "a formula of {} characters; wanted {} at most".format(len(text), LONGEST)
        raise FormulaError(message, text[:60] + " ...", 0)
    reader = _Reader(text)
    formula = reader.formula()
    if reader.kind is not None:
        reader.refuse_word(JOINING)
        reader.refuse("wanted `and`, `or`, `implies`, `until` or the end")
    return formula


class _Reader:
    """A recursive descent over the tokens of ``text``, one ahead."""

    def __init__(self, text):
        self.text, self.end, self._depth = text, 0, 0
        self.advance()

    def advance(self):
        """Go to the next token: its ``kind`` (None at the end), ``value`` and ``position``."""
        rest = self.text[self.end :]
        self.position = self.end + len(rest) - len(rest.lstrip())
        if not rest.strip():
            self.kind, self.value = None, "the end"
            return
        match = TOKEN.match(self.text, self.end)
        if match is None:
            self.kind, self.value = "sign", self.text[self.position]
            instead = ELSEWHERE.get(self.value)
            hint = ", wanted {}".format(instead) if instead else ""
            self.refuse("a character that no formula has{}".format(hint))
        self.kind, self.value, self.end = match.lastgroup, match.group(match.lastgroup), match.end()

    def refuse(self, wanted):
        """Raise the ``FormulaError`` that points at this token."""
        came = self.value if self.kind is None else "`{}`".format(self.value)
        raise FormulaError("{}, got {}".format(wanted, came), self.text, self.position)

    def refuse_word(self, words, word=None, position=None, always=False):
        """Raise the ``FormulaError`` on a ``word``, by default this token, that is nearly one of ``words``.

        ``position``: of its character; ``always``: also if it is like none of them.
        """
        word = word or (self.value if self.kind == "name" else "")
        if always or difflib.get_close_matches(word, words, n=1):
            position = self.position if position is None else position
            raise FormulaError(unknown_name("operator", word, words), self.text, position)

    def take(self, *values):
        """Return this token's value and go on, if it is one of ``values``, else None."""
        if self.kind in (None, "number") or self.value not in values:
            return None
        value = self.value
        self.advance()
        return value

    def expect(self, value):
        """Go on past ``value``, which has to stand here."""
        if not self.take(value):
            self.refuse("wanted `{}`".format(value))

    def formula(self):
        """Return an implication."""
        left = self.joined("or", Or, lambda: self.joined("and", And, self.until))
        if self.take("implies"):
            return Or((Not(left), self.deeper(self.formula)))
        return left

    def deeper(self, read):
        """Return what ``read`` returns, one level down."""
        self._depth += 1
        if self._depth > DEEPEST:
            self.refuse("a formula more than {} levels deep".format(DEEPEST))
        result = read()
        self._depth -= 1
        return result

    def joined(self, word, kind, read):
        """Return what ``read`` returns, or the ``kind`` of several of them that ``word`` joins."""
        parts = [read()]
        while self.take(word):
            parts.append(read())
        return parts[0] if len(parts) == 1 else kind(tuple(parts))

    def until(self):
        """Return ``a until b``, or a unary formula."""
        left = self.unary()
        if not self.take("until"):
            return left
        position, window = self.position, self.window()
        return Until(left, self.unary(), window, position)

    def unary(self):
        """Return what one operator makes of the formula behind it, or an atom."""
        return self.deeper(self._unary)

    def _unary(self):
        if self.take("not"):
            return Not(self.unary())
        word = self.take("always", "eventually")
        if word:
            position, window = self.position, self.window()
            return (Always if word == "always" else Eventually)(self.unary(), window, position)
        word = self.take("each", "some")
        if word:
            position, domain = self.position, self.take(*DOMAINS)
            if not domain:
                self.refuse("wanted one of {} behind `{}`".format(", ".join(DOMAINS), word))
            return (Each if word == "each" else Some)(domain, self.unary(), position)
        if self.take("("):
            inner = self.formula()
            self.expect(")")
            return inner
        return self.comparison()

    def window(self):
        """Return the window [s] that stands here, by default to the end of the run."""
        position = self.position
        if not self.take("["):
            return UNBOUNDED
        first = self.seconds()
        self.expect(",")
        last = self.seconds()
        self.expect("]")
        if first > last:
            text = "a window from {:g} s to {:g} s; wanted one that ends no earlier than it begins"
            raise FormulaError(text.format(first, last), self.text, position)
        return first, last

    def seconds(self):
        """Return the time [s] that stands here."""
        number = self.number("wanted a time in seconds")
        unit = self.unit()
        if unit is not None and UNITS[unit].dimension != "s":
            self.refuse("wanted a time in seconds behind {:g} {}".format(number, unit))
        return number * UNITS[unit or "s"].factor

    def number(self, wanted):
        """Return the number that stands here."""
        if self.kind != "number":
            self.refuse(wanted)
        value = float(self.value)
        if not math.isfinite(value):
            self.refuse("a number that is not finite")
        self._unit = UNIT.match(self.text, self.end)
        self.advance()
        return value

    def unit(self):
        """Return the unit behind the number that was just read, None if there is none."""
        match, self._unit = self._unit, None
        if match is None:
            match = NO_UNIT.match(self.text, self.position)
            if match and match.group(1) not in KEYWORDS:
                message = unknown_name("unit", match.group(1), UNITS)
                raise FormulaError(message, self.text, self.position)
            return None
        self.end = match.end()
        self.advance()
        return match.group(1)

    def comparison(self):
        """Return the ``Predicate`` that stands here, or the ``And`` of two, as of ``1 < x < 2``."""
        begin, sides, signs = self.position, [self.sum()], []
        while len(sides) < 3:
            sign = self.take("<", "<=", ">", ">=")
            if not sign:
                break
            signs.append(sign)
            sides.append(self.sum())
        if not signs:
            word = self.text[begin : self.position].strip()
            if word.isidentifier() and word not in KEYWORDS and self.kind is not None:
                self.refuse_word(OPERATORS, word, begin, always=self.value in ("(", "["))
            self.refuse("wanted `<` or `>` behind `{}`".format(word))
        text = self.text[begin : self.position].strip()
        found = [self._at_least(*pair, text) for pair in zip(sides, signs, sides[1:])]
        for each in found:
            if not each.signals:
                raise FormulaError("no signal is compared here", self.text, begin)
        return found[0] if len(found) == 1 else And(tuple(found))

    @staticmethod
    def _at_least(left, sign, right, text):
        larger, smaller = (left, right) if sign.startswith(">") else (right, left)
        return Predicate((*larger, *(each._replace(factor=-each.factor) for each in smaller)), text)

    def sum(self):
        """Return the terms that stand here."""
        terms, sign = [], -1.0 if self.take("-") else 1.0
        while True:
            term = self.term()
            terms.append(term._replace(factor=sign * term.factor))
            taken = self.take("+", "-")
            if not taken:
                return terms
            sign = -1.0 if taken == "-" else 1.0

    def term(self):
        """Return a number with its unit, or a signal with its factor."""
        position, factor = self.position, 1.0
        if self.kind == "number":
            factor = self.number("")
            unit = self.unit()
            if unit is not None or not self.take("*"):
                return Term(factor, unit=unit, position=position)
        if self.take("abs"):
            self.expect("(")
            term = Term(factor, self.name(), True, position=position)
            self.expect(")")
            return term
        position = self.position
        return Term(factor, self.name(), position=position)

    def name(self):
        """Return the name of a signal."""
        if self.kind != "name" or self.value in KEYWORDS:
            self.refuse("wanted the name of a signal, a number, or a formula")
        return self.take(self.value)


def unknown_signal(text, term, known):
    """Return the ``FormulaError`` on the signal of ``term``, which is none of ``known``."""
    return FormulaError(unknown_name("signal", term.signal, known), text, term.position)
