"""After an edit, or a reset, nothing that is of the last run is shown as if it were of what is edited."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from gui_fixtures import quiet_study, shown
from protocol_fixtures import shipped
from PyQt5.QtWidgets import QApplication
from snapshots import snapshot_of

APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors", "forked_programs")
CHECK = {
    "name": "gap",
    "passed": True,
    "predicted": 0.0,
    "measured": 0.0,
    "difference": 0.0,
    "tolerance": 0.1,
    "note": "",
    "question": "theorem",
}
VERDICT = {
    "title": "Five robots",
    "reason": "",
    "outcome": "passed",
    "checks": [CHECK],
    "final_gaps": None,
    "min_distance": None,
    "warnings": [],
}
REMARK = "last run, before your edits"


@pytest.fixture
def study():
    """The GUI after a run that is over, with its verdict."""
    widget = shown(quiet_study(shipped("consensus", {"gain": 0.2}), draws_curves=True), 1180, 720)
    widget.history.before_clearing = lambda: None  # nothing is kept
    widget.course._judge.follow = lambda ran: None  # the verdict is given here
    n = widget.scenario.n
    poses = [np.outer(np.arange(n), [5.0, 0.0, 0.0]) + 0.1 * time for time in range(3)]
    widget.samples = [
        snapshot_of(
            float(time),
            tuple(range(1, n + 1)),
            pose,
            np.full((n, 3), 0.1),
            np.full((n, 2), 0.1),
            np.ones(n, dtype=bool),
        )
        for time, pose in enumerate(poses)
    ]
    tick(widget, [None, *widget.samples])
    widget.verdict.set_verdict(VERDICT)
    tick(widget)
    yield widget
    widget.history.clear()
    widget.close_study()
    widget.close()


def tick(study, samples=()):
    study.connection.take_samples.return_value = list(samples)
    study.tick()
    study.connection.take_samples.return_value = []
    study.tick()


def is_marked(study):
    """Return whether verdict, its tab, curves and status line say so; all or none of them do."""
    study.curves.canvas.draw()
    study.status["time"].setText("")
    study.study.state._time = lambda *_: (True, "t = 2.0 s")
    study.status_line.show()
    tabs = study.results_tabs
    found = {
        REMARK in study.verdict.title.message.lower(),
        "last run" in tabs.tabText(tabs.indexOf(study.verdict)),
        REMARK in [text.get_text() for text in study.curves.plot.axes.texts],
        REMARK in study.status["time"].text(),
    }
    assert len(found) == 1
    return found.pop()


def test_a_run_that_is_over_is_marked_once_the_scenario_is_edited_and_not_by_its_speed(study):
    assert not is_marked(study)
    study.bar.speed_chosen.emit(5.0)
    tick(study)
    assert not is_marked(study)
    study.protocol.parameters_changed.emit({"gain": 0.6})
    tick(study)
    assert is_marked(study)
    assert (
        study.verdict.title.message == "Last run, before your edits: Five robots: passed (1 passed)"
    )
    study.bar.undo_asked.emit()
    tick(study)
    assert not is_marked(study) and study.verdict.title.message == "Five robots: passed (1 passed)"


def test_edits_of_a_run_that_goes_on_are_of_that_run(study):
    study.study.is_controlled = study.study.state.is_controlled = lambda: True
    study.connection.newest.return_value = None
    tick(study)
    study.protocol.parameters_changed.emit({"gain": 0.6})
    tick(study)
    assert not is_marked(study)


def test_a_reset_puts_verdict_and_curves_away(study):
    study.protocol.parameters_changed.emit({"gain": 0.6})
    tick(study)
    tick(study, [None])
    assert study.verdict.verdict is None and "No verdict" in study.verdict.title.message
    tabs = study.results_tabs
    assert tabs.tabText(tabs.indexOf(study.verdict)) == "Verdict"
    assert not is_marked(study) and not study.curves.plot.axes.lines


def test_the_tabs_stay_where_they_are_as_the_verdict_changes(study):
    tabs, places = study.results_tabs, []
    bar = tabs.tabBar()
    study.verdict.clear()
    for headline in ("", "on course", "FAILED", "3 failing", "not judged", "passed"):
        study.verdict.headline_changed.emit(headline)
        places.append(bar.tabRect(tabs.indexOf(study.comparison)).left())
    assert len(set(places)) == 1
    study.verdict.headline_changed.emit("self-consistent (last run)")
    widest = bar.tabRect(tabs.indexOf(study.comparison)).left()
    study.verdict.headline_changed.emit("passed")
    assert bar.tabRect(tabs.indexOf(study.comparison)).left() == widest > places[0]
