"""Each robot's odometry at its own rate: headless, over ROS, and what cannot be kept is said."""

import json

import numpy as np
import pytest
from ros_fixtures import log_of

from mrs_simulator.ros.receive.odometry_inbox import NEVER, Inbox
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.results.report import read_run
from mrs_simulator.study.run.experiment import Experiment, run_experiment
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.odometry_rates import OdometrySchedule, odometry_notes, odometry_steps
from mrs_simulator.world.world import EVERY, World

KINDS = ("pioneer3dx", "husky", "pioneer3dx")  # 10 Hz, 50 Hz, 10 Hz
POSES = [[0.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 6.0, 0.0]]
CONTENT = {
    "poses": POSES,
    "kind": list(KINDS),
    "odometry_rate": "kinds",
    "duration": 3.0,
    "control": {"protocol": "consensus", "rate": 25},
    "topology": {"preset": "complete"},
}


def test_rates_are_whole_numbers_of_steps_and_others_are_said():
    team = Team(KINDS)
    assert odometry_steps(team, "kinds", 0.02).tolist() == [5, 1, 5]
    assert odometry_steps(team, 30.0, 0.02).tolist() == [2, 2, 2]
    assert odometry_steps(team, 200.0, 0.02).tolist() == [1, 1, 1]
    assert odometry_notes(team, "kinds", 0.02) == [] == odometry_notes(team, None, 0.02)
    notes = odometry_notes(team, 30.0, 0.02)
    assert len(notes) == 3
    assert notes[0] == "robot1: odometry at 25 Hz, every 2 steps of 0.02 s; wanted 30 Hz"
    assert odometry_notes(Team(KINDS * 9), 30.0, 0.02)[-1] == "and of 22 more robots"


def test_who_is_due():
    schedule = OdometrySchedule([5, 1, 5])
    assert schedule.shortest == 1
    assert [schedule.due(k).tolist() for k in (0, 1, 5)] == [[0, 1, 2], [1], [0, 1, 2]]
    assert [OdometrySchedule([3, 3]).due(k).tolist() for k in (0, 1, 3)] == [[0, 1], [], [0, 1]]


def test_between_two_odometries_a_robot_is_where_it_was():
    world = World(KINDS, POSES, limits=None, odometry_rate="kinds")
    seen = []
    for _ in range(12):
        world.set_commands(EVERY, np.tile([0.5, 0.0], (3, 1)))
        world.step()
        seen.append(np.round(world.estimates.pose()[:, 0] / 0.01).astype(int).tolist())
    assert [row[1] for row in seen] == list(range(1, 13))
    assert [row[0] for row in seen] == [0] * 4 + [5] * 5 + [10] * 3
    assert [row[2] for row in seen] == [row[0] for row in seen]
    world.reset()  # which counts anew
    assert world.estimates.pose()[:, 0].tolist() == [0.0] * 3
    with pytest.raises(ValueError):
        world.estimates.pose()[0] = 1.0


def test_a_law_gets_states_of_slow_robots_late():
    rates = [Experiment(scenario_from_dict(dict(CONTENT, odometry_rate=r))) for r in ("kinds", 50)]
    last = []
    for each in rates:
        *_, (_, pose, command) = each.samples()
        last.append((pose, command))
    assert not np.allclose(last[0][0], last[1][0], atol=1e-4)
    plain = {key: value for key, value in CONTENT.items() if key != "odometry_rate"}
    *_, (_, pose, _) = Experiment(scenario_from_dict(plain)).samples()
    np.testing.assert_array_equal(pose, last[1][0])  # 50 Hz is each step


@pytest.mark.parametrize("rate", [0, -1, "often", [10], True])
def test_a_rate_that_cannot_be_is_refused(rate):
    with pytest.raises(ScenarioError, match="odometry_rate: .*wanted"):
        scenario_from_dict(dict(CONTENT, odometry_rate=rate))


def test_a_scenario_keeps_its_rate():
    scenario = scenario_from_dict(CONTENT)
    assert scenario_from_dict(scenario.to_dict()).odometry_rate == "kinds"
    assert "odometry_rate" not in scenario._replace(odometry_rate=None).to_dict()


def test_a_rate_that_is_not_kept_is_a_warning_of_the_run(tmp_path):
    scenario = scenario_from_dict(dict(CONTENT, odometry_rate=30, duration=0.1))
    run_experiment(scenario, str(tmp_path), formats=())
    warnings = json.loads((tmp_path / "run.json").read_text())["warnings"]
    assert any("odometry at 25 Hz" in warning for warning in warnings)


def test_in_lockstep_none_is_waited_for_who_is_not_due():
    inbox = Inbox((1, 2, 3))
    inbox._stamp[:] = [100, 100, 100]
    assert inbox.complete().to_nsec() == 100
    inbox._stamp[1] = 120
    assert inbox.complete() is None  # at one rate all bear one stamp
    inbox.set_periods([100e-9, 20e-9, 100e-9], 20e-9)
    assert inbox.complete().to_nsec() == 120
    inbox._stamp[:] = [100, 200, 100]  # robots 1 and 3 are due
    assert inbox.complete() is None
    inbox._stamp[:] = [200, 200, 100]
    assert inbox.complete() is None
    inbox._stamp[:] = [200, 200, 200]
    assert inbox.complete().to_nsec() == 200
    inbox._stamp[2] = NEVER
    assert inbox.complete() is None


def test_over_ros_each_robot_tells_at_its_own_rate_and_lockstep_repeats_the_experiment(
    ros, tmp_path
):
    scenario = scenario_from_dict(dict(CONTENT, speed=0))
    path = tmp_path / "rates.yaml"
    path.write_text(scenario.to_yaml())
    # The probe listens to the state, too.
    ros.node("stage", "--scenario", path, "_lockstep:=true", "_wait_for_recorders:=2")
    probe = ros.probe()
    for robot in (1, 2, 3):
        probe.ask("listen('/robot{}/odom', Odometry)".format(robot))
    ros.node("pioneer_control", "--scenario", path, "_lockstep:=true")
    record = ros.node("record", "--scenario", path, "--out", tmp_path / "over_ros")
    ros.judged(record, tmp_path / "over_ros")
    # Whatever a late subscriber misses: robots 1 and 3 are due every fifth step, robot 2 at each.
    told = "len(stamps.get({0!r}, ())) > 9 and stamps[{0!r}]"
    steps = [
        np.round(np.array(probe.wait(told.format("/robot{}/odom".format(robot)))) / 0.02)
        for robot in (1, 2, 3)
    ]
    assert not np.any(steps[0] % 5) and not np.any(steps[2] % 5) and np.any(steps[1] % 5)
    over_ros = read_run(str(tmp_path / "over_ros" / "run.csv"))
    run_experiment(scenario, str(tmp_path / "headless"), formats=())
    headless = read_run(str(tmp_path / "headless" / "run.csv"))
    np.testing.assert_allclose(over_ros.pose, headless.pose, atol=1e-6)
    np.testing.assert_allclose(over_ros.command, headless.command, atol=1e-6)


def test_two_rates_are_one_too_many(ros, tmp_path):
    path = tmp_path / "rates.yaml"
    path.write_text(scenario_from_dict(CONTENT).to_yaml())
    stage = ros.node("stage", "--scenario", path, "_odom_rate:=20")
    assert stage.wait(60) == 2
    assert "odom_rate = 20: the scenario's odometry_rate is kinds" in log_of(stage)
