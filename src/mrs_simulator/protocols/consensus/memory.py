"""Consensus protocols that remember positions or velocities, with what theory claims of their runs."""

import copy

import numpy as np

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.claims import Claim, Condition, disagreement
from mrs_simulator.core.fields import Parameter
from mrs_simulator.core.linear_theorem import linear_theorem
from mrs_simulator.core.spectra import left_null_vector
from mrs_simulator.core.stability import Stability, share_left
from mrs_simulator.protocols.common import (
    AGREED,
    all_hold,
    attracting,
    below,
    decays_as,
    spanning_tree,
)
from mrs_simulator.protocols.consensus.energies import second_order_energy
from mrs_simulator.protocols.consensus.equations import (
    delayed_consensus,
    least_damping,
    second_order_consensus,
    unshared_motion,
)
from mrs_simulator.protocols.consensus.law import ACCURACY, GAIN, NAMES
from mrs_simulator.protocols.consensus.published import Delayed, SecondOrder
from mrs_simulator.protocols.published.laws import Resumed, exact_motion, weights_of

TAU = Parameter(
    "tau",
    0.3,
    "s",
    low=0.0,
    high=100.0,
    meaning="age of all positions, rounded to whole command periods",
    why="stable below pi/(2 gain lambda_max)",
)
DAMPING = Parameter(
    "g",
    1.0,
    "s",
    low=-100.0,
    high=100.0,
    meaning="weight of velocity differences against those of positions",
    why="on a directed graph a bound above 0 must be exceeded",
)
PUSH = Parameter(
    "push", 0.0, "m/s", low=0.0, high=10.0, meaning="largest initial velocity along each axis"
)
SEED = Parameter("seed", 0, low=0, high=2**31 - 1, meaning="of everything random in the protocol")


def stable_if_held(theorem, period, late=0):
    """Return the condition that all decays under commands held for ``period`` [s], ``late`` by so many."""
    why, moves = "the command period is too long", len(theorem.eigenvalues) > theorem.zeros
    holds = not moves or theorem.held_rate(period, late) > 0.0
    return Condition("stable with held commands", holds, why, necessary=True)


class Remembering(PioneerControl):
    """A protocol that remembers: begins with the first command, or when time goes back."""

    DIMENSIONS = (2, 3)
    _last = None  # [s] time of the last command

    def pointMassLaw(self, hand):
        if self._last is None or self.time < self._last:
            self.start()
            self.begin(hand)
        self._last = self.time
        return self.law(hand)

    def start(self):
        """Forget the past; the next command is the first."""
        self._last = None

    def begin(self, hand):
        """Make the memory of a team that stands at ``hand`` (n, d) [m]."""
        raise NotImplementedError

    def law(self, hand):
        """Return the velocities (n, d) [m/s] and remember what is needed later."""
        raise NotImplementedError


class Solved(Remembering):
    """A protocol that remembers and whose exact solution is that of its published law."""

    _begun = None  # memory of the published law with which the run that is judged begins, if known

    def prediction(self, start, time):
        """Return the exact solution under held inputs, (m, n, d) [m], at ``time`` (m,) [s]."""
        law = self.published()
        law = law if self._begun is None else Resumed(law, 0.0, self._begun)
        motion = exact_motion(law, start, self.period, time, drift=self.carried)
        return motion and motion[0]


class Resumable(Solved):
    """Such a protocol whose claims hold from any memory on."""

    def resumed(self, time, memory):
        """Return the law that begins with the published law's ``memory``."""
        rest = copy.copy(self)
        rest._begun = memory
        return rest


class DelayedConsensus(Solved):
    """``u_i(t) = gain sum_j a_ij (p_j - p_i)(t - tau)``: Olfati-Saber and Murray, 2004.

    Before the start all robots stood where they are.

    Theorem: over a graph with a spanning tree all robots come to ``w^T p(0)``, on an undirected graph
    the mean of their places, if and only if ``tau < (pi/2 - |arg mu|)/(gain |mu|)`` for every
    eigenvalue mu of L but one 0; undirected, ``tau < pi/(2 gain lambda_max)``.
    """

    PARAMETERS = (GAIN, TAU)

    def published(self):
        return Delayed(weights_of(self.topology), self.gain, self.delay_steps)

    @property
    def delay_steps(self):
        """Return tau in command periods."""
        return int(round(self.tau / self.period))

    def begin(self, hand):
        """Remember that the robots stood at ``hand``."""
        self._history = [hand]

    def law(self, hand):
        """Return the velocities from the positions of tau ago."""
        self._history = (self._history + [hand])[-self.delay_steps - 1 :]
        return self.gain * delayed_consensus(self._history, self.topology)

    def claims(self, start):
        """Return limit, invariant and rate if tau is below ``pi/(2 gain lambda_max)``."""
        conditions = [spanning_tree(self.topology), attracting(self.gain)]
        if not all_hold(conditions):
            return conditions
        tau = self.delay_steps * self.period
        theorem = self._theorem()
        conditions += [
            below("tau < pi/(2 gain lambda_max) [s]", tau, theorem.longest_delay, necessary=True),
            stable_if_held(theorem, self.period, self.delay_steps),
        ]
        claims = theorem.consequences(start, self.period, ACCURACY, NAMES._replace(rate=""))
        return [*conditions, *claims, decays_as(self.prediction, disagreement)]

    def _theorem(self):
        """Return what theory says of ``gain L``, all of which is late by tau."""
        return linear_theorem(self.gain * self.topology.laplacian())

    def stability(self, start):
        """Return how far tau, not rounded, is from ``pi/(2 gain lambda_max)``."""
        if self.links.faults or self.gain <= 0.0:
            return None
        margin = share_left(self.tau, self._theorem().longest_delay)
        return Stability(r"$\tau = \pi/(2\kappa\lambda_{\max})$", margin)


class SecondOrderConsensus(Resumable):
    """``v_i' = sum_j a_ij ((p_j - p_i) + g (v_j - v_i))``: Ren and Atkins, 2007.

    The robots are commanded the velocities v.  These begin at random, up to ``push`` along each axis.

    Theorem: over a graph with a spanning tree velocities agree, and robots meet and move on together
    along ``w^T p(0) + t w^T v(0)``, if and only if ``g > max sqrt(Im(mu)^2/(Re(mu) |mu|^2))`` over the
    eigenvalues mu of L but one 0. On an undirected graph every ``g > 0`` does.
    """

    PARAMETERS = (DAMPING, PUSH, SEED)

    def published(self):
        draw = np.random.default_rng(self.seed).random((len(self.numbers), self.dimension))
        first = self.push * (2.0 * draw - 1.0)
        return SecondOrder(weights_of(self.topology), self.g, first, self.period)

    def begin(self, hand):
        """Draw the initial velocities."""
        self._velocity = self.initial_velocities()

    def initial_velocities(self):
        """Return v(0), (n, d) [m/s]."""
        if self._begun is not None:
            return self._begun
        size = len(self.numbers), self.dimension
        return self.push * np.random.default_rng(self.seed).uniform(-1.0, 1.0, size)

    def law(self, hand):
        """Return the velocities at the end of this period, by which semi-implicit steps move."""
        force = second_order_consensus(hand, self._velocity, self.topology, self.g)
        self._velocity = self._velocity + self.period * force
        return self._velocity

    def energy(self, start):
        """Return ``p^T L p/2 + |v|^2/2``, over a directed graph that of what is not shared."""
        if self.g <= 0.0 or len(start) < 2:
            return None
        return second_order_energy(self.topology, self.g)

    def claims(self, start):
        """Return limit and rate if ``g`` exceeds the bound that the directed graph sets."""
        conditions = [spanning_tree(self.topology)]
        if not all_hold(conditions):
            return conditions
        name = "g > max sqrt(Im(mu)^2/(Re(mu)|mu|^2)) [s]"
        held = linear_theorem(unshared_motion(self.topology, self.g, self.period))
        bound = least_damping(self.topology)
        conditions += [
            Condition(
                name, self.g > bound, "{:.4g} against {:.4g}".format(self.g, bound), necessary=True
            ),
            stable_if_held(held, self.period),
        ]
        return conditions + [
            Claim(
                "distance from w^T p(0) + t w^T v(0) [m]", 0.0, AGREED, self._off_limit, free=True
            ),
            decays_as(self.prediction, disagreement),
        ]

    def _off_limit(self, run):
        weights = left_null_vector(self.topology)
        elapsed = run.time[-1] - run.time[0]
        place = weights @ run.hand[0] + elapsed * (weights @ self.initial_velocities())
        return float(np.linalg.norm(run.hand[-1] - place, axis=1).max())
