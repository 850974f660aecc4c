"""Readings that a scenario has recorded beside run.csv."""

import csv

import numpy as np
import pytest

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.sensors.types import TYPES
from mrs_simulator.study.run.experiment import Experiment, perform
from mrs_simulator.study.run.sensor_files import FILE, lines_of, recorded_sensors
from mrs_simulator.study.run.sensor_sizes import with_sizes
from mrs_simulator.vehicles import Team
from mrs_simulator.world.world import World

MOUNTS = {
    "laser": {"range": [0.1, 5.0], "rays": 31},
    "seen": {"type": "range_bearing", "noise": {"range": {"stddev": 0.02}}},
    "beacons": {"type": "beacons", "points": [[2.0, 2.0], [-4.0, 1.0]]},
    "bumper": {"type": "bumper"},
    "encoders": {"type": "encoders"},
    "imu": {"type": "imu"},
    "compass": {"type": "compass"},
    "altimeter": {"type": "altimeter"},
    "gps": {"type": "gps", "origin": [49.1, 12.3, 400.0], "noise": {"dropout": 0.3}},
    "mocap": {"type": "motion_capture", "noise": {"position": {"latency": 0.1}}},
    "battery": {"type": "battery", "rate": 5.0},
}


def scenario(**more):
    content = {
        "poses": [[0.0, 0.0, 0.0], [-2.0, 0.3, 0.4], [3.0, -1.0, 2.0]],
        "obstacles": [{"type": "box", "name": "w", "center": [6.0, 0.0], "size": [0.2, 9.0]}],
        "sensors": [{"mounts": MOUNTS}, {"robots": 3, "mounts": {"laser": None}}],
        "control": {"protocol": "consensus"},
        "duration": 1.0,
        "record": ["sonar", *MOUNTS],
    }
    return scenario_from_dict(dict(content, **more))


def rows_of(out, name):
    with open(out / FILE.format(name), newline="") as file:
        header, *rows = csv.reader(file)
    return header, np.array(rows, dtype=float)


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """The directory of a recorded run, and what was said of it beforehand."""
    directory = tmp_path_factory.mktemp("run")
    (directory / FILE.format("old")).write_text("of an earlier run")
    perform(scenario(), str(directory))
    return directory


def test_every_sample_is_recorded_as_it_was_measured(out):
    header, rows = rows_of(out, "laser")
    assert header == ["time", "robot", *("range{}".format(k + 1) for k in range(31))]
    assert rows[:, 1].tolist() == [1.0, 2.0] * 11  # the third robot has none
    assert rows[::2, 0] == pytest.approx(0.1 * np.arange(11))
    world = World.from_scenario(scenario())
    suite = Suite.of_scenario(scenario(), world.team, world.obstacles)
    suite.activate({0: ["laser"]})
    suite.update(0, world.sensed)
    np.testing.assert_allclose(rows[:2, 2:], suite.active[0].newest.ranges, rtol=1e-8)


def test_files_have_the_columns_of_their_readings(out):
    wanted = {
        "seen": ["seen", "range", "bearing"],
        "bumper": ["front1", "front2", "front3", "front4", "front5"]
        + ["rear1", "rear2", "rear3", "rear4", "rear5"],
        "encoders": ["travel1", "travel2"],
        "imu": ["acceleration1", "acceleration2", "acceleration3", "rate1", "rate2", "rate3"],
        "compass": ["heading"],
        "altimeter": ["height"],
        "gps": ["latitude", "longitude", "altitude"],
        "mocap": ["x", "y", "theta"],
        "battery": ["voltage", "charge"],
    }
    for name, columns in wanted.items():
        header, rows = rows_of(out, name)
        assert header == ["time", "robot", *columns]
        assert set(rows[:, 1]) == {1.0, 2.0, 3.0}
    assert np.isnan(rows_of(out, "gps")[1]).any()
    _, seen = rows_of(out, "seen")
    assert ((seen[:, 2] != seen[:, 1]) & (seen[:, 3] > 0.0)).all()
    assert rows_of(out, "mocap")[1][-1, 0] == 1.0  # also what was known only later
    assert not (out / FILE.format("old")).exists()


def test_recording_changes_no_run(out, tmp_path):
    perform(scenario(record=[]), str(tmp_path))
    assert (tmp_path / "run.csv").read_bytes() == (out / "run.csv").read_bytes()
    assert not list(tmp_path.glob("sensor_*"))


def test_sizes_are_reported_beforehand(out, tmp_path):
    said = []
    long = scenario(duration=600.0)
    experiment = Experiment(long)
    experiment.record_sensors(str(tmp_path), said.append).close()
    assert said[1].startswith(
        "sensor_laser.csv: 2 robots, 31 values at 10 Hz for 600 s: about 1.6 MB"
    )
    world, mounts = experiment.world, experiment.sensors.mounts
    recorded = recorded_sensors(long.record, mounts, world.team.kinds)
    recorded = with_sizes(recorded, long, world.team, world.obstacles, lines_of)
    sensors = {each.name: each for each in recorded}
    # What is measured exactly, and is 0, has few digits: it takes less.
    noiseless = "imu", "compass", "altimeter", "mocap", "gps", "encoders"
    for name in set(sensors).difference(noiseless):
        size = (out / FILE.format(name)).stat().st_size
        assert 0.8 < size / sensors[name].size(1.0) < 1.25, name
    for name in noiseless:
        assert (out / FILE.format(name)).stat().st_size < sensors[name].size(1.0), name
    assert (
        "at 10 Hz for 600 s: about 1.1 MB if as many are seen as at the start, at most" in said[2]
    )


def test_every_type_of_sensor_can_be_recorded_or_is_a_picture():
    tabled = {mount["type"] for mount in MOUNTS.values() if "type" in mount} | {"laser", "sonar"}
    assert {*TYPES} == {*tabled, "camera"}


def test_pictures_are_left_to_bags(tmp_path):
    said, mounts = [], {"eye": {"type": "camera"}}
    seen = scenario(sensors=[{"robots": 2, "mounts": mounts}], record=["eye", "sonar"])
    Experiment(seen).record_sensors(str(tmp_path), said.append).close()
    assert said[0] == "record: pictures of eye are in bags alone"
    assert [each.name for each in tmp_path.iterdir()] == [FILE.format("sonar")]


def test_what_no_robot_has_is_refused():
    with pytest.raises(ScenarioError, match="record: unknown 'lasr'"):
        Experiment(scenario(record=["lasr"]))
    with pytest.raises(ScenarioError, match="record: .*, wanted a list of different names"):
        scenario(record=["laser", "laser"])
    with pytest.raises(ScenarioError, match="record: 'laser', wanted a list"):
        scenario(record="laser")
    assert scenario_from_dict(scenario().to_dict()).record == ("sonar", *MOUNTS)


def test_one_file_is_of_one_type():
    laser, compass = {"type": "laser", "rays": 3}, {"type": "compass"}
    sensors = [{"mounts": {"s": laser}}, {"robots": 3, "mounts": {"s": compass}}]
    with pytest.raises(ScenarioError, match="s of robot1 is a laser, and of robot3 a compass"):
        Experiment(scenario(sensors=sensors, record=["s"]))


def test_a_size_is_reported_of_all_beacons_that_may_be_received():
    mounts = {"b": {"type": "beacons", "points": [[float(k), 0.0] for k in range(9)]}}
    given = scenario(sensors=[{"mounts": mounts}], record=["b"])
    team = Team.from_scenario(given)
    (told,) = recorded_sensors(["b"], fitted_mounts(team, given.sensors), team.kinds)
    assert told.most == 9


def test_a_size_is_reported_of_all_robots_that_may_be_seen(tmp_path):
    given = scenario_from_dict({
        "robots": 5, "poses": {"layout": "circle", "radius": 1.5}, "duration": 2.0,
        "record": ["others"], "sensors": [{"mounts": {"others": {"type": "range_bearing"}}}],
    })  # fmt: skip
    team = Team.from_scenario(given)
    (told,) = recorded_sensors(["others"], fitted_mounts(team, given.sensors), team.kinds)
    assert told.most == 4 and told.summary(2.0).endswith("at most 0.02 MB")
    # A row of its file: 10 Hz, 5 robots that see 4 each.
    row = len("0.1,1,2,1.73553495647023,0.448798950512828\n")
    assert told.size(2.0) == pytest.approx(2.0 * 10.0 * 5 * 4 * row, rel=0.5)
