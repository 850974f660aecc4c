"""What users' code gives for a verdict, as plain values; what cannot be one is refused by its name.

Values of numpy become Python's, and a number that is not finite becomes None: JSON has neither.
"""

import math

import numpy as np

from mrs_simulator.core.claims import QUESTIONS, Claim, Condition
from mrs_simulator.core.fields import MOST_BITS, shown
from mrs_simulator.verdict.verdict_file import KEYS, LISTS

DEEPEST = 20  # [-] lists and mappings within each other
RELATIONS = ("equal", "at most", "at least")
# What a verdict says of itself; ``measures`` may give the other KEYS and LISTS of a verdict.
RESERVED = (
    "schema",
    "outcome",
    "passed",
    "reason",
    "checks",
    "min_distance",
    "real_time_factor",
    "seed",
)
RESERVED += ("title", "protocol", "robots", "duration", "ended", "warnings", "versions", "derived")
FLAGS = {Claim: ("free", "motion"), Condition: ("holds", "rules_out", "necessary")}
TEXTS = {Claim: ("name", "unproved"), Condition: ("name", "why")}


def plain(value, where="value", depth=0):
    """Return ``value`` as JSON has it; a number that is not finite is None.

    Raises ``TypeError``, which begins with ``where``, for anything but numbers, texts, lists and mappings.
    """
    if isinstance(value, (np.ndarray, np.generic)) and value.dtype.kind in "biufUO":
        value = float(value) if isinstance(value, np.floating) else value.tolist()
    if value is None or isinstance(value, (bool, str)):
        return value if value is None or isinstance(value, bool) else str.__str__(value)
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, int) and value.bit_length() <= MOST_BITS:
        return int(value)
    if isinstance(value, (list, tuple)) and depth < DEEPEST:
        return [
            plain(each, "{}[{}]".format(where, row), depth + 1) for row, each in enumerate(value)
        ]
    if isinstance(value, dict) and depth < DEEPEST:
        places = {key: "{}[{}]".format(where, _key(key, where)) for key in value}
        return {_key(key, where): plain(value[key], places[key], depth + 1) for key in value}
    deep = " within {} others".format(depth) if depth >= DEEPEST else ""
    text = "{}: {}{}, wanted a number, a text, or a list or mapping of these"
    raise TypeError(text.format(where, type(value).__name__, deep))


def _key(key, where):
    if isinstance(key, (str, int, np.integer)):
        return str(key)
    raise TypeError("{}: a key of type {}, wanted texts".format(where, type(key).__name__))


def measures_of(given):
    """Return ``(values, faults)``: what ``measures`` returned, by name, and what of it cannot be kept."""
    if not isinstance(given, dict):
        return {}, ["returned {}, wanted a mapping of values by name".format(type(given).__name__)]
    values, faults = {}, []
    for name, value in given.items():
        try:
            _check_name(name)
            values[str.__str__(name)] = _measure(name, value)
        except (TypeError, ValueError) as error:
            faults.append(str(error))
    return values, faults


def _check_name(name):
    if not isinstance(name, str):
        raise TypeError("a name of type {}, wanted texts".format(type(name).__name__))
    if name in RESERVED:
        raise ValueError("{!r}: a name of the verdict's own, wanted another".format(name))


def _measure(name, value):
    """Return ``value`` as plain; that of a key of which verdicts know the type has to be of it."""
    value = plain(value, repr(name))
    if value is None:
        return value
    if name in KEYS:
        kind, wanted, _ = KEYS[name]
        fits = isinstance(value, kind) and not isinstance(value, bool)
    elif name in LISTS:
        kind, wanted = LISTS[name]
        fits = isinstance(value, list) and all(isinstance(each, kind) for each in value)
    else:
        return value
    if not fits:
        raise TypeError("{!r}: {}, wanted {}".format(name, shown(value), wanted))
    return value


def claim_of(entry, shape):
    """Return ``entry``, a ``Claim`` or ``Condition`` about points of ``shape`` (n, d), with plain values.

    Raises ``TypeError`` and ``ValueError`` that name the claim and what is wrong with it.
    """
    kind = type(entry)
    if kind not in FLAGS:
        text = "{} among them, wanted Claims and Conditions"
        raise TypeError(text.format(_briefly(entry)))
    where = "{} {}".format(kind.__name__, _briefly(entry.name))
    texts = {key: _text(getattr(entry, key), key, where) for key in TEXTS[kind]}
    flags = {key: _flag(getattr(entry, key), key, where) for key in FLAGS[kind]}
    entry = entry._replace(**texts, **flags)
    return _checked_claim(entry, where, shape) if kind is Claim else entry


def _checked_claim(claim, where, shape):
    if not callable(claim.measure):
        text = "{}: measure = {}, wanted a function of the run"
        raise TypeError(text.format(where, _briefly(claim.measure)))
    if not isinstance(claim.relation, str) or claim.relation not in RELATIONS:
        text = "{}: relation = {}, wanted one of {}"
        raise ValueError(text.format(where, _briefly(claim.relation), ", ".join(RELATIONS)))
    if not isinstance(claim.question, str) or claim.question not in QUESTIONS:
        text = "{}: question = {}, wanted one of {}"
        raise ValueError(text.format(where, _briefly(claim.question), ", ".join(QUESTIONS)))
    if claim.place is not None:
        try:
            np.broadcast_to(np.asarray(claim.place, dtype=float), shape)
        except (TypeError, ValueError):
            came = _briefly(claim.place)
            if isinstance(claim.place, np.ndarray):
                came = "an array {}".format(claim.place.shape)
            text = "{}: place = {}, wanted points {}"
            raise ValueError(text.format(where, came, shape)) from None
    numbers = {key: _finite(getattr(claim, key), key, where) for key in ("predicted", "tolerance")}
    return claim._replace(**numbers)


def _text(value, key, where):
    if not isinstance(value, str):
        raise TypeError("{}: {} = {}, wanted a text".format(where, key, _briefly(value)))
    return str.__str__(value)


def _flag(value, key, where):
    if not isinstance(value, (bool, np.bool_, int)) and np.shape(value):
        raise TypeError("{}: {} = {}, wanted True or False".format(where, key, _briefly(value)))
    return bool(value)


def _finite(value, key, where):
    numeric = isinstance(value, (bool, int, float, np.ndarray, np.generic)) and not np.ndim(value)
    number = plain(value, where) if numeric else None
    if number is None or isinstance(number, str):
        text = "{}: {} = {}, wanted one finite number"
        raise ValueError(text.format(where, key, _briefly(value)))
    return number


def _briefly(value):
    """Return ``value`` as it is shown, or its type where users' code would have to show it."""
    known = (str, bytes, bool, int, float, np.generic, type(None))
    return shown(value) if isinstance(value, known) else type(value).__name__


def texts_of(given, source):
    """Return the texts in ``given``, which users' function ``source`` returned, as a list.

    What is none is replaced by a text that names it.
    """
    if isinstance(given, str):
        return [str.__str__(given)]
    if not isinstance(given, (list, tuple, np.ndarray)) or not np.ndim(given):
        text = "{} returned {}, wanted a list of texts"
        return [text.format(source, _briefly(given))]
    fault = source + " returned {} among them, wanted texts"
    return [
        str.__str__(each) if isinstance(each, str) else fault.format(_briefly(each))
        for each in given
    ]
