"""Overlaps of footprints, and the list of pairs against all pairs."""

from types import SimpleNamespace

import numpy as np
import pytest

from mrs_simulator.core import compiled_neighbours, neighbours, sample_blocks
from mrs_simulator.core.neighbours import close_pairs, least_distance, least_distance_over
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.vehicles.kind import Body
from mrs_simulator.world.clock import Clock
from mrs_simulator.world.contact import bodies, collisions, compiled_contacts, contacts
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
from mrs_simulator.world.motion import compiled as compiled_motion
from mrs_simulator.world.motion import crowd_steps, kinematic
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
    for loop in (None, compiled_neighbours.near_pairs)[: 2 if n <= neighbours.DENSE else 1]:
        first, second = close_pairs(position, 1.3, loop)
        assert list(zip(first.tolist(), second.tolist())) == all_pairs(position, 1.3)


def test_pairs_are_listed_by_the_loop_from_the_second_time_on(monkeypatch):
    asked = []
    monkeypatch.setattr(collisions, "same_bits", lambda compiled, *_: asked.append(compiled))
    listed = VerletList(0.7)
    places = np.random.default_rng(0).uniform(0.0, 40.0, (neighbours.DENSE + 1, 2))
    listed.pairs(places)
    assert not asked
    listed.clear()
    listed.pairs(places)
    assert asked == [collisions.compiled_pairs]


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
def test_the_least_distance_over_time_is_the_least_of_all_samples(n, dimension, speed, monkeypatch):
    monkeypatch.setattr(sample_blocks, "AT_ONCE", 300)  # several blocks of samples
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
    for step in range(250):
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
    assert seldom < len(looks) - seldom == 250


LOOPS = {
    compiled_contacts.compiled_push: compiled_contacts.push_all,
    compiled_contacts.compiled_note: compiled_contacts.note_all,
    compiled_neighbours.compiled_pairs: compiled_neighbours.pairs_in_cells,
    compiled_motion.compiled_feel: compiled_motion.feel_all,
    crowd_steps.compiled_step: crowd_steps.step_all,
}
# Compiling takes long, and the loops are the same code.
WAYS = ["numpy", "loops", pytest.param("numba", marks=pytest.mark.release)]


def by(way, monkeypatch):
    """Let contacts be found by numpy, by the loops as Python runs them, or by these compiled; return how
    often each of them is called."""
    used = dict.fromkeys(LOOPS, 0)

    def chosen(compiled, *_, **__):
        if way == "numpy":
            return None
        used[compiled] += 1
        return LOOPS[compiled] if way == "loops" else compiled()

    if way == "numba":
        pytest.importorskip("numba")
    for module in (bodies, collisions, contacts, kinematic):
        monkeypatch.setattr(module, "same_bits", chosen)
    same = compiled_motion.approached_by, compiled_motion.carried_by
    for name, twin in zip(("compiled_approached", "compiled_carried"), same):
        loop = twin(lambda kernel: kernel)
        monkeypatch.setattr(kinematic, name, lambda loop=loop: loop)
    monkeypatch.setattr(kinematic, "approached_function", lambda: kinematic.ramped)
    monkeypatch.setattr(kinematic, "carried_function", lambda: kinematic.moved_along_arcs_wrapped)
    return used


def piles():
    """Return contacts, poses, distances and room of piles pushed apart, and elsewhere again."""
    draw, found = np.random.default_rng(7), []
    for case in range(62):
        few = case < 60
        team = ("pioneer3dx", "husky")[: 1 + case % 2] * (3 if few else 25)
        n, size, pile = len(team), draw.uniform(0.3, 1.8), Bodies(team)
        for _ in range(2):
            pose = np.column_stack([draw.uniform(-size, size, (n, 2)), draw.uniform(-3, 3, n)])
            pose[:, 0] *= 1.0 if few else 3.0
            pose[0, 0] = -0.0
            pose[:, 2] *= case % 3 > 0  # side by side, two sides are as good
            touched = list(pile.separate(pose))
            found.append((touched, pose.tobytes(), pile.closest(pose), pile.room))
    return found


@pytest.mark.parametrize(
    "loose, skin", [(bodies.LOOSE, bodies.SKIN), (0.02, 0.05), (0.9, bodies.SKIN)]
)
@pytest.mark.parametrize("way", WAYS[1:])
def test_the_loop_pushes_robots_apart_to_numpys_bits(way, loose, skin, monkeypatch):
    monkeypatch.setattr(bodies, "LOOSE", loose)
    for module in (bodies, collisions):
        monkeypatch.setattr(module, "SKIN", skin)
    by("numpy", monkeypatch)
    wanted = piles()
    used = by(way, monkeypatch)
    assert piles() == wanted and used[compiled_contacts.compiled_push] > 0.9 * len(wanted)
    assert sum(len(touched) for touched, *_ in wanted) > 100
    assert sum(room > 0.0 for *_, room in wanted) > 10


def parting():
    """Return poses and contacts of two robots whose corners touch as they turn, and part within a step."""
    draw = np.random.default_rng(42)
    headings = draw.uniform(-3.1, 3.1, 2)
    world = World(
        ("pioneer3dx",) * 2, [[0.0, 0.0, headings[0]], [0.7, 0.0, headings[1]]], limits="top"
    )
    told = []
    for _ in range(4):
        command = draw.uniform(-1.0, 1.0, (2, 2)) * [1.0, 4.0]
        for _ in range(25):
            world.set_commands(EVERY, command)
            world.step()
            told.append((world.pose.tobytes(), world.contacts.take()))
    return told


@pytest.mark.parametrize("way", WAYS[1:])
def test_robots_that_part_after_a_step_by_the_loop_are_looked_at_again(way, monkeypatch):
    by("numpy", monkeypatch)
    wanted = parting()
    used = by(way, monkeypatch)
    assert parting() == wanted and used[crowd_steps.compiled_step] > 0


def crowd(n):
    """Return poses, twists, collisions and distances of n robots that drive into each other for 4 s."""
    world = World(("pioneer3dx",) * n, grid(n), limits="top")
    draw = np.random.default_rng(2)
    told = []
    for step in range(200):
        if step % 50 == 0:
            command = draw.uniform(-1.0, 1.0, (n, 2))
        world.set_commands(EVERY, command)
        world.step()
        told.append((world.pose.tobytes(), world.twist.tobytes(), world.contacts.closest))
        told[-1] += (world.contacts.take(),)
    return told


def grid(n):
    wide = int(np.ceil(np.sqrt(n)))
    row, column = np.divmod(np.arange(n), wide)
    return np.column_stack([0.7 * row, 0.7 * column, np.arange(n) % 7 - 3.0])


@pytest.mark.parametrize("way", WAYS[1:])
def test_a_crowd_by_the_loops_has_numpys_bits(way, monkeypatch):
    n = 25 if way == "loops" else neighbours.DENSE + 33
    by("numpy", monkeypatch)
    wanted = crowd(n)
    used = by(way, monkeypatch)
    assert crowd(n) == wanted
    assert all(used.values()) or way == "loops" and sum(map(bool, used.values())) == 4
    assert sum(len(told[3]) for told in wanted) > n


@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=pytest.mark.release)])
def test_pairs_by_the_loop_are_those_of_the_grid(compiled):
    loop = compiled_neighbours.pairs_in_cells
    if compiled:
        pytest.importorskip("numba")
        loop = compiled_neighbours.compiled_pairs()
    draw = np.random.default_rng(5)
    for n, dimension, distance in ((300, 2, 0.7), (400, 3, 1.9), (300, 2, 40.0), (300, 2, 0.01)):
        points = draw.uniform(-9.0, 9.0, (n, dimension))
        wanted = close_pairs(points, distance)
        np.testing.assert_array_equal(close_pairs(points, distance, loop), wanted)


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


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(3))
def test_contacts_as_arrays_are_noted_as_one_by_one(seed, way, monkeypatch):
    """Pairs and a crate are touched on and off, some longer ago than a touch is remembered."""
    by(way, monkeypatch)
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
