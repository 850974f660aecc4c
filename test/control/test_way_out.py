"""Robots brake in time: their courses hold, and no pair that meets touches, whatever its kind."""

import contextlib
import os

import numpy as np
import pytest
import yaml
from protocol_fixtures import SCENARIOS

from mrs_simulator import PioneerControl
from mrs_simulator.control.safety.bounds import Surroundings
from mrs_simulator.control.safety.braking_certificate import SHARES, STEEPEST, WayOut
from mrs_simulator.control.safety.distances import body_radii
from mrs_simulator.core.neighbours import lengths
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.courses import Courses
from mrs_simulator.vehicles.team_in_space import team_of
from mrs_simulator.world.world import EVERY, World

PERIOD = 0.02
KINDS = ("pioneer3dx", "robotino3", "f1tenth", "heron", "wamv", "crazyflie2", "epuck")


def heights(kinds):
    """Return the heights (n,) [m] at which robots of these ``kinds`` begin."""
    return np.where(Team(kinds).airborne, 1.0, 0.0)


WALL = {"type": "wall", "from": [2.0, -9.0], "to": [2.0, 9.0]}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [1, 2])
def test_robots_stay_beside_their_courses_no_farther_than_these_say(kind, seed):
    draw = np.random.default_rng(seed)
    world = World((kind,), [[0.0, 0.0, 0.3]], z=heights((kind,)), step=PERIOD)
    courses = Courses(world.team)
    inner = courses.at_rest(world.pose, np.ones(1))
    top = np.minimum(world.team.limits.of_all(1).top, 4.0)
    command = top * draw.uniform(-1.0, 1.0, top.shape)
    for k in range(60):
        command = command if k % 20 else top * draw.uniform(-1.0, 1.0, top.shape)
        world.set_commands(EVERY, command)
        world.step()
        inner = courses.followed(inner, command, PERIOD)
    next_one = top * draw.uniform(-1.0, 1.0, top.shape)
    course = courses.course(inner, world.pose, np.ones(1), next_one, PERIOD)
    for k in range(300):
        world.set_commands(EVERY, next_one if k == 0 else np.zeros_like(next_one))
        world.step()
        now = min((k + 1) * PERIOD, course.time[-1])
        row = min(np.searchsorted(course.time, now, "right"), len(course.time) - 1)
        share = (now - course.time[row - 1]) / (course.time[row] - course.time[row - 1])
        line = course.place[row - 1 : row + 1, 0, :2]
        beside = np.linalg.norm(world.pose[0, :2] - line[0] - share * (line[1] - line[0]))
        assert beside <= course.aside[row - 1, 0] + 1e-5, k


def met(kinds, fidelity="kinematic", wall=False, gain=0.3, far=5.0, duration=10.0):
    """Return the least gaps [m] between two robots that change places, and between them and ``WALL``."""
    reach = Team(kinds).reach
    poses = [[-far, 0.0, 0.0], [far, 0.0, np.pi]]

    class Swap(PioneerControl):
        def pointMassLaw(self, hand):
            return gain * (np.array([[far, 0.0], [-far, 0.0]]) - hand)

    content = {"poses": poses, "model": list(kinds), "fidelity": fidelity}
    if any(heights(kinds)):
        content["altitude"] = heights(kinds).tolist()
    content.update(obstacles=[WALL] if wall else [])
    content.update(control={"safety": {"obstacles": wall}, "rate": 10})
    scenario = scenario_from_dict(content)
    control = make_control(scenario, Swap)
    world = World.from_scenario(scenario)
    least, inside = np.inf, np.inf
    for k in range(int(duration / world.step_size)):
        if k % 5 == 0:
            z = world.z
            pose = world.pose if z is None else np.column_stack([world.pose, z])
            world.set_commands(EVERY, control.commands(pose, world.time, world.joints))
        world.step()
        apart = np.linalg.norm(world.pose[0, :2] - world.pose[1, :2]) - reach.sum()
        gap = np.abs(world.pose[:, 0] - 2.0) - 0.05 - reach
        least, inside = min(least, apart), min(inside, gap.min())
    return least, inside


@pytest.mark.parametrize(
    "kind",
    [
        "pioneer3dx",
        "robotino3",
        "f1tenth",
        "heron",
        "crazyflie2",
        pytest.param("wamv", marks=pytest.mark.release),
    ],
)
def test_robots_head_on_never_touch(kind):
    assert met((kind, kind))[0] > 1e-3


@pytest.mark.parametrize("kinds", [("robotino3", "f1tenth"), ("pioneer3dx", "robotino3")])
def test_robots_of_several_kinds_head_on_never_touch(kinds):
    assert met(kinds)[0] > 1e-3


@pytest.mark.parametrize("kind", ["pioneer3dx", "heron"])
def test_nor_do_they_with_forces(kind):
    assert met((kind, kind), "dynamic")[0] > 1e-3


@pytest.mark.parametrize("kind", ["f1tenth", "heron", "robotino3"])
def test_robots_commanded_through_a_wall_stop_before_it(kind):
    gap = met((kind, kind), wall=True, gain=3.0)[1]
    assert gap > 1e-3


@pytest.mark.parametrize(
    "kind", ["ardrone2", pytest.param("crazyflie2", marks=pytest.mark.release), "f1tenth"]
)
def test_who_runs_on_with_forces_stops_before_a_wall(kind):
    assert met((kind, kind), "dynamic", wall=True, gain=3.0, duration=3.5)[1] > 1e-3


def test_tilted_bodies_lie_within_their_discs():
    tilt = np.arctan2(0.127, 0.517)  # of a box by which its corner reaches farthest
    lower_corner = 0.2585 * np.sqrt(2.0) * np.cos(tilt) + 0.0635 * np.sin(tilt)
    drones = Team(("ardrone2", "ardrone2"))
    assert body_radii(drones, "dynamic")[0] > lower_corner > body_radii(drones, "kinematic")[0]
    assert (body_radii(Team(("husky", "heron")), "dynamic") == Team(("husky", "heron")).reach).all()


def test_upright_bodies_in_space_lie_within_their_balls():
    poses = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]
    content = {"model": ["ardrone2", "crazyflie2"], "poses": poses, "altitude": 1.0}
    team = team_of(scenario_from_dict(content), dimension=3)
    half = np.array([0.0635, 0.0125]) / team.downwash  # their middles differ by 0.051 m in height
    inside = np.hypot(team.reach, half) + 0.0255 / team.downwash
    assert (body_radii(team, "kinematic") >= inside - 1e-9).all()


def test_pioneers_with_the_ramps_of_their_firmware_cross_without_contact_or_deadlock():
    with open(os.path.join(SCENARIOS, "formation_safely.yaml"), encoding="utf-8") as file:
        content = yaml.safe_load(file)
    content.update(limits="firmware", duration=14.0)
    experiment = Experiment(scenario_from_dict(content))
    for _ in experiment.samples():
        assert not experiment.control.safety_filter.deadlock
    assert not experiment.collisions


@pytest.mark.parametrize("kind", ["robotino3", "epuck"])
def test_wheels_of_models_touch_no_sooner_than_the_outline(kind):
    apart = Team((kind,)).reach[0] + 0.003
    wall = {"type": "wall", "from": [-1.0, -apart - 0.05], "to": [1.0, -apart - 0.05]}
    for heading in np.linspace(0.0, np.pi, 4):  # a wheel ahead in some of these
        poses = [[0.0, 0.0, heading], [2.0 * apart, 0.0, heading]]
        content = {"model": kind, "poses": poses, "obstacles": [wall], "fidelity": "dynamic"}
        with contextlib.closing(World.from_scenario(scenario_from_dict(content))) as world:
            for _ in range(10):
                world.step()
            assert not world.contacts.take(), heading


def test_who_might_touch_is_first_let_go_slower():
    way_out = WayOut(Team(("pioneer3dx",) * 2), np.full(2, 0.3), 0.1, "kinematic")
    facing = np.array([[0.0, 0.0, 0.0], [0.614, 0.0, np.pi]])
    free = Surroundings()
    given = np.full((2, 2), [0.5, 0.1])
    passed = way_out.certified(given, facing, np.zeros(2), 0.0, free)
    np.testing.assert_allclose(passed[:, 1], 0.1)
    share = passed[0, 0] / 0.5
    assert share in SHARES[1:-1] and passed[1, 0] == passed[0, 0]
    assert way_out.may_have_acted(passed, facing[:, :2], free)
    apart = facing + [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]
    assert not way_out.may_have_acted(passed, apart[:, :2], free)
    assert all(one <= STEEPEST * other for one, other in zip(SHARES, SHARES[1:-1]))


def test_boats_that_turned_aside_go_on_as_fast_as_they_can():
    """Otters change places across a circle: their turn limits slow down no wanted velocity twice."""
    angle = 0.4 * np.pi * np.arange(5)
    start = 8.0 * np.column_stack([np.cos(angle), np.sin(angle)])

    class Across(PioneerControl):
        def pointMassLaw(self, hand):
            return 0.4 * (-start - hand)

    content = {
        "model": "otter",
        "poses": np.column_stack([start, angle + np.pi]).tolist(),
        "control": {"rate": 10.0, "parameters": {"l": 0.2}, "safety": True},
        "duration": 18.0,
    }
    experiment = Experiment(scenario_from_dict(content), Across)
    for _ in experiment.samples():
        pass
    points = experiment.control.points(experiment.world.pose)
    experiment.world.close()
    assert np.linalg.norm(points + start, axis=1).max() < 0.8
    assert not experiment.collisions and not experiment.control.safety_filter.deadlock


@pytest.mark.parametrize("kind", ["pioneer3dx", "robotino3", "f1tenth", "heron"])
def test_states_that_follow_are_the_last_ones_of_the_course(kind):
    team = Team((kind,) * 3)
    courses, draw = Courses(team), np.random.default_rng(2)
    (inner,) = courses.at_rest(np.zeros((3, 3)), np.zeros(3))
    inner = inner + draw.uniform(-0.3, 0.3, inner.shape)
    command = draw.uniform(-0.5, 0.5, (3, len(courses.team.axes)))
    (group,) = courses.team.groups
    last = courses._phase(group, inner, group.of(command), np.array([0.05, 0.1]))[2]
    (followed,) = courses.followed([inner], command, 0.1)
    np.testing.assert_allclose(followed, last, atol=1e-12)
    assert not np.array_equal(followed, inner)


def test_lengths_are_norms_to_the_bit():
    vectors = np.random.default_rng(3).normal(0.0, 1.0, (7, 50, 3))
    for each in (vectors, vectors[0], vectors[0][:, :2], np.asfortranarray(vectors[0])):
        np.testing.assert_array_equal(lengths(each), np.linalg.norm(each, axis=-1))
