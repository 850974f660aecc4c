"""The figure ``certificates``: energies, connectivity and other curves that theory speaks of."""

import os

import numpy as np
from matplotlib import rcParams

from mrs_simulator.control.user_code import print_raised
from mrs_simulator.study.draw.canvas import in_style, new_figure, save, settle, styled
from mrs_simulator.study.draw.figure_parts import legend_of_all, thin
from mrs_simulator.study.draw.log_ticks import label_log
from mrs_simulator.study.draw.style import Look

CERTIFICATES = "certificates"  # name of the file
MEASURED, BOUND = "#0072b2", "#d60000"
PANEL = 1.9  # [in]


def certificate_figure(curves, look=None):
    """Return the figure of ``curves``, a panel for each: measured, predicted dashed, a bound dotted."""
    look = Look() if look is None else look
    with in_style(look.style):
        return _figure(curves, look)


def save_certificates(curves, out, formats, look=None):
    """Write the figure of ``curves`` to the directory ``out``; a fault in them is printed, and no more."""
    try:
        figure = certificate_figure(curves, look)
    except Exception as error:
        print_raised(error)
        return
    for kind in formats:
        path = os.path.join(out, "{}.{}".format(CERTIFICATES, kind))
        save(figure, path, look.stamp if look else "")


@styled
def _figure(curves, look):
    figure = new_figure(look.width, 0.5 + look.scaled(PANEL) * len(curves))
    panels = figure.subplots(len(curves), 1, squeeze=False)[:, 0]
    for axes, curve in zip(panels, curves):
        _draw(axes, curve)
    legend_of_all(panels)
    figure.align_ylabels(list(panels))
    settle(figure)
    return figure


def _draw(axes, curve):
    line = {"ls": "", "marker": "o", "ms": 5} if curve.points else {"lw": 1.4}
    at, measured = np.asarray(curve.at), np.asarray(curve.measured, dtype=float)
    axes.plot(*_thinned(curve, at, measured), color=MEASURED, label="Measured", **line)
    if curve.predicted is not None:
        style = {"color": "k", "ls": (0, (4, 3)), "lw": 1.1}
        where = at if curve.predicted_at is None else np.asarray(curve.predicted_at)
        predicted = np.asarray(curve.predicted, dtype=float)
        axes.plot(*_thinned(curve, where, predicted), label="Theory", **style)
    if curve.bound is not None:
        axes.axhline(curve.bound, color=BOUND, ls=":", lw=1.2, label="Bound")
    if curve.log and np.all(measured > 0.0):
        axes.set_yscale("log")
        label_log(axes.yaxis)
    if curve.points and curve.predicted_at is not None:
        axes.set_xlim(np.min(curve.predicted_at), np.max(curve.predicted_at))
    elif curve.points:
        axes.set_xticks(at)
    else:
        axes.set_xlim(at[0], at[-1] if at[-1] > at[0] else at[0] + 1.0)
    axes.set_xlabel(curve.across)
    axes.set_ylabel(curve.name.replace(" [", "\n["), fontsize=0.9 * rcParams["axes.labelsize"])


def _thinned(curve, at, values):
    return (at, values) if curve.points else thin(at, values)
