"""Status texts and enabled actions, from what was received."""

from types import SimpleNamespace

import numpy as np
import pytest
from protocol_fixtures import shipped
from snapshots import snapshot_of

from mrs_simulator.rqt_plugin.run.study_state import StudyState
from mrs_simulator.scenario.network.links import Links
from mrs_simulator.study.run.law_answers import prediction

STAGE = SimpleNamespace(fidelity="kinematic", paused=False, real_time_factor=1.0, speed=1.0)
RUNNING = SimpleNamespace(running=True, trouble="", protocol="Formation")
STOPPED = SimpleNamespace(running=False, trouble="emergency stop", protocol="Formation")


def snapshot(n=3, stale=(), real=()):
    numbers = tuple(range(1, n + 1))
    fresh = np.array([number not in stale for number in numbers])
    zeros = np.zeros((n, 3))
    return snapshot_of(2.5, numbers, zeros, zeros, zeros[:, :2], fresh, frozenset(real))


class Link:
    """What was received: all of it is fresh."""

    def __init__(self, master_online=True, snapshot=None, topics=None, **received):
        self.master_online, self._snapshot, self._topics = master_online, snapshot, topics or {}
        self._received = received

    registered, absent = frozenset(), {}
    silent = None  # [s] for which the controller said nothing

    def silence(self, name):
        return self.silent if self.silent is not None else 0.0 if name in self._received else None

    def newest(self, name):
        return self._received.get(name)

    def is_fresh(self, name):
        return name in self._received

    def snapshot(self):
        return self._snapshot

    def odometry_topics(self):
        return self._topics


def state(checking=False, started=(), ending=(), **received):
    preflight = SimpleNamespace(running=checking, starting=checking)
    processes = SimpleNamespace(
        is_running=lambda name: name in started,
        is_ending=lambda name: name in ending,
        age=lambda name: 30.0,
    )
    return StudyState(Link(**received), processes, preflight)


@pytest.mark.parametrize(
    "shown, said",
    [
        (snapshot(), (True, "3 robots")),
        (snapshot(1), (True, "1 robot")),
        (snapshot(4, real=[2]), (True, "robots: 3 simulated, 1 real")),
        (snapshot(4, stale=[1, 3], real=[1, 2, 3, 4]), (False, "robots: 4 real, 2 stale")),
        (None, (None, "no robots")),
    ],
)
def test_the_robots_in_the_status_line(shown, said):
    assert state(snapshot=shown).lines()["robots"] == said


def test_the_controller_in_the_status_line():
    def said(pressed, control=STOPPED):
        return state(control=control, emergency=pressed).lines()["controller"]

    assert said(True) == (False, "controller: emergency stop")
    assert said(False) == (None, "controller: stopped; emergency stop released: press Start")
    assert said(False, RUNNING) == (True, "controller: Formation")
    assert "checked" in state(checking=True).lines()["controller"][1]


def test_no_time_where_there_is_none():
    assert state().lines()["time"] == (None, "")
    assert state(snapshot=snapshot()).lines()["time"] == (None, "t = 2.5 s")
    fast = SimpleNamespace(**dict(vars(STAGE), speed=2.0, real_time_factor=2.0))
    assert (
        state(snapshot=snapshot(), stage=fast).lines()["time"][1]
        == "t = 2.5 s, 2.0 \u00d7 real time"
    )
    paused = SimpleNamespace(**dict(vars(fast), paused=True))
    assert state(snapshot=snapshot(), stage=paused).lines()["time"] == (True, "t = 2.5 s")
    good, text = state(snapshot=snapshot(real=[1]), stage=fast).lines()["time"]
    assert good is False and "real robots run at 1" in text


@pytest.mark.parametrize(
    "given, why",
    [
        (dict(master_online=False, snapshot=snapshot()), "no ROS master"),
        (dict(), "no robots: start the simulation, or the robots' drivers"),
        (dict(snapshot=snapshot(stale=[2])), "no recent data of robot2"),
        (dict(snapshot=snapshot(), control=RUNNING), "a controller runs"),
        (dict(snapshot=snapshot(), emergency=True), "release the emergency stop first"),
        (dict(snapshot=snapshot(), checking=True), "a check is under way"),
        (dict(snapshot=snapshot(), ending=["control"]), "the last controller is ending"),
        (dict(snapshot=snapshot(), stage=STAGE), ""),
        (dict(snapshot=snapshot(real=[1]), topics={1: "/robot1/odom"}), ""),
        (
            dict(snapshot=snapshot(real=[1]), topics={1: "/robot1/pose"}),
            "odometry on /robot1/pose: start the controller with the launch file "
            "that sets this topic",
        ),
        (dict(snapshot=snapshot(real=[1]), topics={1: "/robot1/pose"}, control=STOPPED), ""),
    ],
)
def test_a_start_that_is_not_possible_says_why(given, why):
    assert state(**given).no_start() == why
    assert state(**given).actions()["control"][0] is (not why)


def test_real_robots_alone_offer_no_simulation():
    actions = state(snapshot=snapshot(real=[1, 2, 3])).actions()
    for name in ("simulate", "pause", "step", "reset", "speed"):
        assert not actions[name][0] and "real" in actions[name][1], name
    assert actions["control"] == (True, "the robots are checked first: some are real")
    assert actions["preflight"][0] and actions["bag"][0] and actions["save"][0]
    assert "real" in state(snapshot=snapshot(real=[1])).team_locked()
    assert state(snapshot=snapshot(real=[1]), stage=STAGE).team_locked() == ""


def test_nothing_yet_offers_the_speed_to_begin_with():
    actions = state().actions()
    assert actions["speed"] == (True, "") and actions["simulate"] == (True, "")
    assert actions["pause"] == (False, "no simulation runs")
    assert actions["step"][0] is False and actions["end"] == (
        False,
        "no simulation was started here",
    )


def test_another_number_of_robots_than_the_scenarios_is_not_dragged():
    received = dict(state=SimpleNamespace(), stage=STAGE, snapshot=snapshot(10))
    assert "10 robots run, the scenario has 7" in state(**received).poses_locked(7)
    assert (
        state(**received).poses_locked(10)
        == state(started=["stage"], **received).poses_locked(7)
        == ""
    )


def test_no_simulation_starts_beside_one_that_is_ending():
    ending = state(ending=["stage"], stage=STAGE, snapshot=snapshot())
    assert ending.actions()["simulate"] == (False, "the last simulation is ending")


def test_a_partly_real_team_shows_what_reset_and_speed_do_not_affect():
    actions = state(snapshot=snapshot(real=[2]), stage=STAGE).actions()
    assert actions["reset"] == (True, "real robots stay where they are: robot2")
    assert actions["speed"][0] and "1 \u00d7" in actions["speed"][1]
    assert state(snapshot=snapshot(), stage=STAGE).actions()["reset"] == (True, "")
    assert actions["step"] == (False, "pause the simulation first")


@pytest.mark.parametrize("name, known", [("formation_switching", True), ("formation_lossy", False)])
def test_the_predicted_error_knows_the_faults_of_the_edges(name, known):
    faulty, perfect = shipped(name), shipped(name)._replace(links=Links())
    (time, error, _), (_, without, _) = map(prediction, (faulty, perfect))
    assert (error is not None) == known
    if known:
        assert len(error) == len(time) and error[0] == pytest.approx(without[0])
        assert np.abs(error - without).max() > 0.05 * error[0]


def test_a_controller_that_says_nothing_is_not_no_controller():
    hanging = state(snapshot=snapshot(), started=["control"], control=RUNNING)
    assert hanging.hangs() == ""
    hanging.connection.silent = 7.4
    hanging.connection._received = {}
    assert hanging.lines()["controller"] == (False, "controller: has not answered for 7 s")
    possible, why = hanging.actions()["control"]
    assert not possible and "has not answered for 7 s: end it first" in why
    assert hanging.actions()["stop"][0]
    ended = state(snapshot=snapshot())  # and its node is gone from the master
    ended.connection.silent = 7.4
    assert ended.hangs() == "" and ended.lines()["controller"] == (None, "no controller")
    ended.connection.registered = {"control"}  # it was started elsewhere
    assert "7 s" in ended.hangs()
    assert "since it started 30 s ago" in state(started=["control"]).hangs()
