"""Land, on which boats run aground and others stand."""

import numpy as np
import pytest
from protocol_fixtures import check, shipped, verdict_of

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.surroundings.obstacles import Box
from mrs_simulator.world.world import EVERY, World, WorldError

WHEELED = "pioneer3dx", "husky", "robotino3", "f1tenth", "husky_panda"
LAND = Box("beach", 10.0, 0.0, 0.0, 10.0, 40.0, 0.0)  # from x = 5 on


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_a_boat_that_runs_aground_is_reported_and_comes_off_again(fidelity):
    world = World(("heron",), [[3.0, 0.0, 0.0]], obstacles=[LAND], fidelity=fidelity)

    def drive(speed, steps):
        for _ in range(steps):
            world.set_commands(EVERY, np.array([[speed, 0.0]]))
            world.step()

    drive(0.8, 200)
    assert world.pose[0, 0] == pytest.approx(5.0 - 0.675, abs=0.01)  # the bow is on the beach
    assert abs(world.twist[0, 0]) < 0.05
    assert {(each.first, each.second) for each in world.contacts.take()} == {("robot1", "beach")}
    drive(-0.4, 250)
    assert world.pose[0, 0] < 4.0
    assert not world.contacts.take()


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_others_stand_on_land_and_fly_over_it(fidelity):
    kinds = ("pioneer3dx", "crazyflie2", "heron")
    poses = [[6.5, 1.0, 0.0], [4.8, -1.0, 0.0], [0.0, 0.0, 0.0]]
    world = World(kinds, poses, obstacles=[LAND], fidelity=fidelity, z=[0.0, 0.0, 0.0])
    command = np.zeros((3, len(world.team.axes)))
    command[:2, world.team.axes.index("linear.x")] = 0.5
    command[1, world.team.axes.index("linear.z")] = 0.1
    for _ in range(110):
        world.set_commands(EVERY, command)
        world.step()
    assert world.pose[0, 0] > 7.0 and world.pose[1, 0] > 5.5
    assert not world.contacts.take()
    world.close()


@pytest.mark.parametrize(
    "name, fidelity",
    [
        *((name, "kinematic") for name in WHEELED),
        ("pioneer3dx", "dynamic"),
        ("husky_panda", "dynamic"),
        *(pytest.param(name, "dynamic", marks=pytest.mark.release) for name in WHEELED[1:4]),
    ],
)
def test_wheels_that_leave_the_land_are_reported_and_stand_still(name, fidelity):
    poses = [[5.3, 0.0, np.pi], [5.3, 5.0, 0.0]]
    world = World((name, "pioneer3dx"), poses, obstacles=[LAND], fidelity=fidelity)
    command = np.zeros((2, len(world.team.axes)))
    command[:, 0] = 0.5
    for _ in range(150):
        world.set_commands(EVERY, command)
        world.step()
    assert [each[1:3] for each in world.faults.take()] == [("robot1", "in_water")]
    assert 4.0 < world.pose[0, 0] < 5.0 and world.pose[1, 0] > 5.5
    np.testing.assert_allclose(world.twist[0], 0.0, atol=0.01)
    world.reset()
    np.testing.assert_array_equal(world.pose, poses)
    world.close()


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_wheels_do_not_begin_in_the_water_where_there_is_land(fidelity):
    text = r"robot2 at \[3.0, 0.0\] is in the water, a Pioneer.*wanted it on land"
    with pytest.raises(WorldError, match=text):
        poses = [[6.0, 0.0, 0.0], [3.0, 0.0, 0.0]]
        World(("pioneer3dx",) * 2, poses, obstacles=[LAND], fidelity=fidelity)
    World(("pioneer3dx",), [[3.0, 0.0, 0.0]]).close()  # without land there is no water
    World(("heron", "crazyflie2"), [[3.0, 0.0, 0.0], [1.0, 0.0, 0.0]], obstacles=[LAND]).close()


def test_a_boat_does_not_begin_on_land():
    with pytest.raises(WorldError, match="robot1 overlaps obstacle beach"):
        World(("heron",), [[6.0, 0.0, 0.0]], obstacles=[LAND])


def test_a_scenario_tells_of_land_and_a_verdict_of_who_ran_aground(tmp_path):
    land = {"type": "land", "name": "beach", "center": [10, 0], "size": [10, 40]}
    scenario = scenario_from_dict({"model": "heron", "poses": [[0, 0, 0]], "obstacles": [land]})
    assert scenario.obstacles == (LAND,)
    assert scenario_from_dict(scenario.to_dict()).obstacles == scenario.obstacles
    with pytest.raises(ScenarioError, match="height"):
        scenario_from_dict({"poses": [[0, 0, 0]], "obstacles": [dict(land, height=1.0)]})
    land = dict(land, center=[12, -4], size=[4, 40])
    aground = shipped("line_of_sight", obstacles=[land], duration=12.0)
    told = check(verdict_of(aground, tmp_path), "collisions")
    assert told["passed"] is False and "and beach at" in told["note"]
