"""Judging a run: which claims are made of it, and on which part of it they are judged."""

import contextlib
import copy
import functools

import numpy as np

from mrs_simulator.control.user_code import call, print_raised
from mrs_simulator.core.claims import Claim, Condition, proved, without_theorem
from mrs_simulator.core.doc_links import named
from mrs_simulator.core.sample_blocks import blocks
from mrs_simulator.core.stability import stability_measures
from mrs_simulator.protocols.making import make_control
from mrs_simulator.protocols.published.laws import Resumed
from mrs_simulator.record.recording import part_of
from mrs_simulator.record.run_changes import changed_by, changes_text
from mrs_simulator.scenario.scenario import FARTHEST
from mrs_simulator.verdict.certificates import BALANCE, certificate_claims
from mrs_simulator.verdict.derived.derived_theory import derived_control
from mrs_simulator.verdict.estimation import estimation_measures
from mrs_simulator.verdict.impossible_runs import impossibilities
from mrs_simulator.verdict.law.published_checks import (
    at_limit,
    delay_measures,
    exactness_claims,
    filter_acted,
    knows_noise,
)
from mrs_simulator.verdict.obedience import obedience_checks
from mrs_simulator.verdict.requirements.results import requirement_results
from mrs_simulator.verdict.safety_claims import safety_claims
from mrs_simulator.verdict.theory.exact_runs import exact_run, later, published_law, robots_run
from mrs_simulator.verdict.theory.meetings import meetings, theory_track
from mrs_simulator.verdict.theory.recorded_slip import run_with_recorded_slip
from mrs_simulator.verdict.theory.theorem import Ideal, Points
from mrs_simulator.verdict.user_values import claim_of, measures_of
from mrs_simulator.verdict.verdict import (
    FEWEST_SAMPLES,
    NOT_JUDGED,
    Late,
    Theory,
    judge,
    labelled,
    with_reason,
    with_requirements,
)

LONG = 1 << 21  # [-] robots over all samples, above which theory is drawn at some of these alone
MOST_DRAWN = 4000  # [-] of them: more than a figure has dots across
SHOWN = 5  # [-] a fifth of the run, at its end, over which the place where it ends is drawn
SHOWN_ROBOTS = 3  # [-] beside the one that lost most, by number
NARROWER = 0.1  # [-] of the tolerance of points, where the cost is known
CLOSE = 1e-6  # [m] to where theory has a point, within which it is there
LITTLE = 1e-3  # [m] of a path, that limits may cut off a rest of the run which is judged
FILTERED = "the safety filter acted"
NEARLY = 0.99  # [-] of how far robots may go at most
BESIDE = 1e-6  # [-] of a command period by which a sample may be beside a command
ESTIMATED = "the law knew estimates of the poses"
NOISY = (
    "the law saw wheel odometry with the errors of odometry_errors, which are not recorded; "
    "wanted estimates: odometry"
)
UNRECORDED = ESTIMATED + ", which the record does not hold"


def judged(run, control=None, foretold=None, derives=True):
    """Return the verdict on ``run`` and the hand points that theory predicts, as figures draw them.

    ``control`` makes the claims; requirements are those of the run's scenario.  The points are (m, n, d),
    or of a long run, or where only the end is known, a mapping of ``time`` and ``hand``, or None;
    ``foretold`` is called with them as soon as they are known.  ``derives``: a law that states no theory is
    judged by the linear one that follows from it, if any does.
    """
    verdict, track = _judged_by_theory(run, control, foretold, derives)
    return with_requirements(verdict, requirement_results(control, run)), track


@np.errstate(over="ignore", invalid="ignore")  # of recordings with numbers near the largest
def _judged_by_theory(run, control, foretold, derives):
    """Return the verdict without requirements, and the predicted points."""
    foretold = foretold or (lambda points: None)
    if control is None:
        foretold(None)
        return judge(run, guards=impossibilities(run)), None
    whole = run.in_space(control.dimension)
    unfit = _unfit(whole)
    if unfit:
        foretold(None)
        return judge(whole, unfit, guards=impossibilities(whole)), None
    control, run, changed = since_changes(control, whole)
    derived, why = derived_control(control, run) if derives else (None, "")
    control = control if derived is None else derived
    control.safety_filter.begin_scene(run.meta.get("scene_time", 0.0))
    faults, unpredicted, measures = [], [], {}
    track = None if changed.ruled_out else _track(control, run, unpredicted)
    if track is not None and run is not whole and not isinstance(track, dict):
        track = {"time": run.time, "hand": track}
    if track is not None:
        foretold(track)
    acted = filter_acted(control, run)
    if acted is None:  # a filter that is not asked costs derived theory nothing
        claims, theory = _claims(control if derived is None else _alone(control), run, faults)
    else:
        claims, theory = _unfiltered(control, run, acted, faults)
    if track is None:
        track = None if changed.ruled_out else _end_of(run, claims)
        foretold(track)
    if derives and acted is None and run is whole and _has_no_points(control, theory):
        theory = theory._replace(points=Ideal(control, run))
    theory = _joined(theory, changed)
    if derived is not None:
        # collisions that the law itself leads to are no less wrong, nor are ways to infinity
        theory = theory._replace(led=None)
    else:
        theory = theory._replace(leads_apart=_leads_apart(control, whole))
    with _keeping(faults, "measures"):
        measures, wrong = measures_of(call(control.measures, run))
        faults += _faults("measures", wrong)
    measures.update(estimation_measures(run))
    with _keeping(faults, "stability"):
        measures.update(call(stability_measures, control, run))
    if not run.meta.get("lockstep"):
        with _keeping(faults, "published"):
            measures.update(call(delay_measures, control, run))
    faults += unpredicted
    carried = _carried(control, run) or _unrecorded(run)
    if carried:
        theory = theory._replace(ruled_out=carried)
    guards = safety_claims(control, whole) + impossibilities(whole)
    obedience = functools.partial(obedience_checks, control)
    verdict = judge(whole, claims + faults, measures, guards, theory, obedience)
    if derived is not None:
        return labelled(verdict), track
    return (with_reason(verdict, why) if verdict["outcome"] == NOT_JUDGED else verdict), track


def _leads_apart(control, run):
    """Return whether its protocol predicts of a ``run`` that ended early that the team had gone too far."""
    if run.scenario is None or run.time[-1] >= run.scenario.duration - run.scenario.step:
        return False
    with _keeping([], "prediction"):  # whose faults are reported with the track
        next_sample = run.time[-1:] - run.time[0] + run.scenario.record_period
        track = call(control.predicted_track, run.hand[0], next_sample)
        return track is not None and bool(np.max(np.abs(track)) >= NEARLY * FARTHEST)
    return False


def _has_no_points(control, theory):
    """Return whether the law has no form on points, by which its theorem could be tested."""
    return theory.points is not None and theory.exact is None and published_law(control) is None


def since_changes(control, run):
    """Return ``(control, run, theory)`` of what is judged: the part after the last change on the way.

    ``theory``: its ``rest`` and ``why``; or why no claim applies, where the law remembers what was before
    or is another one, or too little is left.
    """
    changes = run.meta.get("changes")
    if not changes or run.scenario is None:
        return control, run, Theory()
    scenario, text = changed_by(run.scenario, changes), changes_text(run.scenario, changes)
    # A sample at the change itself may hold the command from before it.
    first = int(np.searchsorted(run.time - run.time[0], changes[-1].time + BESIDE, side="right"))
    begin = command_after(run.time, first, control.period)
    same = scenario.control.protocol == run.scenario.control.protocol
    known = same and control.MEMORYLESS and not control.links.faults
    if not known or begin + FEWEST_SAMPLES > len(run.time):
        return control, run, Theory(ruled_out=text)
    rest = part_of(run, slice(begin, None))._replace(scenario=scenario)
    why = "from {:.1f} s on; {}".format(rest.time[0], text)
    return make_control(scenario, type(control)), rest, Theory(rest=rest, why=why)


def _joined(theory, changed):
    """Return ``theory`` of the part of a run that ``changed`` has left to be judged."""
    if changed.ruled_out:
        return theory._replace(ruled_out=changed.ruled_out)
    if changed.rest is None:
        return theory
    why = "; ".join(filter(None, (theory.why, changed.why)))
    return theory._replace(rest=changed.rest if theory.rest is None else theory.rest, why=why)


def _unfit(run):
    """Return which conditions of any claim ``run`` does not keep, a list of ``Condition``."""
    count = len(run.time)
    lost = np.empty(count, dtype=bool)
    for rows in blocks(count, len(run.robots)):
        lost[rows] = ~np.isfinite(run.hand[rows]).all(axis=(1, 2))
    when = "not at {:g} s".format(run.time[np.argmax(lost)] - run.time[0])
    conditions = (
        Condition("two samples", count > 1, "there is {}".format(count)),
        Condition("places of all robots", not lost.any(), when),
    )
    return [condition for condition in conditions if not condition.holds]


def _unrecorded(run):
    """Return a text where the record lacks estimates of poses, else ""."""
    estimated = run.scenario is not None and run.scenario.estimates is not None
    return UNRECORDED if estimated and run.estimate is None else ""


def _carried(control, run):
    """Return what moves robots of ``run`` besides their commands, in words, or ""."""
    if run.scenario is None or all(g.drive.MEDIUM != "water" for g in control.team.groups):
        return ""
    environment = run.scenario.environment
    if any(environment.current) and not control.IN_CURRENT:
        return "the current carries the robots"
    if run.scenario.fidelity == "dynamic" and (any(environment.wind) or environment.wave_height):
        return "wind and waves push the robots"
    return ""


def _unfiltered(control, run, acted, faults):
    """Return ``(claims, theory)`` on what comes after the sample ``acted``, the safety filter's last.

    There the law alone moves the robots.  What it remembers then is not known, so that of a law with a
    memory, or where nothing comes after, no claim applies.
    """
    # it may have acted between two samples
    begin = command_after(run.time, acted + 2, control.period)
    if not control.MEMORYLESS or control.links.faults or begin + FEWEST_SAMPLES > len(run.time):
        claims, theory = _claims(control, run, faults)
        return claims, theory._replace(ruled_out=FILTERED)
    rest = part_of(run, slice(begin, None))
    claims, theory = _claims(_alone(control), rest, faults)
    why = "from {:.1f} s on, after {}".format(rest.time[0], FILTERED)
    return claims, theory._replace(rest=rest, why=why)


def _alone(control):
    """Return a copy of ``control`` without the safety filter."""
    alone = copy.copy(control)
    alone._keep(safety=False)
    alone.safety_filter.acts = False
    return alone


def command_after(time, row, period):
    """Return the first sample from ``row`` on at a command, of which one comes every ``period`` [s].

    ``time`` (m,) [s] of the samples, the first of which is at a command; ``row`` itself where none is.
    """
    turns = (time[row:] - time[0]) / period
    found = np.flatnonzero(np.abs(turns - np.rint(turns)) < BESIDE)
    return row + int(found[0]) if len(found) else row


def _claims(control, run, faults, followed=None, balanced=True):
    """Return ``(claims, theory)`` on ``run``: all that are made, and the ``Theory`` beside them.

    ``followed``: the run of the robots under the published law, if it is known already; ``balanced``:
    whether the energy's balance is claimed.
    """
    claims, theory = None, Theory()
    with _keeping(faults, "claims"):
        claims = checked_claims(call(control.all_claims, run.hand[0]), run, faults)
    raised, claims = claims is None, claims or []
    with _keeping(faults, "energy"):
        claims = claims + call(certificate_claims, control, run, balanced)
    if run.estimate is not None:
        claims = without_theorem(claims, ESTIMATED)
    elif knows_noise(run):
        claims = without_theorem(claims, NOISY)
    with _keeping(faults, "published"):
        exact = call(exact_run, control, run)
        followed = call(robots_run, control, run) if followed is None else followed
        slipped, known = None, followed
        if control.fidelity == "dynamic":
            slipped = known = call(run_with_recorded_slip, control, run)
        claims = claims + call(exactness_claims, control, run, exact, followed)
        made = {} if raised else _claims_with(control, run, fidelity="point_mass")
        points = Points(control, run, exact, made)
        narrow = _narrow(made) if known is not None and run.meta.get("lockstep") else {}
        gripping = _gripping(control, run) if slipped is not None else None
        theory = Theory(exact, followed, slipped, narrow, points=points, gripping=gripping)
        if control.deadband and not raised:
            unbanded = _claims_with(control, run)
            theory = theory._replace(unbanded={name: c.tolerance for name, c in unbanded.items()})
    # Of what is left of a run after a change, none may have come.
    if run.collisions and run.collisions[-1].time >= run.time[0]:
        with _keeping([], "prediction"):  # whose faults are reported with the track
            theory = theory._replace(led=_led(control, run, theory, claims))
    late = any(
        isinstance(claim, Claim) and claim.name == BALANCE and claim.free for claim in claims
    )
    return claims, _limited(control, run, theory, late)


def _gripping(control, run):
    """Return the function that returns the run of robots whose wheels grip as declared, made when asked."""
    return functools.lru_cache(maxsize=1)(lambda: call(robots_run, control, run, True))


def _led(control, run, theory, claims):
    """Return the pairs of rows that theory leads together, as :func:`meetings` does.

    Of points, at each command until the last collision, and of robots, which within limits meet
    elsewhere.
    """
    tracks, last = [theory_track(control, run, theory.exact, claims)], run.collisions[-1].time
    if theory.exact is not None:
        count = min(int((last - run.time[0]) / control.period) + 2, MOST_DRAWN)
        time = run.time[0] + control.period * np.arange(count)
        between = call(exact_run, control, run._replace(time=time))
        tracks += [] if between is None else [(between.hand, time)]
    if theory.followed is not None:
        tracks.append((theory.followed.hand, run.time))
    found = [meetings(control.team, *track) for track in tracks if track]
    return {pair: when for each in found for pair, when in each.items()}


def _claims_with(control, run, **other):
    """Return the claims that ``control`` makes of ``run`` with ``other`` attributes, by name.

    Of points with the tolerances typed for them.  What a dead band costs robots that are followed is in
    their run already.
    """
    own = copy.copy(control)
    own._keep(deadband=0.0, **other)
    made = checked_claims(call(own.all_claims, run.hand[0]), run, [])
    return {claim.name: claim for claim in made if isinstance(claim, Claim)}


def _narrow(claims):
    """Return the tolerances of ``claims`` of points for robots whose run is known, by name.

    Where the motion of these robots is known to rounding, so is what held commands, limits and slip cost,
    and of what points are allowed, for ends and sampling, little is left to allow.
    """
    allowed = {name: claim.tolerance for name, claim in claims.items()}
    return {name: max(NARROWER * most, min(most, CLOSE)) for name, most in allowed.items()}


def _limited(control, run, theory, balanced):
    """Return ``theory`` with who was at a limit, and with what is judged then.

    ``balanced``: whether the energy's balance is: one that takes commands as they are is judged of all.
    """
    followed, cut = theory.followed, None
    if followed is None:
        limited = np.zeros(run.hand.shape[:2], dtype=bool)
        if control.saturation != "none":
            limited = at_limit(control, run)
    else:
        limited, cut = followed.meta["limited"], followed.meta["cut"]
        sure = run.meta.get("lockstep") and control.fidelity != "dynamic"
        if sure and cut[-1].max() <= LITTLE:
            return theory
        limited = limited if sure else limited | at_limit(control, run)
    if not limited.any():
        return theory
    if followed is None and control.saturation == "team" and not control.MEMORYLESS:
        return theory  # one factor for all only re-times the motion
    made = functools.partial(_late, control, run, limited, theory, balanced)
    late = functools.lru_cache(maxsize=1)(made)
    return theory._replace(limited=_who(run, limited, cut), late=late)


def _who(run, limited, cut):
    """Return which robots were at a limit, ``limited`` (m, n) bool, and what that took from their paths.

    ``cut``: (m, n) [m] until each sample, or None where it is not known.
    """
    often = limited.sum(axis=0)
    worst = int(np.argmax(often if cut is None else np.where(often > 0, cut[-1], -1.0)))
    at = run.time[np.flatnonzero(limited[:, worst])[-1]]
    others = [row for row in np.flatnonzero(often).tolist() if row != worst]
    text = "robot{} was at its limits until {:.1f} s".format(run.robots[worst], at)
    if cut is not None:
        text += ", which cut {:.2g} m off its path".format(cut[-1, worst])
    also = ", ".join("robot{}".format(run.robots[row]) for row in others[:SHOWN_ROBOTS])
    if not also:
        return text
    more = ", ..." if len(others) > SHOWN_ROBOTS else ""
    end = run.time[np.flatnonzero(limited[:, others].any(axis=1))[-1]]
    later = " until {:.1f} s".format(end) if end > at else ""
    return "{} (and {}{}{})".format(text, also, more, later)


def _late(control, run, limited, theory, balanced, little=LITTLE):
    """Return the ``Late`` part of a run in which robots were at limits, ``limited`` (m, n) bool.

    It begins where limits cut off no more than ``little`` [m] of a path any more; its ``again`` begins
    after the last limit of all.
    """
    whole, at, followed = theory, limited.any(axis=1), theory.followed
    cut = None if followed is None else followed.meta["cut"]
    if cut is not None:  # what still is cut off later is no more than the rest is judged with
        at &= (cut[-1] - cut).max(axis=1) > little
    last = int(np.flatnonzero(at if at.any() else limited.any(axis=1))[-1])
    begin = _next_command(control, run, last + 1)
    other = None if begin is None else _resumed(control, run, begin, theory)
    if other is None:
        return Late(_who(run, limited, cut))
    rows = slice(begin, None)
    rest = part_of(run, rows)
    known = _is_where(theory, run, begin)
    left = later(followed, rows) if known else None
    claims, theory = _claims(other, rest, [], left, balanced)
    after = _who(run, limited[: last + 1], None if cut is None else cut[: last + 1])
    why = "from {:.1f} s on, after {}".format(rest.time[0], after)
    theory, again = theory._replace(limited="", late=None), None
    if little and cut is not None and limited[begin:].any():
        why += "; limits cut {:.2g} m at most off a path later".format((cut[-1] - cut[begin]).max())
        made = functools.partial(_late, control, run, limited, whole, balanced, 0.0)
        again = functools.lru_cache(maxsize=1)(made)
    return Late(why, rest, {claim.name: claim for claim in claims}, theory, again)


def _next_command(control, run, first):
    """Return the first sample from ``first`` on that falls on a command; None if too few are left."""
    if control.links.faults or first + FEWEST_SAMPLES > len(run.time):
        return None
    if control.MEMORYLESS:
        return first
    count = (run.time[first:] - run.time[0]) / control.period
    whole = np.flatnonzero(np.abs(count - np.round(count)) < CLOSE * np.maximum(count, 1.0))
    found = first + int(whole[0]) if len(whole) else len(run.time)
    return found if found + FEWEST_SAMPLES <= len(run.time) else None


def _is_where(theory, run, row):
    """Return whether the robots are in the sample ``row`` where the followed ones are."""
    followed = theory.followed
    return bool(theory.narrow) and np.abs(followed.hand[row] - run.hand[row]).max() < CLOSE


def _resumed(control, run, row, theory):
    """Return the control by which the rest of ``run`` from the sample ``row`` on is judged, or None.

    What a law remembers then is known where it is the time alone, and of robots that are where theory
    has them.
    """
    if control.MEMORYLESS:
        return control
    law, memory = published_law(control), None
    if _is_where(theory, run, row):
        memory = theory.followed.meta["memory"][row]
    elif law is None or law.SEES not in ("now", "pose"):
        return None
    time = run.time[row] - run.time[0]
    rest = call(control.resumed, time, memory)
    if rest is None:
        return None
    rest._keep(published=lambda: Resumed(law, time, memory))
    return rest


def checked_claims(claims, run, faults):
    """Return the ``claims`` that can be judged, with plain values; others are added to ``faults``."""
    kept, wrong = [], []
    for claim in claims:
        try:
            kept.append(claim_of(claim, run.hand.shape[1:]))
        except (TypeError, ValueError) as error:
            wrong.append(str(error))
    faults += _faults("claims", wrong)
    return kept


def _track(control, run, faults):
    """Return the predicted hand points (m, n, d) [m], of a long run a mapping of some, or None."""
    track, last = None, len(run.time) - 1
    count = last + 1 if run.hand[..., 0].size <= LONG else min(last + 1, MOST_DRAWN)
    rows = np.unique(np.linspace(0, last, count).round().astype(int))
    wanted = rows.shape + run.hand.shape[1:]
    with _keeping(faults, "prediction"):
        given = call(control.predicted_track, run.hand[0], run.time[rows] - run.time[0])
        if given is not None and np.shape(given) != wanted:
            raise ValueError("shape {}, wanted {}".format(np.shape(given), wanted))
        track = None if given is None else np.asarray(given, dtype=float)
    if track is None or len(rows) > last:
        return track
    return {"time": run.time[rows], "hand": track}


@contextlib.contextmanager
def _keeping(faults, method):
    """Add to ``faults`` that the protocol's ``method`` raised: the run is not lost for it."""
    try:
        yield
    except Exception as error:
        print_raised(error)
        faults += _faults(method, [named(error)])


def _faults(method, texts):
    """Return the check that fails where the protocol's ``method`` does what ``texts`` say, a list."""
    name = "{}() returns".format(method)
    return [Condition(name, False, "; ".join(texts), rules_out=False)] if texts else []


def _end_of(run, claims):
    """Return the place where ``claims`` say that the run ends, over its last samples, or None."""
    for claim in proved(claims):
        if claim.place is not None:
            begin = len(run.time) - 1 - len(run.time) // SHOWN
            hand = np.broadcast_to(claim.place, (2,) + run.hand.shape[1:])
            return {"time": run.time[[begin, -1]], "hand": hand}
    return None
