"""Teams of which robots have arms: the controlled points are the tools, moved by base and arm together.

Commands (n, a + k) have a column for each axis of the bases and one for each joint of the arms, ``arm.1``
to ``arm.k`` [rad/s]; joints (n, 1 + k) have the drive's inner joint first, which no base with an arm has,
and the arm's.  Columns of joints that a robot has not stay 0.  Robots without an arm keep their own points.
"""

from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.state.columns import arm_axes
from mrs_simulator.vehicles.arms.chain import frames, jacobian
from mrs_simulator.vehicles.arms.inverse_kinematics import tool_inputs
from mrs_simulator.vehicles.arms.mounted import check_home
from mrs_simulator.vehicles.limits import AxisLimits
from mrs_simulator.vehicles.team import EVERY, Team

HOMEWARDS = 0.5  # [1/s] at which an arm returns to its home posture, where the tool lets it
LEVEL = 1.0  # [1/s] at which the tool returns to its height, under laws of points in the plane
PLANAR = ("linear.x", "linear.y", "angular.z")  # axes of a base, in the order of the Jacobians


class ArmGroup(NamedTuple):
    """The robots with one model of arm, m of them."""

    rows: Any  # (m,) in the team
    chain: Any
    placed: Any  # (m, 4, 4): the arms' roots in the bases' frames
    home: Any  # (m, k) [rad]
    columns: slice  # of its joints, among those of ``joints``
    height: Any  # (m,) [m] of the tools at home

    def tools(self, joints):
        """Return places (m, 3) [m] and Jacobians (m, 3, k) of the tools in the bases' frames."""
        found = frames(self.chain, joints[self.rows, self.columns])
        places = np.einsum("mij,mj->mi", self.placed, found[:, -1, :, 3])[:, :3]
        return places, self.placed[:, :3, :3] @ jacobian(self.chain, found)


class ArmedTeam(Team):
    """A ``Team`` of which robots have arms, under laws of points in the plane: tools keep their height."""

    has_arms = True

    def __init__(self, kinds, limits="firmware", relative_to="", own=None):
        """As ``Team``.  Raises ``ValueError``, also for an arm without a description."""
        super().__init__(kinds, limits, relative_to, own)
        self.bases = Team(self.kinds, limits)
        self._width = len(self.bases.axes)
        groups = _groups(self.kinds)
        self.arm_joints = max(len(group.chain.joints) for group in groups)
        self.arms = groups
        self.axes = self.bases.axes + arm_axes(self.arm_joints)
        # A group with all axes of the bases has none of the arms'.
        own = slice(0, self._width)
        self.groups = tuple(
            g._replace(columns=own) if g.columns is EVERY else g for g in self.groups
        )
        self.has_joints, self.limits_joints = True, False
        self._keep_arms()

    def _keep_arms(self):
        """Set the arms' joint limits and greatest speeds, (n, k), and which robots have which joints."""
        shape = self.n, self.arm_joints
        self.lower, self.upper = np.zeros(shape), np.zeros(shape)
        self.rates, home = np.zeros(shape), np.zeros((self.n, 1 + self.arm_joints))
        for group in self.arms:
            at = group.rows, slice(0, len(group.chain.joints))
            self.lower[at], self.upper[at] = group.chain.lower, group.chain.upper
            self.rates[at], home[group.rows, group.columns] = group.chain.speed, group.home
        self.rest_joints = home
        there = self.rates > 0.0
        self.robot_axes = np.column_stack([self.bases.robot_axes, there])
        limits = self.bases.limits.of_all(self.n)
        top = np.column_stack([limits.top, np.where(there, self.rates, np.inf)])
        never = np.full(shape, np.inf)
        self.limits = AxisLimits(top, np.column_stack([limits.acceleration, never]))
        # Which of the bases' axes are in the plane, and where they are among those of the Jacobians.
        self._planar = [i for i, axis in enumerate(self.bases.axes) if axis in PLANAR]
        self._places = [PLANAR.index(self.bases.axes[i]) for i in self._planar]
        own = {each: dict(zip(each.axes, each.limits["firmware"])) for each in set(self.kinds)}
        self._scale = np.array(
            [[own[each][axis].top if axis in own[each] else 0.0 for axis in PLANAR]
             for each in self.kinds]
        )  # fmt: skip

    def split(self, command):
        """Return the bases' part (..., n, a) of ``command`` (..., n, a + k), and the arms', (..., n, k)."""
        return command[..., : self._width], command[..., self._width :]

    # Points --------------------------------------------------------------------------------------

    def tools(self, pose, joints, l, pointing=None):
        """Return the controlled points in space, (n, 3) [m], of bases at ``pose`` (n, 3) on the ground.

        (n, 4) with heights of the bases, at which points of robots without an arm are.
        """
        result = np.zeros((self.n, 3))
        result[:, :2] = self.bases.point(pose[..., :3], joints[:, 0], l, pointing)
        for group in self.arms:
            places, _ = group.tools(joints)
            result[group.rows] = _outwards(places, pose[group.rows, 2])
            result[group.rows, :2] += pose[group.rows, :2]
        if pose.shape[1] > 3:
            result[:, 2] += pose[:, 3]
        return result

    def point(self, pose, joints, l, pointing=None):
        """Return the controlled points (n, d) [m] of robots at ``pose`` (n, 3) with ``joints`` (n, 1 + k).

        Of many samples, (..., n, ...) each, too.
        """
        if pose.ndim > 2:
            joints = np.broadcast_to(joints, pose.shape[:-1] + joints.shape[-1:])
            return np.array([self.point(*each, l) for each in zip(pose, joints)])
        return self.tools(pose, joints, l, pointing)[:, : self.dimension]

    def pointing(self, pose, joints):
        """Return cosine and sine of the headings in which the bases' points lie, (..., n)."""
        return self.bases.pointing(pose, joints[..., 0])

    def lead(self, l):
        """Return how far [m] the controlled points are from the centres at home, (n,)."""
        result = np.broadcast_to(self.bases.lead(l), self.n).astype(float)
        for group in self.arms:
            places, _ = group.tools(self.rest_joints)
            result[group.rows] = np.hypot(places[:, 0], places[:, 1])
        return result

    # Commands ------------------------------------------------------------------------------------

    def command(self, velocity, pose, joints, l, period, pointing=None):
        """Return the commands (n, a + k) that give the points ``velocity`` (n, d) [m/s].

        Held for ``period`` [s] they do so in the mean, but for terms of its third power: bases turn and
        arms bend meanwhile, so that the mapping is taken at the middle.  Arms return home as far as the
        tools let them; none is sent beyond its ends.
        """
        given = velocity[:, :2], pose[..., :3], joints[:, 0], l, period, pointing
        result = np.zeros((self.n, len(self.axes)), order="F")
        result[:, : self._width] = self.bases.command(*given)
        for group in self.arms:
            heading, half = pose[group.rows, 2], 0.5 * period
            found = self._inputs(group, velocity, heading, joints, joints, period)
            middle = joints.copy()
            middle[group.rows, group.columns] += half * found[:, 3:]
            turned = heading + half * found[:, 2]
            found = self._inputs(group, velocity, turned, joints, middle, period)
            end = self._width + len(group.chain.joints)
            result[group.rows, : self._width] = 0.0
            result[np.ix_(group.rows, self._planar)] = found[:, self._places]
            result[group.rows, self._width : end] = found[:, 3:]
        return result

    def _inputs(self, group, velocity, heading, joints, middle, period):
        """Return body twists and joint rates, (m, 3 + k), that move the tools of a ``group`` as wanted.

        The mapping is that at ``heading`` (m,) [rad] and joints ``middle`` (n, 1 + k).
        """
        rows, k = group.rows, len(group.chain.joints)
        places, inner = group.tools(middle)
        q = joints[rows, group.columns]
        wanted = np.empty((len(rows), 3))
        wanted[:, :2] = _inwards(velocity[rows, :2], heading)
        wanted[:, 2] = self._climb(group, velocity, places)
        scale = np.column_stack([self._scale[rows], self.rates[rows, :k]])
        besides = np.column_stack([np.zeros((len(rows), 3)), HOMEWARDS * (group.home - q)])
        free = np.full((len(rows), 3), np.inf)
        low = np.column_stack([-free, np.minimum((self.lower[rows, :k] - q) / period, 0.0)])
        high = np.column_stack([free, np.maximum((self.upper[rows, :k] - q) / period, 0.0)])
        return tool_inputs(_whole(places, inner), wanted, besides, scale, low, high)

    def command_within(self, velocity, pose, joints, l, period, scope, pointing=None):
        """Return :meth:`command` after :meth:`saturated`."""
        command = self.command(velocity, pose, joints, l, period, pointing)
        return self.saturated(command, joints, period, scope)

    def _climb(self, group, velocity, places):
        """Return how fast the tools of a ``group`` at ``places`` (m, 3) go up, (m,) [m/s]: back home."""
        return LEVEL * (group.height - places[:, 2])

    def velocity(self, command, pose, joints, l, period):
        base, rates = self.split(command)
        result = np.zeros((self.n, 3))
        result[:, :2] = self.bases.velocity(base, pose[..., :3], joints[:, 0], l, period)
        for group in self.arms:
            rows = group.rows
            places, inner = group.tools(joints)
            moved = np.zeros((len(rows), 3 + len(group.chain.joints)))
            moved[:, self._places] = base[rows][:, self._planar]
            moved[:, 3:] = rates[rows, : len(group.chain.joints)]
            own = np.einsum("mic,mc->mi", _whole(places, inner), moved)
            result[rows] = _outwards(own, pose[rows, 2])
        return result[:, : self.dimension]

    def velocities_in(self, command, pose, points, l, period, joints=None):
        """Return the points' velocities (m, n, d) [m/s] under recorded commands (m, n, a + k).

        ``joints`` (m, n, 1 + k) as recorded, by default at home.
        """
        if joints is None:
            joints = np.broadcast_to(self.rest_joints, (len(pose),) + self.rest_joints.shape)
        samples = zip(command, pose, joints)
        return np.array([self.velocity(*each, l, period) for each in samples])

    # Limits --------------------------------------------------------------------------------------

    def _beyond(self, rates):
        """Return by which factor the arms' ``rates`` (..., n, k) are beyond their speeds, (..., n)."""
        share = np.abs(rates) / np.where(self.rates > 0.0, self.rates, np.inf)
        return share.max(axis=-1)

    def excess(self, command, joints, period):
        base, rates = self.split(command)
        return np.maximum(self.bases.excess(base, joints[:, 0], period), self._beyond(rates))

    def at_limits(self, command, share=1.0):
        base, rates = self.split(command)
        return self.bases.at_limits(base, share) | (self._beyond(rates) >= share)

    def slowed(self, command, factor, joints):
        """Return ``command`` (n, a + k) with all speeds divided by ``factor`` (n,), at least 1.

        Of cars among them as their drive does it: their points keep their directions.
        """
        result = (command.T / np.asarray(factor)).T
        if self.bases.has_joints:
            base = self.bases.slowed(self.split(command)[0], factor, joints[:, 0])
            result[:, : self._width] = base
        return result

    def is_within(self, command):
        """Return False: arms' limits are checked by :meth:`saturated`."""
        return False

    def saturated(self, command, joints, period, scope):
        """Return ``command`` within each robot's limits, as ``Team.saturated`` does."""
        factor = np.maximum(self.excess(command, joints, period), 1.0)
        if scope == "team":
            factor = np.full(self.n, factor.max())
        return self.slowed(command, factor, joints)

    def joints_after(self, command, joints, period):
        """Return the joints, (n, 1 + k), after ``period`` [s] of ``command`` (n, a + k)."""
        base, rates = self.split(command)
        drives = self.bases.joints_after(base, joints[:, 0], period)
        return np.column_stack([drives, self.moved(joints[:, 1:], rates, period)])

    def moved(self, q, rates, duration):
        """Return the arms' joints (n, k) [rad] after ``duration`` [s] at ``rates`` (n, k) [rad/s].

        None is faster than it can be, or goes beyond its ends.
        """
        rates = np.clip(rates, -self.rates, self.rates)
        return np.clip(q + duration * rates, self.lower, self.upper)


class ArmedTeamInSpace(ArmedTeam):
    """An ``ArmedTeam`` under laws of points in space: d = 3."""

    dimension = 3

    def __init__(self, kinds, limits="firmware", relative_to="", own=None):
        """As ``ArmedTeam``.  Raises ``ValueError`` that names a robot without an arm."""
        super().__init__(kinds, limits, relative_to, own)
        for row, each in enumerate(self.kinds):
            if each.arm is None:
                text = "control.dimension: 3, but robot{}, a {}, has no arm; wanted 2"
                raise ValueError(text.format(row + 1, each.title))

    def _climb(self, group, velocity, places):
        return velocity[group.rows, 2]


def has_arms(kinds):
    """Return whether any of ``kinds``, of ``Kind``, has an arm."""
    return any(each.arm is not None for each in kinds)


def _groups(kinds):
    rows_of = {}
    for row, each in enumerate(kinds):
        if each.arm is not None:
            rows_of.setdefault(each.arm.model.name, []).append(row)
    return tuple(_group(kinds, rows) for rows in rows_of.values())


def _group(kinds, rows):
    arms = [kinds[row].arm for row in rows]
    for row, arm in zip(rows, arms):
        check_home(arm, "robot{}, {}".format(row + 1, kinds[row].title))
    chain = arms[0].chain
    columns = slice(1, 1 + len(chain.joints))
    group = ArmGroup(
        rows=np.array(rows),
        chain=chain,
        placed=np.array([arm.placed for arm in arms]),
        home=np.array([arm.home for arm in arms]),
        columns=columns,
        height=None,
    )
    joints = np.zeros((len(kinds), columns.stop))
    joints[rows, columns] = group.home
    places, _ = group.tools(joints)
    return group._replace(height=places[:, 2])


def _whole(places, inner):
    """Return the Jacobians (m, 3, 3 + k) of tools at ``places`` (m, 3) by vx, vy, omega and the joints.

    ``inner`` (m, 3, k): those by the joints; all in the bases' frames, in which a turn of the base moves
    a tool by ``omega (-y, x, 0)``.
    """
    base = np.zeros((len(places), 3, 3))
    base[:, 0, 0] = base[:, 1, 1] = 1.0
    base[:, 0, 2], base[:, 1, 2] = -places[:, 1], places[:, 0]
    return np.concatenate([base, inner], axis=2)


def _outwards(vectors, theta):
    """Return ``vectors`` (m, 3) of the bases' frames in the common frame."""
    cos, sin = cos_sin(theta)
    x, y = vectors[:, 0], vectors[:, 1]
    return np.column_stack([cos * x - sin * y, sin * x + cos * y, vectors[:, 2]])


def _inwards(vectors, theta):
    """Return ``vectors`` (m, 2) of the common frame in the bases' frames."""
    cos, sin = cos_sin(theta)
    x, y = vectors[:, 0], vectors[:, 1]
    return np.column_stack([cos * x + sin * y, cos * y - sin * x])
