"""Scenarios opened, refused and saved by the whole window: what is not opened is not in force."""

import os

import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import quiet_study, shown
from PyQt5.QtWidgets import QApplication

from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path

pytestmark = pytest.mark.usefixtures("no_hidden_errors", "forked_programs")
LAW = (
    "from mrs_simulator.control.pioneer_control import PioneerControl\n"
    "class Law(PioneerControl):\n"
    "    def pointMassLaw(self, hand): return 0.0 * hand\n"
)
TWO = "poses: [[0, 0, 0], [2, 0, 0]]\ncontrol: {{protocol: {}}}\n"


@pytest.fixture
def gui(tmp_path, monkeypatch):
    """The window with nothing behind it."""
    monkeypatch.setenv("HOME", str(tmp_path))
    application = QApplication.instance() or QApplication([])
    widget = shown(quiet_study(load_scenario(scenario_path("paper_four"))), 1366, 768)
    yield widget
    widget.close_study()
    widget.close()
    application.processEvents()


def said(gui):
    return gui.messages.toPlainText()


def test_with_nothing_running_the_state_says_so_and_no_more(gui):
    gui.connection.master_online = True
    gui.tick()
    start = gui.bar.button("control")
    assert gui.bar.button("simulate").isEnabled()
    assert not start.isEnabled() and "no robots" in start.toolTip()
    assert not gui.status["time"].isVisible() and gui.status["robots"].isVisible()
    assert "no simulation runs" in gui.bar.button("pause").toolTip()


def test_what_is_wrong_is_said(gui, tmp_path):
    (tmp_path / "broken.py").write_text("raise RuntimeError('half done')")
    (tmp_path / "bad.yaml").write_text("poses: [[0, 0]]")
    gui.protocol.protocol_chosen.emit(str(tmp_path / "broken.py"))
    gui.load(str(tmp_path / "bad.yaml"))
    gui.restore_settings({"scenario": "poses: 3", "across": "1 x", "down": "-5 9", "shown": None})
    assert gui.scenario.n == 4 and gui.scenario.control.protocol == "formation"
    assert all(text in said(gui) for text in ("half done", "poses[0]", "not applied"))
    kept = gui.save_settings()
    gui.shown["trails"].setChecked(False)
    gui.restore_settings(kept)
    assert gui.shown["trails"].isChecked()


def test_a_scenario_that_is_not_opened_is_not_in_force(gui, tmp_path):
    law = tmp_path / "law.py"
    law.write_text(LAW + "    def targets(self, hand): raise KeyError('nowhere')\n")
    for name, protocol in (("own", "law.py"), ("unknown", "nonesuch")):
        (tmp_path / (name + ".yaml")).write_text(TWO.format(protocol))
    kept = gui.save_settings()
    for name in ("own", "unknown"):
        gui.load(str(tmp_path / (name + ".yaml")))
    gui.protocol.protocol_chosen.emit(str(law))
    text = (tmp_path / "own.yaml").read_text().replace("law.py", str(law))
    gui.restore_settings({"scenario": text})
    assert gui.save_settings()["scenario"] == kept["scenario"]
    assert gui.team.poses().shape == (4, 3)
    gui.protocol.protocol_chosen.emit("containment")
    gui.team.set_team(gui.scenario.poses[:2], gui.scenario.kinds[:2])
    gui.team.team_changed.emit()
    assert gui.scenario.n == 4 and gui.team.poses().shape == (4, 3)
    assert said(gui).count("not opened") == 2 and said(gui).count("KeyError: 'nowhere'") == 3
    assert "nonesuch" in said(gui) and "leaders = 3" in said(gui)


def test_a_scenario_saved_elsewhere_finds_the_law_beside_the_first(gui, tmp_path):
    (tmp_path / "other").mkdir()
    (tmp_path / "law.py").write_text(LAW)
    (tmp_path / "mine.yaml").write_text(TWO.format("law.py"))
    gui.load(str(tmp_path / "mine.yaml"))
    saved = str(tmp_path / "other" / "saved.yaml")
    gui.save_scenario(saved)
    kept = gui.save_settings()
    for again in (lambda: gui.load(saved), lambda: gui.restore_settings(kept)):
        gui.editing.take(load_scenario(scenario_path("paper_four")))
        again()
        assert gui.study.edited.derived.protocol == "Law"
    gui.save_scenario(str(tmp_path / "nowhere" / "saved.yaml"))
    assert "not saved" in said(gui) and "nowhere" in said(gui)
