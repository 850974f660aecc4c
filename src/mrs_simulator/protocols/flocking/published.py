"""Flocking laws as published, for verdicts: see :mod:`protocols.published.laws`."""

import cmath
import itertools
import math

import numpy as np

from mrs_simulator.core.kinematics import direction_of
from mrs_simulator.core.neighbours import squared as squares
from mrs_simulator.protocols.published.laws import Published

# of the sigma-norm [1/m^2] and of the bump function, in Olfati-Saber, 2006
EPSILON, BUMP = 0.1, 0.2


class Accelerated(Published):
    """``v_i' = a_i(p, v)``, u = v, in steps of a command period."""

    SEES = "next"

    def __init__(self, first, period):
        """``first`` (n, d) [m/s]: the velocities at the start."""
        self.first, self.period = first, period

    def begin(self, start):
        """Return v(0) and what else is remembered of the start."""
        return self.first, self.remembered(start)

    def remembered(self, start):
        """Return what the law needs to know of ``start`` (n, d) later."""
        return None

    def resumed(self, velocity, memory):
        return velocity, memory[1]

    def velocity(self, points, time, memory):
        """Return ``(v+, memory)``."""
        v, rest = memory
        v = self.within(v + self.period * self.acceleration(points, v, time, rest))
        return v, (v, rest)

    def within(self, v):
        """Return the velocities ``v`` (n, d) as far as the law allows them."""
        return v

    def acceleration(self, points, v, time, rest):
        """Return a, (n, d) [m/s^2]."""
        raise NotImplementedError


class AlphaGamma(Accelerated):
    """Algorithm 2 of Olfati-Saber, 2006: pair forces, alignment, and a virtual leader."""

    WORK = 30.0

    def __init__(self, first, period, d, r, strength, alignment, c1, c2, leader_velocity):
        super().__init__(first, period)
        self.d, self.r, self.strength, self.alignment = _sigma(d), _sigma(r), strength, alignment
        self.c1, self.c2, self.leader_velocity = c1, c2, np.array(leader_velocity)

    def remembered(self, start):
        """Return where the virtual leader starts, (d,) [m]."""
        return start.sum(axis=0) / len(start)

    def acceleration(self, points, v, time, rest):
        a = -self.c1 * (points - rest - time * self.leader_velocity)
        a -= self.c2 * (v - self.leader_velocity)
        apart = points - points[:, np.newaxis]  # (n, n, d), of row i those from robot i
        squared = squares(apart)
        z = _sigma(np.sqrt(squared))
        near = _bump(z / self.r)
        force = self.strength * near * (z - self.d) / np.sqrt(1.0 + (z - self.d) ** 2)
        force /= np.sqrt(1.0 + EPSILON * squared)
        alignment = self.alignment * near
        a += (force[:, np.newaxis] @ apart)[:, 0]
        a += (alignment[:, np.newaxis] @ (v - v[:, np.newaxis]))[:, 0]
        return a


def _sigma(distance):
    return (np.sqrt(1.0 + EPSILON * distance**2) - 1.0) / EPSILON


def _bump(z):
    """Return the bump function of each of ``z`` (n, n)."""
    bump = np.where(z < BUMP, 1.0, 0.0)
    between = (z >= BUMP) & (z <= 1.0)
    # By math, as ever: numpy's cosine may have another last bit.
    shares = math.pi * (z[between] - BUMP) / (1.0 - BUMP)
    bump[between] = [0.5 * (1.0 + math.cos(share)) for share in shares]
    return bump


class CuckerSmale(Accelerated):
    """``v_i' = K/n sum_j (1 + |p_ij|^2/r^2)^-beta (v_j - v_i)``: Cucker and Smale, 2007."""

    def __init__(self, first, period, gain, beta, reach):
        super().__init__(first, period)
        self.gain, self.beta, self.reach = gain, beta, reach

    def acceleration(self, points, v, time, rest):
        squared = squares(points - points[:, np.newaxis])
        psi = (1.0 + squared / self.reach**2) ** -self.beta
        relative = v - v[:, np.newaxis]  # (n, n, d), of row i those relative to robot i
        return self.gain / len(points) * (psi[:, :, np.newaxis] * relative).sum(axis=1)


class Boids(Accelerated):
    """Separation, alignment and cohesion, in the form that ``reynolds`` documents: Reynolds, 1987."""

    def __init__(self, first, period, radius, gains, speed):
        super().__init__(first, period)
        self.radius, self.gains, self.speed = radius, gains, speed

    def acceleration(self, points, v, time, rest):
        separation, alignment, cohesion = self.gains
        away = points[:, np.newaxis] - points  # (n, n, d), of row i from all others to robot i
        squared = (away**2).sum(axis=2)
        near = squared < self.radius**2
        np.fill_diagonal(near, False)
        count = near.sum(axis=1)[:, np.newaxis]
        among = near[:, :, np.newaxis]
        with np.errstate(invalid="ignore"):  # of nobody
            a = alignment * (np.where(among, v, 0.0).sum(axis=1) / count - v)
            a += cohesion * (np.where(among, points, 0.0).sum(axis=1) / count - points)
        apart = near & (squared > 0.0)
        shares = away / np.where(apart, squared, 1.0)[:, :, np.newaxis]
        a += separation * np.where(apart[:, :, np.newaxis], shares, 0.0).sum(axis=1)
        return np.where(count > 0, a, 0.0)

    def within(self, v):
        """Return ``v`` with speeds from half the speed to the speed."""
        speed = np.sqrt((v**2).sum(axis=1))
        wanted = np.minimum(np.maximum(speed, 0.5 * self.speed), self.speed)
        return v * (wanted / np.where(speed > 0.0, speed, 1.0))[:, np.newaxis]


class Headings(Published):
    """``theta_i+ = arg sum_j e^{i theta_j} + xi_i`` over robots within the radius: Vicsek, 1995."""

    SEES, WORK = "next", 20.0

    def __init__(self, n, radius, speed, noise, seed, period):
        draws = np.random.default_rng(seed)
        self.first = draws.uniform(-np.pi, np.pi, n)
        self.draws, self.drawn = draws, []
        self.radius, self.speed, self.noise, self.period = radius, speed, noise, period
        self.RANDOM = noise > 0.0

    def begin(self, start):
        """Return the headings of the start, (n,) [rad]."""
        return self.first

    def resumed(self, velocity, memory):
        """Return the headings (n,) [rad] of the command ``velocity`` (n, 2) [m/s]."""
        return direction_of(velocity)

    def velocity(self, points, time, memory):
        """Return ``(u, headings)``."""
        command = int(round(time / self.period))
        while len(self.drawn) <= command:
            xi = self.draws.uniform(-0.5 * self.noise, 0.5 * self.noise, len(points))
            self.drawn.append(xi)
        headings = np.empty(len(points))
        directions = [cmath.exp(1j * heading) for heading in memory]
        among = squares(points - points[:, np.newaxis]) < self.radius**2
        for i, near in enumerate(among):
            mean = sum(itertools.compress(directions, near.tolist()))
            kept = cmath.phase(mean) if abs(mean) > 1e-12 else memory[i]
            headings[i] = kept + self.drawn[command][i]
        return self.speed * np.column_stack([np.cos(headings), np.sin(headings)]), headings


def random_directions(seed, n, speed, dimension=2):
    """Return ``speed`` [m/s] in n random directions, (n, d): in space those of normal deviates."""
    draws = np.random.default_rng(seed)
    if dimension == 3:
        rows = [draws.standard_normal(3) for _ in range(n)]
        return speed * np.array([row / math.sqrt(row @ row) for row in rows])
    angles = draws.uniform(-np.pi, np.pi, n)
    return speed * np.array([[math.cos(angle), math.sin(angle)] for angle in angles])
