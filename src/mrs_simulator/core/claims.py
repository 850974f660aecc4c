"""Claims of a protocol about its own runs: limits, rates, invariants and bounds, with their conditions.

A *quantity* is a function of the hand points of all samples, (m, n, d) [m], that returns one value
for each sample, (m,) or (m, d).
"""

from typing import Any, Callable, NamedTuple

import numpy as np

# [-] of the start, below which a rate is looked for: first the last
RATE_WINDOWS = (1e-3, 1e-2, 1e-1)
RATE_FLOOR = 1e-9  # [-] of the start, below which rounding is all there is
NEGLIGIBLE = 1e-9  # [m], or the quantity's unit: from less at the start nothing decays but rounding
IN_PART = "with forces, robots in water and air follow small velocities in part only"
RESTS = "it begins at {:.3g}, and below {:.3g} friction holds robots where they are"
MOST_PAIRS = 20000  # [-] of robots over the samples that ``by_sample`` takes at a time
FEWEST_FITTED = 12  # [-] samples of a fitted rate
NO_TOPOLOGY = "the scenario has no topology; wanted one, such as topology: {preset: ring}"
# What a claim asks: whether theory holds of the law; whether robots get the commands that the published law
# wants; whether they go where theory goes.
THEOREM, LAW, ROBOTS = QUESTIONS = ("theorem", "law", "robots")


class NothingDecays(ValueError):
    """A rate was to be measured of a quantity that is zero from the start: it has none."""


class TooShort(NothingDecays):
    """A run in which a claim cannot be measured yet; the message says how long a run it wants."""


class Claim(NamedTuple):
    """One prediction of a theorem and how to measure it in a run.

    ``relation``: "equal" (within ``tolerance``), "at most" or "at least" (with ``tolerance`` to
    spare).  ``free``: it holds only while no limit on the robots' speeds is reached, which is required
    where no published law states the effect of limits.  ``unproved``: why no theorem says it of this
    run; it is measured all the same.  ``place``: where the hand points end according to it, (n, d) or
    (d,) [m], if it says so.  ``question``: one of ``QUESTIONS``; those of the
    theorem are tested on the exact solution too.  ``motion``: it is about robots that move freely, and so
    not about a run in which bodies touched.  ``decays``: of a rate, the quantity whose rate it is.
    ``outside``: of a local theorem, a function of the points (n, d) [m] at which the law itself comes to
    rest; it returns why the start was not near enough for the theorem, "" where that does not show.
    """

    name: str
    predicted: Any
    tolerance: float
    measure: Callable
    relation: str = "equal"
    free: bool = False
    unproved: str = ""
    place: Any = None
    question: str = THEOREM
    motion: bool = True
    decays: Any = None
    outside: Any = None


class Condition(NamedTuple):
    """A condition of the theorem: whether it holds here, and why not.

    ``rules_out``: where it does not, no claim of the protocol is judged, and the run is not judged;
    else it fails.  ``necessary``: without it the theorem says that the protocol fails, and so does the
    run.
    """

    name: str
    holds: bool
    why: str = ""
    rules_out: bool = True
    necessary: bool = False


def listed(claims):
    """Return ``claims`` as a list: a ``Claim`` or ``Condition`` alone is one of them."""
    return [claims] if isinstance(claims, (Claim, Condition)) else list(claims)


def converges_to(points, tolerance=0.05, name="final distance from the limit [m]", free=False):
    """Claim that the hand points end at ``points``, (n, d) or one point (d,) [m], within ``tolerance``.

    Raises ``TypeError`` for a number alone, which is no point.
    """
    points = np.asarray(points, dtype=float)
    if not points.ndim:
        text = "converges_to(points): {:g}, wanted points (n, d) or one point (d,) [m]"
        raise TypeError(text.format(points))
    return Claim(
        name,
        0.0,
        tolerance,
        lambda run: float(np.linalg.norm(run.hand[-1] - points, axis=-1).max()),
        free=free,
        place=points,
    )


def ends_at(quantity, value, tolerance, name, free=False):
    """Claim that the ``quantity`` is ``value`` at the end, within ``tolerance``."""
    return Claim(name, value, tolerance, lambda run: float(quantity(run.hand[-1:])[0]), free=free)


def rate(value, of, tolerance=0.05, name="decay rate [1/s]", free=True, floor=0.0):
    """Claim that the quantity ``of`` decays like ``exp(-value t)``, value [1/s].

    ``tolerance`` is a share of ``value``.  Measured by a straight line through the logarithm of the
    last part of the decay above ``floor``, in the quantity's unit, where the slowest mode is left; a
    ``floor`` of None says that these robots follow small velocities in part only, and show no rate.
    Raises ``TypeError`` where the two are the other way round.
    """
    if callable(value):
        raise TypeError("rate(value, of): wanted a number [1/s], and then a function of the points")
    return Claim(
        name,
        float(value),
        tolerance * abs(value),
        lambda run: decay_rate(run.time, of(run.hand), floor or 0.0),
        free=free,
        unproved=IN_PART if floor is None else "",
        decays=of,
    )


def invariant(quantity, tolerance=0.01, name="drift of the invariant", free=True):
    """Claim that the ``quantity`` keeps the value it starts with, within ``tolerance``."""

    def drift(run):
        values = np.asarray(quantity(run.hand), dtype=float).reshape(len(run.time), -1)
        return float(np.linalg.norm(values - values[0], axis=1).max())

    return Claim(name, 0.0, tolerance, drift, free=free)


def stays_below(quantity, bound, name, tolerance=0.0):
    """Claim that the ``quantity`` never exceeds ``bound`` by more than ``tolerance``."""
    return Claim(
        name, bound, tolerance, lambda run: float(np.max(quantity(run.hand))), relation="at most"
    )


def stays_above(quantity, bound, name, tolerance=0.0):
    """Claim that the ``quantity`` never falls below ``bound`` by more than ``tolerance``."""
    return Claim(
        name, bound, tolerance, lambda run: float(np.min(quantity(run.hand))), relation="at least"
    )


def decreases(quantity, name, tolerance=1e-6, free=False):
    """Claim that the ``quantity`` never grows, by more than ``tolerance`` of itself in one sample.

    Below ``RATE_FLOOR`` of its start, or of 1, it is not looked at: rounding is all there is.
    """

    def growth(run):
        values = np.abs(np.asarray(quantity(run.hand), dtype=float))
        floor = RATE_FLOOR * max(values[0], RATE_FLOOR)
        return float(np.max(np.diff(values) / np.maximum(values[:-1], floor), initial=0.0))

    return Claim(name, 0.0, tolerance, growth, relation="at most", free=free)


def decay_rate(time, values, least=0.0):
    """Return the rate [1/s] at which ``values`` (m,) decay at ``time`` (m,) [s]; None if they do not.

    Values from the first at most ``least`` on are not looked at.  Raises ``NothingDecays`` for values
    that begin at zero, or there.
    """
    values = np.asarray(values, dtype=float)
    if values[0] <= max(NEGLIGIBLE, least):
        raise NothingDecays(RESTS.format(values[0], least) if least else "")
    low = np.flatnonzero(values <= least)
    if len(low):
        time, values = time[: low[0]], values[: low[0]]
    if np.isnan(values[0]):
        return None
    share = values / values[0]
    # A decay that has reached its floor stays there: only what comes before counts.
    low = np.flatnonzero(share <= RATE_FLOOR)
    end = low[0] if len(low) else len(share)
    floor = max(
        RATE_FLOOR, 30.0 * float(np.min(share[:end], initial=1.0)) if end < len(share) else 0.0
    )
    for top in RATE_WINDOWS:
        below = np.flatnonzero(share[:end] > top)
        begin = below[-1] + 1 if len(below) else 0
        window = np.arange(begin, end)
        window = window[share[window] > floor]
        if len(window) >= FEWEST_FITTED:
            return slope(time[window], -np.log(share[window]))
    return None


def slope(time, values):
    """Return the slope of the straight line through ``values`` (m,) at ``time`` (m,) [s].

    None for fewer than two values, or such as are not finite.
    """
    if len(time) < 2 or not np.isfinite(values).all():
        return None
    return float(np.polyfit(time, values, 1)[0])


def proved(claims):
    """Return those of ``claims`` that theory stands for; none where a condition does not hold."""
    if any(isinstance(claim, Condition) and not claim.holds for claim in claims):
        return []
    return [claim for claim in claims if not isinstance(claim, Condition) and not claim.unproved]


def without_theorem(claims, why):
    """Return ``claims`` as what no theorem says of this run, ``why``; conditions stay as they are."""
    return [
        claim if isinstance(claim, Condition) else claim._replace(unproved=why) for claim in claims
    ]


# Quantities ------------------------------------------------------------------------------------


def centroid(hand):
    """Return the centroids (m, 2) [m]."""
    return hand.mean(axis=1)


def disagreement(hand):
    """Return the distance from agreement, (m,) [m]: ``|alpha - 1 mean(alpha)|``."""
    return np.linalg.norm(hand - hand.mean(axis=1, keepdims=True), axis=(1, 2))


def extent(hand):
    """Return the longer side, (m,) [m], of the smallest box around the team."""
    return np.ptp(hand, axis=1).max(axis=1)


def distance_to(points):
    """Return the quantity ``|alpha - points|``, (m,) [m]."""
    points = np.asarray(points, dtype=float)
    return lambda hand: np.linalg.norm(hand - points, axis=(1, 2))


def by_sample(quantity):
    """Return the ``quantity`` computed of some samples at a time: pairs of all at once take much memory."""

    def of(hand):
        every = max(1, MOST_PAIRS // hand.shape[1] ** 2)
        return np.concatenate(
            [quantity(hand[row : row + every]) for row in range(0, len(hand), every)]
        )

    return of
