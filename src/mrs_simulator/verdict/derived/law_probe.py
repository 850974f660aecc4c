"""Asking a law for its velocities at states of one's own, and what the answers say of it.

All that is found holds at the states that were probed.
"""

from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.linear_theorem import linear_theorem
from mrs_simulator.verdict.derived.linear_law import fitted

SCALES = (0.3, 1.0, 3.0)  # [-] of the team's extent, over which states are spread
CHECKED = 6  # states at each scale
FEW = 3  # the same, of a law whose linear theory alone is wanted
SAME = 1e-9  # [-] of the largest velocity, within which velocities are the same
LINEAR = 1e-7  # [-] of the largest velocity or coefficient, within which a law is linear
DIFFERENCE = 1e-5  # [-] of the extent, for derivatives
SYMMETRIC = 1e-5  # [-] of the largest derivative
LATER = 12.3  # [s] at which a law is asked again
STEP, STEPS = 0.05, 2000  # [s], of the run that looks for an equilibrium
NUDGE = 1e-3  # [-] of the extent, away from the start
NEWTON = 20  # steps at most from where that run ends
SOUGHT = 4  # states at each scale, from which other equilibria are looked for
FARTHEST = 10.0  # [-] of the extent, beyond which an equilibrium is not reported
ALIKE = 1e-3  # [-] of the largest eigenvalue, by which those of one equilibrium may differ
AT_REST = 1e-9  # [-] of the first velocity, at an equilibrium
NEAR = 1e-5  # [-] of the extent, of a last Newton step to it
AT_ONCE = 500  # states of one question, each of which is to be answered in time
CHANCE = "chance"  # what a law's velocities may depend on


class Probe:
    """A law of n robots: velocities (k, n, d) [m/s] of controlled points at (k, n, d) [m].

    ``ask(points, theta, time, fresh)`` returns them, as ``asking.velocities_at``.
    """

    def __init__(self, ask, start, seed=0):
        """``start`` (n, d) [m]: the points that the scenario begins with."""
        self._ask, self.start = ask, np.asarray(start, dtype=float)
        self.random = np.random.default_rng(seed)
        (self.n, self.dimension), self.asked = self.start.shape, 0
        self.centre = self.start.mean(axis=0)
        self.extent = max(1.0, float(np.ptp(self.start, axis=0).max()))

    def at(self, points, theta=None, time=0.0, fresh=True):
        """Return the velocities at ``points`` (k, n, d), with random headings unless ``theta`` is given.

        ``fresh``: each by a new instance of the law; else ``AT_ONCE`` in turn by one.
        """
        points = np.asarray(points, dtype=float)
        if theta is None:
            theta = self.random.uniform(-np.pi, np.pi, points.shape[:2])
        self.asked += len(points)
        parts = (slice(i, i + AT_ONCE) for i in range(0, len(points), AT_ONCE))
        return np.concatenate([self._ask(points[i], theta[i], time, fresh) for i in parts])

    def states(self, scale, count):
        """Return random states (count, n, d), spread over ``scale`` times the team's extent."""
        size = scale * self.extent
        return self.centre + self.random.uniform(-0.5, 0.5, (count, self.n, self.dimension)) * size


class Facts(NamedTuple):
    """What was found of a law; :func:`facts_of` says what each is."""

    memory: str
    headings: bool
    receives: Any
    translation: bool
    rotation: bool
    gradient: bool
    residual: float
    linear: Any
    equilibrium: Any
    equilibria: Any
    matrix: Any
    constant: Any
    asked: int


def facts_of(probe):
    """Return the ``Facts`` of the law behind ``probe``.

    ``memory``: "", or what velocities depend on besides positions: time, the calls before, chance;
    ``headings``: whether on headings; ``receives``: for each scale the matrix (n, n) of who moves whom,
    None of a law by chance, whose answers differ whoever moved; ``translation``, ``rotation``: whether
    velocities stay, or turn with the team; ``gradient``: whether the derivative is symmetric, None of a
    law that only jumps; ``residual`` [-]: of u = c - M x; ``linear``: the ``linear_theorem``, of the law
    itself or near its ``equilibrium`` (n, d), or None; ``equilibria``: of a law that is not linear,
    ``(points, linear_theorem)`` of those with different eigenvalues; ``matrix``, ``constant``: M and c.
    """
    states = np.concatenate([probe.states(scale, CHECKED) for scale in SCALES])
    theta = probe.random.uniform(-np.pi, np.pi, states.shape[:2])
    same = _sameness(probe.at(states, theta))
    memory = _memory(probe, states, theta, same)
    headings = not memory and not same(probe.at(states, theta + 1.0))
    receives = None if memory == CHANCE else _receives(probe)
    plain = {"memory": memory, "headings": headings, "receives": receives}
    if memory or headings:
        unknown = dict.fromkeys(Facts._fields)
        return Facts(**{**unknown, **plain, "asked": probe.asked})
    moved = probe.at(states + 0.7 * probe.extent)
    turn = np.eye(probe.dimension)
    turn[:2, :2] = [[0.6, 0.8], [-0.8, 0.6]]
    derivative = [jacobian(probe, state) for state in states[::CHECKED]]
    fit = _fit(probe)
    is_linear = fit.residual <= LINEAR
    equilibrium = None if is_linear else _equilibrium(probe)
    others = () if is_linear else _equilibria(probe, equilibrium)
    matrix, constant = fit.matrix, fit.constant
    if not is_linear and equilibrium is not None:
        matrix, constant = _linearised(probe, equilibrium)
    known = is_linear or equilibrium is not None
    return Facts(
        **plain,
        translation=same(moved),
        rotation=same(probe.at(states @ turn) @ turn.T),
        gradient=_is_gradient(derivative, is_linear),
        residual=fit.residual,
        linear=linear_theorem(matrix, constant, exact=False) if known else None,
        equilibrium=equilibrium,
        equilibria=others,
        matrix=matrix if known else None,
        constant=constant if known else None,
        asked=probe.asked,
    )


def linear_fit(probe):
    """Return ``(fit, "")``, the ``Fit`` of a law of positions alone that is linear, or None and why not."""
    states = np.concatenate([probe.states(scale, FEW) for scale in SCALES])
    theta = probe.random.uniform(-np.pi, np.pi, states.shape[:2])
    same = _sameness(probe.at(states, theta))
    memory = _memory(probe, states, theta, same)
    if memory or not same(probe.at(states, theta + 1.0)):
        return None, "which depends on {}".format(memory or "headings")
    fit = _fit(probe)
    return (fit, "") if fit.residual <= LINEAR else (None, "which is not linear")


def _sameness(velocities):
    """Return the function that says whether others are the same as these ``velocities`` (k, n, d)."""
    size = max(np.abs(velocities).max(), 1e-300)

    def same(others, limit=SAME):
        return bool(np.abs(others - velocities).max() <= limit * size)

    return same


def _memory(probe, states, theta, same):
    """Return what velocities depend on besides the state, "" for nothing."""
    if not same(probe.at(states, theta)):
        return CHANCE
    if not same(probe.at(states, theta, LATER)):
        return "time"
    in_turn = probe.at(states, theta, fresh=False)
    return "" if same(in_turn) else "the states before"


def _receives(probe):
    """Return for each of ``SCALES`` whether robot i moves otherwise where j stands elsewhere, (n, n)."""
    found = []
    for scale in SCALES:
        who = np.zeros((probe.n, probe.n), dtype=bool)
        for state in probe.states(scale, 3):
            elsewhere = np.repeat(state[np.newaxis], probe.n + 1, axis=0)
            rows = np.arange(probe.n)
            elsewhere[rows, rows] += (
                probe.random.uniform(0.05, 0.2, probe.start.shape) * probe.extent
            )
            theta = np.zeros(elsewhere.shape[:2])
            velocity = probe.at(elsewhere, theta)
            change = np.abs(velocity[:-1] - velocity[-1]).max(axis=2)  # of i, where j was moved
            who |= (change > SAME * max(np.abs(velocity).max(), 1e-300)).T
        found.append(who)
    return found


def jacobian(probe, state):
    """Return the derivative (n d, n d) [1/s] of the velocities at ``state`` (n, d), by differences."""
    return _tangents(probe, state[np.newaxis])[1][0]


def _tangents(probe, states):
    """Return the velocities (k, n, d) at ``states`` (k, n, d), and their derivatives (k, n d, n d) [1/s].

    All are asked for at once, as a question to another process takes longer than its answer.
    """
    size, count = DIFFERENCE * probe.extent, probe.start.size
    offsets = size * np.eye(count).reshape(count, *probe.start.shape)
    around = np.concatenate([0.0 * offsets[:1], offsets, -offsets])
    points = (states[:, np.newaxis] + around).reshape(-1, *probe.start.shape)
    velocity = probe.at(points, np.zeros(points.shape[:2]), fresh=False)
    velocity = velocity.reshape(len(states), len(around), count)
    ahead, behind = velocity[:, 1 : count + 1], velocity[:, count + 1 :]
    derivative = np.swapaxes((ahead - behind) / (2.0 * size), 1, 2)
    return velocity[:, 0].reshape(states.shape), derivative


def _is_gradient(derivatives, is_linear):
    """Return whether all ``derivatives`` are symmetric; None of a law that only jumps, as signs do."""
    if not is_linear and not any(each.any() for each in derivatives):
        return None
    return all(np.abs(j - j.T).max() <= SYMMETRIC * np.abs(j).max() for j in derivatives)


def _fit(probe):
    """Return the ``Fit`` over all scales together, so that what changes with distance shows."""
    count = probe.start.size + 1
    each = count // len(SCALES) + 2
    states = np.concatenate(
        [probe.states(scale, each) for scale in SCALES]
        + [probe.states(scale, CHECKED) for scale in SCALES]
    )
    velocities = probe.at(states)
    k = len(states)
    return fitted(states.reshape(k, -1), velocities.reshape(k, -1), CHECKED * len(SCALES))


def _equilibrium(probe):
    """Return where the team comes to rest from its start (n, d), or None: by steps, then Newton's."""
    # Slightly beside its start, so that it leaves what only looks like rest.
    beside = NUDGE * probe.extent * probe.random.standard_normal(probe.start.shape)
    state, theta = probe.start + beside, np.zeros((1, probe.n))
    first = max(np.abs(probe.at(state[np.newaxis], theta)).max(), 1e-300)
    for _ in range(STEPS):
        velocity = probe.at(state[np.newaxis], theta, fresh=False)[0]
        state = state + STEP * velocity
        if not np.isfinite(state).all():
            return None
        if np.abs(velocity).max() <= 1e-4 * first:
            break
    else:
        return None
    return _rests(probe, [state], first)[0]


def _rests(probe, states, first):
    """Return the equilibria (n, d) to which Newton's steps lead from ``states`` (k, n, d), each or None.

    ``first`` [m/s]: the velocity of which ``AT_REST`` is rest.
    """
    states, found, going = np.array(states), [None] * len(states), np.arange(len(states))
    for _ in range(NEWTON):
        tangents = zip(going, *_tangents(probe, states[going]))
        going = []
        for i, velocity, derivative in tangents:
            step = np.linalg.lstsq(derivative, -velocity.ravel(), rcond=1e-6)[0]
            if np.abs(velocity).max() <= AT_REST * first:
                # Where velocities rise with a power, as -x^3, they are small before the place is near.
                found[i] = states[i] if np.abs(step).max() <= NEAR * probe.extent else None
                continue
            states[i] += step.reshape(states[i].shape)
            if np.isfinite(states[i]).all():
                going.append(i)
        if not going:
            break
    return found


def _equilibria(probe, known):
    """Return ``(points, linear_theorem)`` of equilibria whose eigenvalues differ, the ``known`` one first.

    Newton's steps look for them from random states; those that a symmetry maps to each other count once.
    """
    states = np.concatenate([probe.states(scale, SOUGHT) for scale in SCALES])
    first = max(np.abs(probe.at(states, np.zeros(states.shape[:2]))).max(), 1e-300)
    rests = [known, *_rests(probe, states, first)]
    found = []
    for state in rests:
        if state is None or np.abs(state - probe.centre).max() > FARTHEST * probe.extent:
            continue
        theorem = linear_theorem(*_linearised(probe, state), exact=False)
        size = max(np.abs(theorem.eigenvalues).max(), 1e-300)  # 0 where no robot is in range
        if not any(_alike(theorem, other, size) for _, other in found):
            found.append((state, theorem))
    return tuple(found)


def _alike(theorem, other, size):
    """Return whether two spectra are the same, in any order of equal real parts."""
    one, two = (np.sort_complex(np.round(each.eigenvalues / size, 4)) for each in (theorem, other))
    return np.abs(one - two).max() <= ALIKE


def _linearised(probe, state):
    """Return M (n d, n d) and c (n d,) of the law near the equilibrium ``state`` (n, d)."""
    matrix = -jacobian(probe, state)
    return matrix, matrix @ state.ravel()
