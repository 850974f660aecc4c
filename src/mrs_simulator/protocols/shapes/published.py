"""Formation laws as published, for verdicts: see :mod:`protocols.published.laws`."""

import cmath
import functools

import numpy as np

from mrs_simulator.protocols.published.laws import Averaging, Published


class Distances(Published):
    """``u_i = -gain sum_j a_ij (|p_ij|^2 - d_ij^2) p_ij``: Krick, Broucke, Francis, 2009."""

    def __init__(self, weights, gain, places):
        self.weights, self.gain = weights, gain
        self.wanted = np.sum((places[:, np.newaxis] - places) ** 2, axis=2)

    def velocity(self, points, time, memory):
        apart = points[:, np.newaxis] - points
        pull = self.weights * (np.sum(apart**2, axis=2) - self.wanted)
        return -self.gain * np.einsum("ij,ijk->ik", pull, apart), None


class Bearings(Published):
    """``u_i = -gain sum_j a_ij (I - g_ij g_ij^T) g*_ij``: Zhao and Zelazo, 2016."""

    def __init__(self, weights, gain, places):
        self.weights, self.gain, self.wanted = weights, gain, _unit(places)

    def velocity(self, points, time, memory):
        have, want = _unit(points), self.wanted
        across = want - np.sum(have * want, axis=2, keepdims=True) * have
        return -self.gain * np.einsum("ij,ijk->ik", self.weights, across), None


class BearingsWithLeaders(Published):
    """``u_i = -gain sum_j a_ij (I - g*_ij g*_ij^T)(p_i - p_j)``, the first ``leaders`` still."""

    def __init__(self, weights, gain, places, leaders):
        self.weights, self.gain, self.wanted = weights, gain, _unit(places)
        self.leaders = leaders

    def velocity(self, points, time, memory):
        apart, want = points[:, np.newaxis] - points, self.wanted
        across = apart - np.sum(apart * want, axis=2, keepdims=True) * want
        u = -self.gain * np.einsum("ij,ijk->ik", self.weights, across)
        u[: self.leaders] = 0.0
        return u, None


class Marching(Published):
    """``u_i = d_i' + gain sum_j a_ij (p_j - p_i - (d_j - d_i)) + anchor (d_i - p_i)``, d on a path.

    d' is the mean over the time for which a command is held; 0 for who follows without feed-forward.
    """

    def __init__(self, weights, gain, anchor, wanted, period, blind):
        """``wanted(time)``: the places d, (n, d) [m]; ``blind`` (n,) bool: who knows no d'."""
        self.weights, self.gain, self.anchor = weights, gain, anchor
        self.wanted, self.period, self.blind = wanted, period, blind

    def velocity(self, points, time, memory):
        now, then = self.wanted(time), self.wanted(time + self.period)
        ahead = np.where(self.blind[:, np.newaxis], 0.0, (then - now) / self.period)
        keep, _ = Averaging(self.weights, self.gain, now).velocity(points, time, None)
        return ahead + keep + self.anchor * (now - points), None

    def over(self, up):
        """Return this law with the weights of edges that are down at 0."""
        weights = self.weights * up
        return Marching(weights, self.gain, self.anchor, self.wanted, self.period, self.blind)


def least_snap(points, speed):
    """Return the curve of least snap through ``points`` (k, d), (d,) [m] as a function of the time [s].

    Each leg takes its length over ``speed``; at rest at both ends.  By the quadratic programme of its
    definition: polynomials of degree 7 in the share x of each leg's time h, smooth to the third
    derivative, of least cost; fourth derivatives of x^i and x^j, over (0, 1), make
    ``i!/(i-4)! j!/(j-4)!/(i + j - 7)/h^7`` of it.
    """
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1) / speed
    if not len(legs):
        return lambda time: points[0]
    size = 8 * len(legs)
    cost, fourth = np.zeros((size, size)), [i * (i - 1) * (i - 2) * (i - 3) for i in range(8)]
    for leg, h in enumerate(legs):
        for i in range(4, 8):
            for j in range(4, 8):
                cost[8 * leg + i, 8 * leg + j] = fourth[i] * fourth[j] / (i + j - 7) / h**7
    bounds, values = _passed(points, legs)
    m = len(bounds)
    scale = np.concatenate([np.ones(size), np.full(m, max(1.0, np.abs(cost).max()))])
    system = np.block([[cost, bounds.T], [bounds, np.zeros((m, m))]]) * np.outer(scale, scale)
    right = np.concatenate([np.zeros((size, points.shape[1])), values]) * scale[:, np.newaxis]
    found = np.linalg.solve(system, right)[:size].reshape(len(legs), 8, -1)
    ends = np.cumsum(legs)

    def at(time):
        if time >= ends[-1]:
            return points[-1]
        leg = int(np.searchsorted(ends, max(time, 0.0), side="right"))
        share = (max(time, 0.0) - (ends[leg] - legs[leg])) / legs[leg]
        return share ** np.arange(8) @ found[leg]

    return at


def _passed(points, legs):
    """Return the equations ``A c = b`` of a curve that passes ``points``, smooth, at rest at its ends."""
    rows, values, nothing = [], [], np.zeros(points.shape[1])

    def row(leg, share, order):
        result = np.zeros(8 * len(legs))
        for j in range(order, 8):
            slope = np.prod([float(j - i) for i in range(order)])
            result[8 * leg + j] = slope * share ** (j - order) / legs[leg] ** order
        return result

    for leg in range(len(legs)):
        rows += [row(leg, 0.0, 0), row(leg, 1.0, 0)]
        values += [points[leg], points[leg + 1]]
        for order in (1, 2, 3):
            rows.append(row(leg, 1.0, order))
            if leg + 1 < len(legs):
                rows[-1] -= row(leg + 1, 0.0, order)
            values.append(nothing)
    rows += [row(0, 0.0, order) for order in (1, 2, 3)]
    return np.array(rows), np.array(values + [nothing] * 3)


def on_path(name, radius, corners, s):
    """Return the place and heading at ``s`` [m] along a path, as ``(z, heading)``, z complex [m].

    A line along x; a circle to the left from the origin; an eight of two circles, to the left first;
    a polygon about ``corners`` (k, 2) from the middle of its first side, its corners rounded.
    """
    if name == "line":
        return complex(s), 0.0
    if name in ("circle", "eight"):
        angle = s / radius
        lap, rest = divmod(angle, 4.0 * np.pi)
        if name == "circle" or rest < 2.0 * np.pi:
            heading = angle if name == "circle" else rest
            return radius * 1j * (1.0 - cmath.exp(1j * heading)), heading
        heading = 4.0 * np.pi - rest
        return -radius * 1j * (1.0 - cmath.exp(1j * heading)), heading
    return _on_polygon(tuple(map(tuple, corners)), radius, s)


@functools.lru_cache(maxsize=16)
def _polygon(corners, radius):
    """Return the first side's middle, all sides, turns [rad], what these cut off [m], and the lap [m]."""
    corner, k = [complex(*each) for each in corners], len(corners)
    sides = [corner[(i + 1) % k] - corner[i] for i in range(k)]
    turns = [cmath.phase(sides[(i + 1) % k] / sides[i]) for i in range(k)]
    cuts = [radius * np.tan(abs(turn) / 2.0) for turn in turns]
    lap = sum(abs(side) for side in sides)
    lap += sum(radius * abs(turn) - 2.0 * cut for turn, cut in zip(turns, cuts))
    return corner[0] + 0.5 * sides[0], sides, turns, cuts, lap


def _on_polygon(corners, radius, s):
    z, sides, turns, cuts, lap = _polygon(corners, radius)
    i, k = 0, len(sides)
    laps, s = divmod(s, lap)
    heading = cmath.phase(sides[0]) + laps * sum(turns)
    straight = 0.5 * abs(sides[0]) - cuts[0]
    while s > straight:
        s, z = s - straight, z + straight * cmath.exp(1j * heading)
        part = min(s / (radius * abs(turns[i])), 1.0) if turns[i] else 1.0
        side = np.sign(turns[i]) * 1j
        centre = z + radius * side * cmath.exp(1j * heading)
        z = centre - radius * side * cmath.exp(1j * (heading + part * turns[i]))
        heading += part * turns[i]
        if part < 1.0:
            return z, heading
        s -= radius * abs(turns[i])
        straight = abs(sides[(i + 1) % k]) - cuts[i] - cuts[(i + 1) % k]
        i = (i + 1) % k
        if i == 0:
            straight = abs(sides[0]) - cuts[-1]  # s ends within the first half of this side
    return z + s * cmath.exp(1j * heading), heading


def along(place, places, swing, turning):
    """Return ``places`` (n, d) [m] about the path's ``(z, heading)``, ``swing`` times as large."""
    z, heading = place
    turn = cmath.exp(1j * heading) if turning else 1.0
    points = z + swing * turn * (places[:, 0] + 1j * places[:, 1])
    return np.column_stack([points.real, points.imag, swing * places[:, 2:]])


class Separations(Published):
    """l-psi control: ``lambda' = k1 (lambda* - lambda)``, ``psi' = k2 (psi* - psi)``: Desai, 2001.

    Follower i's hand point is at ``z_L + lambda e^{i(theta_L + psi)}`` beside its leader L, whose own
    ``(v, omega)`` are known; so ``z' = v e^{i theta_L} + (lambda' + i lambda (omega + psi'))
    e^{i(theta_L + psi)}``.
    """

    SEES = "pose"

    def __init__(self, leader, wanted, gains, path, speed, period):
        """``leader`` (n,) rows, its own for the leader; ``wanted`` (n,) complex [m], beside it."""
        self.leader, self.wanted, self.gains = leader, wanted, gains
        self.path, self.speed, self.period = path, speed, period
        self.depth, above = 1, np.array(leader)
        while self.depth < len(leader) and not np.array_equal(above, above[np.array(leader)]):
            self.depth, above = self.depth + 1, above[np.array(leader)]
        self.depth += 1

    def commands(self, pose, hand, command, time, l):
        """Return the wanted ``(v, omega)``, (n, 2), given what the leaders' ``command`` (n, 2) is."""
        wanted, place = [], [complex(*each) for each in pose[:, :2].tolist()]
        point = [complex(*each) for each in hand.tolist()]
        heading = [cmath.exp(1j * theta) for theta in pose[:, 2].tolist()]
        known = command.tolist()
        for i, j in enumerate(self.leader):
            if i == j:
                begin, end = (self.path(self.speed * t)[1] for t in (time, time + self.period))
                wanted.append((self.speed, (end - begin) / self.period))
                continue
            (v, omega), ahead = known[j], heading[j]
            seen = (point[i] - place[j]) / ahead
            longer = self.gains[0] * (abs(self.wanted[i]) - abs(seen))
            round_ = self.gains[1] * cmath.phase(self.wanted[i] / seen)
            unit = ahead * seen / abs(seen)
            own = (v * ahead + (longer + 1j * abs(seen) * (omega + round_)) * unit) / heading[i]
            wanted.append((own.real, own.imag / l))
        return np.array(wanted)


def _unit(points):
    """Return ``(p_j - p_i)/|p_j - p_i|``, (n, n, d); zero where points coincide."""
    towards = points[np.newaxis] - points[:, np.newaxis]
    length = np.linalg.norm(towards, axis=2, keepdims=True)
    return towards / np.where(length > 0.0, length, 1.0)
