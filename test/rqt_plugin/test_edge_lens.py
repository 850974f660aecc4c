"""What is said of the edge under the mouse, driven by the mouse."""

import os
import re
import time

import numpy as np
import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import quiet_study, shown, wait_shown
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication

from mrs_simulator.core.graphs import Topology
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.run.experiment import run_experiment

pytestmark = pytest.mark.usefixtures("no_hidden_errors", "forked_programs")


@pytest.fixture
def study():
    application = QApplication.instance() or QApplication([])
    scenario = load_scenario(scenario_path("consensus"))
    ring = Topology(
        scenario.n, [(i + 1, (i + 1) % scenario.n + 1) for i in range(scenario.n)], False
    )
    widget = quiet_study(scenario._replace(topology=ring))
    shown(widget, 1180, 720)
    widget.map_panel.map.set_mode("edges")
    yield widget
    widget.close_study()
    widget.close()
    application.processEvents()


def middle_of(widget, edge):
    team = widget.map.team
    at = widget.map.frame, 1.0, team.shapes
    begin, end = widget.map.edges.segment_of(edge, team.numbers, team.pose, *at)
    return QPoint(*map(int, 0.5 * (begin + end)))


def settled(widget, limit=60.0):
    """Return the text at the edge once theory has answered."""
    end = time.monotonic() + limit
    while "..." in widget.map.hover_text and time.monotonic() < end:
        widget.live.show_prediction()
        widget.edge_lens.follow()
        QTest.qWait(20)
    return widget.map.hover_text.split("\n")


def hovered(widget):
    """Return the lines at the first edge under the mouse, once theory has answered."""
    QTest.mouseMove(widget.map, QPoint(3, 3))
    QTest.mouseMove(widget.map, middle_of(widget, widget.map.edges.list[0]))
    wait_shown(lambda: widget.map.hover_text)
    return settled(widget)


def test_an_edge_under_the_mouse_says_what_goes_with_it_and_a_click_removes_it(study):
    edge = study.map.edges.list[0]
    QTest.mouseMove(study.map, middle_of(study, edge))
    assert study.map.hovered == edge
    lines = settled(study)
    assert lines[0].startswith("Robot 1 and robot 2") and lines[1] == "without it: a spanning tree"
    n = study.scenario.n
    before = study.topology.figure("lambda"), study.topology.figure("time")
    without, now = lines[2].split(", now ")
    assert now == before[0] and float(without.split()[2]) < float(now)
    assert lines[3].startswith("converges in ") and lines[4] == "now in " + before[1]
    QTest.mouseClick(study.map, Qt.LeftButton, Qt.NoModifier, middle_of(study, edge))
    assert len(study.topology.edges()) == n - 1 and study.map.hovered is None
    # As was said before the click.
    assert study.topology.figure("lambda") == without.split()[2]


def test_nothing_is_said_elsewhere_or_in_another_mode(study):
    edge = study.map.edges.list[0]
    at = middle_of(study, edge)
    QTest.mouseMove(study.map, at)
    QTest.mouseMove(study.map, QPoint(3, 3))
    assert study.map.hovered is None and not study.map.hover_text
    study.map.set_mode("look")
    QTest.mouseMove(study.map, at)
    assert study.map.hovered is None


def test_an_edge_of_a_run_from_the_list_is_judged_by_the_gain_of_that_run(study, tmp_path):
    ran = study.scenario
    ran = ran._replace(duration=2.0, control=ran.control._replace(parameters={"gain": 0.125}))
    run_experiment(ran, str(tmp_path / "ran"), formats=())
    edited = hovered(study)
    study.map.set_mode("look")
    study.opened.open(str(tmp_path / "ran"))
    given = {"follow": study.opened.follow, "said": study.messages.toPlainText}
    wait_shown(lambda: study.opened.run is not None, **given)
    study.modes["ahead"].setChecked(True)
    study.replay.show_frame()
    study.opened.show_frame()
    run = hovered(study)
    assert run[:3] == edited[:3] and len(run) == 5  # of the same graph
    times = [
        [float(re.search("in ([0-9.]+) s", line)[1]) for line in each[3:]] for each in (run, edited)
    ]
    np.testing.assert_allclose(times[0], 4.0 * np.array(times[1]), rtol=0.02)
