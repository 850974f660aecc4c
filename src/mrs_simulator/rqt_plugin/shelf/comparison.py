"""What two or more runs have in common and what not, as rows of tables; without Qt and ROS."""

from typing import Any, NamedTuple

from mrs_simulator.rqt_plugin.shelf.differences import differing, telling, value_text
from mrs_simulator.verdict.requirements.results import known_bound

MOST_IN_NAME = 2  # [-] differing values
OTHERWISE = "run {}"


class ComparedRun(NamedTuple):
    """One of the runs of a comparison."""

    name: str
    keys: dict  # of its scenario, flat
    verdict: Any  # as in verdict.json, None where it was not judged


def told_apart(runs):
    """Return ``runs`` with names that differ: those of equal ones by what differs in their scenarios."""
    names = [run.name for run in runs]
    if len(set(names)) == len(names):
        return list(runs)
    found = telling(differing([run.keys for run in runs]))
    result, taken = [], set()
    for place, run in enumerate(runs):
        texts = ["{} {}".format(each.short, value_text(each.values[place])) for each in found]
        short = [text for text in texts if len(text) <= 30][:MOST_IN_NAME]
        name = ", ".join(short) if names.count(run.name) > 1 and short else run.name
        name = name if name not in taken else "{} ({})".format(name, place + 1)
        taken.add(name)
        result.append(run._replace(name=name))
    return result


def parameter_rows(runs):
    """Return a row of texts for each key that differs: the key, and its value in each of ``runs``."""
    found = differing([run.keys for run in runs])
    return [[each.short, *map(value_text, each.values)] for each in found]


def claim_rows(runs):
    """Return ``(name, [check of each run])`` of each claim and requirement, those that differ first.

    A check is a mapping with predicted, measured and passed; None in a run that has it not.
    """
    by_run = [_checks(run.verdict) for run in runs]
    names = dict.fromkeys(name for checks in by_run for name in checks)
    rows = [(name, [checks.get(name) for checks in by_run]) for name in names]
    return sorted(rows, key=lambda row: _agree(row[1]))


def _checks(verdict):
    if verdict is None:
        return {}
    wanted = [
        {
            "name": each["name"],
            "passed": each["met"],
            "predicted": None,
            "measured": known_bound(each),
        }
        for each in verdict.get("requirements", [])
    ]
    return {check["name"]: check for check in [*verdict["checks"], *wanted]}


def _agree(checks):
    """Return whether all runs have the same result."""
    return len({check["passed"] if check else "absent" for check in checks}) == 1
