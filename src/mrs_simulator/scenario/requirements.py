"""Requirements of a scenario: formulas of Signal Temporal Logic by name, over signals of its robots."""

from typing import NamedTuple, Optional

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.temporal_logic.formula import EDGE, PAIR, ROBOT, predicates
from mrs_simulator.scenario.reading import ScenarioError, unwanted

LONGEST_NAME = 60  # [characters]
# Of what became of a requirement: verdict.requirements.results
RESULT_KEYS = (
    *("name", "formula", "met", "low", "high", "predicate", "margin", "unit", "time", "member"),
    *("decided_at", "grade", "scale", "period", "note"),
)


class SignalKind(NamedTuple):
    """A signal's ``unit``, the ``domain`` whose members have one each, None of the team's, and its text."""

    unit: str
    domain: Optional[str]
    meaning: str


SIGNALS = {
    "time": SignalKind("s", None, "since the start"),
    "x": SignalKind("m", ROBOT, "of the centre"),
    "y": SignalKind("m", ROBOT, "of the centre"),
    "height": SignalKind("m", ROBOT, "of the centre above the ground"),
    "heading": SignalKind("rad", ROBOT, "theta, as recorded: not wrapped"),
    "speed": SignalKind("m/s", ROBOT, "of the centre, since the sample before"),
    "turn_rate": SignalKind("rad/s", ROBOT, "since the sample before"),
    "error": SignalKind(
        "m", ROBOT, "distance of the controlled point from where the protocol wants it"
    ),
    "deviation": SignalKind("m", ROBOT, "distance of the controlled point from the exact solution"),
    "obstacle_clearance": SignalKind("m", ROBOT, "distance of the body from the nearest obstacle"),
    "distance": SignalKind("m", PAIR, "of two centres"),
    "clearance": SignalKind("m", PAIR, "distance of two bodies, negative where they overlap"),
    "length": SignalKind("m", EDGE, "of an edge of the first graph, between controlled points"),
    "energy": SignalKind("", None, "the protocol's energy, in its own unit"),
    "lambda_2": SignalKind("", None, "algebraic connectivity of the graph"),
    "contacts": SignalKind("", None, "number of contacts so far"),
}


CURVE, SENSOR = "curve", "sensor"  # before the dot of signals that a law or a robot's sensor gives
OPEN = {
    CURVE: SignalKind("", None, "curve.NAME: a curve of the law over time, in its own unit"),
    SENSOR: SignalKind("", ROBOT, "sensor.NAME.FIELD: the least of a reading, in its own unit"),
}
FORMS = ("curve.NAME", "sensor.NAME.FIELD")


class _Signals(dict):
    """The signals by name, with those that a law or sensors give, of which only the form is known."""

    def __missing__(self, name):
        parts = str(name).split(".")
        if len(parts) != {CURVE: 2, SENSOR: 3}.get(parts[0]) or not all(parts):
            raise KeyError(name)
        return OPEN[parts[0]]

    def __iter__(self):
        yield from SIGNALS
        yield from FORMS

    def __contains__(self, name):
        try:
            self[name]
        except KeyError:
            return False
        return True


ALL_SIGNALS = _Signals(SIGNALS)


class Requirement(NamedTuple):
    """A formula, as ``text``, and its ``name``."""

    name: str
    text: str

    @property
    def signals(self):
        """Return the names of the signals of which the formula speaks, a set."""
        return {name for each in predicates(self.formula) for name in each.signals}

    @property
    def sensors(self):
        """Return the names and fields of the sensors of which the formula speaks, a set of pairs."""
        return {
            tuple(name.split(".")[1:]) for name in self.signals if name.startswith(SENSOR + ".")
        }

    @property
    def formula(self):
        """Return the formula as a tree."""
        from mrs_simulator.core.temporal_logic.syntax import parse

        return parse(self.text)


@explained_by("docs/requirements.md")
def read_requirements(top):
    """Return the ``Requirement``s under the key ``requirements``, checked, as a tuple."""
    given, where = top.take("requirements", {}), top.at("requirements")
    if not isinstance(given, dict):
        raise unwanted(where, given, "a mapping of formulas by name")
    return tuple(_read(name, text, where) for name, text in given.items())


def _read(name, text, where):
    # Most scenarios have no requirement.
    from mrs_simulator.core.temporal_logic.robustness import check
    from mrs_simulator.core.temporal_logic.syntax import FormulaError, parse

    if not isinstance(name, str) or not 0 < len(name) <= LONGEST_NAME:
        raise unwanted(where, name, "a name of a requirement")
    try:
        check(parse(text), text, ALL_SIGNALS)
    except FormulaError as error:
        raise ScenarioError("{}.{}: {}".format(where, name, error)) from None
    return Requirement(name, text)
