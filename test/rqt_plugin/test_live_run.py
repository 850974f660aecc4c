"""What the GUI shows of a run while its scenario is edited."""

import os
from types import SimpleNamespace
from unittest import mock

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from gui_fixtures import quiet_study
from protocol_fixtures import shipped
from PyQt5.QtWidgets import QApplication
from snapshots import snapshot_of

from mrs_simulator.core.graphs import Topology
from mrs_simulator.record.run_changes import controller_settings
from mrs_simulator.study.run.law_answers import Prediction

APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors")


@pytest.fixture
def study():
    widget = quiet_study(shipped("consensus", {"gain": 0.2}))
    widget.history.before_clearing = lambda: None  # nothing is kept
    yield widget
    widget.history.clear()
    widget.close_study()


def sample(study, time):
    """Return the state at ``time`` [s] of robots that go round in 20 s."""
    n = study.scenario.n
    place = [2.0 * np.cos(0.314 * time), 2.0 * np.sin(0.314 * time), 0.1]
    pose = np.tile(place, (n, 1)) + np.outer(np.arange(n), [5.0, 0.0, 0.0])
    command, fresh = np.full((n, 2), 0.1), np.ones(n, dtype=bool)
    return snapshot_of(time, tuple(range(1, n + 1)), pose, np.full((n, 3), 0.1), command, fresh)


def tick(study, times, obeyed=()):
    """Let robots be commanded at ``times`` [s], and controllers say what they obey."""
    study.connection.take_samples.return_value = [sample(study, time) for time in times]
    study.connection.take.side_effect = lambda name: obeyed if name == "applied" else []
    study.tick()


def test_the_error_beside_the_curves_is_of_the_run_and_of_no_later_edit(study, monkeypatch):
    gains = []

    def error_function(scenario=None):
        gains.append(scenario and scenario.control.parameters["gain"])

    monkeypatch.setattr(study.study.edited, "error_function", error_function)
    tick(study, [0.0, 1.0])
    assert gains == [0.2]
    study.protocol.parameters_changed.emit({"gain": 0.6})
    tick(study, [2.0])
    assert study.scenario.control.parameters["gain"] == 0.6 and gains == [0.2]
    first = dict(controller_settings(study.history.scenario))
    tick(study, [3.0], [(0.0, first), (2.5, controller_settings(study.scenario))])
    assert gains == [0.2, 0.6]
    study.history.clear()  # another run: what is edited is what comes
    tick(study, [])
    assert gains == [0.2, 0.6, None]


def test_theory_beside_the_curves_ends_where_the_run_was_changed(study, monkeypatch):
    drawn, edited = mock.Mock(), study.study.edited
    monkeypatch.setattr(study.curves, "set_prediction", drawn)
    changed = dict(
        controller_settings(study.scenario), control={"protocol": "consensus", "rate": 50.0}
    )
    tick(study, [0.0, 1.0, 2.0], [(0.0, controller_settings(study.scenario)), (1.5, changed)])
    of_edits, of_run = (
        (Prediction(np.arange(4.0), np.full(4, value), "soon"), None) for value in (5.0, 7.0)
    )
    monkeypatch.setattr(edited, "take_prediction", lambda: of_edits)
    monkeypatch.setattr(edited, "take_run_prediction", lambda: of_run)
    study.live.show_prediction()
    (call,) = drawn.call_args_list
    assert [part.tolist() for part in call[0]] == [[0.0, 1.0], [7.0, 7.0]]


def test_a_slower_speed_is_advised_while_a_simulation_runs_and_no_law_hangs(study, monkeypatch):
    monkeypatch.setattr(study.study, "note_timing", lambda: "periods were missed")
    fresh = study.connection.is_fresh
    for runs, hangs, advised in (
        (True, "", True),
        (True, "has not answered for 9 s", False),
        (False, "", False),
        (True, "", True),
    ):
        fresh.side_effect = lambda name, runs=runs: runs and name == "stage"
        monkeypatch.setattr(study.study.state, "hangs", lambda hangs=hangs: hangs)
        study.status_line.show_timing()
        assert ("choose a slower speed" in study.banners.text("timing")) == advised


def test_trails_of_a_run_that_is_faster_than_the_pictures_lead_through_its_samples(study):
    taken, shown = study.connection.take_samples, study.map.trails
    study.connection.is_fresh.side_effect = lambda name: True
    for begin in (0.0, 20.0, 0.0):  # two pictures of a run, and the first of another
        times = np.arange(begin, begin + 10.05, 0.1)
        taken.side_effect = [[sample(study, time) for time in times[:-1]], [], []]
        study.connection.snapshot.return_value = sample(study, times[-1])
        study.live.show_frame()
        shown = study.map.trails
        assert (shown.count >= 95).all() and (shown.count <= 101 * (1 + (begin > 0))).all()
        apart = np.linalg.norm(np.diff(shown.path(0)[-95:], axis=0), axis=1)
        assert apart.max() < 0.1


def test_trails_of_another_run_begin_with_its_first_sample(study):
    taken, snapshot = study.connection.take_samples, study.connection.snapshot
    tick(study, [0.0, 1.0, 2.0])
    study.connection.is_fresh.side_effect = lambda name: True
    taken.return_value, snapshot.return_value = [], sample(study, 2.0)
    study.live.show_frame()
    taken.return_value = [None, sample(study, 2.05), sample(study, 2.2)]  # time goes on
    snapshot.return_value = sample(study, 2.2)
    study.live.show_frame()
    wanted = [sample(study, time).pose[0, :2] for time in (2.05, 2.2)]
    np.testing.assert_allclose(study.map.trails.path(0), wanted)


def test_many_samples_between_two_pictures_are_thinned(study):
    study.connection.is_fresh.side_effect = lambda name: True
    study.connection.take_samples.side_effect = [
        [sample(study, time) for time in np.arange(0.0, 100.0, 0.1)]
    ]
    study.connection.snapshot.return_value = sample(study, 100.0)
    study.live.show_frame()
    assert (study.map.trails.count == 101).all()


def test_once_the_simulation_has_ended_the_map_shows_what_starts_and_the_run_faintly(study):
    connection, shown, start = study.connection, study.map, study.scenario.poses
    connection.is_fresh.side_effect = lambda name: True
    for time in (0.0, 1.0):
        connection.snapshot.return_value = sample(study, time)
        study.live.show_frame()
    assert shown.last_run is None and not np.allclose(shown.team.pose, start)
    ended, trails = shown.team.pose, shown.trails
    shown.show_targets(ended[:, :2])
    connection.snapshot.return_value = None
    study.live.show_frame()
    assert np.allclose(shown.team.pose, start) and not shown.trails.begun
    assert np.array_equal(shown.last_run.scene.state.pose, ended)
    assert shown.last_run.trails is trails and "last run" in shown.legend()
    assert shown.targets is None is study.study.edited.derived.targets
    shown.resize(400, 300)
    faint = shown.grab().toImage()
    study.live.put_away()  # as an edit does
    shown.set_shown("legend", False)
    connection.snapshot.return_value = sample(study, 0.0)
    study.live.show_frame()
    assert shown.last_run is None and shown.grab().toImage() != faint


def test_a_simulation_of_others_has_ended_once_it_is_gone_from_the_master(study):
    connection = study.connection
    connection.is_fresh.side_effect = lambda name: True
    connection.snapshot.return_value = sample(study, 0.0)
    connection.forget.side_effect = lambda name: setattr(connection.snapshot, "return_value", None)
    study.live.show_frame()
    connection.is_fresh.side_effect = lambda name: False
    connection.registered = frozenset(["stage"])  # it is silent
    study.live.show_frame()
    assert study.map.last_run is None
    connection.registered = frozenset()
    study.live.show_frame()
    assert study.map.last_run is not None


def test_the_loss_of_the_master_has_a_banner_until_it_is_back(study):
    for online, lost in ((False, False), (True, False), (False, True), (True, False)):
        study.connection.master_online = online
        study.status_line.show()
        assert ("master does not answer" in study.banners.text("master")) == lost


def test_the_banner_of_a_law_that_hangs_can_be_closed_and_comes_again_with_another(
    study, monkeypatch
):
    hanging = ["has not answered for 4 s"]
    study.connection.newest.side_effect = lambda name: "law.py:3" if name == "law_at" else None
    monkeypatch.setattr(study.study.state, "hangs", lambda: hanging[0])
    for here in (True, False):
        study.study.processes.is_running.side_effect = lambda name, here=here: here
        study.status_line.show_hanging()
        assert hanging[0] in study.banners.text("hangs")
        assert ("law hangs at law.py:3," in study.banners.text("hangs")) == here
        study.banners.button("hangs", "Close").click()
        study.status_line.show_hanging()
        assert not study.banners.text("hangs")
        kept, hanging[0] = hanging[0], ""
        study.status_line.show_hanging()
        hanging[0] = kept


def test_a_stop_that_was_asked_for_is_no_error(study):
    for trouble, wrong in (("stopped by request", False), ("the law failed", True)):
        status = SimpleNamespace(trouble=trouble, running=False, stopped=())
        study.live._report_trouble(status)
        assert bool(study.banners.text("error")) == wrong
        assert trouble in study.messages.toPlainText()


def test_warnings_are_closed_whatever_the_controller_does_meanwhile(study):
    status = SimpleNamespace(running=True, warnings=("deadlock",))
    study.live.show_warnings(status)
    study.live.go_on(None)  # after a replay
    study.banners.button("warnings", "Close").click()
    assert not study.banners.text("warnings")
    study.live.show_warnings(status)
    assert not study.banners.text("warnings")
    study.live.show_warnings(SimpleNamespace(running=True, warnings=("deadlock", "slow")))
    assert study.banners.text("warnings") == "deadlock\nslow"


def test_predicted_paths_are_on_the_map_until_the_robots_go(study, monkeypatch):
    paths = np.zeros((5, study.scenario.n, 2))
    found = iter([(paths, None)])
    monkeypatch.setattr(study.study.edited, "take_forecast", lambda: next(found, None))
    tick(study, [])
    assert study.map.forecast is paths and "forecast" in study.map.legend()
    study.map.show_snapshot(sample(study, 0.0))
    tick(study, [0.0, 1.0])
    assert study.map.forecast is None


def test_the_graph_of_an_opened_scenario_is_shown_once_the_controller_before_has_ended(study):
    before, chain = study.study.edited.derived.topology, [(1, 2, 1.0), (2, 3, 1.0)]
    n = study.scenario.n
    status = SimpleNamespace(
        trouble="", running=True, stopped=(), warnings=(), targets=np.empty((0, 2)),
        edges=tuple(before.edges), directed=before.directed, command=np.zeros((n, 2)),
    )  # fmt: skip
    study.editing.take(study.scenario._replace(topology=Topology(n, chain)))
    study.connection.newest.side_effect = lambda name: status if name == "control" else None
    for is_there, wanted in ((True, before.edges), (False, chain)):
        study.connection.is_fresh.side_effect = lambda name, there=is_there: (
            there and name == "control"
        )
        study.live.follow_control()
        assert sorted(study.map.edges.list) == sorted(wanted)
    # The table of edges, with which the scenario is edited, has them, too.
    assert sorted(study.topology.edges()) == sorted(chain)
