"""Carrying a load together along a path, with what theory claims of such runs.

The load's grasps ``r_i`` are a formation: where the load is wanted at ``x(t)``, turned by ``psi(t)``, robot
i's tool is wanted at ``p_i* = x + R(psi) r_i``, and

    u_i = p_i*' + gain (p_i* - p_i) + coupling sum_j a_ij (e_j - e_i),    e_i = p_i - p_i*.

The errors obey ``e' = -(gain I + coupling L) e``.  On undirected graphs their mean, by which the load is
off its path, decays at ``gain``; what is left of them, which pulls the grips against each other, at no less
than ``gain + coupling lambda_2``.  Between grips of stiffness K the internal force of robot i is K times
its misfit; it ends at zero, and each then carries its share ``G+ w`` of the weight (``core.grasps``).
"""

import numpy as np

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.control.twists import ControlError
from mrs_simulator.core import grasps
from mrs_simulator.core.claims import Claim, decay_rate
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.kinematics import cos_sin, phase_of
from mrs_simulator.core.spatial import headings, rotated, turned_about_z
from mrs_simulator.protocols.common import attracting, below
from mrs_simulator.protocols.curves import Curve
from mrs_simulator.protocols.linear_errors import Tracking
from mrs_simulator.protocols.published.laws import weights_of
from mrs_simulator.protocols.shapes.law import TOLERANCES, undirected
from mrs_simulator.protocols.shapes.published import Marching, least_snap
from mrs_simulator.protocols.trajectory.equations import minimum_snap
from mrs_simulator.protocols.trajectory.law import read_waypoints

DECAY = "decay rate of the internal force over the exact solution's [-]"
FAINT = 0.2  # [N] down to which their decay is looked at: tools on bends hold it up
REST = 2.0  # [N] of internal force that a run may end with, without forces of motion
SHARE = 0.1  # [-] of the largest internal force, by which a run may be off theory


class Carrying(Tracking, PioneerControl):
    """A load carried along a minimum-snap path through waypoints, by the tools of arms in formation.

    Each is drawn to its grasp on the moving load, and to its neighbours' errors, against internal forces.

    Theorem: on an undirected graph with the second eigenvalue ``lambda_2`` of its Laplacian, the load's
    way off its path decays at ``gain``, and internal forces decay at least at ``gain + coupling lambda_2``;
    each robot then carries its share ``G+ w`` of the weight w, G the grasp matrix.
    """

    PARAMETERS = (
        Parameter("gain", 0.5, "1/s", low=-10.0, high=100.0, meaning="to the place on the path"),
        Parameter(
            "coupling",
            0.5,
            "1/s",
            low=0.0,
            high=100.0,
            meaning="to the neighbours' errors, against internal forces",
        ),
        Parameter(
            "waypoints",
            "0 0 0, 4 0 0",
            "m, rad",
            meaning="of the load: its place, d numbers, and its yaw",
        ),
        Parameter(
            "speed",
            0.1,
            "m/s",
            **POSITIVE,
            high=10.0,
            meaning="mean, between two of them; a radian counts as a metre",
        ),
    )
    DIMENSIONS = (2, 3)
    load = None  # ``load.Load``

    def carry(self, load):
        """Carry ``load``, a ``load.Load``; ``ControlError`` without one."""
        if load is None:
            raise ControlError("carrying: the scenario has no load, wanted one under the key load")
        self.load, self._grasps = load, np.array(load.grasps)[:, : self.dimension]

    def checked_parameters(self, given):
        """Return all values; waypoints that make no path are refused."""
        values = super().checked_parameters(given)
        read_waypoints(values["waypoints"], self.dimension + 1)
        return values

    def set_parameters(self, given):
        """Set the parameters and lay out the path."""
        super().set_parameters(given)
        self._path = minimum_snap(read_waypoints(self.waypoints, self.dimension + 1), self.speed)

    def published(self):
        """Return the law as published: a march of the grasps."""
        path = least_snap(read_waypoints(self.waypoints, self.dimension + 1), self.speed)
        across, up = self._grasps[:, :2] @ [1.0, 1j], self._grasps[:, 2:]

        def wanted(time):
            *place, yaw = path(self._begun + time)
            turned = across * np.exp(1j * yaw)
            return np.column_stack([turned.real, turned.imag, up]) + place

        weights, blind = weights_of(self.topology), np.zeros(len(self.numbers), dtype=bool)
        return Marching(weights, self.coupling, self.gain, wanted, self.period, blind)

    def of_load(self, time):
        """Return where the load is wanted at ``time`` (m,) [s]: places (m, d) [m] and yaw (m,) [rad]."""
        at = self._path.at(self._begun + np.asarray(time, dtype=float))
        return at[:, :-1], at[:, -1]

    def wanted(self, time):
        place, yaw = self.of_load(time)
        cos, sin = (each[:, np.newaxis] for each in cos_sin(yaw))
        x, y, *up = self._grasps.T
        turned = [cos * x - sin * y, sin * x + cos * y, *(z + 0.0 * cos for z in up)]
        return np.stack(turned, axis=-1) + place[:, np.newaxis]

    def pointMassLaw(self, hand):
        now, then = self.wanted([self.time, self.time + self.period])
        error = hand - now
        drawn = self.coupling * (self.topology.laplacian() @ error)
        return (then - now) / self.period - self.gain * error - drawn

    # What theory says of a run -------------------------------------------------------------------

    def error_matrix(self):
        """Return ``gain I + coupling L``, (n, n) [1/s]."""
        return self.gain * np.eye(len(self.numbers)) + self.coupling * self.topology.laplacian()

    def claims(self, start):
        """Return claims: the load follows its path; internal forces are as predicted and vanish."""
        greatest = float(np.abs(np.linalg.eigvals(self.error_matrix())).max())
        conditions = [
            attracting(self.gain),
            below("greatest eigenvalue times Tc < 2", greatest * self.period, 2.0, necessary=True),
            undirected(self.topology),
        ]
        place = TOLERANCES[self.fidelity].place
        force = REST if self.fidelity == "kinematic" else place * self.load.stiffness / 10.0
        off = float(np.linalg.norm((start - self.wanted([0.0])[0]).mean(axis=0)))
        most = float(self._misfit_forces(start[np.newaxis])[0])
        weight = self.load.weight[2]
        # Where wheels and joints have forces, grips are never quite at rest.
        decays = [] if self.fidelity == "dynamic" else [self._decay()]
        return [
            *conditions,
            *decays,
            Claim("load off its path [m]", off, place, self._off_path, "at most"),
            Claim("load off its path at the end [m]", 0.0, place, self._off_at_end),
            Claim("load turned off its path at the end [rad]", 0.0, place, self._turned_off),
            Claim("largest internal force [N]", most, SHARE * most + force, self._largest),
            Claim("internal force at the end [N]", 0.0, force, self._last),
            Claim("weight carried, mean [N]", weight, 0.02 * weight, self._carried),
            Claim("share off G+ w, mean [N]", 0.0, 0.02 * weight + force, self._off_share),
            Claim("robots that let go", 0, 0, self._let_go, motion=False),
        ]

    def _decay(self):
        """Return the claim that internal forces decay as those of the exact solution do meanwhile."""

        def share(run):
            track = self.prediction(run.hand[0], run.time - run.time[0])
            rates = [
                decay_rate(run.time, self._misfit_forces(hand), FAINT) for hand in (run.hand, track)
            ]
            return rates[0] / rates[1] if all(rates) else None

        return Claim(DECAY, 1.0, 0.02, share, free=True)

    def _points(self, run):
        """Return the tools of ``run`` in space, (m, n, 3) [m], at their grasps without recorded height."""
        if run.hand.shape[2] == 3:
            return run.hand
        height = run.point_z
        if height is None:
            height = np.broadcast_to(np.array(self.load.grasps)[:, 2], run.hand.shape[:2])
        return np.concatenate([run.hand, height[..., np.newaxis]], axis=2)

    def _lies(self, run):
        """Return where the load of ``run`` is, places (m, 3) [m] and quaternions (m, 4)."""
        if run.load is not None:
            return run.load.place, run.load.orientation
        return grasps.fitted_pose(np.array(self.load.grasps), self._points(run))

    def _hangs(self, run):
        """Return where the load of ``run`` hangs, at yaw 0; with forces alone its weight bends grips."""
        if run.load is None or self.fidelity != "dynamic":
            return np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
        own = np.array(self.load.grasps)
        return grasps.hanging_pose(own, own, self.load.weight, self.load.stiffness)

    def _errors(self, run):
        """Return by how much the load of ``run`` is off its path, (m,) [m] and (m,) [rad].

        Off where it would hang there, below and beside the path.
        """
        place, turn = self._lies(run)
        wanted, yaw = self.of_load(run.time - run.time[0])
        below = rotated(turned_about_z(yaw), np.broadcast_to(self._hangs(run)[0], place.shape))
        wanted = wanted + below[:, : self.dimension]
        off = np.linalg.norm(place[:, : self.dimension] - wanted, axis=1)
        return off, np.abs(phase_of(np.exp(1j * (headings(turn) - yaw))))

    def internal_forces(self, run):
        """Return the largest internal force of any robot at each sample of ``run``, (m,) [N].

        As recorded, beyond those of a load that hangs at rest; else K times the misfits of the tools.
        """
        place, turn = self._lies(run)
        at = grasps.grasp_points(np.array(self.load.grasps), place, turn)
        if run.load is not None:
            found = grasps.internal_forces(at - place[:, np.newaxis], run.load.force)
            found = found - rotated(
                turned_about_z(headings(turn))[:, np.newaxis], self._of_tilt(run)
            )
        else:
            found = self.load.stiffness * (self._points(run) - at)
        return np.linalg.norm(found, axis=2).max(axis=1)

    def _of_tilt(self, run):
        """Return the internal forces (n, 3) [N] of a load at rest that its weight tilts, at yaw 0."""
        place, turn = self._hangs(run)
        own = np.array(self.load.grasps)
        at = grasps.grasp_points(own, place, turn)
        return grasps.internal_forces(at - place, self.load.stiffness * (own - at))

    def _misfit_forces(self, hand):
        """Return the largest internal force (m,) [N] of tools at ``hand`` (m, n, d)."""
        points = hand
        if hand.shape[2] == 2:
            up = np.broadcast_to(np.array(self.load.grasps)[:, 2], hand.shape[:2])
            points = np.concatenate([hand, up[..., np.newaxis]], axis=2)
        own = np.array(self.load.grasps)
        off = points - grasps.grasp_points(own, *grasps.fitted_pose(own, points))
        return self.load.stiffness * np.linalg.norm(off, axis=2).max(axis=1)

    def _largest(self, run):
        return float(self.internal_forces(run).max())

    def _last(self, run):
        return float(self.internal_forces(run)[-1])

    def _off_path(self, run):
        return float(self._errors(run)[0].max())

    def _off_at_end(self, run):
        return float(self._errors(run)[0][-1])

    def _turned_off(self, run):
        return float(self._errors(run)[1][-1])

    def _forces(self, run):
        if run.load is None:  # theory's own run: each carries its share
            place, turn = self._lies(run)
            at = grasps.grasp_points(np.array(self.load.grasps), place, turn)
            return grasps.least_forces(at - place[:, np.newaxis], self.load.weight)
        return run.load.force

    def _carried(self, run):
        return float(self._forces(run)[:, :, 2].sum(axis=1).mean())

    def _off_share(self, run):
        place, turn = self._lies(run)
        arms = grasps.grasp_points(np.array(self.load.grasps), place, turn) - place[:, np.newaxis]
        force = self._forces(run)
        own = (
            force
            - grasps.internal_forces(arms, force)
            - grasps.least_forces(arms, self.load.weight)
        )
        return float(np.linalg.norm(own.mean(axis=0), axis=1).max())

    def _let_go(self, run):
        if run.load is None:
            return 0
        return int((~run.load.force.any(axis=2)).any(axis=0).sum())

    def curves(self, run):
        """Return the load's path error and the internal force against time."""
        time = run.time - run.time[0]
        track = self.predicted_track(run.hand[0], time)
        predicted = None if track is None else self._misfit_forces(track)
        mean = None
        if track is not None:
            mean = np.linalg.norm((track - self.wanted(time)).mean(axis=1), axis=1)
        return [
            Curve("load off its path [m]", time, self._errors(run)[0], predicted=mean),
            Curve(
                "largest internal force [N]", time, self.internal_forces(run), predicted=predicted
            ),
        ]
