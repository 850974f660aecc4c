"""The verdict on a run: what theory predicts, what was measured, and whether they agree.

A run *passed* where at least one claim of its protocol was judged and nothing judged failed, it
*failed* where something did, and else it was *not judged*, for a stated reason.  What passes by theory
that was derived from the law itself is *self-consistent*: it agrees with itself, mistakes included.
"""

import argparse
import functools
import json
import math
import platform
import sys
from typing import Any, Dict, NamedTuple, Optional

import numpy as np

from mrs_simulator.control.user_code import print_raised
from mrs_simulator.core.claims import (
    NO_TOPOLOGY,
    QUESTIONS,
    ROBOTS,
    THEOREM,
    Condition,
    NothingDecays,
)
from mrs_simulator.core.doc_links import OF_FAILED, OF_NOT_JUDGED, OF_SELF_CONSISTENT, named, words
from mrs_simulator.core.writing import printing, write_text
from mrs_simulator.record.controller_log import deadlock_text
from mrs_simulator.record.recording import closest_approach, part_of
from mrs_simulator.record.run_changes import changes_text
from mrs_simulator.scenario.incidents import ARM_END, SATURATED
from mrs_simulator.scenario.reading import reason
from mrs_simulator.scenario.team.mismatch import NO_MISMATCH
from mrs_simulator.verdict.requirements.results import requirement_lines, summary
from mrs_simulator.verdict.user_values import plain
from mrs_simulator.verdict.verdict_file import OUTCOMES, read_verdict
from mrs_simulator.version import __version__

HOLDS = "holds"  # what is predicted of a condition
PASSED, FAILED, NOT_JUDGED, SELF_CONSISTENT = OUTCOMES
WORDS = {
    PASSED: "PASSED",
    SELF_CONSISTENT: "SELF-CONSISTENT",
    FAILED: "FAILED",
    NOT_JUDGED: "NOT JUDGED",
}
EXPLAINED = {FAILED: OF_FAILED, NOT_JUDGED: OF_NOT_JUDGED, SELF_CONSISTENT: OF_SELF_CONSISTENT}
DERIVED = "by linear theory derived from the law, which states none"
UNJUDGED_CODE = 3  # of programs that require a verdict
CELL = 13  # [-] letters of a number in the table for a terminal; a longer text stands after the outcome
NO_PROTOCOL = "no protocol is known whose claims could be judged"
UNKNOWN_LAW = NO_PROTOCOL + ": that the controller ran {} is known from a topic alone"
NO_CLAIMS = "the protocol states no claims"
NO_COMMANDS = "no robot was commanded to move: the controller did not run"
NOT_TESTED = "the theorem is not tested: {}"
UNTESTED = "the law is confirmed; the theorem is not tested: {}"
NONE_OF_THEM = "none of its claims applies"
NONE_APPLY = "none of the protocol's claims applies to this run"
STILL = "robots held still by the safety filter"
BROKEN = "measuring it failed"  # how the note of a claim begins whose measure raised
MOST_NAMED = 3  # [-] collisions, or incidents
FEWEST_SAMPLES = 3  # [-] of a part of a run that is judged
HIDDEN = "the published law on these robots does not show it either"
TOO_COSTLY = 2.0  # [-] of a claim's own tolerance: what held commands may cost at most
STILLED = "does not apply: the dead band {:g} holds robots still, which costs {:.3g}"
DISOBEYED = "does not apply: the scenario's mismatch costs {:.3g}"
UNFREE = (
    "{}: where that moves what is claimed, say free=True, and it is judged of the rest of the run"
)
FALLS = (
    "the run is too short: what it misses still falls, from {:.3g} to {:.3g} in its last quarter"
)
LED = (
    "theory leads their points there; wanted fidelity: point_mass, or places that are farther apart"
)
APART = "theory leads it there"
COST = "held commands and limits cost {:.3g}, which the tolerance takes in"
SLIP = "robots that slip as recorded are {:.3g} off under the published law"
OTHERWISE = "under the published law robots that slip so have {:.4g}"
GRIP = (
    "wheels that speed up no faster than their friction lets them cost {:.3g}, which the "
    "tolerance takes in"
)
COSTLY = (
    "the published law misses it as well, by {:.3g}: commands are held too long for these robots"
)
SCHEMA = 2  # of verdict.json: checks have a question since 2
ASKED = {
    "theorem": "theorem: does theory hold of the law?",
    "law": "law: do robots get the commands that the published law wants?",
    "robots": "robots: do they go where theory goes?",
}
VERSIONED = ("numpy", "matplotlib", "pybullet", "numba")


class Check(NamedTuple):
    """One comparison; ``passed`` is None where it says nothing of this run (``note``: why).

    ``question``: which of ``QUESTIONS`` it answers.
    """

    name: str
    predicted: Any
    measured: Any
    tolerance: Optional[float]
    passed: Optional[bool]
    difference: Optional[float] = None
    note: str = ""
    question: str = ROBOTS


class Theory(NamedTuple):
    """What theory gives beside claims.

    ``exact``: the ``Run`` of points, ``followed``: that of these robots under held commands and within
    their limits, ``slipped``: that of robots which make of their commands what the recorded ones made of
    theirs, or None; ``narrow``: tolerances by the names of claims, where the robots are compared
    with the latter two; ``limited``: who was at a limit and until when, or ""; ``late``: returns the
    :class:`Late` of such a run; ``ruled_out``: why no claim applies, or ""; ``rest``: the part of the run
    that is judged, None for all of it, and ``why``; ``points``: the :class:`Points` on which the theorem
    is tested, or None; ``led``: when [s] theory leads which pairs of rows nearer to each other than bodies
    can be, as :func:`meetings.meetings` returns it, or None; ``leads_apart``: whether the protocol predicts
    that the team goes as far as a run may at most; ``gripping``: returns the ``followed`` of
    wheels that speed up no faster than friction lets them, or is None; ``unbanded``: the tolerances by the
    names of claims without what they allow a dead band, {} where there is none.
    """

    exact: Any = None
    followed: Any = None
    slipped: Any = None
    narrow: Dict[str, float] = {}
    unbanded: Dict[str, float] = {}
    limited: str = ""
    late: Any = None
    ruled_out: str = ""
    rest: Any = None
    why: str = ""
    points: Any = None
    led: Any = None
    leads_apart: bool = False
    gripping: Any = None

    def of_points(self, claim):
        """Return the ``Answer`` of the law itself on ``claim``, None where that is not known."""
        return self.points.answer(claim) if self.points and claim.question == THEOREM else None


NO_THEORY = Theory()


class Late(NamedTuple):
    """What is judged of claims for unlimited inputs where a robot was at a limit, and ``why``.

    ``run``: the part of the run after that, None if nothing is judged; ``claims`` made of its start,
    by name; ``theory``: the :class:`Theory` of that part; ``again``: returns the ``Late`` of what is left
    after the last limit of all, for claims that even little of a limit costs too much, or None.
    """

    why: str
    run: Any = None
    claims: Any = None
    theory: Any = NO_THEORY
    again: Any = None


def judge(run, claims=None, measures=None, guards=(), theory=NO_THEORY, obedience=None):
    """Return the verdict on ``run`` as the plain mapping that ``verdict.json`` holds.

    ``claims``: ``Claim``s and ``Condition``s of the protocol, None without a protocol; ``measures``:
    further values for the verdict; ``guards``: claims of what watches over any protocol, which judge
    no theory of its; ``theory``: what they are compared with; ``obedience``: the function that returns
    the checks of whether the robots of a run do as commanded.
    """
    checks = _checks(run if theory.rest is None else theory.rest, claims or (), theory)
    unjudged = _unjudged(run, claims, checks, theory)
    if unjudged and unjudged in (NO_COMMANDS, run.meta.get("degraded")):
        checks = [check._replace(passed=None, note=unjudged) for check in checks]
    checks += [check._replace(question=ROBOTS) for check in _checks(run, guards)]
    checks += _obeyed(run, obedience)
    warnings = [*run.meta.get("warnings", []), *filter(None, [_changes(run)])]
    checks += _deadlock(run)
    checks.append(_collisions(run, theory.led))
    checks += _incidents(run)
    ended = _ended(run)
    checks.append(_end(ended, theory))
    scenario = run.scenario
    closest = closest_approach(run.pose, run.z)
    if "closest_approach" in run.meta:
        closest = min(closest, run.meta["closest_approach"])
    wrong = any(check.passed is False for check in checks)
    outcome = FAILED if wrong else NOT_JUDGED if unjudged else PASSED
    checks.sort(key=lambda check: QUESTIONS.index(check.question))
    verdict = {
        "schema": SCHEMA,
        "outcome": outcome,
        "passed": outcome == PASSED,
        "reason": unjudged if outcome == NOT_JUDGED else "",
        "checks": [check._asdict() for check in checks],
        "settle_time": None,
        "final_gaps": None,
        "y_spread": None,
        **(measures or {}),
        "min_distance": closest if math.isfinite(closest) else None,
        "real_time_factor": run.meta.get("real_time_factor"),
        "seed": scenario.seed if scenario is not None else run.meta.get("seed"),
        "title": scenario.title if scenario is not None else "",
        "protocol": scenario.control.protocol if scenario is not None else "",
        "robots": len(run.robots),
        "duration": float(run.time[-1] - run.time[0]),
        "ended": ended,
        "warnings": warnings,
        "versions": versions(),
    }
    return plain(verdict, "verdict")  # differences of finite numbers may be infinite


def labelled(verdict):
    """Return the ``verdict`` on a run that was judged by theory derived from its own law."""

    def said(text):
        return text.replace("published law", "derived law")

    checks = [{**c, "name": said(c["name"]), "note": said(c["note"])} for c in verdict["checks"]]
    verdict = {**verdict, "checks": checks, "derived": True, "passed": False}
    if verdict["outcome"] == PASSED:
        verdict["outcome"] = SELF_CONSISTENT
    return with_reason(verdict, DERIVED)


def with_reason(verdict, why):
    """Return ``verdict`` with ``why`` behind its reason."""
    if not why:
        return verdict
    return {**verdict, "reason": "; ".join(filter(None, (verdict["reason"], why)))}


def with_requirements(verdict, results):
    """Return ``verdict`` with the ``results`` of the scenario's requirements: broken ones fail the run.

    That all are met judges no theory: a run that was not judged is not judged still.  Open ones leave a
    run passed, whose reason then says how many are met.
    """
    if not results:
        return verdict
    verdict = {**verdict, "requirements": results}
    if any(each["met"] is False for each in results):
        reason = DERIVED if verdict.get("derived") else ""
        return {**verdict, "outcome": FAILED, "passed": False, "reason": reason}
    is_open = any(each["met"] is None for each in results)
    told = (NOT_JUDGED, SELF_CONSISTENT, PASSED) if is_open else (NOT_JUDGED, SELF_CONSISTENT)
    return with_reason(verdict, summary(results)) if verdict["outcome"] in told else verdict


def _obeyed(run, obedience):
    """Return the checks of ``obedience`` of ``run`` until bodies touch or one falls, a list."""
    if obedience is None or run.meta.get("uncommanded") or run.meta.get("degraded"):
        return []
    broken_off = first_break(run)
    if broken_off is None:
        return obedience(run)
    until = part_of(run, slice(0, int(np.searchsorted(run.time, broken_off[0]))))
    why = "until {1} at {0:.1f} s".format(*broken_off)
    return [check._replace(note=_joined(check.note, why)) for check in obedience(until)]


def _unjudged(run, claims, checks, theory):
    """Return why nothing of the protocol's theorem was tested, or ""."""
    if claims is None:
        unknown = run.meta.get("unknown_law")
        return UNKNOWN_LAW.format(unknown) if unknown else NO_PROTOCOL
    if run.meta.get("uncommanded"):
        return NO_COMMANDS
    if run.meta.get("degraded"):
        return run.meta["degraded"]
    broken = _broken(claims)
    if broken:
        return ": ".join(filter(None, (NONE_APPLY, broken, _lacks_topology(claims))))
    claimed = [check for check in checks if check.predicted != HOLDS]
    if not claimed:
        return NO_CLAIMS
    judged = [check for check in claimed if check.passed is not None]
    if any(check.question == THEOREM for check in judged):
        return ""
    why = deadlock_text(run.meta.get("deadlock")) or _changes(run)
    if why:
        return why
    of_theorem = [c for c in claims if not isinstance(c, Condition) and _is_of_theorem(c)]
    needed = _needed(of_theorem, theory)
    if not judged:
        return NOT_TESTED.format(needed) if needed else NONE_APPLY
    return UNTESTED.format(needed or (NONE_OF_THEM if of_theorem else NO_CLAIMS))


def _needed(claims, theory):
    """Return how long a run the first of ``claims`` needs that is open in this one, in words, or ""."""
    answers = [theory.of_points(claim) for claim in claims if not claim.unproved]
    short = [answer for answer in answers if answer and answer.needed is not None]
    if not short:
        return ""
    return min(short, key=lambda answer: answer.needed).note.split(": ", 1)[1]


def _changes(run):
    """Return what was changed during ``run``, in words, or ""."""
    known = run.scenario is not None
    return changes_text(run.scenario, run.meta.get("changes", [])) if known else ""


def outcome_of(verdict):
    """Return the outcome in ``verdict``; files of earlier versions know passed and failed alone."""
    return verdict.get("outcome") or (PASSED if verdict["passed"] else FAILED)


def exit_code(verdict, required=False):
    """Return the exit code of a program that ends with ``verdict``.

    0 passed, 1 failed; not judged and self-consistent 0, or ``UNJUDGED_CODE`` where a verdict is
    ``required``.
    """
    unjudged = UNJUDGED_CODE if required else 0
    codes = {PASSED: 0, FAILED: 1, NOT_JUDGED: unjudged, SELF_CONSISTENT: unjudged}
    return codes[outcome_of(verdict)]


def margin_of(check):
    """Return what a ``check``, a mapping, has to spare in its unit: less than 0 if it failed; or None."""
    if check.get("difference") is None or check.get("tolerance") is None:
        return None
    said = check["note"].split(", ")[0]
    relation = said if said in ("at most", "at least") else "equal"
    return check["tolerance"] - _excess(check["difference"], relation)


def _collisions(run, led=None):
    """Return the check of collisions, which fails unless theory leads all these pairs there, ``led``."""
    if run.meta.get("collisions_unknown"):
        return Check("collisions", 0, None, 0, None, note="none was reported")
    check = _compare("collisions", 0, len(run.collisions), 0, "equal")
    note = _first_few(
        run.collisions, lambda c: "{} and {} at {:.1f} s".format(c.first, c.second, c.time)
    )
    filtered = run.scenario is not None and run.scenario.control.safety  # which is to prevent them
    if led and run.collisions and not filtered and pairs_of(run) <= set(led):
        return check._replace(passed=None, note=_joined(note, LED))
    return check._replace(note=note)


def _first_few(happened, text):
    named = [text(each) for each in happened[:MOST_NAMED]]
    return ", ".join(named + ["..."] * (len(happened) > MOST_NAMED))


def pairs_of(run):
    """Return the pairs of rows of robots that touched, in their order, and None for what is no robot."""
    rows = {"robot{:g}".format(number): row for row, number in enumerate(run.robots)}
    pairs = {(rows.get(c.first), rows.get(c.second)) for c in run.collisions}
    return {pair if None in pair else tuple(sorted(pair)) for pair in pairs}


def _incidents(run):
    """Return a check of what befell robots, a list; what the scenario ordered, and what follows, fails no
    run, nor do rotors at their limit or arms at an end."""
    found = run.meta.get("incidents")
    if not found:
        return []
    own = [each for each in found if not each.ordered and each.what not in (SATURATED, ARM_END)]
    note = _first_few(found, lambda each: "{} at {:.1f} s".format(each.text, each.time))
    return [Check("incidents", 0, len(found), 0, False if own else None, note=note)]


def _deadlock(run):
    """Return a check that names robots in a deadlock at the end, a list; no theorem excludes it."""
    held = run.meta.get("deadlock")
    if not held:
        return []
    return [Check(STILL, 0, len(held), 0, None, note=deadlock_text(held))]


def _end(ended, theory):
    """Return the check that a run ``ended`` complete; theory itself may drive a team apart."""
    check = Check("ended", "complete", ended, None, ended == "complete")
    if theory.leads_apart:
        return check._replace(passed=None, note=APART)
    return check


def _ended(run):
    ended, scenario = run.meta.get("ended", "complete"), run.scenario
    short = False
    if scenario is not None:  # of real robots 1/rate, of simulated ones whole steps
        period = max(1.0 / scenario.record_rate, scenario.record_period)
        short = run.time[-1] < scenario.duration - period
    return "cut short" if short and ended == "complete" else ended


def _checks(run, claims, theory=NO_THEORY):
    """Return the checks of ``claims``, conditions first.

    What compares with the law itself is judged whether or not a theorem's conditions hold.
    """
    checks = [_held(claim) for claim in claims if isinstance(claim, Condition)]
    unproved, broken_off = _broken(claims), first_break(run)
    for claim in claims:
        if isinstance(claim, Condition):
            continue
        why = theory.ruled_out or claim.unproved or (unproved if _is_of_theorem(claim) else "")
        found = None if why else theory.of_points(claim)
        if why:
            checks.append(_measured_only(run, claim, why))
        elif found is not None and found.holds is False:
            checks.append(measured_of(run, claim)._replace(passed=False, note=found.note))
        elif broken_off is not None and claim.motion:
            checks.append(_judged_before(run, claim, theory, broken_off))
        else:
            checks.append(_judged(run, claim, theory))
        note = _joined(checks[-1].note, theory.why)
        checks[-1] = checks[-1]._replace(note=note, question=claim.question)
    return checks


def _is_of_theorem(claim):
    return claim.question == THEOREM


def _broken(claims):
    """Return which conditions do not hold that the claims need, as a text, or ""."""
    conditions = [claim for claim in claims if isinstance(claim, Condition)]
    broken = ", ".join(c.name for c in conditions if c.rules_out and not c.holds)
    return broken and "{} does not hold".format(broken)


def _lacks_topology(claims):
    """Return ``NO_TOPOLOGY`` where a condition of ``claims`` fails for want of one, else ""."""
    conditions = [claim for claim in claims if isinstance(claim, Condition)]
    return NO_TOPOLOGY if any(NO_TOPOLOGY in condition.why for condition in conditions) else ""


def _held(condition):
    held = Check(condition.name, HOLDS, HOLDS, None, True, question=THEOREM)
    if condition.holds:
        return held
    fails = condition.necessary or not condition.rules_out
    return held._replace(
        measured="does not hold", passed=False if fails else None, note=condition.why
    )


def first_break(run):
    """Return when [s] the run's first collision or incident was, and which, in words; None for none."""
    first = min((c.time for c in run.collisions), default=None)
    found = [
        (c.time, "{} and {} touched".format(c.first, c.second))
        for c in run.collisions
        if c.time == first
    ]
    incidents = run.meta.get("incidents", ())
    # Where an arm is at its end, base and other joints make up for it.
    found += [(i.time, i.text) for i in incidents if i.what != ARM_END]
    return min(found, default=None)


def _judged_before(run, claim, theory, found):
    """Return the check of a ``claim`` about free motion in a run in which bodies touched or one fell."""
    why = "{1} at {0:.1f} s".format(*found)
    samples = int(np.searchsorted(run.time, found[0]))
    if _is_of_theorem(claim) or samples < FEWEST_SAMPLES:
        return _measured_only(run, claim, why)
    check = _judged(part_of(run, slice(0, samples)), claim, theory)
    return check._replace(note=_joined(check.note, "until " + why))


def _judged(run, claim, theory):
    """Return the check of ``claim``, on the part of the run of which the theorem speaks.

    The tolerance of what is not compared with the law itself has as a part what the same claim misses in
    ``theory.followed``: what held commands and limits cost.  Where limits cost more than the claim
    allows, the rest of the run is judged, from the last time at a limit on.
    """
    if not _is_of_theorem(claim):
        if claim.free and theory.limited:
            return _judged_late(run, claim, theory)
        return measured_of(run, claim)
    found = theory.of_points(claim)
    short = found.note if found is not None and found.holds is not True else ""
    if theory.followed is None:
        if claim.free and theory.limited:
            return _judged_late(run, claim, theory)
        check = measured_of(run, claim)
        if check.passed is False and theory.limited:
            why = _missed_at_limits(run, claim, theory.limited)
            check = check._replace(note=_joined(check.note, why))
        if short and check.passed is not None and not check.note.startswith(BROKEN):
            check = check._replace(passed=None, note=short)
        return check
    cost, why = _cost(claim, theory.followed)
    if theory.limited and _is_costly(claim, theory):
        return _judged_late(run, claim, theory)
    if short:
        return measured_of(run, claim)._replace(passed=None, note=short)
    return _within_cost(run, claim, theory, cost, why)


def _missed_at_limits(run, claim, limited):
    """Return why a run in which robots were at limits, ``limited`` in words, misses ``claim``."""
    parts = part_of(run, slice(0, 1 + 3 * len(run.time) // 4)), run
    then, now = (_cost(claim, part)[0] for part in parts)
    falls = None not in (then, now) and then - now > claim.tolerance
    return _joined(FALLS.format(then, now) if falls else "", UNFREE.format(limited))


def _within_cost(run, claim, theory, cost, why):
    """Return the check of ``claim`` whose tolerance takes in its ``cost``; ``why`` None is not known."""
    if cost is None:
        check = measured_of(run, claim)
        if check.passed is None or check.note.startswith(BROKEN):
            return check
        return check._replace(passed=None, note="does not apply: {}".format(why))
    typed = theory.unbanded.get(claim.name, claim.tolerance)
    own = theory.narrow.get(claim.name, typed)
    if theory.slipped is not None:
        return _within_slip(run, claim, theory, min(own, claim.tolerance), cost)
    if claim.name in theory.narrow:  # what points miss is no cost of the robots
        missed = min(_missed_by_points(claim, theory), cost)
        own, cost = min(own + missed, max(own, claim.tolerance)), cost - missed
    check = measured_of(run, claim._replace(tolerance=own + cost))
    if check.passed is None or cost <= own:
        return check
    if cost > claim.tolerance and run.scenario is not None:
        deadband = run.scenario.control.deadband
        if deadband:
            return check._replace(passed=None, note=STILLED.format(deadband, cost))
        if run.scenario.mismatch != NO_MISMATCH:
            return check._replace(passed=None, note=DISOBEYED.format(cost))
    if cost > TOO_COSTLY * claim.tolerance:
        check = measured_of(run, claim)
        return check._replace(note=_joined(check.note, COSTLY.format(cost)))
    return check._replace(note=_joined(check.note, COST.format(cost)))


def _missed_by_points(claim, theory):
    """Return by how much the exact solution misses ``claim``, 0 where that is not known."""
    if theory.exact is None:
        return 0.0
    missed, _ = _cost(claim, theory.exact)
    return missed or 0.0


def _within_slip(run, claim, theory, own, cost):
    """Return the check of ``claim`` about robots whose slip the record shows.

    The tolerance is what ``claim`` allows such robots for slip, and what held commands and limits ``cost``;
    nothing of the record widens it.  Within that, what is measured has to be, within ``own``, what it is
    under the published law with this slip.
    """
    found = measured_of(theory.slipped, claim)
    slip, why = _cost(claim, theory.slipped)
    if slip is None:
        check = measured_of(run, claim)
        return check if check.passed is None else check._replace(passed=None, note=why)
    allowed = min(cost, TOO_COSTLY * claim.tolerance)
    check = measured_of(run, claim._replace(tolerance=claim.tolerance + allowed))
    if check.passed is False:
        check = _within_grip(run, claim, theory, check)
    if check.passed is None or check.measured is None:
        return check
    if _excess(check.measured - found.measured, claim.relation) > own:
        return check._replace(
            passed=False, note=_joined(check.note, OTHERWISE.format(found.measured))
        )
    return check if slip <= own else check._replace(note=_joined(check.note, SLIP.format(slip)))


def _within_grip(run, claim, theory, check):
    """Return the ``check`` of ``claim``, or where the grip of wheels costs more, that with this cost."""
    gripping = theory.gripping and theory.gripping()
    cost = _cost(claim, gripping)[0] if gripping is not None else None
    allowed = claim.tolerance + min(cost or 0.0, TOO_COSTLY * claim.tolerance)
    if allowed <= check.tolerance:
        return check
    within = measured_of(run, claim._replace(tolerance=allowed))
    return within._replace(note=_joined(within.note, GRIP.format(cost)))


def _cost(claim, followed):
    """Return by how much ``claim`` is missed in the run ``followed``, or None and why that is not known."""
    check = measured_of(followed, claim)
    if check.difference is None:
        return None, HIDDEN
    return max(0.0, _excess(check.difference, claim.relation)), ""


def _is_costly(claim, theory):
    """Return whether held commands and limits cost ``claim`` more than it allows."""
    if not _is_of_theorem(claim) or theory.followed is None:
        return False
    cost, _ = _cost(claim, theory.followed)
    return cost is None or cost > claim.tolerance


def _judged_late(run, claim, theory):
    """Return the check of ``claim`` on the part of the run that limits left alone."""
    late = theory.late() if theory.late else Late(theory.limited)
    if (
        late.again
        and claim.name in late.claims
        and _is_costly(late.claims[claim.name], late.theory)
    ):
        late = late.again()
    if late.run is None or claim.name not in late.claims:
        return _measured_only(run, claim, late.why)
    rest, found = late.run, first_break(late.run) if claim.motion else None
    if found is not None:
        rest = part_of(rest, slice(0, int(np.searchsorted(rest.time, found[0]))))
        if len(rest.time) < FEWEST_SAMPLES:
            return _measured_only(run, claim, late.why)
    check = _judged(rest, late.claims[claim.name], late.theory)
    return check._replace(note=_joined(check.note, late.why))


def _joined(*notes):
    return ", ".join(filter(None, notes))


def _measured_only(run, claim, why):
    """Return what was measured of a claim that does not apply: a threshold is studied by it."""
    return measured_of(run, claim)._replace(passed=None, note="does not apply: {}".format(why))


def _skipped(claim, note):
    return Check(claim.name, claim.predicted, None, claim.tolerance, None, note=note)


def measured_of(run, claim):
    """Return the ``Check`` of ``claim`` on all of ``run``."""
    try:
        with np.errstate(all="ignore"):
            measured = _number(claim.measure(run))
        if measured is not None and not math.isfinite(measured):
            measured = None
    except NothingDecays as error:
        why = words(error) or "there is nothing to decay from this start"
        return _skipped(claim, "does not apply: {}".format(why))
    except Exception as error:  # what a person wrote may raise anything; the run is not lost for it
        print_raised(error)
        note = "{}: {}".format(BROKEN, named(error))
        return _skipped(claim, note)._replace(passed=False)
    return _compare(claim.name, claim.predicted, measured, claim.tolerance, claim.relation)


def _number(value):
    """Return a measured ``value`` as a plain number or None; ``ValueError`` for anything else."""
    if value is None or isinstance(value, (int, float)):
        return value
    if np.ndim(value) or not np.isrealobj(value):
        text = "measured {} of shape {}, wanted one number"
        raise ValueError(text.format(type(value).__name__, np.shape(value)))
    return float(value)


def _compare(name, predicted, measured, tolerance, relation):
    if measured is None:
        return Check(
            name, predicted, None, tolerance, False, note="could not be measured in this run"
        )
    difference = measured - predicted
    passed = bool(_excess(difference, relation) <= tolerance)
    note = "" if relation == "equal" else relation
    return Check(name, predicted, measured, tolerance, passed, difference, note)


def _excess(difference, relation):
    return {"equal": abs(difference), "at most": difference, "at least": -difference}[relation]


def versions() -> Dict[str, str]:
    """Return the versions of what makes a run what it is."""
    return dict(_versions())


@functools.lru_cache(maxsize=None)
def _versions():
    from importlib import metadata  # slow to import, wanted once a run

    found = {"mrs_simulator": __version__, "python": platform.python_version()}
    for name in VERSIONED:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def write_verdict(verdict, path):
    """Write ``verdict`` as JSON to ``path``, whole or not at all."""
    write_text(path, json.dumps(verdict, indent=2, allow_nan=False) + "\n")


def verdict_text(verdict):
    """Return the verdict as a short table for a terminal."""
    lines = ["{}: {}".format(verdict["title"] or "run", WORDS[outcome_of(verdict)])]
    if verdict.get("reason"):
        lines[0] += " ({})".format(verdict["reason"])
    width = max([32] + [len(check["name"]) for check in verdict["checks"]])
    row = "    {:" + str(width) + "} {:>" + str(CELL) + "} {:>" + str(CELL) + "} {:>10}  {}"
    lines.append(row.format("", "predicted", "measured", "tolerance", "").rstrip())
    for question in QUESTIONS:
        asked = [check for check in verdict["checks"] if check["question"] == question]
        lines += ["  " + _heading(question, verdict)] if asked else []
        lines += [row.format(check["name"], *_said(check)) for check in asked]
    lines += requirement_lines(verdict.get("requirements", []))
    if verdict["final_gaps"]:
        gaps = verdict["final_gaps"]
        shown = ", ".join("{:.4f}".format(gap) for gap in gaps[:12])
        lines.append("  final gaps [m]: {}{}".format(shown, ", ..." if len(gaps) > 12 else ""))
    if verdict["min_distance"] is not None:
        lines.append("  closest approach of two centres: {:.3f} m".format(verdict["min_distance"]))
    if verdict["real_time_factor"]:
        lines.append("  achieved real-time factor: {:.1f}".format(verdict["real_time_factor"]))
    lines += ["  warning: " + warning for warning in verdict["warnings"]]
    if outcome_of(verdict) in EXPLAINED:
        lines.append("  what this means: {}".format(EXPLAINED[outcome_of(verdict)]))
    return "\n".join(lines)


def _heading(question, verdict):
    """Return the ``question`` of a block of lines."""
    if not verdict.get("derived"):
        return ASKED[question]
    return (
        ASKED[question]
        .replace("theory hold", "its own linear theory hold")
        .replace("published", "derived")
    )


def _said(check):
    """Return predicted, measured and tolerance of a ``check``, and what is said of it."""
    cells = [_cell(check[key]) for key in ("predicted", "measured", "tolerance")]
    word = {True: "PASSED", False: "FAILED", None: "-"}[check["passed"]]
    said = " ".join(filter(None, (word, _note(check))))
    if len(cells[1]) > CELL:  # a text, such as why a run ended
        said, cells[1] = "{}: {}".format(said, cells[1]), ""
    return (*cells, said)


def _note(check):
    note = check.get("note", "")
    return "({})".format(note) if note else ""


def _cell(value):
    if value is None:
        return "-"
    if not isinstance(value, float):
        return str(value)
    return "{:.4f}".format(value) if abs(value) >= 1e-3 or value == 0.0 else "{:.2e}".format(value)


@printing
def main():
    """Print the verdict in the file that the command line names; exit as :func:`exit_code` says."""
    parser = argparse.ArgumentParser(description="Print a verdict.json as a table.")
    parser.add_argument("file")
    add_require_verdict(parser)
    arguments = parser.parse_args()
    try:
        verdict = read_verdict(arguments.file)
    except (OSError, ValueError) as error:
        print("verdict: {}: {}".format(arguments.file, reason(error)), file=sys.stderr)
        sys.exit(2)
    print(verdict_text(verdict))
    sys.exit(exit_code(verdict, arguments.require_verdict))


def add_require_verdict(parser):
    """Give ``parser`` the option ``--require-verdict``, which :func:`exit_code` takes."""
    text = "exit with {} where the run could not be judged".format(UNJUDGED_CODE)
    parser.add_argument("--require-verdict", action="store_true", help=text)


if __name__ == "__main__":
    main()
