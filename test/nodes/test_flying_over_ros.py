"""Robots that fly over ROS: a law of space in lockstep, and the emergency stop."""

import numpy as np
from ros_fixtures import log_of, ros  # noqa: F401  a fixture

from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import run_experiment


def team(speed=0.0, **control):
    content = {
        "model": "crazyflie2",
        "poses": [[0.0, 0.0, 0.3], [2.0, 0.5, -1.0], [0.5, 2.0, 2.0]],
        "altitude": [0.8, 1.5, 2.0],
        "control": dict({"rate": 20, "dimension": 3}, **control),
        "topology": {"preset": "complete"},
        "duration": 3.0,
        "speed": speed,
    }
    return scenario_from_dict(content)


def record_in_lockstep(ros, tmp_path, scenario):  # noqa: F811
    """Run ``scenario`` over ROS in lockstep; its record is left in ``tmp_path / "out"``."""
    path = tmp_path / "team.yaml"
    path.write_text(scenario.to_yaml())
    ros.node("stage", "--scenario", path, "_lockstep:=true", "_wait_for_recorders:=1")
    ros.node("pioneer_control", "--scenario", path, "_lockstep:=true")
    record = ros.node("record", "--scenario", path, "--out", tmp_path / "out")
    ros.judged(record, tmp_path / "out")


def test_a_team_takes_off_flies_as_without_ros_and_a_lost_rotor_is_recorded(ros, tmp_path):  # noqa: F811
    scenario = team(protocol="displacement_formation", parameters={"gain": 0.2, "shape": "grid"})
    event = {"at": 2.0, "robot": 3, "event": "rotor_lost", "rotor": 1}
    scenario = scenario.changed(takeoff=True, events=[event])
    record_in_lockstep(ros, tmp_path, scenario)
    run_experiment(scenario, str(tmp_path / "headless"), formats=())
    run, alone = (
        read_run_csv(str(tmp_path / name / "run.csv"), scenario) for name in ("out", "headless")
    )
    np.testing.assert_allclose(run.spatial.z[0], scenario.altitude, atol=0.02)
    before = np.count_nonzero(run.time < 1.8)
    assert before > 15 and np.ptp(run.points[:before, 0, 2]) > 0.1
    np.testing.assert_allclose(run.points[:before], alone.points[:before], atol=1e-6)
    (incident,) = run.meta["incidents"]
    assert incident.text == "robot3 lost rotor 1" and abs(incident.time - 2.0) < 0.2
    fallen = run.spatial.z[-1] < 0.7 * scenario.altitude
    assert fallen.tolist() == [False, False, True]


def test_the_emergency_stop_lands_the_team(ros, tmp_path):  # noqa: F811
    path = tmp_path / "team.yaml"
    path.write_text(team(speed=5.0, protocol="consensus", parameters={"gain": 0.01}).to_yaml())
    ros.node("stage", "--scenario", path)
    probe = ros.probe()
    ros.node("pioneer_control", "--scenario", path)
    probe.wait("control('running') and state('z') and min(state('z')) > 0.5")
    probe.ask("press(True)")
    probe.wait("control('trouble') == 'emergency stop' and max(state('z')) < 1.5")
    probe.ask("press(True)")
    probe.wait("max(state('z')) == 0.0")
    probe.wait_simulated(1.0)
    assert probe.ask("max(state('z'))") == 0.0
