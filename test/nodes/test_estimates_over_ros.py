"""The control node estimates poses as a run without ROS does, and tells them to those who record."""

import json
import xmlrpc.client

import numpy as np
import pytest
import rosbag
import yaml
from mixed_runs import in_gui, run_file
from ros_fixtures import PATIENCE, log_of, wait_until

from mrs_simulator.nodes.record.bag_recording import ESTIMATES, bagged_forms
from mrs_simulator.nodes.record.bag_size import RECORD, size_text, written
from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.study.results.bag_reading import read_bag
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.verdict.estimation import estimation_measures

SAME = 1e-9  # [m, rad] by which estimates over ROS may differ: headings go as quaternions
LEAST_KEPT = 0.6  # [-] of the readings of a sensor that drops a fifth of them
NEAR = {"range": {"stddev": 0.1}}
CONTENT = {
    "poses": [[2.0, 0.0, 0.5], [-1.0, 1.7, 3.0], [-1.0, -1.7, -2.0]],
    "odometry": "wheel",
    "odometry_errors": {"alpha": [0.02, 0, 0, 0.02, 0.002, 0.002]},
    "limits": {"v_max": 0.75, "omega_max": 3.0},
    "control": {"protocol": "displacement_formation", "parameters": {"shape": "circle", "size": 3.0}},
    "topology": {"preset": "ring"},
    "estimates": {"ekf": ["gps", "imu", "beacons"]},
    "sensors": [
        {
            "mounts": {
                "gps": {"type": "gps", "noise": {"stddev": 0.3, "latency": 0.15, "dropout": 0.2}},
                "imu": {"type": "imu", "noise": {"rate": {"stddev": 0.01, "bias": {"stddev": 0.05}}}},
                "beacons": {"type": "beacons", "points": [[9, 0], [0, 9]], "noise": NEAR},
            }
        }
    ],
    "record": ["gps", "imu", "beacons"],
    "record_rate": 50,
    "duration": 1.2,
}  # fmt: skip


@pytest.fixture
def scenario(tmp_path):
    path = tmp_path / "scenario.yaml"
    path.write_text(yaml.safe_dump(CONTENT))
    return path


def test_estimates_over_ros_are_those_without(ros, scenario, tmp_path):
    alone = run_experiment(load_scenario(str(scenario)), str(tmp_path / "alone"), formats=())
    given = ["--scenario", scenario, "_lockstep:=true"]
    bag = ros.node("bag", "--scenario", scenario, "--out", tmp_path)
    record = ros.node("record", "--scenario", scenario, "--out", tmp_path / "over")
    control = ros.node("pioneer_control", *given)
    # Both recorders, and the probe, which subscribes once they receive all that they record.
    waits = "_wait_for_control:=true", "_wait_for_recorders:=3"
    stage = ros.node("stage", *given, *waits)
    loaded = load_scenario(str(scenario))
    items = written(loaded, bagged_forms(loaded), ESTIMATES)
    ros.wait_for_connections("/record_", {item.topic for item in items})
    ros.wait_for_connections("/record", {"/stage/state", ESTIMATES})
    ros.probe()
    verdict = ros.judged(record, tmp_path / "over", 3 * PATIENCE)
    ros.stop(stage)
    run, wanted = (
        read_run_csv(str(tmp_path / out / "run.csv"), load_scenario(str(scenario)))
        for out in ("over", "alone")
    )
    assert len(run.time) == len(wanted.time) == 61
    for name in ("time", "pose", "command", "estimate"):
        np.testing.assert_allclose(
            getattr(run, name), getattr(wanted, name), rtol=0.0, atol=SAME, err_msg=name
        )
    assert np.abs(run.estimate - run.pose)[-1].max() > 1e-3
    for name in ("estimation_error", "heading_error", "largest_estimation_error"):
        assert verdict[name] == pytest.approx(alone[name], abs=SAME) and verdict[name] > 0.0
    assert "Traceback" not in log_of(stage) + log_of(control) + log_of(record)
    bag.send_signal(2)
    bag.wait(PATIENCE)
    check_size(tmp_path / "run.bag", load_scenario(str(scenario)), log_of(bag))
    bagged = read_bag(str(tmp_path / "run.bag"))
    at = np.searchsorted(bagged.time, run.time - 1e-6)
    np.testing.assert_allclose(bagged.estimate[at], run.estimate, rtol=0.0, atol=SAME)


def stamp_in(message):
    """Return the time [s] that ``message`` states."""
    if hasattr(message, "clock"):
        return message.clock.to_sec()
    return getattr(message, "transforms", [message])[0].header.stamp.to_sec()


def check_size(path, scenario, log):
    """Check that a bag is as large as was estimated: rates and lengths of messages, and the file itself."""
    items = written(scenario, bagged_forms(scenario), ESTIMATES)
    assert size_text(items, scenario.duration) in log
    lengths, stamps, wanted = {}, {}, {item.topic for item in items}
    with rosbag.Bag(str(path)) as bag:
        for topic, (_, data, *_, kind), _ in bag.read_messages(raw=True):
            lengths.setdefault(topic, []).append(len(data))
            if topic in wanted:
                stamps.setdefault(topic, set()).add(stamp_in(kind().deserialize(data)))
    for item in items:
        own, when = lengths[item.topic], sorted(stamps[item.topic])
        assert np.mean(own) == pytest.approx(item.length, rel=0.2), item
        # Stamps do not depend on when messages arrive.  A waiting stage repeats the clock and odometry,
        # and readings that are dropped leave gaps.
        assert np.diff(when).min() == pytest.approx(1.0 / item.rate, rel=1e-3), item
        assert len(when) - 1 > LEAST_KEPT * item.rate * (when[-1] - when[0]), item
    assert {"/robot3/imu", "/robot1/beacons", ESTIMATES, "/tf"} <= {item.topic for item in items}
    # Else there are what comes seldom, and definitions of messages, which do not grow with time.
    records = sum(sum(own) + RECORD * len(own) for own in lengths.values())
    assert records <= path.stat().st_size < 1.1 * records + 8000 * len(lengths)


@pytest.mark.processes
def test_a_run_that_the_gui_saves_has_the_estimates_of_a_run_without_ros(scenario, tmp_path):
    wanted = load_scenario(str(scenario))
    run_experiment(wanted, str(tmp_path / "alone"), formats=())
    alone = read_run_csv(str(tmp_path / "alone" / "run.csv"), wanted)
    run = in_gui(wanted, tmp_path)
    with open(tmp_path / "alone" / "run.csv") as one, open(run_file(tmp_path)) as other:
        assert one.readline() == other.readline()
    shared = run.time <= alone.time[-1] + 1e-6
    rows = np.searchsorted(alone.time, run.time[shared] - 1e-6)
    assert len(rows) > 10
    for name in ("time", "pose", "command", "estimate"):
        theirs, ours = getattr(alone, name)[rows], getattr(run, name)[shared]
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=SAME, err_msg=name)
    errors = estimation_measures(run)
    assert errors["estimation_error"] > 1e-3 and not run.meta["warnings"]


def test_of_real_robots_the_record_says_that_the_truth_is_not_known(ros, scenario, tmp_path):
    """A sensor that is silent stops them by its name; poses are the estimates, and no error is told."""
    content = dict(CONTENT, estimates={"ekf": ["imu"]}, duration=0.3)
    scenario.write_text(yaml.safe_dump(content))
    xmlrpc.client.ServerProxy(ros.uri).setParam("/test", "/use_sim_time", False)
    probe = ros.probe()
    probe.ask("[stand_in(n, (0.0, 0.0, 0.0)) for n in (1, 2, 3)]")
    control = ros.node(
        "pioneer_control", "--scenario", scenario, "_autostart:=true", "_frozen_time:=0"
    )
    record = ros.node("record", "--scenario", scenario, "--out", tmp_path / "real")
    probe.wait("'no fresh imu of robot1 (never received), robot2' in (control('trouble') or '')")
    # Commands begin with the readings, and a guard ends them after 2 s: these robots do not move.
    wait_until(lambda: "waiting for the robots' first command" in log_of(record))
    probe.ask("[stand_in_imu(n, 0.0) for n in (1, 2, 3)]")
    facts = tmp_path / "real" / "run.json"
    wait_until(facts.exists)  # as the run begins: the recorder may be killed
    begun = json.loads(facts.read_text())
    assert begun["real"] == [1, 2, 3] and begun["truth_unknown"] and begun["collisions_unknown"]
    out = tmp_path / "real" / "verdict.json"
    wait_until(out.exists)
    verdict = wait_until(lambda: json.loads(out.read_text() or "null"))
    assert any("where the robots truly were is not known" in each for each in verdict["warnings"])
    assert "estimation_error" not in verdict
    run = read_run_csv(str(tmp_path / "real" / "run.csv"), load_scenario(str(scenario)))
    assert run.meta["truth_unknown"] is True
    np.testing.assert_array_equal(run.estimate, run.pose)
    np.testing.assert_allclose(run.pose[0], content["poses"], atol=1e-9)
    assert "Traceback" not in log_of(control)


def test_a_reset_does_not_stall_a_run_in_lockstep_that_waits_for_a_sensor(ros, scenario):
    """What it puts off was due before: time would wait for the control, and the control for time."""
    scenario.write_text(yaml.safe_dump(dict(CONTENT, estimates={"ekf": ["imu"]}, duration=60)))
    given = ["--scenario", scenario, "_lockstep:=true", "_speed:=1"]
    probe = ros.probe()
    ros.node("pioneer_control", *given)
    ros.node("stage", *given, "_wait_for_control:=true", "_lockstep_timeout:=0.5")
    probe.wait_simulated(0.2)
    assert probe.ask("call('/stage/reset', Trigger)")[0]
    probe.wait_simulated(0.2)
