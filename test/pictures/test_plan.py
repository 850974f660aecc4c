"""Bodies from straight above, against the same bodies in space."""

import numpy as np
import pytest

from mrs_simulator.core.spatial import about_z, upright
from mrs_simulator.pictures.plan import bodies, kind_plan, obstacle_bodies
from mrs_simulator.pictures.scene import Scene
from mrs_simulator.pictures.solids import kind_model, obstacle_models
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.scenario.team.load import Load
from mrs_simulator.state.columns import LoadState
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.vehicles import kind
from mrs_simulator.vehicles.registry import shipped_kinds

GRID = np.stack(np.meshgrid(*[np.linspace(-1.2, 1.2, 61)] * 2), axis=-1).reshape(-1, 2)


def scene(kinds, pose, shades=None, **columns):
    shades = np.full((len(pose), 3), 0.4) if shades is None else np.array(shades)
    numbers = tuple(range(1, len(pose) + 1))
    state = StateTable(0.0, numbers, pose=np.array(pose, dtype=float), **columns)
    return Scene(tuple(map(kind, kinds)), state, shades)


def above(team, shown=True):
    return bodies(team, lambda points: points, np.broadcast_to(shown, len(team.kinds)))


def polygons(layer):
    return np.split(layer.points, np.cumsum(layer.counts)[:-1])


def within(polygon, points):
    """Return which ``points`` (k, 2) are in a convex ``polygon`` of any sense, (k,)."""
    x, y = (np.roll(polygon, -1, axis=0) - polygon).T
    apart = points[:, np.newaxis] - polygon
    side = x * apart[..., 1] - y * apart[..., 0]
    return (side >= 0.0).all(axis=1) | (side <= 0.0).all(axis=1)


@pytest.mark.parametrize("name", shipped_kinds())
def test_a_kind_covers_the_same_ground_in_the_plan_and_in_space(name):
    model = kind_model(kind(name))
    faces = np.split(model.corners, np.cumsum(model.counts)[:-1])
    corners = [model.vertices[face, :2] for face, z in zip(faces, model.normals[:, 2]) if z > 1e-6]
    size = np.abs(model.vertices[:, :2]).max()
    in_space = np.any([within(each, size * GRID) for each in corners], axis=0)
    in_plan = np.any(
        [within(each, size * GRID) for each in polygons(kind_plan(kind(name)))], axis=0
    )
    assert in_space.any() and (in_space != in_plan).sum() <= 3  # of 3721, on the rims


def test_a_robot_is_at_its_pose_in_its_colour():
    (x, y), red = (2.0, -1.0), (0.8, 0.1, 0.1)
    layer = above(scene(["husky"], [(x, y, np.pi / 2)], [red]))
    plan = kind_plan(kind("husky"))
    turned = plan.points[:, ::-1] * (-1.0, 1.0)  # a quarter turn: x ahead is y of the map
    np.testing.assert_allclose(layer.points, turned + (x, y), atol=1e-12)
    assert plan.own.any() and (layer.colours[plan.own] == (*red, 1.0)).all()
    assert not (layer.colours[~plan.own] == (*red, 1.0)).all(axis=1).any()
    tip = polygons(layer)[-1][0]
    assert tip[0] == pytest.approx(x) and tip[1] > y + 0.2  # the arrow looks ahead


def test_what_is_higher_is_on_top():
    kinds, pose = ["crazyflie2", "husky_panda", "epuck"], np.zeros((3, 3))
    shades = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    team = scene(kinds, pose, shades, spatial=upright(np.zeros(3), np.array([2.0, 0.0, 0.0])))
    first = above(team).colours[:, :3].tolist()
    last = {shade: len(first) - first[::-1].index(list(shade)) for shade in shades}
    assert last[shades[2]] < last[shades[0]] and last[shades[1]] < last[shades[0]]
    arms = above(team, shown=False)
    assert len(arms.counts) == 7 and first.index(arms.colours[0, :3].tolist()) < last[shades[0]]


def test_a_load_hides_no_robot_and_stale_robots_are_pale():
    load = Load(6.0, (0.3, 3.4, 0.1), ((0.0, 1.0, 0.0), (0.1, 0.0, 0.0), (0.0, -1.0, 0.0)))
    carried = LoadState(np.array([1.5, 0.5, 0.6]), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros((3, 3)))
    team = scene(["epuck", "epuck"], np.zeros((2, 3)), fresh=np.array([True, False]))
    both = above(team)
    assert set(both.colours[:, 3]) == {1.0, 0.4}
    loaded = above(team._replace(load=load, state=team.state.replace(load=carried)))
    assert len(loaded.counts) == len(both.counts) + 1 and 0.0 < loaded.colours[-1, 3] < 1.0
    np.testing.assert_allclose(np.ptp(polygons(loaded)[-1], axis=0), (0.3, 3.4), atol=1e-9)


def test_robots_without_a_pose_are_left_out():
    team = scene(["epuck", "husky"], [(np.nan, 0.0, 0.0), (1.0, 1.0, 0.0)])
    assert len(above(team).counts) == len(kind_plan(kind("husky")).counts)
    assert above(team, shown=[True, False]) is None
    assert above(scene(["husky_panda"], [(np.nan, 0.0, 0.0)])) is None  # nor their arms


def test_every_part_differs_from_a_dark_ground():
    ground, text = np.array([0.12, 0.12, 0.13]), (0.9, 0.9, 0.9)
    team = scene(["husky", "pioneer3dx"], np.zeros((2, 3)))
    dark = bodies(team, lambda points: points, np.ones(2, dtype=bool), text)
    assert np.abs(dark.colours[:-1, :3] - ground).max(axis=1).min() > 0.05
    wheels = ~np.concatenate([kind_plan(each).own | kind_plan(each).arrow for each in team.kinds])
    assert (dark.colours[wheels, :3] > above(team).colours[wheels, :3]).all()


@pytest.mark.parametrize("obstacle", [
    Cylinder("post", 2.0, -1.0, 0.5, 1.0), Box("wall", 1.0, 3.0, 0.7, 9.0, 0.4, 1.0),
    Box("land", -1.0, 0.0, -0.4, 3.0, 2.0, 0.0),
])  # fmt: skip
def test_an_obstacle_covers_what_it_covers_in_space(obstacle):
    base, text = np.ones(3), np.zeros(3)
    layer = obstacle_bodies([obstacle], lambda points: points, base, text)
    assert np.allclose(layer.colours, [[*[0.92 if obstacle.name == "land" else 0.75] * 3, 1.0]])
    for model, (x, y, yaw) in obstacle_models(obstacle, (0.5, 0.5, 0.5, 1.0)):
        below = (model.vertices @ about_z([yaw])[0].T)[:, :2] + [x, y]
        centre = below.mean(axis=0)
        assert within(layer.points, centre + 0.995 * (below - centre)).all()
    if obstacle.name == "post":
        assert np.allclose(np.hypot(*(layer.points - [2.0, -1.0]).T), 0.5)


def test_without_obstacles_there_is_nothing_to_paint():
    assert obstacle_bodies((), lambda points: points, np.ones(3), np.zeros(3)) is None
