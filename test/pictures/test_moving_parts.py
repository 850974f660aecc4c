"""Wheels roll as far as robots go, rotors spin in the air, and things of one look are drawn together."""

import numpy as np
import pytest

from mrs_simulator.core.spatial import upright
from mrs_simulator.pictures.camera import Camera
from mrs_simulator.pictures.instances import instances
from mrs_simulator.pictures.moving_parts import Odometer, frames, parted, rolled_angle, spin_angle
from mrs_simulator.pictures.palette import LIGHT
from mrs_simulator.pictures.scene import Scene, _corners, drawn
from mrs_simulator.pictures.solids import kind_model
from mrs_simulator.pictures.trails import MOST_FAR, MOST_NEAR, shown_trails
from mrs_simulator.pictures.turning import posed
from mrs_simulator.pictures.view import View
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.vehicles import kind

HERE = np.zeros((1, 3)), np.eye(3)[np.newaxis]
COUNTS = {
    "pioneer3dx": (2, 0),
    "pioneer3at": (4, 0),
    "turtlebot3_burger": (2, 0),
    "youbot": (4, 0),
    "robotino3": (3, 0),
    "f1tenth": (4, 0),
    "crazyflie2": (0, 4),
    "ardrone2": (0, 4),
    "heron": (0, 0),
}


def scene(pose, name="pioneer3dx", spatial=None, joints=None, **given):
    pose = np.array(pose, dtype=float).reshape(-1, 3)
    numbers = tuple(range(1, len(pose) + 1))
    state = StateTable(0.3, numbers, pose=pose, spatial=spatial, joints=joints)
    shades = np.tile((1.0, 0.0, 0.0), (len(pose), 1))
    return Scene((kind(name),) * len(pose), state, shades)._replace(**given)


@pytest.mark.parametrize("name", COUNTS)
def test_wheels_and_rotors_of_shipped_kinds_are_known(name):
    moving = parted(kind(name))[1]
    assert (sum(not p.is_rotor for p in moving), sum(p.is_rotor for p in moving)) == COUNTS[name]
    assert sum(part.is_steered for part in moving) == 2 * (name == "f1tenth")


def top_of(part, rolled):
    """Return where the point on top of a wheel is once the robot, standing at 0, has ``rolled``."""
    place, turn = frames(part, *HERE, rolled_angle(part, np.array([rolled], dtype=float)))
    top = part.place[:3, :3].T @ (0.0, 0.0, part.radius)
    return (place + turn @ top)[0] - part.place[:3, 3]


def test_wheels_roll_by_as_much_as_their_places_move():
    left, right = sorted(parted(kind("pioneer3dx"))[1], key=lambda part: -part.place[1, 3])
    for part in (left, right):
        assert top_of(part, (0.0, 0.0, 0.0)) == pytest.approx([0.0, 0.0, part.radius], abs=1e-6)
        ahead = top_of(part, (0.5 * np.pi * part.radius, 0.0, 0.0))  # a quarter of a turn
        assert ahead == pytest.approx([part.radius, 0.0, 0.0], abs=1e-6)
    # On the spot to the left: the wheel on the left goes back, that on the right ahead.
    turned = top_of(left, (0.0, 0.0, 0.1)), top_of(right, (0.0, 0.0, 0.1))
    assert turned[0][0] < -0.001 and turned[1][0] == pytest.approx(-turned[0][0])


def test_omnidirectional_wheels_do_not_roll_along_their_axes():
    for part in parted(kind("robotino3"))[1]:
        axis = part.place[:2, 2] / np.linalg.norm(part.place[:2, 2])
        slips, rolls = (
            rolled_angle(part, np.array([(*way, 0.0)])) for way in (axis, (-axis[1], axis[0]))
        )
        assert slips[0] == pytest.approx(0.0, abs=1e-9)
        assert abs(rolls[0]) == pytest.approx(1.0 / part.radius)


def test_the_front_wheels_of_a_car_steer():
    for part in parted(kind("f1tenth"))[1]:
        axis = frames(part, *HERE, np.zeros(1), np.array([0.3]))[1][0, :, 2]
        angle = np.arctan2(axis[1], axis[0]) % np.pi - 0.5 * np.pi
        assert angle == pytest.approx(0.3 if part.place[0, 3] > 0.2 else 0.0, abs=1e-9)


def test_rotors_beside_each_other_spin_the_other_way_round_and_only_in_the_air():
    rotors = parted(kind("crazyflie2"))[1]
    place = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
    angles = np.array([spin_angle(place, part, 0.03) for part in rotors])
    assert not angles[:, 0].any()
    assert sorted(np.sin(angles[:, 1]) > 0.0) == [False, False, True, True]
    assert spin_angle(place, rotors[0], 0.04)[1] != angles[0, 1]


def test_the_odometer_adds_up_the_way_of_each_robot_along_its_heading():
    odometer, turn = Odometer(), np.linspace(0.0, 4.0 * np.pi, 400)
    # Twice around a circle of 2 m, ahead; the other one goes aside.
    for angle in turn:
        circle = 2.0 * np.sin(angle), -2.0 * np.cos(angle), angle % (2.0 * np.pi)
        rolled = odometer.at((1, 2), np.array([circle, (0.0, angle, 0.0)]))
    assert rolled[0] == pytest.approx([8.0 * np.pi, 0.0, 4.0 * np.pi], rel=1e-3, abs=1e-3)
    assert rolled[1] == pytest.approx([0.0, 4.0 * np.pi, 0.0])
    lost = odometer.at((1, 2), np.full((2, 3), np.nan))
    assert (lost == rolled).all()
    assert not odometer.at((1,), np.zeros((1, 3))).any()  # another team


def test_all_wheels_of_a_kind_are_drawn_by_one_call_and_turn():
    pose = [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (np.nan, 0.0, 0.0)]
    body, wheels = instances(scene(pose, rolled=np.array([(0.05, 0, 0)] * 3)), LIGHT.obstacle)
    assert len(body.place) == 2 and body.has_nose and len(wheels.place) == 4
    still = instances(scene(pose), LIGHT.obstacle)[1]
    assert np.allclose(still.place, wheels.place) and not np.allclose(still.turn, wheels.turn)


def test_the_disc_of_a_rotor_is_seen_through():
    team = scene([(0, 0, 0)] * 2, "crazyflie2", upright(np.zeros(2), np.ones(2)))
    found = instances(team, LIGHT.obstacle)
    assert sorted((each.opacity < 1.0, len(each.place)) for each in found) == [
        (False, 2),
        (False, 8),
        (True, 8),
    ]


def test_obstacles_are_two_bodies_scaled_to_the_size_of_each():
    boxes = Box("a", 1.0, 2.0, 0.4, 3.0, 0.5, 0.6), Box("b", -1.0, 0.0, 0.0, 0.3, 0.3, 0.3)
    post = Cylinder("c", 4.0, 1.0, 0.3, 0.9)
    found = instances(scene([(0, 0, 0)], obstacles=(*boxes, post)), LIGHT.obstacle)[2:]
    assert [len(each.place) for each in found] == [1, 2]
    corners = [
        place + each.model.vertices @ turn.T
        for each in found
        for place, turn in zip(each.place, each.turn)
    ]
    for own, obstacle in zip(corners, (post, *boxes)):
        wanted = _corners((obstacle,))
        assert own.min(axis=0) == pytest.approx(wanted.min(axis=0))
        assert own.max(axis=0) == pytest.approx(wanted.max(axis=0))


def test_trails_are_thinned_to_what_is_seen_and_end_where_they_did():
    pose = [(0.0, 0.0, 0.0)] * 30 + [(900.0, 0.0, 0.0)] * 30
    steps = np.linspace(0.0, 1.0, 3000)[:, np.newaxis] * (1.0, 2.0, 0.0)
    team = scene(pose, trails=tuple(np.array([(x, y, 0.0)]) + steps for x, y, _ in pose))
    view = View(Camera(), 600, 400, LIGHT)
    found = shown_trails(team, view)
    assert all((a[-1] == b[-1]).all() for a, b in zip(found, team.trails))
    near, far = (sum(map(len, part)) for part in (found[:30], found[30:]))
    assert 0.4 * MOST_NEAR < near <= MOST_NEAR + 30 and 0.4 * MOST_FAR < far <= MOST_FAR + 30
    longer = team._replace(trails=tuple(np.vstack([t, t[-1:] + 0.1]) for t in team.trails))
    assert (shown_trails(longer, view)[0][: len(found[0]) - 1] == found[0][:-1]).all()
    few = team._replace(trails=team.trails[:2], kinds=team.kinds[:2])
    assert [len(each) for each in shown_trails(few, view)] == [3000, 3000]


@pytest.mark.parametrize("name", COUNTS)
def test_painted_parts_turn_as_those_of_the_graphics_card(name):
    joints = np.array([[0.4], [-0.3]]) if name == "f1tenth" else None
    spatial = upright(np.zeros(2), np.ones(2)) if kind(name).module.MEDIUM == "air" else None
    rolled = np.array([(0.07, 0.02, 0.3), (0.0, 0.0, 0.0)])
    motion = scene([(0, 0, 0)] * 2, name, spatial, joints, rolled=rolled).motion
    model, moving = posed(kind(name), motion), parted(kind(name))[1]
    if not moving:
        assert model is kind_model(kind(name))
        return
    level = np.zeros((2, 3)), np.array([np.eye(3)] * 2)
    first = 0
    for part in moving:
        place, turn = motion.frames(part, *level)
        count = model.begins[0] // len(moving)
        marks = model.vertices[:, first : first + count]
        own = (marks - place[:, np.newaxis]) @ turn  # into the part's frame, where they rest
        assert np.allclose(own[0], own[1]) and np.hypot(*own[0, :, :2].T).max() < 1.01 * part.radius
        first += count
    # Each face's plane is still that of its corners.
    normals = np.broadcast_to(model.normals, (2, len(model.counts), 3))
    offsets = np.broadcast_to(model.offsets, normals.shape[:2])
    face = np.repeat(np.arange(len(model.counts)), model.counts)
    along = np.einsum("mcd,mcd->mc", normals[:, face], model.vertices[:, model.corners])
    assert np.allclose(along, offsets[:, face])


def test_a_painted_picture_shows_wheels_roll_and_rotors_spin():
    camera = Camera(distance=1.5)
    for name, spatial in (("pioneer3dx", None), ("crazyflie2", upright(np.zeros(1), np.ones(1)))):
        still = scene([(0, 0, 0)], name, spatial)
        moved = still._replace(
            rolled=np.array([(0.03, 0.0, 0.0)]), state=still.state.replace(time=0.32)
        )
        if spatial is not None:
            camera = Camera((0.0, 0.0, 1.0), 0.4)
        first, then = (
            max(
                drawn(each, camera, 300, 200).layers,
                key=lambda layer: len(getattr(layer, "counts", ())),
            )
            for each in (still, moved)
        )
        apart = np.hypot(*(first.points - then.points).T) > 0.5
        assert 0.02 < apart.mean() < 0.6 and (first.counts == then.counts).all()
