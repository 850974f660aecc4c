"""Studies that a control theorist does, in the window without ROS, by mouse and keyboard alone."""

import json
import os
import pathlib
import shlex

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from gui_fixtures import MEETING, SEARCHED, leave_out_curves, wait_drawn
from gui_hands import STEPS, Person
from gui_tables import judged_row
from PyQt5.QtCore import QPoint, QSettings, Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import (
    QApplication,
    QComboBox,
    QLineEdit,
    QListView,
    QTableView,
    QTableWidget,
)

from mrs_simulator.pictures.camera import on_screen
from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.rqt_plugin.local_side.connection import LocalConnection
from mrs_simulator.rqt_plugin.local_side.processes import LocalProcesses
from mrs_simulator.rqt_plugin.run import edited_scenario
from mrs_simulator.rqt_plugin.run.bar import SPEEDS
from mrs_simulator.rqt_plugin.start.picker import CARD
from mrs_simulator.rqt_plugin.study_widget import StudyWidget
from mrs_simulator.rqt_plugin.widgets.on_screen import OnScreen
from mrs_simulator.rqt_plugin.window.main_window import Window
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_yaml
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.results.figure_command import main as figure
from mrs_simulator.study.run.experiment import run_experiment

pytestmark = pytest.mark.usefixtures("no_hidden_errors", "forked_programs")
SIZE = 1280, 800  # [px] of the window
FASTER = Qt.Key_Plus, Qt.ControlModifier


@pytest.fixture
def at_window(tmp_path, monkeypatch, request):
    """Open the window with a scenario, and return the ``Person`` before it; again, as it was left."""
    monkeypatch.setenv("HOME", str(tmp_path))
    # The screen of Qt's platform offscreen is smaller than a person's.
    monkeypatch.setattr(OnScreen, "keep", lambda _: None)
    application, windows = QApplication.instance() or QApplication([]), []

    def opened(scenario, path="", draws_curves=True):
        connection = LocalConnection()
        processes = LocalProcesses(connection)
        study = StudyWidget(connection, processes, scenario)
        if not draws_curves:
            leave_out_curves(study)
        settings = QSettings(str(tmp_path / "settings.ini"), QSettings.IniFormat)
        window = Window(study, settings)
        windows.append(window)
        window.show()
        assert QTest.qWaitForWindowActive(window)
        application.processEvents()
        window.resize(*SIZE)
        person = Person(window, request.node.name[5:25])
        person.study = study
        person.until(lambda: window.width() == SIZE[0])
        if path:  # of a run, as on the command line
            study.shelf_control.open(str(path))
            person.until(lambda: study.opened.run is not None)
        return person

    yield opened
    for window in filter(Window.isVisible, windows):
        window.close()
    for window in windows:
        window.study.study.processes.wait_closed()
    application.processEvents()


def shipped(name, **changes):
    """Return the shipped scenario called ``name`` with some of its keys changed."""
    return load_scenario(scenario_path(name))._replace(**changes)


def as_fast_as_possible(person):
    """Choose the highest speed by keys."""
    person.key(*FASTER, times=len(SPEEDS))


def run(person):
    """Press Run, and wait until the run is over, judged and on the list."""
    entries = person.study.shelf.list.runs
    before = len(entries.entries)
    person.click(person.button("Run the scenario"))
    wait_judged(person, before + 1)


def wait_judged(person, count):
    """Wait until ``count`` runs are on the list, and have their verdicts."""
    study, entries = person.study, person.study.shelf.list.runs
    person.until(lambda: len(entries.entries) == count and study.results.of_run())
    person.until(lambda: all(entry.outcome for entry in entries.entries))


def on_map(person, x, y):
    """Return the place [px] of a point [m] on the map."""
    return QPoint(*(int(round(part)) for part in person.study.map.to_screen(x, y)))


def robot(person, number):
    """Return the place [px] of a robot on the map."""
    team = person.study.map.team
    return on_map(person, *team.pose[list(team.numbers).index(number), :2])


def edge(person, i, j):
    """Return a place [px] on the edge over which i receives from j, away from their numbers."""
    team = person.study.map.team
    (found,) = [each for each in person.study.map.edges.list if each[:2] == (i, j)]
    at = person.study.map.frame, 1.0, team.shapes
    begin, end = person.study.map.edges.segment_of(found, team.numbers, team.pose, *at)
    return QPoint(*map(int, begin + 0.5 * (end - begin)))


def runs_in(home):
    return sorted(
        home.glob(".local/share/mrs_simulator/runs/*"), key=lambda each: each.stat().st_mtime
    )


def read(path):
    return json.loads(path.read_text())


def test_the_paper_s_run_is_one_click_and_its_figures_are_saved(at_window, tmp_path):
    scenario = shipped("paper", duration=60.0)
    person = at_window(scenario)
    as_fast_as_possible(person)
    run(person)
    assert person.clicks == 1
    assert person.study.results_tabs.currentWidget() is person.study.verdict
    assert person.study.verdict.title.message.startswith("Seven Pioneers form a line: passed")
    person.picture("verdict")
    person.key(Qt.Key_S, Qt.ControlModifier)
    person.name_file("Save results", tmp_path / "saved")
    person.until(lambda: person.study.saved.path == str(tmp_path / "saved"))
    person.picture("saved")
    names = {each.name for each in (tmp_path / "saved").iterdir()}
    wanted = {"run.csv", "run.json", "scenario.yaml", "verdict.json", "provenance.json"}
    figures = {
        "{}.{}".format(f, k) for f in ("trajectories", "inputs") for k in ("png", "pdf", "svg")
    }
    assert wanted | figures <= names
    run_experiment(scenario, str(tmp_path / "alone"), formats=())
    alone = (tmp_path / "alone" / "run.csv").read_bytes()
    (kept,) = runs_in(tmp_path)
    assert (tmp_path / "saved" / "run.csv").read_bytes() == (kept / "run.csv").read_bytes() == alone


def test_two_gains_are_compared_by_six_clicks(at_window, tmp_path):
    person = at_window(shipped("paper_four", duration=6.0))
    as_fast_as_possible(person)
    run(person)
    person.tab("Protocol")
    person.fill(person.seen(QLineEdit, "k"), "0.05")
    run(person)
    person.tab("Runs")
    runs = person.seen(QListView, "Runs")
    person.click(runs.viewport(), box_of(runs, 1))
    study = person.study
    person.until(lambda: study.map.ghosts)
    assert person.clicks == 6
    assert (study.map.own_name, study.map.ghosts[0].name) == ("k 0.05", "k 0.02")
    assert study.results_tabs.currentWidget() is study.curves
    curves = study.curves._data()[0]
    assert [curve.run for curve in curves[3:5]] == ["k 0.05", "k 0.02"]
    styles = {(curve.run, str(curve.style["ls"])) for curve in curves}
    assert styles == {("k 0.05", "-"), ("k 0.02", "(0, (5, 2))")}
    person.picture("curves")
    person.tab("Compare")
    person.picture("table")
    table, claims = study.comparison.parameters, study.comparison.claims
    assert [table.text(0, column) for column in range(3)] == ["k", "0.05", "0.02"]
    rows = [row.split("\t") for row in claims.as_tsv().splitlines()]
    assert rows[0][1:4] == ["k 0.05, " + what for what in ("predicted", "measured", "result")]
    (gap,) = [row for row in rows if row[0].startswith("final gap")]
    assert float(gap[2]) != float(gap[5])
    # A ghost is where its robots were as long after their start.
    slider = study.time_line.slider
    person.click(slider, QPoint(slider.width() // 2, slider.height() // 2))
    other = read_run_csv(os.path.join(runs.runs.entries[1].path, "run.csv"))
    row = np.flatnonzero(other.time <= study.replay.cursor.time)[-1]
    assert 10 < row < len(other.time) - 10
    person.until(lambda: np.allclose(study.map.ghosts[0].scene.state.pose, other.pose[row]))
    person.click(person.button("Compare none"))
    person.until(lambda: not study.map.ghosts and study.comparison.claims is None)
    assert len(study.curves._data()[0]) == 4
    person.click(runs.viewport(), box_of(runs, 1))
    person.until(lambda: study.map.ghosts)
    person.tab("Team")
    person.click(person.button("Open scenario..."))
    picker = person.dialog("Choose a scenario")
    person.until(lambda: picker.list.count() > 0)
    person.key(Qt.Key_Return)  # another one, with which nothing is compared
    person.until(lambda: study.scenario.n == 7 and not study.map.ghosts)
    for folder in runs_in(tmp_path):
        names = {each.name for each in folder.iterdir()}
        assert {"run.csv", "run.json", "scenario.yaml", "verdict.json", "provenance.json"} <= names


def box_of(runs, row):
    """Return the place [px] of the box of the run in ``row``."""
    return runs.itemDelegate().box(runs.visualRect(runs.model().index(row))).center()


def test_a_cell_of_a_sweep_map_is_a_run_that_opens(at_window, tmp_path):
    person = at_window(shipped("consensus", duration=3.0), draws_curves=False)
    study = person.study
    person.tab("Sweep")
    axes = study.sweep.axes
    offered = ["gain", "control.rate"]
    person.until(lambda: [axis.name.currentText() for axis in axes] == offered)
    for form, ends in zip(axes, (("0.5", "4"), ("4", "20"))):
        for field, text in zip((form.low, form.high, form.count), (*ends, "2")):
            person.fill(field, text)
    person.picture("form")
    person.click(person.button("Start sweep"))
    cell = study.sweep.map.cell_box(0, 0).center().toPoint()
    person.click(study.sweep.map, cell)  # nothing is there to open yet
    person.until(lambda: study.sweep.note.message.startswith("4 of 4 cells"))
    # gain Tc < 1/2 on this graph: of the four only gain 4 at 4 Hz breaks it
    assert study.sweep.note.message == "4 of 4 cells, 3 passed; as theory has it: 4 of 4"
    assert "gain Tc < 2/\u03bb_max" in study.sweep.map.text_of((0, 1))
    assert study.opened.path == "" and study.sweep_control.cells.lines
    shades = [shade_of(study.sweep.map, 0, column) for column in (0, 1)]
    assert shades[0].blue() > shades[0].red() and shades[1].red() > shades[1].blue()
    person.picture("map")
    person.click(study.sweep.map, study.sweep.map.cell_box(0, 1).center().toPoint())
    person.until(lambda: study.opened.run is not None)
    person.picture("run")
    run = study.opened.run
    assert (run.scenario.control.parameters["gain"], run.scenario.control.rate) == (4.0, 4.0)
    assert "FAILED" in study.verdict.title.message
    final = read_run_csv(os.path.join(run.path, "run.csv")).pose[-1]
    np.testing.assert_allclose(study.map.team.pose, final)
    assert os.path.dirname(os.path.dirname(run.path)) == str(tmp_path / "mrs_runs")
    person.key(Qt.Key_Left)  # by keys, too
    person.key(Qt.Key_Return)
    person.until(lambda: study.opened.run is not None and study.opened.run.path != run.path)
    assert study.opened.run.scenario.control.parameters["gain"] == 0.5


def shade_of(view, row, column):
    """Return the colour of a cell near its corner."""
    image = view.grab().toImage()
    corner = view.cell_box(row, column).topLeft().toPoint() * (image.width() / view.width())
    return image.pixelColor(corner.x() + 6, corner.y() + 6)


def test_a_counterexample_is_on_the_map_by_three_clicks(at_window):
    person = at_window(scenario_from_yaml(MEETING + SEARCHED, "scenario"), draws_curves=False)
    study = person.study
    person.tab("Search")
    person.until(lambda: "gain" in study.search.vary.toPlainText())
    person.picture("form")
    person.click(person.button("Find counterexample"))
    assert study.search.bar.isVisible() and study.search.bar.maximum() == 500
    person.click(person.button("Show counterexample"))  # once it is there
    person.until(lambda: study.opened.run is not None and study.replay.cursor.is_past)
    assert person.clicks == 3
    person.picture("counterexample")
    assert study.search.text.toPlainText().startswith("found after ")
    assert "near: BROKEN" in study.search.text.toPlainText()
    assert "experiment ~/mrs_runs/two_points_agree_" in study.search.text.toPlainText()
    assert not study.search.bar.isVisible()
    run = study.opened.run
    decided = read(tmp_of(run.path) / "search.json")["worst"]["decided_at"]
    assert study.replay.cursor.time == pytest.approx(decided)
    person.until(lambda: np.hypot(*np.diff(study.map.team.pose[:, :2], axis=0)[0]) >= 2.0)
    person.click(person.button("Edit scenario"))
    assert study.scenario.title == "Counterexample: Two points agree"


def tmp_of(path):
    """Return the folder above ``path``."""
    return pathlib.Path(path).parent


DRAWN = (1, 2), (2, 3), (3, 4), (4, 5), (2, 5)


def test_five_robots_form_a_shape_over_a_graph_that_was_drawn_by_mouse(at_window, tmp_path):
    person = at_window(shipped("paper", duration=20.0), draws_curves=False)
    study = person.study
    person.fill(person.field("Robots"), "5")
    person.tab("Protocol")
    protocols = person.seen(QComboBox, "The team's coordination protocol")
    person.choose(protocols, "displacement_formation")
    person.tab("Topology")
    person.click(person.button("Remove all"))
    if study.topology.directed():
        person.click(person.button("directed"), QPoint(10, 10))
    person.click(person.button("Edges"))
    for i, j in DRAWN:
        person.drag(study.map, robot(person, i), robot(person, j))
    person.until(lambda: study.topology.figure("time").startswith("9.39 s"))
    person.picture("drawn")
    assert (study.topology.figure("tree"), study.topology.figure("edges")) == ("yes", "5")
    assert person.clicks == 13
    as_fast_as_possible(person)
    run(person)
    person.picture("verdict")
    assert "passed" in study.verdict.title.message and "failed" not in study.verdict.title.message
    (kept,) = runs_in(tmp_path)
    saved = load_scenario(str(kept / "scenario.yaml"))
    assert saved.n == 5 and not saved.topology.directed
    assert {frozenset(each[:2]) for each in saved.topology.edges} == set(map(frozenset, DRAWN))
    final = read_run_csv(str(kept / "run.csv")).pose[-1, :, :2]
    # a regular pentagon, but for the hand length
    sides = np.hypot(*(final - np.roll(final, 1, axis=0)).T)
    assert np.ptp(sides) < 0.15


def test_what_if_is_asked_of_a_moment_of_a_replay_and_kept(at_window, tmp_path):
    scenario = shipped("paper_four", duration=12.0)
    run_experiment(scenario, str(tmp_path / "recorded"), formats=())
    person = at_window(scenario, tmp_path / "recorded")
    study, slider = person.study, person.study.time_line.slider
    bar, begun = study.map_panel.ahead, study.map.team.pose
    person.click(slider, QPoint(slider.width() // 3, slider.height() // 2))
    moment = study.replay.cursor.time
    assert 3.0 < moment < 5.0
    person.click(person.button("What if"))
    assert bar.gain.currentText() == "k"
    person.click(bar.slider, QPoint(bar.slider.width() - 5, bar.slider.height() // 2))
    error = looked(person, "k = 0.0")
    person.click(study.map, edge(person, 2, 3))
    assert looked(person, "without 2\u20133") != error
    person.drag(study.map, robot(person, 1), robot(person, 1) + QPoint(60, 0))
    error = looked(person, "robot 1 at (")
    assert study.map.ahead.moved == (0,) and "ahead" in study.map.legend()
    before = study.map.team.pose
    assert np.abs(before - begun).max() > 0.5  # of the moment, and nobody was moved
    person.tab("error")
    person.until(lambda: "What if" in {curve.name for curve in study.curves._data()[0]})
    wait_drawn(study.curves)
    assert study.curves.plot.axes.get_yscale() == "log"
    person.picture("ghosts")
    person.click(person.button("Keep as run"))
    person.until(lambda: bar.text.text().startswith("Kept as"))
    runs = study.shelf.list.runs
    person.until(lambda: len(runs.entries) == 2 and runs.entries[0].marks.note)
    person.picture("kept")
    assert "without 2\u20133" in runs.entries[0].marks.note
    kept = pathlib.Path(runs.entries[0].path)
    changes = {what: (at, to) for at, what, to in read(kept / "run.json")["changes"]}
    assert changes["control"][1]["parameters"]["k"] == pytest.approx(0.0283, abs=1e-4)
    assert changes["topology"][1]["edges"] == [[1, 2, 1.0], [3, 4, 1.0]]
    assert changes["control"][0] == pytest.approx(moment, abs=0.1)
    rerun = read_run_csv(str(kept / "run.csv"))
    recorded = read_run_csv(str(tmp_path / "recorded" / "run.csv"))
    same = recorded.time <= moment
    np.testing.assert_allclose(rerun.pose[: same.sum()], recorded.pose[same], atol=1e-9)
    assert np.abs(rerun.pose[-1] - recorded.pose[-1]).max() > 0.5


def looked(person, changed):
    """Return the error [m] at the end of a look with what is ``changed``, once it is whole."""
    bar = person.study.map_panel.ahead

    def done():
        return changed in bar.text.text() and "error" in bar.text.text() and bar.keep.isEnabled()

    person.until(done)
    return float(bar.text.text().rpartition("error ")[2].split()[0])


def test_edits_are_undone_redone_and_never_lost(at_window, monkeypatch):
    monkeypatch.setattr(edited_scenario, "TOGETHER", 0.2)  # [s]
    person = at_window(shipped("paper_four"), draws_curves=False)
    study, states = person.study, [person.study.scenario.poses.copy()]

    def edited():
        states.append(study.scenario.poses.copy())
        assert np.abs(states[-1] - states[-2]).max() > 0.1
        QTest.qWait(210)  # what follows sooner is the same edit

    person.click(person.button("Poses"))
    person.drag(study.map, robot(person, 1), robot(person, 1) + QPoint(-60, -60))
    edited()
    band = robot(person, 4) + QPoint(-20, -20), robot(person, 3) + QPoint(20, 20)
    person.drag(study.map, *band, held=Qt.ShiftModifier)
    assert study.map.chosen.numbers == {3, 4}
    person.click(study.map, robot(person, 3), button=Qt.RightButton)
    person.entry("Align: same y")
    assert np.ptp(study.scenario.poses[2:, 1]) == 0.0
    edited()
    person.picture("aligned")
    person.choose(person.seen(QComboBox, "Arrangement of all robots"), "random")
    person.click(person.button("Apply"))
    edited()
    person.click(person.button("Another"))
    edited()
    person.picture("random")
    for poses in states[-2::-1]:
        key_until(person, Qt.ControlModifier, poses)
        np.testing.assert_array_equal(study.map.team.pose, poses)
    for poses in states[1:]:
        key_until(person, Qt.ControlModifier | Qt.ShiftModifier, poses)
    person.window.close()
    person = at_window(shipped("paper_four"), draws_curves=False)
    person.click(person.button("Open scenario..."))
    picker = person.dialog("Choose a scenario")
    person.until(lambda: picker.list.count() > 1)
    person.picture("picker")
    titles = [picker.list.item(row).data(CARD)[0].title for row in (0, 1)]
    assert titles == ["Four Pioneers form a line", "Seven Pioneers form a line"]
    person.key(Qt.Key_Return)  # the first card is that of the edits
    person.until(lambda: np.array_equal(person.study.scenario.poses, states[-1]))


def key_until(person, held, poses):
    """Press Z with the keys ``held`` until the scenario's poses are ``poses``.

    A drag on a busy computer may be several edits.
    """
    for _ in range(2 * STEPS):
        person.key(Qt.Key_Z, held)
        if np.array_equal(person.study.scenario.poses, poses):
            return
    raise AssertionError(person.study.scenario.poses)


SLOW = "requirements: {slow: 'always(each robot(speed < 0.4 m/s))'}\n"


def test_a_line_of_the_verdict_leads_to_its_moment_and_robot(at_window, tmp_path):
    text = shipped("paper_four", duration=30.0).to_yaml() + SLOW
    scenario = scenario_from_yaml(text, "scenario")
    run_experiment(scenario, str(tmp_path / "recorded"), formats=())
    (wanted,) = read(tmp_path / "recorded" / "verdict.json")["requirements"]
    assert not wanted["met"] and (wanted["time"], wanted["member"]) == (3.56, "robot2")
    person = at_window(scenario, tmp_path / "recorded")
    study = person.study
    person.tab("Verdict")
    table = study.verdict.findChild(QTableWidget)
    row = next(r for r in range(table.rowCount()) if table.text(r, 1) == "slow [m/s]")
    table.scrollToItem(table.item(row, 0))
    person.click(table.viewport(), table.visualItemRect(table.item(row, 1)).center())
    begin = study.replay.cursor.span[0]
    assert study.replay.cursor.time == pytest.approx(begin + wanted["time"])
    run = read_run_csv(str(tmp_path / "recorded" / "run.csv"))
    row = np.flatnonzero(run.time <= study.replay.cursor.time)[-1]
    person.until(lambda: np.allclose(study.map.team.pose, run.pose[row]))
    assert picked_out(study) == {2}
    person.picture("decided")
    person.tab("Team")
    for number, click in ((1, on_map_at), (4, on_curve), (3, in_table), (1, in_space)):
        click(person, number)
        assert picked_out(study) == {number}
    assert study.replay.cursor.time > begin + 20.0  # as the click on the curve chose
    person.picture("picked")
    person.click(study.map, on_map(person, 15.0, 5.0))
    assert picked_out(study) == {0}


def on_map_at(person, number):
    person.click(person.study.map, robot(person, number))


def on_curve(person, number):
    person.tab("Curves")
    person.tab("y")
    wait_drawn(person.study.curves)
    curves = person.study.curves
    (curve,) = [each for each in curves._data()[0] if each.robot == number]
    at = int(0.9 * len(curve.time))
    x, y = curves.plot.axes.transData.transform((curve.time[at], curve.values[at]))
    person.click(curves.canvas, QPoint(int(x), int(curves.canvas.height() - y)))


def in_table(person, number):
    table = person.study.team.findChild(QTableView)
    person.click(table.viewport(), table.visualRect(table.model().index(number - 1, 0)).center())


def in_space(person, number):
    person.tab("3D")
    canvas = person.study.view.canvas
    person.until(lambda: canvas.scene is not None and len(canvas.scene.place) >= number)

    def place():
        middle = canvas.scene.place[number - 1 : number] + (0.0, 0.0, 0.1)
        ((x, y),) = on_screen(canvas.camera.seen(middle), canvas.width(), canvas.height())
        return QPoint(int(x), int(y))

    before = None
    while place() != before:  # the view comes nearer at first
        before = place()
        QTest.qWait(50)
    person.click(canvas, before)


def picked_out(study):
    """Return which robots map, 3D view, curves and table pick out."""
    bold = [c.robot for c in study.curves._data()[0] if "zorder" in c.style] or [0]
    rows = study.team.table.selectionModel().selectedRows()
    chosen = study.map.scene().chosen
    parts = study.map.selected, 0 if chosen is None else chosen + 1, study.sensors.number
    return {*parts, *bold, *([row.row() + 1 for row in rows] or [0])}


def test_what_is_taken_away(at_window, tmp_path):
    scenario = shipped("paper_four", duration=4.0)
    run_experiment(scenario, str(tmp_path / "recorded"), formats=())
    person = at_window(scenario, tmp_path / "recorded")
    study, save = person.study, person.study.bar.button("save")
    corner = QPoint(save.width() - 4, save.height() // 2)
    person.menu(save, "Picture of the map...", corner)
    person.name_file("Save the picture", tmp_path / "map.pdf")
    person.until(lambda: study.saved.path == str(tmp_path / "map.pdf"))
    assert (tmp_path / "map.pdf").read_bytes().startswith(b"%PDF")
    person.menu(save, "Copy the curves", corner)
    rows = QApplication.clipboard().text().splitlines()
    assert rows[0].startswith("time [s],Robot 1 x [m],")
    columns = np.array([row.split(",") for row in rows[1:]], dtype=float)
    run = read_run_csv(str(tmp_path / "recorded" / "run.csv"))
    np.testing.assert_allclose(columns, np.column_stack([run.time, run.pose[:, :, 0]]), atol=1e-6)
    person.menu(save, "Compose a figure...", corner)
    composer = person.dialog("Compose a figure")
    person.click(person.button("Formation error", composer), QPoint(10, 10))
    person.click(person.button("Trajectories", composer), QPoint(10, 10))
    person.until(lambda: composer.preview.pixmap() is not None and not composer.note.message)
    person.picture("composer")
    person.click(person.button("Copy", composer))
    command = shlex.split(QApplication.clipboard().text())
    assert command[:3] == ["mrs-simulator", "figure", str(tmp_path / "recorded")]
    person.click(person.button("Save...", composer))
    person.name_file("Save the figure", tmp_path / "own.pdf")
    person.until(lambda: composer.note.message.startswith("saved"))
    command[command.index("--out") + 1] = str(tmp_path / "again.pdf")
    figure(command[2:])
    assert (tmp_path / "again.pdf").read_bytes() == (tmp_path / "own.pdf").read_bytes()
    composer.close()
    person.go_back()
    person.key(Qt.Key_S, Qt.ControlModifier)  # all of the run that is shown
    person.name_file("Save results", tmp_path / "all")
    person.until(lambda: study.saved.path == str(tmp_path / "all"))
    assert (tmp_path / "all" / "trajectories.pdf").exists()
    same = [(tmp_path / each / "run.csv").read_bytes() for each in ("all", "recorded")]
    assert same[0] == same[1] and study.results.of_run() == ""


def test_a_push_is_an_event_of_the_run(at_window, tmp_path):
    person = at_window(shipped("paper_four", duration=3.0), draws_curves=False)
    study = person.study
    person.tab("Verdict")
    person.key(Qt.Key_Minus, Qt.ControlModifier, times=2)  # there is time for a push
    person.click(person.button("Run the scenario"))
    person.until(lambda: len(study.history.time) > 1)
    person.click(person.button("Push"))
    begin = robot(person, 2)
    person.drag(study.map, begin, begin + QPoint(80, 0), letting_go=False)
    pushed = study.map.to_plane(begin.x() + 80, begin.y())
    person.until(lambda: "robot2 was pushed" in study.messages.toPlainText())
    # Held until it is seen there: the first push may be of the drag's beginning.
    person.until(lambda: np.hypot(*(study.history.pose[:, 1, :2] - pushed).T).min() < 0.3)
    person.picture("held")
    person.let_go(study.map, begin + QPoint(80, 0))
    as_fast_as_possible(person)
    wait_judged(person, 1)
    person.picture("verdict")
    (kept,) = runs_in(tmp_path)
    events = load_scenario(str(kept / "scenario.yaml")).events
    assert {(each.event, each.robot) for each in events} == {("pushed", 2)}
    run = read_run_csv(str(kept / "run.csv"))
    assert np.hypot(*(run.pose[:, 1, :2] - pushed).T).min() < 0.3
    assert judged_row(study.verdict, "final gap, the worst [m]")["result"] == "not judged"
    person.tab("Messages")
    person.picture("messages")


def test_two_gains_are_compared_by_keys_alone(at_window):
    person = at_window(shipped("paper_four", duration=3.0), draws_curves=False)
    study = person.study
    as_fast_as_possible(person)
    run_by_key(person, 1)
    tabs = study.settings_tabs.tabBar()
    tab_to(person, tabs)
    person.key(Qt.Key_Right)
    tab_to(person, person.seen(QLineEdit, "k"))
    person.replace("0.05")
    run_by_key(person, 2)
    tab_to(person, tabs)
    person.key(Qt.Key_Right, times=2)
    tab_to(person, person.seen(QListView, "Runs"))
    person.key(Qt.Key_Down)
    person.key(Qt.Key_Space)
    person.until(lambda: study.map.ghosts)
    assert (study.map.own_name, study.map.ghosts[0].name) == ("k 0.05", "k 0.02")
    person.picture("compared")
    person.key(Qt.Key_F8)
    person.until(lambda: study.study.state.is_emergency())
    person.picture("stopped")
    assert person.clicks == 0


def run_by_key(person, count):
    """Press F5 as soon as Run is offered, and wait until ``count`` runs are judged."""
    person.until(person.study.bar.button("run").isEnabled)
    person.key(Qt.Key_F5)
    wait_judged(person, count)


def tab_to(person, widget):
    """Press Tab until ``widget`` has the focus."""
    for _ in range(200):
        if QApplication.focusWidget() is widget:
            return
        person.key(Qt.Key_Tab)
    raise AssertionError(widget)
