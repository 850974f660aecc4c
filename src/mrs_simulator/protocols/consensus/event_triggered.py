"""Consensus with broadcasts at events, with what theory claims of its runs."""

import numpy as np

from mrs_simulator.core.claims import (
    LAW,
    RATE_FLOOR,
    Claim,
    Condition,
    centroid,
    converges_to,
    invariant,
)
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.spectra import algebraic_connectivity, spectral_radius
from mrs_simulator.protocols.common import AGREED, attracting, below, falls, spanning_tree
from mrs_simulator.protocols.consensus.equations import consensus, event_thresholds
from mrs_simulator.protocols.consensus.law import GAIN, NAMES
from mrs_simulator.protocols.consensus.memory import Remembering
from mrs_simulator.protocols.consensus.published import EventTriggered
from mrs_simulator.protocols.energies import laplacian_energy
from mrs_simulator.protocols.published.laws import exact_motion, weights_of

SIGMA = Parameter(
    "sigma",
    0.8,
    **POSITIVE,
    high=1.0,
    open_high=True,
    meaning="share of the largest error that a broadcast corrects",
    why="p^T L p decreases between 0 and 1",
)
FEW = 0.25  # [-] of the broadcasts of a periodic law: fewer than this are few


class EventTriggeredConsensus(Remembering):
    """``u = -gain L p_hat``, broadcast at events: Dimarogonas, Frazzoli and Johansson, 2012.

    Robot i broadcasts, and p_hat_i becomes p_i, when their distance exceeds its threshold.

    Theorem: on a connected undirected graph all robots come to the mean of their places, which is kept,
    and ``p^T L p`` stays below ``exp(-(1 - sigma) gain lambda_2 t)`` times its start, with far fewer
    broadcasts than commands.
    """

    PARAMETERS = (GAIN, SIGMA)
    JUMPS = True

    def published(self):
        return EventTriggered(weights_of(self.topology), self.gain, self.sigma)

    def begin(self, hand):
        """Let every robot broadcast once."""
        self._known, self._commands, self._broadcasts = hand, 0, 0

    def law(self, hand):
        """Return the velocities from what was broadcast last."""
        self._known, count = self._updated(hand, self._known if self._commands else None)
        self._broadcasts += count
        self._commands += 1
        return self.gain * consensus(self._known, self.topology)

    def _updated(self, hand, known):
        """Return ``(p_hat, count)``: what is known after the broadcasts at ``hand``."""
        if known is None:
            return hand, len(hand)
        allowed = event_thresholds(hand, self.topology, self.sigma)
        events = np.linalg.norm(hand - known, axis=1) > allowed
        return np.where(events[:, np.newaxis], hand, known), int(events.sum())

    def energy(self, start):
        """Return ``p^T L p/2`` on an undirected graph, which falls by what was broadcast last."""
        if self.topology.directed or self.gain <= 0.0:
            return None
        return laplacian_energy(self.topology, self.gain)

    def claims(self, start):
        """Return limit, invariant, decrease of ``p^T L p`` and few broadcasts."""
        # The share of its threshold by which an error grows between two looks at it.
        growth = self.gain * self.period * spectral_radius(self.topology) / np.sqrt(self.sigma)
        adjacency = self.topology.adjacency()
        symmetric = np.allclose(adjacency, adjacency.T)
        conditions = [
            Condition("undirected", bool(symmetric), "the theorem needs L = L^T"),
            spanning_tree(self.topology),
            attracting(self.gain),
            below("gain Tc lambda_max/sqrt(sigma) < 0.1", growth, 0.1),
        ]
        if not conditions[1].holds:
            return conditions
        return conditions + [
            converges_to(start.mean(axis=0), AGREED, "distance from the mean [m]", free=True),
            invariant(centroid, 0.01, NAMES.kept),
            *falls(self.energy(start), "growth of p^T L p [-]", free=True),
            Claim("p^T L p over its bound [-]", 1.0, 1e-6, self._over, "at most", free=True),
            Claim(
                "broadcasts a robot and command [-]", FEW, 0.0, self.share, "at most", question=LAW
            ),
            *self._broadcast_claims(),
        ]

    def _broadcast_claims(self):
        """Return the claim that robots broadcast as often as points do under the published rule."""
        if self.fidelity != "point_mass":
            return []

        def over_exact(run):
            law = self.published()
            time = np.arange(0.0, run.time[-1] - run.time[0] + 0.5 * self.period, self.period)
            exact_motion(law, run.hand[0], self.period, time)
            return self._counted(run)[0] / law.broadcasts

        name = "exact share of events [-]"
        return [Claim(name, 1.0, 0.02, over_exact, free=True, question=LAW)]

    def _over(self, run):
        """Return the largest ratio of ``p^T L p`` to ``exp(-(1 - sigma) gain lambda_2 t)`` of its start."""
        slowest = (1.0 - self.sigma) * self.gain * algebraic_connectivity(self.topology)
        bound = np.exp(-slowest * (run.time - run.time[0]))
        values = laplacian_energy(self.topology, self.gain).values(run.hand)
        ratio = values / (max(values[0], 1e-200) * np.maximum(bound, RATE_FLOOR))
        return float(np.max(ratio[1:], initial=0.0))  # the first is 1 by construction

    def share(self, run):
        """Return the broadcasts of ``run`` for each robot and command [-]; periodic laws have 1."""
        broadcasts, commands = self._counted(run)
        return broadcasts / (commands * len(self.numbers))

    def _counted(self, run):
        if self._last is not None:
            return self._broadcasts, self._commands
        # Judged from a recording alone: what the law saw at commands between samples follows from these.
        known, count, commands = None, 0, 0
        for row, hand in enumerate(run.hand):
            steps = self._commands_after(run, row)
            for step in range(steps):
                known, events = self._updated(hand, known)
                count, commands = count + events, commands + 1
                if self.fidelity == "point_mass":
                    hand = hand + self.period * self.gain * consensus(known, self.topology)
                elif (
                    step + 1 < steps
                ):  # which arcs between two samples are not known: a straight line
                    hand = run.hand[row] + (step + 1) / steps * (run.hand[row + 1] - run.hand[row])
        return count, commands

    def _commands_after(self, run, row):
        """Return how many commands fall on the sample ``row`` and on the time until the next."""
        turns = (run.time[row : row + 2] - run.time[0]) / self.period
        first, after = np.ceil(turns - 1e-6).astype(int) if len(turns) > 1 else (0, 1)
        return int(after - first)

    def measures(self, run):
        """Return how often robots broadcast, and how often they were commanded."""
        broadcasts, commands = self._counted(run)
        return {"broadcasts": broadcasts, "commands": commands}
