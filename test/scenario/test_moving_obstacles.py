"""Obstacles on tracks: where they are, that they push, are touched, seen and drawn."""

import numpy as np
import pytest

from mrs_simulator import PioneerControl, run_experiment
from mrs_simulator.control.safety.bounds import Surroundings
from mrs_simulator.control.safety.nearest_velocities import safe_velocities
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.surroundings.moving_obstacles import (
    Track,
    advance,
    obstacles_at,
    scene_facts,
)
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.study.draw.space_film import Film
from mrs_simulator.world.world import World

CART = {"type": "cylinder", "name": "cart", "center": [3.0, 0.0], "radius": 0.3}
ROLLING = dict(CART, track={"to": [[-3.0, 0.0]], "speed": 0.5})


def scenario(obstacle=ROLLING, **more):
    content = {"poses": [[0.0, 0.0, 0.0]], "obstacles": [obstacle], "duration": 1.0}
    return scenario_from_dict(dict(content, **more))


def world_after(seconds, **more):
    world = World.from_scenario(scenario(**more))
    for _ in range(int(round(seconds / world.step_size))):
        world.step()
    return world


def test_a_track_goes_back_and_forth_or_round():
    there = Track(((4.0, 0.0), (4.0, 3.0)), 0.5)
    for time, place in (
        (0.0, (0, 0)),
        (6.0, (3, 0)),
        (10.0, (4, 1)),
        (14.0, (4, 3)),
        (16.0, (4, 2)),
        (29.0, (0.5, 0)),
    ):
        assert there.place((0.0, 0.0), time) == pytest.approx(place)
    assert there._replace(closed=True).place((0.0, 0.0), 19.0) == pytest.approx(
        (2.0, 1.5)
    )  # the side back
    stands, moves = Box("a", 1.0, 2.0, 0.3, 1.0, 1.0, 0.5), Cylinder("b", 0.0, 0.0, 0.2, 0.5, there)
    now = obstacles_at((stands, moves), 6.0)
    assert now[0] is stands and now[1] == Cylinder("b", 3.0, 0.0, 0.2, 0.5)


def test_what_stands_in_the_way_is_touched_and_pushed():
    near = world_after(4.5)  # the cart's rim is 0.45 m from the centre, the robot's front 0.24 m
    assert near.pose[0, 0] == 0.0 and not near.contacts.take()
    world = world_after(6.0)
    (touch,) = world.contacts.take()
    assert {touch.first, touch.second} == {"robot1", "cart"} and 4.5 < touch.time < 5.5
    front = world.team.kinds[0].body.front
    assert world.pose[0, 0] == pytest.approx(0.0 - 0.3 - front, abs=0.02)  # the cart is at 0
    stands = world_after(6.0, obstacle=CART)
    assert not stands.contacts.take() and stands.pose[0, 0] == 0.0


def test_sensors_see_it_where_it_is():
    given = scenario(
        obstacle=dict(CART, center=[3.0, 1.5], track={"to": [[-3.0, 1.5]], "speed": 0.5})
    )
    world = World.from_scenario(given)
    suite = Suite.of_scenario(given, world.team, world.obstacles)
    suite.activate({0: ["sonar"]})
    left = {}
    for step in range(0, 301):
        suite.update(step, world.sensed)
        left[step] = suite.readings(world.time)[0]["sonar"].ranges[0]
        world.step()
    assert np.isinf(left[0]) or left[0] > 2.0
    # At 6 s it is at (0, 1.5), its nearest point in the cone of the transducer at (0.069, 0.136).
    assert left[300] == pytest.approx(np.hypot(0.069, 1.364) - 0.3, abs=0.005)


def test_films_show_it_where_it_is():
    given, samples = scenario(), np.array([0.0, 2.0])
    still = np.zeros((2, 1, 3))
    run = Run(samples, np.array([1]), still, still[..., :2], still[..., :2], scenario=given)
    film = Film(run)
    assert [film.scene(k).obstacles[0].x for k in (0, 1)] == pytest.approx([3.0, 2.0])


def test_it_is_written_as_it_is_read():
    given = scenario()
    again = scenario_from_dict(given.to_dict())
    assert again.obstacles == given.obstacles and again.obstacles[0].track == Track(
        ((-3.0, 0.0),), 0.5
    )
    assert "track" not in scenario(obstacle=CART).to_dict()["obstacles"][0]


@pytest.mark.parametrize(
    "track, said",
    [
        ({"to": [], "speed": 1}, r"track.to: \[\], wanted a list"),
        ({"to": [[1, 2, 3]], "speed": 1}, r"track.to\[0\]"),
        ({"to": [[3, 0]], "speed": 1}, "each point apart from the last"),
        ({"to": [[1, 0]], "speed": 0}, "speed"),
        ({"to": [[1, 0]], "speed": 21}, "speed: 21, wanted a number above 0 and at most 20"),
        ({"to": [[1, 0]], "speed": 1, "pause": 3}, "unknown 'pause'"),
    ],
)
def test_wrong_tracks_are_named(track, said):
    with pytest.raises(ScenarioError, match=said):
        scenario(obstacle=dict(CART, track=track))


# With forces ------------------------------------------------------------------------------------


def pushed(kind, fidelity="dynamic", seconds=3.0, **own):
    """Return the world after a cart has driven at 0.4 m/s from 1 m ahead against a robot of a ``kind``."""
    cart = dict(CART, center=[1.0, 0.0], track={"to": [[-9.0, 0.0]], "speed": 0.4})
    group = dict(kind=kind, poses=[[0.0, 0.0, 0.0]], **own)
    world = World.from_scenario(
        scenario_from_dict({"groups": [group], "obstacles": [cart], "fidelity": fidelity})
    )
    for _ in range(int(round(seconds / world.step_size))):
        world.step()
    return world


@pytest.mark.parametrize(
    "kind, fidelity",
    [
        ("pioneer3dx", "dynamic"),
        ("heron", "dynamic"),
        ("crazyflie2", "dynamic"),
        ("husky_xarm6", "kinematic"),
        ("husky_xarm6", "dynamic"),
    ],
)
def test_robots_with_forces_or_arms_are_pushed_along(kind, fidelity):
    pytest.importorskip("pybullet")
    world = pushed(kind, fidelity)
    front = world.team.kinds[0].body.front
    (touch,) = world.contacts.take()
    assert {touch.first, touch.second} == {"robot1", "cart"}
    assert touch.time == pytest.approx((0.7 - front) / 0.4, abs=0.06)
    assert world.pose[0, 0] == pytest.approx(-0.2 - 0.3 - front, abs=0.02)  # the cart is at -0.2
    world.close()


def test_one_that_hovers_is_pushed_and_one_below_the_top_alone():
    pytest.importorskip("pybullet")
    low, high = (pushed("crazyflie2", seconds=2.5, altitude=z) for z in (0.3, 0.7))
    assert low.pose[0, 0] == pytest.approx(0.0 - 0.3 - 0.06, abs=0.02) and low.z[0] > 0.25
    assert high.pose[0, 0] == pytest.approx(0.0, abs=1e-6) and not high.contacts.take()
    for world in (low, high):
        world.close()


def test_robots_at_rest_wait_for_it_without_creeping():
    pytest.importorskip("pybullet")
    world = world_after(1.2, fidelity="dynamic")  # it is far off: the solver rests
    before = world.pose.copy()
    world.step()
    assert (world.pose == before).all()
    world.close()


def test_one_that_is_put_elsewhere_pushes_none_there():
    pytest.importorskip("pybullet")
    from mrs_simulator.world.motion.dynamic import DynamicMotion

    cart = scenario(obstacle=dict(CART, track={"to": [[-9.0, 0.0]], "speed": 0.4})).obstacles
    motion = DynamicMotion(["pioneer3dx"], [[0.0, 0.0, 0.0]], cart)
    motion.move_obstacles(obstacles_at(cart, 10.0))  # at -1 m, on the other side
    motion.advance(np.zeros((1, 2)))
    assert abs(motion.pose[0, 0]) < 1e-3 and not motion.contacts()
    motion.close()


# The safety filter --------------------------------------------------------------------------------

AROUND = {"type": "box", "name": "van", "center": [1.2, -4.2], "size": [0.6, 1.0],
          "track": {"to": [[1.2, 5.0]], "speed": 0.3}}  # fmt: skip
ROUND = Track(((-4.0, 0.2), (-4.0, 2.5)), 0.25, closed=True)


def test_velocities_follow_the_way_and_turn_at_its_ends():
    there, begin = Track(((4.0, 0.0), (4.0, 3.0)), 0.5), (0.0, 0.0)
    for time, velocity in ((0.0, (0.5, 0)), (8.0, (0, 0.5)), (14.0, (0, -0.5)), (27.9, (-0.5, 0)),
                           (28.0, (0.5, 0))):  # fmt: skip
        np.testing.assert_allclose(there.velocity(begin, time), velocity, atol=1e-12)
    back = there._replace(closed=True).velocity(begin, 15.0)
    np.testing.assert_allclose(back, [-0.4, -0.3])


def test_how_fast_it_comes_covers_every_place_on_its_way():
    draw = np.random.default_rng(3)
    cart, period = Cylinder("a", 1.0, 2.0, 0.3, 1.0, Track(((4.0, 0.0), (4.0, 3.0)), 0.5)), 0.4
    ways = np.array([[np.cos(a), np.sin(a)] for a in np.linspace(-3.0, 3.0, 7)])
    for time in draw.uniform(0.0, 40.0, 50):
        begun = np.array(cart.track.place((1.0, 2.0), time))
        for part in np.linspace(0.05, 1.0, 7) * period:
            way = np.array(cart.track.place((1.0, 2.0), time + part)) - begun
            assert (ways @ way <= part * advance(cart, time, period, ways) + 1e-12).all()
    assert not advance(cart._replace(track=None), 0.0, period, ways).any()


class Stay(PioneerControl):
    """Wants to be where it began."""

    def start(self):
        self.goal = None

    def pointMassLaw(self, hand):
        if self.goal is None:
            self.goal = hand.copy()
        return 0.5 * (self.goal - hand)


def in_the_way(**more):
    cart = dict(CART, center=[4.0, 0.2], radius=0.4, track=ROUND.to_plain())
    poses = [[0.0, 0.0, 0.0], [0.0, 2.5, 1.0], [1.0, -2.5, 2.0]]
    content = {"poses": poses, "obstacles": [cart, AROUND], "duration": 5.5, "limits": "none"}
    content["control"] = {"safety": {"obstacles": True}}
    return scenario_from_dict(dict(content, **more))


def verdict_on(given, tmp_path):
    verdict = run_experiment(given, str(tmp_path), Stay, formats=())
    return {check["name"].split(" [")[0]: check for check in verdict["checks"]}


def test_the_filter_gives_way_where_one_for_standing_obstacles_collides(tmp_path, monkeypatch):
    checks = verdict_on(in_the_way(), tmp_path)
    assert checks["collisions"]["measured"] == 0
    assert checks["least clearance of obstacles and border"]["passed"]
    standing = lambda obstacle, time, period, ways: np.zeros(len(ways))  # noqa: E731
    monkeypatch.setattr("mrs_simulator.control.safety.bounds.advance", standing)
    assert verdict_on(in_the_way(), tmp_path / "b")["collisions"]["measured"] > 0


def test_robots_that_take_their_time_give_way_too_though_no_theorem_says_so(tmp_path):
    alone = {"poses": [[1.0, -2.5, 2.0]], "obstacles": [AROUND], "duration": 9.0}
    checks = verdict_on(in_the_way(limits="firmware", **alone), tmp_path)
    assert checks["collisions"]["measured"] == 0
    clear = checks["least clearance of obstacles and border"]
    assert clear["passed"] is None and "take time to speed up" in clear["note"]
    fast = dict(AROUND, track={"to": [[1.2, 5.0]], "speed": 2.0})
    told = verdict_on(in_the_way(obstacles=[fast], control={"safety": {"speed": 0.3}},
                                 duration=0.2), tmp_path / "b")  # fmt: skip
    why = told["least clearance of obstacles and border"]["note"]
    assert "obstacles come at up to 2 m/s, robots go 0.3 m/s" in why


def test_who_cannot_flee_stops_none_else():
    # Robot 1 stands between two carts that come, robot 2, far away, before a third.
    carts = [
        Cylinder("cart", x, 0.0, 0.3, 1.0, Track(((to, 0.0),), speed))
        for x, to, speed in ((-0.7, 9.0, 0.5), (0.7, -9.0, 0.3), (19.0, 29.0, 0.3))
    ]
    points, reach = np.array([[0.0, 0.0], [20.0, 0.0]]), np.full(2, 0.4)
    bounds = Surroundings(tuple(carts)).bounds(points, reach, 0.0, 0.02)
    safe = safe_velocities(np.zeros((2, 2)), points, 0.8, 0.02, bounds=bounds)
    assert safe[1, 0] == pytest.approx(0.3 - 0.3 * 0.3, abs=1e-6) and abs(safe[0, 0]) < 0.2


def test_a_law_that_begins_later_knows_how_far_it_has_come(tmp_path):
    control = make_control(in_the_way())
    point = np.array([[0.0, 0.0], [0.0, 9.0], [0.0, -9.0]])
    control.safety_filter.begin_scene(10.0)
    assert control.safety_filter.bounds(point, 2.0).gap[0] == pytest.approx(
        np.hypot(1.0, 0.2) - 0.4 - control.safety_filter.distance / 2.0
    )
    run = Run(np.array([2.0]), np.array([1]), np.zeros((1, 1, 3)), np.zeros((1, 1, 2)),
              np.zeros((1, 1, 2)), scenario=in_the_way(), meta={"scene_time": 10.0})  # fmt: skip
    assert Film(run).scene(0).obstacles[0].x == pytest.approx(1.0)
    assert scene_facts(run.scenario.obstacles, 10.0) == {"scene_time": 10.0}
    assert scene_facts((), 10.0) == scene_facts(run.scenario.obstacles, 0.0) == {}
