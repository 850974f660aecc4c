"""Robots with arms under a published law: tools, their mapping and their motion, written a second time.

Nothing is shared with ``vehicles.arms``, which moves the robots, but the numbers of the kinds and of the
arms' descriptions.  With every joint at 0 joint i turns about an axis ``a_i`` through ``o_i`` (or slides
along it), and the tool is at ``p``; at positions q the last joint moves the tool first, the first joint
last (a product of exponentials: Lynch and Park, Modern Robotics, 2017, 4.1)

    p <- o_i + R(a_i, q_i) (p - o_i),    i = k, ..., 1.
"""

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.protocols.published.robots import Robots, complex_of

HOME = 0.5  # [1/s] share of the way home that joints are wanted to go besides
UP = 1.0  # [1/s] share of the way to its height at home that a tool goes, in the plane
EASY, DAMPED = 0.05, 0.05  # [m/s] least singular value without damping, and the damping at 0
BASE = ("linear.x", "linear.y", "angular.z")
OFF = 1e-9  # [m/s] from what was wanted of a tool, beyond which it is not reached


class Tools:
    """The m arms of one model of a team."""

    def __init__(self, kinds, rows):
        """``kinds``: all of the team's; ``rows`` (m,): those of robots with this model."""
        arms, self.rows = [kinds[row].arm for row in rows], np.array(rows)
        self.chain = chain = arms[0].chain
        x, y, self._up, self._yaw = np.array([arm.mount for arm in arms]).T
        self._foot = x + 1j * y
        self.home = np.array([arm.home for arm in arms])
        frame, axes, origins = np.eye(4), [], []
        for before, axis in zip(chain.before, chain.axes):
            frame = frame @ before
            axes.append(frame[:3, :3] @ axis)
            origins.append(frame[:3, 3])
        self._axes, self._origins = np.array(axes), np.array(origins)
        self._across = np.cross(self._axes[:, np.newaxis], np.eye(3))  # v @ that is axis x v
        self._tool = (frame @ chain.tool)[:3, 3]
        self.height = self.at(self.home)[0][:, 2]

    def at(self, q):
        """Return places (m, 3) [m] of the tools in the bases' frames at ``q`` (m, k), and Jacobians.

        Those are (m, 3, 3 + k): by vx, vy and omega of the base, and by the joints.
        """
        m, k = q.shape
        moved = np.zeros((m, k + 1, 3))  # what each joint does, and the place
        moved[:, k] = self._tool
        for i in reversed(range(k)):
            if self.chain.slides[i]:
                moved[:, i] = self._axes[i]
                moved[:, k] += np.multiply.outer(q[:, i], self._axes[i])
                continue
            moved[:, k] -= self._origins[i]
            moved[:, i + 1 :] = _turned(moved[:, i + 1 :], self._across[i], q[:, i])
            moved[:, i] = moved[:, k] @ self._across[i]
            moved[:, k] += self._origins[i]
        across = moved[..., 0] + 1j * moved[..., 1]
        moved[..., 0], moved[..., 1] = _pair(across * np.exp(1j * self._yaw)[:, np.newaxis])
        place = moved[:, k] + np.column_stack([*_pair(self._foot), self._up])
        columns = np.zeros((m, 3, 3 + k))
        columns[:, 0, 0] = columns[:, 1, 1] = 1.0
        columns[:, 0, 2], columns[:, 1, 2] = -place[:, 1], place[:, 0]
        columns[:, :, 3:] = np.swapaxes(moved[:, :k], 1, 2)
        return place, columns


class ArmedRobots(Robots):
    """A team of robots of stated drives, some of them with arms, whose points are then their tools."""

    stacks = False  # postures differ from team to team

    def __init__(self, team, l, period, scope, frozen=False):
        """As ``Robots``; ``team``: a ``vehicles.arms.ArmedTeam``."""
        super().__init__(team.bases, l, period, scope, frozen)
        self.dimension, self._period = team.dimension, period
        self._width, self._joints = len(team.bases.axes), team.arm_joints
        by_model = {}
        for row, kind in enumerate(team.kinds):
            if kind.arm is not None:
                by_model.setdefault(kind.arm.model, []).append(row)
        self.arms = [Tools(team.kinds, rows) for rows in by_model.values()]
        self.q = np.zeros((team.n, self._joints))
        self._speed, self._low, self._high = (np.zeros_like(self.q) for _ in range(3))
        for arm in self.arms:
            own = np.ix_(arm.rows, range(arm.home.shape[1]))
            self.q[own], self._speed[own] = arm.home, arm.chain.speed
            self._low[own], self._high[own] = arm.chain.lower, arm.chain.upper
        self._places = [
            (k, BASE.index(axis)) for k, axis in enumerate(team.bases.axes) if axis in BASE
        ]
        self._fastest = np.array([_speeds(kind) for kind in team.kinds])
        self._short = np.zeros(team.n, dtype=bool)  # whose tool could not do what was wanted last

    def be(self, pose, points=None, joints=None):
        """Be at rest at ``pose`` (n, 3), arms at ``joints`` (n, 1 + k) [rad], or else where they are."""
        super().be(pose, points)
        if joints is not None:
            self.q = np.array(joints[:, 1:])

    def be_as(self, run, row):
        self.be(run.pose[row], run.hand[row], None if run.joints is None else run.joints[row])

    @property
    def points(self):
        """Return the controlled points (n, d) [m]: tools, and of robots without arms as ever."""
        result = np.zeros((self.team.n, 3))
        result[:, :2] = super().points
        pose = self.pose
        for arm in self.arms:
            place, _ = arm.at(self._of(arm))
            result[arm.rows] = _turn_out(place, pose[arm.rows, 2])
            result[arm.rows, :2] += pose[arm.rows, :2]
        return result[:, : self.dimension]

    def _of(self, arm):
        return self.q[arm.rows, : arm.home.shape[1]]

    def commands(self, u):
        """Return the commands (n, a + k) for velocities ``u`` (n, d) [m/s] of the points, within limits.

        The mapping is that of the middle of the period, where what is wanted at its begin leads.
        """
        self._short[:] = False
        result = np.zeros((self.team.n, self._width + self._joints))
        w = complex_of(u)
        result[:, : self._width] = self._columns(lambda g, part: part.commands(w[g.rows]))
        theta = self.pose[:, 2]
        for arm in self.arms:
            now, then = self._of(arm), theta[arm.rows]
            first, _ = self._inputs(arm, u, then, now)
            half = 0.5 * self._period * first
            found, short = self._inputs(arm, u, then + half[:, 2], now + half[:, 3:])
            self._short[arm.rows] = short
            result[arm.rows, : self._width] = 0.0
            for column, place in self._places:
                result[arm.rows, column] = found[:, place]
            result[np.ix_(arm.rows, range(self._width, self._width + now.shape[1]))] = found[:, 3:]
        return self.limited(result)

    def _inputs(self, arm, u, theta, q):
        """Return inputs (m, 3 + k) that move tools by ``u``, with the mapping at ``theta`` and ``q``.

        And whose tools do not go so, (m,) bool.
        """
        place, columns = arm.at(q)
        wanted = np.empty((len(q), 3))
        wanted[:, 0], wanted[:, 1] = _pair(complex_of(u[arm.rows]) * np.exp(-1j * theta))
        wanted[:, 2] = u[arm.rows, 2] if u.shape[1] == 3 else UP * (arm.height - place[:, 2])
        now, k = self._of(arm), q.shape[1]
        low, high = (each[arm.rows, :k] - now for each in (self._low, self._high))
        top = np.column_stack([self._fastest[arm.rows], self._speed[arm.rows, :k]])
        free = np.full((len(q), 3), np.inf)
        low = np.column_stack([-free, low / self._period])
        high = np.column_stack([free, high / self._period])
        besides = np.column_stack([0.0 * wanted, HOME * (arm.home - now)])
        found = _least(columns, wanted, besides, top, low, high)
        off = np.einsum("mij,mj->mi", columns, found) - wanted
        return found, np.linalg.norm(off, axis=1) > OFF

    def velocities(self, command):
        """Return the points' mean velocities (n, d) [m/s] while ``command`` (n, a + k) is held.

        Those of the middle of the period.
        """
        result = np.zeros((self.team.n, 3))
        result[:, :2] = super().velocities(command[:, : self._width])
        for arm, inputs in self._tool_inputs(command):
            half = 0.5 * self._period * inputs
            _, columns = arm.at(self._of(arm) + half[:, 3:])
            moved = np.einsum("mij,mj->mi", columns, inputs)
            result[arm.rows] = _turn_out(moved, self.pose[arm.rows, 2] + half[:, 2])
        return result[:, : self.dimension]

    def _tool_inputs(self, command):
        """Yield ``Tools`` and their inputs (m, 3 + k) under ``command`` (n, a + k)."""
        for arm in self.arms:
            k = arm.home.shape[1]
            inputs = np.zeros((len(arm.rows), 3 + k))
            for column, place in self._places:
                inputs[:, place] = command[arm.rows, column]
            inputs[:, 3:] = command[arm.rows, self._width : self._width + k]
            yield arm, inputs

    def twists(self, command):
        """Return the commands (n, a + k) for ``(v, omega)`` (n, 2) of each base, arms at rest."""
        return np.pad(super().twists(command), [(0, 0), (0, self._joints)])

    def unicycle(self, command):
        """Return ``(v, omega)`` (n, 2) of the bases, of commands (n, a + k)."""
        return super().unicycle(command[:, : self._width])

    def sizes(self, command):
        """Return how fast ``command`` (n, a + k), or a difference, moves the points at most, (n,) [m/s].

        Each joint's part is added to the base's, so that a motion of joints alone counts, too.
        """
        result = super().sizes(command[:, : self._width])
        for arm, inputs in self._tool_inputs(command):
            _, columns = arm.at(self._of(arm))
            result[arm.rows] = np.linalg.norm(columns * inputs[:, np.newaxis], axis=1).sum(axis=1)
        return result

    def _factors(self, command):
        share = np.abs(command[:, self._width :]) / np.where(self._speed > 0.0, self._speed, np.inf)
        return np.maximum(super()._factors(command[:, : self._width]), share.max(axis=1))

    def _full(self):
        return super()._full() | self._short

    def _slowed(self, command, factor):
        base = super()._slowed(command[:, : self._width], factor)
        return np.column_stack([base, command[:, self._width :] / factor[:, np.newaxis]])

    def move(self, command, duration, parts=1):
        """Move for ``duration`` [s] under ``command`` (n, a + k), the bases in ``parts``."""
        super().move(command[:, : self._width], duration, parts)
        rates = np.clip(command[:, self._width :], -self._speed, self._speed)
        self.q = np.clip(self.q + duration * rates, self._low, self._high)

    def lag(self, command):
        """Return whose base has not reached the speeds of ``command`` (n, a + k) yet, (n,) bool."""
        return super().lag(command[:, : self._width])


def robots_of(control, frozen=False):
    """Return the ``Robots`` of ``control``'s team; ``frozen``: point masses, whose headings stay."""
    made = ArmedRobots if control.team.has_arms else Robots
    robots = made(control.team, control.l, control.period, control.saturation, frozen)
    robots.deadband = control.deadband
    return robots


def _speeds(kind):
    """Return how fast the base of ``kind`` is along ``BASE``, (3,); 0 where it does not go."""
    own = dict(zip(kind.axes, kind.limits["firmware"]))
    return [own[axis].top if axis in own else 0.0 for axis in BASE]


def _least(columns, wanted, besides, top, low, high):
    """Return the inputs (m, c) nearest to ``besides`` by which tools go as ``wanted`` (m, 3).

    By singular values, each input measured by its ``top``; one beyond ``low`` or ``high`` is held there.
    """
    held, x = top <= 0.0, np.clip(besides, low, high) * (top > 0.0)
    while True:
        scale = np.where(held, 0.0, top)
        u, s, v = np.linalg.svd(columns * scale[:, np.newaxis], full_matrices=False)
        damping = DAMPED**2 * np.maximum(0.0, 1.0 - (s[:, -1:] / EASY) ** 2)
        left = wanted - np.einsum("mij,mj->mi", columns, x)
        y = s / (s**2 + damping) * np.einsum("mji,mj->mi", u, left)
        found = x + scale * np.einsum("mji,mj->mi", v, y)
        beyond = ~held & ((found < low - 1e-12) | (found > high + 1e-12))
        if not beyond.any():
            return np.clip(found, low, high)
        x = np.where(beyond, np.clip(found, low, high), x)
        held |= beyond


def _turned(vectors, across, angle):
    """Return ``vectors`` (m, j, 3) turned by ``angle`` (m,) [rad] about a; ``v @ across`` is a x v."""
    cos, sin = (each[:, np.newaxis, np.newaxis] for each in cos_sin(angle))
    once = vectors @ across
    return vectors + sin * once + (1.0 - cos) * (once @ across)


def _turn_out(vectors, theta):
    """Return ``vectors`` (m, 3) of the bases' frames in the common frame."""
    turned = complex_of(vectors) * np.exp(1j * theta)
    return np.column_stack([*_pair(turned), vectors[:, 2]])


def _pair(values):
    return values.real, values.imag
