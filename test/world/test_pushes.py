"""Robots that somebody pushes: scheduled by the scenario, without their wheels."""

import numpy as np
import pytest

from mrs_simulator import simulate
from mrs_simulator.scenario.incidents import Event
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.world.world import EVERY, World, WorldError

PUSH = {"at": 0.1, "robot": 2, "event": "pushed", "by": [0.5, -0.25]}
CONTENT = {"poses": [[0, 0, 0], [3, 0, 0]], "events": [PUSH]}


@pytest.mark.parametrize("fidelity", ["kinematic", "point_mass"])
def test_a_push_puts_a_robot_elsewhere_and_its_wheels_do_not_turn(fidelity):
    scenario = scenario_from_dict(dict(CONTENT, fidelity=fidelity))
    assert scenario.events == (Event(0.1, 2, "pushed", by=(0.5, -0.25)),)
    assert scenario_from_dict(scenario.to_dict()).events == scenario.events
    world = World.from_scenario(scenario)
    assert not world.can_fuse(1)
    world.set_commands(EVERY, np.zeros((2, 2)))
    for _ in range(5):
        world.step()
    assert world.pose[1].tolist() == [3.0, 0.0, 0.0] and not world.faults.take()
    world.step()
    assert world.pose.tolist() == [[0.0, 0.0, 0.0], [3.5, -0.25, 0.0]]
    (pushed,) = world.faults.take()
    assert (pushed.text, pushed.ordered) == ("robot2 was pushed", True)
    world.step()
    assert world.pose[1].tolist() == [3.5, -0.25, 0.0]


def test_who_is_pushed_into_another_robot_is_a_collision():
    events = [Event(0.1, 2, "pushed", by=(-2.9, 0.0))]
    world = World(("pioneer3dx",) * 2, [[0, 0, 0], [3, 0, 0]], events=events)
    for _ in range(8):
        world.step()
    assert len(world.contacts.take()) == 1 and np.ptp(world.pose[:, 0]) > 0.3


def test_claims_are_judged_until_the_push_and_wheels_do_not_feel_it():
    content = dict(CONTENT, odometry="wheel", duration=0.5, control={"protocol": "consensus"})
    study = simulate(scenario_from_dict(dict(content, topology={"preset": "path"})))
    assert not [each for each in study.verdict["checks"] if each["passed"] is False]
    (note,) = {each["note"] for each in study.verdict["checks"] if each["name"] == "incidents"}
    assert note == "robot2 was pushed at 0.1 s"


@pytest.mark.parametrize(
    "more, said",
    [
        ({"fidelity": "dynamic"}, "fidelity dynamic; wanted kinematic or point_mass"),
        ({"model": ["husky_panda", "husky"]}, "a team with arms"),
        ({"model": "crazyflie2", "altitude": 1.0}, "robot2, which flies"),
    ],
)
def test_robots_that_cannot_be_pushed_are_refused(more, said):
    with pytest.raises(WorldError, match=said):
        World.from_scenario(scenario_from_dict(dict(CONTENT, **more)))


@pytest.mark.parametrize("by", [None, [1.0], [1e9, 0.0], [float("nan"), 0.0]])
def test_a_push_is_two_lengths(by):
    with pytest.raises(ScenarioError, match="events\\[0\\].by"):
        scenario_from_dict(dict(CONTENT, events=[dict(PUSH, by=by)]))
