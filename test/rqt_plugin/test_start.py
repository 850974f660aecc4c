"""The first minute: picker, tour, dropped files, and edits that are never lost."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from gui_fixtures import quiet_study, shown, wait_shown
from protocol_fixtures import shipped
from PyQt5.QtCore import QMimeData, QPointF, Qt, QUrl
from PyQt5.QtGui import QColor, QDropEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QFrame

from mrs_simulator.rqt_plugin.start.cards import card_of
from mrs_simulator.rqt_plugin.start.memory import MOST_EDITS, StartMemory
from mrs_simulator.rqt_plugin.start.picker import CARD, ScenarioPicker
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path

APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors")


@pytest.fixture(autouse=True)
def home(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    return tmp_path / "mrs_simulator"


def test_a_card_tells_law_team_and_theorem_and_what_is_wrong(tmp_path):
    colours = QColor("white"), QColor("black")
    card = card_of(scenario_path("consensus"), *colours)
    assert card.about.startswith("consensus \u00b7 6 robots") and not card.wrong
    assert card.theorem.startswith("Over a graph with a spanning tree all robots come to w^T p(0)")
    pixels = {card.image.pixel(x, y) for x in range(0, 272, 2) for y in range(0, 204, 2)}
    assert len(pixels) > 6  # robots of six colours, and the ground
    broken = tmp_path / "broken.yaml"
    broken.write_text("robots: many\n")
    assert "poses" in card_of(str(broken), *colours).wrong


def test_the_picker_finds_by_words_and_opens_by_return():
    memory = StartMemory()
    memory.opened(scenario_path("marching"), "text")
    picker, chosen = ScenarioPicker(memory), []
    picker.chosen.connect(chosen.append)
    picker.cards.close()
    picker.timer.stop()
    for name in ("marching", "paper", "consensus"):
        picker._add(card_of(scenario_path(name), QColor("white"), QColor("black")))
    assert [picker.list.item(row).data(CARD)[1] for row in range(3)] == [
        "Recent",
        "Shipped",
        "Shipped",
    ]
    shown(picker, 600, 500)
    QTest.keyClicks(picker._find, "Line FORMATION")
    assert [picker.list.item(row).isHidden() for row in range(3)] == [True, False, True]
    picker.grab()
    QTest.keyClick(picker.list, Qt.Key_Return)
    assert chosen == [scenario_path("paper")] and not picker.isVisible()


def test_the_tour_has_six_steps_and_one_click_ends_it_for_ever():
    study = quiet_study(shipped("consensus"))
    shown(study, 1100, 740)
    study.files.memory.change(picker=False)
    study.start.begin()
    texts = []
    for _ in range(6):
        tour = study.start.tour
        texts.append(tour.text.text())
        assert study.rect().contains(tour.geometry())
        tour.next.click()
    assert len(set(texts)) == 6 and study.start.tour is None
    study.files.memory.change(tour=True)
    study.start.begin()
    QTest.mouseClick(study.start.tour.close_button, Qt.LeftButton)
    assert study.map.hasFocus()  # F5 works at once
    study.start.begin()
    assert study.start.tour is None and not StartMemory().kept()["tour"]
    study.close_study()


def test_the_tour_stays_beside_its_subject_when_one_column_becomes_two():
    study = quiet_study(shipped("consensus"))
    shown(study, 600, 540)
    study.files.memory.change(picker=False)
    study.start.begin()
    bar = study.results_tabs.tabBar()
    wait_shown(lambda: ring_is_around(study, bar))
    place = bar.mapTo(study, bar.rect().topLeft())
    study.status["time"].setText("in another line<br>of the state")  # as once a run begins
    study.status["time"].show()
    wait_shown(lambda: bar.mapTo(study, bar.rect().topLeft()) != place)
    wait_shown(lambda: ring_is_around(study, bar))
    study.resize(1340, 740)
    wait_shown(lambda: ring_is_around(study, study.settings_tabs.tabBar()))
    study.close_study()


def ring_is_around(study, bar):
    """Return whether the tour's ring is where ``bar``, whose tabs it is about, is."""
    corner = bar.mapTo(study, bar.rect().topLeft())
    gap = study.findChild(QFrame, "ring").pos() - corner
    return bar.isVisible() and max(abs(gap.x()), abs(gap.y())) < 4


def dropped(study, path):
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path))])
    place = QPointF(5, 5)
    event = QDropEvent(place, Qt.CopyAction, data, Qt.LeftButton, Qt.NoModifier)
    study.start.eventFilter(study, event)  # Qt itself sends none outside a drag


def test_a_scenario_dropped_on_the_window_opens_and_unsaved_edits_are_kept(home):
    study = quiet_study(load_scenario(scenario_path("paper")))
    study.study.state.is_controlled = lambda: False
    study.study.is_controlled = lambda: False
    study.team.set_pose(1, 3.0, 3.0, 0.0)
    study.editing._change_team()
    edited = study.files.text()
    dropped(study, scenario_path("consensus"))
    assert study.scenario.title == load_scenario(scenario_path("consensus")).title
    opened, kept = study.files.memory.recent()
    assert study.files.memory.is_edits(kept) and os.path.basename(opened) == "consensus.yaml"
    assert load_scenario(kept).poses[0].tolist() == [3.0, 3.0, 0.0]
    with open(kept, encoding="utf-8") as file:
        assert file.read() == edited
    dropped(study, home / "picture.png")
    assert "wanted a scenario" in study.messages.toPlainText()
    study.close_study()
    assert len(os.listdir(home / "edits")) == 1  # nothing was edited since


def test_files_of_edits_are_few_and_a_broken_memory_is_none(home):
    memory = StartMemory()
    for number in range(MOST_EDITS + 3):
        memory.keep_edits("text {}".format(number), "team {}".format(number))
    assert len(os.listdir(home / "edits")) == MOST_EDITS
    (home / "start.json").write_text("{")
    assert memory.recent() == [] and memory.kept()["picker"]
