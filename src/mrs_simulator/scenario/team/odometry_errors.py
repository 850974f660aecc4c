"""Errors of wheel odometry in a scenario: unequal wheels, a wrong track, noise."""

from typing import NamedTuple, Optional, Tuple

import numpy as np

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.scenario.reading import Section, number, number_list

GYRO = ("bias", "walk")
MOST_FACTOR = 0.5  # [-]
MOST_RATIO = 2.0  # [-] of two wheels' diameters, and of tracks


class OdometryErrors(NamedTuple):
    """Errors of wheel odometry, none by default.

    ``alpha``: a1 to a6 of the velocity motion model, in its form with squares (Thrun, Burgard, Fox,
    Probabilistic Robotics, table 5.3): over a time T [s] at speed v and turn rate w the variance of the
    distance is (a1 v^2 + a2 w^2) T, of the turn (a3 v^2 + a4 w^2) T, of the heading besides
    (a5 v^2 + a6 w^2) T.
    ``factor``: of measured distances and turns, 1 + e each, e drawn once for each robot and evenly
    between -factor and factor, as MobileSim and Stage have it.
    ``gyro``: the turn comes from a gyro instead of the wheels: its bias [rad/s] and random walk of the
    angle [rad/sqrt(s)]; None for none.
    ``Ed``, ``Eb``: the wheels' diameters, right over left, and the actual track over the nominal one
    (Borenstein and Feng, UMBmark, 1994): by these robots move, see ``core.uneven_wheels``.
    """

    alpha: Tuple[float, ...] = (0.0,) * 6
    Ed: float = 1.0
    Eb: float = 1.0
    factor: float = 0.0
    gyro: Optional[Tuple[float, float]] = None

    @property
    def wheels(self):
        """Return the left and the right wheel's diameter over the nominal, (c_l, c_r), mean 1."""
        return 2.0 / (self.Ed + 1.0), 2.0 / (1.0 / self.Ed + 1.0)

    def to_plain(self):
        """Return the mapping that a scenario holds."""
        plain = {"alpha": list(self.alpha), "Ed": self.Ed, "Eb": self.Eb}
        if self.factor:
            plain["factor"] = self.factor
        if self.gyro is not None:
            plain["gyro"] = dict(zip(GYRO, self.gyro))
        return plain


@explained_by("docs/sensors.md#odometry")
def read_odometry_errors(top):
    """Return the ``OdometryErrors`` under ``odometry_errors``, None without it."""
    given = top.take("odometry_errors")
    if given is None:
        return None
    section = Section(given, top.at("odometry_errors"))
    alpha = read_alpha(section) or (0.0,) * 6
    low = 1.0 / MOST_RATIO
    ratios = (section.number(key, 1.0, low=low, high=MOST_RATIO) for key in ("Ed", "Eb"))
    factor = section.number("factor", 0.0, low=0.0, high=MOST_FACTOR)
    errors = OdometryErrors(alpha, *ratios, factor, _read_gyro(section))
    section.done()
    return errors


def read_alpha(section):
    """Return the six ``alpha`` of a ``Section``, None without them."""
    given, where = section.take("alpha"), section.at("alpha")
    if given is None:
        return None
    values = number_list(given, 6, where)
    return tuple(
        number(value, "{}[{}]".format(where, k), low=0.0) for k, value in enumerate(values)
    )


def _read_gyro(section):
    if not section.has("gyro"):
        return section.take("gyro")
    gyro = Section(section.take("gyro"), section.at("gyro"))
    numbers = gyro.number(GYRO[0], 0.0), gyro.number(GYRO[1], 0.0, low=0.0)
    gyro.done()
    return numbers


def true_squares(alpha, v, w, step):
    """Return the squares of speed and turn rate, (2, m), to be expected where odometry has ``v``, ``w``.

    Over a ``step`` [s] odometry's own noise adds to both, for short steps most of what they are:
    ``E v'^2 = v^2 + (a1 v^2 + a2 w^2) / T``, ``E w'^2 = w^2 + ((a3 + a5) v^2 + (a4 + a6) w^2) / T``.
    """
    a1, a2, a3, a4, a5, a6 = alpha
    share = np.eye(2) + np.array([[a1, a2], [a3 + a5, a4 + a6]]) / step
    return np.maximum(np.linalg.solve(share, np.stack([v * v, w * w])), 0.0)


def step_deviations(alpha, v, w, step):
    """Return the standard deviations of distance [m], turn and heading [rad] in a ``step`` [s].

    ``v`` [m/s], ``w`` [rad/s] (m,); shapes (3, m).
    """
    squares = v * v, w * w
    pairs = zip(alpha[::2], alpha[1::2])
    return [(step * (a * squares[0] + b * squares[1])) ** 0.5 for a, b in pairs]
