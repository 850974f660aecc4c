"""Draws states of the team over time, and the formation error beside its prediction."""

import math
import time as clock

import numpy as np
from matplotlib.backends.backend_qt5agg import FigureCanvasQTAgg

from mrs_simulator.rqt_plugin.curves import quantities
from mrs_simulator.rqt_plugin.curves.plot import MANY_CURVES, CurvesPlot
from mrs_simulator.rqt_plugin.curves.quantities import (
    ERROR,
    QUANTITIES,
    Curve,
    ErrorCurve,
    positive,
    shown_quantities,
)
from mrs_simulator.rqt_plugin.curves.source import USUAL_AXES, Source
from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QTimer
from mrs_simulator.rqt_plugin.qt.QtGui import QFontInfo, QPalette
from mrs_simulator.rqt_plugin.qt.QtWidgets import QCheckBox, QLineEdit, QTabBar, QWidget
from mrs_simulator.rqt_plugin.run.history import History
from mrs_simulator.rqt_plugin.widgets import pacing
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.study.draw.compared_panels import run_line
from mrs_simulator.study.draw.figure_parts import marks_of

PERIOD, SOON = 250, 40  # [ms] between redraws: of a run, and under a person's hand
ALL = "Robots whose curves are drawn, such as 1-3, 7; empty: all"
FOLLOW = (
    "The time axis goes on with the run.\n"
    "Wheel: zoom about the mouse; beside an axis: that axis alone. Drag: pan. Double click: all."
)
THIS, AHEAD, THEORY = "This run", "What if", "Theory"
BOLD, PALE = 1.8, 0.35  # [-] width of curves picked out; opacity of the others
WRONG = "QLineEdit { border: 1px solid #e5484d; }"
# [s] of a run whose axis ends with it; [s], and [-] of about its length, that it then grows by
SHORT, LEAST_STEP, STEPS = 5.0, 2.0, 8
LONG = 0.01  # [s] of processor time of what is prepared, to be drawn a little later
SMOOTH = 0.2  # [-] share of the newest in the mean cost of redraws, of which some are dear
FAR = 10.0  # [-] times the largest error of a run, above which its theory is not drawn
NO_RUN = "No run yet: Run (F5) starts one"


def _ahead_of(end):
    """Return ``end`` [s], or a little more: an axis that stays need not be drawn anew."""
    if end <= SHORT:
        return end
    step = max(LEAST_STEP, 2.0 ** math.floor(math.log2(end)) / STEPS)
    return step * math.ceil(end / step - 1e-6)


def _seen(theory, run):
    """Return the ``Curve`` of ``theory``, NaN where it is too far off to see the ``run`` beside it."""
    highest = np.nan if run is None else np.nanmax(np.append(run.values, 0.0))
    most = FAR * highest if highest > 0.0 else np.finfo(float).max
    return theory._replace(values=np.where(theory.values <= most, theory.values, np.nan))


class _Canvas(FigureCanvasQTAgg):
    """Paints only while visible, and only after its owner updated the figure."""

    prepare = None

    def __init__(self, plot):
        super().__init__(plot.figure)
        self.plot, self._kept = plot, (None, None)

    @guarded
    def draw(self):
        """Update the figure and draw it."""
        if self.isVisible():
            self.prepare()
            self.draw_prepared()

    def draw_prepared(self):
        """Draw the curves anew, and all around them where it has changed, which costs most."""
        moving, around = self.plot.moving, self.plot.around()
        if around == self._kept[0]:
            self.restore_region(self._kept[1])
        else:
            for artist in moving:
                artist.set_animated(True)  # it is left out
            super().draw()
            self._kept = around, self.copy_from_bbox(self.figure.bbox)
        for artist in moving:
            self.plot.axes.draw_artist(artist)
        self.update()


@guarded
class DrawnCurves(QWidget):
    """State curves of a team and its formation error, redrawn while visible and only if changed."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self.setAutoFillBackground(True)  # as the figure, not as the tabs around it
        self._ranges = ()
        self._live = self.source = Source(History())  # of the run of now; what is shown
        self._others, self._own_name = [], THIS  # ``Source``s over it, and what it is called then
        self._remark = ""  # on the curves of the run of now
        self._cost = 0.0  # [s] of processor time of a redraw, a mean of the last ones
        self._ahead = None  # time since the run began [s] and error [m], as it would go on
        self._prepared = None  # [s] that it took to prepare what is still to be drawn
        self._picked = 0  # the number of the robot that is picked out
        self._xlim, self._ylim = None, None  # None: all
        self._drawn, self._dirty = None, True
        self._goes_on = False  # whether an error is still being computed
        self.timer = QTimer(self, interval=PERIOD, timeout=self.tick)
        self._make_controls()
        self._make_canvas()
        self._take_look()

    def set_history(self, history):
        """Show ``history``, a ``History`` that may go on growing."""
        self._live.history, self._dirty = history, True

    def show_ahead(self, time, error):
        """Draw the ``error`` [m] of the run as it would go on, at ``time`` [s] since it began; or None."""
        known = error is not None and time is not None
        shown = (np.array(time), positive(np.array(error))) if known else None
        if shown is not None or self._ahead is not None:
            self._ahead = shown
            self._renew()

    def set_prediction(self, time, error):
        """Draw theory's ``error`` [m] at ``time`` [s] of the run over its own; None, None: no theory."""
        self._live.set_prediction(time, error)
        self._dirty = True

    def set_error(self, function, background=False):
        """Set the formation error: a function of poses (m, n, 3) to (m,) [m], or None.

        ``background``: it may take long, and is computed in a thread.
        """
        self._live.error, self._dirty = ErrorCurve(function, background), True

    def show_source(self, source):
        """Show the curves of ``source``, a ``Source``, in place of those of the run of now; None: these."""
        source = source or self._live
        if source is not self.source:
            self.source, self._drawn = source, None
            self._offer(*source.team)
            self._renew()

    def compare(self, others, own=""):
        """Draw the curves of ``others``, named ``Source``s, over those shown, as if they began with it.

        ``own``: the name of the run shown.
        """
        self._others, self._own_name = list(others), own or THIS
        self._renew()

    def mark(self, remark):
        """Write ``remark`` into the curves of the run of now, "" for none."""
        if remark != self._remark:
            self._remark = remark
            self._renew()

    def pick_out(self, number):
        """Draw the curves of the robot ``number`` above all others, 0 for none."""
        if number != self._picked:
            self._picked = number
            self._renew()

    def set_axes(self, axes, in_space=False):
        """Offer the quantities of a team whose commands have ``axes``, names of Twist components.

        ``in_space``: whether they leave the ground.
        """
        self._live.team = tuple(axes), in_space
        if self.source is self._live:
            self._offer(axes, in_space)

    def _offer(self, axes, in_space):
        shown = shown_quantities(tuple(axes), in_space)
        if shown == [self.tabs.tabData(tab) for tab in range(self.tabs.count())]:
            return
        chosen, blocked = self._index(), self.tabs.blockSignals(True)
        while self.tabs.count():
            self.tabs.removeTab(0)
        for tab, index in enumerate(shown):
            self.tabs.addTab(QUANTITIES[index].tab)
            self.tabs.setTabToolTip(tab, QUANTITIES[index].meaning)
            self.tabs.setTabData(tab, index)
        self.tabs.setCurrentIndex(shown.index(chosen) if chosen in shown else 0)
        self.tabs.blockSignals(blocked)
        self._dirty = True

    def _index(self):
        """Return the place in ``QUANTITIES`` of what is shown."""
        return self.tabs.tabData(max(0, self.tabs.currentIndex())) if self.tabs.count() else 0

    def _make_controls(self):
        self.tabs, self.field, self.follow = QTabBar(), QLineEdit(toolTip=ALL), QCheckBox("Follow")
        self.set_axes(USUAL_AXES)
        self.tabs.setExpanding(False)
        self.tabs.setDrawBase(False)
        self.tabs.currentChanged.connect(self._on_tab)
        self.field.setPlaceholderText("all robots")
        self.field.textChanged.connect(self._on_field)
        self.follow.setChecked(True)
        self.follow.setToolTip(FOLLOW)
        self.follow.toggled.connect(self._on_follow)

    def _make_canvas(self):
        self.plot = CurvesPlot()
        self.canvas = _Canvas(self.plot)
        self.canvas.prepare = self._prepare
        above = row_of((self.tabs, 1), self.field, self.follow)
        column_of(above, (self.canvas, 1), owner=self, margins=0)

    def _take_look(self):
        """Take sizes from the font and colours from the palette."""
        palette, font = self.palette(), QFontInfo(self.font())
        pixels = font.pixelSize()
        roles = QPalette.Window, QPalette.Base, QPalette.WindowText
        colours = (palette.color(role).getRgbF()[:3] for role in roles)
        self.plot.take_look(font.family(), pixels, *colours)
        self.field.setMinimumWidth(4 * pixels)
        self.field.setMaximumWidth(9 * pixels)
        self.canvas.setPalette(palette)
        self._dirty = True

    def changeEvent(self, event):
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() in (QEvent.PaletteChange, QEvent.FontChange, QEvent.StyleChange):
            self._on_look()

    def showEvent(self, event):
        """Resume redrawing."""
        super().showEvent(event)
        self.timer.start(SOON)

    def hideEvent(self, event):
        """Stop redrawing."""
        super().hideEvent(event)
        if hasattr(self, "timer"):  # else Python has collected it, shown, before Qt takes it down
            self.timer.stop()

    def _on_look(self):
        if hasattr(self, "canvas"):  # not while this is made
            self._take_look()

    def _on_tab(self, *_):
        self._ylim = None
        self.field.setEnabled(self._index() != ERROR)
        self._renew()

    def _on_field(self, *_):
        try:
            self._ranges = quantities.parse_robots(self.field.text())
            numbers = self.source.history.numbers
            absent = {number for ends in self._ranges for number in ends} - set(numbers)
            problem = "No robot {} in the team".format(min(absent)) if absent and numbers else ""
        except ValueError as error:
            problem = str(error)
        self.field.setToolTip(problem or ALL)
        self.field.setStyleSheet(WRONG if problem else "")
        self._renew()

    def _on_follow(self, follow):
        """Go on with the width of the window, or stay with the axes as they are."""
        if not follow and self._drawn is not None:
            self._xlim, self._ylim = self.plot.axes.get_xlim(), self.plot.axes.get_ylim()
        elif follow:
            whole = self._xlim is None or self._xlim[0] <= 0.0
            self._xlim, self._ylim = None if whole else self._xlim, None
        self._renew()

    # Drawing

    @guarded
    def tick(self):
        seen, begun = self.isVisible() and not self.window().isMinimized(), clock.thread_time()
        if seen and self._prepared is not None:
            self.canvas.draw_prepared()
            self._note_cost(self._prepared + clock.thread_time() - begun)
            self._prepared = None
        elif seen and (self._dirty or self._stamp() != self._drawn):
            builds = self.plot.builds
            self._prepare()
            taken = clock.thread_time() - begun
            if self.plot.builds != builds or taken > LONG:  # to draw it, too, is another pause
                self._prepared = taken
                self.timer.start(SOON)
                return
            self.canvas.draw_prepared()
            self._note_cost(clock.thread_time() - begun)
        wait = pacing.pause(self._cost, pacing.CURVES, len(self.source.history.numbers))
        self.timer.setInterval(max(PERIOD, int(1e3 * wait)))

    def _note_cost(self, taken):
        """Note the processor time [s] that a redraw has ``taken``."""
        self._cost += SMOOTH * (taken - self._cost)

    def _renew(self):
        """Redraw at once, without the usual pause."""
        self._dirty = True
        if self.timer.isActive() and self.timer.interval() != SOON:
            self.timer.start(SOON)

    def _stamp(self):
        time = self.source.history.time
        others = len(self._others)
        return self.source.history.numbers, tuple(time[:1]), len(time), tuple(time[-1:]), others

    def _prepare(self):
        """Update the figure."""
        stamp = self._stamp()
        if self._drawn is None or stamp[:2] != self._drawn[:2] or stamp[3] < self._drawn[3]:
            self.follow.setChecked(True)  # another run
            self._xlim, self._ylim = None, None
            self._on_field()
        self._drawn, self._goes_on = stamp, False
        self._show_data()
        self._dirty = self._goes_on
        self._on_drawn()

    def _show_data(self):
        """Show in the plot what is to be drawn now."""
        index, (found, message) = self._index(), self._data()
        limits = self._time_limits(), self._ylim
        self.plot.remark = self._remark if found and self.source is self._live else ""
        self.plot.update(found, self.source.history.numbers, index, message, *limits)

    def _on_drawn(self):
        """Hook called after each redraw."""

    def _data(self):
        """Return the curves to draw, and a remark."""
        source = self.source
        if self._index() == ERROR:
            return self._error_data()
        values, styles = QUANTITIES[self._index()].values, self.plot.styles
        found = source.state_curves(values, self._chosen, styles)
        if not found:
            there = len(source.history.time)
            return [], "No robot is selected" if there else NO_RUN
        others = [source.state_curves(values, self._chosen, styles) for source in self._others]
        return self._picked_out(self._told_apart([found, *others])), ""

    def _picked_out(self, curves):
        """Return ``curves``, those of the robot picked out above the others, which are paler."""
        if all(curve.robot != self._picked for curve in curves):
            return curves
        return [
            curve._replace(style=dict(curve.style, zorder=3, lw=BOLD * curve.style["lw"]))
            if curve.robot == self._picked
            else curve._replace(style=dict(curve.style, alpha=PALE))
            for curve in curves
        ]

    def _told_apart(self, runs):
        """Return the curves of all ``runs``, each run's in its own line; of too many the first's alone."""
        if not self._others or sum(map(len, runs)) > MANY_CURVES:
            return runs[0]
        team, found = max(self.source.history.numbers), []
        for place, run in enumerate(runs):
            for curve in run:
                marks = marks_of(curve.robot - 1, team, place)
                style = dict(curve.style, ls=run_line(place), **marks)
                found.append(curve._replace(style=style, run=curve.run or self._own_name))
        return found

    def _error_data(self):
        source, found = self.source, []
        complete = [each.is_complete() for each in (source, *self._others)]  # each goes on
        self._goes_on = not all(complete)
        run, _ = self.plot.error_styles()
        own = source.error_curve(run)
        if own is not None:
            found.append(own._replace(name=self._own_name, run=""))
        theories = self._theories()
        found += [_seen(curve, own) for curve in theories.get(self._own_name, [])]
        if self._ahead is not None:
            when, error = self._ahead
            found.append(Curve(AHEAD, when, error, self.plot.ahead_style()))
        for place, other in enumerate(self._others, 1):
            curve = other.error_curve(self.plot.compared_style(place))
            found += [] if curve is None else [curve._replace(name=other.short_name)]
            found += [_seen(each, curve) for each in theories.get(other.short_name, [])]
        return found, source.error.problem or ("" if found else NO_RUN)

    def _theories(self):
        """Return ``[Curve]`` of theory of each run, by its name; one where all have the same."""
        _, usual = self.plot.error_styles()
        runs = [(self._own_name, self.source)]
        runs += [(other.short_name, other) for other in self._others]
        known = [
            (place, name, each.theory)
            for place, (name, each) in enumerate(runs)
            if each.theory is not None
        ]
        same = len(known) == len(runs) and all(
            np.array_equal(*pair) for _, _, theory in known for pair in zip(theory, known[0][2])
        )
        if same or (known and not self._others):
            when, error = known[0][2]
            return {self._own_name: [Curve(THEORY, when, error, usual)]}
        names, style = "{}, {{}}".format(THEORY), self.plot.theory_style
        return {
            name: [Curve(names.format(name), when, error, style(place))]
            for place, name, (when, error) in known
        }

    def _chosen(self, number):
        return not self._ranges or any(low <= number <= high for low, high in self._ranges)

    def _time_limits(self):
        """Return the ends of the time axis [s], which begins with the run."""
        begin, end = 0.0, self.source.lasts
        if not end and self.source.theory is not None and self._index() == ERROR:
            end = self.source.theory[0][-1]
        for other in self._others if self._xlim is None else ():
            end = max(end, other.lasts)
        if self._ahead is not None and self._xlim is None and self._index() == ERROR:
            end = max(end, self._ahead[0][-1])
        end = end if end > begin else 1.0
        if self._xlim is not None and self.follow.isChecked():
            width = self._xlim[1] - self._xlim[0]
            self._xlim = (end - width, end) if width < end - begin else None
        limits = self._xlim or (begin, _ahead_of(end))
        if not self.follow.isChecked():
            self._xlim = limits
        return limits
