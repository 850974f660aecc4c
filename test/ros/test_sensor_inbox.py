"""Readings that come over ROS: their stamps, what is stale, and what is waited for in lockstep."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import rospy
from std_msgs.msg import Float32, Float64, Header, Int8

from mrs_simulator.ros.message_forms.sensor_forms.cloud import Cloud
from mrs_simulator.ros.receive import sensor_inbox
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.vehicles import Team

SETTINGS = {"sensor_topic": "/robot{}/RosAria/*", "sensor_timeout": 0.5}


class Times:
    """Simulated and wall time, which the test sets."""

    simulated, wall = 1.0, 100.0


@pytest.fixture
def times(monkeypatch):
    monkeypatch.setattr(sensor_inbox.rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(sensor_inbox.rospy, "get_time", lambda: Times.simulated)
    now = lambda: rospy.Time.from_sec(Times.simulated)  # noqa: E731
    monkeypatch.setattr(sensor_inbox.rospy, "get_rostime", now)
    monkeypatch.setattr(sensor_inbox.time, "monotonic", lambda: Times.wall)
    monkeypatch.setattr(sensor_inbox, "clock_at", lambda stamp, timeout: Times.simulated)
    monkeypatch.setattr(sensor_inbox, "read", lambda parameter: SETTINGS[parameter.name])
    Times.simulated, Times.wall = 1.0, 100.0
    return Times


def inbox_of(real=(), noise=None, names=("sonar",), kept=()):
    content = {"poses": [[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]], "step": 0.02}
    more = {"sonar": {"noise": noise or {}}, "imu": {"type": "imu", "rate": 10.0}}
    scenario = scenario_from_dict(dict(content, sensors=[{"mounts": more}]))
    team = Team.from_scenario(scenario)
    mounts = fitted_mounts(team, scenario.sensors)
    return sensor_inbox.SensorInbox(names, mounts, team.kinds, real, scenario.step, kept=kept)


def put(inbox, row, stamp, count=16):
    inlet = inbox._inlets[row]
    places = inlet.form._places[:count]
    along = np.column_stack([np.cos(places[:, 2]), np.sin(places[:, 2]), 0.0 * places[:, 2]])
    points = np.column_stack([places[:, :2], np.zeros(count)]) + 2.0 * along
    header = Header(0, rospy.Time.from_sec(stamp), "sonar")
    inbox.put(Cloud(header, points.astype(np.float32)), inlet)


def test_topics_follow_the_pattern(times):
    assert [i.topics[0] for i in inbox_of()._inlets] == [
        "/robot{}/RosAria/sonar".format(k) for k in (1, 2)
    ]
    SETTINGS["sensor_topic"] = "/robot{}/sonar"
    with pytest.raises(ValueError, match="wanted one \\* for the sensor's name"):
        inbox_of()
    SETTINGS["sensor_topic"] = "/robot{}/RosAria/*"


def test_readings_are_stamped_since_the_law_began(times):
    inbox = inbox_of()
    assert inbox.readings(1.0) == {0: {}, 1: {}}
    put(inbox, 1, 1.3)
    times.simulated = 1.3
    readings = inbox.readings(1.0)
    assert readings is inbox.readings(1.0) and readings[0] == {}
    assert readings[1]["sonar"].stamp == pytest.approx(0.3, abs=2e-9)
    assert readings[1]["sonar"].ranges == pytest.approx([2.0] * 16, abs=4e-7)
    with pytest.raises(ValueError, match="read-only"):  # the safety filter goes by it, too
        readings[1]["sonar"].ranges[:] = 9.0
    put(inbox, 1, 1.4)
    assert inbox.readings(1.0)[1]["sonar"].stamp == pytest.approx(0.4, abs=2e-9)


def test_what_an_estimator_asks_for_is_kept_until_it_is_taken(times):
    inbox = inbox_of(kept=("sonar",))
    for row, stamp in ((1, 1.1), (0, 1.1), (0, 1.2), (0, 1.2)):  # the last one again
        times.simulated = stamp
        put(inbox, row, stamp)
    taken = [(stamp, name, [row for row, _ in heard]) for stamp, name, heard in inbox.take()]
    first, second = (rospy.Time.from_sec(stamp).to_nsec() for stamp in (1.1, 1.2))
    assert taken == [(first, "sonar", [0, 1]), (second, "sonar", [0])]
    assert inbox.take() == [] and inbox.readings(1.0)[0]["sonar"].stamp == pytest.approx(0.2)
    others = inbox_of()
    put(others, 0, 1.2)
    assert others.take() == []  # a law wants the newest alone


def test_what_is_silent_or_refused_is_named(times):
    inbox = inbox_of()
    assert (
        inbox.missing(1.0) == "no fresh sonar of robot1 (never received), robot2 (never received)"
    )
    put(inbox, 0, 1.0)
    put(inbox, 1, 1.0, count=8)
    wanted = "robot2 (never received, refused: 8 echoes, but the mount has 16 transducers)"
    assert inbox.missing(1.1) == "no fresh sonar of " + wanted
    put(inbox, 1, 1.0)
    assert inbox.missing(1.5) == "" and inbox.stale(1.5) == []
    assert inbox.missing(1.6).startswith("no fresh sonar of robot1 (0.6 s), robot2 (0.6 s)")
    assert inbox.stale(1.6) == [0, 1]
    times.simulated = 3.0
    put(inbox, 0, 1.2)
    assert "refused: stamped 1.8 s before the simulated time" in inbox.missing(3.0)


def test_a_slow_sensor_may_be_silent_for_two_periods_and_a_half(times):
    inbox = inbox_of(noise={"latency": 0.3})
    assert [inlet.timeout for inlet in inbox._inlets] == pytest.approx([0.8, 0.8])
    slow = sensor_inbox._Inlet(0, inbox._inlets[0].form.mount, None, False, 1.0, 0.5)
    assert slow.timeout == pytest.approx(2.8)


def test_clocks_of_real_robots_may_be_any(times):
    inbox = inbox_of(real=(0, 1))
    times.simulated = 5000.0  # the node's own, wall time
    for k in range(8):
        times.wall, times.simulated = 100.0 + 0.1 * k, 5000.0 + 0.1 * k
        put(inbox, 0, 70.0 + 0.1 * k)
    assert inbox.readings(5000.0)[0]["sonar"].stamp == pytest.approx(0.7, abs=1e-6)
    assert inbox.stale(times.simulated) == [1]
    put(inbox, 0, 70.0 + 0.1 * 7)  # the link is lost: the same stamp again
    times.wall += 0.6
    assert "robot1 (0.6 s, refused: its stamp stands still)" in inbox.missing(times.simulated)


def test_a_real_robots_battery_is_published_on_several_topics(times):
    mounts = {"battery": {"type": "battery", "rate": 10.0}}
    scenario = scenario_from_dict({"poses": [[0, 0, 0]], "sensors": [{"mounts": mounts}]})
    team = Team.from_scenario(scenario)
    known = ("battery",), fitted_mounts(team, scenario.sensors), team.kinds
    (inlet,) = sensor_inbox.SensorInbox(*known, step=0.02)._inlets
    assert inlet.topics == ["/robot1/RosAria/battery"]  # of a simulated robot
    inbox = sensor_inbox.SensorInbox(*known, real=(0,))
    (inlet,) = inbox._inlets
    ends = "battery", "battery_voltage", "battery_state_of_charge", "battery_recharge_state"
    assert inlet.topics == ["/robot1/RosAria/" + end for end in (*ends, "battery_state")]
    inbox.put(Int8(-1), inlet, 3)
    assert inbox.readings(1.0)[0] == {} and inbox.stale(1.0) == [0]
    for part, message in ((3, Int8(1)), (1, Float64(12.5)), (2, Float32(0.5)), (1, Float64(12.4))):
        times.simulated, times.wall = times.simulated + 0.1, times.wall + 0.1
        inbox.put(message, inlet, part)
    reading = inbox.readings(1.0)[0]["battery"]
    assert (reading.voltage, reading.charge, reading.charging) == (12.4, 0.5, True)
    assert reading.stamp == pytest.approx(0.4) and inbox.stale(times.simulated) == []


def test_lockstep_waits_for_what_was_measured(times):
    inbox = inbox_of()
    assert "never received" in inbox.awaited(1.0, 1.0)
    for row in (0, 1):
        put(inbox, row, 1.0)
    assert inbox.awaited(1.0, 1.0) == inbox.awaited(1.08, 1.0) == ""
    put(inbox, 0, 1.1)
    assert inbox.awaited(1.1, 1.0) == "no fresh sonar of robot2 (0.1 s)"
    late = inbox_of(noise={"latency": 0.3})
    assert late.awaited(1.28, 1.0) == "" and "never received" in late.awaited(1.3, 1.0)
    looks_back = inbox_of(names=("imu",))
    assert looks_back.awaited(1.08, 1.0) == "" and "never received" in looks_back.awaited(1.1, 1.0)


def camera_inbox(real=()):
    """Return the inbox of a camera of 2 x 1 pixels at 5 Hz, and ``tell(stamp, part, value)``."""
    eye = {"type": "camera", "width": 2, "height": 1, "rate": 5.0}
    scenario = scenario_from_dict({"poses": [[0, 0, 0]], "sensors": [{"mounts": {"eye": eye}}]})
    team = Team.from_scenario(scenario)
    mounts = fitted_mounts(team, scenario.sensors)
    inbox = sensor_inbox.SensorInbox(("eye",), mounts, team.kinds, real, scenario.step)
    (inlet,) = inbox._inlets

    def tell(stamp, part, value):
        picture = np.full((1, 2, 3), value, dtype=np.uint8), np.full((1, 2), float(value))
        header = Header(0, rospy.Time.from_sec(stamp), "")
        inbox.put(inlet.forms[part].message(picture, header), inlet, part)

    return inbox, tell


def heard(inbox):
    """Return stamp, value of the picture and value of the depth of the newest reading, None without."""
    reading = inbox.readings(0.0)[0].get("eye")
    return reading and (round(reading.stamp, 6), reading.image[0, 0, 0], reading.depth[0, 0])


def test_a_picture_and_its_depth_are_one_reading(times):
    inbox, tell = camera_inbox()
    assert inbox._inlets[0].topics == ["/robot1/RosAria/eye", "/robot1/RosAria/eye_depth"]
    tell(1.0, 0, 1)
    assert heard(inbox) is None and inbox.awaited(1.0, 1.0)
    assert inbox.missing(1.0).endswith(
        "(never received); nothing came on /robot1/RosAria/eye_depth"
    )
    tell(1.0, 1, 1)
    assert heard(inbox) == (1.0, 1, 1.0) and inbox.missing(1.0) == inbox.awaited(1.0, 1.0) == ""
    # Each topic has a thread of its own: the next picture may overtake the depth.
    times.simulated = 1.4
    for stamp, part, value in ((1.2, 1, 2), (1.2, 0, 2), (1.4, 0, 3)):
        tell(stamp, part, value)
    assert heard(inbox) == (1.2, 2, 2.0)
    tell(1.4, 1, 3)
    assert heard(inbox) == (1.4, 3, 3.0)
    # After a restart nothing of the last run is taken for this one's.
    times.simulated = 0.0
    tell(1.2, 0, 4)
    assert heard(inbox) == (1.4, 3, 3.0)
    tell(1.2, 1, 4)
    assert heard(inbox) == (1.2, 4, 4.0) and inbox.rates()[0][2] == 4


def test_real_cameras_tell_picture_and_depth_when_they_like(times):
    inbox, tell = camera_inbox(real=(0,))
    for k in range(4):
        times.simulated = times.wall = 100.0 + 0.2 * k
        tell(times.wall, 0, k)
        assert heard(inbox) == (None if k < 2 else (round(times.wall - 0.2, 6), k - 1, k - 1.0))
        times.simulated = times.wall = times.wall + 0.03
        tell(times.wall, 1, k)
    assert heard(inbox) == (100.6, 3, 3.0)


def test_nothing_is_missing_where_nothing_is_asked_for(times):
    inbox = inbox_of(names=())
    assert inbox.missing(1e9) == inbox.awaited(1e9, 0.0) == ""
    assert not math.isnan(len(inbox.readings(0.0)))


def test_a_reading_that_is_published_again_puts_off_what_is_waited_for_in_lockstep(times):
    """A reset puts off the next sample: to wait for it would end in a stall, for time waits too."""
    inbox = inbox_of()
    put(inbox, 0, 1.0)
    put(inbox, 1, 1.0)
    put(inbox, 1, 1.0)  # as to a new listener, while nothing is waited for
    assert "robot1" in inbox.awaited(1.1, 1.0) and "robot2" in inbox.awaited(1.1, 1.0)
    put(inbox, 1, 1.0)
    assert inbox.awaited(1.2, 1.0) == "no fresh sonar of robot1 (0.2 s)"
    times.simulated = 1.25
    put(inbox, 0, 1.25)
    put(inbox, 1, 1.25)
    assert inbox.awaited(1.3, 1.0) == "" and "robot2" in inbox.awaited(1.35, 1.0)


def test_a_sensor_is_unconnected_until_its_publisher_has_answered(times, monkeypatch):
    made = []

    def subscriber(*_, **__):
        connections = [SimpleNamespace(callerid_pub="unknown")]
        made.append(SimpleNamespace(impl=SimpleNamespace(connections=connections)))
        return made[-1]

    monkeypatch.setattr(sensor_inbox.rospy, "Subscriber", subscriber)
    inbox = inbox_of()
    made[0].impl.connections[0].callerid_pub = "/stage"
    assert inbox.unconnected() == "no fresh sonar of robot2 (never received)"
    made[1].impl.connections[0].callerid_pub = "/stage"
    assert inbox.unconnected() == ""
