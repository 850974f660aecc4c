"""Sources of the poses that the control uses: a scenario's ``estimates``."""

from typing import NamedTuple, Optional, Tuple

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import NAMES, REQUIRED, Field
from mrs_simulator.scenario.reading import Section
from mrs_simulator.scenario.team import odometry_errors

ODOMETRY, EKF = "odometry", "ekf"
# of the velocity motion model, by default
ALPHA = (0.01, 0.0, 0.0, 0.01, 0.001, 0.001)


# Without ``alpha`` the noise is the scenario's.
FILTER = (
    Field(EKF, type=NAMES, rule=REQUIRED, meaning="the sensors of a Kalman filter of each robot"),
    odometry_errors.ALPHA._replace(
        default=None,
        rule="that of `odometry_errors`, else {}".format(list(ALPHA)),
        meaning="the noise that the filter takes odometry for",
    ),
)


class Estimates(NamedTuple):
    """A source of poses: odometry alone, one sensor that measures poses, or a filter.

    ``source``: "odometry", "ekf" or the name of a sensor; ``sensors``: of the filter, by name; ``alpha``:
    the odometry noise that it assumes, a1 to a6 of the velocity motion model, None for the scenario's.
    """

    source: str
    sensors: Tuple[str, ...] = ()
    alpha: Optional[Tuple[float, ...]] = None

    @property
    def asked(self):
        """Return the names of the sensors that are read for it."""
        return self.sensors if self.source in (EKF, ODOMETRY) else (self.source,)

    def to_plain(self):
        """Return what a scenario holds."""
        if self.source != EKF:
            return self.source
        plain = {EKF: list(self.sensors)}
        return plain if self.alpha is None else dict(plain, alpha=list(self.alpha))


@explained_by("docs/sensors.md#estimated-poses")
def read_estimates(top, others):
    """Return the ``Estimates`` under ``estimates``, None without it."""
    given = top.take("estimates")
    if given is None:
        return None
    where = top.at("estimates")
    if isinstance(given, str):
        return Estimates(given, (), None)
    values = Section(given, where).values(FILTER)
    return Estimates(EKF, values[EKF], values["alpha"])
