"""Paints drawings of ``pictures`` with matplotlib: files, video frames, axes of one's own."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke

from mrs_simulator.pictures.drawing import Lines, Paths, Polygons

TEXT_SIZE = 8.5  # [pt]
DPI = 100
RIM = 0.5  # [px] width of the lines around faces


def paint(axes, drawing):
    """Fill ``axes`` with ``drawing``; one pixel of it is one unit of the axes, y downwards."""
    axes.set_xlim(0.0, drawing.width)
    axes.set_ylim(drawing.height, 0.0)
    axes.set_axis_off()
    axes.add_patch(_ground(drawing))
    for place, layer in enumerate(drawing.layers):
        if isinstance(layer, Polygons):
            artist = PolyCollection(
                _pieces(layer),
                facecolors=layer.colours,
                edgecolors=layer.rims,
                linewidths=RIM * _points(axes),
            )
            axes.add_collection(artist, autolim=False)
            artist.set_zorder(1 + place)
        elif isinstance(layer, (Lines, Paths)):
            lines = layer.segments if isinstance(layer, Lines) else _pieces(layer)
            width = layer.width * _points(axes)
            artist = LineCollection(lines, colors=layer.colours, linewidths=width)
            axes.add_collection(artist, autolim=False)
            artist.set_zorder(1 + place)
        else:
            for (x, y), text in zip(layer.places, layer.texts):
                halo = [withStroke(linewidth=2.0, foreground=layer.halo)]
                how = {"ha": "left" if layer.left else "center", "va": "center"}
                axes.text(
                    x, y, text, color=layer.colour, size=TEXT_SIZE, path_effects=halo,
                    zorder=1 + place, clip_on=True, **how,
                )  # fmt: skip


def pixels(drawing):
    """Return ``drawing`` as (height, width, 3) uint8."""
    figure = Figure(figsize=(drawing.width / DPI, drawing.height / DPI), dpi=DPI)
    canvas = FigureCanvasAgg(figure)
    paint(figure.add_axes([0.0, 0.0, 1.0, 1.0]), drawing)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[: drawing.height, : drawing.width, :3]


def _pieces(layer):
    return np.split(layer.points, np.cumsum(layer.counts)[:-1])


def _ground(drawing):
    return Rectangle((0, 0), drawing.width, drawing.height, color=drawing.ground, zorder=0)


def _points(axes):
    """Return how many points a pixel of the drawing is, [pt]."""
    box = axes.get_window_extent()
    return 72.0 / axes.figure.dpi * box.width / abs(np.diff(axes.get_xlim())[0])
