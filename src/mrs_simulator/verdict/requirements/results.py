"""What became of a scenario's requirements in a run, and how verdicts say it."""

import numpy as np

from mrs_simulator.control.user_code import print_raised
from mrs_simulator.core.doc_links import named
from mrs_simulator.core.temporal_logic.formula import ending, predicates
from mrs_simulator.scenario.requirements import RESULT_KEYS
from mrs_simulator.verdict.user_values import plain

WORDS = {True: "met", False: "BROKEN", None: "open"}


def requirement_results(control, run):
    """Return what became of each requirement of the run's scenario, as :func:`evaluated` does.

    Those that a simulation evaluated at each of its steps are kept, if they are still the scenario's.
    """
    wanted = run.scenario.requirements if run.scenario else ()
    kept = run.meta.get("requirements", [])
    whole = all(isinstance(each, dict) and set(each) == set(RESULT_KEYS) for each in kept)
    if whole and [(each["name"], each["formula"]) for each in kept] == list(wanted):
        return kept
    return evaluated(control, run)


def evaluated(control, run, goes_on=False):
    """Return what became of each requirement at the samples of ``run``, a list of plain mappings.

    ``name``, ``formula``; ``met``, None where the run leaves it open; ``low`` and ``high``, the bounds
    of its robustness, None where infinite; ``predicate``: the comparison that decided, ``margin``
    [``unit``] what it had to spare at ``time`` [s], ``member`` whose it was; ``decided_at`` [s];
    ``grade`` [``unit``]: the mean of its smallest margins; ``scale`` [``unit``]: its constant; ``period``
    [s], the longest between two samples; ``note``: why it was not evaluated, or "".  ``goes_on``: whether
    these are the first samples of a run that is to last as long as its scenario says.
    """
    scenario = run.scenario
    period = float(np.diff(run.time).max()) if len(run.time) > 1 else 0.0
    return [
        _result(each, control, run, period, scenario.duration if goes_on else None)
        for each in (scenario.requirements if scenario else ())
    ]


def left_open(scenario, note):
    """Return the results of the requirements of a ``scenario`` whose run has no sample; ``note``: why."""
    return [_begun(each, 0.0, note) for each in scenario.requirements]


def _begun(requirement, period, note=""):
    """Return the result of a ``requirement`` of which nothing is known yet."""
    result = dict.fromkeys(RESULT_KEYS)
    result.update(name=requirement.name, formula=requirement.text, period=period, note=note)
    return result


def _result(requirement, control, run, period, duration):
    # Most runs have no requirement.
    from mrs_simulator.core.temporal_logic.robustness import evaluate
    from mrs_simulator.core.temporal_logic.syntax import FormulaError
    from mrs_simulator.verdict.requirements.signals import Absent, signal_of

    result = _begun(requirement, period)
    formula = requirement.formula
    if duration is not None:
        formula = ending(formula, duration)
    names = {name for each in predicates(formula) for name in each.signals}
    try:
        signals = {name: signal_of(name, control, run) for name in sorted(names)}
        found = evaluate(formula, requirement.text, run.time - run.time[0], signals)
    except (Absent, FormulaError) as error:
        return {**result, "note": str(error)}
    except Exception as error:  # of the protocol's methods
        print_raised(error)
        return {**result, "note": named(error)}
    result.update((key, value) for key, value in found._asdict().items() if key in RESULT_KEYS)
    if found.holds is not None and found.margin is None:
        result["note"] = "there is none of which it speaks"
    return plain({**result, "met": found.holds}, "requirement")


def known_bound(result):
    """Return the robustness of a requirement that is met or broken, of an open one None."""
    return {True: result["low"], False: result["high"], None: None}[result["met"]]


def bound_of(result):
    """Return the robustness of a requirement, of an open one what is known of it: at most, or at least."""
    if result["met"] is not None:
        return known_bound(result)
    return result["low"] if result["high"] is None else result["high"]


def summary(results):
    """Return how many of the ``results`` are met, in words, "" where there are none."""
    if not results:
        return ""
    met = sum(each["met"] is True for each in results)
    return "requirements met: {} of {}".format(met, len(results))


def requirement_lines(results):
    """Return the lines for a terminal of the ``results``."""
    return ["  requirement " + line_of(each) for each in results]


def line_of(result):
    """Return what became of one requirement in words: "settled: met, margin +0.031 m ..."."""
    text = "{}: {}".format(result["name"], WORDS[result["met"]])
    if result["note"]:
        return "{} ({})".format(text, result["note"])
    if result["met"] is None:
        return "{} ({}): the run ends before it is decided".format(text, result["formula"])
    whose = " by {}".format(result["member"]) if result["member"] else ""
    unit = " " + result["unit"] if result["unit"] else ""
    line = "{}, margin {:+.3g}{}{} at {:.2f} s, decided at {:.2f} s ({})"
    return line.format(
        text,
        result["margin"],
        unit,
        whose,
        result["time"],
        result["decided_at"],
        result["predicate"],
    )
