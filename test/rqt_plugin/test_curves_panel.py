"""The curves panel shows the run's own numbers, costs nothing while hidden, and answers the mouse."""

import os
import threading
from time import monotonic, sleep
from types import SimpleNamespace

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from gui_fixtures import wait_drawn
from matplotlib.colors import to_hex
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QColor, QMouseEvent, QPalette, QWheelEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from snapshots import snapshot_of

from mrs_simulator.core.spatial import upright
from mrs_simulator.rqt_plugin.curves import quantities
from mrs_simulator.rqt_plugin.curves.panel import CurvesPanel
from mrs_simulator.rqt_plugin.curves.quantities import ERROR, QUANTITIES, Curve, ErrorCurve
from mrs_simulator.rqt_plugin.curves.source import Source
from mrs_simulator.rqt_plugin.run import history as run_history
from mrs_simulator.rqt_plugin.run.history import History
from mrs_simulator.rqt_plugin.widgets import pacing
from mrs_simulator.rqt_plugin.widgets.colours import STEPS

APP = QApplication.instance() or QApplication([])


def snapshot(time, n=3):
    """Return the team at ``time``: robot i at x = i (1 + time), turning on the spot."""
    pose, twist = np.zeros((n, 3)), np.zeros((n, 3))
    pose[:, 0] = np.arange(1, n + 1) * (1.0 + time)
    pose[:, 2] = np.mod(2.0 * time + np.pi, 2.0 * np.pi) - np.pi
    twist[:, 2] = 2.0
    return snapshot_of(time, tuple(range(1, n + 1)), pose, twist, twist[:, :2], np.ones(n, bool))


def make_history(m, n=3, begin=0.0):
    history = History()
    for step in range(m):
        history.append(snapshot(begin + 0.1 * step, n))
    return history


class Watched(CurvesPanel):
    """A panel that counts its draws."""

    def __init__(self):
        super().__init__()
        self.draws, self._draw = 0, self.canvas.draw_prepared
        self.canvas.draw_prepared = self._counted

    def _counted(self):
        self.draws += 1
        self._draw()


@pytest.fixture
def panel():
    """Return a visible panel of 700 x 400 pixels."""
    made = Watched()
    made.resize(700, 400)
    made.show()
    assert QTest.qWaitForWindowExposed(made)
    yield made
    made.close()
    made.deleteLater()
    QTest.qWait(1)


def settle(panel):
    """Let ``panel`` draw all that is left to draw, as its timer would a little later."""
    QApplication.processEvents()
    while panel._dirty or panel._prepared is not None or panel._stamp() != panel._drawn:
        panel.tick()
        QTest.qWait(1)


def lines(panel):
    return panel.plot.axes.lines


def pixel(panel, time, value):
    """Return where on the canvas a point of the plot lies."""
    x, y = panel.plot.axes.transData.transform((time, value))
    return QPoint(int(round(x)), int(round(panel.canvas.height() - y)))


def wheel(panel, place, steps=1):
    event = QWheelEvent(
        QPointF(place),
        QPointF(panel.canvas.mapToGlobal(place)),
        QPoint(),
        QPoint(0, 120 * steps),
        Qt.NoButton,
        Qt.NoModifier,
        Qt.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(panel.canvas, event)


def move(panel, place, buttons=Qt.NoButton):
    """Move the mouse; QTest's own way depends on the platform's cursor."""
    spot = QPointF(place)
    event = QMouseEvent(QEvent.MouseMove, spot, Qt.NoButton, buttons, Qt.NoModifier)
    QApplication.sendEvent(panel.canvas, event)


def drag(panel, begin, end):
    QTest.mousePress(panel.canvas, Qt.LeftButton, pos=begin)
    move(panel, end, Qt.LeftButton)
    QTest.mouseRelease(panel.canvas, Qt.LeftButton, pos=end)


def test_curves_follow_the_history(panel):
    history = make_history(20)
    panel.set_history(history)
    settle(panel)
    for row, line in enumerate(lines(panel)):
        np.testing.assert_allclose(line.get_xdata(), history.time)
        np.testing.assert_allclose(line.get_ydata(), history.pose[:, row, 0])
    history.append(snapshot(5.0))
    settle(panel)
    assert lines(panel)[2].get_xdata()[-1] == 5.0
    assert panel.plot.axes.get_xlim() == (0.0, 5.0)
    assert panel.plot.axes.get_ylim()[1] > 18.0


def test_each_tab_shows_its_quantity_with_its_unit(panel):
    history = make_history(60)
    panel.set_history(history)
    wanted = [history.pose[:, 0, 0], history.pose[:, 0, 1], 2.0 * history.time]
    wanted += [history.state.twist[:, 0, 0], history.state.twist[:, 0, 2]]
    for index, values in enumerate(wanted):
        panel.tabs.setCurrentIndex(index)
        settle(panel)
        np.testing.assert_allclose(lines(panel)[0].get_ydata(), values, atol=1e-9)
        label = panel.plot.axes.get_ylabel()
        assert label.endswith("[{}]".format(QUANTITIES[index].unit))


def test_nothing_is_drawn_without_news_nor_while_hidden(panel, monkeypatch):
    monkeypatch.setattr(pacing, "CURVES", np.inf)  # however dear a picture is
    calls = []
    history = make_history(20)
    panel.set_history(history)
    panel.set_error(lambda pose: calls.append(len(pose)) or np.ones(len(pose)))
    panel.tabs.setCurrentIndex(ERROR)
    wait_drawn(panel)
    drawn, called = panel.draws, list(calls)
    assert drawn and called == [20]
    QTest.qWait(350)  # longer than the time between redraws
    assert panel.draws == drawn
    panel.hide()
    history.append(snapshot(9.0))
    panel.set_prediction([0.0, 1.0], [1.0, 0.5])
    panel.canvas.draw_idle()
    QTest.qWait(350)  # longer than the time between redraws
    assert (panel.draws, calls) == (drawn, called)
    panel.show()
    wait_drawn(panel)
    assert panel.draws > drawn and calls == [20, 1]


def test_a_running_history_is_drawn_four_times_a_second_at_most(panel, monkeypatch):
    monkeypatch.setattr(pacing, "CURVES", np.inf)  # however dear a picture is
    history = make_history(2)
    panel.set_history(history)
    wait_drawn(panel)
    drawn, begin, step = panel.draws, monotonic(), 0
    while panel.draws - drawn < 4 and monotonic() < begin + 60.0:
        step += 1
        history.append(snapshot(1.0 + step))
        QTest.qWait(20)
    assert 4 <= panel.draws - drawn <= (monotonic() - begin) / 0.25 + 1.0


def test_robots_are_chosen_by_the_field(panel):
    panel.set_history(make_history(5, n=9))
    settle(panel)
    QTest.keyClicks(panel.field, "1-3, 7")
    settle(panel)
    legend = [text.get_text() for text in panel.plot.axes.get_legend().get_texts()]
    assert legend == ["1", "2", "3", "7"] and len(lines(panel)) == 4
    panel.field.setText("9, 4-5")
    settle(panel)
    assert lines(panel)[0].get_ydata()[0] == 4.0
    panel.field.clear()
    settle(panel)
    assert len(lines(panel)) == 9


@pytest.mark.parametrize("text, reason", [("1-", "range"), ("x", "x"), ("3-1", "smaller")])
def test_a_wrong_choice_is_framed_explained_and_without_effect(panel, text, reason):
    panel.set_history(make_history(5))
    panel.field.setText("2")
    panel.field.setText(text)
    settle(panel)
    assert reason in panel.field.toolTip() and "border" in panel.field.styleSheet()
    assert len(lines(panel)) == 1
    panel.field.clear()
    assert not panel.field.styleSheet()


def test_a_robot_that_is_not_in_the_team_is_named(panel):
    panel.set_history(make_history(5))
    settle(panel)
    panel.field.setText("2, 8")
    settle(panel)
    assert "8" in panel.field.toolTip() and len(lines(panel)) == 1


@pytest.mark.parametrize("ranges, text", [((), " "), (((1, 3), (7, 7)), "1 - 3;7")])
def test_parsing_robots(ranges, text):
    assert quantities.parse_robots(text) == ranges


def test_hover_names_the_robot_with_time_and_value(panel):
    panel.set_history(make_history(41))
    settle(panel)
    move(panel, pixel(panel, 2.0, 6.0))
    assert panel.label.isVisible()
    name, time, value = panel.label.text().replace(":", ",").split(",")
    assert name == "Robot 2"
    assert float(time.split()[0]) == pytest.approx(2.0, abs=0.05)
    assert float(value.split()[0]) == pytest.approx(6.0, abs=0.1)
    assert panel.canvas.rect().contains(panel.label.geometry())
    move(panel, pixel(panel, 0.5, 14.0))
    assert not panel.label.isVisible()


def test_error_and_theory_are_shown_on_a_log_scale(panel):
    history = make_history(30)
    panel.set_history(history)
    panel.set_error(lambda pose: np.exp(-pose[:, 0, 0]))
    panel.set_prediction(history.time, 2.0 * np.exp(-history.time))
    settle(panel)
    panel.tabs.setCurrentIndex(ERROR)
    assert panel.as_csv().startswith("time [s],This run error [m],Theory")  # before it is drawn
    settle(panel)
    run, theory = lines(panel)
    assert panel.plot.axes.get_yscale() == "log"
    np.testing.assert_allclose(run.get_ydata(), np.exp(-1.0 - history.time))
    np.testing.assert_allclose(theory.get_ydata(), 2.0 * np.exp(-history.time))
    assert theory.get_linestyle() == "--" and run.get_linestyle() == "-"
    panel.set_prediction(None, None)
    settle(panel)
    assert len(lines(panel)) == 1


def test_theory_that_goes_to_infinity_leaves_the_run_in_sight(panel):
    history = make_history(30)
    panel.set_history(history)
    panel.set_error(lambda pose: 2.0 + 0.0 * pose[:, 0, 0])
    panel.set_prediction(
        history.time, np.append(np.logspace(0, 300, len(history.time) - 1), np.inf)
    )
    panel.tabs.setCurrentIndex(ERROR)
    settle(panel)
    run, theory = lines(panel)
    low, high = panel.plot.axes.get_ylim()
    assert low < run.get_ydata().min() and run.get_ydata().max() < high < 100.0
    assert np.isfinite(theory.get_ydata()).sum() == 1


def test_theory_begins_with_the_run_which_begins_with_the_first_command(panel):
    history = make_history(5, begin=1.7e9)  # robots that stand
    panel.set_history(history)
    panel.set_prediction([0.0, 1.0, 2.0], [1.0, 0.5, 0.25])
    panel.tabs.setCurrentIndex(ERROR)
    settle(panel)
    (theory,) = lines(panel)
    np.testing.assert_allclose(theory.get_xdata(), [0.0, 1.0])  # what is seen
    begin = history.time[-1] + 0.1
    for time in (begin, begin + 0.1):
        history.append(snapshot(time).replace(command=np.full((3, 2), 0.1)))
    settle(panel)
    (theory,) = lines(panel)
    np.testing.assert_allclose(theory.get_xdata(), [0.0, 1.0])
    assert history.time[history.first_row()] == begin
    assert panel.plot.axes.get_xlim() == pytest.approx((0.0, 0.1), abs=1e-6)  # of the run alone


def test_the_time_axis_begins_with_the_run_and_moments_stay_those_of_the_history(panel):
    history = make_history(5, begin=30.0)  # robots that stand until their controller is there
    for time in (31.0, 32.0, 33.0):
        history.append(snapshot(time).replace(command=np.full((3, 2), 0.1)))
    panel.set_history(history)
    settle(panel)
    assert panel.plot.axes.get_xlim() == (0.0, 2.0)
    panel.show_moment(32.0)
    assert panel.moment == 1.0
    chosen = []
    panel.time_chosen.connect(chosen.append)
    box, ratio = panel.plot.axes.bbox, panel.canvas.devicePixelRatioF()
    middle = QPoint(int((box.x0 + box.x1) / 2 / ratio), panel.canvas.height() // 2)
    QTest.mouseClick(panel.canvas, Qt.LeftButton, pos=middle)
    assert chosen == [pytest.approx(32.0, abs=0.02)]


@pytest.mark.parametrize(
    "function, expected",
    [(None, "no formation error"), (lambda pose: None, "no formation"), (lambda p: p[9999], "log")],
)
def test_without_an_error_the_plot_says_why(panel, function, expected):
    panel.set_history(make_history(5))
    panel.set_error(function)
    panel.tabs.setCurrentIndex(ERROR)
    settle(panel)
    assert not lines(panel) and expected in panel.plot.axes.texts[0].get_text()


def test_each_sample_is_given_to_the_error_once_until_the_history_begins_anew(monkeypatch):
    monkeypatch.setattr(run_history, "MOST_VALUES", 0)
    monkeypatch.setattr(run_history, "FEWEST_SAMPLES", 32)
    seen = []
    curve = ErrorCurve(lambda pose: seen.append(len(pose)) or pose[:, 0, 0])

    def update(history):
        seen.clear()
        assert curve.update(history.numbers, history.time, history.pose)
        np.testing.assert_array_equal(curve.values, history.pose[:, 0, 0])
        return sum(seen)

    history = make_history(20)
    assert update(history) == 20
    history.append(snapshot(7.0))
    assert update(history) == 1
    for step in range(30):  # it was full meanwhile, and is longer than before nevertheless
        history.append(snapshot(8.0 + step))
    assert len(history.time) > 21
    assert update(history) == len(history.time)
    assert update(make_history(30, begin=3.0)) == 30
    history.clear()
    assert curve.update(history.numbers, history.time, history.pose)
    assert not len(curve.values)


def test_a_slow_error_is_computed_in_several_redraws():
    history, calls = make_history(1200), []

    def slow(pose):
        calls.append(len(pose))
        sleep(1e-4 * len(pose))
        return np.ones(len(pose))

    curve = ErrorCurve(slow)
    assert not curve.update(history.numbers, history.time, history.pose)
    assert len(curve.values) < 1200
    while not curve.update(history.numbers, history.time, history.pose):
        pass
    assert sum(calls) == len(curve.values) == 1200


def test_a_users_error_is_computed_beside_the_redraws_however_long_it_takes():
    history, go_on = make_history(700), threading.Event()

    def hangs(pose):
        go_on.wait()
        return pose[:, 0, 0]

    curve = ErrorCurve(hangs, background=True)
    assert not curve.update(history.numbers, history.time, history.pose)
    assert not len(curve.values)
    go_on.set()
    while not curve.update(history.numbers, history.time, history.pose):
        pass
    np.testing.assert_array_equal(curve.values, history.pose[:, 0, 0])


def test_no_redraw_waits_long_for_an_error_whatever_a_sample_takes(monkeypatch):
    history, now = make_history(200), [0.0]

    def slow(pose):
        now[0] += 0.0047 * len(pose)
        return np.ones(len(pose))

    monkeypatch.setattr(quantities, "clock", SimpleNamespace(monotonic=lambda: now[0]))
    curve, taken, done = ErrorCurve(slow), [], False
    while not done:
        begun = now[0]
        done = curve.update(history.numbers, history.time, history.pose)
        taken.append(now[0] - begun)
    assert (
        len(curve.values) == 200 and max(taken) < 0.1 and max(taken[1:]) < 2.0 * quantities.PATIENCE
    )


def test_a_cleared_history_shows_no_curves(panel):
    history = make_history(20)
    panel.set_history(history)
    settle(panel)
    history.clear()
    settle(panel)
    assert not lines(panel) and "No run yet" in panel.plot.axes.texts[0].get_text()
    history.append(snapshot(0.0, n=2))
    settle(panel)
    assert len(lines(panel)) == 2


def test_wheel_zooms_about_the_mouse_drag_pans_and_double_click_shows_all(panel):
    panel.set_history(make_history(101))
    settle(panel)
    QTest.mouseClick(panel.follow, Qt.LeftButton, pos=QPoint(8, panel.follow.height() // 2))
    place = pixel(panel, 4.0, 10.0)
    wheel(panel, place, 2)
    settle(panel)
    begin, end = panel.plot.axes.get_xlim()
    assert end - begin == pytest.approx(6.4) and begin < 4.0 < end
    assert (pixel(panel, 4.0, 10.0) - place).manhattanLength() <= 3
    drag(panel, place, place + QPoint(60, 0))
    settle(panel)
    assert panel.plot.axes.get_xlim()[0] < begin - 0.3
    QTest.mouseDClick(panel.canvas, Qt.LeftButton, pos=place)
    settle(panel)
    assert panel.plot.axes.get_xlim() == pytest.approx((0.0, 10.0))


def test_following_keeps_the_width_and_a_drag_ends_it(panel):
    history = make_history(101)
    panel.set_history(history)
    settle(panel)
    wheel(panel, pixel(panel, 5.0, 10.0), 2)
    settle(panel)
    assert panel.plot.axes.get_xlim() == pytest.approx((3.6, 10.0))
    history.append(snapshot(12.0))
    settle(panel)
    assert panel.plot.axes.get_xlim() == pytest.approx((5.6, 12.0))
    place = pixel(panel, 8.0, 20.0)
    drag(panel, place, place + QPoint(40, 5))
    assert not panel.follow.isChecked()


def test_a_zoomed_plot_is_of_full_detail_and_thinning_keeps_peaks():
    time = np.arange(40000.0)
    values = np.zeros(40000)
    values[12345] = 7.0
    curve = Curve("Robot 1", time, values, {})
    whole = quantities.thinned(curve, 0.0, 40000.0, 800)
    assert len(whole[0]) <= 800 and np.max(whole[1]) == 7.0 and whole[0][-1] == 39999.0
    assert list(quantities.thinned(curve, 100.0, 102.0, 800)[0]) == [
        99.0,
        100.0,
        101.0,
        102.0,
        103.0,
    ]


def test_curves_thinned_together_keep_the_peaks_of_each():
    time, table = np.arange(10000.0), np.zeros((10000, 3))
    table[1234, 0], table[777, 1], table[9999, 2], table[50, 2] = 7.0, -5.0, 3.0, np.nan
    when, values = quantities.thinned_together(time, table, 0.0, 1e4, 100)
    assert len(when) == len(values) <= 101 and when[-1] == 9999.0 and (np.diff(when) >= 0.0).all()
    assert (np.nanmax(values, axis=0) == [7.0, 0.0, 3.0]).all()
    assert values.min(axis=0)[1] == -5.0 and values[-1, 2] == 3.0
    whole, _ = quantities.thinned_together(time, table, 100.0, 102.0, 100)
    assert whole.tolist() == [99.0, 100.0, 101.0, 102.0, 103.0]


def test_the_curves_of_a_large_team_are_drawn_as_one_and_still_named(panel):
    panel.set_history(make_history(30, 300))
    settle(panel)
    bundle = panel.plot._bundle
    assert len(lines(panel)) == 0 and bundle in panel.plot.axes.collections
    segments = bundle.get_segments()
    assert len(segments) == 300 and len({tuple(colour) for colour in bundle.get_colors()}) == STEPS
    np.testing.assert_allclose(segments[299], [[t, 300.0 * (1.0 + t)] for t in segments[299][:, 0]])
    move(panel, pixel(panel, 1.5, 300.0 * 2.5))
    assert panel.label.text().startswith("Robot 300:")


RELEASE = pytest.mark.release  # of what has room enough


@pytest.mark.parametrize(
    "n, size",
    [
        (1, (500, 300)),
        (12, (500, 300)),
        (50, (500, 300)),
        (12, (1200, 500)),
        pytest.param(1, (1200, 500), marks=RELEASE),
        pytest.param(50, (1200, 500), marks=RELEASE),
    ],
)
def test_nothing_is_cut_off(panel, size, n):
    panel.resize(*size)
    panel.set_history(make_history(5, n=n))
    panel.set_error(lambda pose: pose[:, 0, 0])
    panel.set_prediction([0.0, 1.0], [1e-6, 1.0])
    settle(panel)
    figure = panel.plot.figure
    for index in range(len(QUANTITIES)):
        panel.tabs.setCurrentIndex(index)
        panel.canvas.prepare()  # all but the paint
        box = figure.get_tightbbox(panel.canvas.get_renderer())
        assert box.x0 >= 0.0 and box.y0 >= 0.0
        assert box.x1 * figure.dpi <= figure.bbox.width + 1
        assert box.y1 * figure.dpi <= figure.bbox.height + 1


def test_colours_are_those_of_the_theme(panel):
    panel.set_history(make_history(5))
    palette = QPalette()
    palette.setColor(QPalette.Window, QColor("#202020"))
    palette.setColor(QPalette.Base, QColor("#101010"))
    palette.setColor(QPalette.WindowText, QColor("#f0f0f0"))
    panel.setPalette(palette)
    settle(panel)
    axes = panel.plot.axes
    assert panel.plot.figure.get_facecolor()[0] == pytest.approx(0x20 / 255.0, abs=0.01)
    assert axes.get_facecolor()[0] == pytest.approx(0x10 / 255.0, abs=0.01)
    assert axes.xaxis.label.get_color()[0] == pytest.approx(0xF0 / 255.0, abs=0.01)


def test_the_lateral_speed_is_shown_of_robots_that_have_one(panel):
    def tabs():
        return [panel.tabs.tabText(tab) for tab in range(panel.tabs.count())]

    history = make_history(20)
    history.state.twist[:, :, 1] = 0.25
    panel.set_history(history)
    assert "v\u1d67" not in tabs()
    panel.tabs.setCurrentIndex(tabs().index("\u03c9"))
    panel.set_axes(("linear.x", "linear.y", "angular.z"))
    assert panel.tabs.tabText(panel.tabs.currentIndex()) == "\u03c9"  # what was looked at
    panel.tabs.setCurrentIndex(tabs().index("v\u1d67"))
    settle(panel)
    assert set(lines(panel)[0].get_ydata()) == {0.25}
    assert "lateral" in panel.plot.axes.get_ylabel()
    panel.set_axes(("linear.x", "angular.z"))
    assert tabs()[panel.tabs.currentIndex()] == "x" and "v\u1d67" not in tabs()


def test_curves_show_heights_of_teams_that_fly(panel):
    def tabs():
        return [panel.tabs.tabText(tab) for tab in range(panel.tabs.count())]

    panel.set_axes(("linear.x", "linear.z", "angular.z"))
    assert "z" not in tabs() and "climb" not in tabs()
    panel.set_axes(("linear.x", "linear.z", "angular.z"), in_space=True)
    assert tabs() == ["x", "y", "z", "\u03b8", "v", "climb", "\u03c9", "error"]
    history = History()
    for step in range(5):
        expected = snapshot(0.1 * step)
        spatial = upright(expected.pose[:, 2], [1.0, 2.0, 3.0])
        spatial.twist[:, 0] = 0.1 * step
        history.append(expected.replace(spatial=spatial))
    panel.set_history(history)
    for tab, values in ((2, [[1.0, 2.0, 3.0]] * 5), (5, [[0.1 * k] * 3 for k in range(5)])):
        panel.tabs.setCurrentIndex(tab)
        panel.canvas.draw()
        drawn = np.transpose([line.get_ydata() for line in panel.plot.axes.lines])
        np.testing.assert_allclose(drawn, values)


def compared(panel, factors):
    """Compare a run whose theory is 1 with runs whose theories are ``factors``, in the error."""
    panel.set_history(make_history(40))
    panel.tabs.setCurrentIndex(ERROR)
    source_of = panel._live, *(Source(make_history(40), "run {}".format(k)) for k in factors)
    for source, factor in zip(source_of, (1.0, *factors)):
        source.error = ErrorCurve(lambda pose: np.full(len(pose), 2.0))
        source.set_prediction(np.arange(4.0), np.full(4, factor))
    panel.compare(source_of[1:], "own")
    settle(panel)
    return [curve.name for curve in panel.plot._curves], panel.plot.axes.get_legend()


def test_each_compared_runs_theory_has_its_name_and_its_line(panel):
    names, legend = compared(panel, [2.0, 3.0])
    wanted = ["own", "Theory, own", "run 2.0", "Theory, run 2.0", "run 3.0", "Theory, run 3.0"]
    assert names == wanted == [text.get_text() for text in legend.get_texts()]
    drawn = lines(panel)
    for run, theory in zip(drawn[::2], drawn[1::2]):
        assert run.get_color() == theory.get_color()
        assert run.get_linestyle() == theory.get_linestyle()
        assert theory.get_linewidth() > 2.0 * run.get_linewidth() and theory.get_alpha() < 0.5


def test_robots_of_one_colour_differ_by_marks_where_runs_are_compared(panel):
    panel.set_history(make_history(40, 10))
    panel.compare([Source(make_history(40, 10), "other")], "own")
    settle(panel)
    looks = [
        (to_hex(line.get_color()), line.get_linestyle(), line.get_marker()) for line in lines(panel)
    ]
    assert len(looks) == 20 == len(set(looks))
    assert [marker for _, _, marker in looks[:10]] == ["None"] * 7 + ["o"] * 3


def test_one_theory_of_all_compared_runs_is_drawn_once(panel):
    names, _ = compared(panel, [1.0, 1.0])
    assert names == ["own", "Theory", "run 1.0", "run 1.0"]


@pytest.mark.parametrize("size", [(700, 400), (460, 260)])
def test_a_legend_of_many_runs_stays_in_the_figure_and_leaves_room(panel, size):
    panel.resize(*size)
    _, legend = compared(panel, [2.0, 3.0, 4.0])
    figure = panel.plot.figure
    box = legend.get_window_extent(figure.canvas.get_renderer())
    assert box.x0 >= 0.0 and box.x1 <= figure.bbox.width and box.y1 <= figure.bbox.height
    assert panel.plot.axes.bbox.height >= 0.35 * figure.bbox.height
    assert {"own", "run 4.0"} <= {text.get_text() for text in legend.get_texts()}


def test_the_menu_of_the_curves_selects_isolates_and_exports(panel):
    panel.set_history(make_history(40))
    settle(panel)
    clicked, exported = [], []
    panel.robot_clicked.connect(clicked.append)
    panel.export_asked.connect(exported.append)

    def entries(place):
        panel.canvas.customContextMenuRequested.emit(place)
        found = {entry.text(): entry for entry in panel.menu.actions()}
        panel.menu.hide()
        return found

    on_curve = pixel(panel, 2.0, 2.0 * 3.0)
    found = entries(on_curve)
    assert "All robots" not in found
    found["Select robot 2"].trigger()
    found["Robot 2 alone"].trigger()
    settle(panel)
    assert clicked == [2] and len(lines(panel)) == 1
    found = entries(QPoint(3, 3))
    assert "Select robot 2" not in found
    found["All robots"].trigger()
    settle(panel)
    assert len(lines(panel)) == 3
    for text in ("Copy the curves", "Picture of the curves...", "Compose a figure..."):
        found[text].trigger()
    assert exported == ["table", "curves", "figure"]


def test_curves_that_are_collected_while_shown_go_without_an_error(no_hidden_errors):
    panel = CurvesPanel()
    panel.show()
    assert QTest.qWaitForWindowExposed(panel)
    timer = panel.timer
    panel.__dict__.clear()  # as the collector of cycles does, before Qt takes the widget down
    panel.hide()
    timer.stop()
    panel.deleteLater()
