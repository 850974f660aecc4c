"""The markers node: what RViz shows of the team, its trajectories and the obstacles."""

import threading
from collections import Counter
from xml.etree import ElementTree

import numpy as np
import pytest
import rospy
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from mrs_simulator.core.spatial import rotated
from mrs_simulator.nodes.display import markers as markers_node
from mrs_simulator.nodes.display.markers import MOST_SOLIDS, Markers, Trails
from mrs_simulator.nodes.display.solids import model, solids
from mrs_simulator.ros.message_forms.messages import read_state, team_state
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.scenario.surroundings.moving_obstacles import CLOCK_START, Track
from mrs_simulator.scenario.surroundings.obstacles import Cylinder
from mrs_simulator.vehicles import kind, shipped_kinds
from mrs_simulator.vehicles.visuals import description, visual_parts
from mrs_simulator.world.world import World

PARTS = 8  # of a robot: body, plate, wheels and caster of its model, heading, number, trajectory
OBSTACLES = """
robots: 2
poses: [[0, 0, 0], [0, 3, 0]]
obstacles:
  - {type: box, center: [6, 1], size: [2.0, 1.0], yaw: 0.5, height: 0.8}
  - {type: cylinder, center: [8, 8], radius: 0.7, height: 1.0}
"""


def start(ros, *arguments):
    """Start a stage and the markers node; return a probe that watches the markers."""
    ros.node("stage", *arguments)
    ros.node("markers")
    probe = ros.probe()
    probe.ask("watch_markers()")
    return probe


def ends(probe):
    """Return the first and the last point of each trajectory."""
    return [[line["points"][0], line["points"][-1]] for line in probe.ask("shown('LINE_STRIP')")]


def test_each_robot_has_its_parts_under_names_of_their_own(ros):
    probe = start(ros, "--robots", 3)
    probe.wait("len(markers) == {}".format(3 * PARTS))
    assert probe.ask("marker_repeated") is False
    shapes = {
        "CUBE": 6,
        "CYLINDER": 6,
        "SPHERE": 3,
        "ARROW": 3,
        "TEXT_VIEW_FACING": 3,
        "LINE_STRIP": 3,
    }
    assert {kind: len(probe.ask("shown({!r})".format(kind))) for kind in shapes} == shapes
    assert probe.ask("sorted({m.header.frame_id for m in markers.values()})") == ["world"]
    assert [label["text"] for label in probe.ask("shown('TEXT_VIEW_FACING')")] == ["1", "2", "3"]
    arrows = [arrow["place"] for arrow in probe.ask("shown('ARROW')")]
    state = probe.wait("state('x') and [state('x'), state('y')]")
    assert arrows == [pytest.approx(place) for place in zip(*state)]


def test_arms_and_their_load_are_drawn_where_they_are():
    given = load_scenario(scenario_path("carrying.yaml"))
    world = World.from_scenario(given)
    shown = {(marker.ns, marker.id): marker for marker in markers_of(world, load=given.load)}
    (box,) = [marker for (ns, _), marker in shown.items() if ns == "load"]
    assert box.type == Marker.CUBE and [box.scale.x, box.scale.y, box.scale.z] == [0.3, 3.4, 0.1]
    at, carried = box.pose.position, world.load.state
    np.testing.assert_allclose([at.x, at.y, at.z], carried.place)
    arms = [marker for (ns, _), marker in shown.items() if ns == "arms"]
    assert len({marker.id for marker in arms}) == len(arms) > 3 * 7
    places = np.array([[m.pose.position.x, m.pose.position.y, m.pose.position.z] for m in arms])
    for tool in world.grasps._tools():  # the last link ends in it
        assert np.linalg.norm(places - tool, axis=1).min() < 0.15


def test_robots_that_are_gone_are_deleted(ros):
    probe = start(ros, "--robots", 3)
    probe.wait("len(markers) == {}".format(3 * PARTS))
    assert probe.ask("set_team([[0, 0, 0]])")[0] is True
    probe.wait("len(markers) == {}".format(PARTS))
    assert [label["text"] for label in probe.ask("shown('TEXT_VIEW_FACING')")] == ["1"]
    assert probe.ask("set_team([[0, 0, 0], [3, 0, 0]])")[0] is True
    probe.wait("len(markers) == {}".format(2 * PARTS))


def test_trajectories_begin_anew_after_a_reset_and_with_a_new_team(ros):
    probe = start(ros, "--robots", 2, "_speed:=2")
    probe.wait("len(markers) == {}".format(2 * PARTS))
    assert ends(probe)[0][0] == pytest.approx([10.0, -5.0], abs=0.01)  # the first hand point
    for change, origin in (
        ("call('/stage/reset', Trigger)", [10.0, -5.0]),
        ("set_team([[2, 2, 0], [5, 5, 0]])", [2.05, 2.0]),
    ):
        probe.ask("drive([1, 2], 0.5, 0.0)")
        probe.wait("shown('LINE_STRIP')[0]['points'][-1][0] > 11.5")
        assert ends(probe)[0][0] == pytest.approx([10.0, -5.0], abs=0.01)
        probe.ask("release()")
        assert probe.ask(change)[0] is True
        # Between the old trajectories and the new ones there may be none.
        away = "[abs(x - {}) for line in shown('LINE_STRIP')[:1] for x, _ in line['points']]"
        probe.wait("max({} or [9.0]) < 0.9".format(away.format(origin[0])))
        assert ends(probe)[0] == [pytest.approx(origin, abs=0.9)] * 2


def test_obstacles_are_shown(ros, tmp_path):
    path = tmp_path / "obstacles.yaml"
    path.write_text(OBSTACLES)
    probe = start(ros, "--scenario", path)
    probe.wait("len(markers) == {}".format(2 * PARTS + 2))
    cylinder = probe.ask("shown('CYLINDER')")[0]  # the group of obstacles comes first
    assert (cylinder["place"], cylinder["size"]) == ([8.0, 8.0], [1.4, 1.4, 1.0])
    box = probe.ask("shown('CUBE')")[0]
    assert (box["place"], box["size"]) == ([6.0, 1.0], [2.0, 1.0, 0.8])


def test_each_robot_is_shown_as_its_kind_is(ros, tmp_path):
    scenario = tmp_path / "mixed.yaml"
    scenario.write_text(
        "poses: [[0, 0, 0], [2, 0, 0], [4, 0, 0]]\nmodel: [husky, epuck, f1tenth]\n"
    )
    probe = start(ros, "--scenario", scenario)
    probe.wait("len(shown('CYLINDER')) == 4 + 5 + 4 and len(shown('CUBE')) == 3 + 3")
    assert probe.ask("marker_repeated") is False
    # The robots' descriptions are told, those of kinds of one's own too.
    told = "rospy.get_param('/robot{}/robot_description', '')"
    probe.wait("'<robot name=\"f1tenth\">' in {}".format(told.format(3)))
    assert probe.ask(told.format(2)) == description(kind("epuck"))
    assert probe.ask("set_team([[0, 0, 0]])")[0] is True
    probe.wait("{} == ''".format(told.format(3)))


def shown(kinds, obstacles=(), at=1):
    """Return the markers of robots of ``kinds`` that stand, and of ``obstacles``, ``at`` a time [s]."""
    return markers_of(
        World(kinds, [[3.0 * row, 0.0, 0.5] for row in range(len(kinds))]), obstacles, at
    )


def markers_of(world, obstacles=(), at=1, load=None):
    """Return the markers of a ``world``, in which robots may carry ``load``."""
    node = Markers.__new__(Markers)
    node._lock, node._shown, node._trails = threading.Lock(), {}, Trails()
    node._kinds, node._obstacles, node._load = world.team.kinds, obstacles, load
    message = team_state(world, rospy.Time(at), "world", (1, 0))
    node._newest, node._header = read_state(message), message.header
    return node._markers()


def drawn(kinds, monkeypatch, most=MOST_SOLIDS):
    """Return how many markers of each type there are of robots, ``most`` solids together."""
    monkeypatch.setattr(markers_node, "MOST_SOLIDS", most)
    return Counter(marker.type for marker in shown(kinds))


def test_an_obstacle_on_a_track_is_drawn_where_it_is():
    post = Cylinder("post", 5.0, 0.0, 0.3, 1.0, Track(((5.0, 4.0),), 0.5))
    for time, y in ((0, 0.0), (CLOCK_START + 3, 1.5)):
        markers = [
            marker for marker in shown(("epuck",), (post,), time) if marker.ns == "obstacles"
        ]
        assert [marker.pose.position.y for marker in markers] == [y]


def test_many_robots_are_drawn_as_outlines(monkeypatch):
    solid = drawn(("pioneer3dx", "epuck"), monkeypatch)
    assert (solid[Marker.CUBE], solid[Marker.CYLINDER], solid[Marker.SPHERE]) == (2, 7, 2)
    outlined = drawn(("pioneer3dx", "epuck"), monkeypatch, most=10)
    assert (outlined[Marker.CUBE], outlined[Marker.CYLINDER]) == (5, 1)  # body; wheels; round body


def test_a_model_is_turned_with_its_robot():
    lying = np.array([np.sin(np.pi / 4), 0.0, 0.0, np.cos(np.pi / 4)])  # rolled by a right angle
    found = solids(model(kind("pioneer3dx")), (1.0, 2.0, 3.0), lying, ColorRGBA())
    level = solids(model(kind("pioneer3dx")), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), ColorRGBA())
    for marker, flat in zip(found, level):
        at, was = marker.pose.position, flat.pose.position
        assert (at.x, at.y, at.z) == pytest.approx((1.0 + was.x, 2.0 - was.z, 3.0 + was.y))
    wheel = found[2].pose.orientation  # whose axle lay along y, now along z
    axle = rotated([wheel.x, wheel.y, wheel.z, wheel.w], np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(abs(axle), [0.0, 0.0, 1.0], atol=1e-6)


def test_a_description_is_one_link_of_plain_solids():
    for name in shipped_kinds():
        robot = ElementTree.fromstring(description(kind(name)))
        assert [child.tag for child in robot] == ["link"] and len(robot[0]) == len(
            visual_parts(kind(name))
        )
        assert {visual[1][0].tag for visual in robot[0]} <= {"box", "cylinder", "sphere"}
    lowest = min(float(v[0].get("xyz").split()[2]) for v in robot[0])
    assert lowest > -1.0


def test_a_kind_without_a_model_has_its_outline():
    plain = kind("robotino3")._replace(model="", shape=())
    body, nose = visual_parts(plain)
    assert body.form == "cylinder" and body.place[2] == pytest.approx(0.5 * plain.body.height)
    assert "<cylinder" in description(plain) and nose.place[2] > body.place[2]
