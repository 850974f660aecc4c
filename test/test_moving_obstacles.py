"""Obstacles on tracks: where they are, that they push, are touched, seen and drawn."""

import numpy as np
import pytest

from mrs_simulator.core.moving import Track, obstacles_at
from mrs_simulator.core.obstacles import Box, Cylinder
from mrs_simulator.core.reading import ScenarioError
from mrs_simulator.core.recording import Run
from mrs_simulator.core.scenario import scenario_from_dict
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.study.film import Film
from mrs_simulator.world.world import World, WorldError

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
    assert near.pose[0, 0] == 0.0 and not near.take_collisions()
    world = world_after(6.0)
    (touch,) = world.take_collisions()
    assert {touch.first, touch.second} == {"robot1", "cart"} and 4.5 < touch.time < 5.5
    front = world.kinds[0].body.front
    assert world.pose[0, 0] == pytest.approx(0.0 - 0.3 - front, abs=0.02)  # the cart is at 0
    stands = world_after(6.0, obstacle=CART)
    assert not stands.take_collisions() and stands.pose[0, 0] == 0.0


def test_sensors_see_it_where_it_is():
    given = scenario(
        obstacle=dict(CART, center=[3.0, 1.5], track={"to": [[-3.0, 1.5]], "speed": 0.5})
    )
    world = World.from_scenario(given)
    suite = Suite.of_scenario(given, world.team, world.obstacles)
    suite.listen({0: ["sonar"]})
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
        ({"to": [[1, 0]], "speed": 1, "pause": 3}, "unknown 'pause'"),
    ],
)
def test_wrong_tracks_are_named(track, said):
    with pytest.raises(ScenarioError, match=said):
        scenario(obstacle=dict(CART, track=track))


def test_with_forces_it_is_refused():
    pytest.importorskip("pybullet")
    with pytest.raises(WorldError, match="obstacle cart moves: wanted fidelity kinematic"):
        World.from_scenario(scenario(fidelity="dynamic"))
