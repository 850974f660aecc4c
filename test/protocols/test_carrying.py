"""Loads carried together: statics of grasps, the law and its theorem, grips that let go, recordings."""

import numpy as np
import pytest

from mrs_simulator.core import grasps
from mrs_simulator.core.spatial import quaternion_product, rotated, turned_about_z
from mrs_simulator.protocols.carrying.law import Carrying
from mrs_simulator.record.recording import part_of
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.scenario.team.load import Load
from mrs_simulator.study.run.simulating import open_run, simulate
from mrs_simulator.world.arms.carrying import CarriedLoad, LoadError
from mrs_simulator.world.world import World, WorldError

OWN = np.array([[-0.1, 1.4, 0.0], [0.1, 0.0, 0.0], [-0.1, -1.4, 0.0]])
LOAD = Load(6.0, (0.3, 3.4, 0.1), tuple(map(tuple, OWN)), 400.0, 80.0)


def scenario(**changes):
    content = load_scenario(scenario_path("carrying.yaml")).to_dict()
    parameters = {
        "gain": 0.8,
        "coupling": 0.3,
        "speed": 0.5,
        "waypoints": "0 0 0.51 0, 1 0 0.6 0.2",
    }
    content["control"]["parameters"] = parameters
    return dict(content, duration=4.0, **changes)


# Statics -----------------------------------------------------------------------------------------


def test_the_grasp_matrix_adds_up_forces_and_torques():
    rng = np.random.default_rng(0)
    arms, force = rng.normal(size=(2, 5, 4, 3))
    given = grasps.grasp_matrix(arms) @ force.reshape(5, 12, 1)
    np.testing.assert_allclose(given[:, :3, 0], force.sum(axis=1))
    np.testing.assert_allclose(given[:, 3:, 0], np.cross(arms, force).sum(axis=1))


def test_the_weight_is_split_as_a_lever_has_it():
    """By hand: torques about x share 1.4 m levers evenly; about y, 0.1 m to either side: a half for one."""
    found = grasps.least_forces(OWN, LOAD.weight)
    weight = 6.0 * 9.81
    np.testing.assert_allclose(found[:, 2], [weight / 4.0, weight / 2.0, weight / 4.0])
    np.testing.assert_allclose(found[:, :2], 0.0, atol=1e-12)
    np.testing.assert_allclose(grasps.internal_forces(OWN, found), 0.0, atol=1e-12)


def test_internal_forces_move_nothing_and_shares_are_the_smallest():
    rng = np.random.default_rng(1)
    force = rng.normal(size=(3, 3))
    inner = grasps.internal_forces(OWN, force)
    np.testing.assert_allclose(grasps.grasp_matrix(OWN) @ inner.ravel(), 0.0, atol=1e-12)
    wrench = grasps.grasp_matrix(OWN) @ force.ravel()
    np.testing.assert_allclose(grasps.least_forces(OWN, wrench), force - inner, atol=1e-12)
    pull = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # along the beam
    np.testing.assert_allclose(grasps.internal_forces(OWN, pull), pull, atol=1e-12)


def test_a_body_is_found_where_its_grips_are():
    for angle in (0.0, 2.0, np.pi, -3.0):
        turn = quaternion_product(turned_about_z(angle), [0.0, np.sin(0.2), 0.0, np.cos(0.2)])
        place = np.array([3.0, -2.0, 0.7])
        points = grasps.grasp_points(OWN, place, turn)
        found, orientation = grasps.fitted_pose(OWN, points)
        np.testing.assert_allclose(found, place, atol=1e-12)
        np.testing.assert_allclose(rotated(orientation, OWN), rotated(turn, OWN), atol=1e-12)
    anyhow = np.random.default_rng(4).normal(size=(5, 3))
    turn = np.array([0.5, -0.1, 0.7, 0.5])
    found, orientation = grasps.fitted_pose(anyhow, grasps.grasp_points(anyhow, place, turn))
    np.testing.assert_allclose(found, place, atol=1e-12)
    np.testing.assert_allclose(orientation, turn, atol=1e-12)
    points = grasps.grasp_points(OWN, place, turn)
    many = np.stack([points, points + 1.0])
    places, turns = grasps.fitted_pose(OWN, many)
    np.testing.assert_allclose(places[1] - places[0], 1.0)
    np.testing.assert_allclose(grasps.grasp_points(OWN, places, turns), many, atol=1e-12)


def test_a_body_hangs_where_its_springs_balance_its_weight():
    """By hand: four springs of 400 N/m bend by m g/(4 K) alike; those of a tilted body balance it still."""
    square = np.array([[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]])
    place, turn = grasps.hanging_pose(square, square, LOAD.weight, 400.0)
    np.testing.assert_allclose(place, [0.0, 0.0, -6.0 * 9.81 / 1600.0], atol=1e-12)
    np.testing.assert_allclose(turn, [0.0, 0.0, 0.0, 1.0], atol=1e-12)
    points = OWN + np.random.default_rng(2).normal(0.0, 0.02, (3, 3))
    place, turn = grasps.hanging_pose(OWN, points, LOAD.weight, 400.0)
    at = grasps.grasp_points(OWN, place, turn)
    given = grasps.grasp_matrix(at - place) @ (400.0 * (points - at)).ravel()
    np.testing.assert_allclose(given, LOAD.weight, atol=1e-9)
    _, turn = grasps.hanging_pose(OWN, OWN, LOAD.weight, 400.0)
    # The middle grasp carries half and bends twice as far: 3.68 cm more, over 0.2 m of the body.
    np.testing.assert_allclose(
        2.0 * np.arcsin(turn[1]), np.arcsin(6.0 * 9.81 / 4 / 400 / 0.2), rtol=0.02
    )


def test_misfits_of_a_body_at_rest_give_internal_forces_alone():
    points = OWN + np.random.default_rng(2).normal(0.0, 0.02, (3, 3))
    state = CarriedLoad(LOAD, points).state
    at = grasps.grasp_points(OWN, state.place, state.orientation)
    arms = at - state.place
    np.testing.assert_allclose(
        grasps.internal_forces(arms, state.force), LOAD.stiffness * (points - at), atol=1e-9
    )
    np.testing.assert_allclose(
        grasps.grasp_matrix(arms) @ state.force.ravel(), LOAD.weight, atol=1e-9
    )


# Taking hold and letting go ----------------------------------------------------------------------


def test_a_robot_far_from_its_grasp_is_named():
    points = OWN.copy()
    points[1, 0] += 0.4
    with pytest.raises(
        LoadError, match="tool of robot2 is 0.2.. m from its grasp, wanted within 0.1"
    ):
        CarriedLoad(LOAD, points)


def test_a_grip_beyond_its_strength_lets_go_and_three_go_on_carrying():
    own = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    load = Load(4.0, (2.0, 2.0, 0.1), tuple(map(tuple, own)), 1000.0, 40.0)
    carried = CarriedLoad(load, own)
    points = own.copy()
    points[3] += [-0.1, 0.1, 0.0]
    assert carried.update(points) == [3]
    assert carried.held.tolist() == [True, True, True, False]
    np.testing.assert_allclose(carried.state.force[:, 2].sum(), 4.0 * 9.81)
    points[0] += [-0.2, -0.2, 0.0]
    assert len(carried.update(points)) == 1 and not carried.held.any()
    assert carried.state.place[2] == 0.05 and not carried.state.force.any()
    assert carried.update(points) == []


# Runs --------------------------------------------------------------------------------------------


def test_a_load_follows_its_path_and_internal_forces_end(tmp_path):
    run = simulate(scenario(), out=tmp_path)
    assert run.passed, str(run)
    checks = {check["name"]: check for check in run.verdict["checks"]}
    assert checks["largest internal force [N]"]["measured"] > 10.0
    assert checks["internal force at the end [N]"]["measured"] < 0.1
    again = open_run(tmp_path)
    assert again.passed
    part = part_of(again.run, slice(5, 20))
    for mine, read, some in zip(run.run.load, again.run.load, part.load):
        assert np.array_equal(mine, read) and np.array_equal(some, mine[5:20])
    assert np.array_equal(part.joints, run.run.joints[5:20])


def test_in_the_plane_the_load_keeps_its_height():
    content = scenario()
    content["control"]["dimension"] = 2
    content["control"]["parameters"]["waypoints"] = "0 0 0, 1 0 0.2"
    run = simulate(content)
    assert run.passed, str(run)
    assert np.ptp(run.run.load.place[:, 2]) < 2e-3


def test_a_robot_that_lags_behind_fails_the_verdict():
    class Slack(Carrying):
        def pointMassLaw(self, hand):
            return super().pointMassLaw(hand) - [[0.0], [0.0], [0.2]]

    given = scenario()["control"]["parameters"]
    run = simulate(scenario(), protocol=Slack, parameters=given)
    failed = {check["name"] for check in run.verdict["checks"] if check["passed"] is False}
    assert {"internal force at the end [N]", "load off its path at the end [m]"} <= failed


def test_a_dropped_load_is_reported_and_fails_the_verdict():
    content = scenario()
    content["load"]["grip"] = 32.0
    run = simulate(content)
    assert not run.passed
    failed = [check["name"] for check in run.verdict["checks"] if check["passed"] is False]
    assert "robots that let go" in failed
    (incident,) = run.run.meta["incidents"]
    assert incident.robot == "robot2" and "it fell" in incident.text
    assert "incidents" in failed
    assert run.run.load.place[-1, 2] == 0.05


def test_an_arm_at_its_end_is_reported_and_nothing_breaks():
    content = scenario()
    home = [0.0, 1.8, 0.0, -0.4, 0.0, 2.2, 0.785]  # nearly stretched, at the end of a joint
    own = {"base": "husky", "arm": {"model": "panda", "mount": [0.3, 0.0, 0.39, 0.0], "home": home}}
    content.update(kinds={"stretched": own}, model="stretched")
    del content["load"]
    content["control"] = {"protocol": "trajectory", "rate": 20, "dimension": 3}
    content["control"]["parameters"] = {"waypoints": "0 0 0.3, 0 0 -2", "speed": 0.5}
    run = simulate(content)
    told = [incident.text for incident in run.run.meta["incidents"]]
    assert told and all("of its arm at its end" in text for text in told)
    (check,) = [each for each in run.verdict["checks"] if each["name"] == "incidents"]
    assert check["passed"] is None
    assert np.isfinite(run.run.pose).all() and np.isfinite(run.run.joints).all()


def test_what_no_load_can_be_is_refused():
    for change, words in (
        ({"mass": 0.0}, "load.mass: 0.0, wanted"),
        ({"size": [1.0, 0.0, 1.0]}, "wanted a number above 0"),
        ({"grasps": [[0.0, 0.0, 0.0]]}, "for each of 3 robots"),
        ({"grasps": [[0.0, y, 0.0] for y in (0.0, 1.0, 2.0)]}, "not on a line"),
        ({"grips": 2.0}, "grips"),
    ):
        content = scenario()
        content["load"] = dict(content["load"], **change)
        with pytest.raises(ScenarioError, match=words):
            scenario_from_dict(content)
    with pytest.raises(ScenarioError, match="load with 5 robots: 3 grasps"):
        scenario_from_dict(scenario()).with_robots(5)
    content = scenario(model="pioneer3dx")
    with pytest.raises(WorldError, match="load: wanted robots that all have an arm"):
        World.from_scenario(scenario_from_dict(content))
    content = scenario()
    del content["load"]
    with pytest.raises(ValueError, match="carrying: the scenario has no load"):
        simulate(content)


def test_a_scenario_with_a_load_is_read_back():
    first = scenario_from_dict(scenario())
    assert scenario_from_dict(first.to_dict()).load == first.load
