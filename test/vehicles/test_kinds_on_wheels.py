"""The shipped kinds on wheels: closed forms with typed-out numbers, and their models."""

import math
import os
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from test_drives_omnidirectional import top_speed_along

from mrs_simulator.vehicles import kind, shipped_kinds
from mrs_simulator.vehicles.drives import car, differential
from mrs_simulator.vehicles.drives import omnidirectional as omni
from mrs_simulator.world.world import World

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
with open(os.path.join(ROOT, "docs", "kinds.md"), encoding="utf-8") as page:
    PAGE = page.read()

ON_WHEELS = tuple(
    name
    for name in shipped_kinds()
    if kind(name).module.MEDIUM == "ground" and kind(name).arm is None
)

DIFFERENTIAL = {
    # kind: forward m/s, turn on the spot deg/s, track m, wheel radius m, and the wheels' rad/s at
    # 0.1 m/s and 0.5 rad/s
    "pioneer3dx": (0.75, 100.0, 0.357, 0.09, 0.1194444, 2.1027778),
    "pioneer3at": (0.75, 100.0, 0.588, 0.111, -0.4234234, 2.2252252),
    "amigobot": (0.75, 100.0, 0.182, 0.05, 1.09, 2.91),
    "turtlebot3_burger": (0.22, 162.72, 0.160, 0.033, 1.8181818, 4.2424242),
    "husky": (1.0, 114.5916, 1.07025, 0.1651, -1.0149152, 2.2263023),
    "epuck": (0.1288, 278.4575, 0.053, 0.0205, 4.2317073, 5.5243902),
}


def limits(name, preset="firmware"):
    """Return axis -> (greatest speed, acceleration) of a kind."""
    each = kind(name)
    return dict(zip(each.axes, each.limits[preset]))


def one(*values):
    return np.array([values])


@pytest.mark.parametrize("name", sorted(DIFFERENTIAL))
def test_differential_kinds_have_the_numbers_of_their_sources(name):
    forward, turn, track, radius, left, right = DIFFERENTIAL[name]
    top, numbers = limits(name), kind(name).numbers
    assert top["linear.x"].top == forward
    assert math.degrees(top["angular.z"].top) == pytest.approx(turn, abs=0.01)
    assert (numbers.track, numbers.radius) == pytest.approx((track, radius))
    wheels = differential.rim_speeds(one(0.1, 0.5), None, numbers) / radius
    np.testing.assert_allclose(wheels, one(left, right), atol=1e-6)


@pytest.mark.parametrize(
    "name, forward, turn, acceleration",
    [
        ("pioneer3dx", 1.5, 360.0, 2.0),
        ("pioneer3at", 1.2, 300.0, 2.0),
        ("amigobot", 1.0, 300.0, 2.0),
    ],
)
def test_the_firmware_accepts_higher_settings(name, forward, turn, acceleration):
    top = limits(name, "top")
    assert top["linear.x"] == (forward, acceleration)
    assert math.degrees(top["angular.z"].top) == pytest.approx(turn)


def test_the_husky_slides_when_it_turns():
    numbers = kind("husky").numbers
    assert numbers.track == pytest.approx(1.875 * 0.5708)
    assert limits("husky")["linear.x"].acceleration == 3.0
    assert limits("husky")["angular.z"].acceleration == 6.0
    assert kind("husky").command_timeout == 0.25


def test_the_burgers_turn_rate_is_above_what_its_speed_gives():
    top, numbers = limits("turtlebot3_burger"), kind("turtlebot3_burger").numbers
    assert 2.0 * top["linear.x"].top / numbers.track == pytest.approx(2.75)
    assert top["angular.z"].top == 2.84
    assert math.isinf(top["linear.x"].acceleration)


def test_one_turn_a_second_is_the_e_pucks_top_speed():
    top, numbers = limits("epuck"), kind("epuck").numbers
    assert 2.0 * math.pi * numbers.radius == pytest.approx(top["linear.x"].top, abs=1e-4)
    assert 2.0 * top["linear.x"].top / numbers.track == pytest.approx(
        top["angular.z"].top, abs=1e-3
    )


def test_robotino_top_speeds_and_wheels():
    each = kind("robotino3")
    numbers, top = each.numbers, np.array(each.limits["firmware"])[:, 0]
    assert numbers.rim_max == pytest.approx(0.589049, abs=1e-6)
    speeds = top_speed_along(np.radians([0.0, 90.0, 30.0, 60.0]), numbers)
    np.testing.assert_allclose(speeds, [0.680175, 0.589049, 0.589049, 0.680175], atol=1e-6)
    # On the spot its rims would allow 0.589/0.175 = 3.366 rad/s; its limit is pi.
    assert numbers.rim_max / 0.175 == pytest.approx(3.366, abs=1e-3)
    still = omni.limited(one(0.0, 0.0, 9.0), top, numbers)
    np.testing.assert_allclose(still, one(0.0, 0.0, math.pi))
    ahead = omni.limited(one(9.0, 0.0, 0.0), top, numbers)
    np.testing.assert_allclose(ahead, one(0.680175, 0.0, 0.0), atol=1e-6)
    wheels = omni.rim_speeds(one(0.3, 0.0, 0.0), None, numbers) / numbers.radius
    np.testing.assert_allclose(wheels, one(-4.330127, 0.0, 4.330127, 0.0), atol=1e-6)
    assert each.command_timeout == 0.5


@pytest.mark.parametrize(
    "twist, wheels",
    [
        ((0.5, 0.0, 0.0), (10.526316, 10.526316, 10.526316, 10.526316)),
        ((0.0, 0.5, 0.0), (-10.526316, 10.526316, 10.526316, -10.526316)),
        ((0.0, 0.0, 1.0), (-8.105263, 8.105263, -8.105263, 8.105263)),
    ],
)
def test_youbot_wheels(twist, wheels):
    numbers = kind("youbot").numbers
    turning = omni.rim_speeds(one(*twist), None, numbers) / numbers.radius
    np.testing.assert_allclose(turning, one(*wheels), rtol=1e-6)


def test_youbot_top_speeds():
    each = kind("youbot")
    speeds = top_speed_along(np.radians([0.0, 90.0, 45.0]), each.numbers)
    # Along a diagonal two wheels do all the work, so it is slower by the root of two.
    np.testing.assert_allclose(speeds, [0.8, 0.8, 0.565685], atol=1e-4)
    assert limits("youbot")["angular.z"].top == pytest.approx(0.8 / 0.385, abs=1e-3)


def test_f1tenth_radius_and_limits():
    each = kind("f1tenth")
    radius = each.numbers.wheelbase / math.tan(each.numbers.steering_max)
    assert radius == pytest.approx(0.7416, abs=1e-4)
    assert each.limits["firmware"][0] == (20.0, 9.51)
    assert (each.numbers.backward, each.numbers.steering_rate) == (5.0, 3.2)
    twist = car.twist_of(np.array([2.0]), np.array([0.2]), each.numbers)
    np.testing.assert_allclose(twist, one(2.0, 1.227801), rtol=1e-6)
    # A quarter of a second from straight ahead to the full steering angle, all but.
    assert each.numbers.steering_max / each.numbers.steering_rate == pytest.approx(0.1309, abs=1e-4)


def stands_at(root):
    """Return link -> place in base_link, (3,) [m]; the models' joints are not turned."""
    places, joints = {"base_link": np.zeros(3)}, list(root.iter("joint"))
    while joints:
        for joint in list(joints):
            parent = joint.find("parent").get("link")
            if parent in places:
                origin = joint.find("origin").get("xyz").split()
                places[joint.find("child").get("link")] = places[parent] + np.array(origin, float)
                joints.remove(joint)
    return places


def wheels_of(each):
    """Return where the wheels of a kind stand by its YAML file, (w, 2) [m]."""
    numbers = each.numbers
    if each.drive == "differential" and not numbers.wheelbase:
        return [(0.0, 0.5 * numbers.track), (0.0, -0.5 * numbers.track)]
    if each.drive == "differential":
        x, y = 0.5 * numbers.wheelbase, 0.5 * numbers.spacing
        return [(x, y), (x, -y), (-x, y), (-x, -y)]
    if each.drive == "car":
        x, y = numbers.wheelbase, 0.5 * numbers.track
        return [(0.0, y), (0.0, -y), (x, y), (x, -y)]
    rolling = np.array([row for row in numbers.rolling if any(row)])
    if len(rolling) == 3:  # omni wheels drive across their rays
        return [(distance * y, -distance * x) for x, y, distance in rolling]
    return [(0.235, 0.15), (0.235, -0.15), (-0.235, 0.15), (-0.235, -0.15)]


@pytest.mark.parametrize("name", ON_WHEELS)
def test_the_model_has_the_numbers_of_its_kind(name):
    each = kind(name)
    root = ET.parse(each.model).getroot()
    assert root.get("name") == name
    assert not list(root.iter("mesh"))
    mass = sum(float(item.get("value")) for item in root.iter("mass"))
    assert mass == pytest.approx(each.mass, rel=1e-4)
    links = {link.get("name"): link for link in root.iter("link")}
    places = stands_at(root)
    spheres = {
        link: float(item.find("collision/geometry/sphere").get("radius"))
        for link, item in links.items()
        if "wheel" in link
    }
    assert spheres
    assert set(spheres.values()) == {each.numbers.radius}
    standing = sorted(tuple(places[link][:2].round(4)) for link in spheres)
    np.testing.assert_allclose(standing, sorted(wheels_of(each)), atol=1e-4)
    joints = {joint.get("name") for joint in root.iter("joint")}
    assert set(each.numbers.joints) <= joints


@pytest.mark.parametrize("name", shipped_kinds())
def test_the_model_has_the_outline_of_its_kind(name):
    each = kind(name)
    collision = ET.parse(each.model).getroot().find("link[@name='base_link']/collision")
    x, y, z = map(float, collision.find("origin").get("xyz").split())
    shape = collision.find("geometry")[0]
    if each.body.round:
        assert shape.tag == "cylinder"
        assert (x, y, float(shape.get("radius"))) == (0.0, 0.0, each.body.front)
        height = float(shape.get("length"))
    else:
        length, width, height = map(float, shape.get("size").split())
        assert (x + 0.5 * length, 0.5 * length - x) == pytest.approx(
            (each.body.front, each.body.rear), abs=1e-4
        )
        assert width == pytest.approx(each.body.width)
    above = each.module.ride_height(each.numbers)
    assert above + z + 0.5 * height == pytest.approx(each.body.height, abs=1e-4)


@pytest.mark.parametrize("name", ["pioneer3at", "husky"])
def test_dry_friction_gives_a_skid_steers_effective_track(name):
    # Turning without torque: rims against sliding, y (rim - omega y) = x (omega x) for each wheel.
    numbers = kind(name).numbers
    x, y = 0.5 * numbers.wheelbase, 0.5 * numbers.spacing
    assert 2.0 * (x * x + y * y) / y == pytest.approx(numbers.track, rel=1e-3)


@pytest.mark.parametrize("name", ["pioneer3at", "husky"])
def test_a_skid_steer_with_forces_turns_as_fast_as_its_firmware_lets_it(name):
    top = kind(name).limits["firmware"][1].top
    world = World((kind(name),), [[0.0, 0.0, 0.0]], fidelity="dynamic", engine="planar")
    for _ in range(75):
        world.set_commands([0], np.array([[0.0, top]]))
        world.step()
    assert world.twist[0, 2] == pytest.approx(top, rel=1e-3)
    world.close()


def numbers_in(text):
    return {float(found) for found in re.findall(r"\d+(?:\.\d+)?", text)}


@pytest.mark.parametrize("name", shipped_kinds())
def test_the_page_of_kinds_has_the_numbers_of_each(name):
    each = kind(name)
    row = re.search(r"^\| `{}` \|.*$".format(name), PAGE, re.M).group()
    title, drive, outline, mass, speeds, ramps, wheels = (
        cell.strip() for cell in row.split("|")[2:-1]
    )
    assert title == each.title
    assert drive.startswith(each.drive)
    body = [each.body.front] if each.body.round else [each.body.length, each.body.width]
    assert numbers_in(outline) == {round(value, 6) for value in body}
    assert numbers_in(mass) == {each.mass}
    forward, turn = each.limits["firmware"][0], each.limits["firmware"][-1]
    said = numbers_in(speeds)
    if name != "robotino3":  # its rims are slower than that
        assert forward.top in said
    if math.isfinite(turn.top):
        assert any(min(abs(v - turn.top), abs(math.radians(v) - turn.top)) < 1e-6 for v in said)
    if math.isinf(forward.acceleration):
        assert ramps.startswith("its thrust" if each.drive == "vessel" else "none")
    else:
        assert forward.acceleration in numbers_in(ramps)
    if each.drive == "quadrotor":
        assert round(math.degrees(each.numbers.tilt_max), 2) in numbers_in(ramps)
        return
    if each.drive == "vessel":
        assert each.numbers.arm in numbers_in(wheels)
        return
    lengths = {"differential": ["track", "radius"], "car": ["wheelbase", "steering_max"]}
    known = {getattr(each.numbers, key) for key in lengths.get(each.drive, ["radius"])}
    assert (known if each.drive != "omnidirectional" or name == "robotino3" else set()) <= (
        numbers_in(wheels)
    )


@pytest.mark.parametrize("text", re.findall(r"```yaml\n(.*?)```", PAGE, re.S))
def test_the_kinds_written_on_the_page_drive(text, tmp_path):
    name = text.split()[1]
    (tmp_path / name).write_text(text)
    world = World((kind(str(tmp_path / name)),), [[0.0, 0.0, 0.0]])
    world.set_commands([0], np.full((1, len(world.team.axes)), 0.2))
    for _ in range(25):
        world.step()
    assert world.pose[0, 0] > 0.01
