"""Obstacles that move: on given tracks, at constant speed, whatever is in their way."""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.reading import ScenarioError, Section, number_list, shown

MOST_SPEED = 20.0  # [m/s]


class Track(NamedTuple):
    """The way of an obstacle's centre: from where it begins through ``to``, back and forth or round."""

    to: Tuple[Tuple[float, float], ...]  # [m]
    speed: float  # [m/s]
    closed: bool = False  # from the last point straight to the first, and round again

    def place(self, begin, time):
        """Return where a centre that begins at ``begin`` (x, y) [m] is at ``time`` [s], (x, y) [m]."""
        points = np.array([begin, *self.to, *([begin] if self.closed else [])], dtype=float)
        lengths = np.hypot(*np.diff(points, axis=0).T)
        total = float(lengths.sum())
        way = (self.speed * time) % (total if self.closed else 2.0 * total)
        if way > total:
            way = 2.0 * total - way
        reached = np.concatenate([[0.0], np.cumsum(lengths)])
        x, y = (float(np.interp(way, reached, column)) for column in points.T)
        return x, y

    def to_plain(self):
        """Return the mapping that a scenario holds."""
        return {
            "to": [list(point) for point in self.to],
            "speed": self.speed,
            "closed": self.closed,
        }


def moves(obstacle):
    """Return whether an ``obstacle`` has a track."""
    return obstacle.track is not None


def obstacles_at(obstacles, time):
    """Return ``obstacles``, a tuple, where they are at ``time`` [s]; those without a track as they are."""
    return tuple(
        each if each.track is None else _moved(each, *each.track.place((each.x, each.y), time))
        for each in obstacles
    )


def _moved(obstacle, x, y):
    """Return the ``obstacle`` at (x, y) [m], as one that stands."""
    return obstacle._replace(x=x, y=y, track=None)


def read_track(section, begin):
    """Return the ``Track`` under ``track`` of an obstacle that begins at ``begin`` (x, y); None without."""
    if not section.has("track"):
        return section.take("track")
    own = Section(section.take("track"), section.at("track"))
    given, where = own.take("to"), own.at("to")
    if not isinstance(given, list) or not given:
        raise ScenarioError("{}: {}, wanted a list of [x, y]".format(where, shown(given)))
    to = tuple(
        tuple(number_list(point, 2, "{}[{}]".format(where, k))) for k, point in enumerate(given)
    )
    before = (tuple(begin), *to)
    if any(point == last for last, point in zip(before, to)):
        raise ScenarioError(
            "{}: {}, wanted each point apart from the last".format(where, shown(given))
        )
    speed = own.number("speed", above=0.0, high=MOST_SPEED)
    track = Track(to, speed, own.flag("closed", False))
    own.done()
    return track
