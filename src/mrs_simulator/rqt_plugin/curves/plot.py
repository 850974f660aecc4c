"""Drawing of the curves panel: a matplotlib figure in a widget's colours and font.

The style is that of the saved figures.  matplotlib's global ``rcParams`` are neither changed nor
relied on: a thread that saves figures may have borrowed them.
"""

import functools

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, fontManager
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from mrs_simulator.rqt_plugin.curves.quantities import (
    ERROR,
    QUANTITIES,
    fitted,
    foot,
    thinned,
    thinned_together,
)
from mrs_simulator.rqt_plugin.qt.QtGui import QColor
from mrs_simulator.rqt_plugin.widgets.colours import dash_places, places, shade, shades
from mrs_simulator.study.draw.compared_panels import BROAD, PALE, run_line
from mrs_simulator.study.draw.figure_parts import MOST_IN_LEGEND
from mrs_simulator.study.draw.log_ticks import label_log

MOST_POINTS, ALL_POINTS = 800, 12000  # of one curve, of all
MANY_CURVES, BUNDLED_POINTS = 40, 20000  # beyond, all are one artist; points of all of them
MOST_LABELLED = 40
DASHES = ("-", (0, (4, 1, 1, 1)), (0, (2, 1)), (0, (1, 1)))  # besides colours
AHEAD = (0, (2.2, 1.6))  # the dashes of what is looked ahead of
ROOM, LOOSE = 0.05, 0.75  # [-] beside what fits an axis; of a held one, below which it is renewed
MOST_RUNS = 6  # [-] beside each other in a legend
COLOURS = 7  # [-] of compared runs' errors
DPI = 96
MOST_NAMED = 0.3  # [-] of the figure's height that a legend above the axes may have
ROW = 1.3  # [em] of height of a legend above the axes
POWER = 2.4  # [em] width of a power of ten
LOW = 9.0  # [em] of height, below which the axes have all of it: no legend, no names


@functools.lru_cache(maxsize=8)
def _known(family):
    """Return the families to draw with: the window's own where matplotlib finds it."""
    names = {entry.name for entry in fontManager.ttflist}
    return [name for name in (family,) if name in names] + ["DejaVu Sans"]


def _in_legend(style):
    """Return of a ``style`` what is the same whether or not the curve is picked out."""
    return {key: value for key, value in style.items() if key not in ("alpha", "lw", "zorder")}


class CurvesPlot:
    """The figure of one quantity against time."""

    def __init__(self, size=(5.0, 3.0)):
        """``size``: width and height [in]."""
        self.figure = Figure(figsize=size, dpi=DPI)
        FigureCanvasAgg(self.figure)  # until it is shown in another
        self._axes, self._bar = None, None
        self._curves, self._numbers, self._index, self._built = [], (), 0, None
        self.remark = ""  # above the axes
        self._bundle, self._drawn = None, []  # what is drawn: time and values of each curve
        self.builds, self._laid = 0, None  # [-] of axes; what their place and labels are of

    @property
    def axes(self):
        """Return the axes, made when they are first asked for, which takes 6 ms."""
        if self._axes is None:
            self._axes = self.figure.add_subplot(1, 1, 1)
        return self._axes

    def take_look(self, family, pixels, face, base, text, math="dejavusans"):
        """Take the font's family and size [pixels], and the colours (r, g, b) of background and text.

        ``math``: matplotlib's name of the fonts of formulas.
        """
        self._face, self._base, self._text = face, base, text
        self._font = FontProperties(family=_known(family), size=72.0 * pixels / DPI)
        self._width = max(1.0, pixels / 16.0)  # of a thin line [points]
        if hasattr(self._font, "set_math_fontfamily"):  # since matplotlib 3.4
            self._font.set_math_fontfamily(math)
        self._built = None

    def styles(self, shown, numbers):
        """Return how to draw each of the robots ``shown`` of the team ``numbers``."""
        width = 1.3 if len(shown) <= MOST_IN_LEGEND else 0.8 if len(shown) <= MOST_LABELLED else 0.5
        count = max(numbers)
        of_team = [each.getRgbF()[:3] for each in shades(count, self._ground())]
        colours = [of_team[place] for place in places(shown, count).tolist()]
        dashes = [DASHES[place] for place in dash_places(shown, count).tolist()]
        styles = zip(colours, dashes)
        return [{"color": c, "ls": dash, "lw": width * self._width} for c, dash in styles]

    def error_styles(self):
        """Return how to draw the error of the run, and that of theory."""
        run = {"color": self._shade(1, 1), "lw": 1.3 * self._width}
        return run, {"color": self._text, "lw": self._width, "ls": (0, (4, 3))}

    def ahead_style(self):
        """Return how to draw the error of the run as it would go on."""
        return dict(self.error_styles()[0], ls=AHEAD)

    def compared_style(self, place):
        """Return how to draw the error of the compared run at ``place``, from 1 on."""
        colour = self._shade(1 + place % COLOURS, COLOURS)
        return {"color": colour, "lw": 1.3 * self._width, "ls": run_line(place)}

    def theory_style(self, place):
        """Return how to draw theory of the run at ``place``, among several: broad and pale."""
        style = self.compared_style(place) if place else self.error_styles()[0]
        return dict(style, lw=BROAD * style["lw"], alpha=PALE, zorder=1.8)

    def update(self, curves, numbers, index, message, xlim, ylim):
        """Show ``curves`` of quantity ``index`` of a team within limits; ``ylim`` None: fitting."""
        self._curves, self._numbers, self._index = curves, numbers, index
        box, lone = self.figure.bbox, all(len(curve.time) == 1 for curve in curves)
        looks = [(curve.name, _in_legend(curve.style)) for curve in curves]
        built = looks, numbers, index, message, box.size.tolist(), lone, self.remark
        if built != self._built:
            self._build(message, {"marker": "o", "ms": 3} if lone else {})
            self._built, self.builds = built, self.builds + 1
        self._restyle()
        self.axes.set_xlim(xlim)
        if self._bundle is not None:
            self._drawn = self._fill_bundle()
        else:
            self._drawn = [self._fill(*pair) for pair in zip(curves, self.axes.lines)]
        self.axes.set_ylim(ylim or self._fitting(index == ERROR))
        if self._laid != self.around():
            self._lay_out()
            self._laid = self.around()

    def _restyle(self):
        """Show which curves are picked out; for that nothing is built anew."""
        if self._bundle is not None:
            styles = [curve.style for curve in self._curves]
            self._bundle.set_color([(*to_rgb(s["color"]), s.get("alpha", 1.0)) for s in styles])
            self._bundle.set_linewidth([s["lw"] for s in styles])
            return
        for curve, line in zip(self._curves, self.axes.lines):
            style = curve.style
            line.set(alpha=style.get("alpha"), lw=style["lw"], zorder=style.get("zorder", 2.0))

    def _fitting(self, log):
        """Return limits that fit what is drawn: those of before where they still do."""
        wanted = fitted([values for _, values in self._drawn], log)
        if self._laid is None or self._laid[0] != self.builds:
            return wanted
        held = self.axes.get_ylim()
        (low, high), (least, most) = (np.log(pair) if log else pair for pair in (held, wanted))
        room = 0.5 * ROOM * (most - least)  # what fits has more of it
        still = low <= least + room and high >= most - room
        return held if still and most - least > LOOSE * (high - low) else wanted

    def around(self):
        """Return what all but the curves depends on, anything that can be compared."""
        box = self.figure.bbox.size.tolist(), self.figure.dpi
        return self.builds, self.axes.get_xlim(), self.axes.get_ylim(), box

    @property
    def moving(self):
        """Return the artists of the curves, which change as a run goes on."""
        lines = list(self.axes.lines) if self._bundle is None else [self._bundle]
        return sorted(lines, key=lambda line: line.get_zorder())

    def nearest(self, x, y):
        """Return the curve within reach of a pixel, its nearest point [pixels] and time, or None."""
        best, found = 1.5 * self.em(), None
        if not self.axes.bbox.contains(x, y):
            return None
        data = self.axes.transData
        begin, end = data.inverted().transform([[x - best, y], [x + best, y]])[:, 0]
        for curve, (time, values) in zip(self._curves, self._drawn):
            first = max(0, np.searchsorted(time, begin) - 1)
            near = slice(first, np.searchsorted(time, end) + 1)
            place = foot(data.transform(np.column_stack([time[near], values[near]])), (x, y))
            away = np.hypot(*(place - (x, y)))
            if away < best:
                best, found = away, (curve, place)
        return found and (*found, data.inverted().transform(found[1])[0])

    def em(self):
        """Return the font's size [pixels]."""
        return self._font.get_size() * self.figure.dpi / 72.0

    def _is_low(self):
        return self.figure.bbox.height < LOW * self.em()

    def _ground(self):
        return QColor.fromRgbF(*self._base)

    def _shade(self, number, count):
        """Return the colour (r, g, b) of robot ``number`` of a team of ``count``."""
        return shade(number, count, self._ground()).getRgbF()[:3]

    def _mixed(self, part):
        """Return a colour between the background, 0, and the text, 1."""
        return tuple((1.0 - part) * a + part * b for a, b in zip(self._base, self._text))

    def _build(self, message, marks):
        """Make the axes, one line per curve, and a legend or colour bar."""
        quantity, em = QUANTITIES[self._index], self.em()
        for axes in list(self.figure.axes):  # to clear them would make them anew
            self.figure.delaxes(axes)
        self.figure.set_facecolor(self._face)
        self._axes = axes = self.figure.add_subplot(1, 1, 1)
        axes.set_facecolor(self._base)
        look = {"fontproperties": self._font, "color": self._text}
        if not self._is_low():
            axes.set_xlabel("time [s]", **look)
            axes.set_ylabel("{} [{}]".format(quantity.label, quantity.unit), **look)
        axes.text(0.5, 0.5, message, ha="center", transform=axes.transAxes, **look)
        if self._index == ERROR:
            axes.set_yscale("log")
            label_log(axes.yaxis)
        else:
            self._number(axes.yaxis, self.figure.bbox.height / (2.6 * em), False)
        self._number(axes.xaxis, self.figure.bbox.width / (4.5 * em), True)
        axes.xaxis.offsetText.set(**look)
        axes.set_axisbelow(True)
        axes.grid(True, color=self._mixed(0.13), lw=0.6)
        axes.tick_params(which="both", direction="in", color=self._mixed(0.7))
        axes.tick_params(which="both", labelcolor=self._text)
        for spine in axes.spines.values():
            spine.set(color=self._mixed(0.7), linewidth=0.7)
        self._bundle = None
        if len(self._curves) > MANY_CURVES:
            self._bundle = LineCollection([])
            axes.add_collection(self._bundle, autolim=False)
        else:
            for curve in self._curves:
                axes.plot([], [], **curve.style, **marks)
        self._name_curves()
        if self.remark and not self._is_low():
            self._top = max(self._top, (0.6 + ROW) * self.em())
            corner = {"va": "bottom", "transform": axes.transAxes, "fontproperties": self._font}
            axes.text(0.0, 1.015, self.remark, color=self._text, **corner)

    def _number(self, axis, most, offset):
        axis.set_major_locator(MaxNLocator(int(np.clip(most, 2, 8)), steps=[1, 2, 5, 10]))
        form = ScalarFormatter(useOffset=offset)
        form.set_scientific(False)
        axis.set_major_formatter(form)

    def _name_curves(self):
        """Identify the lines: by a legend above or beside the axes, or a colour bar."""
        self._bar, self._side, self._top = None, 0.0, 0.8 * self.em()
        if not self._curves or self._is_low():
            return
        lines = list(self.axes.lines)
        runs = list(dict.fromkeys(curve.run for curve in self._curves))
        if self._index == ERROR:
            self._legend_above(lines, [curve.name for curve in self._curves])
            if (
                self._top > MOST_NAMED * self.figure.bbox.height
            ):  # a run's theory has its colour and dash
                seen = [line for line in lines if line.get_zorder() >= 2.0]
                self._legend_above(seen, [self._curves[lines.index(line)].name for line in seen])
        elif len(self._curves) > MANY_CURVES or len(self._first_run(runs)) > MOST_IN_LEGEND:
            self._add_bar()
        else:
            curves = self._first_run(runs)
            room = self.figure.bbox.height / self.em() - 4.5
            columns = -(-len(curves) // max(1, int(room / 1.25)))
            place = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0), "ncol": columns}
            names = [curve.name.partition(",")[0].replace("Robot ", "") for curve in curves]
            legend = self._legend(lines[: len(curves)], names, place, 0.5, "Robot")
            self._side = legend.get_window_extent(self.figure.canvas.get_renderer()).width
            if len(runs) > 1:
                self.axes.add_artist(legend)  # else the next legend takes its place
        if self._index != ERROR and len(runs) > 1:
            look = {"color": self._text, "lw": 1.3 * self._width}
            signs = [Line2D([], [], ls=run_line(place), **look) for place in range(len(runs))]
            self._legend_above(signs, runs)

    def _first_run(self, runs):
        """Return the curves of the first of ``runs``."""
        return [curve for curve in self._curves if curve.run == runs[0]]

    def _legend_above(self, lines, names):
        """Add a legend above the axes, in as many rows as the width asks for, and leave room for it."""
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
        columns = min(MOST_RUNS, len(lines))
        legend = self._legend(lines, names, dict(place, ncol=columns), 0.0, "")
        wide = legend.get_window_extent(self.figure.canvas.get_renderer()).width
        room = self.figure.bbox.width - self._side - 5.0 * self.em()
        if wide > room and columns > 1:
            rows = -(-len(lines) // max(1, int(columns * room / wide)))
            columns = -(-len(lines) // rows)
            self._legend(lines, names, dict(place, ncol=columns), 0.0, "")
        self._top = (0.6 + ROW * -(-len(lines) // columns)) * self.em()

    def _legend(self, lines, names, place, pad, title):
        """Return a legend of ``lines`` at ``place``."""
        legend = self.axes.legend(
            lines,
            names,
            prop=self._font,
            frameon=False,
            handlelength=1.4 if title else 2.4,
            handletextpad=0.5,
            columnspacing=1.0,
            labelspacing=0.2,
            borderpad=0.1,
            borderaxespad=pad,
            **place,
        )
        legend.set_title(title, prop=self._font)
        for text in [legend.get_title(), *legend.get_texts()]:
            text.set_color(self._text)
        return legend

    def _add_bar(self):
        em, low, high = self.em(), min(self._numbers), max(self._numbers)
        self._bar = bar = self.figure.add_axes([0.9, 0.1, 0.05, 0.8], label="robots")
        count, numbers = max(self._numbers), np.linspace(low, high, 256).round().astype(int)
        of_team = np.array([each.getRgbF()[:3] for each in shades(count, self._ground())])
        picture = of_team[places(numbers, count)][:, np.newaxis]
        bar.imshow(picture, aspect="auto", origin="lower", extent=(0, 1, low, high))
        bar.set_xticks([])
        bar.set_yticks(np.unique(np.linspace(low, high, 6).round()))
        bar.yaxis.tick_right()
        bar.tick_params(labelcolor=self._text, length=0, pad=2)
        bar.set_title("Robot", fontproperties=self._font, color=self._text, loc="left")
        for spine in bar.spines.values():
            spine.set_visible(False)
        self._side = 3.8 * em

    def _fill(self, curve, line):
        """Give ``line`` the visible part of ``curve``; return it."""
        most = min(MOST_POINTS, ALL_POINTS // len(self._curves))
        drawn = thinned(curve, *self.axes.get_xlim(), most)
        line.set_data(*drawn)
        return drawn

    def _fill_bundle(self):
        """Give the bundle the visible parts of all curves, which share their times; return it."""
        table = np.stack([curve.values for curve in self._curves], axis=1)
        most = BUNDLED_POINTS // len(self._curves)
        limits = self.axes.get_xlim()
        time, table = thinned_together(self._curves[0].time, table, *limits, most)
        values = table.T
        points = np.stack([np.broadcast_to(time, values.shape), values], axis=2)
        self._bundle.set_segments(points)
        return [(time, row) for row in values]

    def _widest(self, axis):
        """Return the width [em] of the labels at the ticks of ``axis``."""
        texts = axis.get_major_formatter().format_ticks(axis.get_majorticklocs())
        return max([POWER if "$" in text else 0.52 * len(text) for text in texts] + [0.52])

    def _lay_out(self):
        """Give the axes all the room that their labels leave."""
        em, axes = self.em(), self.axes
        width, height = self.figure.bbox.width, self.figure.bbox.height
        wide = self._widest(axes.yaxis)
        left, right = (2.5 + wide) * em, self._side + (1.2 if self._side else 1.5) * em
        below = (1.6 if self._is_low() else 3.0) * em
        above = 0.3 * em if self._is_low() else self._top
        low, tall = below / height, max(0.1, 1.0 - (below + above) / height)
        axes.set_position([left / width, low, max(0.1, 1.0 - (left + right) / width), tall])
        if self._bar is not None:
            place = 1.0 - (right - 1.2 * em) / width
            self._bar.set_position([place, low, 0.9 * em / width, tall - 1.1 * em / height])
        for axis in (axes.xaxis, axes.yaxis, *([self._bar.yaxis] if self._bar else [])):
            for tick in axis.get_major_ticks() + axis.get_minor_ticks():
                tick.label1.set_fontproperties(self._font)
                tick.label2.set_fontproperties(self._font)
