"""A look ahead from a moment of a run: the run itself where nothing is changed, and what is kept of it."""

import numpy as np
import pytest
from protocol_fixtures import shipped

from mrs_simulator.record.run_changes import Change, controller_settings, to_plain
from mrs_simulator.scenario.incidents import PUSHED
from mrs_simulator.scenario.reading import read_json
from mrs_simulator.study.results.report import read_run
from mrs_simulator.study.run import ahead
from mrs_simulator.study.run.ahead import Edit, keep_ahead, look_ahead, look_further, prepare_ahead
from mrs_simulator.study.run.experiment import Experiment, played

SCENARIO = shipped("paper_four")._replace(duration=6.0)
ROW = 25  # of the sample from which on things are otherwise


@pytest.fixture(scope="module")
def run():
    samples = list(Experiment(SCENARIO._replace(duration=9.0)).samples())
    return [np.array(column) for column in zip(*samples)]


@pytest.fixture(autouse=True)
def no_run_is_known():
    ahead._RUN.clear()


def edit(run, **changes):
    return Edit(float(run[0][ROW]), run[1][ROW], {}, {})._replace(**changes)


def test_without_a_change_a_run_goes_on_to_its_own_bits_beyond_its_end(run):
    key = ("run",)
    calls = 1
    while not prepare_ahead(SCENARIO, key, [], 2.5, 0.0):  # however little time there is
        calls += 1
    assert 2 <= calls <= ahead.SNAPSHOTS
    future = look_ahead(SCENARIO, key, [], edit(run), 0.0)
    assert not future.is_whole
    while not future.is_whole:
        future = look_further(SCENARIO, 0.05)
    assert future.time.tolist() == run[0][ROW : ROW + len(future.time)].tolist()
    np.testing.assert_array_equal(future.pose, run[1][ROW : ROW + len(future.time)])
    assert future.time[-1] == pytest.approx(SCENARIO.duration) and len(future.error) == 36


def test_robots_gains_and_edges_are_otherwise_from_that_moment_on(run):
    whole = [look_ahead(SCENARIO, ("run",), [], edit(run), 60.0)]
    for change in (
        {"places": {1: (3.0, 3.0)}},
        {"parameters": {"k": 0.05}},
        {"topology": ([(1, 2, 1.0)], True)},
    ):
        whole.append(look_ahead(SCENARIO, ("run",), [], edit(run, **change), 60.0))
    assert whole[1].pose[0, 1, :2].tolist() == [3.0, 3.0]
    np.testing.assert_array_equal(whole[2].pose[0], run[1][ROW])
    ends = [future.pose[-1] for future in whole]
    assert min(np.abs(end - ends[0]).max() for end in ends[1:]) > 0.05
    np.testing.assert_array_equal(  # and afterwards it is the run again
        look_ahead(SCENARIO, ("run",), [], edit(run), 60.0).pose, whole[0].pose
    )


def test_changes_of_the_run_before_the_moment_are_made(run):
    gains = controller_settings(SCENARIO)["control"]
    change = Change(1.0, "control", {**gains, "parameters": {**gains["parameters"], "k": 0.05}})
    moments = ahead.Moments(SCENARIO, [change])
    assert np.abs(moments.at(2.5).world.pose - run[1][ROW]).max() > 0.01
    assert moments.at(0.9).world.pose.tolist() == run[1][9].tolist()
    assert to_plain([change])


def test_a_look_that_is_kept_is_a_run_whose_pushes_are_events_of_its_scenario(run, tmp_path):
    wanted = edit(run, places={0: (8.0, -3.0)}, parameters={"k": 0.05})
    future = look_ahead(SCENARIO, ("run",), [], wanted, 60.0)
    keep_ahead(SCENARIO, [], wanted, str(tmp_path / "kept"))
    kept = read_run(str(tmp_path / "kept"))
    assert kept.pose[: ROW + 1].tolist() == run[1][: ROW + 1].tolist()
    np.testing.assert_allclose(kept.pose[-1], future.pose[-1], atol=1e-12)
    (event,) = kept.scenario.events
    assert (event.event, event.robot, event.at) == (PUSHED, 1, pytest.approx(2.5))
    assert [change.key for change in kept.meta["changes"]] == ["control"]
    kept_files = {"verdict.json", "trajectories.png", "trajectories.pdf"}
    assert kept_files < {path.name for path in (tmp_path / "kept").iterdir()}
    # Its scenario alone makes the push, too.
    pushed = kept.scenario._replace(duration=3.0)
    found = played(pushed)[0].pose
    assert found[: ROW + 1].tolist() == kept.pose[: ROW + 1].tolist()
    assert np.hypot(*(found[ROW + 1, 0, :2] - [8.0, -3.0])) < 0.2


def test_a_look_with_an_edge_less_is_kept_as_a_run_that_obeys_its_law(tmp_path, monkeypatch):
    monkeypatch.setattr("mrs_simulator.study.draw.figures.figures", lambda *_: [])
    path = str(tmp_path / "kept")
    scenario = shipped("displacement_formation")._replace(duration=12.0)
    at = ahead.Moments(scenario).at(1.0).world.pose.copy()
    keep_ahead(scenario, [], Edit(1.0, at, {}, {}, ([*scenario.topology.edges[1:]], False)), path)
    checks = {each["name"]: each for each in read_json(path + "/verdict.json")["checks"]}
    followed = [check for name, check in checks.items() if "law" in name]
    assert "changed during the run: edges" in followed[0]["note"]
    assert [check["name"] for check in followed if not check["passed"]] == []


def test_what_cannot_be_looked_at_is_refused(run, tmp_path):
    with pytest.raises(ValueError, match="fidelity dynamic, wanted one of point_mass or kinematic"):
        ahead.Moments(SCENARIO._replace(fidelity="dynamic"))
    with pytest.raises(ValueError, match="at 9.5 s: wanted a moment within the first 9 s"):
        prepare_ahead(SCENARIO, ("run",), [], 9.5, 1.0)
    elsewhere = run[1][ROW] + [0.0, 0.2, 0.0] * np.array([[0], [0], [1], [0]])
    with pytest.raises(ValueError, match="robot3 was 0.2 m elsewhere at 2.50 s"):
        keep_ahead(SCENARIO, [], edit(run, recorded=elsewhere), str(tmp_path))
    future = look_ahead(SCENARIO, ("run",), [], edit(run, recorded=elsewhere), 60.0)
    assert future.pose[0].tolist() == elsewhere.tolist()  # which is looked ahead of all the same
