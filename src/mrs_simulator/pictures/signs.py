"""Signs in pixels, the same on the map and in space: edges of the graph, starts and targets of robots."""

import numpy as np

from mrs_simulator.pictures.drawing import Lines, Paths, Polygons, with_opacity
from mrs_simulator.pictures.palette import START

SOME_ROBOTS = 30  # [-] beyond, signs and numbers are smaller
MANY_ROBOTS = 200  # [-] beyond, signs are smaller still and there are no numbers
CORNERS = 12  # [-] of dots
EDGE_WIDTHS = (0.7, 6.0)  # [px], least and most; one of weight 1 is EDGE_WIDTH wide
EDGE_WIDTH = 1.4  # [px]
# [px] length of an edge's head, and what it has more of its line's width [-]
HEAD, WIDER = 7.0, 1.5
CROSS_WIDTH = 1.8  # [px]
RING_RADII, RING_WIDTH = (5.0, 3.5, 2.0), 1.4  # [px], in teams of some, more, many
TOWARD_TEXT = 0.25  # [-] of crosses: share of the text's colour, to stand out from trails


def by_count(count, few, more, many):
    """Return which of three sizes suits a team of ``count`` robots."""
    return few if count <= SOME_ROBOTS else more if count <= MANY_ROBOTS else many


def circle():
    """Return the corners (k, 2) of a round sign of radius 1."""
    turn = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
    return np.stack([np.cos(turn), np.sin(turn)], axis=1)


def dots(places, colours, radius):
    """Return discs of ``radius`` [px] at ``places`` (m, 2) [px] in ``colours`` (m, 4)."""
    points = (np.asarray(places)[:, np.newaxis] + radius * circle()).reshape(-1, 2)
    return Polygons(points, np.full(len(places), CORNERS), colours, colours)


def starts(places, count, unit=1.0):
    """Return dots where robots began, at ``places`` (m, 2) [px], of the size that suits ``count`` robots.

    ``unit`` [px]: what signs grow with.
    """
    colours = np.tile((*START, 1.0), (len(places), 1))
    return dots(places, colours, by_count(count, 3.0, 2.2, 1.5) * unit)


def rings(places, colours, count, unit=1.0):
    """Return rings at ``places`` (m, 2) [px] in ``colours`` (m, 4).

    ``count``, ``unit``: as of :func:`starts`.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, 2 * CORNERS + 1)
    rim = unit * by_count(count, *RING_RADII) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    corners = np.asarray(places)[:, np.newaxis] + rim
    counts = np.full(len(corners), len(rim))
    return Paths(corners.reshape(-1, 2), counts, np.asarray(colours), RING_WIDTH * unit)


def crosses(places, shades, text, count, unit=1.0):
    """Return a cross at each target of ``places`` (m, 2) [px], in the ``shades`` (m, 3) of their robots.

    ``text`` (3,): the colour of texts; ``count``, ``unit`` as of :func:`starts`.
    """
    half = by_count(count, 4.5, 3.0, 2.0) * unit
    arms = half * np.array([[(-1, -1), (1, 1)], [(-1, 1), (1, -1)]], dtype=float)
    shades = np.asarray(shades) + TOWARD_TEXT * (np.asarray(text) - shades)
    segments = (np.asarray(places)[:, np.newaxis, np.newaxis] + arms).reshape(-1, 2, 2)
    return Lines(segments, with_opacity(np.repeat(shades, 2, axis=0), 1.0), CROSS_WIDTH * unit)


def edges(begin, end, weight, colour, directed, unit=1.0):
    """Yield the layers of edges from ``begin`` to ``end`` (m, 2) [px], as wide as their ``weight`` (m,).

    ``colour`` (4,); ``directed``: with a head at the receiver, ``end``; ``unit`` as of :func:`starts`.
    """
    widths = unit * np.clip(EDGE_WIDTH * np.asarray(weight), *EDGE_WIDTHS).round(1)
    for width in np.unique(widths):
        chosen = widths == width
        segments = np.stack([begin[chosen], end[chosen]], axis=1)
        yield Lines(segments, np.tile(colour, (len(segments), 1)), float(width))
    if directed and len(widths):
        yield heads(begin, end, widths, colour, unit)


def heads(begin, end, widths, colour, unit=1.0):
    """Return the heads at ``end`` (m, 2) [px] of edges from ``begin``, of ``widths`` (m,) [px]."""
    apart = end - begin
    length = np.maximum(np.hypot(*apart.T), 1e-9)
    size = np.minimum(HEAD * unit + WIDER * widths, 0.6 * length)
    along = apart * (size / length)[:, np.newaxis]
    across = 0.42 * along[:, ::-1] * (-1.0, 1.0)
    # The point is a little beyond the line's blunt end, which it covers.
    points = np.stack([end, end - along + across, end - along - across], axis=1)
    colours = np.tile(colour, (len(points), 1))
    hidden = with_opacity(colours[:, :3], 0.0)
    return Polygons(points.reshape(-1, 2), np.full(len(points), 3), colours, hidden)
