"""Errors of wheel odometry in a scenario: unequal wheels, a wrong track, noise."""

import numpy as np

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import NUMBERS, Field
from mrs_simulator.scenario.reading import Section, record

MOST_FACTOR = 0.5  # [-]
MOST_RATIO = 2.0  # [-] of two wheels' diameters, and of tracks


ALPHA = Field(
    "alpha",
    (0.0,) * 6,
    low=0.0,
    type=NUMBERS,
    sizes=(6,),
    rule="zeros",
    meaning="`[a1, ..., a6]` of the velocity motion model: noise of distance, turn and heading",
)
GYRO = (
    Field("bias", 0.0, "rad/s", meaning="of what it measures"),
    Field("walk", 0.0, "rad/sqrt(s)", low=0.0, meaning="random walk of its angle"),
)


def read_gyro(section, others):
    """Return bias and walk under ``gyro`` of the ``section``, None without it."""
    if not section.has("gyro"):
        return section.take("gyro")
    return tuple(Section(section.take("gyro"), section.at("gyro")).values(GYRO).values())


ERRORS = (
    ALPHA,
    Field(
        "Ed",
        1.0,
        low=1.0 / MOST_RATIO,
        high=MOST_RATIO,
        meaning="ratio of the wheels' diameters, right over left, at the same mean",
    ),
    Field(
        "Eb",
        1.0,
        low=1.0 / MOST_RATIO,
        high=MOST_RATIO,
        meaning="ratio of the actual track to the nominal one",
    ),
    Field(
        "factor",
        0.0,
        low=0.0,
        high=MOST_FACTOR,
        meaning="by which measured distances and turns are off at most, drawn once for each robot",
    ),
    Field("gyro", read=read_gyro, meaning="turns come from a gyro instead of the wheels"),
)


class OdometryErrors(record("OdometryErrors", ERRORS)):
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

    __slots__ = ()

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
            plain["gyro"] = {field.name: value for field, value in zip(GYRO, self.gyro)}
        return plain


@explained_by("docs/sensors.md#odometry")
def read_odometry_errors(top, others):
    """Return the ``OdometryErrors`` under ``odometry_errors``, None without it."""
    given = top.take("odometry_errors")
    if given is None:
        return None
    return OdometryErrors(**Section(given, top.at("odometry_errors")).values(ERRORS))


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
