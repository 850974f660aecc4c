"""Robots that users bring: what becomes of their descriptions, and what is refused by name."""

import os
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pybullet
import pytest
import yaml
from robot_descriptions import BODY, CONTROLLER, PLUGIN, box_stl, urdf, write_package, xacro

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.study.run.experiment import Experiment, run_experiment
from mrs_simulator.vehicles import kind
from mrs_simulator.vehicles.importing import imported, read_request, xacro_files
from mrs_simulator.vehicles.importing.chassis import Mass, joined
from mrs_simulator.vehicles.importing.meshes import MeshError, mesh_points
from mrs_simulator.vehicles.importing.packages import Packages
from mrs_simulator.vehicles.importing.placing import inverse_transform, roll_pitch_yaw, transform_at
from mrs_simulator.world.world import World


def bring(path, given=None, **request):
    """Return content and notes of the robot in the file at ``path``."""
    where = os.path.dirname(str(path))
    content = dict(request, urdf=os.path.basename(str(path)))
    return imported(read_request(content, "my.yaml: import", where), given or {}, "my.yaml")


def brought(directory, text, given=None, **request):
    return bring(write_package(directory, text), given, **request)


def test_a_description_with_a_drive_plugin_becomes_a_kind(tmp_path):
    content, notes = bring(write_package(tmp_path))
    assert content["name"] == "scout" and content["drive"] == "differential"
    # The box reaches from -0.13 to 0.07 m, the wheels from -0.11 to 0.11 m; axle 0.04 m high.
    assert content["body"] == pytest.approx(
        {"front": 0.07, "rear": 0.13, "width": 0.22, "height": 0.16}
    )
    assert content["mass"] == pytest.approx(1.0)
    wheels = {key: content["wheels"][key] for key in ("track", "radius", "torque", "friction")}
    assert wheels == pytest.approx({"track": 0.2, "radius": 0.04, "torque": 3.0, "friction": 0.7})
    # Wheels of 10 rad/s: 0.4 m/s, and 2 * 0.4 / 0.2 = 4 rad/s; rims of 2 m/s^2: 20 rad/s^2.
    firmware = content["limits"]["firmware"]
    assert firmware["linear.x"] == pytest.approx({"max": 0.4, "acceleration": 2.0})
    assert firmware["angular.z"] == pytest.approx({"max": 4.0, "acceleration": 20.0})
    assert content["odometry_rate"] == 30.0 and notes == ()
    assert "plugin 'drive'" in content["sources"]["wheels"]


def test_a_controllers_file_becomes_a_kind(tmp_path):
    content, notes = brought(tmp_path, urdf(plugin=""), controller="control.yaml")
    # Neither separation nor radius is given: the wheels' places and shapes tell.
    assert content["wheels"]["track"] == pytest.approx(0.2 * 1.1)
    assert content["wheels"]["radius"] == pytest.approx(0.04)
    firmware = content["limits"]["firmware"]
    assert firmware["linear.x"] == {"max": 0.5, "acceleration": 3.0}
    assert firmware["angular.z"] == {"max": 2.0}
    assert (content["command_timeout"], content["odometry_rate"]) == (0.25, 40.0)
    assert len(notes) == 1 and "-0.5 to 1" in notes[0]


def test_a_xacro_file_is_expanded_or_says_what_is_missing(tmp_path, monkeypatch):
    path = write_package(tmp_path, xacro(), "scout.urdf.xacro")
    content, _ = bring(path, arguments={"base_mass": 1.8})
    assert content["mass"] == pytest.approx(2.0)
    monkeypatch.setattr(xacro_files, "_there", lambda name: False)
    with pytest.raises(ScenarioError, match="scout.urdf.xacro: is a xacro file: wanted xacrodoc"):
        bring(path)
    with pytest.raises(ScenarioError, match="argument 'a', but it is no xacro file"):
        bring(write_package(tmp_path), arguments={"a": 1})


def test_a_namespace_alone_makes_no_xacro_file(tmp_path, monkeypatch):
    # As xacro itself writes them, with its banner.
    head = '<!-- from <xacro:include filename="$(arg x)"/> -->\n<robot name="scout" {}>'
    text = urdf().replace('<robot name="scout">', head.format('xmlns:xacro="http://ros.org/xacro"'))
    assert "xmlns:xacro" in text
    monkeypatch.setattr(xacro_files, "_there", lambda name: False)
    assert brought(tmp_path, text)[0]["name"] == "scout"
    with pytest.raises(ScenarioError, match="is a xacro file"):
        brought(tmp_path, text.replace('value="0.8"', 'value="${0.4 * 2}"'))


def test_an_include_is_found_beside_the_file(tmp_path):
    text = xacro().replace("$(find scout_description)/urdf/", "")
    assert bring(write_package(tmp_path, text, "scout.urdf.xacro"))[0]["mass"] == pytest.approx(1.0)


def test_an_include_of_a_package_that_is_not_there_is_left_out_and_reported(tmp_path):
    extra = '<xacro:include filename="$(find a_laser)/laser.xacro"/>\n<xacro:arg'
    text = xacro().replace("<xacro:arg", extra)
    content, notes = bring(write_package(tmp_path, text, "scout.urdf.xacro"))
    assert content["mass"] == pytest.approx(1.0)
    assert [note for note in notes if "package 'a_laser' is not in ROS_PACKAGE_PATH" in note]
    used = text.replace("</robot>", "<xacro:a_laser/></robot>")
    with pytest.raises(ScenarioError, match="unknown macro name: xacro:a_laser; package 'a_laser'"):
        bring(write_package(tmp_path, used, "scout.urdf.xacro"))


@pytest.fixture
def world():
    client = pybullet.connect(pybullet.DIRECT)
    yield client
    pybullet.disconnect(client)


def loaded_mass(path, client):
    body = pybullet.loadURDF(
        path, flags=pybullet.URDF_USE_INERTIA_FROM_FILE, physicsClientId=client
    )
    links = range(-1, pybullet.getNumJoints(body, physicsClientId=client))
    dynamics = [pybullet.getDynamicsInfo(body, link, physicsClientId=client) for link in links]
    return sum(each[0] for each in dynamics)


def test_links_without_inertia_weigh_nothing(tmp_path, world):
    # Straight from its file pybullet gives base_footprint, caster and imu 1 kg each.
    assert loaded_mass(bring(write_package(tmp_path))[0]["model"], world) == pytest.approx(1.0)


def test_a_file_written_anew_is_read_anew(tmp_path, world):
    first = brought(tmp_path, urdf())[0]["model"]
    assert loaded_mass(first, world) == pytest.approx(1.0)
    second = brought(tmp_path, urdf().replace('mass value="0.8"', 'mass value="2.8"'))[0]["model"]
    assert loaded_mass(second, world) == pytest.approx(3.0)
    assert brought(tmp_path, urdf())[0]["model"] == first


def test_a_missing_mesh_is_replaced_by_the_bounding_shape(tmp_path, world):
    path = write_package(tmp_path)
    os.remove(str(tmp_path / "scout_description" / "meshes" / "base.stl"))
    (tmp_path / "scout_description" / "meshes" / "tire.stl").write_bytes(b"no mesh")
    content, notes = bring(path)
    assert len(notes) == 3 and "link 'base_link': visual: mesh package://scout" in notes[2]
    assert "collision shape is drawn instead" in notes[2] and "not drawn" not in "".join(notes)
    assert loaded_mass(content["model"], world) == pytest.approx(1.0)
    drawn = ElementTree.parse(content["model"]).findall(
        "link[@name='base_link']/visual/geometry/box"
    )
    assert [box.get("size") for box in drawn] == ["0.2 0.16 0.1"]


def test_a_collision_mesh_becomes_the_box_around_it(tmp_path, world):
    mesh = '<mesh filename="../meshes/base.stl" scale="2 1 1"/>'
    text = urdf(body=BODY.replace('<box size="0.2 0.16 0.1"/>', mesh))
    content, notes = brought(tmp_path, text)
    # The mesh reaches from z = 0 to 0.1 m, 0.06 m above base_link.
    assert content["body"] == pytest.approx(
        {"front": 0.17, "rear": 0.23, "width": 0.22, "height": 0.17}
    )
    assert "the box around it" in notes[0]
    assert loaded_mass(content["model"], world) == pytest.approx(1.0)
    os.remove(str(tmp_path / "scout_description" / "meshes" / "base.stl"))
    with pytest.raises(ScenarioError, match="link 'base_link': collision.*or the key body"):
        bring(tmp_path / "scout_description" / "urdf" / "scout.urdf")
    body = {"front": 0.1, "rear": 0.2, "width": 0.2, "height": 0.3}
    content, notes = bring(tmp_path / "scout_description" / "urdf" / "scout.urdf", {"body": body})
    assert content["body"] == {} and "left out" in "".join(notes)


def test_packages_are_found_as_ros_finds_them(tmp_path, monkeypatch):
    write_package(tmp_path / "first")
    write_package(tmp_path / "second" / "deep")
    ignored = tmp_path / "first" / "scout_description"
    uri = "package://scout_description/meshes/base.stl"
    both = os.pathsep.join([str(tmp_path / "first"), str(tmp_path / "second")])
    assert Packages(str(tmp_path), search=both).file(uri, "")[0] == str(
        tmp_path / "first" / "scout_description" / "meshes" / "base.stl"
    )
    (ignored / "CATKIN_IGNORE").write_text("")
    assert "second" in Packages(str(tmp_path), search=both).file(uri, "")[0]
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "second"))
    assert "second" in Packages(str(tmp_path)).file(uri, "")[0]
    # The package in which the description lies, and one that the user names, come first.
    assert "first" in Packages(str(ignored / "urdf")).file(uri, "")[0]
    given = {"scout_description": str(tmp_path)}
    assert Packages(str(ignored / "urdf"), given).file(uri, "")[0] is None
    path, why = Packages(str(tmp_path), search="").file(uri, "")
    assert path is None and "'scout_description' is not in ROS_PACKAGE_PATH" in why
    with pytest.raises(ScenarioError, match="http://x/y.stl', wanted package://"):
        Packages(str(tmp_path)).file("http://x/y.stl", "link 'a'")


def test_what_the_user_says_goes_over_the_description(tmp_path, world):
    body = {"radius": 0.2}
    content, _ = brought(tmp_path, urdf(), {"mass": "2 kg", "body": body})
    assert content["mass"] == pytest.approx(2.0) and set(content["body"]) == {"height"}
    assert loaded_mass(content["model"], world) == pytest.approx(2.0)
    limits = {"firmware": {axis: {"max": 1.0} for axis in ("linear.x", "angular.z")}}
    content, _ = brought(tmp_path, urdf(limit=""), {"limits": limits})
    assert content["limits"]["firmware"]["linear.x"] == {"acceleration": 2.0}
    with pytest.raises(
        ScenarioError, match=r"my.yaml: limits.firmware.linear.x.max: nothing given"
    ):
        brought(tmp_path, urdf(limit=""))


def test_a_moving_part_is_held_and_reported(tmp_path):
    text = urdf(
        body=BODY.replace('name="scan_joint" type="fixed"', 'name="scan_joint" type="prismatic"')
    )
    _, notes = brought(tmp_path, text)
    assert len(notes) == 1 and "joint 'scan_joint' (prismatic) is held at 0" in notes[0]


def skid_steer():
    """Return the description of a robot on four driven wheels, at x = 0 and -0.1 m, y = +-0.1 m."""
    from robot_descriptions import WHEEL

    rear = "".join(
        WHEEL.format(side="rear_" + side, y=y, limit="").replace('xyz="0 ', 'xyz="-0.1 ', 1)
        for side, y in (("left", 0.1), ("right", -0.1))
    )
    plugin = PLUGIN.replace("diff_drive", "skid_steer_drive")
    for side in ("left", "right"):
        tag, name = side + "Joint", "wheel_{}_joint".format(side)
        both = "<{0}FrontJoint>{1}</{0}FrontJoint><{0}RearJoint>wheel_rear_{0}_joint</{0}RearJoint>"
        plugin = plugin.replace("<{0}>{1}</{0}>".format(tag, name), both.format(side, name))
    return urdf(body=BODY + rear, plugin=plugin)


def test_four_driven_wheels_are_a_pair_midway(tmp_path):
    content, notes = brought(tmp_path, skid_steer())
    # Measured from midway between the axles, 0.05 m behind the front one.
    assert content["body"]["front"] == pytest.approx(0.12)
    assert content["body"]["rear"] == pytest.approx(0.09)
    assert content["mass"] == pytest.approx(1.1)
    # They stand at (+-0.05, +-0.1) m: 2 (0.05^2 + 0.1^2)/0.1 = 0.25 m.
    wheels = content["wheels"]
    assert (wheels["spacing"], wheels["wheelbase"]) == pytest.approx((0.2, 0.1))
    assert wheels["track"] == pytest.approx(0.25)
    assert any("their effective track is 0.25 m" in note for note in notes)


def test_a_skid_steer_turns_with_forces_as_its_effective_track_tells(tmp_path):
    path = write_package(tmp_path, skid_steer())
    robot = kind("mine", own={"mine": {"import": {"urdf": str(path)}}})
    world = World((robot,), [[0.0, 0.0, 0.0]], fidelity="dynamic")
    for _ in range(100):
        world.set_commands([0], np.array([[0.0, 0.5]]))
        world.step()
    assert world.twist[0, 2] == pytest.approx(0.5, rel=0.1)
    world.close()


BAD = {
    "no XML": (lambda text: text[:-20], "scout.urdf: not valid XML"),
    "no robot": (lambda text: text.replace("robot", "sdf"), "<sdf>, wanted a <robot>"),
    "no plugin": (
        lambda text: text.replace("gazebo_ros_diff", "x"),
        "drive plugins: none; wanted one",
    ),
    "no joint": (
        lambda text: text.replace("<leftJoint>wheel_left_joint", "<leftJoint>wheel_left"),
        "plugin 'drive': joint: unknown 'wheel_left'; did you mean 'wheel_left_joint'",
    ),
    "no tag": (lambda text: text.replace("rightJoint>", "right>"), "rightJoint: nothing given"),
    "no number": (
        lambda text: text.replace(">0.20<", ">wide<"),
        "wheelSeparation: 'wide', wanted a number above 0",
    ),
    "nan": (lambda text: text.replace(">0.08<", ">nan<"), "wheelDiameter: 'nan', wanted a number"),
    "negative mass": (
        lambda text: text.replace('value="0.8"', 'value="-1"'),
        "link 'base_link': inertial: mass: value: '-1', wanted a number of at least 0",
    ),
    "mass without inertia": (
        lambda text: text.replace("<inertia ", "<inert "),
        "link 'base_link': inertial: wanted a tag <inertia>",
    ),
    "inertia of no body": (
        lambda text: text.replace('ixx="0.002" ixy="0"', 'ixx="0.002" ixy="1"'),
        "link 'base_link': inertial: inertia: not that of any body",
    ),
    "two parents": (
        lambda text: text.replace('<child link="scan_link"/>', '<child link="imu_link"/>'),
        "joint 'scan_joint': link 'imu_link' is the child of joint 'imu_joint', too",
    ),
    "unknown link": (
        lambda text: text.replace('<parent link="base_footprint"/>', '<parent link="base_foot"/>'),
        "joint 'base_joint': link: unknown 'base_foot'; did you mean 'base_footprint'",
    ),
    "two roots": (
        lambda text: text.replace("</robot>", '<link name="lost"/></robot>'),
        "links without a parent: 'base_footprint', 'lost'; wanted one",
    ),
    "a ring": (
        lambda text: text.replace(
            "</robot>",
            '<link name="a"/><link name="b"/><joint name="c" type="fixed"><parent link="a"/>'
            '<child link="b"/></joint><joint name="d" type="fixed"><parent link="b"/>'
            '<child link="a"/></joint></robot>',
        ),
        "link 'a' hangs from itself",
    ),
    "a name twice": (
        lambda text: text.replace('link name="imu_link"', 'link name="base_link"'),
        "link 'base_link': the name is taken",
    ),
    "no shape": (
        lambda text: text.replace('<box size="0.2 0.16 0.1"/>', ""),
        "link 'base_link': collision: geometry: wanted one of box, cylinder, sphere, mesh",
    ),
    "fixed wheel": (
        lambda text: text.replace(
            'wheel_left_joint" type="continuous"', 'wheel_left_joint" type="fixed"'
        ),
        "joint 'wheel_left_joint': type fixed, wanted one of continuous, revolute",
    ),
    "wheel's axis": (
        lambda text: text.replace('<axis xyz="0 0 1"/>', '<axis xyz="1 0 0"/>'),
        "joint 'wheel_left_joint': turns about (1, 0, 0); wanted the y axis",
    ),
    "no axis": (
        lambda text: text.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>'),
        "joint 'wheel_left_joint': axis: xyz: its length is 0",
    ),
    "body under the ground": (
        lambda text: text.replace('<sphere radius="0.01"/>', '<sphere radius="0.05"/>'),
        "link 'caster_link': collision: reaches 0.04 m below the wheels' lowest point",
    ),
    "in millimetres": (
        lambda text: text.replace('<sphere radius="0.01"/>', '<sphere radius="1e9"/>'),
        "link 'caster_link': collision: reaches 1e+09 m from the robot",
    ),
    "friction": (
        lambda text: text.replace(">0.7<", ">high<"),
        "gazebo 'wheel_left_link': mu1: 'high'",
    ),
}


@pytest.mark.parametrize("name", sorted(BAD))
def test_a_bad_description_is_refused_with_the_link_joint_or_tag_named(tmp_path, name):
    change, wanted = BAD[name]
    text = change(urdf())
    assert text != urdf()
    with pytest.raises(ScenarioError) as error:
        brought(tmp_path, text)
    assert wanted in str(error.value)


def test_wheels_that_are_no_pair_are_refused(tmp_path):
    with pytest.raises(ScenarioError, match="wanted the left wheel left of the right one"):
        brought(tmp_path, urdf(left=-0.1, right=0.1))
    crooked = urdf().replace('xyz="0 0.1 0.03"', 'xyz="0.1 0.1 0.03"')
    with pytest.raises(ScenarioError, match="0.1 m apart along x"):
        brought(tmp_path, crooked)
    twice = urdf().replace("<rightJoint>wheel_right", "<rightJoint>wheel_left")
    with pytest.raises(ScenarioError, match="'wheel_left_joint' is named twice"):
        brought(tmp_path, twice)


@pytest.mark.parametrize(
    "text, wanted",
    [
        ("a: 1", "controllers of the type .*: none; wanted one"),
        (CONTROLLER + CONTROLLER.replace("scout", "b", 1), "b/mobile.*, scout/mobile"),
        (
            CONTROLLER.replace("left_wheel: wheel_left_joint", "left_wheel: 3"),
            "left_wheel: 3, wanted",
        ),
        (CONTROLLER.replace("max_velocity: 2.0", "max_velocity: -1"), "angular.z.max_velocity: -1"),
        (CONTROLLER.replace("timeout: 0.25", "timeout: soon"), "cmd_vel_timeout: 'soon'"),
        (
            CONTROLLER.replace("_multiplier: 1.1", "_multiplier: 0"),
            "wheel_separation_multiplier: 0",
        ),
        (CONTROLLER.replace("wheel_left_joint", "wheel"), "joint: unknown 'wheel'"),
    ],
)
def test_a_bad_controller_is_refused_by_its_key(tmp_path, text, wanted):
    path = write_package(tmp_path, urdf(plugin=""))
    with open(os.path.join(os.path.dirname(path), "control.yaml"), "w") as file:
        file.write(text)
    with pytest.raises(ScenarioError, match=wanted):
        bring(path, controller="control.yaml")


def test_one_of_several_controllers_is_chosen_by_name(tmp_path):
    path = write_package(tmp_path, urdf(plugin=""))
    with open(os.path.join(os.path.dirname(path), "control.yaml"), "w") as file:
        file.write(CONTROLLER + CONTROLLER.replace("scout", "b", 1).replace("0.25", "0.5"))
    content, _ = bring(path, controller="control.yaml", controller_name="b/mobile_base_controller")
    assert content["command_timeout"] == 0.5


def test_the_request_is_checked():
    for content, wanted in (
        ({}, "urdf: nothing given, wanted a text"),
        ({"urdf": "a.urdf", "controler": "b"}, "unknown 'controler'; did you mean 'controller'"),
        ({"urdf": "a.urdf", "arguments": [1]}, "arguments: .*wanted a mapping"),
        ({"urdf": "a.urdf", "controller_name": "b"}, "controller is not given"),
    ):
        with pytest.raises(ScenarioError, match=wanted):
            read_request(content, "my.yaml: import", "/")


def test_points_of_meshes(tmp_path):
    files = {
        "a.stl": box_stl([0, 0, 0], [1, 2, 3]),
        "b.stl": b"solid b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 2 3\nvertex 1 0 0\n",
        "c.obj": b"v 0 0 0\nv 1 2 3\nvn 9 9 9\nf 1 2 1\n",
        "d.dae": b"""<COLLADA xmlns="x"><asset><unit meter="0.1"/><up_axis>Z_UP</up_axis></asset>
          <library_geometries><geometry id="g"><mesh><source id="s"><float_array>0 0 0 10 20 15
          </float_array></source><vertices><input semantic="POSITION" source="#s"/></vertices></mesh>
          </geometry></library_geometries><library_visual_scenes><visual_scene><node>
          <scale>1 1 2</scale><instance_geometry url="#g"/></node></visual_scene>
          </library_visual_scenes></COLLADA>""",
    }
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
        points = mesh_points(str(tmp_path / name))
        np.testing.assert_allclose([points.min(axis=0), points.max(axis=0)], [[0, 0, 0], [1, 2, 3]])
    for name, content in (("e.stl", b"x"), ("f.obj", b"v a b c"), ("g.dae", b"<"), ("h.ply", b"")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(MeshError):
            mesh_points(str(tmp_path / name))


def test_transforms():
    # A quarter turn about x takes y to z; roll, pitch and yaw come back.
    turned = transform_at([1, 2, 3], [np.pi / 2, 0.0, 0.0])
    np.testing.assert_allclose(turned @ [0, 1, 0, 1], [1, 2, 4, 1], atol=1e-12)
    np.testing.assert_allclose(inverse_transform(turned) @ turned, np.eye(4), atol=1e-12)
    for rpy in ([0.1, -0.2, 3.0], [0.3, np.pi / 2, 0.0], [-0.4, -np.pi / 2, 0.0]):
        again = transform_at([0, 0, 0], roll_pitch_yaw(transform_at([0, 0, 0], rpy)))
        np.testing.assert_allclose(again, transform_at([0, 0, 0], rpy), atol=1e-9)


def test_masses_are_joined_about_their_centre():
    # Two balls of 1 kg at x = 0 and 2 m: 2 kg at 1 m, 2 kg m^2 about y and z.
    ball = Mass(1.0, np.zeros(3), 0.1 * np.eye(3))
    both = joined([ball, ball._replace(centre=np.array([2.0, 0.0, 0.0]))])
    assert both.mass == 2.0 and both.centre[0] == 1.0
    np.testing.assert_allclose(both.inertia.diagonal(), [0.2, 2.2, 2.2])


PAGE = os.path.join(
    os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "docs"
)


def example(start):
    """Return the YAML example of the page on users' robots that begins with ``start``."""
    with open(os.path.join(PAGE, "robots_of_your_own.md"), encoding="utf-8") as file:
        found = re.findall(r"```yaml\n(.*?)```", file.read(), re.S)
    (text,) = [text for text in found if text.startswith(start)]
    return text


def test_the_pages_robot_from_dimensions_drives_in_the_pages_scenario(tmp_path):
    (tmp_path / "my_bot.yaml").write_text(example("title: The robot") + example("shape:"))
    (tmp_path / "scenario.yaml").write_text(example("title: Three of ours"))
    scenario = load_scenario(str(tmp_path / "scenario.yaml"))
    verdict = run_experiment(scenario, str(tmp_path / "out"), formats=())
    assert verdict["outcome"] == "passed", verdict["checks"]
    team = Experiment(scenario).world.team
    assert team.limits.top.tolist() == [0.5, pytest.approx(2.0944, abs=1e-4)]
    (tmp_path / "mine.yaml").write_text(example("base:"))
    assert kind(str(tmp_path / "mine.yaml")).limits["firmware"][0].top == 0.4


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_an_imported_robot_drives_as_commanded(tmp_path, fidelity):
    write_package(tmp_path)
    (tmp_path / "my_scout.yaml").write_text(
        example("import:").replace(
            "turtlebot3/turtlebot3_description/urdf/turtlebot3_burger.urdf.xacro",
            "scout_description/urdf/scout.urdf",
        )
    )
    os.remove(str(tmp_path / "scout_description" / "meshes" / "base.stl"))
    content = {"model": "my_scout.yaml", "poses": [[0.0, 0.0, 0.0]], "fidelity": fidelity}
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(content))
    experiment = Experiment(load_scenario(str(tmp_path / "scenario.yaml")))
    world = experiment.world
    for _ in range(100):
        world.set_commands([0], [[0.2, 1.0]])
        world.step()
    world.close()
    # A circle of 0.2 m, after a ramp of 0.1 s at 2 m/s^2 and 0.05 s at 20 rad/s^2.
    assert world.time == pytest.approx(2.0)
    np.testing.assert_allclose(world.twist[0], [0.2, 0.0, 1.0], atol=0.01)
    np.testing.assert_allclose(world.pose[0], [0.18, 0.27, 1.97], atol=0.03)
    assert len(experiment.warnings) == 1 and "base.stl" in experiment.warnings[0]
