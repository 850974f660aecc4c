"""Judging a run: which claims are made of it, and on which part of it they are judged."""

import contextlib
import traceback

import numpy as np

from mrs_simulator.control.laws.exactness import (
    at_limit,
    exact_run,
    exactness_claims,
    filter_acted,
    held_arcs,
)
from mrs_simulator.control.user_code import call
from mrs_simulator.core.claims import Claim, Condition
from mrs_simulator.core.stability import stability_measures
from mrs_simulator.core.verdict import Late, judge
from mrs_simulator.study.certificates import certificate_claims
from mrs_simulator.study.possible_runs import impossibilities
from mrs_simulator.study.safety_claims import safety_claims

SHOWN = 5  # [-] a fifth of the run, at its end, over which the place where it ends is drawn
FILTERED = "the safety filter acted"


def judged(run, control=None):
    """Return the verdict on ``run`` and the hand points that theory predicts, as figures draw them.

    ``control`` makes the claims.  The points are (m, n, 2), or where only the end is known a mapping of
    ``time`` and ``hand``, or None.
    """
    if control is None:
        return judge(run, guards=impossibilities(run)), None
    faults, measures = [], {}
    claims, exact = _claims(control, run, faults)
    with _keeping(faults, "measures"):
        measures = call(control.measures, run)
    with _keeping(faults, "stability"):
        measures.update(call(stability_measures, control, run))
    track = _track(control, run, faults)
    ruled_out = FILTERED if filter_acted(control, run) else ""
    verdict = judge(
        run,
        claims + faults,
        measures,
        safety_claims(control, run.hand[0]) + impossibilities(run),
        _late(control, run),
        exact,
        ruled_out,
    )
    return verdict, _end_of(run, claims) if track is None else track


def _claims(control, run, faults):
    """Return ``(claims, exact)`` on ``run``: all that are made, and the exact solution or None."""
    claims, exact = [], None
    with _keeping(faults, "claims"):
        claims = _checked(call(control.all_claims, run.hand[0]), faults)
    with _keeping(faults, "energy"):
        claims = claims + call(certificate_claims, control, run)
    with _keeping(faults, "published"):
        exact = call(exact_run, control, run)
        claims = claims + [
            claim._replace(tolerance=claim.tolerance + held_arcs(control, run))
            if claim.free
            else claim
            for claim in call(exactness_claims, control, run, exact)
        ]
    return claims, exact


def _checked(claims, faults):
    """Return those of ``claims`` that are such; what else is among them goes to ``faults``."""
    kept = []
    for claim in claims:
        if isinstance(claim, (Claim, Condition)):
            kept.append(claim)
            continue
        with _keeping(faults, "claims"):
            raise TypeError("{:.60} among them, wanted Claims and Conditions".format(repr(claim)))
    return kept


def _track(control, run, faults):
    """Return the predicted hand points (m, n, 2) [m], or None."""
    track = None
    with _keeping(faults, "prediction"):
        track = call(control.predicted_track, run.hand[0], run.time - run.time[0])
        if track is not None and np.shape(track) != run.hand.shape:
            came, track = np.shape(track), None
            raise ValueError("shape {}, wanted {}".format(came, run.hand.shape))
    return track


def _late(control, run):
    """Return the ``Late`` part of a run in which a robot was at a limit, None if none was."""
    if control.saturation == "none":
        limited = np.zeros(len(run.time), dtype=bool)
    else:
        limited = at_limit(control, run.command).any(axis=1)
    if not limited.any():
        return None
    if control.saturation == "team" and not control.MEMORYLESS:
        return None  # one factor for all only re-times the motion
    last = int(np.flatnonzero(limited)[-1])
    at = run.time[last] - run.time[0]
    if not control.MEMORYLESS or control.links.faults or last + 2 >= len(run.time):
        return Late("a robot was at its speed limit until {:.1f} s".format(at))
    rest = run._replace(**{
        name: getattr(run, name)[last + 1 :] for name in ("time", "pose", "hand", "command")
    })  # fmt: skip
    claims, exact = _claims(control, rest, [])
    why = "from {:.1f} s on, after the last time at a speed limit".format(at)
    return Late(why, rest, {claim.name: claim for claim in claims}, exact)


def proved(claims):
    """Return those of ``claims`` that theory stands for; none where a condition does not hold."""
    if any(isinstance(claim, Condition) and not claim.holds for claim in claims):
        return []
    return [claim for claim in claims if not isinstance(claim, Condition) and not claim.unproved]


@contextlib.contextmanager
def _keeping(faults, method):
    """Add to ``faults`` that the protocol's ``method`` raised: the run is not lost for it."""
    try:
        yield
    except Exception as error:
        traceback.print_exc()
        text = "{}: {}".format(type(error).__name__, error)
        faults.append(Condition("{}() returns".format(method), False, text, rules_out=False))


def _end_of(run, claims):
    """Return the place where ``claims`` say that the run ends, over its last samples, or None."""
    for claim in proved(claims):
        if claim.place is not None:
            begin = len(run.time) - 1 - len(run.time) // SHOWN
            hand = np.broadcast_to(claim.place, (2,) + run.hand.shape[1:])
            return {"time": run.time[[begin, -1]], "hand": hand}
    return None
