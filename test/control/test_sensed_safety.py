"""The safety filter by what robots sense of each other and of obstacles."""

import re

import numpy as np
import pytest
from protocol_fixtures import check, failed, shipped, verdict_of

from mrs_simulator.control.safety.filter_by_sensors import (
    SensedNeighbourhood,
    arcs,
    nearest,
    safe_by_sensors,
)
from mrs_simulator.protocols.loading import ProtocolError
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import ScenarioError
from mrs_simulator.sensors.types.range_bearing import RangeBearingReading
from mrs_simulator.sensors.types.ranging import RangeReading
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.verdict.judging import command_after

PERIOD = 0.02
CONE = np.radians(15.0)
STRAIGHT = np.eye(2)[np.newaxis]


def seen(numbers, ranges, bearings, place=(0.0, 0.0)):
    numbers = np.array(numbers, dtype=int)
    return RangeBearingReading(0.0, numbers, np.array(ranges), np.array(bearings), place)


def heard(ranges, directions, cone=CONE):
    places = np.column_stack([np.zeros((len(directions), 2)), np.radians(directions)])
    return RangeReading(0.0, np.array(ranges, dtype=float), places, 5.0, cone)


def test_of_a_pair_each_takes_half():
    # h = 1.2^2 - 1 = 0.44, as the filter that knows both has it: 2.4 (u_1 - u_2) <= 0.44^3.
    seer = SensedNeighbourhood((0.0, 0.0), 0.5, np.array([0.5, 0.5]), PERIOD)
    out, limit = seer.bounds([seen([2], [1.2], [0.0])])
    np.testing.assert_allclose(out, [[-1.0, 0.0]])
    np.testing.assert_allclose(limit, 0.5 * 0.44**3 / 2.4)


def test_robots_are_where_the_sensor_is_and_sees_them():
    reading = seen([2], [1.0], [0.5 * np.pi], (0.2, 0.1))
    np.testing.assert_allclose(reading.points, [[0.2, 1.1]], atol=1e-12)


def test_a_wall_ahead_of_a_ray_leaves_half_of_the_gap_each_second():
    seer = SensedNeighbourhood((0.1, 0.0), 0.4, np.zeros(1), PERIOD)
    out, limit = seer.bounds([heard([1.5, np.inf], [0.0, 90.0], cone=0.0)])
    np.testing.assert_allclose(out, [[-1.0, 0.0]])
    np.testing.assert_allclose(limit, 0.5 * (1.4 - 0.4))


def test_an_echo_may_come_from_anywhere_in_its_cone_where_no_other_would_receive_it():
    place, out = arcs(heard([2.0], [0.0]))
    angles = np.radians([-15.0, -7.5, 0.0, 7.5, 15.0])
    np.testing.assert_allclose(place, 2.0 * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    np.testing.assert_allclose(out, -0.5 * place)
    # One at 20 deg hears from 5 deg to 35 deg on, and hears nothing; or it lost what it heard.
    assert len(arcs(heard([2.0, np.inf], [0.0, 20.0]))[0]) == 3
    assert len(arcs(heard([2.0, np.nan], [0.0, 20.0]))[0]) == 5
    # Two that hear the same thing exclude nothing.
    assert len(arcs(heard([2.0, 2.0], [0.0, 20.0]))[0]) == 10


def test_the_nearest_velocity_is_that_of_a_search(monkeypatch):
    monkeypatch.setattr("mrs_simulator.control.safety.filter_by_sensors.SWIRL", 0.0)
    draw = np.random.default_rng(1)
    grid = np.stack(np.meshgrid(*[np.linspace(-1.5, 1.5, 151)] * 2), axis=-1).reshape(-1, 2)
    for _ in range(30):
        angle = draw.uniform(0.0, 2.0 * np.pi, 4)
        out, limit = np.stack([np.cos(angle), np.sin(angle)], axis=1), draw.uniform(0.0, 0.5, 4)
        wanted = draw.uniform(-1.0, 1.0, 2)
        found = nearest(wanted, out, limit)
        assert (-out @ found <= limit + 1e-6).all()
        allowed = grid[(-grid @ out.T <= limit).all(axis=1)]
        least = np.linalg.norm(allowed - wanted, axis=1).min()
        assert np.linalg.norm(found - wanted) <= least + 1e-9


def test_a_robot_that_has_sensed_nothing_yet_stands_still():
    seer = SensedNeighbourhood((0.0, 0.0), 0.5, np.array([0.5, 0.5]), PERIOD)
    wanted = np.array([[1.0, 0.0]])
    assert not safe_by_sensors(wanted, [seer], STRAIGHT, [[None]]).any()
    free = safe_by_sensors(wanted, [seer], STRAIGHT, [[seen([], [], [])]], np.array([0.3]))
    np.testing.assert_allclose(free, [[0.3, 0.0]])


def test_sensors_are_asked_for_by_name_and_type():
    scenario = shipped("formation_by_sonar", duration=1.0)

    def sensed(name, **mounts):
        control = dict(scenario.control.to_plain(), safety={"sensed": name})
        return scenario.changed(control=control, sensors=[{"mounts": mounts}] if mounts else [])

    with pytest.raises(ProtocolError, match="control.safety asks for sensors lidar: .*robot1"):
        make_control(sensed("lidar"))
    with pytest.raises(ProtocolError, match="safety.sensed: north is a compass, wanted one of"):
        make_control(sensed("north", north={"type": "compass"}))
    with pytest.raises(ScenarioError, match="safety.sensed: 3, wanted a list of"):
        sensed(3)
    assert make_control(sensed("sonar")).SENSORS == ("sonar",)


def test_robots_that_see_each_other_cross_apart(tmp_path):
    verdict = verdict_of(shipped("sensed_crossing", duration=19.0), tmp_path)
    assert verdict["outcome"] == "passed" and not failed(verdict)
    assert "after the safety filter acted" in check(verdict, "commands off")["note"]
    least = check(verdict, "least distance")
    assert least["measured"] > least["predicted"] == pytest.approx(0.45)


def test_without_seeing_they_would_touch(tmp_path, monkeypatch):
    blind = "mrs_simulator.sensors.types.range_bearing.RangeBearingReading.of"
    monkeypatch.setattr(blind, lambda reading, k: seen([], [], [])._replace(stamp=reading.stamp))
    verdict = verdict_of(shipped("sensed_crossing", duration=9.0), tmp_path)
    assert "collisions" in failed(verdict)


def test_obstacles_that_only_sonars_know_are_passed(tmp_path):
    verdict = verdict_of(shipped("formation_by_sonar", duration=20.0), tmp_path)
    assert verdict["outcome"] == "passed" and not failed(verdict)
    assert check(verdict, "least clearance")["measured"] > 0.0


def test_burgers_pass_what_only_their_lasers_know(tmp_path):
    scenario = shipped("burgers_by_laser", duration=7.0)
    verdict = verdict_of(scenario, tmp_path / "seeing")
    assert not failed(verdict) and check(verdict, "least clearance")["measured"] > 0.0
    blind = scenario.changed(control=dict(scenario.control.to_plain(), safety=False))
    assert "collisions" in failed(verdict_of(blind, tmp_path / "blind"))


def warned(range_=3.0, rate=20.0, **control):
    scenario = shipped("sensed_crossing", duration=1.0)
    seer = {"type": "range_bearing", "range": range_, "rate": rate}
    plain = dict(scenario.control.to_plain(), **control)
    changed = scenario.changed(control=plain, sensors=[{"mounts": {"neighbours": seer}}])
    return make_control(changed).foreseen


def test_sensors_that_reach_too_short_or_read_too_slowly_are_warned_of_before_the_run():
    assert warned() == []
    (text,) = warned(range_=0.5)
    wanted, would = re.search(r"wanted ([0-9.]+) m .* at most ([0-9.]+) m/s", text).groups()
    # Both bodies, both robots for two periods of 50 ms, and the way in which they brake without ramps.
    assert float(wanted) == pytest.approx(0.45 + 2.0 * 0.5 * 0.1, abs=0.02)
    assert warned(range_=float(wanted) + 0.005) == [] and 0.0 < float(would) < 0.5
    sensed = {"sensed": ["neighbours"]}
    assert warned(range_=0.5, safety=dict(sensed, speed=float(would))) == []
    assert "top speeds are unlimited" not in warned(safety=sensed)
    (text,) = warned(rate=5.0)
    assert "reads at 5 Hz, wanted the commands' 20 Hz or more" in text


def test_what_is_outside_of_the_promise_is_warned_of_before_the_run():
    cart = {"type": "box", "name": "cart", "center": [9.0, 9.0], "size": [0.8, 0.5]}
    cart["track"] = {"to": [[9.0, -9.0]], "speed": 0.2}
    scenario = shipped("formation_safely", duration=1.0)
    assert make_control(scenario).foreseen == []
    (text,) = Experiment(scenario.changed(obstacles=[cart])).control.foreseen
    assert "obstacles that move, cart, at up to 0.2 m/s" in text and "docs/safety.md" in text
    assert text in Experiment(scenario.changed(obstacles=[cart])).warnings
    (text,) = make_control(scenario.changed(mismatch={"speed": 1.2})).foreseen
    assert "because of the mismatch" in text
    push = {"at": 1.0, "robot": 2, "event": "pushed", "by": [0.1, 0.0]}
    (text,) = make_control(scenario.changed(events=[push])).foreseen
    assert "because of robots that are pushed, or fall:" in text
    (text,) = make_control(scenario.changed(odometry_rate=0.5 * scenario.control.rate)).foreseen
    assert "because of places that come less often than commands:" in text
    assert make_control(scenario.changed(odometry_rate=scenario.control.rate)).foreseen == []
    unfiltered = dict(scenario.control.to_plain(), safety=False)
    assert make_control(scenario.changed(obstacles=[cart], control=unfiltered)).foreseen == []


def test_what_comes_after_the_filter_begins_with_a_command():
    time = 0.1 * np.arange(30)
    assert command_after(time, 7, 0.2) == 8 and command_after(time, 8, 0.2) == 8
    assert command_after(time, 7, 0.1) == 7 and command_after(time[:8], 7, 0.2) == 7
