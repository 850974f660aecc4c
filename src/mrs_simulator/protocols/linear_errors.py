"""Laws whose errors obey a linear equation: what of their theory follows from its matrix alone."""

import copy

import numpy as np

from mrs_simulator.control.array_law import of_samples
from mrs_simulator.core.linear_theorem import ACCURACY, NAMES, linear_theorem
from mrs_simulator.protocols.common import all_hold, commands_by
from mrs_simulator.protocols.energies import error_energy


class LinearErrors:
    """Mixin of laws under which the errors ``e = p - r(t)`` obey ``e' = -M e``.

    Claims, prediction and energy follow from ``error_matrix`` and ``reference``.
    """

    NAMES = NAMES  # of what follows from M and r

    def error_matrix(self):
        """Return M [1/s], (n, n) or, of all coordinates robot by robot, (n d, n d); None without one."""
        raise NotImplementedError

    def reference(self, time):
        """Return r at ``time`` (m,) [s], (m, n, d) [m], or (n, d) if it rests; here the origin."""
        return np.zeros((len(self.numbers), self.dimension))

    def theorem(self):
        """Return the ``LinearTheorem`` of M, and of r, which rests."""
        matrix, rest = self.error_matrix(), self.reference(0.0)
        return linear_theorem(matrix, matrix @ rest.reshape(len(matrix), -1))

    def claims(self, start):
        """Return limit, what stays, and decay rate, if all that moves decays under held commands."""
        conditions = self.theorem().conditions(self.period)
        return conditions + (self.consequences(start) if all_hold(conditions) else [])

    def consequences(self, start, accuracy=ACCURACY, **options):
        """Return the claims of the theorem, as ``LinearTheorem.consequences`` does."""
        options.setdefault("names", self.NAMES)
        return self.theorem().consequences(start, self.period, accuracy, **options)

    def energy(self, start):
        """Return ``e^T P e`` of what moves, ``M^T P + P M = gain I`` there; None where it grows."""
        matrix, gain = self.error_matrix(), getattr(self, "gain", 1.0)
        if gain <= 0.0 or matrix is None or not matrix.any():
            return None
        rest = self.reference(0.0)

        def error(hand):
            return (hand - rest).reshape(hand.shape[:-2] + (len(matrix), -1))

        return error_energy(matrix / gain, gain, error)

    def prediction(self, start, time):
        """Return the exact solution under held inputs, (m, n, d) [m], at ``time`` (m,) [s]."""
        matrix, counts = self.error_matrix(), commands_by(time, self.period)
        if matrix is None:
            return None
        away = start - self.reference(np.zeros(1)).reshape((-1,) + start.shape)[0]
        step = np.eye(len(matrix)) - self.period * matrix
        track = powers(step, away.reshape(len(matrix), -1), counts)
        return self.reference(counts * self.period) + track.reshape((-1,) + start.shape)


class Tracking(LinearErrors):
    """Mixin of laws by which robots follow places ``wanted`` that move, with feed-forward."""

    MEMORYLESS = False  # they know the time
    _begun = 0.0  # [s] of the way that are over when the run which is judged begins

    def resumed(self, time, memory):
        """Return the law as it goes on from ``time`` [s]."""
        rest = copy.copy(self)
        rest._begun = self._begun + time
        return rest

    def wanted(self, time):
        """Return the wanted places at ``time`` (m,) [s], (m, n, d) [m]."""
        raise NotImplementedError

    def reference(self, time):
        """Return the wanted places, (m, n, d) [m]."""
        return self.wanted(time)

    def energy(self, start):
        """Return None: no energy is stated of errors from what moves."""
        return None

    def theorem(self):
        """Return the ``LinearTheorem`` of the errors."""
        return linear_theorem(self.error_matrix())

    def consequences(self, start, accuracy=ACCURACY, **options):
        """Return the claims of the theorem, of the errors."""

        def of_errors(measure):
            return lambda run: measure(run._replace(hand=self.errors(run)))

        claims = super().consequences(start - self.wanted([0.0])[0], accuracy, **options)
        return [claim._replace(measure=of_errors(claim.measure), place=None) for claim in claims]

    @of_samples
    def targets(self, hand):
        """Return where the robots are wanted now, (n, d) [m]."""
        wanted = self.wanted(np.ravel(self.time))
        return wanted if np.ndim(self.time) else wanted[0]

    def errors(self, run):
        """Return how far the points of ``run`` are from the wanted places, (m, n, d) [m]."""
        return run.hand - self.wanted(run.time - run.time[0])


@np.errstate(over="ignore", invalid="ignore")
def powers(step, start, counts):
    """Return ``step^k start``, (m, n, d), for each k of ascending ``counts`` (m,).

    Where that is beyond the largest number, inf or NaN.
    """
    track, point, done = np.empty((len(counts),) + start.shape), start, 0
    jumps = {}
    for row, count in enumerate(counts.tolist()):
        jump = count - done
        if jump not in jumps:
            jumps[jump] = np.linalg.matrix_power(step, jump)
        point, done = jumps[jump] @ point, count
        track[row] = point
    return track
