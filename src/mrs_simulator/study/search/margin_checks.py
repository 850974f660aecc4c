"""Whether measured robots keep within the margins of their scenario, for the preflight."""

import json
import os

import numpy as np

from mrs_simulator.study.results.stamp import stamp_of
from mrs_simulator.study.run.preflight import Check
from mrs_simulator.study.search.margins import Axis, acts
from mrs_simulator.study.search.margins_command import IDLE, REPORT
from mrs_simulator.vehicles import Team

SPARE = 1.5  # [-] times what is measured that a margin is wanted to be
MISMATCH = "mismatch"  # of a comparison, as a scenario has it


class MarginsError(ValueError):
    """A file that does not hold what its program writes; the message names it."""

    page = "docs/search.md#margins"


def read_margins(path):
    """Return the report that ``margins`` wrote to the directory, or file, ``path``."""
    path = os.path.join(path, REPORT) if os.path.isdir(path) else path
    report = _read(path)
    axes = report.get("axes") if isinstance(report, dict) else None
    wanted = {"key", "nominal", "end", "unit", "breaks"}
    if not isinstance(axes, list) or not all(
        isinstance(axis, dict) and wanted <= set(axis) for axis in axes
    ):
        raise MarginsError("{}: wanted what mrs-simulator margins wrote".format(path))
    return report


def read_measured(path):
    """Return values by key of the ``compare.json`` at ``path``: lists of numbers, one for each robot."""
    found = _read(path)
    mismatch = found.get(MISMATCH) if isinstance(found, dict) else None
    if not isinstance(mismatch, dict):
        raise MarginsError("{}: wanted what report --compare wrote".format(path))
    lists = {key: value if isinstance(value, list) else [value] for key, value in mismatch.items()}
    if not all(isinstance(each, (int, float)) for values in lists.values() for each in values):
        raise MarginsError("{}: wanted numbers under {}".format(path, MISMATCH))
    return {"{}.{}".format(MISMATCH, key): values for key, values in lists.items()}


def _read(path):
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except ValueError as error:
        raise MarginsError("{}: {}".format(path, error)) from None


def scenario_check(report, scenario, limits):
    """Return a ``Check`` that the margins' ``report`` is of ``scenario`` and its law as they are now.

    ``limits``: the scenario's, lowered to the highest speeds that robots are held to now.
    """
    if "stamp" not in report:
        return Check("margins", False, "do not say of which scenario they are: measure them again")
    slower = scenario._replace(limits=limits)
    before, now = (Team.from_scenario(each) for each in (scenario, slower))
    if np.array_equal(before.limits.top, now.limits.top):
        slower = scenario
    if report["stamp"] == stamp_of(slower):
        return Check("margins", True, "of this scenario and law")
    if report["stamp"] == stamp_of(scenario):
        text = "at up to {}, robots are held to {}: measure them again with such limits"
        return Check("margins", False, text.format(*map(_speeds, (before, now))))
    text = "of another scenario or law, or from before a change of {}: measure them again"
    return Check("margins", False, text.format(report.get("scenario", "it")))


def _speeds(team):
    return "{:.3g} m/s and {:.3g} rad/s".format(*team.speeds.max(axis=0))


def margin_checks(report, measured):
    """Return a ``Check`` of each axis of the margins' ``report``; ``measured``: values by key.

    What breaks first must be ``SPARE`` times as far from the nominal value as the farthest measured one.
    An axis along which something breaks and that was not measured is named, and passes.
    """
    checks = []
    for row in report["axes"]:
        axis = Axis(row["key"], row["nominal"], row["end"], row["unit"])
        first = _first(axis, row["breaks"])
        if axis.key not in measured and first:
            text = "not measured, " + _breaking(axis, first)
            checks.append(Check(_subject(axis), True, text))
        for value in _farthest(axis, measured.get(axis.key, ())):
            checks.append(_check(axis, value, first, acts(row)))
    return checks


def _farthest(axis, values):
    """Return the one of ``values`` that is farthest along ``axis``, none where none is on its side."""
    return sorted((v for v in values if axis.share(v) > 0.0), key=axis.share)[-1:]


def _subject(axis):
    return "margin of {}".format(axis.key)


def _first(axis, breaks):
    """Return the share of the way, the name and the value of what breaks first, None where all hold."""
    found = [(axis.share(pair[1]), name, pair[1]) for name, pair in breaks.items() if pair]
    return min(found) if found else None


def _with_unit(axis, value):
    return "{:.3g}{}".format(value, " " + axis.unit if axis.unit else "")


def _breaking(axis, first):
    return "{} breaks at {}".format(first[1], _with_unit(axis, first[2]))


def _check(axis, value, first, may_break):
    text = _with_unit(axis, value) + " measured, "
    if first is None:
        passed = axis.share(value) <= 1.0
        said = IDLE + " to" if not may_break else "all hold to" if passed else "tried only to"
        text += "{} {}".format(said, _with_unit(axis, axis.end))
        return Check(_subject(axis), passed, text)
    passed = first[0] >= SPARE * axis.share(value)
    text += _breaking(axis, first)
    return Check(
        _subject(axis), passed, text if passed else text + ", wanted {:g} times".format(SPARE)
    )
