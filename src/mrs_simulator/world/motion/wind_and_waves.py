"""Gusts of wind and waves, seeded for each robot on its own.

A gust g is an Ornstein-Uhlenbeck process, ``g' = -g/T + sigma sqrt(2/T) w``, w white noise: normal with
standard deviation sigma at any time, correlated over T.  A wave's force is white noise behind a filter of
second order about the waves' frequency,

    f'' + 2 lambda omega f' + omega^2 f = 2 sigma sqrt(lambda omega) w',

of standard deviation sigma (Fossen 2011, section 8.2).  Both are advanced exactly: what they are like does
not depend on the step.
"""

import numpy as np

from mrs_simulator.scenario.surroundings.environment import Disturbances
from mrs_simulator.world.wheel_odometry.noise import RobotStreams

GUSTS, WAVES = 2, 3  # among a robot's noise streams, after its wheels
DAMPING = 0.1  # [-] lambda of the waves' spectrum: how broad it is


class Gusts:
    """The wind's deviation from its mean at each of m robots."""

    def __init__(self, deviation, time, step, seed, rows):
        """``deviation`` sigma [m/s]; ``time`` T [s]; ``step`` [s]; ``rows``: of the robots in the team."""
        self._deviation, self._noise = deviation, RobotStreams(seed, rows, GUSTS, 1)
        self._share = np.exp(-step / time)
        self._fresh = np.sqrt(1.0 - self._share**2)
        self.speed = self._deviation * self._noise.draw()[:, 0]  # as it is after a long time

    def advance(self):
        """Return the gusts (m,) [m/s] after a step."""
        fresh = self._fresh * self._noise.draw()[:, 0]
        self.speed = self._share * self.speed + self._deviation * fresh
        return self.speed


class Waves:
    """What the waves do to each of m robots, in units of their standard deviations: aside and about the
    vertical."""

    def __init__(self, period, step, seed, rows):
        """``period`` [s] of the waves; ``step`` [s]; ``rows`` in the team."""
        omega = 2.0 * np.pi / period
        self._turn = _transition(omega, DAMPING, step)
        # Of the integral of f, and of f: the covariance at any time, and what a step adds of it.
        steady = np.diag([1.0 / omega**2, 1.0])
        self._spread = np.sqrt(np.diag(steady))
        self._fresh = np.linalg.cholesky(steady - self._turn @ steady @ self._turn.T)
        self._noise = RobotStreams(seed, rows, WAVES, 4)
        # As it is after a long time.
        self._state = self._draw() * self._spread[:, np.newaxis]  # (2, 2 m)

    def _draw(self):
        """Return standard normal numbers (2, 2 m): of the filter's states, for each robot's two forces."""
        return self._noise.draw().reshape(-1, 2, 2).transpose(1, 0, 2).reshape(2, -1)

    def advance(self):
        """Return the forces (m, 2), standard deviation 1, after a step."""
        self._state = self._turn.dot(self._state) + self._fresh.dot(self._draw())
        return self._state[1].reshape(-1, 2)


def _transition(omega, damping, step):
    """Return ``exp(A step)`` (2, 2) of ``A = [[0, 1], [-omega^2, -2 damping omega]]``, damping below 1."""
    own = omega * np.sqrt(1.0 - damping**2)
    cos, sin = np.cos(own * step), np.sin(own * step) / own
    slope = damping * omega * sin
    return np.exp(-damping * omega * step) * np.array(
        [[cos + slope, sin], [-(omega**2) * sin, cos - slope]]
    )


class Weather:
    """What an ``Environment`` does to the robots ``rows`` of a team, step by step."""

    def __init__(self, environment, step, seed, rows):
        """``step`` [s]; ``seed`` of the run."""
        self._environment, m = environment, len(rows)
        self._wind, speed = np.array(environment.wind), float(np.hypot(*environment.wind))
        self._along = self._wind / speed if speed else self._wind
        self._gusts = self._waves = None
        if environment.gusts:
            self._gusts = Gusts(environment.gusts, environment.gust_time, step, seed, rows)
        if environment.wave_height:
            self._waves = Waves(environment.wave_period, step, seed, rows)
        self._still = Disturbances(
            np.array(environment.current), np.tile(self._wind, (m, 1)), np.zeros((m, 2))
        )

    @property
    def is_steady(self):
        """Return whether the disturbances are the same in each step."""
        return self._gusts is None and self._waves is None

    def disturbances(self):
        """Return the ``Disturbances`` in the next step."""
        present = self._still
        if self._gusts is not None:
            gust = self._gusts.advance()[:, np.newaxis] * self._along
            present = present._replace(wind=present.wind + gust)
        if self._waves is not None:
            present = present._replace(waves=self._environment.wave_height * self._waves.advance())
        return present
