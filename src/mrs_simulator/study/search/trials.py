"""One run of a search, in memory, and how near it came to breaking what it is to keep."""

import math
from typing import Any, NamedTuple

from mrs_simulator.core.doc_links import named, page_of, words
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_of_file
from mrs_simulator.study.run.experiment import Experiment, LawFailed, played
from mrs_simulator.study.search.space import content_with
from mrs_simulator.verdict.judging import judged
from mrs_simulator.verdict.requirements.results import known_bound
from mrs_simulator.verdict.verdict import HOLDS, margin_of

LAW = "law"  # the name under which a law that raises breaks a run
SLOPE = 0.5  # [-] weight of the mean of the smallest margins
NEUTRAL = 1.0  # [-] what a run that leaves all open has to spare


class Trial(NamedTuple):
    """What became of one variation.

    ``value``: the least that a requirement has to spare, divided by its constant, negative where one is
    broken; infinite for a variation that is no scenario, ``error`` then says why.  ``worst``: the
    requirement of that value, as ``results.evaluated`` has it; ``slope``: by how much the mean of its
    smallest margins is above, scaled like ``value``, or that of all claims; ``spares``: such a value of
    each that was judged, by name: not of a requirement that was left open.
    """

    value: float
    worst: Any = None
    error: str = ""
    slope: float = 0.0
    spares: Any = None

    @property
    def objective(self):
        """Return what a search makes small: ``value``, and what still falls where that does not."""
        return self.value + SLOPE * self.slope

    @property
    def text(self):
        """Return how near the run came to breaking what, in words, in the unit of that."""
        worst = self.worst or {"name": ""}
        if worst.get("margin") is not None:
            unit = " " + worst["unit"] if worst["unit"] else ""
            return "margin {:+.4g}{} of {}".format(worst["margin"], unit, worst["name"])
        if not worst["name"]:
            return "nothing was judged"
        if self.has_no_margin:
            return "{} {}".format(
                worst["name"], "speaks of nothing" if worst["met"] else "left open"
            )
        if worst["name"] == LAW:
            return "{}: {}".format(LAW, worst["note"])
        return "margin {:+.3g} of the tolerance of {}".format(self.value, worst["name"])

    @property
    def has_no_margin(self):
        """Return whether it was judged by a requirement that was left open, or that speaks of nothing."""
        worst = self.worst or {}
        return "formula" in worst and worst["margin"] is None

    @property
    def is_broken(self):
        """Return whether something was broken."""
        return self.value < 0.0


def try_variation(content, path, variation, until=None, within=False):
    """Return the ``Trial`` of the scenario's ``content`` with a ``variation``.

    ``path``: the scenario's file; ``until`` [s]: a shorter duration; ``within``: claims are broken only
    where all conditions of the theorem hold.
    """
    try:
        changed = content_with(content, variation, path)
        if until is not None:
            changed["duration"] = until
        return _trial(scenario_of_file(changed, path, "{} varied".format(path)), within)
    except (ScenarioError, ValueError, OSError) as error:
        return Trial(math.inf, error=words(error) if page_of(error) else named(error))


def _trial(scenario, within):
    if not scenario.requirements:
        return _of_claims(scenario, within)
    experiment, failed = Experiment(scenario), None
    try:
        for _ in experiment.samples():
            pass
    except LawFailed as error:
        failed = str(error)
    finally:
        experiment.world.close()
    results = experiment.requirement_results()
    trial = of_results(results)
    if failed is None:
        return trial
    # What the run that ended early leaves open is not kept either.
    left_open = {each["name"]: -NEUTRAL for each in results if each["met"] is None}
    trial = trial._replace(spares={**trial.spares, **left_open})
    if trial.is_broken:
        return trial
    worst = {"name": LAW, "note": failed, "decided_at": experiment.world.time}
    return trial._replace(value=-NEUTRAL, worst=worst, slope=0.0)


def of_results(results):
    """Return the ``Trial`` whose requirements became ``results``."""
    worst = min(results, key=_spare)
    slope = 0.0
    if worst["grade"] is not None:
        slope = (worst["grade"] - worst["margin"]) / worst["scale"]
    spares = {each["name"]: _spare(each) for each in results if each["met"] is not None}
    return Trial(_spare(worst), worst, slope=slope, spares=spares)


def _spare(result):
    """Return the robustness of a requirement over its scale; of an open one what is known."""
    known = known_bound(result) if result["met"] is not None else result["high"]
    known = None if known is None else known / (result["scale"] or 1.0)
    if result["met"] is not None:
        return NEUTRAL if known is None else known
    return NEUTRAL if known is None else max(known, 0.0)


def _of_claims(scenario, within):
    """Return the ``Trial`` of the protocol's own claims: what they have to spare of their tolerances."""
    verdict, _ = judged(*played(scenario))
    if within and any(is_outside(each) for each in verdict["checks"]):
        return Trial(NEUTRAL)
    return of_checks([each for each in verdict["checks"] if each["passed"] is not None])


def of_checks(checks):
    """Return the ``Trial`` of the ``checks`` of a run that were judged.

    A claim may be near its bound whatever varies, as one that a start meets exactly: the mean of what all
    have to spare is the slope towards the others.
    """
    spares = {each["name"]: share_of(each) for each in checks}
    if not spares or min(spares.values()) >= NEUTRAL:
        return Trial(NEUTRAL, spares=spares)
    worst = min(checks, key=lambda each: spares[each["name"]])
    value = spares[worst["name"]]
    said = {"name": worst["name"], "note": worst["note"], "decided_at": None}
    mean = sum(spares.values()) / len(spares)
    return Trial(value, said, slope=mean - value, spares=spares)


def is_outside(check):
    """Return whether a ``check`` is a condition of the theorem that does not hold."""
    return check["predicted"] == HOLDS and check["measured"] != HOLDS


def share_of(check):
    """Return the share of its tolerance that a ``check`` has to spare, negative where it failed.

    Of a bound, from which a run may be far, the share of the bound itself where that is larger.
    """
    margin, share = margin_of(check), NEUTRAL
    if margin is not None and check["tolerance"]:
        size = check["tolerance"]
        if check["note"].split(", ")[0] in ("at most", "at least"):
            size = max(size, abs(check["predicted"]))
        share = margin / size
    if check["passed"]:
        return max(share, 1e-9)
    return min(share, -1e-9) if share < NEUTRAL else -NEUTRAL
