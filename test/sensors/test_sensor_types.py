"""Bumpers, encoders, range-and-bearing, inertial sensors and positions against geometry by hand."""

import math

import numpy as np
import pytest

from mrs_simulator.core.spatial import Spatial
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.sensors.state import State
from mrs_simulator.sensors.suite import Suite, of_robot, of_robots
from mrs_simulator.sensors.types.inertial import GRAVITY
from mrs_simulator.sensors.types.position import local_place, radii
from mrs_simulator.vehicles import Team
from mrs_simulator.world.world import EVERY, World


def suite(mounts, poses=((0.0, 0.0, 0.0),), **more):
    scenario = scenario_from_dict(
        dict({"poses": [list(pose) for pose in poses], "sensors": [{"mounts": mounts}]}, **more)
    )
    return scenario, Suite.of_scenario(scenario, Team.from_scenario(scenario))


def state(poses, twist=None, time=0.0, **more):
    poses = np.array(poses, dtype=float)
    twist = np.zeros_like(poses) if twist is None else np.array(twist, dtype=float)
    return State(time, poses, twist, **more)


def read(mounts, *states, poses=None, **more):
    """Return the readings of the only mount at the last of ``states``, one step after each other."""
    poses = states[-1].pose.tolist() if poses is None else poses
    _, found = suite(mounts, poses, **more)
    (name,) = mounts
    found.activate({row: [name] for row in range(len(poses))})
    for step, each in enumerate(states):
        found.update(step, lambda each=each: each)
    known = found.readings(states[-1].time)
    return [known[row].get(name) for row in range(len(poses))]


# Range and bearing -------------------------------------------------------------------------------

SEES = {"sight": {"type": "range_bearing", "range": 6.0, "place": [0.0, 0.0, 0.1]}}
TRIANGLE = [[0.0, 0.0, math.pi / 2.0], [0.0, 3.0, 0.0], [4.0, 0.0, 0.0]]


def test_others_are_seen_by_number_range_and_bearing():
    first, second, third = read(SEES, state(TRIANGLE))
    assert first.numbers.tolist() == [2, 3]
    assert first.ranges == pytest.approx([3.0, 4.0])
    assert first.bearings == pytest.approx([0.0, -math.pi / 2.0])
    assert second.numbers.tolist() == [1, 3] and second.ranges == pytest.approx([3.0, 5.0])
    assert second.bearings == pytest.approx([-math.pi / 2.0, math.atan2(-3.0, 4.0)])
    assert third.bearings == pytest.approx([-math.pi, math.atan2(3.0, -4.0)])


def test_no_robot_beyond_range_or_view_is_seen():
    near = {"sight": dict(SEES["sight"], range=4.5)}
    assert [each.numbers.tolist() for each in read(near, state(TRIANGLE))] == [[2, 3], [1], [1]]
    ahead = {"sight": dict(SEES["sight"], view="90 deg")}
    assert [each.numbers.tolist() for each in read(ahead, state(TRIANGLE))] == [[2], [3], []]
    aside = {"sight": dict(SEES["sight"], view="90 deg", yaw="-90 deg")}
    assert read(aside, state(TRIANGLE))[0].numbers.tolist() == [3]


def test_what_stands_between_hides_others():
    row = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]]
    assert [each.numbers.tolist() for each in read(SEES, state(row))] == [[2], [1, 3], [2]]
    through = {"sight": dict(SEES["sight"], occlusion=False)}
    assert read(through, state(row))[0].numbers.tolist() == [2, 3]
    above = {"sight": dict(SEES["sight"], place=[0.0, 0.0, 0.3])}  # a Pioneer is 0.237 m high
    assert read(above, state(row))[0].numbers.tolist() == [2, 3]
    crate = {"type": "box", "center": [0.0, 1.5], "size": [0.2, 0.2]}
    assert read(SEES, state(TRIANGLE), obstacles=[crate])[0].numbers.tolist() == [3]


def test_noise_makes_no_range_negative():
    noise = {"range": {"bias": -9.0}}
    kinds = {"type": "range_bearing", "noise": noise}, dict(BEACONS, noise=noise)
    for mount in kinds:
        (reading, _) = read({"x": mount}, state([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]))
        assert len(reading.ranges) and not reading.ranges.any()


def test_a_lost_range_or_bearing_loses_the_robot():
    noise = {"bearing": {"dropout": 1.0}}
    assert read({"sight": dict(SEES["sight"], noise=noise)}, state(TRIANGLE))[0].numbers.size == 0
    noise = {"range": {"bias": 0.5}, "bearing": {"bias": "180 deg"}}
    biased = read({"sight": dict(SEES["sight"], noise=noise)}, state(TRIANGLE))[0]
    assert biased.ranges == pytest.approx([3.5, 4.5])
    assert biased.bearings == pytest.approx([-math.pi, math.pi / 2.0])


# Beacons -----------------------------------------------------------------------------------------

BEACONS = {"type": "beacons", "points": [[3.0, 4.0], [0.0, -2.0], [90.0, 0.0]], "bearing": True}


def test_beacons_are_received_by_number_range_and_bearing():
    (heard,) = read(
        {"b": dict(BEACONS, place=[1.0, 0.0, 0.3])}, state([[0.0, -1.0, math.pi / 2.0]])
    )
    # The sensor is at the origin: 1 m ahead of a robot that looks along y.
    assert heard.numbers.tolist() == [1, 2] and heard.ranges == pytest.approx([5.0, 2.0])
    assert heard.bearings == pytest.approx([math.atan2(-3.0, 4.0), -math.pi])
    (far,) = read({"b": dict(BEACONS, bearing=False)}, state([[0.0, 0.0, 0.0]]))
    assert far.ranges == pytest.approx([5.0, 2.0]) and np.isnan(far.bearings).all()


def test_bodies_hide_beacons_below_their_height():
    crate = {"type": "box", "center": [1.5, 2.0], "size": [0.2, 0.2], "height": 0.5}
    low, high = (dict(BEACONS, place=[0.0, 0.0, z]) for z in (0.3, 0.6))
    at = state([[0.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    assert read({"b": low}, at, obstacles=[crate])[0].numbers.tolist() == [2]
    assert read({"b": high}, at, obstacles=[crate])[0].numbers.tolist() == [1, 2]
    near = {"b": dict(BEACONS, place=[0.0, 0.0, 0.1])}  # robot2 stands before the second
    assert [each.numbers.tolist() for each in read(near, at)] == [[1], [1, 2]]
    assert read({"b": dict(low, occlusion=False)}, at, obstacles=[crate])[0].numbers.size == 2


def test_a_wall_does_not_hide_the_beacons_on_it():
    wall = {"type": "box", "center": [5.5, 0.0], "size": [1.0, 8.0], "height": 1.0}
    column = {"type": "cylinder", "center": [-3.0, 0.0], "radius": 0.3, "height": 1.0}
    turn = np.linspace(-0.5, 0.5, 40)
    points = [[5.0, y] for y in np.linspace(-3.0, 3.0, 40)]
    points += np.stack([-3.0 + 0.3 * np.cos(turn), 0.3 * np.sin(turn)], axis=1).tolist()
    points += [[5.1, 0.0], [-2.8, 0.0]]  # within them
    mount = {"b": dict(BEACONS, points=points, place=[0.1, 0.0, 0.2])}
    for theta in (0.0, 0.3, 2.0):
        (heard,) = read(mount, state([[0.0, 0.0, theta]]), obstacles=[wall, column])
        assert heard.numbers.tolist() == list(range(1, 81))


# Bumpers -----------------------------------------------------------------------------------------


def pressed(pose, *contacts):
    (reading,) = read({"bumper": {"type": "bumper"}}, state([pose], contacts=contacts))
    return np.flatnonzero(reading.front).tolist(), np.flatnonzero(reading.rear).tolist()


def test_the_section_that_faces_a_contact_is_pressed():
    # Sections of 36 deg from 90 deg on the left; the outline's middle is 45.5 mm behind the axle.
    assert pressed([0.0, 0.0, 0.0], ("robot1", "wall", 0.21, 0.0)) == ([2], [])
    assert pressed([0.0, 0.0, 0.0], ("wall", "robot1", -0.0455 + 0.1, 0.2)) == ([0], [])
    assert pressed([1.0, 1.0, math.pi / 2.0], ("robot1", "wall", 1.0, 1.21)) == ([2], [])
    assert pressed([1.0, 1.0, math.pi / 2.0], ("robot1", "wall", 1.2, 1.1)) == ([3], [])
    assert pressed([0.0, 0.0, 0.0], ("robot1", "wall", -0.02, 0.2)) == ([0], [])
    assert pressed([0.0, 0.0, 0.0], ("robot1", "wall", -0.3, 0.0)) == ([], [2])
    assert pressed([0.0, 0.0, 0.0], ("robot1", "wall", -0.2, 0.2)) == ([], [1])
    assert pressed([0.0, 0.0, 0.0], ("robot2", "wall", 0.2, 0.0)) == ([], [])


def test_a_robot_that_drives_into_a_wall_feels_it_ahead():
    wall = {"type": "box", "center": [1.0, 0.0], "size": [0.2, 2.0]}
    scenario, found = suite({"bumper": {"type": "bumper"}}, obstacles=[wall])
    world = World.from_scenario(scenario)
    found.activate({0: ["bumper"]})
    felt = []
    for step in range(150):
        world.set_commands(EVERY, np.array([[0.5, 0.0]]))
        found.update(step, world.sensed)
        reading = found.readings(world.time)[0]["bumper"]
        felt.append((world.pose[0, 0], reading.front.any()))
        assert not reading.rear.any() and not reading.front[[0, 1, 3, 4]].any()
        world.step()
    assert felt[-1][1] and not felt[40][1]
    assert felt[-1][0] == pytest.approx(0.9 - 0.21, abs=1e-3)


# Encoders ----------------------------------------------------------------------------------------

COUNTS = {"encoders": {"type": "encoders", "noise": {"quantum": "1 mm"}}}


def test_encoders_count_how_far_the_wheels_have_rolled():
    scenario, found = suite(COUNTS, [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], limits="none")
    world = World.from_scenario(scenario)
    found.activate({0: ["encoders"], 1: ["encoders"]})
    for _ in range(100):
        world.set_commands(EVERY, np.array([[0.2, 0.0], [0.0, 0.5]]))
        world.step()
    found.update(100, world.sensed)
    straight, turning = (found.readings(world.time)[row]["encoders"].travel for row in (0, 1))
    assert straight == pytest.approx([0.4, 0.4])
    arc = 0.5 * 0.357 * 0.5 * 2.0  # half a track, 0.5 rad/s for 2 s
    assert turning == pytest.approx([-arc, arc], abs=0.51e-3)
    assert turning * 1000.0 == pytest.approx(np.round(turning * 1000.0), abs=1e-9)


def test_robots_without_wheels_have_no_encoders():
    with pytest.raises(
        ScenarioError, match="mounts.encoders: encoders, but a Crazyflie 2.x has no"
    ):
        suite(COUNTS, model="crazyflie2")


# Inertial sensors --------------------------------------------------------------------------------

IMU = {"imu": {"type": "imu"}}


def test_an_imu_feels_gravity_ramps_and_turns():
    step = 0.02
    before = state([[0.0, 0.0, 1.0]] * 2, [[0.5, 0.0, 0.0], [0.5, 0.0, 2.0]])
    now = state([[0.0, 0.0, 1.0]] * 2, [[0.51, 0.0, 0.0], [0.5, 0.0, 2.0]], time=step)
    ahead, circling = read(IMU, before, now)
    assert ahead.acceleration == pytest.approx([0.5, 0.0, GRAVITY])  # 0.01 m/s in 0.02 s
    assert circling.acceleration == pytest.approx(
        [0.0, 1.0, GRAVITY]
    )  # v omega, towards the centre
    assert circling.rate == pytest.approx([0.0, 0.0, 2.0])


def test_a_tilted_imu_feels_gravity_aslant():
    half = 0.5 * math.radians(30.0)
    pitched = Spatial(  # nose down by 30 deg
        np.array([1.0]), np.array([[0.0, math.sin(half), 0.0, math.cos(half)]]), np.zeros((1, 3))
    )
    pose, z = [[0.0, 0.0, 0.0]], np.array([1.0])
    before = state(pose, z=z, spatial=pitched)
    (reading,) = read(IMU, before, before.replace(time=0.02), model="crazyflie2")
    assert reading.acceleration == pytest.approx([-0.5 * GRAVITY, 0.0, math.sqrt(0.75) * GRAVITY])


def test_an_imu_without_a_step_before_says_nothing_yet():
    assert read(IMU, state([[0.0, 0.0, 0.0]])) == [None]


def test_a_compass_an_altimeter_and_motion_capture():
    at = state([[1.0, 2.0, 3.0]], z=np.array([1.5]))
    biased = {"compass": {"type": "compass", "noise": {"bias": "0.5 rad"}}}
    assert read(biased, at)[0].heading == pytest.approx(3.5 - 2.0 * math.pi)
    assert read({"height": {"type": "altimeter"}}, at)[0].height == 1.5
    capture = {"seen": {"type": "motion_capture", "noise": {"position": {"bias": 0.1}}}}
    assert read(capture, at)[0][1:] == pytest.approx((1.1, 2.1, 3.0))


@pytest.mark.parametrize(
    "latitude, north, east",
    [(0.0, 110574.0, 111320.0), (45.0, 111132.0, 78847.0), (60.0, 111412.0, 55800.0)],
)
def test_a_gps_tells_degrees_of_the_earth(latitude, north, east):
    along, across = radii(math.radians(latitude))
    assert math.radians(along) == pytest.approx(north, abs=1.0)
    assert math.radians(across) * math.cos(math.radians(latitude)) == pytest.approx(east, abs=1.0)
    mount = {"type": "gps", "origin": [latitude, 10.0, 400.0], "place": [0.5, 0.0, 0.2]}
    (reading,) = read({"gps": mount}, state([[100.0, 200.0, math.pi / 2.0]]))
    assert (reading.latitude - latitude) * north == pytest.approx(200.5, abs=2e-3)
    assert (reading.longitude - 10.0) * east == pytest.approx(100.0, abs=2e-3)
    assert reading.altitude == pytest.approx(400.2)


def test_longitudes_go_on_beyond_the_antimeridian():
    for meridian, x, degrees in ((180.0, 10.0, -179.99991017), (-180.0, -10.0, 179.99991017)):
        mount = {"type": "gps", "origin": [0.0, meridian, 0.0]}
        (reading,) = read({"gps": mount}, state([[x, 2.0, 0.0]]))
        assert reading.longitude == pytest.approx(degrees, abs=1e-8)
        back = local_place(reading, (0.0, math.radians(meridian), 0.0))
        assert back == pytest.approx((x, 2.0, 0.0), abs=1e-6)


@pytest.mark.parametrize(
    "mount, wanted",
    [
        ({"type": "gps", "origin": [91, 0, 0]}, "gps.origin: 91, wanted a number from -89 to 89"),
        ({"type": "gps", "origin": ["91 deg", 0, 0]}, "gps.origin"),
        ({"type": "gps", "origin": [True, 0, 0]}, "gps.origin: True"),
        ({"type": "range_bearing", "view": "400 deg"}, "x.view"),
        ({"type": "beacons", "points": []}, "x.points: .* wanted places of 1 to 1000 beacons"),
        ({"type": "beacons", "points": [[1.0]]}, r"x.points\[0\]: .* wanted \[x, y\]"),
        (
            {"type": "range_bearing", "noise": {"stddev": 1}},
            "x.noise: unknown 'stddev'.*bearing, range",
        ),
        ({"type": "bumper", "noise": {"stddev": 1}}, "x.noise: unknown 'stddev'"),
        ({"type": "bumper", "front": 2.5}, "x.front: 2.5"),
        ({"type": "sonar", "transducers": [[1e300, 0, 0]]}, "wanted a number from -100 to 100"),
    ],
)
def test_impossible_numbers_are_refused(mount, wanted):
    with pytest.raises(ScenarioError, match=wanted.replace("gps.origin", "x.origin")):
        suite({"x": mount})


@pytest.mark.parametrize("name", ["a b", "class", "_a", "\u00e9", "1a", "../x"])
def test_a_name_is_one_of_topics_and_attributes(name):
    with pytest.raises(ScenarioError, match="wanted letters, digits and _"):
        suite({name: {"type": "compass"}})


# Battery -----------------------------------------------------------------------------------------

CELL = {"type": "battery", "rate": 1.0, "capacity": "1 Wh", "idle": 20, "drive": 40, "turn": 10}


def test_a_battery_drains_with_use_without_a_subscriber():
    mount = dict(CELL, voltage=[10.0, 12.0], charge=0.5)
    _, found = suite({"battery": mount}, step=0.02, control={"rate": 1})
    assert not found.is_idle
    for step in range(0, 151, 50):  # at 0.5 m/s and 0.2 rad/s, 20 + 20 + 2 W
        found.update(step, lambda step=step: state([[0.0] * 3], [[0.5, 0.0, -0.2]], 0.02 * step))
    found.activate_from({0: ["battery"]}, 150, lambda: state([[0.0] * 3], time=3.0))
    reading = found.readings(3.0)[0]["battery"]
    found.activate_from({}, 151, lambda: state([[0.0] * 3], [[9.0, 0.0, 0.0]], 3.5))
    found.activate_from({0: ["battery"]}, 175, lambda: state([[0.0] * 3], [[9.0, 0.0, 0.0]], 3.5))
    reading = found.readings(3.5)[0]["battery"]  # a new listener drains nothing
    assert reading.stamp == 3.0 and reading.charge == pytest.approx(0.5 - 3 * 42.0 / 3600.0)
    assert reading.voltage == pytest.approx(10.0 + 2.0 * reading.charge)
    for step in range(200, 20001, 50):
        found.update(step, lambda step=step: state([[0.0] * 3], time=0.02 * step))
    assert found.readings(400.0)[0]["battery"].charge == 0.0
    found.begin()
    found.update(0, lambda: state([[0.0] * 3]))
    assert found.readings(0.0)[0]["battery"].charge == 0.5


def test_a_battery_says_what_it_wants():
    with pytest.raises(
        ScenarioError, match=r"voltage: \[3, 2\], wanted that of the empty one first"
    ):
        suite({"battery": dict(CELL, voltage=[3, 2])})
    with pytest.raises(ScenarioError, match="voltage: 3, wanted"):
        suite({"battery": dict(CELL, voltage=3)})


def test_readings_of_all_robots_at_once_are_those_of_each():
    mounts = {"sight": SEES["sight"], "laser": {}, "encoders": {"type": "encoders"}}
    mounts.update({name: {"type": name} for name in ("compass", "imu", "gps", "bumper", "battery")})
    _, found = suite(mounts, TRIANGLE)
    found.activate(dict.fromkeys(range(3), tuple(mounts)))
    for step in range(2):
        now = state(TRIANGLE, time=0.02 * step, travel=(np.ones((3, 2)),))
        found.update(step, lambda now=now: now)
    assert {sensor.mount.name for sensor in found.active if sensor.newest} == set(mounts)
    for sensor in found.active:
        for k, own in enumerate(of_robots(sensor.newest, 3)):
            alone = of_robot(sensor.newest, k)
            assert type(own) is type(alone)
            for value, wanted in zip(own, alone):
                np.testing.assert_array_equal(value, wanted)
                assert not getattr(getattr(value, "flags", None), "writeable", False)
