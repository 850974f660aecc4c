"""Colours of robots: the same in curves, map and table, and, on a light ground, in saved figures."""

import functools

import numpy as np
from matplotlib.cm import viridis

from mrs_simulator.rqt_plugin.qt.QtGui import QColor
from mrs_simulator.study.draw.figure_parts import MOST_IN_LEGEND, PALETTE

DASHES = 4  # [-] patterns of lines that distinguish robots besides their colours
STEPS = 24  # [-] distinct colours of a team with more than ``MOST_IN_LEGEND`` robots
# Of viridis: without the pale end, which is too faint on white, or the dark one.
ON_LIGHT, ON_DARK = (0.0, 0.92), (0.3, 1.0)
DARK = 0.5  # [-] lightness, below which a ground is dark
BRIGHTENED = 0.25  # [-] share of white in the colours of a small team on a dark ground
# A mode is one of a row of joined buttons.  Some styles hardly distinguish a pressed button in a
# dark theme.
CHECKED = (
    "QToolButton:checked { background: palette(highlight); color: palette(highlighted-text);"
    " border: 1px solid palette(highlight); border-radius: 2px; }"
    # A style sheet takes a style's own mark of the focus away.
    " QToolButton:checked:focus { border: 2px solid palette(window-text); }"
)
DIM = 0.4  # [-] lightness, below which a colour is brightened there


@functools.lru_cache(maxsize=16)
def _shades(many, dark):
    if many:
        samples = viridis(np.linspace(*(ON_DARK if dark else ON_LIGHT), STEPS))
        return tuple(QColor(*rgb) for rgb in (255.0 * samples[:, :3]).round().astype(int).tolist())
    return tuple(_brightened(QColor(name)) if dark else QColor(name) for name in PALETTE)


def _brightened(shade):
    if shade.lightnessF() > DIM:
        return shade
    parts = (int(round(part + BRIGHTENED * (255 - part))) for part in shade.getRgb()[:3])
    return QColor(*parts)


def shades(count, ground):
    """Return the distinct ``QColor``s of a team of ``count`` robots on the ``QColor`` ``ground``.

    :func:`places` assigns them to robots: they repeat in a small team, and range from the first to the last
    robot in a large one.
    """
    return _shades(count > MOST_IN_LEGEND, ground.lightnessF() < DARK)


def places(numbers, count):
    """Return the place of each of the robots ``numbers`` in :func:`shades` of a team of ``count``."""
    numbers = np.asarray(numbers, dtype=int).reshape(-1)
    if count <= MOST_IN_LEGEND:
        return (numbers - 1) % len(PALETTE)
    steps = (numbers - 1) * (STEPS - 1) / max(1, count - 1)
    return np.clip(np.round(steps).astype(int), 0, STEPS - 1)


def dash_places(numbers, count):
    """Return which of ``DASHES`` patterns, from 0 on, ``numbers`` of a team of ``count`` robots have.

    Those of robots of one colour differ, and in a large team those of neighbours, whose colours are alike.
    """
    each = len(PALETTE) if count <= MOST_IN_LEGEND else 1
    return (np.asarray(numbers, dtype=int).reshape(-1) - 1) // each % DASHES


def shade(number, count, ground):
    """Return the ``QColor`` of robot ``number`` of a team of ``count`` on ``ground``."""
    return shades(count, ground)[places([number], count)[0]]
