"""The environment: current, wind and waves."""

import math
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import NUMBERS, POSITIVE, Field
from mrs_simulator.scenario.reading import ScenarioError, Section, unwanted

FASTEST_CURRENT, FASTEST_WIND = 20.0, 100.0  # [m/s] that a scenario may have
HIGHEST_WAVES = 30.0  # [m]


class Environment(NamedTuple):
    """Current, wind and waves: uniform and constant but for gusts and waves."""

    current: Tuple[float, float] = (0.0, 0.0)  # [m/s] of the water, common frame
    wind: Tuple[float, float] = (0.0, 0.0)  # [m/s], mean velocity, common frame
    gusts: float = 0.0  # [m/s], standard deviation of the wind's speed
    gust_time: float = 2.0  # [s] over which gusts are correlated
    wave_height: float = 0.0  # [m], significant height
    wave_period: float = 4.0  # [s]

    def to_plain(self):
        """Return the mapping that a scenario holds."""
        return {
            "current": list(self.current),
            "wind": {"velocity": list(self.wind), "gusts": self.gusts, "time": self.gust_time},
            "waves": {"height": self.wave_height, "period": self.wave_period},
        }


CALM = Environment()


class Disturbances(NamedTuple):
    """Current, wind and waves that act on m robots in one step."""

    current: np.ndarray  # (2,) [m/s], common frame
    wind: np.ndarray  # (m, 2) [m/s], common frame
    # (m, 2) [m], aside and about the vertical, standard deviation ``wave_height``
    waves: np.ndarray


def _velocity(name, fastest, meaning):
    """Return the declaration of a velocity (x, y) [m/s] that is no faster than ``fastest`` [m/s]."""
    field = Field(
        name, (0.0, 0.0), "m/s", type=NUMBERS, sizes=(2,), rule="0, 0 m/s", meaning=meaning
    )

    def read(section, others):
        value = section.field(field)
        if math.hypot(*value) > fastest:
            raise unwanted(section.at(name), list(value), "at most {:g} m/s".format(fastest))
        return value

    return field._replace(read=read)


CURRENT = (_velocity("current", FASTEST_CURRENT, "of the water, x and y in the common frame"),)
WIND = (
    _velocity("velocity", FASTEST_WIND, "mean, x and y in the common frame"),
    Field(
        "gusts",
        0.0,
        "m/s",
        low=0.0,
        high=FASTEST_WIND,
        meaning="standard deviation of the wind's speed",
    ),
    Field("time", CALM.gust_time, "s", **POSITIVE, meaning="over which gusts are correlated"),
)
WAVES = (
    Field("height", 0.0, "m", low=0.0, high=HIGHEST_WAVES, meaning="significant height"),
    Field("period", CALM.wave_period, "s", **POSITIVE, meaning="of the waves"),
)


@explained_by("docs/scenarios.md#current-wind-and-waves")
def read_environment(top, others):
    """Return the ``Environment`` under ``environment`` of ``top``; ``ScenarioError`` if it is none."""
    top = Section(top.take("environment", {}), top.at("environment"))
    wind, waves = (Section(top.take(key, {}), top.at(key)) for key in ("wind", "waves"))
    parts = zip((top, wind, waves), (CURRENT, WIND, WAVES))
    environment = Environment(*(v for part, keys in parts for v in part.values(keys).values()))
    if environment.gusts and environment.wind == (0.0, 0.0):
        text = "{}: {:g} m/s without wind, whose direction they have; wanted {}, or 0"
        raise ScenarioError(text.format(wind.at("gusts"), environment.gusts, wind.at("velocity")))
    return environment
