"""Laws against a current as published, for verdicts: see :mod:`protocols.published.laws`."""

import cmath

import numpy as np

from mrs_simulator.protocols.published.laws import Averaging, Published


class StationKeeping(Published):
    """``u_i = gain sum_j a_ij (e_j - e_i) - anchor e_i - integral z_i``, ``z_i' = e_i``.

    ``integral z_i`` is no longer than ``most``.
    """

    SEES = "past"

    def __init__(self, weights, gains, most, stations, period):
        """``gains``: of edges, of the own station, of the integral; ``most`` [m/s]; ``stations`` (n, 2)."""
        self.weights, self.gains, self.most = weights, gains, most
        self.stations, self.period = stations, period

    def begin(self, start):
        """Return the integral of the error, 0."""
        return np.zeros(np.shape(start))

    def velocity(self, points, time, memory):
        """Return ``(u, memory)``, the integral (n, 2) [m s]."""
        gain, anchor, integral = self.gains
        among, _ = Averaging(self.weights, gain, self.stations).velocity(points, time, None)
        away = points - self.stations
        after = np.array(memory + self.period * away)
        for row, own in enumerate(after):
            made_up = integral * np.hypot(*own)
            if made_up > self.most or not integral:
                after[row] = own * (self.most / made_up if integral else 0.0)
        return among - anchor * away - integral * memory, after

    def over(self, up):
        """Return this law with the weights of edges that are down at 0."""
        return StationKeeping(self.weights * up, self.gains, self.most, self.stations, self.period)


class LineOfSight(Published):
    """``u_i = U e^{i (chi - atan((e_i + sigma z_i)/ahead))}``: complex numbers for the plane."""

    SEES = "past"

    def __init__(self, places, middle, numbers, period):
        """``places`` (n, 2) [m] of a shape that looks along x, turned about its ``middle`` (2,) [m];
        ``numbers``: chi [rad], U [m/s], ahead [m], sigma [m/s]."""
        self.places, self.middle, self.numbers, self.period = places, middle, numbers, period

    def begin(self, start):
        """Return the integrals, 0."""
        return [0.0] * len(start)

    def velocity(self, points, time, memory):
        """Return ``(u, memory)``, the integrals [m]."""
        chi, speed, ahead, sigma = self.numbers
        u, after = [], []
        for point, place, z in zip(points, self.places, memory):
            e = (complex(*(point - self.middle)) * cmath.exp(-1j * chi) - complex(*place)).imag
            aim = e + sigma * z
            u.append(speed * cmath.exp(1j * (chi - cmath.phase(complex(ahead, aim)))))
            after.append(z + self.period * ahead * e / (aim * aim + ahead * ahead))
        return np.array([[w.real, w.imag] for w in u]), after

    def over(self, up):
        """Return this law: robots receive nothing from each other."""
        return self
