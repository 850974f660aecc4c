"""Robots with arms, and loads, as rigid bodies: against statics, and against the kinematics they have."""

import numpy as np
import pybullet
import pytest
from test_carrying import scenario

from mrs_simulator.core import grasps
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.surroundings.obstacles import Cylinder
from mrs_simulator.study.run.simulating import simulate
from mrs_simulator.vehicles import kind
from mrs_simulator.vehicles.arms.assembling import assembled
from mrs_simulator.vehicles.arms.team import ArmedTeam
from mrs_simulator.vehicles.importing.description import read_description
from mrs_simulator.world.world import World

STEP = 0.02


@pytest.fixture(scope="module")
def standing():
    """A world in which three robots stand and hold a load, after it has come to rest."""
    given = scenario_from_dict(scenario(fidelity="dynamic"))
    world = World.from_scenario(given)
    for _ in range(75):
        world.step()
    yield world
    world.close()


def test_base_and_arm_are_one_description():
    each = kind("husky_panda")
    found = read_description(assembled(each), "assembled")
    alone = read_description(open(each.model).read(), each.model)
    masses = [sum(link.mass for link in robot.links.values()) for robot in (found, alone)]
    assert masses[0] - masses[1] == pytest.approx(each.arm.chain.mass, abs=0.01)
    moving = [joint.name for joint in found.joints.values() if joint.type == "revolute"]
    assert moving == ["arm/panda_joint{}".format(i) for i in range(1, 8)]


def test_tools_are_where_pybullet_has_them(standing):
    bodies = standing.motion.bodies
    points = standing.team.tools(standing.pose, standing.joints, 0.1)
    for row in range(3):
        body, _, tool = bodies.arm_of(row)
        seen = pybullet.getLinkState(
            body, tool, computeForwardKinematics=1, physicsClientId=bodies.client
        )[4]
        # The base leans by a tenth of a degree under its arm, which a pose in the plane does not tell.
        np.testing.assert_allclose(points[row], seen, atol=0.01)


def test_a_load_at_rest_hangs_as_statics_has_it(standing):
    load, state = standing.load.load, standing.load.state
    at = grasps.grasp_points(standing.load.grasps, state.place, state.orientation)
    arms = at - state.place
    np.testing.assert_allclose(state.force.sum(axis=0), load.weight[:3], atol=0.2)
    np.testing.assert_allclose(np.cross(arms, state.force).sum(axis=0), 0.0, atol=0.2)
    wanted = grasps.least_forces(arms, load.weight)
    found = state.force - grasps.internal_forces(arms, state.force)
    np.testing.assert_allclose(found, wanted, atol=0.2)
    sag = load.weight[2] / (len(at) * load.stiffness)
    mean = standing.team.tools(standing.pose, standing.joints, 0.1).mean(axis=0) - at.mean(axis=0)
    assert mean[2] == pytest.approx(sag, abs=0.01)


def test_robots_hold_still_against_internal_forces(standing):
    begin = np.array(scenario()["poses"])
    assert 1e-3 < np.abs(standing.pose - begin).max() < 0.03  # wheels creep as the load pulls
    assert np.abs(standing.joints - standing.team.rest_joints).max() < 0.02
    state = standing.load.state
    assert np.linalg.norm(state.force[:, :2], axis=1).max() > 5.0


def test_a_reset_takes_hold_anew(standing):
    standing.reset()
    assert standing.load.held.all()
    np.testing.assert_allclose(standing.joints, standing.team.rest_joints, atol=1e-9)
    count = pybullet.getNumBodies(physicsClientId=standing.motion.bodies.client)
    assert count == 5  # ground, robots and one load
    begun = None
    for _ in range(5):
        standing.step()
        begun = standing.load.state.place if begun is None else begun
    assert np.abs(standing.load.state.place - begun).max() < 3e-3  # it begins where it hangs


def test_joints_turn_as_commanded_and_stop_at_their_ends():
    team = ArmedTeam(["husky_xarm6"])
    world = World(team, [[0.0, 0.0, 0.0]], fidelity="dynamic", step=STEP)
    try:
        command = np.zeros((1, len(team.axes)))
        command[0, 2:] = [0.5, 0.3, -0.4, 0.0, 0.6, -0.5]
        for _ in range(25):
            world.set_commands([0], command)
            world.step()
        turned = world.joints[0, 1:] - team.rest_joints[0, 1:]
        np.testing.assert_allclose(turned, 0.5 * command[0, 2:], atol=0.02)
        command[0, 2:] = [0.0, 0.0, 3.0, 0.0, 0.0, 0.0]
        for _ in range(40):
            world.set_commands([0], command)
            world.step()
        assert world.joints[0, 3] == pytest.approx(team.upper[0, 2], abs=0.01)
    finally:
        world.close()


def test_a_load_is_carried_with_forces():
    content = scenario(fidelity="dynamic")
    content["duration"] = 2.5
    content["control"]["parameters"]["waypoints"] = "0 0 0.51 0"
    run = simulate(content)
    checks = {check["name"]: check for check in run.verdict["checks"]}
    for name in ("largest internal force [N]", "internal force at the end [N]"):
        assert checks[name]["passed"], str(run)
    assert checks["weight carried, mean [N]"]["passed"]
    assert checks["internal force at the end [N]"]["measured"] < 3.0


def test_a_load_that_is_let_go_falls_to_the_ground():
    content = scenario(fidelity="dynamic")
    content["duration"] = 1.2
    content["load"]["grip"] = 25.0
    run = simulate(content)
    assert run.run.load.place[-1, 2] == pytest.approx(0.05, abs=0.02)
    assert run.run.meta["incidents"] and not run.passed
    assert not run.run.load.force[-1].any()


def test_arms_have_forces_beside_boats_and_drones():
    kinds = ["husky_panda", "heron", "crazyflie2", "husky_xarm6"]
    team = ArmedTeam(kinds)
    poses = [[4.0, 0.0, 0.0], [0.0, 5.0, 0.0], [-3.0, -3.0, 0.0], [-6.0, 3.0, 0.0]]
    world = World(team, poses, z=[0.0, 0.0, 1.0, 0.0], fidelity="dynamic", step=STEP)
    command = np.zeros((4, len(team.axes)))
    command[:2, team.axes.index("linear.x")] = 0.4
    command[0, -7], command[3, -7] = 0.2, -0.3  # [rad/s] of the arms' first joints
    for _ in range(50):
        world.set_commands(range(4), command)
        world.step()
    turned = world.joints[:, 1] - team.rest_joints[:, 1]
    np.testing.assert_allclose(turned, [0.2, 0.0, 0.0, -0.3], atol=0.01)
    assert world.pose[0, 0] > 4.3 and world.pose[1, 0] > 0.05  # a boat speeds up slowly
    np.testing.assert_allclose(world.z, [0.0, 0.0, 1.0, 0.0], atol=0.02)
    np.testing.assert_allclose(world.pose[3], poses[3], atol=0.02)
    world.reset()
    np.testing.assert_array_equal(world.joints, team.rest_joints)
    world.close()


def test_an_arm_touches_what_stands_in_its_way():
    """The tool is 0.55 m ahead of the arm's foot: a column that stands there is hit as the arm turns."""
    team = ArmedTeam(["husky_panda"])
    x, y, _ = team.tools(np.zeros((1, 3)), team.rest_joints, 0.1)[0]
    foot = team.kinds[0].arm.mount[0]
    column = Cylinder("column", foot, x - foot, 0.1, 2.0)  # a quarter of a turn to the left
    world = World(team, [[0.0, 0.0, 0.0]], obstacles=(column,), fidelity="dynamic", step=STEP)
    command = np.zeros((1, len(team.axes)))
    command[0, -7] = 0.8
    told = []
    for _ in range(125):
        world.set_commands([0], command)
        world.step()
        told += [each[1:3] for each in world.contacts.take()]
    assert told[:1] == [("robot1", "column")]
    assert abs(world.joints[0, 1]) < 1.7  # it did not pass through
    world.close()
