"""A run in motion with its curves beside it, which grow as it goes on."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mrs_simulator.study.draw.canvas import new_figure, settle, styled
from mrs_simulator.study.draw.curve_figures import draw_in_panels

SHARE = 0.5  # [-] of the width that the curves take
PANEL = 0.75  # [in], least height of one


class GrowingCurves:
    """Shows what another stage does, and beside it the curves of states and inputs up to that sample."""

    def __init__(self, run, width, stage):
        """``stage``: makes the other one of the run and a width [in], as ``animation.Stage`` is made.

        Both together are ``width`` [in] wide.
        """
        self._stage = stage(run, (1.0 - SHARE) * width)
        above = self._stage.picture(0)
        dpi = self._stage.figure.dpi
        height = len(above) - len(above) % 2  # an MP4's sides are even
        self._bare, self._whole, places = _drawn(run, SHARE * width, height / dpi, dpi)
        self._ends = np.interp(run.time, *places).round().astype(int)  # [px] of each sample
        across = above.shape[1] + self._whole.shape[1]
        self._size = height, across - across % 2
        self.figure = Figure(figsize=(self._size[1] / dpi, height / dpi), dpi=dpi)
        FigureCanvasAgg(self.figure)
        self._image = self.figure.figimage(self.picture(0), origin="upper")

    def show(self, row):
        """Show sample ``row`` of the run."""
        self._image.set_data(self.picture(row))

    def picture(self, row):
        """Return sample ``row`` as (height, width, 4) uint8."""
        end, height = self._ends[row] + 1, self._size[0]
        curves = np.concatenate([self._whole[:, :end], self._bare[:, end:]], axis=1)
        both = np.concatenate([self._stage.picture(row)[:height], curves[:height]], axis=1)
        return both[:, : self._size[1]]


@styled
def _drawn(run, width, height, dpi):
    """Return pictures of the panels without and with curves, and the times [s] at two pixels."""
    figure = new_figure(width, height)
    figure.set_dpi(dpi)
    panels = draw_in_panels(figure, run, most=int(height / PANEL))
    settle(figure)
    whole = _picture(figure)
    for axes in panels:
        for artist in (*axes.lines, *axes.collections):
            artist.set_visible(False)
    limits = panels[0].get_xlim()
    pixels = panels[0].transData.transform([(time, 0.0) for time in limits])[:, 0]
    return _picture(figure), whole, (limits, pixels)


def _picture(figure):
    figure.canvas.draw()
    return np.array(figure.canvas.buffer_rgba())
