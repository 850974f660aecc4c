"""Fields: values that users give, declared once for scenarios, ROS, the GUI's forms and the pages."""

import difflib
import itertools
import math
from typing import Any, Callable, NamedTuple, Optional, Tuple

LONGEST_SHOWN = 60  # [characters] of a value in an error message
MOST_BITS = 10000  # [-] of a whole number that is written out; Python refuses far longer ones


# Kinds of values.  A pattern has one {} for the robot's number; EACH: one for all robots, or for each.
NUMBER, WHOLE, FLAG, TEXT = "a number", "a whole number", "true or false", "a text"
PATTERN, NUMBERS, EACH, NAMES = "a pattern", "numbers", "a number for each robot", "names"
KINDS = {float: NUMBER, int: WHOLE, bool: FLAG, str: TEXT}
NO_KIND = "a default that is a number, true, false or a text"
REQUIRED = "required"  # the rule of a field that must be given
POSITIVE = {"low": 0.0, "open_low": True}  # bounds of a ``Field``


class Field(NamedTuple):
    """A value that users give: name, kind, unit, allowed range, default and meaning, declared once.

    A scenario's keys, a node's and a protocol's parameters are read and checked by it, the GUI's forms and
    the tables of the documentation made of it.  ``kind`` is by default that of the ``default`` (float, int,
    bool or str).  ``low`` and ``high`` are allowed values unless ``open_low`` or ``open_high``; ``why``
    gives the reason for the range; ``rule``: where no number is the default, what is, in words.  With a
    kind other than a text ``choices`` are allowed besides.
    """

    name: str
    default: Any = None
    unit: str = ""
    low: Optional[float] = None
    high: Optional[float] = None
    open_low: bool = False
    open_high: bool = False
    choices: Tuple[str, ...] = ()
    meaning: str = ""  # in Markdown
    why: str = ""
    rule: str = ""
    type: str = ""  # one of the kinds, where the default does not say which
    sizes: Tuple[int, ...] = ()  # of NUMBERS: how many there may be
    # Of what is no such kind: read(section, others) makes it of a scenario's ``Section`` and of what was
    # read before, by name; plain(value, n) is what a file holds of it, with n robots.
    read: Optional[Callable] = None
    plain: Optional[Callable] = None

    @property
    def kind(self):
        """Return the kind of its values."""
        return self.type or KINDS.get(type(self.default), NO_KIND)

    def wanted(self, n=None):
        """Return a text with the allowed values, of n robots."""
        return self._allowed(n) + (": " + self.why if self.why else "")

    def _allowed(self, n):
        if self.kind == TEXT and self.choices:
            return "one of " + ", ".join(self.choices)
        if self.kind == PATTERN:
            return "one {} for the robot's number"
        if self.kind == NAMES:
            return "a list of different names"
        name = {
            EACH: NUMBER,
            NUMBERS: "a list of {} numbers".format(" or ".join(map(str, self.sizes))),
        }
        unit = self.unit and "[{}]".format(self.unit)
        text = " ".join(filter(None, [name.get(self.kind, self.kind), self._bounds(), unit]))
        more = ("{} such numbers".format(n),) if self.kind == EACH and n else ()
        return text + "".join(", or " + choice for choice in self.choices + more)

    def _bounds(self):
        low, high = ("" if bound is None else "{:g}".format(bound) for bound in self[3:5])
        if low and high and not (self.open_low or self.open_high):
            return "from {} to {}".format(low, high)
        above = low and ("above " if self.open_low else "of at least ") + low
        below = high and ("below " if self.open_high else "at most ") + high
        return " and ".join(filter(None, [above, below])) if above else "of " * bool(below) + below

    def default_text(self):
        """Return the default in words, with its unit, in Markdown."""
        if self.rule == REQUIRED and self.unit:
            return "{}, in {}".format(self.rule, self.unit)
        if self.rule or self.default in (None, "", (), {}):
            return self.rule or "none"
        value = "{:g}".format(self.default) if self.kind == NUMBER else str(self.default)
        value = value.lower() if self.kind == FLAG else value
        value = "`{}`".format(value) if self.kind in (TEXT, PATTERN) else value
        return "{} {}".format(value, self.unit).strip()

    def row(self, before=""):
        """Return its row of a table in Markdown: name, ``before`` it what it is under, default, meaning."""
        return "| `{}{}` | {} | {} |".format(before, self.name, self.default_text(), self.meaning)

    def checked(self, value, n=None):
        """Return ``value`` as the field's kind; ``ValueError`` if it is not allowed."""
        result = self.typed(value, n)
        if result is None:
            raise ValueError("{} = {}: wanted {}".format(self.name, shown(value), self.wanted(n)))
        return result

    def typed(self, value, n=None):
        """Return ``value`` as the field's kind, of numbers a tuple; None if it is not allowed."""
        if isinstance(value, str) and value in self.choices:
            return value
        kind = self.kind
        if kind in (NUMBERS, EACH) and isinstance(value, (list, tuple)):
            numbers = tuple(map(self._number, value))
            fits = len(numbers) in (self.sizes if kind == NUMBERS else (n,))
            return numbers if fits and None not in numbers else None
        if kind in (NUMBER, EACH):
            return self._number(value)
        if kind == NAMES and isinstance(value, (list, tuple)):
            fits = all(isinstance(name, str) for name in value) and len(set(value)) == len(value)
            return tuple(value) if fits else None
        wanted = {WHOLE: int, FLAG: bool, TEXT: str, PATTERN: str}.get(kind)
        fits = type(value) is wanted and (kind != WHOLE or self._in_range(value))
        fits = fits and not (kind == TEXT and self.choices)
        return value if fits and (kind != PATTERN or value.count("{}") == 1) else None

    def _number(self, value):
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            return None
        try:
            number = float(value)
        except OverflowError:
            return None
        return number if math.isfinite(number) and self._in_range(value) else None

    def _in_range(self, value):
        low, high = self.low, self.high
        if low is not None and (value < low or (self.open_low and value == low)):
            return False
        return high is None or not (value > high or (self.open_high and value == high))


Parameter = Field  # as protocols declare theirs


def checked_values(parameters, given, owner="parameters"):
    """Return a dict with every parameter's value: ``given`` where it is, else the default.

    Raises ``ValueError`` for an unknown name (with the nearest known one) or a bad value.
    """
    known = {parameter.name: parameter for parameter in parameters}
    for name in given:
        if name not in known:
            raise ValueError(unknown_name(owner, name, known))
    return {
        name: parameter.checked(given.get(name, parameter.default))
        for name, parameter in known.items()
    }


def unknown_name(owner, name, known):
    """Return the message for a name that is not ``known``, with the nearest one that is."""
    text = str(name) if isinstance(name, (str, bool, float)) else shown(name)
    near = difflib.get_close_matches(text[:LONGEST_SHOWN], [str(k) for k in known], n=1)
    hint = "; did you mean {!r}?".format(near[0]) if near else ""
    listing = ", ".join(sorted({str(k) for k in known})) or "none"
    return "{}: unknown {}{} (known: {})".format(owner, shown(name), hint, listing)


def counted(count, noun):
    """Return ``count`` and the ``noun``, in the plural unless there is one."""
    return "{} {}{}".format(count, noun, "" if count == 1 else "s")


def shown(value):
    """Return ``value`` as it should appear in an error message, never longer than a line.

    No more of its representation is made than is shown, whatever ``value`` holds.
    """
    if value is None:
        return "nothing given"
    text, pieces = "", _pieces(value)
    while len(text) <= LONGEST_SHOWN:
        more = "".join(itertools.islice(pieces, LONGEST_SHOWN))
        if not more:
            return text
        text += more
    return text[: LONGEST_SHOWN - 3] + "..."


def _pieces(value):
    """Yield the representation of ``value`` piece by piece, as ``repr`` has it."""
    if type(value) in (list, tuple):
        yield "[" if type(value) is list else "("
        for index, item in enumerate(value):
            yield ", " if index else ""
            yield from _pieces(item)
        yield "]" if type(value) is list else ",)" if len(value) == 1 else ")"
    elif type(value) is dict:
        yield "{"
        for index, (key, item) in enumerate(value.items()):
            yield ", " if index else ""
            yield from _pieces(key)
            yield ": "
            yield from _pieces(item)
        yield "}"
    elif isinstance(value, (str, bytes)):
        yield repr(value[: LONGEST_SHOWN + 1])
    elif isinstance(value, int) and value.bit_length() > MOST_BITS:
        yield "a whole number of {} bits".format(value.bit_length())
    else:
        yield repr(value)
