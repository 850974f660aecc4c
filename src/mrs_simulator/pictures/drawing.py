"""The primitives of a picture for any toolkit: polygons, lines and texts in pixels, back to front."""

from typing import Any, NamedTuple, Tuple

import numpy as np


class Polygons(NamedTuple):
    """m filled convex polygons, painted in their order."""

    points: Any  # (v, 2) [px], polygon after polygon
    counts: Any  # (m,) corners of each
    colours: Any  # (m, 4) red, green, blue, opacity in 0..1
    rims: Any  # (m, 4) of the line around each


class Lines(NamedTuple):
    """m straight lines."""

    segments: Any  # (m, 2, 2) [px]
    colours: Any  # (m, 4)
    width: float  # [px]


class Paths(NamedTuple):
    """m lines through several points each."""

    points: Any  # (v, 2) [px], path after path
    counts: Any  # (m,) points of each
    colours: Any  # (m, 4)
    width: float  # [px]


class Texts(NamedTuple):
    """m short texts, each centred at its place, or beginning there (``left``)."""

    places: Any  # (m, 2) [px], of the middle of the line
    texts: Tuple[str, ...]
    colour: Tuple[float, ...]  # (4,)
    halo: Tuple[float, ...]  # (4,) of the rim that keeps a text readable on any ground
    left: bool = False


class Drawing(NamedTuple):
    """A whole picture."""

    width: int  # [px]
    height: int
    ground: Tuple[float, ...]  # (3,) colour of all that nothing else covers
    layers: Tuple[Any, ...]


def taken(points, counts, order):
    """Return the ``points`` (v, 2) of polygons of ``counts`` (m,) corners in another ``order``."""
    begins = np.cumsum(counts) - counts
    return points[ranges(begins[order], counts[order])]


def ranges(begins, counts):
    """Return the indices of ``counts`` (m,) places from each of ``begins`` (m,) on, one after the other."""
    total = int(counts.sum())
    shift = np.repeat(begins - (np.cumsum(counts) - counts), counts)
    return np.arange(total) + shift


def with_opacity(colours, opacity):
    """Return ``colours`` (..., 3) with an opacity, (..., 4)."""
    colours = np.asarray(colours, dtype=float)
    opacity = np.broadcast_to(np.asarray(opacity, dtype=float), colours.shape[:-1])
    return np.concatenate([colours, opacity[..., np.newaxis]], axis=-1)
