"""Which sensors robots have: declared by kinds, changed by a scenario, read where they are heard."""

import numpy as np
import pytest

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict, scenario_from_yaml
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.state import State
from mrs_simulator.sensors.suite import SensorError, Suite
from mrs_simulator.vehicles import KINDS, Team

LASER = {"type": "laser", "rays": 5}


def mounts(*changes, **content):
    content.setdefault("poses", [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
    scenario = scenario_from_dict(dict(content, sensors=list(changes)))
    return fitted_mounts(Team.from_scenario(scenario), scenario.sensors)


def names(found):
    return [[mount.name for mount in robot] for robot in found]


def test_mounts_of_every_shipped_kind_are_possible():
    of_kind = dict(zip(KINDS, fitted_mounts(Team(KINDS))))
    for kind in ("pioneer3dx", "pioneer3at"):
        (sonar,) = of_kind[kind]
        assert sonar.name == "sonar" and len(sonar.settings.transducers) == 16
        assert sonar.rate == 10.0 and sonar.settings.most == 5.0
    assert of_kind["pioneer3dx"][0].settings.transducers[2] == pytest.approx(
        (0.148, 0.078, np.pi / 6)
    )
    assert len(of_kind["amigobot"][0].settings.transducers) == 8
    assert of_kind["turtlebot3_burger"][0].settings.rays == 360


def test_sensors_are_added_removed_and_tuned_for_all_or_for_some():
    found = mounts({"robots": [1, 3], "mounts": {"laser": {}}}, {"mounts": {"scan": LASER}})
    assert names(found) == [
        ["sonar", "laser", "scan"],
        ["sonar", "scan"],
        ["sonar", "laser", "scan"],
    ]
    assert found[0][1].settings.most == 32.767 and found[0][1].place[0] == pytest.approx(0.021)
    found = mounts({"robots": 2, "mounts": {"sonar": None}})
    assert names(found) == [["sonar"], [], ["sonar"]]
    tuned = mounts({"robots": 3, "mounts": {"sonar": {"rate": 5, "noise": {"bias": "1 cm"}}}})
    assert [robot[0].rate for robot in tuned] == [10.0, 10.0, 5.0]
    noise = dict(tuned[2][0].noise)[""]
    assert noise.bias == 0.01 and noise.stddev == dict(tuned[0][0].noise)[""].stddev
    assert tuned[2][0].settings == tuned[0][0].settings


def test_sensors_are_given_to_a_kind_and_to_a_group():
    groups = [
        {"number": 2, "layout": "line", "spacing": 2.0},
        {"kind": "robotino3", "poses": [[9.0, 9.0, 0.0]], "sensors": {"scan": LASER}},
    ]
    scenario = scenario_from_dict(
        {"groups": groups, "sensors": [{"kind": "pioneer3dx", "mounts": {"laser": {"rays": 3}}}]}
    )
    found = names(fitted_mounts(Team.from_scenario(scenario), scenario.sensors))
    assert found == [["sonar", "laser"], ["sonar", "laser"], ["scan"]]
    again = scenario_from_yaml(scenario.to_yaml())
    assert names(fitted_mounts(Team.from_scenario(again), again.sensors)) == found


def test_another_model_or_type_takes_nothing_from_the_one_before():
    (robot,) = mounts({"mounts": {"laser": {"model": "urg04lx"}}}, poses=[[0.0, 0.0, 0.0]])
    assert robot[1].settings.rays == 683 and robot[1].place == (0.0, 0.0, 0.0, 0.0)


def test_more_robots_have_the_sensors_of_the_last():
    content = {"poses": [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]}
    content["sensors"] = [{"robots": [2], "mounts": {"laser": {}}}]
    scenario = scenario_from_dict(content)
    more = scenario.with_robots(3)
    assert (
        names(fitted_mounts(Team.from_scenario(more), more.sensors))[1:] == [["sonar", "laser"]] * 2
    )
    assert scenario.with_robots(1).sensors == ()


def test_a_kind_of_ones_own_declares_mounts():
    own = {
        "scout": {"base": "pioneer3dx", "mounts": {"sonar": None, "scan": dict(LASER, rate="4 Hz")}}
    }
    ((scan,),) = mounts(poses=[[0.0, 0.0, 0.0]], kinds=own, model="scout")
    assert scan.name == "scan" and scan.rate == 4.0


@pytest.mark.parametrize(
    "change, wanted",
    [
        (
            {"robots": 4, "mounts": {}},
            r"sensors\[0\].robots: 4, wanted robots' numbers from 1 to 3",
        ),
        ({"kind": "huskie", "mounts": {}}, r"sensors\[0\].kind: unknown 'huskie'"),
        ({"robots": 1, "kind": "pioneer3dx", "mounts": {}}, "kind: given beside robots"),
        ({"mounts": ["sonar"]}, r"sensors\[0\].mounts: .'sonar'., wanted a mapping"),
        ({"mount": {}}, r"sensors\[0\].mounts: nothing given"),
        (
            {"mounts": {"sonnar": None}},
            r"mounts.sonnar: robot1 \(pioneer3dx\).*did you mean 'sonar'",
        ),
        ({"mounts": {"laser": None}}, r"unknown 'laser' \(known: sonar\)"),
        ({"mounts": {"sonnar": {"rate": 5}}}, "mounts.sonnar: no such sensor to tune"),
        ({"mounts": {"sonar": {"rat": 5}}}, "mounts.sonar: unknown 'rat'; did you mean 'rate'"),
        ({"mounts": {"sonar": {"rate": "5 m"}}}, "mounts.sonar.rate: '5 m'"),
        (
            {"mounts": {"sonar": {"range": [5, 1]}}},
            "mounts.sonar.range: .5, 1., wanted the least first",
        ),
        ({"mounts": {"sonar": {"transducers": [[0, 0]]}}}, r"transducers\[0\]: .0, 0., wanted"),
        (
            {"mounts": {"laser": {"model": "lms20"}}},
            "mounts.laser.model: unknown 'lms20'; .*'lms200'",
        ),
        ({"mounts": {"x": {"type": "lidar"}}}, "mounts.x.type: 'lidar', wanted one of "),
        ({"mounts": {"a b": LASER}}, "mounts.a b: 'a b', wanted letters"),
        ({"mounts": {"x": dict(LASER, place=[0, 0])}}, "mounts.x.place: .0, 0., wanted .x, y, z."),
        ({"mounts": {"x": dict(LASER, noise={"sigma": 1})}}, "mounts.x.noise: unknown 'sigma'"),
    ],
)
def test_impossible_sensors_are_refused_by_name(change, wanted):
    with pytest.raises(ScenarioError, match=wanted):
        mounts(change)


def test_a_kind_with_impossible_mounts_is_refused_though_they_are_not_fitted():
    own = {"scout": {"base": "pioneer3dx", "mounts": {"laser": {"rays": 0}}}}
    with pytest.raises(ScenarioError, match="scout: mounts.laser.rays: 0"):
        mounts(poses=[[0.0, 0.0, 0.0]], kinds=own, model="scout")


# Listening ---------------------------------------------------------------------------------------


def suite(**content):
    content.setdefault("poses", [[0.0, 0.0, 0.0], [2.0, 0.0, 0.5]])
    scenario = scenario_from_dict(content)
    return scenario, Suite.of_scenario(scenario, Team.from_scenario(scenario))


def heard(listened, until=1.0, since=0.0, **content):
    """Return the readings of each row, at every step at which they are new, from ``since`` [s] on."""
    scenario, found = suite(**content)
    result = []
    for step in range(int(round(until / scenario.step)) + 1):
        time = step * scenario.step
        if time >= since - 1e-9:
            if not result:
                found.activate(listened)
            pose = scenario.poses + [0.1 * time, 0.0, 0.0]
            found.update(step, lambda pose=pose, time=time: State(time, pose, np.zeros_like(pose)))
            result.append(found.readings(time))
    return result


def test_a_sensor_is_read_at_its_own_rate_and_known_after_its_latency():
    tuned = [{"robots": 1, "mounts": {"sonar": {"noise": {"latency": 0.25}}}}]
    found = heard({0: ["sonar"], 1: ["sonar"]}, sensors=tuned)
    assert "sonar" not in found[12][0] and found[13][0]["sonar"].stamp == 0.0
    stamps = [each[1]["sonar"].stamp for each in found]
    assert stamps[:11] == pytest.approx([0.0] * 5 + [0.1] * 5 + [0.2])
    late = [each[0]["sonar"].stamp for each in found[13:]]
    assert late == pytest.approx(
        [0.0] * 5
        + [0.1] * 5
        + [0.2] * 5
        + [0.3] * 5
        + [0.4] * 5
        + [0.5] * 5
        + [0.6] * 5
        + [0.7] * 3
    )


def test_readings_depend_on_no_other_sensor_and_on_no_other_subscriber():
    alone = heard({0: ["sonar"]})[-1][0]["sonar"]
    more = [
        {"mounts": {"laser": {}}},
        {"robots": 2, "mounts": {"sonar": {"noise": {"stddev": 0.1}}}},
    ]
    beside = heard({0: ["sonar", "laser"], 1: ["sonar"]}, sensors=more)[-1][0]["sonar"]
    late = heard({0: ["sonar"]}, since=0.55)[-1][0]["sonar"]
    for other in (beside, late):
        assert other.stamp == alone.stamp and np.array_equal(other.ranges, alone.ranges)
    assert not np.array_equal(heard({0: ["sonar"]}, seed=1)[-1][0]["sonar"].ranges, alone.ranges)


def test_no_robot_is_read_without_a_subscriber():
    _, found = suite()
    assert found.is_idle
    found.update(0, lambda: pytest.fail("the state was asked for"))
    assert found.readings(0.0) == {0: {}, 1: {}}


def test_a_sensor_that_a_robot_lacks_is_refused_by_name():
    _, found = suite(sensors=[{"robots": 2, "mounts": {"sonar": None}}])
    with pytest.raises(SensorError, match=r"sensors of robot2 \(pioneer3dx\): unknown 'sonar'"):
        found.activate({0: ["sonar"], 1: ["sonar"]})


def test_a_rate_that_steps_cannot_keep_is_reported():
    _, found = suite(sensors=[{"robots": 2, "mounts": {"sonar": {"rate": 40}}}])
    (note,) = found.notes
    assert note == "robot2: sonar at 50 Hz, every 1 steps of 0.02 s; wanted 40 Hz"
