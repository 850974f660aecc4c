"""Parameters of a protocol, declared once for scenarios, launch files, ROS and the GUI's forms."""

import difflib
import itertools
import math
from typing import Any, NamedTuple, Optional, Tuple

LONGEST_SHOWN = 60  # [characters] of a value in an error message
MOST_BITS = 10000  # [-] of a whole number that is written out; Python refuses far longer ones


class Parameter(NamedTuple):
    """A parameter's name, default value, unit, allowed range and meaning.

    The default's type (float, int, bool or str) is the parameter's type.  ``low`` and ``high`` are
    allowed values unless ``open_low`` or ``open_high``; ``why`` gives the reason for the range.
    """

    name: str
    default: Any
    unit: str = ""
    low: Optional[float] = None
    high: Optional[float] = None
    open_low: bool = False
    open_high: bool = False
    choices: Tuple[str, ...] = ()
    meaning: str = ""
    why: str = ""

    def wanted(self):
        """Return a text with the allowed values."""
        if self.choices:
            return "one of " + ", ".join(self.choices)
        bounds = []
        if self.low is not None:
            bounds.append("{} {:g}".format("above" if self.open_low else "at least", self.low))
        if self.high is not None:
            bounds.append("{} {:g}".format("below" if self.open_high else "at most", self.high))
        kind = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}
        # Another kind of default is refused with the class that has it.
        name = kind.get(type(self.default), "a default that is a number, true, false or a text")
        text = " ".join([name, " and ".join(bounds)]).strip()
        unit = " [{}]".format(self.unit) if self.unit else ""
        return text + unit + (": " + self.why if self.why else "")

    def checked(self, value):
        """Return ``value`` as the parameter's type; ``ValueError`` if it is not allowed."""
        result = self._typed(value)
        if result is None or not self._in_range(result):
            raise ValueError("{} = {}: wanted {}".format(self.name, shown(value), self.wanted()))
        return result

    def _typed(self, value):
        wanted = type(self.default)
        if wanted is float and isinstance(value, (int, float)) and not isinstance(value, bool):
            try:
                return float(value) if math.isfinite(value) else None
            except OverflowError:
                return None
        return value if type(value) is wanted and wanted in (int, bool, str) else None

    def _in_range(self, value):
        if self.choices:
            return value in self.choices
        if self.low is not None and (value < self.low or (self.open_low and value == self.low)):
            return False
        return self.high is None or not (
            value > self.high or (self.open_high and value == self.high)
        )


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
