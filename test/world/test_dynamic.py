"""Full dynamics: what a Pioneer on its wheels does, and that it agrees with a finer solver."""

import math
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.scenario.team.layouts import make_layout
from mrs_simulator.vehicles import kind
from mrs_simulator.world.motion.dynamic import DynamicMotion
from mrs_simulator.world.world import World

ONE = ("pioneer3dx",)
PIONEER = kind("pioneer3dx")


@pytest.fixture
def motion():
    made = []

    def make(poses, **options):
        made.append(DynamicMotion(ONE * len(poses), np.array(poses, dtype=float), **options))
        return made[-1]

    yield make
    for each in made:
        each.close()


def advance(motion, command, seconds):
    command = np.broadcast_to(np.asarray(command, dtype=float), (len(motion.pose), 2))
    for _ in range(int(round(seconds / motion.step))):
        motion.advance(command)
    return motion


def test_robots_that_all_stand_do_not_creep_and_drive_on_from_there(motion):
    robots = advance(motion([[0.0, 0.0, 0.7], [3.0, 0.0, 0.7]]), [[0.5, 0.2], [0.0, 0.0]], 0.5)
    stopped = advance(robots, [0.0, 0.0], 1.5).pose.copy()
    assert np.hypot(*stopped[0, :2]) > 0.03
    np.testing.assert_array_equal(advance(robots, [0.0, 0.0], 4.0).pose, stopped)
    assert not robots.twist.any()
    advance(robots, [[0.0, 0.0], [0.5, 0.0]], 0.5)
    gone = np.hypot(*(robots.pose - stopped)[:, :2].T)
    assert gone[1] > 0.03 > 1e-3 > gone[0]


def test_straight_on_as_the_ramp_says(motion):
    # 0.5 m/s at 0.3 m/s^2: 0.5^2/0.6 m while speeding up, then 0.5 m/s.
    moved = advance(motion([[0.0, 0.0, 0.0]]), [0.5, 0.0], 3.0)
    expected = 0.25 / 0.6 + 0.5 * (3.0 - 0.5 / 0.3)
    assert moved.pose[0, 0] == pytest.approx(expected, abs=0.01)
    assert abs(moved.pose[0, 1]) < 1e-3 and abs(moved.pose[0, 2]) < 1e-3
    assert moved.twist[0] == pytest.approx([0.5, 0.0, 0.0], abs=0.01)
    np.testing.assert_allclose(moved.wheel_travel[0], expected, atol=0.01)


def test_turning_on_the_spot_stays_there(motion):
    turned = advance(motion([[1.0, 1.0, 0.0]]), [0.0, 1.0], 3.0)
    expected = 0.5 / math.radians(100.0) + (3.0 - 1.0 / math.radians(100.0))
    assert turned.pose[0, 2] == pytest.approx(expected, abs=0.02)
    assert np.linalg.norm(turned.pose[0, :2] - 1.0) < 0.01
    assert turned.twist[0, 2] == pytest.approx(1.0, abs=0.01)


def test_a_circle_has_its_radius(motion):
    moved = motion([[0.0, 0.0, 0.0]], limits="top")
    advance(moved, [0.5, 0.5], 2.0)
    begin = moved.pose[0].copy()
    advance(moved, [0.5, 0.5], 2.0 * math.pi / 0.5 / 2.0)
    # Half a turn later it is across the circle, 2 v/omega = 2 m away.
    assert np.linalg.norm(moved.pose[0, :2] - begin[:2]) == pytest.approx(2.0, abs=0.03)


def test_at_rest_it_stays_at_rest(motion):
    stood = advance(motion([[0.0, 0.0, 0.7]]), [0.0, 0.0], 5.0)
    # The solver lets it creep by 0.2 mm/s at most.
    assert np.linalg.norm(stood.pose[0, :2]) < 2e-3
    assert abs(stood.pose[0, 2] - 0.7) < 1e-3


def test_head_on_robots_stop_each_other_and_are_named():
    poses = [[0.0, 0.0, 0.0], [1.2, 0.0, np.pi]]
    world = World(ONE * 2, poses, fidelity="dynamic", limits="top")
    for _ in range(150):
        world.set_commands([0, 1], np.array([[0.4, 0.0], [0.4, 0.0]]))
        world.step()
    collisions = world.contacts.take()
    distance = world.motion.closest()
    world.close()
    assert collisions[0][1:3] == ("robot1", "robot2")
    assert collisions[0].x == pytest.approx(0.6, abs=0.1)
    assert distance > 2.0 * PIONEER.body.front - 0.03


@pytest.mark.parametrize(
    "obstacle", [Box("crate", 1.5, 0.0, 0.4, 0.8, 0.8, 0.5), Cylinder("post", 1.2, 0.0, 0.2, 0.5)]
)
def test_an_obstacle_stops_a_robot_and_is_named(obstacle):
    world = World(ONE, [[0.0, 0.0, 0.0]], obstacles=[obstacle], fidelity="dynamic", limits="top")
    for _ in range(200):
        world.set_commands([0], np.array([[0.4, 0.0]]))
        world.step()
    named = {collision[1:3] for collision in world.contacts.take()}
    x = world.pose[0, 0]
    world.close()
    assert named == {("robot1", obstacle.name)}
    assert x < 1.2


def script(step, n):
    """A varied drive, other for each robot."""
    phase = 0.05 * step + np.arange(n)
    return np.stack([0.4 + 0.3 * np.sin(phase), 0.9 * np.cos(1.7 * phase)], axis=1)


def trajectory(motion, steps=250):
    return np.array(
        [(motion.advance(script(step, len(motion.pose))), motion.pose)[1] for step in range(steps)]
    )


def test_the_quick_solver_agrees_with_the_untuned_reference(motion):
    poses = make_layout("grid", 4, spacing=4.0)
    quick = trajectory(motion(poses))
    reference = trajectory(motion(poses, substep=1.0 / 240.0, iterations=50))
    # The stated tolerance: 2 cm and 0.02 rad over 5 s of driving about.
    assert np.abs(quick - reference)[:, :, :2].max() < 0.02
    assert np.abs(quick - reference)[:, :, 2].max() < 0.02


def test_the_same_drive_gives_the_same_bytes(motion):
    poses = make_layout("grid", 3, spacing=1.0)
    used, unused = motion(poses), motion(poses)
    first = trajectory(used, 100)
    np.testing.assert_array_equal(first, trajectory(unused, 100))
    client = used._client
    used.close()
    again = motion(poses)  # in the solver that was given back, and emptied
    assert again._client == client
    np.testing.assert_array_equal(first, trajectory(again, 100))


@pytest.mark.parametrize("n", [60, pytest.param(200, marks=pytest.mark.release)])
def test_many_robots_stand_and_drive(n, motion):
    poses = make_layout("grid", n, spacing=1.5)
    moved = advance(motion(poses), [0.3, 0.0], 1.0)
    ahead = moved.pose[:, 0] - poses[:, 0]
    np.testing.assert_allclose(ahead, 0.15, atol=0.01)


def test_the_model_file_has_the_constants():
    root = ET.parse(PIONEER.model).getroot()
    mass = sum(float(m.get("value")) for m in root.iter("mass"))
    assert mass == pytest.approx(PIONEER.mass)
    joints = {joint.get("name"): joint for joint in root.iter("joint")}
    offsets = [
        float(joints[name].find("origin").get("xyz").split()[1]) for name in PIONEER.numbers.joints
    ]
    assert offsets == pytest.approx([0.5 * PIONEER.numbers.track, -0.5 * PIONEER.numbers.track])
    links = {link.get("name"): link for link in root.iter("link")}
    for name in ("left_wheel", "right_wheel"):
        radius = links[name].find("collision/geometry/sphere").get("radius")
        assert float(radius) == PIONEER.numbers.radius
    body = links["base_link"].find("collision")
    length, width, height = map(float, body.find("geometry/box").get("size").split())
    x, _, z = map(float, body.find("origin").get("xyz").split())
    assert (length, width) == pytest.approx((PIONEER.body.length, PIONEER.body.width))
    assert x + 0.5 * length == pytest.approx(PIONEER.body.front)
    assert PIONEER.numbers.radius + z + 0.5 * height == pytest.approx(PIONEER.body.height)
