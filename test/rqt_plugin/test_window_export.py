"""What a user takes away: pictures of the views, curves as a table, results with a video."""

import os

import numpy as np
import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import quiet_study, shown, wait_shown
from PIL import Image
from PyQt5.QtGui import QColor, QDesktopServices, QPalette
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QFileDialog
from snapshots import snapshot_of

from mrs_simulator.rqt_plugin.run.bar import EXPORTS
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path

pytestmark = pytest.mark.usefixtures("no_hidden_errors")


def sample(row):
    pose = np.array([[0.1 * row, 1.0, 0.0], [2.0, 0.2 * row, 0.0]])
    columns = np.zeros((2, 3)), np.ones((2, 2)), np.ones(2, dtype=bool)
    return snapshot_of(0.1 * row, (1, 2), pose, *columns)


@pytest.fixture
def study(no_predictions):
    application = QApplication.instance() or QApplication([])
    widget = quiet_study(load_scenario(scenario_path("paper_four")))
    widget.history.before_clearing = lambda: None  # nothing is kept
    for row in range(30):
        widget.history.append(sample(row))
    shown(widget, 900, 600)
    widget.map.show_snapshot(sample(29))
    yield widget
    widget.history.saved = np.inf
    widget.close_study()
    widget.close()
    application.processEvents()


def choose(widget, what):
    """Choose an entry of the menu beside "Save..."."""
    places = [name for name, _, _ in EXPORTS]
    widget.bar.exports.actions()[places.index(what)].trigger()


def answer(widget, path):
    dialog = next(each for each in widget.findChildren(QFileDialog) if each.isVisible())
    dialog.fileSelected.emit(str(path))
    dialog.close()


def test_pictures_of_the_views(study, tmp_path):
    widgets = {"map": study.map, "curves": study.curves.canvas, "view": study.view.canvas}
    begins = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}
    for what, widget in widgets.items():
        if what == "view":
            study.results_tabs.setCurrentWidget(study.view)
        QTest.qWait(1)
        for kind in begins if what == "curves" else ("png", "pdf"):
            path = tmp_path / "{}.{}".format(what, kind)
            choose(study, what)
            answer(study, path)
            assert path.read_bytes().startswith(begins[kind])
        image = Image.open(str(tmp_path / (what + ".png")))
        # The curves' is as wide as other figures: 6.5 in of 200 pixels.
        wanted = 1300 if what == "curves" else 3 * widget.width()
        assert image.size[0] == pytest.approx(wanted, abs=3)
        assert len(np.unique(np.asarray(image.convert("L")))) > 10  # something is drawn
        assert study.curves.canvas.isVisible() == (what != "view")


@pytest.mark.parametrize("size", [(900, 600), pytest.param((1400, 900), marks=pytest.mark.release)])
def test_a_picture_of_the_curves_is_a_papers_whatever_theme_and_size_the_window_has(
    study, tmp_path, size
):
    study.resize(*size)
    palette = study.curves.palette()
    palette.setColor(QPalette.Window, QColor("#303030"))
    palette.setColor(QPalette.WindowText, QColor("#f0f0f0"))
    study.curves.setPalette(palette)
    study.results_tabs.setCurrentWidget(study.curves)
    QTest.qWait(100)
    shown_plot, path = study.curves.plot, tmp_path / "picture.png"
    study.curves.save_picture(str(path))
    data = path.read_bytes()
    study.curves.save_picture(str(path))
    assert path.read_bytes() == data  # the same curves are the same bytes
    image = np.asarray(Image.open(str(path)).convert("RGB"))
    assert image.shape == (680, 1300, 3)  # 6.5 x 3.4 in of 200 pixels
    assert (image[[0, 0, -1, -1], [0, -1, 0, -1]] == 255).all()
    assert study.curves.plot is shown_plot and shown_plot.figure.canvas is study.curves.canvas
    assert shown_plot.figure.get_facecolor()[0] < 0.3


def test_a_picture_of_another_kind_or_where_none_can_be_is_refused(study, tmp_path):
    for name, said in (
        ("a.bmp", "wanted a file that ends in png, pdf"),
        ("no/a.pdf", "No such file"),
    ):
        choose(study, "map")
        answer(study, tmp_path / name)
        assert said in study.messages.toPlainText()
    assert not list(tmp_path.iterdir())


def test_a_figure_is_composed_of_the_run_saved_last(study, tmp_path, monkeypatch):
    asked = []

    def run(name, script, *words, limit):
        asked.append(words)
        Image.new("RGB", (40, 30), "red").save(words[words.index("--out") + 1])
        return (2, "figure: robot 9: none") if "9" in words else (0, "")

    choose(study, "figure")
    assert "no run of this window is saved yet" in study.messages.toPlainText()
    study.results.directory = str(tmp_path / "a run")
    monkeypatch.setattr(study.study.processes, "run", run)
    study.study.processes.directory = str(tmp_path)
    choose(study, "figure")
    composer = study.export.composer
    composer.panels["x"].setChecked(False)
    composer.begin.setText("2")
    wait_shown(lambda: composer.preview.pixmap() is not None and not composer.note.message)
    (words,) = asked  # one figure for three choices
    assert words[0] == study.results.directory and "trajectories" in words
    assert words[words.index("--between") + 1 :][:2] == ("2", "inf")
    composer.copy.click()
    command = "mrs-simulator figure {!r} --out figure.pdf".format(study.results.directory)
    assert QApplication.clipboard().text().startswith(command)
    composer.save.click()
    answer(study, tmp_path / "own.png")
    wait_shown(lambda: "saved" in composer.note.message)
    assert study.saved.path == str(tmp_path / "own.png")
    assert (tmp_path / "own.png").exists()
    assert not composer.compare.isEnabled() and "--compare" not in words
    composer.robots.setText("9")
    wait_shown(lambda: "robot 9: none" in composer.note.message)
    composer.close()


def test_compared_runs_are_composed_by_name_with_their_error(study, tmp_path, monkeypatch):
    compared = [("k 0.02", ""), ("k 0.05", str(tmp_path / "other"))]
    monkeypatch.setattr(study.comparison_control, "named", lambda: compared)
    study.results.directory = str(tmp_path / "a run")
    study.study.processes.directory = str(tmp_path)
    monkeypatch.setattr(study.study.processes, "run", lambda *_, **__: (2, "not drawn here"))
    choose(study, "figure")
    composer = study.export.composer
    composer.panels["error"].setChecked(True)
    words = composer.arguments("f.pdf")
    assert words[words.index("--panels") + 1].split(",")[-1] == "error"
    at = words.index("--compare")
    assert words[at : at + 5] == ["--compare", compared[1][1], "--names", "k 0.02", "k 0.05"]
    composer.begin.setText("2,5")
    assert "'2,5': wanted a number, with a point" in composer.note.message
    composer.begin.setText("2.5")
    assert "wanted a number" not in composer.note.message
    composer.compare.setChecked(False)
    assert "--compare" not in composer.arguments("f.pdf")
    composer.close()


@pytest.mark.parametrize("what, more", [("video", []), ("film", ["--space"])])
def test_results_are_saved_with_a_video(study, tmp_path, what, more, monkeypatch):
    asked = []
    files = study.study.files
    monkeypatch.setattr(files, "saver", lambda *given: lambda: asked.append(given[1:]))
    choose(study, what)
    answer(study, tmp_path / "run")
    options = "--video", "--beside-curves", *more
    assert asked == [(str(tmp_path / "run"), "png,pdf,svg", options)]


@pytest.mark.parametrize("opens", [True, False])
def test_a_line_says_where_a_picture_is_and_opens_its_folder(study, tmp_path, monkeypatch, opens):
    asked = []
    monkeypatch.setattr(
        QDesktopServices, "openUrl", lambda url: asked.append(url.toLocalFile()) or opens
    )
    assert not study.saved.isVisible()
    folder = tmp_path / ("a long name " * 12)
    folder.mkdir()
    choose(study, "map")
    answer(study, folder / "picture.png")
    assert study.saved.isVisible() and study.saved.toolTip().startswith(str(folder))
    assert "Open folder" in study.saved.text() and "\u2026" in study.saved.text()
    study.saved.linkActivated.emit("folder")
    assert asked == [str(folder)]
    assert ("no program opens folders" in study.messages.toPlainText()) == (not opens)
    study.tick()
    assert study.saved.isVisible()
    study.bar.asked.emit("reset")
    assert not study.saved.isVisible()


def test_the_line_names_the_home_directory_as_its_user_does(study, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    study.saved.name(str(tmp_path / "run"), 2000)
    assert "saved: ~" + os.sep + "run" in study.saved.text()
    assert study.saved.folder() == str(tmp_path) and str(tmp_path) in study.saved.toolTip()
    study.saved.name(str(tmp_path) + "2/run", 2000)
    assert str(tmp_path) + "2/run" in study.saved.text()


def test_the_line_opens_a_folder_that_was_saved_itself(study, tmp_path):
    study.say_saved(str(tmp_path))
    assert study.saved.folder() == str(tmp_path)
