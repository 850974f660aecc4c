"""The markers node: what RViz shows of the team, its trajectories and the obstacles."""

import pytest

PARTS = 6  # of a robot: body, two wheels, heading, number, trajectory
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
    shapes = {"CUBE": 9, "ARROW": 3, "TEXT_VIEW_FACING": 3, "LINE_STRIP": 3}
    assert {kind: len(probe.ask("shown({!r})".format(kind))) for kind in shapes} == shapes
    assert probe.ask("sorted({m.header.frame_id for m in markers.values()})") == ["world"]
    assert [label["text"] for label in probe.ask("shown('TEXT_VIEW_FACING')")] == ["1", "2", "3"]
    arrows = [arrow["place"] for arrow in probe.ask("shown('ARROW')")]
    state = probe.ask("[state('x'), state('y')]")
    assert arrows == [pytest.approx(place) for place in zip(*state)]


def test_robots_that_are_gone_are_deleted(ros):
    probe = start(ros, "--robots", 3)
    probe.wait("len(markers) == {}".format(3 * PARTS))
    assert probe.ask("set_team([[0, 0, 0]])")[0] is True
    probe.wait("len(markers) == {}".format(PARTS))
    assert [label["text"] for label in probe.ask("shown('TEXT_VIEW_FACING')")] == ["1"]
    assert probe.ask("set_team([[0, 0, 0], [3, 0, 0]])")[0] is True
    probe.wait("len(markers) == {}".format(2 * PARTS))


@pytest.mark.parametrize(
    "change, origin",
    [
        ("call('/stage/reset', Trigger)", [10.0, -5.0]),
        ("set_team([[2, 2, 0], [5, 5, 0]])", [2.05, 2.0]),
    ],
)
def test_trajectories_begin_anew_after_a_reset_and_with_a_new_team(ros, change, origin):
    probe = start(ros, "--robots", 2, "_speed:=2")
    probe.wait("len(markers) == {}".format(2 * PARTS))
    assert ends(probe)[0][0] == pytest.approx([10.0, -5.0], abs=0.01)  # the first hand point
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
    (cylinder,) = probe.ask("shown('CYLINDER')")
    assert (cylinder["place"], cylinder["size"]) == ([8.0, 8.0], [1.4, 1.4, 1.0])
    box = probe.ask("shown('CUBE')")[0]  # the group of obstacles comes first
    assert (box["place"], box["size"]) == ([6.0, 1.0], [2.0, 1.0, 0.8])


def test_each_robot_is_shown_as_its_kind_is(ros, tmp_path):
    scenario = tmp_path / "mixed.yaml"
    scenario.write_text(
        "poses: [[0, 0, 0], [2, 0, 0], [4, 0, 0]]\nmodel: [husky, epuck, f1tenth]\n"
    )
    probe = start(ros, "--scenario", scenario)
    probe.wait("len(shown('CYLINDER')) == 1")
    assert probe.ask("marker_repeated") is False
    assert probe.ask("len(shown('CUBE'))") == 2 + 4 + 2 + 4  # bodies and wheels
    assert [marker["size"][:2] for marker in probe.ask("shown('CYLINDER')")] == [[0.07, 0.07]]
