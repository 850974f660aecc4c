"""Figures in the project's style: made, laid out and saved, the same run in the same bytes.

Nothing here uses pyplot or changes the global ``rcParams`` for good.
"""

import contextlib
import functools
import io
import os
import threading
import zlib

import matplotlib
import numpy as np
from matplotlib.backend_bases import get_registered_canvas_class
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from mrs_simulator.core.writing import write_bytes
from mrs_simulator.study.draw import pdf_fonts
from mrs_simulator.study.draw.style import WIDTHS

# Saved files carry no date, so that the same run gives the same bytes.
METADATA = {"png": {}, "pdf": {"CreationDate": None}, "svg": {"Date": None}}
SOFTWARE = "Matplotlib version{}, https://matplotlib.org/".format(matplotlib.__version__)
OPAQUE = 255, 255  # [-] least and largest alpha
STAMPED = {"png": "Description", "pdf": "Subject", "svg": "Description"}  # what a file carries

WIDTH = WIDTHS["page"]  # [in]
HEIGHT = 3.4  # [in]

STYLE = {
    "font.family": "serif",
    "font.serif": ["STIXGeneral", "DejaVu Serif"],
    "mathtext.fontset": "stix",
    "font.size": 10.0,
    "axes.labelsize": 10.0,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.fontsize": 9.0,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "legend.columnspacing": 1.6,
    "axes.linewidth": 0.7,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.6,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "savefig.dpi": 200,
    "pdf.fonttype": 42,
    "svg.hashsalt": "mrs_simulator",
    "path.simplify": True,
}

# Two threads that borrowed the global rcParams at once would hand them back in the wrong order.
_RC_LOCK = threading.RLock()
_own_styles = [{}]  # over STYLE, the innermost last; changed under the lock alone


def styled(function):
    """Run ``function`` under ``STYLE`` and leave the global ``rcParams`` as they were."""

    @functools.wraps(function)
    def under_style(*args, **kwargs):
        with _RC_LOCK, matplotlib.rc_context({**STYLE, **_own_styles[-1]}):
            return function(*args, **kwargs)

    return under_style


@contextlib.contextmanager
def in_style(style):
    """Draw with the rcParams in ``style`` over ``STYLE``, in this thread, while others wait."""
    with _RC_LOCK:
        _own_styles.append(style)
        try:
            yield
        finally:
            _own_styles.pop()


@styled
def new_figure(width=WIDTH, height=HEIGHT):
    """Return an empty figure of ``width`` by ``height`` [in] that makes room for its labels."""
    figure = Figure(figsize=(width, height), constrained_layout=True)
    FigureCanvasAgg(figure)
    return figure


@styled
def settle(figure):
    """Lay out ``figure`` once and for all.

    The solver of the layout leaves its last digits to chance: places are rounded, so that the same
    run gives the same bytes.
    """
    _leave_out(figure)
    if hasattr(figure, "set_layout_engine"):  # matplotlib 3.6
        figure.get_layout_engine().execute(figure)
        figure.set_layout_engine("none")
    else:
        figure.execute_constrained_layout()
        figure.set_constrained_layout(False)
    for axes in figure.axes:
        axes.set_position([round(value, 4) for value in axes.get_position(original=True).bounds])


def _leave_out(figure):
    """Keep each drawing of ``figure`` from looking for what it does not have, a twentieth of its time.

    For the place of titles that are empty, and for major ticks that minor ones might lie on.
    """
    for axes in figure.axes:
        if not any(map(axes.get_title, ("left", "center", "right"))):
            axes.set_title("", y=1.0)
        for axis in (axes.xaxis, axes.yaxis):
            axis.remove_overlapping_locs = not isinstance(axis.get_minor_locator(), NullLocator)


@styled
def save(figure, path, stamp=""):
    """Write ``figure`` to ``path`` in the format of its ending, whole or not at all; return path.

    ``stamp``: a text that the file carries as metadata.
    """
    kind = os.path.splitext(path)[1][1:]
    image, metadata = io.BytesIO(), METADATA.get(kind)
    if stamp and kind in STAMPED:
        metadata = {**metadata, STAMPED[kind]: stamp}
    if _is_settled(figure):
        print_settled(figure, image, kind, metadata)
    else:
        figure.savefig(image, format=kind, metadata=metadata)
    write_bytes(path, image.getvalue())
    return path


def _is_settled(figure):
    """Return whether ``figure`` is laid out for good, as matplotlib 3.6 and later can tell."""
    if not hasattr(figure, "get_layout_engine"):
        return False
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    return not isinstance(figure.get_layout_engine(), ConstrainedLayoutEngine)


def print_settled(figure, image, kind, metadata=None):
    """Write a settled ``figure`` to ``image``: what ``savefig`` does, but for drawing it twice.

    From matplotlib 3.6 on that draws all once before, unseen, to lay it out.
    """
    canvas, dpi = figure.canvas, figure.dpi
    try:
        figure.dpi = matplotlib.rcParams["savefig.dpi"]
        printing = get_registered_canvas_class(kind)(figure)
        metadata = metadata or METADATA.get(kind)
        if kind == "png":
            _print_png(printing, image, {"Software": SOFTWARE, **metadata})
            return
        with pdf_fonts.shared() if kind == "pdf" else contextlib.nullcontext():
            getattr(printing, "print_" + kind)(image, metadata=metadata)
    finally:
        figure.dpi = dpi
        figure.set_canvas(canvas)


def _print_png(canvas, image, metadata):
    """Write what ``canvas`` draws to ``image``, without the fourth channel where all is opaque.

    Drawings repeat pixels: to look for longer repetitions takes twice as long and saves 4 %.
    """
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    canvas.draw()
    pixels = Image.fromarray(np.asarray(canvas.buffer_rgba()))
    if pixels.getchannel("A").getextrema() == OPAQUE:
        pixels = pixels.convert("RGB")
    carried, dpi = PngInfo(), canvas.figure.dpi
    for name, text in metadata.items():
        carried.add_text(name, text)
    pixels.save(image, "png", compress_type=zlib.Z_RLE, dpi=(dpi, dpi), pnginfo=carried)
