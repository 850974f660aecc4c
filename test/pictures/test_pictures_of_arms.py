"""Arms and loads in pictures: where their parts are, and that they are seen."""

import numpy as np
import pytest

from mrs_simulator.core.spatial import about_z
from mrs_simulator.pictures.arms import (
    arm_models,
    arm_outlines,
    load_corners,
    load_outline,
    load_tile,
    placed_arms,
)
from mrs_simulator.pictures.camera import Camera
from mrs_simulator.pictures.drawing import Polygons
from mrs_simulator.pictures.scene import Scene, drawn, framed
from mrs_simulator.scenario.team.load import Load
from mrs_simulator.state.columns import LoadState
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.vehicles import kind
from mrs_simulator.vehicles.arms.models import MODELS
from mrs_simulator.vehicles.arms.team import ArmedTeamInSpace

POSE = np.array([[0.0, 0.0, 0.5], [3.0, 1.0, -2.0]])
SHADES = np.full((2, 3), 0.4)


def scene_with(load, carried):
    bare = scene()
    return bare._replace(load=load, state=bare.state.replace(load=carried))


def scene(**columns):
    kinds = (kind("husky_panda"), kind("husky_xarm6"))
    return Scene(kinds, StateTable(0.0, (1, 2), pose=POSE, **columns), SHADES)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_each_link_is_drawn(model):
    models = arm_models(model)
    assert len(models) == len(model.joints) + 1
    for each in models:
        assert not each.own.any() and 0.02 < each.reach < 0.6


def test_links_are_where_the_joints_are_and_the_last_ends_at_the_tool():
    team = ArmedTeamInSpace(["husky_panda", "husky_xarm6"])
    joints = team.rest_joints + 0.1 * (np.arange(8) > 0)
    place = np.column_stack([POSE[:, :2], np.zeros(2)])
    arms = placed_arms(team.kinds, place, about_z(POSE[:, 2]), joints)
    tools = team.point(POSE, joints, 0.1)
    for each in arms:
        (row,) = each.rows
        last = each.links[0, -1]
        end = team.kinds[row].arm.chain.tool[:3, 3]
        np.testing.assert_allclose(last[:3, :3] @ end + last[:3, 3], tools[row], atol=1e-12)
        np.testing.assert_allclose(each.links[0, 0, 2, 3], 0.32)  # the root, on the top plate


def test_joints_fewer_than_an_arms_are_left_out():
    bent = scene(joints=np.ones((2, 8)))
    for joints in (np.ones(2), np.ones((2, 2)), None):
        arms = [
            placed_arms(bent.kinds, bent.place, bent.turn, each)[0].links
            for each in (joints, None, bent.state.joints)
        ]
        np.testing.assert_array_equal(arms[0], arms[1])
        assert np.abs(arms[0] - arms[2]).max() > 0.1


def faces(drawing):
    return sum(len(each.counts) for each in drawing.layers if isinstance(each, Polygons))


def test_arms_and_load_are_in_the_picture():
    load = Load(6.0, (0.3, 3.4, 0.1), ((0.0, 1.0, 0.0), (0.1, 0.0, 0.0), (0.0, -1.0, 0.0)))
    carried = LoadState(np.array([1.5, 0.5, 0.6]), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros((3, 3)))
    bare = scene()._replace(kinds=(kind("husky"),) * 2)
    carrying = scene_with(load, carried)
    camera = framed(carrying, Camera(yaw=30.0, pitch=-30.0), 640, 400)
    count = [faces(drawn(each, camera, 640, 400)) for each in (bare, scene(), carrying)]
    assert count[0] + 100 < count[1] < count[2]


def test_a_long_load_is_painted_in_tiles_that_make_up_the_whole():
    model, middles = load_tile((0.3, 3.4, 0.1))
    assert len(middles) == 7
    low = (middles[:, np.newaxis] + model.vertices).min(axis=(0, 1))
    np.testing.assert_allclose(low, [-0.15, -1.7, -0.05])
    turned = LoadState(np.ones(3), np.array([0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)]), None)
    corners = load_corners(Load(1.0, (0.3, 3.4, 0.1), ()), turned)
    np.testing.assert_allclose(np.ptp(corners, axis=0), [3.4, 0.3, 0.1])


def test_what_is_above_the_ground_has_a_shadow():
    """A beam of 2 m by 0.2 m that is turned by a right angle, 1 m above the ground."""
    load = Load(1.0, (2.0, 0.2, 0.1), ((0.0, 0.0, 0.0),))
    turn = np.array([0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)])
    carried = LoadState(np.array([3.0, 1.0, 1.0]), turn, np.zeros((1, 3)))
    outline = load_outline(load, carried)
    expected = [(2.9, 0.0), (2.9, 2.0), (3.1, 0.0), (3.1, 2.0)]
    np.testing.assert_allclose(sorted(np.round(outline, 9).tolist()), expected, atol=1e-9)
    links = np.tile(np.eye(4), (3, 1, 1))
    links[1, :3, 3], links[2, :3, 3] = (0.0, 0.0, 0.5), (0.4, 0.0, 0.5)  # up, and ahead
    up, ahead = arm_outlines(links)
    assert np.ptp(up, axis=0).max() < 0.1
    np.testing.assert_allclose(np.ptp(ahead, axis=0), [0.48, 0.08])
    without, with_it = (
        drawn(each, Camera(), 640, 480) for each in (scene(), scene_with(load, carried))
    )
    assert shaded(with_it) == shaded(without) + 1


def shaded(drawing):
    return sum(int((p.colours[:, :3] == 0.0).all(axis=1).sum()) for p in polygons(drawing))


def polygons(drawing):
    return [layer for layer in drawing.layers if isinstance(layer, Polygons)]
