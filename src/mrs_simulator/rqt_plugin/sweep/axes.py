"""What a sweep map can vary, over which ranges, and what is wrong with a range; without Qt."""

import re
from typing import Any, NamedTuple, Optional

from mrs_simulator.core.fields import EACH, NUMBER, WHOLE, Field
from mrs_simulator.rqt_plugin.widgets.commas import comma_remark
from mrs_simulator.scenario.control import CONTROL, HAND_LENGTH
from mrs_simulator.scenario.keys import KEYS
from mrs_simulator.scenario.team.mismatch import MISMATCH
from mrs_simulator.study.run.sweep import read_axis, value_under

PARAMETERS = "control.parameters."
FEWEST, MOST, USUAL = 2, 50, 6  # cells along an axis
LINKS = Field("delay", 0.0, "s", low=0.0), Field("loss", 0.0, low=0.0, high=1.0)
# Numbers of a scenario that may vary beside the protocol's parameters, by what they are under.
OFFERED = (
    ("control.", CONTROL, ("rate",)),
    ("mismatch.", MISMATCH, ("delay", "speed", "track")),
    ("links.", LINKS, ("delay", "loss")),
    ("", KEYS, ("seed", "duration")),
)
NUMBERS = NUMBER, WHOLE, EACH
PATH = re.compile(r"[A-Za-z_]\w*(\[\d+\])?(\.\w+(\[\d+\])?)*")
SPREAD = 2.0  # [-] by which a suggested range goes below and above the scenario's value


class SweptKey(NamedTuple):
    """The path of a number in a scenario, what it may be, and its value there (None: not known)."""

    path: str
    field: Optional[Field] = None
    value: Any = None

    @property
    def name(self):
        """Return how it is offered: parameters of the protocol by their names alone."""
        return self.path[len(PARAMETERS) :] if self.path.startswith(PARAMETERS) else self.path

    @property
    def is_whole(self):
        """Return whether its values are whole numbers."""
        return self.field is not None and self.field.kind == WHOLE

    def suggested(self):
        """Return a range ``(low, high)`` about the scenario's value, of values that are allowed."""
        value = self.value if isinstance(self.value, (int, float)) else 0
        if self.is_whole:
            return value, value + USUAL - 1
        low, high = sorted((value / SPREAD, SPREAD * value))
        if low == high:
            high = low + 1.0
        bounds = (None, None) if self.field is None else (self.field.low, self.field.high)
        low = low if bounds[0] is None else max(low, bounds[0])
        high = high if bounds[1] is None else min(high, bounds[1])
        return tuple(float("{:.3g}".format(each)) for each in (low, high))


def swept_keys(scenario, parameters, values):
    """Return the ``SweptKey``s of a scenario: first the protocol's ``parameters`` with ``values``.

    The hand length, which few studies vary, is the last.
    """
    known = [
        SweptKey(PARAMETERS + each.name, each, values.get(each.name, each.default))
        for each in parameters
        if each.kind in NUMBERS and not each.choices
    ]
    content = scenario.to_dict()
    for above, fields, names in OFFERED:
        for field in (each for each in fields if each.name in names):
            missing = field.default[0] if isinstance(field.default, tuple) else field.default
            value = value_under(content, above + field.name, missing)
            known.append(SweptKey(above + field.name, field, value))
    return sorted(known, key=lambda key: key.name == HAND_LENGTH.name)


class AxisTexts(NamedTuple):
    """One axis as it is typed; ``name``: of a ``SweptKey``, or any path."""

    name: str
    low: str
    high: str
    count: int


def key_of(name, keys):
    """Return that of the ``SweptKey``s which is called ``name``, or has it as its path, else a new one."""
    return next((each for each in keys if name in (each.name, each.path)), SweptKey(name))


def read_texts(texts, keys):
    """Return ``(word, values, errors)`` of ``AxisTexts``: ``word`` as the command ``sweep`` takes it.

    ``keys``: the ``SweptKey``s that are known; ``errors``: texts by the name of the field, {} if all is
    well, else ``word`` and ``values`` are None.
    """
    errors, ends, name = {}, [], texts.name.strip()
    if not PATH.fullmatch(name):
        errors["name"] = "{!r}: wanted a key's path, as control.rate".format(name)
    key = key_of(name, keys)
    for end in ("low", "high"):
        try:
            ends.append(_number(getattr(texts, end).strip(), key))
        except ValueError as error:
            errors[end] = str(error)
    if not errors and not ends[0] < ends[1]:
        errors["high"] = "{:g}: wanted more than {:g}".format(ends[1], ends[0])
    if not FEWEST <= texts.count <= MOST:
        errors["count"] = "{}: wanted from {} to {} cells".format(texts.count, FEWEST, MOST)
    if errors:
        return None, None, errors
    word = "{}={!r}..{!r}/{}".format(key.path, *map(float, ends), texts.count)
    if key.is_whole:
        step = max(1, -(-(ends[1] - ends[0] + 1) // texts.count))
        word = "{}={}".format(key.path, ",".join(map(str, range(ends[0], ends[1] + 1, step))))
    return word, read_axis(word)[1], {}


def _number(text, key):
    """Return the number in ``text`` as the ``SweptKey`` allows it; ``ValueError`` says what is wrong."""
    try:
        value = int(text) if key.is_whole else float(text)
    except ValueError:
        kind = WHOLE if key.is_whole else NUMBER
        raise ValueError("{!r}: wanted {}{}".format(text, kind, comma_remark(text))) from None
    if key.field is not None:
        return key.field.checked(value)
    if value - value != 0.0:
        raise ValueError("{}: wanted a finite number".format(text))
    return value
