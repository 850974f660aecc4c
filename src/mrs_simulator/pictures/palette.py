"""Colours of pictures, red, green, blue in 0..1."""

from typing import NamedTuple, Tuple

START = (0.84, 0.0, 0.0)  # of the dot where a robot began


class Palette(NamedTuple):
    """Colours of everything that has no colour of its own."""

    ground: Tuple[float, float, float]
    water: Tuple[float, float, float]
    sky: Tuple[float, float, float]
    lines: Tuple[float, float, float]  # of the grid and the graph
    text: Tuple[float, float, float]
    halo: Tuple[float, float, float]  # around texts
    obstacle: Tuple[float, float, float]
    shadow: float  # [-] opacity


LIGHT = Palette(
    ground=(0.93, 0.94, 0.93),
    water=(0.80, 0.88, 0.93),
    sky=(0.985, 0.99, 1.0),
    lines=(0.45, 0.48, 0.50),
    text=(0.10, 0.10, 0.10),
    halo=(1.0, 1.0, 1.0),
    obstacle=(0.70, 0.69, 0.66),
    shadow=0.22,
)
DARK = Palette(
    ground=(0.20, 0.21, 0.22),
    water=(0.13, 0.22, 0.30),
    sky=(0.12, 0.13, 0.14),
    lines=(0.60, 0.63, 0.66),
    text=(0.95, 0.95, 0.95),
    halo=(0.10, 0.10, 0.10),
    obstacle=(0.52, 0.51, 0.49),
    shadow=0.4,
)
