"""How the claims of a run stand while it goes on, beside the theory of all of it, which is made once."""

import numpy as np

from mrs_simulator.control.user_code import call
from mrs_simulator.core.claims import ROBOTS, THEOREM, Condition
from mrs_simulator.record.recording import part_of
from mrs_simulator.verdict.judging import checked_claims, since_changes
from mrs_simulator.verdict.requirements.results import bound_of, evaluated, line_of
from mrs_simulator.verdict.safety_claims import safety_claims
from mrs_simulator.verdict.theory.exact_runs import exact_run, robots_run
from mrs_simulator.verdict.theory.meetings import meetings
from mrs_simulator.verdict.user_values import plain
from mrs_simulator.verdict.verdict import (
    BROKEN,
    FEWEST_SAMPLES,
    HOLDS,
    LED,
    first_break,
    margin_of,
    measured_of,
    pairs_of,
)

STANDS = ON_COURSE, FAILING, OPEN, NOT_JUDGED = (
    "on course",
    "failing",
    "not yet decidable",
    "does not apply",
)
THEORY_SAMPLES = 1000  # [-] of the run that theory gives
SHARES = 1.0, 0.5, 0.25, 0.125  # [-] of the duration that it covers, the first that it can
BEYOND = 1e-6  # [s] of its end
BEHIND = 0.1  # [-] of the time so far, by which a run may be later than theory before it fails
THERE, BESIDE = "shown by now", "as theory has it by now: {:.4g}"
AWAITED = "theory does not show it yet either, and has {:.4g} by now"
LATE = "theory has shown it since {:.1f} s"
LEFT = "it was shown before"
SOON = "too little of the run is known"


class Course:
    """The claims of one run, and the theory beside it, from its first sample on."""

    def __init__(self, control, run):
        """``run``: as it has begun; what theory gives is of the whole duration of its scenario."""
        self._control, self._shown = control, set()
        self._led = None  # pairs of rows that theory leads together, once that is asked
        self._claims = checked_claims(call(control.all_claims, run.hand[0]), run, [])
        end = run.time[0] + max(run.scenario.duration, run.time[-1] - run.time[0])
        self._theory = _theory_of(control, run, end)

    def standings(self, run):
        """Return how each claim stands in ``run`` so far, a list of mappings with the keys of a check and:

        ``standing``: one of ``STANDS``; ``margin``: what the claim has to spare in its unit, less than 0
        where it is missed, of a requirement its robustness in its ``unit``; None where that is not known.
        """
        conditions = [each for each in self._claims if isinstance(each, Condition)]
        broken = [each.name for each in conditions if each.rules_out and not each.holds]
        rows = list(map(_condition, conditions))
        unproved = "{} does not hold".format(", ".join(broken)) if broken else ""
        stopped = first_break(run)
        for claim in [*self._claims, *safety_claims(self._control, run)]:
            if isinstance(claim, Condition):
                rows += [] if claim in conditions else [_condition(claim)]
                continue
            why = claim.unproved or (unproved if claim.question == THEOREM else "")
            if not why and stopped is not None and claim.motion and claim.question == THEOREM:
                why = "{1} at {0:.1f} s".format(*stopped)
            rows.append(self._standing(run, claim, why))
        rows.append(self._collisions(run))
        return plain(
            rows + list(map(_requirement, evaluated(self._control, run, goes_on=True))), "standings"
        )

    def _collisions(self, run):
        """Return the row of the collisions; those to which theory leads the robots are not judged."""
        row = _collisions(run)
        if self._theory is None or not run.collisions or np.any(self._control.safety):
            return row
        if self._led is None:
            team, theory = self._control.team, self._theory
            self._led = set(meetings(team, theory.hand, theory.time))
        if not pairs_of(run) <= self._led:
            return row
        note = ", ".join((row["note"], LED))
        return {**row, "standing": NOT_JUDGED, "passed": None, "margin": None, "note": note}

    def _standing(self, run, claim, why):
        if len(run.time) < FEWEST_SAMPLES:
            unmeasured = measured_of(None, claim._replace(measure=lambda run: None))
            return _row(unmeasured, claim.question, OPEN, SOON)
        check = measured_of(run, claim)
        if why:
            return _row(check, claim.question, NOT_JUDGED, "does not apply: " + why)
        if check.passed is None or check.note.startswith(BROKEN):
            stands = FAILING if check.note.startswith(BROKEN) else OPEN
            return _row(check, claim.question, stands, check.note)
        if check.passed:
            self._shown.add(claim.name)
            return _row(check, claim.question, ON_COURSE, THERE)
        return self._beside_theory(run, claim, check)

    def _beside_theory(self, run, claim, check):
        """Return the row of a ``claim`` that the run does not show now."""
        if self._theory is None or run.time[-1] > self._theory.time[-1] + BEYOND:
            stands, note = (FAILING, LEFT) if claim.name in self._shown else (OPEN, "")
            return _row(check, claim.question, stands, note)
        now, lasted = run.time[-1], run.time[-1] - run.time[0]
        theory = measured_of(_until(self._theory, now), claim)
        early = now - BEHIND * lasted
        if measured_of(_until(self._theory, early), claim).passed and theory.passed:
            return _row(check, claim.question, FAILING, LATE.format(early))
        if theory.measured is None or check.measured is None:
            return _row(check, claim.question, OPEN, check.note)
        off = claim.tolerance - abs(check.measured - theory.measured)
        if off >= 0.0:
            row = _row(check, claim.question, ON_COURSE, BESIDE.format(theory.measured))
            return {**row, "margin": off}
        return _row(check, claim.question, OPEN, AWAITED.format(theory.measured))


def standings(control, run, known=None):
    """Return the :meth:`Course.standings` of ``run`` so far, and the ``Course`` for the next time.

    ``known``: that of the last time, None the first time.  After a change of gains or edges what comes
    after it is looked at, by the theory of that.  Raises what the law raises.
    """
    control, rest, theory = since_changes(control, run.in_space(control.dimension))
    if theory.ruled_out:
        row = dict.fromkeys(("predicted", "measured", "difference", "tolerance", "margin"))
        row.update(question=THEOREM, name="claims", passed=None, standing=NOT_JUDGED)
        return [{**row, "note": "does not apply: " + theory.ruled_out}, _collisions(run)], None
    begun = rest.time[0], len(run.meta.get("changes") or ())
    course = known[1] if known is not None and known[0] == begun else Course(control, rest)
    rows = course.standings(rest)
    if theory.why:
        rows = [{**row, "note": ", ".join(filter(None, (row["note"], theory.why)))} for row in rows]
    return rows, (begun, course)


def _theory_of(control, run, end):
    """Return the run of theory from where ``run`` begins to ``end`` [s], or a part of it, or None."""
    lasts = end - run.time[0]
    for share in SHARES:
        time = np.linspace(run.time[0], run.time[0] + share * lasts, THEORY_SAMPLES)
        ahead = run.replace(time=time)
        found = call(robots_run, control, ahead) or call(exact_run, control, ahead)
        if found is not None:
            return found
    return None


def _until(run, time):
    """Return ``run`` until ``time`` [s], which is its last sample, interpolated between two of them."""
    row = int(np.searchsorted(run.time, time, side="right"))
    if row >= len(run.time):
        return run
    row = max(1, row)
    share = (time - run.time[row - 1]) / (run.time[row] - run.time[row - 1])
    part = part_of(run, slice(0, row + 1))
    at = {"time": run.time, "hand": run.hand, "pose": run.pose}
    ends = {key: each[row - 1] + share * (each[row] - each[row - 1]) for key, each in at.items()}
    cut = {key: np.concatenate([each[:row], ends[key][np.newaxis]]) for key, each in at.items()}
    return part.replace(**cut)


def _row(check, question, standing, note):
    if standing == ON_COURSE and check.note in ("at most", "at least"):
        note = "{}, {}".format(check.note, note)
    return {
        **check._asdict(),
        "question": question,
        "passed": {ON_COURSE: True, FAILING: False}.get(standing),
        "note": note,
        "standing": standing,
        "margin": margin_of(check._asdict()),
    }


def _condition(condition):
    """Return the row of a ``condition``, which holds or does not from the start."""
    stands = ON_COURSE if condition.holds else FAILING
    if not condition.holds and condition.rules_out and not condition.necessary:
        stands = NOT_JUDGED
    row = dict.fromkeys(("difference", "tolerance", "margin"))
    measured = HOLDS if condition.holds else "does not hold"
    row.update(name=condition.name, predicted=HOLDS, measured=measured, question=THEOREM)
    passed = {ON_COURSE: True, FAILING: False}.get(stands)
    return {
        **row,
        "passed": passed,
        "standing": stands,
        "note": condition.why * (not condition.holds),
    }


def _collisions(run):
    """Return the row of the collisions so far."""
    count = len(run.collisions)
    note = "{} and {} at {:.1f} s".format(*_named(run.collisions[0])) if count else ""
    return {
        "name": "collisions",
        "predicted": 0,
        "measured": count,
        "difference": count,
        "tolerance": 0,
        "margin": -count,
        "question": ROBOTS,
        "passed": not count,
        "note": note,
        "standing": FAILING if count else ON_COURSE,
    }


def _named(collision):
    return collision.first, collision.second, collision.time


def _requirement(result):
    """Return the row of a requirement's ``result``: met and broken ones are decided."""
    row = dict.fromkeys(("predicted", "measured", "difference", "tolerance"))
    note = line_of(result)
    if result["met"] is None:
        note = result["note"] or "undecided by now: " + result["formula"]
    row.update(name=result["name"], question="requirement", passed=result["met"])
    row.update(margin=bound_of(result), unit=result["unit"], note=note)
    row.update(time=result["time"], member=result["member"])
    return {**row, "standing": {True: ON_COURSE, False: FAILING, None: OPEN}[result["met"]]}
