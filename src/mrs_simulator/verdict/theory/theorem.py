"""Whether claims hold of the law itself: on the exact solution, followed until it has settled."""

import collections
import copy
from typing import NamedTuple

import numpy as np

from mrs_simulator.control.user_code import call
from mrs_simulator.core.claims import RATE_FLOOR, TooShort, slope
from mrs_simulator.protocols.published.laws import MOST_COMMANDS, Steps
from mrs_simulator.record.recording import part_of
from mrs_simulator.verdict.theory.exact_runs import exact_run, published_law
from mrs_simulator.verdict.verdict import BROKEN, FEWEST_SAMPLES, measured_of

SETTLED = 1e-3  # [-] of its tolerance, by which what has settled changes at most while time doubles
STEEP = 0.01  # [-] of the change before, below which a change shows that a decay is over
BETWEEN = 0.6, 0.7, 0.8, 0.9  # [-] of a solution, where what has settled is the same
SOONEST = 5.0  # [s] before which nothing counts as settled
LOOKED_BACK = 2  # times that a run is halved, to see whether its end has changed since
FEWEST_SEEN = 20  # [-] samples of a run of which earlier parts are looked at
MOST_PAIRS = 2e7  # [-] pairs of robots over all commands of the longest solution: a second or two
MOST_SAMPLES = 40000  # [-] of a longer solution
NUDGE = 1e-9  # [m] by which a start is moved to see whether the solution is chaotic
ASIDE = 1e-3  # [-] of the team's size, by which a start is moved to contain all modes
RICHER = 12  # times at most that a start beside is made of what is left late of the one before
ALIKE = 0.03  # [-] of a rate's tolerance, by which that changes no more with the last of these
SIMPLE = 0.15  # [-] of a rate's miss, by which it may differ between two parts of a simple decay
PARTS = (1e-3, 1e-6, RATE_FLOOR)  # [-] of the start, between which the two parts lie
FEWEST_FITTED = 12  # [-] samples of a fitted rate
FALSE = "false of the law itself: {} from this start {}"
HELD = "false by held commands: {} {}, and {} with {} times the commands"
OFTENER = 2, 4, 8  # times as many commands, with which a claim may hold
SLOWLY_HELD = "false by held commands: {} {}, {}, and comes to {:.4g} as their period goes to 0"
FINER = 1, 2, 4  # times as many commands, of whose three values a parabola in the period is made
# its value at 0, from theirs: Richardson's extrapolation
AT_ZERO = np.array([1.0, -6.0, 8.0]) / 3.0
LOOKED_AT = 16  # [-] times as long a solution at least, of whose parts finer commands are looked at
SHRINKS = 0.75  # [-] of a miss, that half the period leaves at most where the period is to blame
SHORT = "run too short for this claim: {} s are needed, {} s were run"
OPEN = "run too short for this claim: {} {}"
OUTSIDE = "does not apply: {}"
CHAOTIC = "does not apply: {} misses it, and is chaotic from this start"
BY_CHANCE = "run too short for this claim, or chance: the exact solution with this seed {}"
NO_RATE = "does not apply: the exact solution shows no rate for long enough"
NOT_SIMPLE = "does not apply: the exact solution shows no simple rate, {:.4g} and later {:.4g}"
LATER = "does not apply: the exact solution shows this rate late, {:.4g}"
LACKING = "does not apply: this start lacks the slowest mode; one beside it decays by {:.4g} /s"


class Answer(NamedTuple):
    """What the law itself makes of a claim: ``holds``, False of a false one, None of an open one.

    ``note``: why; ``needed``: how long a run [s] shows the claim, None where that is not known.
    """

    holds: object
    note: str = ""
    needed: object = None


HOLDS = Answer(True)


class Points:
    """The points that the published law moves from the start of ``run``, for as long as claims want.

    ``exact``: their run over the samples of ``run``, or None; ``claims``: those made of points, by name.
    """

    WHO = "the exact solution"

    def __init__(self, control, run, exact, claims):
        self.control, self.run, self.exact, self.claims = control, run, exact, claims
        self._longer, self._answers = {}, {}
        self._steps = collections.defaultdict(Steps)  # by how many times as many commands

    def answer(self, claim):
        """Return the ``Answer`` on ``claim``."""
        if claim.name not in self._answers:
            self._answers[claim.name] = self._answered(self.claims.get(claim.name, claim))
        return self._answers[claim.name]

    def _answered(self, claim):
        if self.exact is None or claim.unproved:
            return HOLDS
        check = measured_of(self.exact, claim)
        if check.passed is not False or check.note.startswith(BROKEN):
            return HOLDS
        if self._is_random():
            if self._waits(claim):
                return Answer(False, FALSE.format(self.WHO, _had(check)))
            return Answer(None, BY_CHANCE.format(_had(check)))
        back = LOOKED_BACK if len(self.exact.time) >= FEWEST_SEEN else 0
        seen = [measured_of(self._until(2.0**-k), claim) for k in range(back, 0, -1)]
        return self._followed(claim, [*seen, check])

    def _followed(self, claim, seen):
        """Return the answer on a ``claim`` that the solution misses, ``seen`` so far."""
        share, run, last = 1.0, self.exact, seen[-1]
        while True:
            if claim.decays is not None and _has_decayed(claim.decays(run.hand)):
                return self._decays_otherwise(claim, run, share)
            late = claim.decays is None and self._lasted(share) >= SOONEST
            if late and _has_settled(seen) and _stays(run, claim, last):
                return self._false(claim, share, last)
            longer = self._for(2.0 * share)
            if longer is None:
                break
            share, run, last = 2.0 * share, longer, measured_of(longer, claim)
            seen.append(last)
            if last.passed:
                needed = self._first(run, claim)
                return Answer(None, SHORT.format(_rounded(needed), self._ran()), needed)
            if last.passed is None or last.note.startswith(BROKEN):
                return Answer(None, OPEN.format(self.WHO, _had(last)))
        if claim.decays is None and _grows(seen) and self._lasted(share) >= SOONEST:
            return self._false(claim, share, last)
        text = _had(last) + " after {} s".format(_rounded(self._lasted(share)))
        return Answer(None, OPEN.format(self.WHO, text))

    def _false(self, claim, share, last):
        """Return the ``Answer`` that ``claim`` is false, as ``last`` shows, or that this is not known."""
        beside = np.zeros(self.run.hand.shape[1:])
        beside[:, 0] = NUDGE * (-1.0) ** np.arange(len(beside))
        nudged = self._for(share, beside)
        off = None if nudged is None else measured_of(nudged, claim)
        if off is None or not _same(off, last, claim.tolerance):
            return Answer(None, CHAOTIC.format(self.WHO))
        why = "" if claim.outside is None else call(claim.outside, self._for(share).hand[-1])
        if why:
            return Answer(None, OUTSIDE.format(why))
        said = _had(last) + " after {} s".format(_rounded(self._lasted(share)))
        return self._falsified(claim, share, said)

    def _falsified(self, claim, share, said):
        """Return that ``claim`` is false, as is ``said``: of the law, or where it is held so long.

        Neutral modes drift as long as commands are held at all, in longer runs by more: parts of it are
        looked at, too.
        """
        held = self._held(claim, share, said)
        if held:
            return Answer(False, held)
        part = 1.0
        while part == 1.0 or part <= share / LOOKED_AT:
            slowly = self._slowly_held(claim, part)
            if slowly:
                return Answer(False, slowly)
            part *= 2.0
        return Answer(False, FALSE.format(self.WHO, said))

    def _held(self, claim, share, said):
        """Return that ``claim``, of which ``said`` is so, holds with more commands, in words, or ""."""
        before = measured_of(self._for(share), claim)
        for times in OFTENER:
            run = self._for(share, commands=times)
            found = None if run is None else measured_of(run, claim)
            if found is None or _same(found, before, claim.tolerance):
                return ""
            if found.passed:
                return HELD.format(self.WHO, said, _had(found), times)
            before = found
        return ""

    def _slowly_held(self, claim, share):
        """Return that ``claim`` would hold if commands were not held at all, in words, or ""."""
        checks = []
        for times in FINER:
            run = self._for(share, commands=times)
            check = None if run is None else measured_of(run, claim)
            if check is None or check.difference is None:
                return ""
            if checks and abs(check.difference) > SHRINKS * abs(checks[-1].difference):
                return ""
            checks.append(check)
        value = float(AT_ZERO @ [check.measured for check in checks])
        if not measured_of(self.run, claim._replace(measure=lambda run: value)).passed:
            return ""
        said = "{} after {} s".format(_had(checks[0]), _rounded(self._lasted(share)))
        finer = [
            "{:.4g} with {} times the commands".format(check.measured, times)
            for check, times in zip(checks[1:], FINER[1:])
        ]
        return SLOWLY_HELD.format(self.WHO, said, ", ".join(finer), value)

    def _decays_otherwise(self, claim, run, share):
        """Return the answer on the rate ``claim``, which ``run``, over ``share`` times the run, misses.

        A rate is known where it is the same in two parts of the decay: of a simple mode.  One that is
        larger than claimed may be that of a start without the slowest mode, which a start beside this
        one has.
        """
        rates = _rates(run.time, claim.decays(run.hand))
        if rates is not None and _is_claimed(rates, claim):
            return Answer(None, LATER.format(rates[1]))
        if rates is None or not _is_simple(rates, claim):
            return Answer(None, NO_RATE if rates is None else NOT_SIMPLE.format(*rates))
        said = "decays by {:.4g} /s".format(rates[1])
        if rates[1] > claim.predicted:
            aside = self._rates_aside(claim, run, share)
            if aside is not None and _is_claimed(aside, claim):
                return Answer(None, LACKING.format(aside[1]))
            if aside is None or not _is_simple(aside, claim):
                return Answer(None, OPEN.format(self.WHO, said))
            said += ", and by {:.4g} /s from one beside it".format(aside[1])
        return self._falsified(claim, share, said)

    def _rates_aside(self, claim, run, share):
        """Return the two rates from a start beside that of ``run``, which has all modes, or None.

        Where the team comes to rest, it is the difference of the two that is looked at, in which no mode of
        ``run`` hides a slower one; what is left of it late begins the next, until the rate changes no more,
        since modes that are nearly as slow as the slowest part only late.
        """
        size = ASIDE * max(1.0, float(np.ptp(run.hand[0], axis=0).max()))
        draw = np.random.default_rng(0).uniform(-size, size, run.hand.shape[1:])
        rests, rates = _rests(claim.decays, run.hand), None
        longer = self._for(2.0 * share) if rests else None  # by whose end what differs is rounding
        if longer is not None:
            run, share = longer, 2.0 * share
        end = run.hand[-1]
        for _ in range(RICHER if rests else 1):
            other = self._for(share, draw)
            if other is None:
                return None
            off = other.hand - (other.hand[-1] - end)  # another limit, that moves as this one does
            if rests:
                off = end + (off - run.hand)
            values, before = claim.decays(off), rates
            rates = _rates(run.time, values)
            if rates is None or _is_claimed(rates, claim):
                break
            if before is not None and abs(rates[1] - before[1]) <= ALIKE * claim.tolerance:
                break
            left = off[np.argmax(values <= RATE_FLOOR * values[0])] - end
            draw = size / max(np.abs(left).max(), 1e-300) * left
        return rates

    def _is_random(self):
        law, links = published_law(self.control), self.control.links
        return law is None or law.RANDOM or bool(links.faults and links.changes_edges)

    def _waits(self, claim):
        """Return whether ``claim`` says how long a run it wants, after which chance averages out."""
        try:
            claim.measure(part_of(self.exact, slice(0, FEWEST_SAMPLES)))
        except TooShort:
            return True
        except Exception:  # of so short a run a person's measure may raise anything
            return False
        return False

    def _lasted(self, share):
        return share * float(self.run.time[-1] - self.run.time[0])

    def _ran(self):
        return _rounded(self._lasted(1.0))

    def _until(self, share):
        """Return the first part of the solution, ``share`` [-] of its samples."""
        return part_of(self.exact, slice(0, int(share * len(self.exact.time))))

    def _for(self, share, beside=None, commands=1):
        """Return the solution over ``share`` times the run, None where it is too long or not finite.

        ``beside`` (n, d) [m]: from a start beside the run's; ``commands``: so many times as many.
        """
        key = (share, commands)
        if beside is None and share == 1.0 and commands == 1:
            return self.exact
        if beside is None and key in self._longer:
            return self._longer[key]
        found = self._computed(share, beside, commands)
        if beside is None:
            self._longer[key] = found
        return found

    def _computed(self, share, beside, commands):
        run, control = self.run, self.control
        count, n = commands * self._lasted(share) / control.period, len(run.robots)
        law, events = published_law(control), run.scenario is not None and run.scenario.events
        work = law.WORK * count * n * n * (n if control.links.faults else 1)
        if count > MOST_COMMANDS or work > MOST_PAIRS or (events and share > 1.0):
            return None
        samples = int(min(share * (len(run.time) - 1), MOST_SAMPLES)) + 1
        run = run._replace(
            time=np.linspace(run.time[0], run.time[0] + self._lasted(share), samples)
        )
        if beside is not None:
            pose = run.pose.copy()
            pose[:, :, :2] += beside[:, :2]
            run = run._replace(hand=run.hand + beside, pose=pose)
        if commands > 1:
            control = copy.copy(control)
            control._keep(period=control.period / commands)
        return call(exact_run, control, run, self._steps[commands] if beside is None else None)

    def _first(self, run, claim):
        """Return after how long [s] ``run``, which shows the ``claim``, does so first."""
        fails, holds = len(run.time) // 2, len(run.time)
        while holds - fails > max(1, holds // 100):
            middle = (fails + holds) // 2
            shown = measured_of(part_of(run, slice(0, middle)), claim).passed
            fails, holds = (fails, middle) if shown else (middle, holds)
        return float(run.time[holds - 1] - run.time[0])


class Ideal(Points):
    """Ideal robots of the run's kinds under the law itself, which has no published form on points.

    They are simulated where the run misses a claim: one that it shows, the law does not make false.
    """

    WHO = "the run of ideal robots"

    def __init__(self, control, run):
        super().__init__(control, run, None, {})
        self._ideal = None

    def _answered(self, claim):
        if claim.unproved or measured_of(self.run, claim).passed is not False:
            return HOLDS
        if self._ideal is None:
            from mrs_simulator.verdict.theory.ideal_runs import IdealRuns  # of a world

            self._ideal = IdealRuns(self.control, self.run)
            self.exact = self._computed(1.0, None, 1)
        return super()._answered(claim)

    def _is_random(self):
        return False

    def _followed(self, claim, seen):
        if self._waits(claim):  # and this run is as long as it wants
            return self._falsified(claim, 1.0, _had(seen[-1]))
        return super()._followed(claim, seen)

    def _computed(self, share, beside, commands):
        try:
            return self._ideal.over(self._lasted(share), beside, commands)
        except Exception:  # of users' code, where it never was
            return None


def _had(check):
    """Return what a solution makes of a claim, in words."""
    return "does not show it" if check.measured is None else "has {:.4g}".format(check.measured)


def _rounded(seconds):
    return "{:.0f}".format(np.ceil(seconds)) if seconds >= 10.0 else "{:.2g}".format(seconds)


def _same(check, other, tolerance):
    found = check.measured is not None and other.measured is not None
    return found and abs(check.measured - other.measured) <= 0.1 * tolerance


def _rests(quantity, hand):
    """Return whether the points ``hand`` (m, n, d) come to rest where the ``quantity`` is nothing."""
    at_end = quantity(np.broadcast_to(hand[-1], hand.shape))
    return bool(np.max(at_end) <= RATE_FLOOR * quantity(hand)[0])


def _has_decayed(values):
    return bool(values[-1] <= RATE_FLOOR * values[0])


def _has_settled(seen):
    """Return whether the last of the checks ``seen``, each at twice the time, differ no more."""
    values = [check.measured for check in seen[-3:]]
    if len(values) < 3 or None in values:
        return False
    before, now = np.abs(np.diff(values))
    most = SETTLED * seen[-1].tolerance
    steep = 1.0 if before <= most else STEEP
    return bool(max(now, before) <= 1e-3 * most or now <= min(most, steep * before))


def _stays(run, claim, last):
    """Return whether ``run`` shows in its second half what it shows at its end, ``last``.

    At twice the time alone a ``claim`` that still changes may come back to what it was.
    """
    for share in BETWEEN:
        then = measured_of(part_of(run, slice(0, int(share * len(run.time)))), claim).measured
        if then is None or abs(then - last.measured) > SETTLED * last.tolerance:
            return False
    return True


def _grows(seen):
    """Return whether the miss has grown each time that time doubled."""
    values = [check.difference for check in seen[-4:]]
    if len(values) < 4 or None in values:
        return False
    steps = np.diff(np.abs(values))
    return bool((steps > seen[-1].tolerance).all() and (np.diff(steps) >= 0.0).all())


def _rates(time, values):
    """Return the rates [1/s] of ``values`` (m,) in two parts of their decay, None where it is too short."""
    share = np.asarray(values, dtype=float) / values[0]
    rates = []
    for top, least in zip(PARTS, PARTS[1:]):
        above = np.flatnonzero(~(share <= top))
        begin = above[-1] + 1 if len(above) else 0
        low = np.flatnonzero(share[begin:] <= least)
        end = begin + (low[0] if len(low) else len(share) - begin)
        if end - begin < FEWEST_FITTED:
            return None
        rates.append(slope(time[begin:end], -np.log(share[begin:end])))
    return rates


def _is_claimed(rates, claim):
    return abs(rates[1] - claim.predicted) <= claim.tolerance


def _is_simple(rates, claim):
    """Return whether ``rates`` of two parts differ little beside what they are off the ``claim``."""
    return abs(rates[1] - rates[0]) <= SIMPLE * abs(rates[1] - claim.predicted)
