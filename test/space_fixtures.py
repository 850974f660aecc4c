"""What tests of laws in space share: a team of points that go anywhere, and its runs."""

import numpy as np

from mrs_simulator.core.claims import Condition
from mrs_simulator.protocols import shipped
from mrs_simulator.record.recording import Run
from mrs_simulator.vehicles import Team

AXES = ("linear.x", "linear.y", "linear.z")


class Flyers(Team):
    """Points in space: the three numbers of a pose are a place, commands are velocities."""

    dimension = 3

    def __init__(self, n):
        super().__init__(("pioneer3dx",) * n, None)
        self.axes, self.robot_axes = AXES, np.ones((n, 3), dtype=bool)
        self.components = slice(3)
        self.ignored_axes = np.repeat([[False] * 3 + [True] * 3], n, axis=0)

    def point(self, pose, joints, l, pointing=None):
        return pose

    def command(self, velocity, pose, joints, l, period, pointing=None):
        return velocity

    def velocities_in(self, command, pose, points, l, period):
        return command


def flying(law, n, topology=None, period=0.02, **parameters):
    """Return the control of n points in space by ``law``, a class or the name of a shipped one."""
    law = shipped(law) if isinstance(law, str) else law
    return law(
        range(1, n + 1),
        topology,
        saturation="none",
        parameters=parameters,
        period=period,
        fidelity="point_mass",
        team=Flyers(n),
    )


def flown(control, start, duration):
    """Return the ``Run`` from ``start`` (n, d): the law's velocities, each held for a period."""
    steps = int(round(duration / control.period)) + 1
    hand = np.empty((steps,) + np.shape(start))
    command, point = np.empty_like(hand), np.array(start, dtype=float)
    for step in range(steps):
        control.time = step * control.period
        command[step], hand[step] = control.pointMassLaw(point), point
        point = point + control.period * command[step]
    time, robots = np.arange(steps) * control.period, np.arange(1, len(start) + 1)
    return Run(time, robots, np.zeros(hand.shape[:2] + (3,)), hand, command, [], None, {})


def wrong_claims(control, run):
    """Return the names of conditions that do not hold, or else of claims that the run misses."""
    claims = control.all_claims(run.hand[0])
    broken = [c.name for c in claims if isinstance(c, Condition) and not c.holds]
    return broken or [c.name for c in claims if not isinstance(c, Condition) and not _met(c, run)]


def _met(claim, run):
    value = claim.measure(run)
    if value is None:
        return False
    over = np.max(np.asarray(value) - claim.predicted)
    if claim.relation == "at least":
        return over >= -claim.tolerance
    return over <= claim.tolerance and (claim.relation == "at most" or over >= -claim.tolerance)
