"""Reads a verdict.json back, of any version, and says what is wrong with one that is none."""

from mrs_simulator.core.claims import LAW, QUESTIONS, ROBOTS, THEOREM
from mrs_simulator.core.fields import shown
from mrs_simulator.scenario.reading import read_json
from mrs_simulator.scenario.requirements import RESULT_KEYS

NUMBER = (int, float)
# Of a verdict, what is read anywhere: its type, what was wanted, and what is taken where it is absent.
KEYS = {
    "schema": (int, "a whole number", 1),
    "title": (str, "a text", ""),
    "reason": (str, "a text", ""),
    "ended": (str, "a text", ""),
    "settle_time": (NUMBER, "a number", None),
    "y_spread": (NUMBER, "a number", None),
    "min_distance": (NUMBER, "a number", None),
    "real_time_factor": (NUMBER, "a number", None),
    "derived": (bool, "true or false", False),
}
LISTS = {
    "final_gaps": (NUMBER, "a list of numbers"),
    "warnings": (str, "a list of texts"),
    "checks": (dict, "a list of mappings"),
    "requirements": (dict, "a list of mappings"),
}
OUTCOMES = ("passed", "failed", "not_judged", "self_consistent")
# What checks without a question ask, by the beginnings of their names; the others are of the theorem.
ASKED = {
    LAW: ("commands off", "energy off", "broadcasts a robot", "exact share of events"),
    ROBOTS: ("largest distance from the exact", "largest distance from the law")
    + (
        "collisions",
        "incidents",
        "ended",
        "robots held still",
        "no robot jumps",
        "bodies are apart",
    )
    + ("least distance", "least clearance", "largest share of a speed cap", "robots start"),
}
OF_A_CHECK = ("predicted", "measured", "tolerance", "difference")  # None where absent


def read_verdict(path):
    """Return the verdict in the JSON file at ``path``, a mapping as ``judge`` returns it.

    Raises ``OSError`` where it cannot be read, and ``ValueError`` where it is no verdict.
    """
    verdict = read_json(path)
    if not isinstance(verdict, dict) or verdict.get("checks") is None:
        text = "{}, wanted a verdict: a mapping with a list of checks"
        raise ValueError(text.format(shown(verdict)))
    _of_type(verdict.get("passed"), bool, "passed", "true or false")
    if verdict.get("outcome", OUTCOMES[0]) not in OUTCOMES:
        text = "outcome: {}, wanted one of {}"
        raise ValueError(text.format(shown(verdict["outcome"]), ", ".join(OUTCOMES)))
    for key, (kind, wanted, absent) in KEYS.items():
        value = verdict.get(key)
        verdict[key] = absent if value is None else _of_type(value, kind, key, wanted)
    for key, (kind, wanted) in LISTS.items():
        values = verdict.get(key) or []
        for value in _of_type(values, list, key, wanted):
            _of_type(value, kind, key, wanted)
        verdict[key] = values
    places = enumerate(verdict["checks"], 1)
    wanted = enumerate(verdict["requirements"], 1)
    verdict["requirements"] = [_requirement(each, "requirement {}".format(k)) for k, each in wanted]
    verdict["checks"] = [_check(check, "check {}".format(place)) for place, check in places]
    return verdict


def _requirement(result, where):
    """Return a requirement's result, which has all its keys."""
    missing = [key for key in RESULT_KEYS if key not in result]
    if missing:
        raise ValueError("{}: no {}, wanted a requirement's result".format(where, missing[0]))
    if result["met"] is not None:
        _of_type(result["met"], bool, where + ": met", "true, false or null")
    numbers = ("low", "high", "margin", "time", "decided_at")
    for key in numbers:
        if result[key] is not None:
            _of_type(result[key], NUMBER, "{}: {}".format(where, key), "a number")
    return result


def _check(check, where):
    """Return a check with all its keys."""
    name = _of_type(check.get("name"), str, where + ": name", "a text")
    where = "{} ({})".format(where, shown(name))
    note = _of_type(check.get("note", ""), str, where + ": note", "a text")
    if "passed" not in check or check["passed"] is not None:
        _of_type(check.get("passed"), bool, where + ": passed", "true, false or null")
    question = check.get("question", _asked(name))
    if question not in QUESTIONS:
        text = "{}: question: {}, wanted one of {}"
        raise ValueError(text.format(where, shown(question), ", ".join(QUESTIONS)))
    return {**dict.fromkeys(OF_A_CHECK), **check, "note": note, "question": question}


def _asked(name):
    """Return the question of a check of files that have none."""
    found = [question for question, begins in ASKED.items() if name.startswith(begins)]
    return found[0] if found else THEOREM


def _of_type(value, kind, where, wanted):
    if not isinstance(value, kind) or (kind is not bool and isinstance(value, bool)):
        raise ValueError("{}: {}, wanted {}".format(where, shown(value), wanted))
    return value
