"""Robots under a published law: commands, limits and motion as :mod:`published.drives` states them."""

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.protocols.published.drives import STATED, Unicycles

AT_LIMIT = 0.999  # [-] of a limit, from which on it counts as reached


class Robots:
    """A team of robots of stated drives; arrays (n, ...) hold one robot per row.

    Where it ``stacks``, arrays (k, n, ...) hold k such teams, which know nothing of each other.
    """

    def __init__(self, team, l, period, scope, frozen=False):
        """``team``: a ``vehicles.Team``; ``l`` [m]; ``period`` [s] of a command; ``scope`` of saturation;
        ``frozen``: point masses, whose headings stay."""
        self.team, self.l, self.scope, self.frozen = team, l, scope, frozen
        self.parts = [(g, STATED[g.drive](g, l, period)) for g in team.groups]
        self._climb = team.axes.index("linear.z") if team.dimension == 3 else None
        self.is_ramped = any(part.is_ramped for _, part in self.parts)
        self.deadband = 0.0  # [m/s, rad/s] up to which commands are sent as zero
        self.drift = np.zeros(team.n, dtype=complex)  # [m/s] by which a current carries them
        self.limited_now = np.zeros(team.n, dtype=bool)  # at a limit under the last ``limited``

    @property
    def stacks(self):
        """Return whether several teams can be reckoned at once."""
        return len(self.parts) == 1 and type(self.parts[0][1]) is Unicycles

    def be(self, pose, points=None):
        """Be at rest at ``pose`` (n, 3); with ``points`` (n, d) [m], steered so that they are there."""
        z = complex_of(pose)
        seen = None if points is None else complex_of(points)
        for g, part in self.parts:
            own, theta = z[..., g.rows], np.array(pose[..., g.rows, 2])
            steered = np.zeros(own.shape)
            if seen is not None:
                steered = part.angles_at(seen[..., g.rows], own, theta)
            part.be(own, theta, steered)
            if self._climb is not None:
                part.begin_at(np.array(points[g.rows, 2]))

    def be_as(self, run, row):
        """Be at rest where the robots of ``run`` are in the sample ``row``."""
        self.be(run.pose[row], run.hand[row])

    def speed_up(self, twist, climb=None):
        """Be as fast as body ``twist`` (n, 3) [m/s, m/s, rad/s] and ``climb`` (n,) [m/s] say."""
        for g, part in self.parts:
            part.speed_up(twist[g.rows], None if climb is None else climb[g.rows])
            if g.drive.MEDIUM == "water":
                part.velocity[:, 0] -= (self.drift[g.rows] * np.exp(-1j * part.theta)).real

    @property
    def pose(self):
        """Return the poses (n, 3), headings not wrapped."""
        result = np.empty(self.parts[0][1].z.shape[:-1] + (self.team.n, 3))
        for g, part in self.parts:
            result[..., g.rows, 0], result[..., g.rows, 1] = part.z.real, part.z.imag
            result[..., g.rows, 2] = part.theta
        return result

    @property
    def points(self):
        """Return the controlled points (n, d) [m]."""
        across = self._pairs(lambda g, part: part.points())
        if self._climb is None:
            return across
        return np.column_stack([across, self._values(lambda g, part: part.height)])

    def commands(self, u):
        """Return the commands (n, a) for velocities ``u`` (n, d) [m/s] of the points, within limits."""
        w = complex_of(u)
        wanted = self._columns(lambda g, part: part.commands(w[..., g.rows]))
        if self._climb is not None:
            wanted[:, self._climb] = u[:, 2]
        return self.limited(wanted)

    def velocities(self, command):
        """Return the points' mean velocities (n, d) [m/s] while ``command`` (n, a) is held."""
        across = self._pairs(lambda g, part: part.velocities(g.of(command)))
        return across if self._climb is None else np.column_stack([across, command[:, self._climb]])

    def twists(self, command):
        """Return the commands (n, a) for ``(v, omega)`` (n, 2) of each robot."""
        return self._columns(lambda g, part: part.twists(command[g.rows]))

    def unicycle(self, command):
        """Return ``(v, omega)`` (n, 2) of commands (n, a)."""
        result = np.empty((self.team.n, 2))
        for g, part in self.parts:
            result[g.rows] = part.unicycle(g.of(command))
        return result

    def sizes(self, command):
        """Return how fast each ``command`` (n, a), or a difference of two, moves the points, (n,) [m/s]."""
        return self._values(lambda g, part: part.sizes(g.of(command)))

    def limited(self, command, scope=None):
        """Return ``command`` (n, a) as saturation, by ``scope`` or the team's, and dead band leave it."""
        scope = scope or self.scope
        factor = self._factors(command)
        self.limited_now = (factor >= AT_LIMIT) | self._full()
        if scope != "none":
            factor = np.maximum(factor, 1.0)
            if scope == "team":
                factor[:] = factor.max(axis=-1, keepdims=True)
            command = self._slowed(command, factor)
        if self.deadband:
            moves = (np.abs(command) > self.deadband).any(axis=-1)
            command = np.where(moves[..., np.newaxis], command, 0.0)
        return command

    def _factors(self, command):
        """Return by which factor each ``command`` (n, a) is beyond a limit, (n,)."""
        return self._values(lambda g, part: part.excess(g.of(command)))

    def _full(self):
        """Return whose inner joint is at its limit, (n,) bool."""
        return self._values(lambda g, part: part.is_full()) > 0.0

    def _slowed(self, command, factor):
        """Return ``command`` (n, a), each slowed by ``factor`` (n,)."""
        return self._columns(lambda g, part: part.slowed(g.of(command), factor[..., g.rows]))

    def move(self, command, duration, parts=1):
        """Move for ``duration`` [s] under ``command`` (n, a), in ``parts`` while anything ramps."""
        for g, part in self.parts:
            own, left = g.of(command), parts
            part.z = part.z + duration * self.drift[g.rows]
            if self.frozen:
                part.z = part.z + duration * part.velocities(own)
                if self._climb is not None:
                    part.height = part.height + duration * command[g.rows, self._climb]
                continue
            while left:
                steady = left > 1 and part.is_steady(own)
                taken = left if steady else 1
                part.move(own, duration * taken / parts)
                left -= taken

    def lag(self, command):
        """Return who has not reached the speeds of ``command`` (n, a) yet, (n,) bool."""
        return self._values(lambda g, part: part.lags(g.of(command))) > 0.0

    # Of one drive alone the whole team is its part.

    def _values(self, of_part):
        if len(self.parts) == 1:
            return of_part(*self.parts[0])
        result = np.empty(self.team.n)
        for g, part in self.parts:
            result[g.rows] = of_part(g, part)
        return result

    def _pairs(self, of_part):
        if len(self.parts) == 1:
            pairs = of_part(*self.parts[0])
            return pairs.view(float).reshape(pairs.shape + (2,))
        result = np.empty(self.team.n, dtype=complex)
        for g, part in self.parts:
            result[g.rows] = of_part(g, part)
        return result.view(float).reshape(-1, 2)

    def _columns(self, of_part):
        if len(self.parts) == 1:
            return of_part(*self.parts[0])
        result = np.zeros((self.team.n, len(self.team.axes)))
        for g, part in self.parts:
            g.put(result, of_part(g, part))
        return result


def are_stated(team):
    """Return whether all drives of ``team`` are stated a second time."""
    return all(group.drive in STATED for group in team.groups)


def complex_of(points):
    """Return ``x + i y``, (n,), of ``points`` (n, 2 or more) [m]."""
    return points[..., 0] + 1j * points[..., 1]


def posed_commands(law, robots, pose, time):
    """Return the commands (n, a) of a law that sees ``pose`` (n, 3), wanted and within limits.

    Leaders' come before their followers': what a leader cannot do, its followers need not follow.
    """
    l, theta = robots.l, pose[:, 2]
    hand = pose[:, :2] + l * np.column_stack(cos_sin(theta))
    command = np.zeros((len(pose), 2))
    for below in reversed(range(law.depth)):
        wanted = robots.twists(law.commands(pose, hand, command, time, l))
        limited = robots.limited(wanted) if robots.scope == "robot" or not below else wanted
        if below:
            command = robots.unicycle(limited)
    return wanted, limited
