"""A run is painted as often as leaves the processor to the simulation."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from gui_fixtures import quiet_study, shown
from protocol_fixtures import shipped
from PyQt5.QtWidgets import QApplication
from snapshots import snapshot_of

from mrs_simulator.rqt_plugin.curves import drawn as drawn_curves
from mrs_simulator.rqt_plugin.curves.drawn import _ahead_of
from mrs_simulator.rqt_plugin.curves.panel import CurvesPanel
from mrs_simulator.rqt_plugin.run.history import History
from mrs_simulator.rqt_plugin.widgets import pacing
from mrs_simulator.rqt_plugin.window import live_run

APP = QApplication.instance() or QApplication([])
WANTED = {7: 0.15, 100: 0.25, 1000: 0.4}  # shares of a core of all that the GUI does


def snapshot(time, n=4):
    poses = np.column_stack([np.full(n, np.sin(time)), np.arange(n), np.zeros(n)])
    twist = np.zeros((n, 3))
    numbers = tuple(range(1, n + 1))
    return snapshot_of(time, numbers, poses, twist, twist[:, :2], np.ones(n, bool))


@pytest.mark.parametrize("robots", WANTED)
def test_pictures_take_less_than_what_the_gui_may(robots):
    taken = [
        1.0 / pacing.pause(1.0, share, robots) for share in (pacing.MAP, pacing.VIEW, pacing.CURVES)
    ]
    assert sum(taken) < WANTED[robots] - 0.02
    alone = [1.0 / pacing.pause(1.0, share, robots) for share in (pacing.MAP_ALONE, pacing.CURVES)]
    assert sum(alone) < WANTED[robots] - 0.02


def test_the_map_waits_for_what_was_painted_between_but_not_for_long(monkeypatch):
    study, now = quiet_study(shipped("paper_four")), [100.0]
    try:
        monkeypatch.setattr(live_run.time, "monotonic", lambda: now[0])
        study.beside.is_beside = False
        study.map.cost = 0.0

        def is_taken(time):
            study.connection.snapshot.return_value = snapshot(time)
            study.live._show_newest()
            return study.map.time == time

        assert is_taken(1.0)
        study.map.spent = 0.009  # 9 % of 0.1 s
        now[0] += 0.05
        assert not is_taken(2.0)
        now[0] += 0.06
        assert is_taken(3.0) and study.map.spent == 0.0
        study.map.spent = 60.0
        now[0] += live_run.MOST_WAITING + 0.01
        assert is_taken(4.0)
        study.map.cost = 60.0
        now[0] += 10.0
        assert not is_taken(5.0)
    finally:
        study.close_study()


def test_curves_alone_are_drawn_anew_where_nothing_else_changes(monkeypatch):
    panel, history = shown(CurvesPanel(), 700, 300), History()
    for time in np.arange(0.0, 9.0, 0.5):
        history.append(snapshot(time))
    panel.set_history(history)
    panel.canvas.draw()
    whole, draw = [], panel.plot.figure.draw
    monkeypatch.setattr(panel.plot.figure, "draw", lambda *of: (whole.append(1), draw(*of)))
    before = np.array(panel.canvas.copy_from_bbox(panel.plot.axes.bbox))
    history.append(snapshot(9.4))
    panel.canvas.draw()
    after = np.array(panel.canvas.copy_from_bbox(panel.plot.axes.bbox))
    assert not whole and (before != after).any()
    assert panel.plot.axes.get_xlim() == (0.0, 10.0)
    history.append(snapshot(10.5))  # beyond the axis
    panel.canvas.draw()
    assert whole and panel.plot.axes.get_xlim() == (0.0, 12.0)
    # The picture is the one that is drawn at once.
    stepwise = np.array(panel.canvas.copy_from_bbox(panel.plot.figure.bbox))
    panel.canvas._kept = None, None
    panel.canvas.draw()
    at_once = np.array(panel.canvas.copy_from_bbox(panel.plot.figure.bbox))
    assert (stepwise == at_once).all()
    panel.close()


def test_the_axis_of_a_long_run_grows_by_steps():
    assert [_ahead_of(end) for end in (0.3, 5.0, 5.1, 9.9, 10.0, 33.0, 64.0, 65.0)] == [
        *(0.3, 5.0, 6.0, 10.0, 10.0, 36.0, 64.0, 72.0)
    ]


def test_a_robot_is_picked_out_and_another_team_shown_in_short_steps():
    panel, history = shown(CurvesPanel(), 700, 300), History()
    for time in (0.0, 1.0, 2.0):
        history.append(snapshot(time))
    panel.set_history(history)
    panel.timer.stop()
    canvas, drawn = panel.canvas, []
    prepared = canvas.draw_prepared
    canvas.draw_prepared = lambda: (drawn.append(panel.plot.builds), prepared())
    panel.tick()
    assert not drawn and panel._prepared is not None  # the axes are there
    panel.tick()
    (builds,) = drawn
    panel.pick_out(2)
    panel.tick()
    assert drawn == [builds, builds]  # nothing was built for that
    widths = [line.get_linewidth() for line in panel.plot.axes.lines]
    assert widths[1] > widths[0] and panel.plot.axes.lines[0].get_alpha() < 1.0
    assert panel.plot.moving[-1] is panel.plot.axes.lines[1]
    panel.close()


def test_curves_that_take_long_are_prepared_and_drawn_in_two_steps(monkeypatch):
    panel, history = shown(CurvesPanel(), 700, 300), History()
    panel.set_history(history)
    for time in (0.0, 1.0, 2.0):
        history.append(snapshot(time))
    panel.timer.stop()
    panel.tick()
    panel.tick()  # the axes are made
    done, prepare, draw = [], panel._prepare, panel.canvas.draw_prepared
    panel._prepare = lambda: (done.append("prepared"), prepare())
    panel.canvas.draw_prepared = lambda: (done.append("drawn"), draw())
    steps = []
    for limit in (np.inf, -1.0):
        monkeypatch.setattr(drawn_curves, "LONG", limit)
        history.append(snapshot(history.time[-1] + 0.1))
        for _ in range(2):
            panel.tick()
            steps.append(list(done))
            done.clear()
    assert steps == [["prepared", "drawn"], [], ["prepared"], ["drawn"]]
    panel.close()
