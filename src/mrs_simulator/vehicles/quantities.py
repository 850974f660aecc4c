"""Physical quantities in YAML: a number in SI units, or a text of a number and a unit."""

import math
import re

from mrs_simulator.scenario.reading import Section, number, unwanted

_QUANTITY = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*)")


def _per(count):
    """Return the conversion of a unit of which ``count`` make one SI unit."""
    return lambda value: value / count


def _times(size):
    return lambda value: value * size


LENGTH = {"m": _times(1.0), "cm": _per(100.0), "mm": _per(1000.0)}
ANGLE = {"rad": _times(1.0), "deg": math.radians}
# For each SI unit the units that may be written instead, each with its conversion.
UNITS = {
    base + per: {name + per: convert for name, convert in names.items()}
    for base, names in (("m", LENGTH), ("rad", ANGLE))
    for per in ("", "/s", "/s^2", "/sqrt(s)")
}
UNITS["m/s"]["km/h"] = _per(3.6)
UNITS["rad/s"]["rpm"] = lambda value: value * 2.0 * math.pi / 60.0
UNITS["s"] = {"s": _times(1.0), "ms": _per(1000.0)}
UNITS["kg"] = {"kg": _times(1.0), "g": _per(1000.0)}
# Of a rotor, per speed squared.
UNITS["N s^2"] = {"N s^2": _times(1.0), "N/rpm^2": _per((2.0 * math.pi / 60.0) ** 2)}
UNITS["N m s^2"] = {"N m s^2": _times(1.0), "N m/rpm^2": _per((2.0 * math.pi / 60.0) ** 2)}
UNITS["J"] = {"J": _times(1.0), "kJ": _times(1e3), "Wh": _times(3600.0)}
PLAIN = (
    "V",
    "W",
    "J/m",
    "J/rad",
    "Hz",
    "N",
    "N m",
    "kg m",
    "kg m^2",
    "N/m",
    "1/s",
    "N s/m",
    "N m s",
    "N s^2/m^2",
    "N s^2/m",
)
UNITS.update({name: {name: _times(1.0)} for name in PLAIN})


def quantity(value, unit, where, **bounds):
    """Return ``value`` in the SI ``unit`` as a float, "" for a pure number.

    ``value`` is a number or a text such as ``"360 deg/s"``; ``bounds``: ``low``, ``high`` and
    ``above`` as in ``reading.number``.  Raises ``ScenarioError``.
    """
    if isinstance(value, str):
        match, known = _QUANTITY.fullmatch(value.strip()), UNITS.get(unit, {})
        if not match or match.group(2) not in known:
            wanted = "with one of the units " + ", ".join(known) if known else "without a unit"
            raise unwanted(where, value, "a number {}".format(wanted))
        value = known[match.group(2)](float(match.group(1)))
    return number(value, where, **bounds)


def times(factor, value):
    """Return the quantity ``value``, a number or a text, ``factor`` times as large; others as they are."""
    match = _QUANTITY.fullmatch(value.strip()) if isinstance(value, str) else None
    if match:
        return "{!r} {}".format(factor * float(match.group(1)), match.group(2))
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return factor * value if is_number else value


class QuantitySection(Section):
    """A mapping whose numbers may be written with units."""

    def quantity(self, key, unit, default=None, **bounds):
        """Return the quantity ``key`` in the SI ``unit``, as :func:`quantity` does."""
        return quantity(self.take(key, default), unit, self.at(key), **bounds)

    def section(self, key):
        """Return the mapping ``key``; an empty one where it is not given."""
        return QuantitySection(self.take(key, {}), self.at(key))

    def strings(self, key, count):
        """Return the list of ``count`` texts ``key`` as a tuple."""
        value = self.take(key)
        fits = isinstance(value, list) and len(value) == count
        if not fits or not all(isinstance(item, str) for item in value):
            raise unwanted(self.at(key), value, "a list of {} texts".format(count))
        return tuple(value)
