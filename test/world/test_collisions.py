"""Overlaps of footprints, and the list of pairs against all pairs."""

from types import SimpleNamespace

import numpy as np
import pytest

from mrs_simulator.core.neighbours import close_pairs, least_distance, least_distance_over
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.vehicles.kind import Body
from mrs_simulator.world.clock import Clock
from mrs_simulator.world.contact import bodies, compiled_contacts
from mrs_simulator.world.contact.bodies import Bodies
from mrs_simulator.world.contact.collisions import (
    Footprints,
    Rectangles,
    VerletList,
    circle_overlap,
    rectangle_overlap,
)
from mrs_simulator.world.contact.contact_arrays import Contact, Touches
from mrs_simulator.world.contact.contacts import Contacts
from mrs_simulator.world.motion.kinematic import KinematicMotion
from mrs_simulator.world.world import EVERY, World


def rectangle(x, y, theta, half):
    axis = np.array([[np.cos(theta), np.sin(theta)]])
    return Rectangles(np.array([[x, y]]), axis, np.array(half))


def test_squares_side_by_side():
    depth, direction = rectangle_overlap(rectangle(0, 0, 0, [1, 1]), rectangle(1.5, 0.2, 0, [1, 1]))
    assert depth[0] == pytest.approx(0.5)
    np.testing.assert_allclose(direction, [[1.0, 0.0]])


def test_a_turned_square_reaches_farther():
    # Half a diagonal, sqrt 2, plus half a side, 1: they touch at 2.4142.
    turned = rectangle(2.4, 0, np.pi / 4, [1, 1])
    assert rectangle_overlap(rectangle(0, 0, 0, [1, 1]), turned)[0][0] == pytest.approx(
        np.sqrt(2) + 1 - 2.4
    )
    apart = rectangle(2.42, 0, np.pi / 4, [1, 1])
    assert rectangle_overlap(rectangle(0, 0, 0, [1, 1]), apart)[0][0] < 0.0


@pytest.mark.parametrize(
    "x, y, depth, direction",
    [
        (1.3, 0.0, 0.2, (1.0, 0.0)),  # beside a side
        (0.0, -1.7, -0.2, (0.0, -1.0)),
        (1.3, 1.4, 0.0, (0.6, 0.8)),  # beside a corner, at distance 0.5
        (0.9, 0.1, 0.6, (1.0, 0.0)),  # inside: out through the nearest side
    ],
)
def test_circle_against_a_square(x, y, depth, direction):
    found, toward = circle_overlap(rectangle(0, 0, 0, [1, 1]), np.array([[x, y]]), 0.5)
    assert found[0] == pytest.approx(depth, abs=1e-12)
    np.testing.assert_allclose(toward, [direction], atol=1e-12)


def test_the_footprint_lies_behind_the_axle():
    rows = Footprints([Body(0.21, 0.301, 0.425, 0.2)]).at(np.array([[1.0, 2.0, np.pi / 2]]))
    np.testing.assert_allclose(rows.middle, [[1.0, 2.0 - 0.0455]])
    np.testing.assert_allclose(rows.half, [0.2555, 0.2125])


def all_pairs(position, distance):
    near = np.linalg.norm(position[:, None] - position, axis=2) < distance
    return list(map(tuple, np.argwhere(np.triu(near, 1)).tolist()))


@pytest.mark.parametrize("n", [1, 2, 40, 300, 700])
def test_close_pairs_are_all_of_them(n):
    position = np.random.default_rng(n).uniform(-10.0, 10.0, (n, 2))
    first, second = close_pairs(position, 1.3)
    assert list(zip(first.tolist(), second.tolist())) == all_pairs(position, 1.3)


def test_the_list_of_pairs_misses_none_while_robots_move():
    draw = np.random.default_rng(1)
    position = draw.uniform(-8.0, 8.0, (300, 2))
    listed = VerletList(0.7)
    for _ in range(60):
        position += draw.normal(0.0, 0.05, position.shape)
        pairs = set(zip(*map(np.ndarray.tolist, listed.pairs(position))))
        assert set(all_pairs(position, 0.7)) <= pairs


def test_overlapping_robots_are_pushed_apart_by_half_each():
    bodies = Bodies(("pioneer3dx",) * 2)
    pose = np.array([[0.0, 0.0, 0.0], [0.0, 0.4, 0.0]])
    contacts = bodies.separate(pose)
    assert [contact[:2] for contact in contacts] == [("robot1", "robot2")]
    assert contacts[0].depth == pytest.approx(0.025)
    np.testing.assert_allclose(pose[:, 1], [-0.0125, 0.4125])
    assert not bodies.separate(pose)


@pytest.mark.parametrize(
    "obstacle", [Box("crate", 0.6, 0.0, 0.0, 1.0, 1.0, 0.5), Cylinder("post", 0.5, 0.0, 0.4, 0.5)]
)
def test_a_robot_is_pushed_out_of_an_obstacle(obstacle):
    bodies = Bodies(("pioneer3dx",), [obstacle])
    pose = np.zeros((1, 3))
    contacts = bodies.separate(pose)
    assert contacts[0][:2] == ("robot1", obstacle.name)
    assert pose[0, 0] < -0.1 + 1e-9
    assert not bodies.separate(pose)


@pytest.mark.parametrize("n", [2, 40, 300])
def test_the_least_distance_is_that_of_all_pairs(n):
    position = np.random.default_rng(n).uniform(-10.0, 10.0, (n, 2))
    apart = position[:, np.newaxis] - position[np.newaxis]
    every = np.linalg.norm(apart, axis=2)[np.triu_indices(n, 1)]
    assert least_distance(position) == pytest.approx(every.min(), abs=1e-15)
    assert least_distance(position[:1]) == np.inf
    assert least_distance(np.concatenate([position, position[:1]])) == 0.0
    assert least_distance(1e-9 * position) == pytest.approx(1e-9 * every.min(), rel=1e-6)


@pytest.mark.parametrize("n, dimension", [(2, 2), (7, 3), (40, 2), (300, 2)])
@pytest.mark.parametrize("speed", [0.0, 0.01, 1.0, 100.0])
def test_the_least_distance_over_time_is_the_least_of_all_samples(n, dimension, speed):
    draw = np.random.default_rng(n)
    steps = speed * draw.normal(size=(60, n, dimension))
    track = 10.0 * draw.normal(size=(n, dimension)) + np.cumsum(steps, axis=0)
    assert least_distance_over(track) == min(map(least_distance, track))
    assert least_distance_over(track[:, :1]) == np.inf
    track[40, 0] = track[40, 1]
    assert least_distance_over(track) == 0.0
    track[40, 0, 0] += 1e-9
    assert least_distance_over(track) == least_distance(track[40])


def test_no_robot_moves_farther_than_bodies_are_commanded():
    kinds, draw = ("pioneer3dx", "robotino3", "f1tenth"), np.random.default_rng(4)
    motion, shares = KinematicMotion(kinds, np.diag([9.0] * 3), limits="top"), []
    for step in range(300):
        if step % 10 == 0:
            command = draw.uniform(-1.5, 1.5, (3, 3))
        before = motion.pose
        motion.advance(command)
        moved = np.linalg.norm((motion.pose - before)[:, :2], axis=1).max()
        shares.append(moved / motion._farthest())
    assert 0.9 < max(shares) <= 1.0 + 1e-12


def drive_about(limits):
    poses = np.array([[1.2 * i, 1.3 * j, i + 2.0 * j] for i in range(6) for j in range(5)])
    post = [Cylinder("post", 3.0, 3.25, 0.15, 0.5), Box("crate", 5.4, 0.65, 0.3, 0.3, 0.2, 0.5)]
    world = World(("pioneer3dx",) * 30, poses, obstacles=post, limits=limits)
    draw, track, collisions = np.random.default_rng(3), [], []
    for step in range(400):
        if step % 40 == 0:
            world.set_commands(EVERY, draw.uniform(-0.6, 0.6, (30, 2)))
        world.step()
        track.append(np.concatenate([world.pose, world.twist], axis=1))
        collisions += world.contacts.take()
    return np.array(track), collisions, world.contacts.closest


@pytest.mark.parametrize("limits", ["top", None])
def test_bodies_that_cannot_have_met_need_no_look(limits, monkeypatch):
    looks = []
    pushed_apart = Bodies._pushed_apart
    monkeypatch.setattr(
        Bodies, "_pushed_apart", lambda *args: (looks.append(1), pushed_apart(*args))[1]
    )
    track, collisions, closest = drive_about(limits)
    seldom = len(looks)
    monkeypatch.setattr(Bodies, "_room_to_move", lambda *_: 0.0)
    each_step = drive_about(limits)
    np.testing.assert_array_equal(track, each_step[0])
    assert (collisions, closest) == each_step[1:] and len(collisions) > 5
    assert seldom < len(looks) - seldom == 400


def piles(monkeypatch, push):
    """Return contacts and poses of piles pushed apart by ``push``, None: by numpy, and how often."""
    used, draw, found = [], np.random.default_rng(7), []

    def noted(*given):
        hits = push(*given)
        used.append(hits != compiled_contacts.FAR)
        return hits

    monkeypatch.setattr(bodies, "same_bits", lambda _: push and noted)
    for case in range(60):
        team = ("pioneer3dx", "husky")[: 1 + case % 2] * 3
        n, size = len(team), draw.uniform(0.3, 1.2)
        pose = np.column_stack([draw.uniform(-size, size, (n, 2)), draw.uniform(-3, 3, n)])
        pose[0, 0] = -0.0
        pose[:, 2] *= case % 3 > 0  # side by side, two sides are as good
        contacts = list(Bodies(team).separate(pose))
        found.append((contacts, pose.tobytes()))
    return found, sum(used)


@pytest.mark.parametrize("compiled", [False, True])
def test_the_loop_pushes_robots_apart_to_numpys_bits(compiled, monkeypatch):
    if compiled:
        pytest.importorskip("numba")
    push = compiled_contacts.compiled_push() if compiled else compiled_contacts.push_all
    wanted, _ = piles(monkeypatch, None)
    found, used = piles(monkeypatch, push)
    assert found == wanted and 20 < used < len(found)
    assert sum(len(contacts) for contacts, _ in found) > 100


@pytest.mark.parametrize("kinds", [("pioneer3dx",), ("pioneer3dx", "turtlebot3_burger")])
@pytest.mark.parametrize("loose", [0.05, 0.3, 9.0])
def test_a_pile_is_pushed_apart_the_same_whichever_pairs_are_kept(kinds, loose, monkeypatch):
    draw = np.random.default_rng(4)
    piled = np.column_stack([draw.uniform(-1.5, 1.5, (60, 2)), draw.uniform(-3.0, 3.0, 60)])
    found = []
    for kept in (0.0, loose):  # 0: pairs are looked up in each pass
        monkeypatch.setattr(bodies, "LOOSE", kept)
        pose = piled.copy(order="F")
        found.append((list(Bodies(kinds * (60 // len(kinds))).separate(pose)), pose))
    assert found[0][0] == found[1][0] and len(found[0][0]) > 50
    np.testing.assert_array_equal(found[0][1], found[1][1])
    assert np.abs(pose - piled).max() > 0.2


@pytest.mark.parametrize("seed", range(3))
def test_contacts_as_arrays_are_noted_as_one_by_one(seed):
    """Pairs and a crate are touched on and off, some longer ago than a touch is remembered."""
    draw, clock = np.random.default_rng(seed), Clock(0.02)
    motion = SimpleNamespace(closest=lambda: 1.0)
    arrays, one_by_one = Contacts(motion, clock), Contacts(motion, clock)
    pairs, begun = np.stack(np.triu_indices(6, 1)), []
    for clock.steps in range(200):
        first, second = pairs[:, draw.random(pairs.shape[1]) < 0.15]
        middle, some = draw.normal(size=(len(first), 2)), np.zeros(len(first))
        touches = Touches(first, second, middle, some, some)
        if draw.random() < 0.2:
            touches.others.append(Contact("robot1", "crate", 1.0, 2.0, 0.0))
        arrays.note(touches)
        one_by_one.note([contact[:4] for contact in touches])
        taken = arrays.take()
        assert taken == one_by_one.take()
        begun += taken
    assert 100 < len(begun) < 300
