"""Sonar and laser against geometry worked out by hand."""

import math

import numpy as np
import pytest

from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.sensors.scenery import Rays, Scenery, cast
from mrs_simulator.sensors.state import State
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.vehicles import Team

CRATE = Box("crate", 3.0, 0.0, 0.0, 2.0, 1.0, 0.5)  # x from 2 to 4, y from -0.5 to 0.5
POST = Cylinder("post", 0.0, 3.0, 1.0, 0.5)  # from (0, 2) on
CLEAN = {"noise": {"stddev": 0.0}}


def along(*degrees, origin=(0.0, 0.0), height=0.1, owner=-2):
    angle = np.radians(degrees)
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)[np.newaxis]
    return Rays(np.array([[origin]], dtype=float), direction, np.array([height]), np.array([owner]))


def state(poses, **more):
    poses = np.array(poses, dtype=float)
    return State(0.0, poses, np.zeros_like(poses), **more)


def scenery(obstacles, kinds=("pioneer3dx",), poses=((50.0, 50.0, 0.0),)):
    return Scenery(Team(kinds), obstacles).at(state(poses))


def test_rays_meet_the_nearest_face_of_a_box_and_pass_beside_it():
    edge = math.degrees(math.atan2(0.5, 2.0))  # of the face at x = 2, as seen from 0
    found = cast(scenery([CRATE]), along(0.0, 10.0, edge + 0.01, 180.0, -10.0), 9.0)[0]
    slanted = 2.0 / math.cos(math.radians(10.0))
    assert found == pytest.approx([2.0, slanted, np.inf, np.inf, slanted])


def test_a_turned_box_is_met_at_its_corner():
    turned = CRATE._replace(yaw=math.pi / 4.0, length=1.0)  # a diamond about (3, 0)
    assert cast(scenery([turned]), along(0.0), 9.0)[0] == pytest.approx(3.0 - math.sqrt(0.5))


def test_rays_meet_a_cylinder():
    # At 80 deg the ray passes 3 cos 80 deg = 0.521 m beside the axis.
    beside = 3.0 * math.cos(math.radians(80.0))
    wanted = 3.0 * math.sin(math.radians(80.0)) - math.sqrt(1.0 - beside**2)
    tangent = 90.0 - math.degrees(math.asin(1.0 / 3.0))
    found = cast(scenery([POST]), along(90.0, 80.0, tangent - 0.01, 270.0), 9.0)[0]
    assert found == pytest.approx([2.0, wanted, np.inf, np.inf])


def test_a_ray_along_a_face_and_one_from_within_are_at_hand():
    assert cast(scenery([CRATE]), along(0.0, origin=(0.0, 0.5)), 9.0)[0] in ([2.0], [np.inf])
    within = cast(scenery([CRATE, POST]), along(0.0, 45.0, origin=(3.0, 0.2)), 9.0)
    assert np.array_equal(within, [[0.0, 0.0]])
    assert np.array_equal(cast(scenery([POST]), along(0.0, origin=(0.0, 2.5)), 9.0), [[0.0]])


def test_what_is_lower_than_the_ray_or_beyond_its_reach_is_not_met():
    assert cast(scenery([CRATE]), along(0.0, height=0.5), 9.0)[0, 0] == np.inf
    assert cast(scenery([CRATE]), along(0.0, height=0.49), 2.0)[0, 0] == 2.0
    assert cast(scenery([CRATE]), along(0.0), 1.99)[0, 0] == np.inf


def test_the_nearest_of_several_counts_whatever_their_order():
    near = CRATE._replace(name="near", x=2.0)
    for obstacles in ([CRATE, near], [near, CRATE]):
        assert cast(scenery(obstacles), along(0.0), 9.0)[0, 0] == pytest.approx(1.0)


def test_rays_of_one_robot_may_begin_far_from_each_other():
    rays = along(0.0, 0.0)._replace(origin=np.array([[[0.0, 40.0], [0.0, 0.0]]]))
    assert cast(scenery([CRATE]), rays, 2.5)[0] == pytest.approx([np.inf, 2.0])


def cone(degrees, toward, obstacles, **more):
    half = math.radians(0.5 * degrees)
    return cast(scenery(obstacles), along(toward, **more), 9.0, cone=half)[0, 0]


def test_a_cone_measures_the_nearest_point_within_it():
    # Straight ahead the face's foot; looking 20 deg aside, the edge ray at 5 deg is nearest.
    assert cone(30.0, 0.0, [CRATE]) == pytest.approx(2.0)
    assert cone(30.0, 20.0, [CRATE]) == pytest.approx(2.0 / math.cos(math.radians(5.0)))
    assert cone(30.0, 30.0, [CRATE]) == np.inf  # the corner is at 14.04 deg
    corner = math.hypot(2.0, 0.5)
    assert cone(60.0, 14.0 + 30.0, [CRATE]) == pytest.approx(corner, abs=1e-3)
    assert cone(30.0, 90.0 - 15.0 + 0.1, [POST]) == pytest.approx(2.0, abs=1e-3)


@pytest.mark.parametrize("obstacle", [CRATE, CRATE._replace(yaw=0.7), POST])
def test_a_cone_is_the_least_of_many_rays(obstacle):
    shapes = scenery([obstacle])
    for toward in np.arange(-60.0, 140.0, 7.3):
        fan = cast(shapes, along(*np.linspace(toward - 20.0, toward + 20.0, 4001)), 9.0).min()
        assert cone(40.0, toward, [obstacle]) == pytest.approx(fan, abs=2e-4)


def test_robots_are_seen_as_their_outlines_and_none_sees_itself():
    kinds, poses = ("pioneer3dx", "epuck"), [[0.0, 0.0, 0.0], [3.0, 0.0, 1.0]]
    shapes = scenery([], kinds, poses)
    assert cast(shapes, along(0.0, height=0.08, owner=0), 9.0)[0, 0] == pytest.approx(3.0 - 0.035)
    assert cast(shapes, along(0.0, height=0.1, owner=0), 9.0)[0, 0] == np.inf  # 86 mm high
    back = along(180.0, origin=(3.0, 0.0), height=0.08, owner=1)
    assert cast(shapes, back, 9.0)[0, 0] == pytest.approx(3.0 - 0.210)  # the Pioneer's front
    behind = along(0.0, origin=(-3.0, 0.0), height=0.08)
    assert cast(shapes, behind, 9.0)[0, 0] == pytest.approx(3.0 - 0.301)
    unseen = cast(shapes, behind, 9.0, unseen=np.array([0]))
    assert unseen[0, 0] == pytest.approx(6.0 - 0.035)


def test_robots_at_another_height_are_not_met():
    team, poses = Team(("crazyflie2", "crazyflie2")), [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]
    shapes = Scenery(team).at(state(poses, z=np.array([1.0, 1.5])))
    assert cast(shapes, along(0.0, height=1.51, owner=0), 9.0)[0, 0] == pytest.approx(2.0 - 0.06)
    assert cast(shapes, along(0.0, height=1.49, owner=0), 9.0)[0, 0] == np.inf


def suite(content, names):
    scenario = scenario_from_dict(content)
    result = Suite.of_scenario(scenario, Team.from_scenario(scenario))
    result.activate(dict.fromkeys(range(scenario.n), names))
    result.update(0, lambda: state(scenario.poses))
    return result.readings(0.0)


def test_the_sonar_of_a_pioneer_between_two_walls():
    walls = [
        {"type": "wall", "from": [-9.0, 1.05], "to": [9.0, 1.05], "thickness": 0.1},
        {"type": "wall", "from": [2.05, -9.0], "to": [2.05, 9.0], "thickness": 0.1},
    ]
    mounts = {"sonar": dict(CLEAN, cone=0.0)}
    content = {"poses": [[0.0, 0.0, 0.0]], "obstacles": walls, "sensors": [{"mounts": mounts}]}
    ranges = suite(content, ["sonar"])[0]["sonar"].ranges
    assert ranges[[0, 15]] == pytest.approx(1.0 - 0.136)  # at 90 deg, y 0.136 m
    assert ranges[3] == pytest.approx((2.0 - 0.166) / math.cos(math.radians(10.0)))
    assert ranges[1] == pytest.approx((1.0 - 0.119) / math.sin(math.radians(50.0)))
    assert np.all(ranges[8:12] == np.inf)
    # Turned by 90 degrees the robot's front is at the first wall.
    content["poses"] = [[0.0, 0.0, math.pi / 2.0]]
    reading = suite(content, ["sonar"])[0]["sonar"]
    assert reading.ranges[3] == pytest.approx((1.0 - 0.166) / math.cos(math.radians(10.0)))
    assert reading.points[3, 0] == pytest.approx(1.0)  # ahead of the robot
    assert reading.ranges[7] == pytest.approx(2.0 - 0.136)


def test_what_is_too_near_reads_as_the_least_range_and_noise_makes_no_echo():
    near = {"type": "box", "center": [1.0, 0.0], "size": [1.5, 1.0]}
    content = {"poses": [[0.0, 0.0, 0.0]], "obstacles": [near]}
    mounts = {"sonar": {"noise": {"stddev": 0.5}, "range": [0.4, 3.0]}}
    content["sensors"] = [{"mounts": mounts}]
    ranges = suite(content, ["sonar"])[0]["sonar"].ranges
    heard = np.isfinite(ranges)
    assert ranges.min() == 0.4 and ranges[heard].max() <= 3.0
    assert np.all(ranges[8:12] == np.inf)


def test_a_laser_scans_from_its_mount():
    wall = {"type": "wall", "from": [-9.0, 1.05], "to": [9.0, 1.05], "thickness": 0.1}
    laser = dict(CLEAN, place=[0.1, 0.0, 0.3], yaw="90 deg")
    content = {
        "poses": [[0.0, 0.0, 0.0]],
        "obstacles": [wall],
        "sensors": [{"mounts": {"laser": laser}}],
    }
    reading = suite(content, ["laser"])[0]["laser"]
    assert reading.ranges.shape == (181,)
    assert reading.ranges[90] == pytest.approx(1.0)
    assert reading.ranges[60] == pytest.approx(1.0 / math.cos(math.radians(30.0)))
    assert reading.points[60] == pytest.approx([0.1 + math.tan(math.radians(30.0)), 1.0])
    assert reading.ranges[0] == np.inf


def test_robots_read_together_read_what_they_read_alone():
    rng = np.random.default_rng(3)
    poses = np.column_stack([rng.uniform(-6.0, 6.0, (12, 2)), rng.uniform(-3.0, 3.0, 12)])
    kinds = ("pioneer3dx", "pioneer3at", "turtlebot3_burger") * 4
    shapes = scenery([CRATE, POST], kinds, poses)
    angle = poses[:, 2:] + np.linspace(-1.5, 1.5, 31)
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    rays = Rays(poses[:, np.newaxis, :2], direction, np.full(12, 0.1), np.arange(12))
    together = cast(shapes, rays, 7.0)
    assert np.isfinite(together).sum() > 30
    for row in range(12):
        alone = Rays(*(each[row : row + 1] for each in rays))
        assert np.array_equal(cast(shapes, alone, 7.0)[0], together[row])


def test_transducers_that_take_turns_repeat_their_last_echoes():
    wall = {"type": "box", "name": "wall", "center": [3.5, 0.0], "size": [1.0, 9.0]}
    ahead = [["0 m", "0 m", "0 deg"]] * 4
    ring = {"type": "sonar", "transducers": ahead, "turns": 4, "cycle": "0.04 s", **CLEAN}
    content = {
        "poses": [[0.0, 0.0, 0.0]],
        "obstacles": [wall],
        "sensors": [{"mounts": {"ring": ring}}],
    }
    suite = suite_of(content)
    heard = []
    for step in range(0, 21, 5):  # samples of 0.1 s, in which the robot drives 0.1 m
        now = state([[0.02 * step, 0.0, 0.0]]).replace(time=0.02 * step)
        suite.update(step, lambda now=now: now)
        heard.append(suite.readings(0.02 * step)[0]["ring"].ranges.tolist())
    # Turns 1 and 2 are over by 0.1 s, then 3, 4 (the first transducer), and 5 at 0.2 s, and so on.
    wanted = [[3.0, 3.0, 3.0, 3.0], [3.0, 2.9, 2.9, 3.0], [2.8, 2.8, 2.9, 2.8]]
    wanted += [[2.8, 2.8, 2.7, 2.7], [2.6, 2.6, 2.6, 2.7]]
    np.testing.assert_allclose(heard, wanted, atol=1e-12)
    suite.begin()
    suite.update(0, lambda: state([[0.5, 0.0, 0.0]]))
    assert suite.readings(0.0)[0]["ring"].ranges == pytest.approx([2.5] * 4)  # all at first


def suite_of(content):
    scenario = scenario_from_dict(content)
    suite = Suite.of_scenario(scenario, Team.from_scenario(scenario))
    suite.activate({0: ["ring"]})
    return suite
