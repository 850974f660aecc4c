"""Kinds of one's own are told as data: whoever hears of them draws them, and opens no file."""

import numpy as np
import pytest

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict, scenario_from_yaml
from mrs_simulator.vehicles import Team, kind, shipped_kinds
from mrs_simulator.vehicles.portable import model_shape, portable, team_from_message
from mrs_simulator.vehicles.registry import file_named
from mrs_simulator.vehicles.shape import Part, outline_parts, read_shape
from mrs_simulator.world.rendering.view import View
from mrs_simulator.world.world import World, WorldError

URDF = """<robot name="cart">
  <link name="base_link">
    <visual><origin xyz="0 0 0.5"/><geometry><box size="0.8 0.6 1.0"/></geometry>
      <material name="pink"><color rgba="1 0.2 0.9 1"/></material></visual>
    <visual><geometry><mesh filename="package://nowhere/top.stl"/></geometry></visual>
  </link>
  <link name="mast"><visual><geometry><sphere radius="0.3"/></geometry></visual></link>
  <joint name="up" type="fixed">
    <origin xyz="0.1 0 1.2" rpy="0 0 1"/><parent link="base_link"/><child link="mast"/>
  </joint>
</robot>
"""
CART = """
title: Cart
base: robotino3
model: cart.urdf
body: {front: 0.4 m, rear: 0.4 m, width: 0.6 m, height: 1.5 m, radius: null}
"""
BOX = """
drive: differential
body: {front: 0.5 m, rear: 0.5 m, width: 0.8 m, height: 0.4 m}
mass: 30 kg
wheels: {track: 0.7 m, radius: 0.1 m}
limits: {firmware: {linear.x: {max: 1 m/s}, angular.z: {max: 1 rad/s}}}
"""
OWN = """
kind: [cart.yaml, box.yaml, quick, heavy, epuck]
kinds:
  quick: {base: pioneer3dx, mass: 9 kg}
  heavy: {base: box.yaml, mass: 90 kg}
  unused: {base: away.yaml}
poses: [[0, 0, 0], [3, 0, 0], [6, 0, 0], [9, 0, 0], [12, 0, 0]]
"""


@pytest.fixture
def own(tmp_path):
    """Return the path of a scenario with kinds in files beside it."""
    texts = (("cart.urdf", URDF), ("cart.yaml", CART), ("box.yaml", BOX), ("own.yaml", OWN))
    for name, text in texts:
        (tmp_path / name).write_text(text)
    return str(tmp_path / "own.yaml")


def test_what_is_published_names_no_file_and_is_the_same_team(own, tmp_path):
    scenario = load_scenario(own)
    told, stands_for, notes = portable(scenario)
    text = told.to_yaml()
    assert str(tmp_path) not in text and ".urdf" not in text and notes == []
    assert told.kinds == ("cart", "box", "quick", "heavy", "epuck")
    assert stands_for == {"cart": scenario.kinds[0], "box": scenario.kinds[1], "heavy": "heavy"}
    heard = scenario_from_yaml(text)
    assert file_named(scenario) and not file_named(heard)
    here, there = Team.from_scenario(scenario), team_from_message(heard)
    for mine, theirs in zip(here.kinds, there.kinds):
        differs = {"model", "shape", "sources", "notes"}
        same = [key for key in mine._fields if key not in differs]
        assert [getattr(mine, key) for key in same] == [getattr(theirs, key) for key in same]
    np.testing.assert_array_equal(here.limits.top, there.limits.top)
    assert [bool(each.shape) for each in there.kinds] == [True, False, False, False, False]
    assert there.kinds[2].model == kind("pioneer3dx").model  # a shipped one


def test_a_scenario_of_shipped_kinds_is_published_as_it_is():
    scenario = scenario_from_dict({"poses": [[0, 0, 0]], "kind": "husky"})
    assert portable(scenario) == (scenario, {}, [])


def test_kinds_of_one_name_are_distinguished(own, tmp_path):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "box.yaml").write_text(BOX)
    (tmp_path / "husky.yaml").write_text(BOX)
    kinds = ("box.yaml", "other/box.yaml", "husky.yaml")
    scenario = load_scenario(own)._replace(
        kinds=tuple(str(tmp_path / name) for name in kinds), poses=np.zeros((3, 3)), own_kinds={}
    )
    assert portable(scenario)[0].kinds == ("box", "box_2", "husky_2")


def test_a_model_becomes_solids(own, tmp_path):
    box, ball = model_shape(str(tmp_path / "cart.urdf"))
    assert box == Part("box", (0.8, 0.6, 1.0), (0, 0, 0.5, 0, 0, 0), (1.0, 0.2, 0.9, 1.0))
    assert ball.form == "sphere" and ball.size == (0.3,)
    assert ball.place == pytest.approx((0.1, 0.0, 1.2, 0.0, 0.0, 1.0))


@pytest.mark.parametrize("name", shipped_kinds())
def test_the_model_of_every_shipped_kind_can_be_published(name):
    parts = model_shape(kind(name).model)
    plain = [part.to_plain() for part in parts]
    assert parts and read_shape(plain, "shape") == parts


def test_a_model_that_cannot_be_published_is_named(own, tmp_path):
    (tmp_path / "cart.urdf").write_text("<robot><link/></robot>")
    told, _, notes = portable(load_scenario(own))
    assert len(notes) == 1 and notes[0].startswith("cart: displays draw its outline: ")
    assert not team_from_message(told).kinds[0].shape


@pytest.mark.parametrize(
    "shape, said",
    [
        ("box", "shape: 'box', wanted a list"),
        ([{"form": "cone", "size": [1]}], r"shape\[0\].form: 'cone', wanted one of"),
        ([{"form": "box", "size": [1, 2]}], r"shape\[0\].size: \[1, 2\], wanted a list of 3"),
        ([{"form": "sphere", "size": [-1]}], r"size: -1.0, wanted a number above 0"),
        ([{"form": "sphere", "size": [1e9]}], "wanted a number from -100 to 100"),
        ([{"form": "sphere", "size": [1], "place": [0, 0, 0, 0, 0, 9]}], "place: 9.0"),
        ([{"form": "sphere", "size": [1], "colour": [2, 0, 0, 1]}], "colour: 2.0"),
        ([{"form": "sphere", "size": [1], "mesh": "a.stl"}], "mesh"),
        ([{"form": "sphere", "size": [1]}] * 101, "at most 100 parts"),
    ],
)
def test_a_shape_that_cannot_be_is_refused_by_name(shape, said):
    with pytest.raises(ScenarioError, match=said):
        read_shape(shape, "kinds.a: shape")


def test_a_team_that_came_over_a_topic_opens_no_file(own):
    scenario = load_scenario(own)
    with pytest.raises(ScenarioError, match="a file, wanted a kind's data"):
        team_from_message(scenario)


def test_the_3d_view_draws_what_it_is_given(own):
    told, _, _ = portable(load_scenario(own))
    kinds = team_from_message(scenario_from_yaml(told.to_yaml())).kinds[:2]
    view = View(kinds, [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    view.look_at((1.0, 0.0), 4.0)
    picture = view.picture(160, 120).astype(int)
    view.close()
    pink = (picture[:, :, 0] > 100) & (picture[:, :, 2] > 100) & (picture[:, :, 1] < 90)
    dark = picture.max(axis=2) < 110  # the outline's nose, and sides in the shade
    assert pink[:, :80].sum() > 200 and not pink[:, 100:].any()
    assert dark[:, 90:].sum() > 20
    assert outline_parts(kinds[1])[0].size == (1.0, 0.8, 0.4)


def test_motion_with_forces_wants_a_model(own):
    box = Team.from_scenario(load_scenario(own)).kinds[1]
    with pytest.raises((WorldError, ValueError), match="kind box: no model given"):
        World((box,), [[0.0, 0.0, 0.0]], fidelity="dynamic")


def test_displays_show_kinds_of_files(ros, own):
    ros.node("stage", "--scenario", own)
    ros.node("markers")
    probe = ros.probe()
    probe.ask("watch_markers()")
    probe.ask("listen('/stage/scenario', String)")
    probe.wait("[m for m in shown('CUBE') if m['size'][:2] == [0.8, 0.6]]")
    # One without shape and model is drawn as its outline.
    probe.wait("[m for m in shown('CUBE') if m['size'][:2] == [1.0, 0.8]]")
    told = probe.wait("plain('/stage/scenario')['data']")
    assert "model: [cart, box, quick, heavy, epuck]" in told
    # What the stage has told it takes back by that name, and nothing else.
    place = "[RobotSpec(kind={!r}, pose=Pose2D({}, 0, 0))]"
    call = "call('/stage/set_team', SetTeam, {})"
    assert probe.ask(call.format(place.format("box", 1))) == [True, "1 robot"]
    probe.wait("state('kind') == ['box']")
    assert probe.ask(call.format(place.format("/etc/passwd.yaml", 1)))[0] is False
