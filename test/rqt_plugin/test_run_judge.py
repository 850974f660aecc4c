"""A run is asked about while it goes on, and judged once when it is over."""

from types import SimpleNamespace
from unittest import mock

import numpy as np
import pytest
from protocol_fixtures import shipped
from ros_fixtures import wait_until
from snapshots import snapshot_of

from mrs_simulator.rqt_plugin.run import run_judge
from mrs_simulator.rqt_plugin.run.history import History
from mrs_simulator.rqt_plugin.run.run_judge import RunJudge
from mrs_simulator.rqt_plugin.window.course import Course
from mrs_simulator.scenario.requirements import Requirement
from mrs_simulator.study.run.run_so_far import standings_of

SCENARIO = shipped("consensus")


@pytest.fixture
def judge(monkeypatch):
    monkeypatch.setattr(run_judge, "PERIOD", 0.0)
    study, history = mock.Mock(), History()
    study.is_controlled.return_value = True
    study.edited.ask_apart.side_effect = lambda function, scenario, *given: (function, given)
    study.files.writing.return_value = lambda: None
    return SimpleNamespace(of=RunJudge(study, history), study=study, history=history)


def add(history, times):
    n = SCENARIO.n
    for time in times:
        pose = SCENARIO.poses + [0.1 * time, 0.0, 0.0]
        command, fresh = np.full((n, 2), 0.1), np.ones(n, dtype=bool)
        numbers = tuple(range(1, n + 1))
        history.append(snapshot_of(time, numbers, pose, np.zeros((n, 3)), command, fresh))


def answer(judge, ran=(SCENARIO, {})):
    judge.of.follow(ran)
    return wait_until(judge.of.take)


def test_a_run_is_asked_about_and_then_judged_once(judge):
    judge.of.follow((SCENARIO, {}))  # nothing has moved yet
    add(judge.history, [2.0, 2.1, 2.2])
    function, (so_far,) = answer(judge).standings
    assert function == "standings_of" and so_far.time.tolist() == pytest.approx([0.0, 0.1, 0.2])
    judge.of.follow((SCENARIO, {}))
    assert judge.of._waits is None  # nothing new
    add(judge.history, [SCENARIO.duration + 2.0])
    said = answer(judge)
    assert said.verdict[0] == "verdict_on" and said.time == pytest.approx(SCENARIO.duration)
    add(judge.history, [SCENARIO.duration + 3.0])  # which goes on
    judge.of.follow((SCENARIO, {}))
    assert judge.of._waits is None
    judge.study.is_controlled.return_value = False
    assert answer(judge).verdict


def test_how_a_run_stood_is_not_shown_any_more_once_it_is_over(judge):
    panels, opened = mock.Mock(), SimpleNamespace(run=None)
    live = SimpleNamespace(ran=(SCENARIO, {}))
    course = Course(panels, judge.study, judge.history, live, opened)
    add(judge.history, [2.0, 2.1, 2.2])

    def shown():
        course.follow()
        return panels.verdict.set_standings.called

    wait_until(shown)
    panels.verdict.set_standings.reset_mock()
    add(judge.history, [2.3])
    course._judge.follow(live.ran)  # asked in time
    add(judge.history, [SCENARIO.duration + 2.0])  # and answered late

    def judged():
        course.follow()
        return panels.verdict.set_verdict.called

    wait_until(judged)
    assert not panels.verdict.set_standings.called


def test_an_answer_on_a_run_that_is_gone_is_dropped_and_an_unknown_law_is_not_asked(judge):
    add(judge.history, [0.0, 0.1, 0.2])
    judge.of.follow((SCENARIO, {"unknown_law": "Mine"}))
    assert judge.of._waits is None
    judge.of.follow((SCENARIO, {}))
    judge.history.clear()
    assert wait_until(lambda: judge.of.take() is None and judge.of._waits is None)


def test_long_runs_of_many_are_thinned_and_the_samples_say_what_is_asked(judge):
    add(judge.history, np.arange(0.0, 200.0, 0.1))
    judge.study.edited.ask_apart.side_effect = None
    long = SCENARIO._replace(duration=1000.0)
    so_far = judge.of._so_far({"changes": []})
    assert len(so_far.time) == run_judge.MOST_SAMPLES and so_far.time[-1] == pytest.approx(199.9)
    long = long._replace(requirements=(Requirement("near", "always each pair(distance < 1 m)"),))
    rows = {row["name"]: row for row in standings_of(long, so_far)}
    assert rows["drift of w^T p [m]"]["standing"] == "failing"  # all go one way
    assert rows["near"]["standing"] == "failing" and "by robot1 and robot" in rows["near"]["note"]


@pytest.mark.parametrize("real", [(), (1,), (1, 2)], ids=["simulated", "mixed", "real"])
def test_real_robots_stand_by_what_their_drivers_measure_as_in_the_verdict(judge, real):
    scenario = (
        SCENARIO._replace(topology=None)
        .with_robots(2)
        ._replace(
            requirements=(
                Requirement("slow", "always each robot(speed < 0.25 m/s)"),
                Requirement("straight", "always each robot(abs(turn_rate) < 0.1 rad/s)"),
                Requirement("free", "always contacts <= 0"),
            )
        )
    )
    for step in range(31):  # of 15 poses a second samples at 10 Hz leave out every third
        place = np.floor(0.1 * step * 15) / 15 * 0.2
        pose = scenario.poses + [place, 0.0, place * 0.45]
        twist, flags = np.full((2, 3), [0.2, 0.0, 0.09]), np.ones(2, dtype=bool)
        command = np.full((2, 2), 0.2)
        time = 1.0 + len(real) + 0.1 * step  # by when it began runs are told apart
        judge.history.append(snapshot_of(time, (1, 2), pose, twist, command, flags, real))
    rows = {row["name"]: row for row in standings_of(scenario, judge.of._so_far({}))}
    fail = [name for name, row in rows.items() if row["standing"] == "failing"]
    moves = {"slow", "straight"}  # what is simulated does as its poses say
    assert moves.intersection(fail) == (set() if len(real) == 2 else moves), rows
    if len(real) == 1:
        assert "by robot2" in rows["slow"]["note"]
    unknown = "nothing reports collisions of real robots"
    assert (rows["free"]["note"] == unknown) == (len(real) == 2)
