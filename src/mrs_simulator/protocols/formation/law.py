"""The paper's formation law (6) as a protocol, with what theory claims of its runs."""

from typing import NamedTuple

import numpy as np

from mrs_simulator.control.array_law import flow_law
from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.claims import Claim, Condition
from mrs_simulator.core.graphs import Topology, arcs_of
from mrs_simulator.core.spectra import stable_step
from mrs_simulator.protocols.common import below, commands_by
from mrs_simulator.protocols.consensus.over_links import AveragingLaw, Linear, linear_claims
from mrs_simulator.protocols.formation import equations as formation
from mrs_simulator.protocols.linear_errors import LinearErrors
from mrs_simulator.protocols.published.arms import robots_of
from mrs_simulator.protocols.published.laws import Averaging, weights_of

SETTLED = 0.02  # [-] settled once the largest target error stays below this share of its start
MOST_ROBOTS = 500  # [-] whose matrices of weights are built


class Tolerances(NamedTuple):
    """How far a run may be from theory, by what moves the robots.

    On full dynamics: what slip may cost at most.  The worst of the shipped runs, for each: 0.028 m,
    0.014 m and 0.031 m with wheel odometry, and 0.028.
    """

    gap: float  # [m]
    spread: float  # [m]
    place: float  # [m] of each final hand point from its predicted place
    settling: float  # [-] of the predicted settling time, beside one command


TOLERANCES = {
    "point_mass": Tolerances(1e-3, 1e-3, 1e-2, 0.002),
    "kinematic": Tolerances(0.01, 0.01, 0.1, 0.05),
    "dynamic": Tolerances(0.05, 0.02, 0.05, 0.05),
}


class Formation(AveragingLaw, PioneerControl):
    """The paper's law (6): ``u_i = -(k/T)(alpha_i - alpha_i*)``, a line parallel to the x axis.

    Theorem: for ``0 < k < 1`` all errors decay, along a chain with the eigenvalue ``1 - k`` in each step,
    so that gaps come to c and the y coordinates to one value. The settling time follows from the start,
    and so does the place: robot n of a chain stands still; in a cycle or a path the centroid does.
    """

    PARAMETERS = formation.PARAMETERS
    DIMENSIONS = (2, 3)
    MEMORYLESS = True

    def published(self):
        """Return law (6) as published."""
        n, row = len(self.numbers), np.arange(len(self.numbers) - 1)
        places = np.zeros((n, self.dimension))
        places[:, 0] = self.c * np.arange(n)[::-1]
        weights = np.zeros((n, n))
        if self.closure == "topology":
            weights = weights_of(self.topology)
        elif n > 1:
            weights[row, row + 1] = 1.0
            weights[n - 1, 0] = float(self.closure == "cycle")
        if self.closure == "path":
            weights = weights + weights.T
        return Averaging(weights, self.k / self.T, places, means=True)

    def set_parameters(self, given):
        """Set the parameters; closures ``chain``, ``cycle`` and ``path`` are graphs of their own."""
        super().set_parameters(given)
        n = len(self.numbers)
        self._closure = formation.closure_topology(self.closure, n, self._given_topology)
        self._offsets = formation.line_offsets(n, self.c, self.dimension)
        self.topology = self._closure
        self._settled = None, None  # a share and a start, and in how many commands it settles

    def checked_parameters(self, given):
        """Return all values; a closure that needs a topology is refused without one."""
        values = super().checked_parameters(given)
        formation.closure_topology(values["closure"], len(self.numbers), self._given_topology)
        return values

    def set_topology(self, topology):
        """Follow ``topology`` from now on (closure ``topology``)."""
        super().set_topology(topology)
        self.set_parameters(dict(self.parameters, closure="topology"))

    @flow_law
    def pointMassLaw(self):
        """Return ``u``, shape (n, d) [m/s], of law (6) for hand points (n, d) [m]."""
        return formation.formation_flow(self._offsets, self.topology, self.k, self.T)

    def targets(self, hand):
        """Return ``alpha_i*``, (n, d) [m]."""
        return hand - formation.target_errors(hand, self._offsets, self._closure)

    def warnings(self, pose):
        """Return the warning that the law spins for ever where the held arc turns too far.

        Safe is ``Tc <= l/(kappa e_max)`` or ``omega_max Tc <= 1``.
        """
        if self.fidelity == "point_mass":  # a point has no heading that could turn too far
            return []
        e_max = self.error(self.points(pose))
        omega_max = self.team.speeds[:, 1].max() if self.saturation != "none" else np.inf
        longest = formation.largest_stable_period(self.k, self.T, self.l, e_max, omega_max)
        if self.period <= longest * (1.0 + 1e-9):
            return []
        return [
            "one command every {:g} s is too slow for l = {:g} m and kappa = k/T = {:g} /s with "
            "errors up to {:.3g} m: a robot may spin for ever. Wanted a period of at most "
            "l/(kappa e_max) = {:.3g} s, or a limit on the turn rate with omega_max Tc <= 1".format(
                self.period, self.l, self.k / self.T, e_max, self.l * self.T / (self.k * e_max)
            )
        ]

    @property
    def gain(self):
        """Return the law's continuous gain ``kappa = k/T`` [1/s]."""
        return self.k / self.T

    def error(self, hand):
        """Return the largest ``|alpha_i - alpha_i*|`` [m]."""
        return formation.error_norm(hand, self._offsets, self._closure)

    # What theory says of a run -------------------------------------------------------------------

    def prediction(self, start, time):
        """Return the hand points of (5), (m, n, d), at ``time`` (m,) [s], in steps of a command."""
        steps, share = commands_by(time, self.period), self.gain * self.period
        return formation.predicted_after(steps, start, self._offsets, self._closure, share)

    def energy(self, start):
        """Return the energy of what robots are off each other's places."""
        return LinearErrors.energy(self, start)

    def error_matrix(self):
        """Return ``kappa D^-1 L``, (n, n) [1/s]."""
        return self.gain * self._laplacian()

    def reference(self, time):
        """Return the places on the line, (n, d) [m]."""
        return self._offsets

    def _laplacian(self):
        """Return ``D^-1 L``, (n, n), with rows of zeros for robots without neighbours."""
        weights = self.published().weights
        in_weight = weights.sum(axis=1)
        laplacian = np.diag(in_weight) - weights
        laplacian[in_weight > 0.0] /= in_weight[in_weight > 0.0, np.newaxis]
        return laplacian

    def _left_by_deadband(self):
        """Return how far [m] a dead band may leave any two robots, and consecutive ones, off the line.

        Robots rest where ``kappa D^-1 L (alpha - d)`` is a velocity that the dead band swallows.
        """
        n = len(self.numbers)
        if not self.deadband or n < 2 or n > MOST_ROBOTS or self.k <= 0.0:
            return 0.0, 0.0
        most = robots_of(self).sizes(np.full((n, len(self.team.axes)), self.deadband))
        places = np.linalg.pinv(self._laplacian()) * most / self.gain
        between = np.abs(places[:, np.newaxis] - places).sum(axis=2)
        return float(between.max()), float(np.diagonal(between, 1).max())

    def claims(self, start):
        """Return what theory predicts of a run from hand points ``start`` (n, d)."""
        if self._closure.edges and not self._closure.has_spanning_tree():
            return [
                Condition(
                    "spanning tree", False, "some robots receive from no common one", necessary=True
                )
            ]
        tolerance, (apart, gap) = TOLERANCES[self.fidelity], self._left_by_deadband()
        claims = [
            Claim(
                "y spread [m]",
                0.0,
                tolerance.spread + apart,
                lambda run: formation.y_spread(run.hand[-1]),
            )
        ]
        if len(self.numbers) > 1:
            claims.insert(
                0, Claim("final gap, the worst [m]", self.c, tolerance.gap + gap, self._worst_gap)
            )
        steps = self._settling_steps(start)
        if steps is not None:
            allowed = (tolerance.settling * steps + 1.0) * self.period
            # One factor for the whole team re-times the motion.
            claims.append(
                Claim(
                    "settling time [s]",
                    steps * self.period,
                    allowed,
                    self._crossing,
                    free=self.saturation == "team",
                )
            )
        place = formation.limit(start, self._offsets, self._closure)
        # Robot n anchors the chain whatever the limits; the other closures keep a mean of all robots,
        # which limits on each robot do not.
        claims.append(
            Claim(
                "distance from final place [m]",
                0.0,
                tolerance.place + apart,
                lambda run: float(np.linalg.norm(run.hand[-1] - place, axis=1).max()),
                free=self.closure != "chain",
            )
        )
        return [self._sampling(), *claims]

    def _settling_steps(self, start):
        """Return in how many commands theory settles from ``start``, or None; a verdict asks thrice."""
        share = self.gain * self.period
        asked = share, np.asarray(start).tobytes()
        known, steps = self._settled
        if known != asked:  # a large team's takes longer than all else of its claims
            steps = formation.predicted_settling(
                start, self._offsets, self._closure, share, SETTLED
            )
            self._settled = asked, steps
        return steps

    def _sampling(self):
        """Return the sampling rule: held commands contract where ``(k/T) Tc`` is below ``2/lambda_max``.

        Of L with rows divided by their degrees.  Unicycles turn meanwhile and may ask for more, which
        :meth:`warnings` states.
        """
        share, name = self.gain * self.period, "(k/T) Tc < 2/lambda_max"
        if len(self.numbers) > MOST_ROBOTS:
            return below(name, share, 1.0)  # lambda_max is at most 2
        return below(name, share, stable_step(np.linalg.eigvals(self._laplacian())))

    def claims_over_links(self, start):
        """Return the shape, and as far as theory knows the edges the place and the rate."""
        law = self.over_links()
        known = law and linear_claims(law, start)
        if not known or isinstance(known[-1], Condition):
            return known
        shape = [c for c in self.claims(start) if c.name.startswith(("final gap", "y spread"))]
        return known + shape

    def over_links(self):
        """Return law (6) as ``Linear``, with the weights of a mean; None where means change as edges do."""
        closure = self._closure
        arcs, weights, _ = arcs_of(closure)
        if self.links.changes_edges:
            if len(arcs) > len(closure.receivers):
                return None
            # The mean over one robot is that robot, whatever the weight.
            means = Topology(closure.n, [edge[:2] for edge in closure.edges], closure.directed)
        else:
            share = weights / closure.in_degree()[arcs[:, 0]]
            edges = [(i, j, part) for (i, j), part in zip((arcs + 1).tolist(), share.tolist())]
            means = Topology(closure.n, edges)
        place = TOLERANCES[self.fidelity].place
        return Linear(means, self.gain, self._offsets, self.period, self.links, place, 0.02)

    def _worst_gap(self, run):
        gaps = formation.line_gaps(run.hand[-1])
        return float(gaps[np.argmax(np.abs(gaps - self.c))])

    def _settling(self, run):
        errors = formation.error_norms(run.hand, self._offsets, self._closure)
        index = formation.settling_index(errors, SETTLED)
        return None if index >= len(errors) else float(run.time[index] - run.time[0])

    def _crossing(self, run):
        """Return when the errors come below ``SETTLED``, between two samples, as they decay there."""
        errors = formation.error_norms(run.hand, self._offsets, self._closure)
        index = formation.settling_index(errors, SETTLED)
        if index >= len(errors) or index == 0:
            return None if index else 0.0
        above, below = np.log(np.maximum(errors[index - 1 : index + 1], 1e-300))
        share = (above - np.log(SETTLED * errors[0])) / (above - below)
        time = run.time[index - 1 : index + 1] - run.time[0]
        return float(time[0] + share * (time[1] - time[0]))

    def measures(self, run):
        """Return settling time [s], final gaps (n-1,) [m] and y spread [m] of ``run``."""
        return {
            "settle_time": self._settling(run),
            "final_gaps": formation.line_gaps(run.hand[-1]).tolist(),
            "y_spread": formation.y_spread(run.hand[-1]),
        }
