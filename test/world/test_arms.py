"""Arms on wheeled bases: kinematics against pybullet, the tool point, limits, protocols on tools."""

import numpy as np
import pybullet
import pytest

from mrs_simulator.protocols.published.arms import ArmedRobots
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.simulating import open_run, simulate
from mrs_simulator.vehicles import Team, kind
from mrs_simulator.vehicles.arms import team as team_of_arms
from mrs_simulator.vehicles.arms.chain import frames, jacobian, read_chain
from mrs_simulator.vehicles.arms.inverse_kinematics import EASY, tool_inputs
from mrs_simulator.vehicles.arms.models import MODELS, chain_of, data_file
from mrs_simulator.vehicles.arms.team import ArmedTeam, ArmedTeamInSpace
from mrs_simulator.world.world import World, WorldError

PERIOD = 0.05


def postures(chain, count=12):
    return np.random.default_rng(3).uniform(chain.lower, chain.upper, (count, len(chain.joints)))


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_forward_kinematics_are_pybullets(model):
    chain = chain_of(model)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(data_file(model.file), useFixedBase=True, physicsClientId=client)
        count = pybullet.getNumJoints(body, physicsClientId=client)
        told = [pybullet.getJointInfo(body, i, physicsClientId=client) for i in range(count)]
        places = {info[1].decode(): info for info in told}
        tool = next(info[0] for info in told if info[12].decode() == model.tool)
        for key, values in (("lower", 8), ("upper", 9), ("effort", 10), ("speed", 11)):
            given = [places[name][values] for name in model.joints]
            np.testing.assert_allclose(getattr(chain, key), given)
        for q in postures(chain):
            for name, angle in zip(model.joints, q):
                joint = places[name][0]
                pybullet.resetJointState(body, joint, angle, physicsClientId=client)
            state = pybullet.getLinkState(
                body, tool, computeForwardKinematics=1, physicsClientId=client
            )
            found = frames(chain, q[np.newaxis])[0, -1]
            np.testing.assert_allclose(found[:3, 3], state[4], atol=1e-6)  # float32 there
            turn = np.array(pybullet.getMatrixFromQuaternion(state[5])).reshape(3, 3)
            np.testing.assert_allclose(found[:3, :3], turn, atol=1e-5)
    finally:
        pybullet.disconnect(client)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_jacobian_is_the_derivative_of_the_place(model):
    chain, h = chain_of(model), 1e-6
    q = postures(chain)
    given = jacobian(chain, frames(chain, q))
    for i, step in enumerate(h * np.eye(q.shape[1])):
        ahead, behind = (frames(chain, each)[:, -1, :3, 3] for each in (q + step, q - step))
        np.testing.assert_allclose(given[:, :, i], (ahead - behind) / (2.0 * h), atol=1e-8)


def test_a_sliding_joint_moves_along_its_axis(tmp_path):
    text = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
      <joint name="s" type="prismatic"><parent link="a"/><child link="b"/><origin xyz="0 0 1"/>
        <axis xyz="0 2 0"/><limit lower="-1" upper="1" velocity="0.5" effort="5"/></joint>
      <joint name="f" type="fixed"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/>
        <axis xyz="0 0 0"/></joint></robot>"""
    path = tmp_path / "slide.urdf"
    path.write_text(text)
    chain = read_chain(str(path), ("s",), "c")
    found = frames(chain, [[0.25]])
    np.testing.assert_allclose(found[0, -1, :3, 3], [1.0, 0.25, 1.0])
    np.testing.assert_allclose(jacobian(chain, found)[0, :, 0], [0.0, 1.0, 0.0])
    with pytest.raises(ScenarioError, match="joints s move the link 'c', wanted t"):
        read_chain(str(path), ("t",), "c")


# Base and arm together ---------------------------------------------------------------------------


def placed(team, count):
    """Return random poses (n, 3) and joints near home (n, 1 + k)."""
    rng = np.random.default_rng(5)
    pose = np.column_stack([4.0 * np.arange(count), np.zeros(count), rng.uniform(-3, 3, count)])
    joints = team.rest_joints.copy()
    joints[:, 1:] += rng.uniform(-0.3, 0.3, joints[:, 1:].shape) * (team.rates > 0.0)
    return pose, joints


def omnidirectional():
    content = {"base": "youbot", "arm": {"model": "iiwa", "mount": [0.1, 0.0, 0.1, 0.0]}}
    return kind("mobile_iiwa", own={"mobile_iiwa": content})


def test_tools_move_as_wanted_on_any_base():
    kinds = ["husky_panda", "husky_xarm6", omnidirectional()]
    team = ArmedTeamInSpace(kinds)
    pose, joints = placed(team, 3)
    u = np.array([[0.2, -0.1, 0.05], [-0.1, 0.2, -0.05], [0.1, 0.1, 0.1]])
    for wanted in (u, -u):
        command = team.command(wanted, pose, joints, 0.1, 1e-9)
        moved = team.velocity(command, pose, joints, 0.1, 1e-9)
        np.testing.assert_allclose(moved, wanted, atol=1e-9)
    assert (team.excess(command, joints, 1e-9) < 1.0).all()
    assert np.all(command[1, -1] == 0.0)  # six joints


def test_velocity_is_the_derivative_of_the_point():
    team = ArmedTeamInSpace(["husky_panda", omnidirectional()])
    pose, joints = placed(team, 2)
    command = np.random.default_rng(2).uniform(-0.3, 0.3, (2, len(team.axes))) * team.robot_axes
    given = team.velocity(command, pose, joints, 0.1, PERIOD)
    h, cos, sin = 1e-6, np.cos(pose[:, 2]), np.sin(pose[:, 2])
    vx, vy, omega = command[:, 0], command[:, 1], command[:, 2]
    rate = np.column_stack([cos * vx - sin * vy, sin * vx + cos * vy, omega])
    turned = np.column_stack([np.zeros(2), command[:, 3:]])
    ends = [
        team.point(pose + sign * h * rate, joints + sign * h * turned, 0.1) for sign in (1.0, -1.0)
    ]
    np.testing.assert_allclose(given, (ends[0] - ends[1]) / (2.0 * h), atol=1e-7)


def test_a_held_command_moves_the_tool_by_what_was_wanted():
    """The mapping is that of the middle: the error falls with the period's third power."""
    errors = []
    for period in (0.1, 0.05):
        team = ArmedTeamInSpace(["husky_panda"], None)
        pose, joints = placed(team, 1)
        world = World(team, pose, step=period, limits=None)
        world.motion.q[:] = joints[:, 1:]
        wanted = np.array([[0.1, 0.2, 0.05]])
        begin = team.point(world.pose, world.joints, 0.1)
        world.set_commands([0], team.command(wanted, pose, joints, 0.1, period))
        world.step()
        moved = team.point(world.pose, world.joints, 0.1) - begin
        errors.append(np.abs(moved - period * wanted).max())
    assert errors[0] < 1e-4 and errors[1] < errors[0] / 6.0


def test_an_arm_comes_home_while_its_tool_rests():
    team = ArmedTeamInSpace(["husky_panda"])
    pose, joints = placed(team, 1)
    world = World(team, pose)
    world.motion.q[:] = joints[:, 1:]
    begin = team.point(world.pose, world.joints, 0.1)
    for _ in range(250):
        told = team.command(np.zeros((1, 3)), world.pose, world.joints, 0.1, world.step_size)
        world.set_commands([0], told)
        world.step()
    assert np.abs(team.point(world.pose, world.joints, 0.1) - begin).max() < 1e-3
    left, away = (np.linalg.norm(each - team.rest_joints) for each in (world.joints, joints))
    assert left < 0.6 * away


def test_reaching_is_damped_where_the_tool_cannot_go():
    jacobian = np.zeros((2, 3, 4))
    jacobian[:, [0, 1], [0, 1]] = 1.0  # nothing moves it up but the last, which the first has not
    jacobian[1, 2, 3] = 1.0
    scale = np.array([[1.0, 1.0, 1.0, 0.0], [1.0, 1.0, 1.0, 1.0]])
    wanted, free = np.tile([0.3, -0.2, 0.4], (2, 1)), np.full((2, 4), np.inf)
    found = tool_inputs(jacobian, wanted, np.zeros((2, 4)), scale, -free, free)
    assert np.isfinite(found).all() and found[0, 3] == 0.0
    np.testing.assert_allclose(found[1], [0.3, -0.2, 0.0, 0.4], atol=1e-12)
    assert 0.9 * 0.3 < found[0, 0] <= 0.3  # as far as it can, and a little damped
    barely = np.array([[1.0, 1.0, 1.0, EASY]])
    found = tool_inputs(jacobian[1:], wanted[1:], np.zeros((1, 4)), barely, -free[1:], free[1:])
    np.testing.assert_allclose(found[0, 3], 0.4, atol=1e-9)
    hardly = np.array([[1.0, 1.0, 1.0, 0.02 * EASY]])
    found = tool_inputs(jacobian[1:], wanted[1:], np.zeros((1, 4)), hardly, -free[1:], free[1:])
    assert 0.0 < found[0, 3] < 0.01  # instead of 400 times what it can do


def test_others_make_up_for_an_input_at_its_bound():
    jacobian = np.zeros((1, 3, 4))
    jacobian[0] = np.column_stack([np.eye(3), [1.0, 0.0, 0.0]])
    high, low = np.array([[0.05, 9.0, 9.0, 9.0]]), np.full((1, 4), -9.0)
    wanted = np.array([[0.4, 0.1, 0.0]])
    found = tool_inputs(jacobian, wanted, np.zeros((1, 4)), np.ones((1, 4)), low, high)
    np.testing.assert_allclose(found, [[0.05, 0.1, 0.0, 0.35]], atol=1e-12)


def test_joints_keep_their_ends_and_speeds():
    team = ArmedTeam(["husky_panda", "pioneer3dx"])
    world = World(team, [[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]])
    command = np.zeros((2, len(team.axes)))
    command[0, 2:] = 100.0
    for _ in range(100):
        before = world.joints
        world.set_commands([0, 1], command)
        world.step()
        rate = np.abs(world.joints - before)[:, 1:] / world.step_size
        assert (rate <= team.rates + 1e-9).all()
    np.testing.assert_allclose(world.joints[0, 1:], team.upper[0])
    assert not world.joints[1].any()
    assert world.motion.ended[0].all()


# As verdicts have it, stated apart -------------------------------------------------------------


@pytest.mark.parametrize("made", [ArmedTeam, ArmedTeamInSpace])
def test_what_moves_the_tools_is_what_verdicts_state_apart(made):
    kinds = ["husky_panda", "husky_xarm6", omnidirectional()]
    team, rng = made(kinds), np.random.default_rng(7)
    pose, joints = placed(team, 3)
    robots = ArmedRobots(team, 0.1, PERIOD, "robot")
    limited = 0
    for _ in range(20):
        u = rng.normal(0.0, 1.0, (3, team.dimension))
        q = joints.copy()
        q[:, 1:] += rng.uniform(-1.0, 1.0, (3, 7)) * (team.rates > 0.0)
        q[:, 1:] = np.clip(q[:, 1:], team.lower, team.upper)
        robots.be(pose, None, q)
        np.testing.assert_allclose(robots.points, team.point(pose, q, 0.1), atol=1e-12)
        command = team.command_within(u, pose, q, 0.1, PERIOD, "robot")
        np.testing.assert_allclose(robots.commands(u), command, atol=1e-11)
        limited += robots.limited_now.sum()
        robots.move(command, PERIOD)
        np.testing.assert_allclose(robots.q, team.moved(q[:, 1:], command[:, 3:], PERIOD))
    assert 0 < limited < 60


@pytest.mark.parametrize(
    "name, value",
    [("HOMEWARDS", 0.45), ("tool_inputs", lambda *given: 1.001 * tool_inputs(*given))],
)
def test_a_mistake_in_the_mapping_of_arms_fails_the_verdict(monkeypatch, name, value):
    monkeypatch.setattr(team_of_arms, name, value)
    checks = {c["name"]: c for c in simulate(scenario(duration=2.0)).verdict["checks"]}
    assert not checks["commands off the published law [-]"]["passed"]


# Teams and runs ----------------------------------------------------------------------------------


def scenario(**changes):
    poses = [[1.5, 0.5, 3.0], [0.0, 2.0, -1.6], [-2.0, -1.0, 0.4]]
    control = {"protocol": "displacement_formation", "rate": 20, "dimension": 3}
    control["parameters"] = {"gain": 0.2, "shape": "circle", "size": 2.0}
    content = {"model": "husky_panda", "robots": 3, "poses": poses, "control": control}
    content.update(topology={"preset": "complete"}, duration=12.0)
    return dict(content, **changes)


def test_a_protocol_runs_on_tool_points_in_space(tmp_path):
    run = simulate(scenario(duration=5.0), out=tmp_path)
    assert run.passed, str(run)
    assert run.run.axes[:2] == ("linear.x", "angular.z") and run.run.axes[-1] == "arm.7"
    assert run.run.joints.shape == (51, 3, 8)
    again = open_run(tmp_path)
    assert again.passed and np.array_equal(again.run.joints, run.run.joints)
    team = ArmedTeamInSpace(["husky_panda"] * 3)
    told = run.run.in_space(3)
    points = team.point(told.pose, told.joints, 0.1)
    np.testing.assert_allclose(points, told.hand, atol=1e-9)


def test_planar_protocols_move_tools_beside_other_robots_and_keep_their_height():
    control = dict(scenario()["control"], dimension=2)
    model = ["husky_panda", "husky_xarm6", "pioneer3dx"]
    run = simulate(scenario(model=model, control=control, limits="none", duration=5.0))
    assert run.passed, str(run)
    height = run.run.point_z
    assert np.ptp(height[:, :2], axis=0).max() < 1e-3 and not height[:, 2].any()
    assert height[0, 0] > 0.5


def test_cars_beside_arms_keep_the_directions_of_their_points():
    """Their steering turns what is ahead of them, and speeds beyond their limits slow it with them."""
    control = dict(scenario()["control"], dimension=2)
    control["parameters"] = {"gain": 0.5, "shape": "circle", "size": 4.0}
    run = simulate(
        scenario(model=["husky_panda", "f1tenth", "pioneer3dx"], control=control, duration=2.0)
    )
    checks = {check["name"]: check for check in run.verdict["checks"]}
    assert checks["commands off the published law [-]"]["passed"]
    assert checks["largest distance from the law on these robots [m]"]["passed"]


@pytest.mark.parametrize(
    "fidelity", ["kinematic", pytest.param("dynamic", marks=pytest.mark.release)]
)
def test_drones_beside_arms_land_where_they_receive_nothing(fidelity):
    team = ArmedTeam(["husky_panda", "crazyflie2"])
    poses = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]
    world = World(team, poses, z=[0.0, 0.2], fidelity=fidelity, step=0.05)
    world.set_commands([0, 1], np.zeros((2, len(team.axes))))
    for _ in range(120):
        world.step()
    assert world.z[1] < 0.15
    world.close()


def test_robots_that_fly_and_robots_with_arms_are_one_team():
    control = dict(scenario()["control"], dimension=2)
    model = ["husky_panda", "crazyflie2", "robotino3"]
    changes = {"model": model, "control": control, "altitude": [0.0, 1.0, 0.0], "duration": 2.0}
    run = simulate(scenario(**changes)).run
    assert run.axes[:4] == ("linear.x", "linear.y", "linear.z", "angular.z")
    np.testing.assert_allclose(run.point_z[-1], [run.point_z[0, 0], 1.0, 0.0], atol=1e-3)
    assert not run.command[:, 0, [1, 2]].any() and run.command[:, 0, 4:].any()
    assert not run.command[:, 1:, 4:].any()


def test_what_cannot_be_is_refused():
    with pytest.raises(ValueError, match="robot2, a Pioneer 3-DX, has no arm; wanted 2"):
        simulate(scenario(model=["husky_panda", "pioneer3dx", "husky_panda"]))
    with pytest.raises(WorldError, match="robot1, Husky A200 with a Panda arm, has an arm"):
        simulate(scenario(), fidelity="point_mass")
    arm = {"model": "panda", "mount": [0.0, 0.0, 0.2, 0.0]}
    for base, change, words in (
        ("f1tenth", {}, "drive car, wanted a wheeled base whose speeds are free"),
        ("husky", {"model": "pandora"}, "pandora.*wanted"),
        ("husky", {"mount": [0.0, 0.0, 0.2]}, "wanted a list of 4 numbers"),
        ("husky", {"mount": [99.0, 0.0, 0.2, 0.0]}, "wanted within 10 m"),
        ("husky", {"home": [9.0] * 7}, "panda_joint1 at 9 rad, wanted from -2.9671 to 2.9671"),
    ):
        own = {"own": {"base": base, "arm": dict(arm, **change)}}
        with pytest.raises(ValueError, match=words):
            ArmedTeam([kind("own", own=own)])


def test_teams_without_arms_know_of_none():
    team = Team(["pioneer3dx", "robotino3"])
    assert not team.has_arms and team.rest_joints.shape == (2,)


def test_ramps_of_bases_fail_no_right_law_on_tools():
    """They cost the first moments of a path, which theory does not know."""
    scenario = {
        "model": "husky_panda",
        "poses": [[0, 0, 0], [8, 0, 1], [8, 8, 2], [0, 8, -1]],
        "control": {"protocol": "consensus", "dimension": 3, "parameters": {"gain": 0.05}},
        "topology": {"preset": "complete"},
        "duration": 3.0,
    }
    drift = checks_of(scenario)["drift of w^T p [m]"]
    assert drift["passed"] and "at its limits until" in drift["note"]


def checks_of(scenario):
    """Return the checks of a run's verdict by their names."""
    checks = simulate(scenario_from_dict(scenario)).verdict["checks"]
    return {check["name"]: check for check in checks}
