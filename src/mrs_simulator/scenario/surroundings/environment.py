"""The environment: current, wind and waves."""

import math
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.scenario.reading import ScenarioError, Section, shown

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
    waves: (
        np.ndarray
    )  # (m, 2) [m], aside and about the vertical, standard deviation ``wave_height``


@explained_by("docs/scenarios.md#current-wind-and-waves")
def read_environment(content, where):
    """Return the ``Environment`` in the mapping ``content``; ``ScenarioError`` if it is none."""
    top = Section(content, where)
    wind, waves = (Section(top.take(key, {}), top.at(key)) for key in ("wind", "waves"))
    environment = Environment(
        current=_velocity(top, "current", FASTEST_CURRENT),
        wind=_velocity(wind, "velocity", FASTEST_WIND),
        gusts=wind.number("gusts", 0.0, low=0.0, high=FASTEST_WIND),
        gust_time=wind.number("time", CALM.gust_time, above=0.0),
        wave_height=waves.number("height", 0.0, low=0.0, high=HIGHEST_WAVES),
        wave_period=waves.number("period", CALM.wave_period, above=0.0),
    )
    for each in (wind, waves, top):
        each.done()
    if environment.gusts and environment.wind == (0.0, 0.0):
        raise ScenarioError(
            "{}: {:g} m/s without wind, whose direction they have; wanted {}, or 0".format(
                wind.at("gusts"), environment.gusts, wind.at("velocity")
            )
        )
    return environment


def _velocity(section, key, fastest):
    if not section.has(key):
        section.take(key, None)
        return 0.0, 0.0
    value = tuple(section.numbers(key, 2))
    if math.hypot(*value) > fastest:
        raise ScenarioError(
            "{}: {}, wanted at most {:g} m/s".format(section.at(key), shown(list(value)), fastest)
        )
    return value
