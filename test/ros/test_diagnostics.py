"""What nodes tell of themselves on /diagnostics."""

import pytest

from mrs_simulator.ros.node import diagnostics
from mrs_simulator.ros.node.diagnostics import ERROR, OK, WARN, Health, Rates
from mrs_simulator.study.run.preflight import Check

STAGE = {
    "paused": False,
    "speed": 1.0,
    "real_time_factor": 1.0,
    "missed_periods": 0,
    "command_periods": 100,
    "waiting_for": [],
    "timed_out": [],
    "real_silent": [],
    "trouble": "",
    "robots": 7,
    "collisions": 0,
    "refused": [0, 2],
}
CONTROL = {
    "protocol": "formation",
    "period": 0.02,
    "compute_time": 1e-3,
    "latency": 2e-3,
    "missed_periods": 0,
    "running": True,
    "trouble": "",
    "stopped": [],
    "warnings": [],
    "refused": [0, 1],
}


@pytest.mark.parametrize(
    "change, level, said",
    [
        ({}, OK, "running"),
        ({"paused": True, "real_time_factor": 0.0}, OK, "paused"),
        ({"speed": 0.0, "real_time_factor": 31.0}, OK, "running"),
        ({"real_time_factor": 0.62}, WARN, "simulated time at 0.62, wanted 1"),
        ({"missed_periods": 12}, WARN, "12% of command periods without a command"),
        ({"timed_out": [3]}, WARN, "1 robot without commands stand"),
        ({"real_silent": [3]}, WARN, "1 real robots are silent"),
        ({"trouble": "a and b publish /clock"}, ERROR, "a and b publish /clock"),
    ],
)
def test_the_stage_tells_how_it_is(change, level, said):
    health = diagnostics.stage_health(dict(STAGE, **change))
    assert (health.level, health.message) == (level, said)
    assert health.values["robots"] == 7 and health.values["refused_commands"] == 2


@pytest.mark.parametrize(
    "change, level, said",
    [
        ({}, OK, "running"),
        ({"running": False}, WARN, "not started"),
        ({"running": False, "trouble": "stopped by request"}, WARN, "stopped by request"),
        ({"trouble": "no fresh sonar of robot2"}, ERROR, "no fresh sonar of robot2"),
        ({"stopped": [2]}, ERROR, "stopped: robots [2]"),
        ({"warnings": ["k is large"]}, WARN, "k is large"),
    ],
)
def test_the_control_tells_how_it_is(change, level, said):
    health = diagnostics.control_health(dict(CONTROL, **change))
    assert (health.level, health.message) == (level, said)
    assert health.values["latency"] == 2e-3 and health.values["refused_messages"] == 1


def test_a_preflight_tells_what_is_not_ok():
    assert diagnostics.preflight_health(None, [3])[1:3] == (OK, "listening")
    good, bad = Check("robot1 publishes", True, ""), Check("robot3 publishes", False, "silent")
    assert diagnostics.preflight_health([good], [])[1:3] == (OK, "ready")
    health = diagnostics.preflight_health([good, bad], [3])
    assert health[1:3] == (ERROR, "1 of 2 checks not OK")
    assert health.values == {"silent_robots": 1, "checks": 2, "not OK 1": "robot3 publishes"}


def test_rates_are_of_the_last_few_looks():
    times = iter([10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0])
    rates = Rates(clock=lambda: next(times))
    assert rates.of({"a": 100}) == {"a": 0.0}
    assert rates.of({"a": 110})["a"] == pytest.approx(10.0)
    for count in (120, 130, 140, 150):
        rates.of({"a": count})
    assert rates.of({"a": 150, "b": 5}) == {"a": pytest.approx(8.0), "b": pytest.approx(1.0)}
    assert rates.window == 5.0


def test_a_sensor_is_slow_by_more_than_one_message():
    heard, wanted = {"a": 8.7, "b": 8.9, "c": 0.8}, {"a": 10.0, "b": 10.0, "c": 1.0}
    assert diagnostics.too_slow(heard, wanted, 5.0) == ["a: 8.7 Hz, wanted 10"]
    assert diagnostics.too_slow({"a": 0.0}, wanted, 0.0) == []  # time stands still


def test_parts_of_a_node_are_named_and_values_are_texts(monkeypatch):
    monkeypatch.setattr(diagnostics.rospy, "get_rostime", lambda: diagnostics.rospy.Time(3))
    sensors = diagnostics.sensors_health({"sonar": 9.98765432}, ["sonar: late"])
    message = diagnostics.array("stage", [Health("", OK, "running", {"n": 7}), sensors])
    first, second = message.status
    assert (first.name, first.hardware_id, first.message) == ("stage", "stage", "running")
    assert [(each.key, each.value) for each in first.values] == [("n", "7")]
    assert (second.name, second.level, second.message) == ("stage: sensors", WARN, "sonar: late")
    assert second.values[0].value == "9.98765" and message.header.stamp.secs == 3
