"""Obstacles that move on given tracks at constant speed, whatever is in their way."""

import numpy as np

from mrs_simulator.core.fields import NUMBER, POSITIVE, REQUIRED, Field
from mrs_simulator.scenario.reading import Section, number_list, record, unwanted

MOST_SPEED = 20.0  # [m/s]
# [s] of a stage's clock as its scene begins: zero would mean that there is no time yet
CLOCK_START = 1.0


def _read_points(section, others):
    given, where = section.take("to"), section.at("to")
    if not isinstance(given, list) or not given:
        raise unwanted(where, given, "a list of [x, y]")
    to = tuple(
        tuple(number_list(point, 2, "{}[{}]".format(where, k))) for k, point in enumerate(given)
    )
    before = (tuple(others["begin"]), *to)
    if any(point == last for last, point in zip(before, to)):
        raise unwanted(where, given, "each point apart from the last")
    return to


TRACK = (
    Field(
        "to",
        unit="m",
        read=_read_points,
        rule=REQUIRED,
        meaning="points `[x, y]` through which its centre goes from where it begins, and back",
    ),
    Field(
        "speed",
        unit="m/s",
        **POSITIVE,
        high=MOST_SPEED,
        type=NUMBER,
        rule=REQUIRED,
        meaning="along it",
    ),
    Field("closed", False, meaning="from the last point straight to the first, and round again"),
)


class Track(record("Track", TRACK)):
    """The path of an obstacle's centre: from its initial place through ``to``, back and forth or round."""

    __slots__ = ()

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

    def velocity(self, begin, time):
        """Return the velocity, (2,) [m/s], from ``time`` [s] on of a centre that begins at ``begin``."""
        points = [begin, *self.to]
        points = np.array([*points, *([begin] if self.closed else points[-2::-1])], dtype=float)
        legs = np.diff(points, axis=0)
        lengths = np.hypot(*legs.T)
        reached = np.cumsum(lengths)
        leg = int(np.searchsorted(reached, (self.speed * time) % reached[-1], side="right"))
        leg = min(leg, len(legs) - 1)
        return self.speed * legs[leg] / lengths[leg]

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


def advance(obstacle, time, period, directions):
    """Return the greatest speed of an ``obstacle`` along unit vectors ``directions`` (n, 2), (n,) [m/s].

    It is the largest mean velocity along each from ``time`` [s] to any time within ``period`` [s]: nowhere
    meanwhile has it come farther than that velocity takes it, as long as its track has at most one corner
    there, since the mean goes from the velocity before it towards that after it.
    """
    if not moves(obstacle):
        return np.zeros(len(directions))
    track, begin = obstacle.track, (obstacle.x, obstacle.y)
    before, after = (np.array(track.place(begin, at)) for at in (time, time + period))
    return np.maximum(
        directions @ track.velocity(begin, time), directions @ ((after - before) / period)
    )


def scene_time(clock):
    """Return the time [s] of the scene at the stage's ``clock`` [s]."""
    return max(0.0, round(clock - CLOCK_START, 9))


def scene_facts(obstacles, begun):
    """Return the facts of a run's scene, which was at ``begun`` [s]; {} where nothing moves."""
    return {"scene_time": float(begun)} if begun and any(map(moves, obstacles)) else {}


def _moved(obstacle, x, y):
    """Return the ``obstacle`` at (x, y) [m], without its track."""
    return obstacle._replace(x=x, y=y, track=None)


def read_track(section, begin):
    """Return the ``Track`` under ``track`` of an obstacle that begins at ``begin`` (x, y); None without."""
    if not section.has("track"):
        return section.take("track")
    own = Section(section.take("track"), section.at("track"))
    return Track(**own.values(TRACK, {"begin": begin}))
