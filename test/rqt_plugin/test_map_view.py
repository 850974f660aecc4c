"""The map as a person uses it: real mouse, wheel and key events, and what is then drawn."""

import logging
import os
from functools import partial

import numpy as np
import pytest
import rospy

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QColor, QHelpEvent, QMouseEvent, QPainter, QPalette, QPixmap, QWheelEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QToolTip
from snapshots import snapshot_of

from mrs_simulator.core.spatial import upright
from mrs_simulator.ros.message_forms.messages import team_state
from mrs_simulator.rqt_plugin.map import axes, edge_drawing, frame, geometry, marks
from mrs_simulator.rqt_plugin.map import ground as map_ground
from mrs_simulator.rqt_plugin.map import trails as map_trails
from mrs_simulator.rqt_plugin.map.drawing import height_text
from mrs_simulator.rqt_plugin.map.sprites import Sprites
from mrs_simulator.rqt_plugin.map.style import MapStyle
from mrs_simulator.rqt_plugin.map.view import MapView
from mrs_simulator.rqt_plugin.ros_side.inbox import _from_state
from mrs_simulator.rqt_plugin.run.history import History
from mrs_simulator.rqt_plugin.widgets import colours
from mrs_simulator.rqt_plugin.widgets.colours import shade as team_shade
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.scenario.surroundings.moving_obstacles import CLOCK_START, Track
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.scenario.team.robots import FARTHEST
from mrs_simulator.vehicles import kind
from mrs_simulator.world.world import World

POSES = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, np.pi / 2], [4.0, 3.0, np.pi]])
NONE = Qt.NoModifier


@pytest.fixture
def view(app, caplog):
    """A shown map of three robots; a test in which a slot or event failed fails."""
    widget = MapView()
    widget.resize(800, 600)
    widget.show()
    widget.show_team(POSES)
    app.processEvents()
    yield widget
    widget.grab()
    widget.close()
    widget.deleteLater()
    app.processEvents()
    assert [record for record in caplog.records if record.levelno >= logging.ERROR] == []


def team(n):
    return np.column_stack([1.5 * (np.arange(n) % 10), 1.5 * (np.arange(n) // 10), np.arange(n)])


def snapshot(time, pose, fresh=None, numbers=None):
    n = len(pose)
    fresh = np.ones(n, dtype=bool) if fresh is None else np.array(fresh)
    numbers = tuple(range(1, n + 1)) if numbers is None else numbers
    return snapshot_of(time, numbers, np.array(pose), np.zeros((n, 3)), np.zeros((n, 2)), fresh)


def at(view, x, y):
    """Return the pixel of the point (x, y) [m]."""
    return QPoint(*(int(round(value)) for value in view.to_screen(x, y)))


def move(view, place, modifier=NONE, buttons=Qt.LeftButton):
    """Move the mouse with ``buttons`` down; ``QTest.mouseMove`` would move the real cursor."""
    kind = QMouseEvent.MouseMove
    where = QPointF(place)
    event = QMouseEvent(
        kind, where, QPointF(view.mapToGlobal(place)), Qt.NoButton, buttons, modifier
    )
    QApplication.sendEvent(view, event)


def drag(view, begin, end, modifier=NONE, button=Qt.LeftButton):
    QTest.mousePress(view, button, modifier, begin)
    for share in (0.3, 0.7, 1.0):
        shift = QPointF(end - begin) * share
        move(view, begin + QPoint(int(shift.x()), int(shift.y())), modifier, button)
    QTest.mouseRelease(view, button, modifier, end)


def click(view, place, button=Qt.LeftButton):
    QTest.mouseClick(view, button, NONE, place)


def wheel(view, place, notches):
    where, turned = QPointF(place), QPoint(0, 120 * notches)
    event = QWheelEvent(
        where,
        QPointF(view.mapToGlobal(place)),
        QPoint(),
        turned,
        Qt.NoButton,
        NONE,
        Qt.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(view, event)


def emitted(signal):
    """Return a list that grows by the arguments of each emission of ``signal``."""
    calls = []
    signal.connect(lambda *arguments: calls.append(arguments))
    return calls


def shade(view, x, y):
    """Return the colour drawn at (x, y) [m]."""
    return QColor(view.grab().toImage().pixel(at(view, x, y)))


def drawn(view):
    """Return the drawing as an array."""
    image = view.grab().toImage().convertToFormat(4)
    bits = image.bits()
    bits.setsize(image.sizeInBytes())
    return np.frombuffer(bits, dtype=np.uint8).copy()


def everything_in_view(view, points):
    low, high = view.frame.bounds()
    return (points >= low).all() and (points <= high).all()


# Looking


def test_at_first_the_whole_team_is_in_view_to_scale_and_upright(view):
    assert everything_in_view(view, POSES[:, :2])
    x, y = np.array(view.to_screen(1.0, 0.0)) - view.to_screen(0.0, 0.0)
    assert x > 0 and y == pytest.approx(0.0)
    assert np.array(view.to_screen(0.0, 1.0)) - view.to_screen(0.0, 0.0) == pytest.approx([0, -x])
    assert view.to_plane(*view.to_screen(1.25, -0.5)) == pytest.approx((1.25, -0.5))


def test_a_drag_pans(view):
    before = at(view, 2.0, 1.5)
    drag(view, before, before + QPoint(60, -35))
    assert view.to_screen(2.0, 1.5) == pytest.approx((before.x() + 60, before.y() - 35), abs=1.0)


@pytest.mark.parametrize("notches", [3, -2])
def test_the_wheel_zooms_about_the_cursor(view, notches):
    place = QPoint(200, 420)
    held, scale = view.to_plane(200, 420), view.frame.scale
    wheel(view, place, notches)
    assert view.to_plane(200, 420) == pytest.approx(held)
    assert view.frame.scale == pytest.approx(scale * 1.2**notches)


def test_a_forecast_that_goes_to_infinity_leaves_the_team_in_sight(view):
    paths = POSES[:, :2] + np.array([0.0, 20.0, 1e6, 1e26, np.inf])[:, np.newaxis, np.newaxis]
    view.show_forecast(paths)
    view.fit()
    low, high = view.frame.bounds()
    assert (high > POSES[:, :2].max(axis=0) + 20.0).all() and np.max(high - low) < 500.0


def test_zoom_has_bounds(view):
    for notches in (400, -800):
        wheel(view, QPoint(300, 300), notches)
        view.grab()
    assert view.frame.scale == frame.SCALES[0]


@pytest.mark.parametrize("how", ["key", "double click", "call"])
def test_fit_brings_team_targets_and_trails_into_view(view, how):
    far = POSES + [30.0, 0.0, 0.0]
    view.show_snapshot(snapshot(0.0, POSES))
    view.show_snapshot(snapshot(1.0, far))
    view.show_targets([[0.0, 40.0], [1.0, 40.0], [np.nan, np.nan]])
    wheel(view, QPoint(400, 300), 20)
    if how == "key":
        QTest.keyClick(view, Qt.Key_F)
    elif how == "double click":
        QTest.mouseDClick(view, Qt.LeftButton, NONE, QPoint(300, 200))
    else:
        view.fit()
    for points in (POSES[:, :2], far[:, :2], np.array([[0.0, 40.0]])):
        assert everything_in_view(view, points)


def test_a_team_that_was_driven_apart_is_in_view(view):
    apart = POSES * [FARTHEST / 4.0, FARTHEST / 4.0, 1.0]
    view.show_snapshot(snapshot(0.0, apart))
    view.fit(whole=True)
    assert everything_in_view(view, apart[:, :2])


def test_an_untouched_view_follows_the_team_and_a_chosen_one_stays(view):
    view.show_snapshot(snapshot(0.0, POSES))
    view.show_snapshot(snapshot(1.0, POSES + [20.0, 0.0, 0.0]))
    assert everything_in_view(view, POSES[:, :2] + [20.0, 0.0])
    wheel(view, QPoint(400, 300), 1)
    chosen = view.to_plane(0, 0)
    view.show_snapshot(snapshot(2.0, POSES + [90.0, 0.0, 0.0]))
    assert view.to_plane(0, 0) == chosen


def test_a_team_placed_out_of_an_untouched_view_is_brought_into_it(view):
    view.show_team(POSES + [50.0, 0.0, 0.0])
    assert everything_in_view(view, POSES[:, :2] + [50.0, 0.0])


@pytest.mark.parametrize(
    "place, text",
    [
        ((4.0, 0.0), "Robot 2: x = 4.000 m, y = 0.000 m, \u03b8 = 90.0\u00b0"),
        ((2.0, 0.0), "Robot 1 receives from robot 2, weight a(1, 2) = 0.5"),
        ((2.0, 2.5), ""),
    ],
)
def test_tooltips_tell_poses_and_weights(view, place, text):
    view.show_topology([(1, 2, 0.5)], True)
    where = at(view, *place)
    QApplication.sendEvent(view, QHelpEvent(QEvent.ToolTip, where, view.mapToGlobal(where)))
    assert QToolTip.text() == text
    QToolTip.hideText()


def test_an_untouched_view_fits_after_a_change_of_size(view, app):
    view.resize(400, 300)
    app.processEvents()
    assert everything_in_view(view, POSES[:, :2])
    view.resize(1, 1)
    app.processEvents()
    view.grab()


def test_a_click_names_the_robot_and_a_drag_does_not(view):
    clicked = emitted(view.robot_clicked)
    click(view, at(view, 4.0, 3.0))
    click(view, at(view, 2.0, 2.0))
    drag(view, at(view, 4.0, 3.0), at(view, 3.0, 2.0))
    assert clicked == [(3,), (0,)]  # of the floor: none
    for mode in ("poses", "edges"):
        view.set_mode(mode)
        click(view, at(view, 4.0, 3.0))
    assert clicked == [(3,), (0,)]


# Poses


def test_a_dragged_robot_moves_and_says_so(view):
    view.set_mode("poses")
    edited = emitted(view.pose_edited)
    begin = at(view, 4.1, 0.05)
    drag(view, begin, begin + QPoint(-90, 40))
    shift = np.array([-90.0, -40.0]) / view.frame.scale
    number, *pose = edited[-1]
    assert len(edited) == 3 and {call[0] for call in edited} == {2} == {number}
    assert pose == pytest.approx([*(POSES[1, :2] + shift), np.pi / 2])
    # It is where it was put: there it can be taken again.
    drag(view, at(view, *pose[:2]), at(view, 2.0, 2.0))
    assert edited[-1][0] == 2 and edited[-1][1:3] == pytest.approx((2.0, 2.0), abs=0.02)


@pytest.mark.parametrize(
    "modifier, button", [(Qt.ShiftModifier, Qt.LeftButton), (NONE, Qt.RightButton)]
)
def test_a_robot_is_turned_to_face_the_cursor(view, modifier, button):
    view.set_mode("poses")
    edited = emitted(view.pose_edited)
    drag(view, at(view, 4.0, 0.0), at(view, 2.0, 2.0), modifier, button)
    assert edited[-1][0] == 2
    assert edited[-1][1:] == pytest.approx((4.0, 0.0, np.radians(135.0)), abs=0.02)


def test_robots_stay_where_they_are_in_other_modes(view):
    edited = emitted(view.pose_edited)
    for mode in ("look", "edges"):
        view.set_mode(mode)
        drag(view, at(view, 0.0, 0.0), at(view, 1.0, 1.0))
    view.set_mode("poses")
    click(view, at(view, 0.0, 0.0))
    drag(view, at(view, 2.0, 1.5), at(view, 3.0, 1.5))
    assert edited == []


def test_the_owner_may_answer_an_edit_with_the_team(view):
    view.set_mode("poses")
    poses = POSES.copy()

    def answer(number, x, y, theta):
        poses[number - 1] = x, y, theta
        view.show_team(poses)

    view.pose_edited.connect(answer)
    drag(view, at(view, 0.0, 0.0), at(view, 1.0, 2.0))
    assert poses[0] == pytest.approx([1.0, 2.0, 0.0], abs=0.02)
    np.testing.assert_array_equal(poses[1:], POSES[1:])


def test_a_team_that_changes_under_a_drag_ends_it(view):
    view.set_mode("poses")
    edited = emitted(view.pose_edited)
    QTest.mousePress(view, Qt.LeftButton, NONE, at(view, 4.0, 3.0))
    view.show_team(POSES[:1])
    move(view, QPoint(300, 300))
    QTest.mouseRelease(view, Qt.LeftButton, NONE, QPoint(300, 300))
    assert edited == []


def test_overlapping_robots_are_outlined_in_red(view):
    assert view.team.overlapping == set()
    view.set_mode("poses")
    drag(view, at(view, 0.0, 0.0), at(view, 4.0, 0.4))
    assert view.team.overlapping == {1, 2}
    corner = view.team.pose[0, 0] + 0.21, 0.4 - 0.2125  # of robot 1, in front at its right
    assert shade(view, *corner) == QColor(marks.ALARM)
    drag(view, at(view, 4.1, 0.55), at(view, 0.0, 0.0))
    assert view.team.overlapping == set()


def test_robots_of_unknown_pose_are_left_out(view):
    poses = POSES.copy()
    poses[1] = np.nan
    view.show_team(poses)
    view.show_topology([(1, 2, 1.0), (2, 3, 1.0), (3, 1, 1.0)], True)
    view.show_snapshot(snapshot(0.0, poses))
    view.show_snapshot(snapshot(1.0, POSES))
    assert view.trails.count.tolist() == [1, 1, 1]
    view.show_snapshot(snapshot(2.0, poses))
    view.fit()
    assert view.team.overlapping == set() and np.isfinite(view.frame.bounds()).all()
    clicked = emitted(view.robot_clicked)
    click(view, at(view, 4.0, 3.0))
    assert clicked == [(3,)]


# Edges


def test_an_edge_is_dragged_as_it_is_drawn_to_the_robot_that_receives(view):
    view.set_mode("edges")
    added = emitted(view.edge_added)
    drag(view, at(view, 4.0, 3.0), at(view, 0.0, 0.0))
    assert added == [(1, 3)]
    view.show_topology(added, True)
    (begin,), (end,) = view.edges.segments(
        view.team.numbers, view.team.pose, view.frame, 1.0, view.team.shapes
    )[0][2:]
    assert np.hypot(*(end - view.to_screen(0.0, 0.0))) < np.hypot(*(begin - view.to_screen(0, 0)))


def test_the_edge_that_is_drawn_says_who_receives_from_whom(view):
    view.show_topology([], True)
    assert view.edge_text(2, 0) == "robot 1 receives from robot 3"
    assert view.edge_text(2, -1) == "... receives from robot 3"
    view.show_topology([], False)
    assert view.edge_text(2, 0) == "robot 3 and robot 1 are neighbours"


def test_a_rubber_band_is_seen_while_drawing_and_escape_ends_it(view):
    view.set_mode("edges")
    added, before = emitted(view.edge_added), drawn(view)
    QTest.mousePress(view, Qt.LeftButton, NONE, at(view, 0.0, 0.0))
    move(view, at(view, 2.0, 2.5))
    assert (drawn(view) != before).any()
    QTest.keyClick(view, Qt.Key_Escape)
    assert (drawn(view) == before).all()
    QTest.mouseRelease(view, Qt.LeftButton, NONE, at(view, 4.0, 3.0))
    assert added == []


def test_no_edge_to_itself_to_the_ground_or_twice(view):
    view.set_mode("edges")
    added = emitted(view.edge_added)
    drag(view, at(view, 0.0, 0.0), at(view, 0.05, 0.05))
    drag(view, at(view, 0.0, 0.0), at(view, 2.0, 2.0))
    view.show_topology([(2, 1, 1.0)], True)
    drag(view, at(view, 0.0, 0.0), at(view, 4.0, 0.0))
    assert added == []
    drag(view, at(view, 4.0, 0.0), at(view, 0.0, 0.0))
    assert added == [(1, 2)]
    view.show_topology([(1, 2, 1.0)], False)
    drag(view, at(view, 4.0, 0.0), at(view, 0.0, 0.0))
    assert added == [(1, 2)]


def test_a_click_on_an_edge_removes_it_and_only_with_the_mode(view):
    removed = emitted(view.edge_removed)
    view.show_topology([(1, 2, 1.0), (3, 2, 0.5)], True)
    click(view, at(view, 2.0, 0.0))
    view.set_mode("edges")
    click(view, at(view, 2.0, 1.0))
    click(view, at(view, 0.0, 0.0))
    assert removed == []
    click(view, at(view, 4.0, 1.5))
    click(view, at(view, 2.0, 0.0))
    assert removed == [(3, 2), (1, 2)]
    view.set_shown("edges", False)
    click(view, at(view, 2.0, 0.0))
    assert len(removed) == 2


def test_of_two_opposite_edges_that_with_its_head_near_is_removed(view):
    view.show_topology([(1, 2, 1.0), (2, 1, 1.0)], True)
    view.set_mode("edges")
    removed = emitted(view.edge_removed)
    click(view, at(view, 1.0, 0.0))
    click(view, at(view, 3.0, 0.0))
    assert removed == [(1, 2), (2, 1)]


def test_heads_point_at_the_robot_that_receives_and_are_wider_than_the_line(view):
    view.set_shown("numbers", False)
    pixel = 1.0 / view.frame.scale
    beside = POSES[0, 0] + 0.21 + 10.0 * pixel, 2.5 * pixel  # of the line, near robot 1
    view.show_topology([(1, 2, 1.0)], False)
    ground = shade(view, *beside)
    view.show_topology([(2, 1, 1.0)], True)
    assert shade(view, *beside) == ground
    view.show_topology([(1, 2, 1.0)], True)
    assert shade(view, *beside) != ground


def test_edges_of_robots_that_are_not_there_are_left_out(view):
    view.show_topology([(1, 9, 1.0), (7, 2, 1.0), (1, 3)], True)
    view.set_mode("edges")
    removed = emitted(view.edge_removed)
    click(view, at(view, 2.0, 1.5))
    assert removed == [(1, 3)]


# A run


@pytest.mark.parametrize("step, points", [(0.029, 2), (0.031, 3)])
def test_a_trail_gets_a_point_only_after_three_centimetres(view, step, points):
    for count in range(3):
        view.show_snapshot(snapshot(float(count), POSES + [count * step, 0.0, 0.0]))
    assert view.trails.count.tolist() == [points] * 3


def test_trails_are_bounded_and_keep_beginning_and_end():
    trails = map_trails.Trails(2)
    for count in range(10000):
        trails.add(np.array([[0.04 * count, 0.0], [0.0, 1.0]]), np.zeros(2))
        assert trails.count[0] <= map_trails.TRAIL_POINTS
    path = trails.path(0)
    assert trails.count[1] == 1 and trails.count[0] > 0.4 * map_trails.TRAIL_POINTS
    assert path[0].tolist() == [0.0, 0.0] and path[-1, 0] > 399.5
    apart = np.diff(path[:, 0])
    assert apart.max() < 1.5 * apart.min()  # the whole path is sampled evenly
    assert trails.bounds().max(axis=0).tolist() == [path[-1, 0], 1.0]


def test_trails_end_with_clear_another_team_an_earlier_time_or_a_new_start(view):
    def run(*times):
        for time in times:
            view.show_snapshot(snapshot(time, view.team.pose + [1.0, 0.0, 0.0]))
        return view.trails.count.max()

    assert run(0.0, 1.0, 2.0) == 3
    view.clear_trails()
    assert view.trails.count.max() == 0
    assert run(0.0, 1.0) == 2
    assert run(0.5) == 1
    view.show_team(view.team.pose)
    assert run(3.0) == 2
    view.show_team(POSES)
    assert run(4.0) == 1
    view.show_snapshot(snapshot(5.0, POSES[:2]))
    assert view.trails.count.tolist() == [1, 1]


def test_toggles_hide_what_they_name_and_show_it_again(view):
    view.show_snapshot(snapshot(0.0, POSES))
    view.show_snapshot(snapshot(1.0, POSES + [0.0, 1.5, 0.0]))
    view.show_targets(POSES[:, :2] + [1.0, 0.0])
    view.show_topology([(1, 2, 1.0)], True)
    whole = drawn(view)
    layers = ("trails", "targets", "edges", "numbers")
    toggles = [partial(view.set_shown, layer) for layer in layers]
    toggles.append(partial(view.set_trail_shown, 2))
    for toggle in toggles:
        toggle(False)
        assert (drawn(view) != whole).any()
        toggle(True)
        assert (drawn(view) == whole).all()


def test_signs_out_of_view_leave_the_picture_as_it_is(view, no_hidden_errors):
    view.set_shown("legend", False)
    view.show_team(POSES)
    before = drawn(view)
    view.show_targets(POSES[:, :2] + 1e6)
    view.show_topology([])
    assert (drawn(view) == before).all()


def test_starts_are_red_dots(view):
    view.show_snapshot(snapshot(0.0, POSES))
    view.show_snapshot(snapshot(1.0, POSES + [0.0, 1.5, 0.0]))
    assert shade(view, 0.0, 0.0) == QColor("#d60000")


def test_robots_have_their_colours_and_stale_ones_have_not(view):
    place = -0.15, 0.0
    assert shade(view, *place) == QColor("#0072b2")
    view.show_snapshot(snapshot(0.0, POSES, [False, True, True]))
    red, green, blue, _ = shade(view, *place).getRgb()
    assert red == green == blue


def test_the_selected_robot_is_highlighted_and_unknown_ones_are_not(view):
    before = drawn(view)
    view.select(2)
    assert (drawn(view) != before).any()
    for number in (99, 0):
        view.select(number)
        assert (drawn(view) == before).all()


def test_a_collision_flashes_and_fades(view, monkeypatch):
    now = [100.0]
    monkeypatch.setattr("mrs_simulator.rqt_plugin.map.flashes.time.monotonic", lambda: now[0])
    before = drawn(view)
    view.flashes.add(2.0, 1.5)
    assert (drawn(view) != before).any() and view.flashes.is_active
    now[0] += 2.01
    view.flashes.fade()
    assert (drawn(view) == before).all() and not view.flashes.is_active


def test_obstacles_are_drawn_to_scale(view):
    inside = ((2.0, 1.5), (2.0, 1.95), (2.15, 1.5), (1.0, 3.25), (0.8, 3.2))
    outside = ((2.35, 1.5), (2.0, 2.1), (1.28, 3.28))
    empty = [shade(view, *place) for place in inside + outside]
    view.show_obstacles(
        [Box("box", 2.0, 1.5, np.pi / 2, 1.0, 0.4, 1.0), Cylinder("post", 1.0, 3.0, 0.3, 1.0)]
    )
    covered = [shade(view, *place) != ground for place, ground in zip(inside + outside, empty)]
    assert covered == [True] * len(inside) + [False] * len(outside)


def test_an_obstacle_on_a_track_is_drawn_where_it_is_then(view):
    box = Box("cart", 0.5, 1.5, 0.0, 0.6, 0.6, 1.0, Track(((3.5, 1.5),), 1.0))
    places = (0.5, 1.45), (2.5, 1.45)
    empty = [shade(view, *place) for place in places]

    def covered():
        return [shade(view, *place) != ground for place, ground in zip(places, empty)]

    view.show_obstacles([box])
    assert covered() == [True, False]
    view.show_snapshot(snapshot(CLOCK_START + 2.0, POSES))
    assert covered() == [False, True] and view.scene().obstacles[0].x == 2.5
    view.show_obstacles([box], 1)
    assert view.editor.own == (box,)


def test_land_is_lighter_than_an_obstacle(view):
    on, off = (1.4, 1.7), (3.4, 1.7)  # beside the grid's lines
    empty = shade(view, *on)
    shades = []
    for height in (0.0, 1.0):
        view.show_obstacles([Box("box", 1.5, 1.5, 0.0, 2.0, 2.0, height)])
        assert shade(view, *off) == empty
        shades.append(shade(view, *on))
    ground, land, box = (colour.lightness() for colour in (empty, *shades))
    assert ground > land > box


def test_fit_brings_near_obstacles_into_view_and_leaves_the_team_its_scale(view):
    view.fit()
    scale = view.frame.scale
    land = Box("land", 0.0, 0.0, 0.0, 1000.0, 9.0, 0.0)
    view.show_obstacles([Cylinder("far", 300.0, 0.0, 1.0, 1.0), land])
    view.fit()
    assert view.frame.scale == scale
    view.show_obstacles([Box("wall", 0.0, 9.0, 0.0, 20.0, 0.2, 1.0)])
    view.fit()
    assert everything_in_view(view, np.array([[-9.0, 9.0], [9.0, 9.0]]))
    assert everything_in_view(view, POSES[:, :2])


def test_the_first_view_of_a_scenario_holds_all_obstacles(view):
    view.show_obstacles([Cylinder("far", 70.0, -40.0, 1.0, 1.0)])
    view.fit(whole=True)
    view.resize(700, 500)
    view.grab()
    assert everything_in_view(view, np.vstack([POSES[:, :2], [[71.0, -41.0]]]))
    view.fit()
    assert not everything_in_view(view, np.array([[70.0, -40.0]]))


def test_a_team_of_7_3_and_100_and_back(view):
    for n in (7, 3, 100, 1, 300, 2):
        poses = team(n)
        view.show_team(poses)
        view.show_topology([(i, i + 1, 0.5 * i) for i in range(1, n)], n % 2 == 0)
        view.show_targets(poses[:, :2])
        view.select(n)
        assert everything_in_view(view, poses[:, :2])
        for time in (0.0, 1.0):
            view.show_snapshot(snapshot(time, poses + [time, 0.0, 0.0], np.arange(n) % 2 == 0))
        view.grab()
    view.show_team(np.empty((0, 3)))
    view.fit()
    click(view, QPoint(300, 300))


def test_robots_keep_their_own_numbers(view):
    view.show_snapshot(snapshot(0.0, POSES, numbers=(2, 5, 8)))
    view.show_topology([(2, 8, 1.0)], True)
    clicked, removed = emitted(view.robot_clicked), emitted(view.edge_removed)
    click(view, at(view, 4.0, 0.0))
    view.set_mode("edges")
    click(view, at(view, 2.0, 1.5))
    assert (clicked, removed) == ([(5,)], [(2, 8)])


def test_very_many_edges_are_drawn_in_part_and_it_says_so(view):
    n = 150
    view.show_team(team(n))
    view.show_topology([(i, j, 1.0) for i in range(1, n + 1) for j in range(1, i)], False)
    view.grab()
    style = view.team.numbers, view.team.pose, view.frame, 1.0, view.team.shapes
    segments, stride = view.edges.segments(*style, 40000)
    assert stride == 1 and len(segments.place) > edge_drawing.MOST_EDGES
    assert view.edges.segments(*style, 1000)[1] == 11


@pytest.mark.parametrize("base, text", [("#ffffff", "#000000"), ("#1e1e22", "#e8e8e8")])
def test_colours_follow_the_palette(view, base, text):
    palette = QPalette()
    palette.setColor(QPalette.Base, QColor(base))
    palette.setColor(QPalette.Text, QColor(text))
    view.setPalette(palette)
    assert QColor(view.grab().toImage().pixel(2, 2)) == QColor(base)


@pytest.mark.parametrize("least, step", [(0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (21, 50), (0.06, 0.1)])
def test_grid_steps_are_1_2_5(least, step):
    assert frame.nice_step(least) == pytest.approx(step)


def test_a_mode_that_is_none_is_refused(view):
    with pytest.raises(ValueError, match="fly.*look, poses, edges"):
        view.set_mode("fly")
    assert view.mode == "look"


# Speed: what is painted once


def test_the_ground_is_painted_once_until_the_view_or_what_lies_there_changes(view, monkeypatch):
    painted = []
    paint = map_ground._draw_ground
    monkeypatch.setattr(
        map_ground, "_draw_ground", lambda *those: painted.append(1) or paint(*those)
    )
    for count in range(10):
        view.show_snapshot(snapshot(float(count), POSES + [0.01 * count, 0.0, 0.0]))
        view.grab()
    assert len(painted) == 1
    for change in (
        lambda: wheel(view, QPoint(300, 300), 1),
        lambda: view.show_obstacles([Cylinder("post", 1.0, 3.0, 0.3, 1.0)]),
        lambda: view.set_trail_shown(2, False),
        view.clear_trails,
        lambda: view.resize(700, 500),
    ):
        before = len(painted)
        change()
        view.grab()
        assert len(painted) == before + 1


@pytest.mark.parametrize("n, samples", [(3, 1), (150, 1), (3, 29)])
def test_trails_continued_bit_by_bit_are_those_painted_at_once(view, n, samples):
    """In a fast run robots pass many ``samples`` from one picture to the next."""
    start = team(n)
    view.show_team(start + [0.0, 2.0, 0.0])
    view.show_team(start)
    # There are no robots, targets or edges over the trails.
    for layer in ("numbers", "targets", "edges"):
        view.set_shown(layer, False)
    history = History()
    for count in range(60):
        wave = [0.03 * count, 0.5 * np.sin(0.1 * count), 0.0]
        newest = snapshot(float(count), start + wave)
        history.append(newest)
        if count % samples == 0:
            rows = slice(max(0, count + 1 - samples), count)
            view.show_snapshot(newest, history.kept(rows).state if count else None)
            view.grab()
    bits = drawn(view)
    view.set_shown("trails", False)
    none = drawn(view)
    view.set_shown("trails", True)
    whole = drawn(view)
    inked, wanted = ((picture != none).reshape(-1, 4).any(axis=1) for picture in (bits, whole))
    assert wanted.sum() > 500
    assert (inked & wanted).sum() > 0.85 * wanted.sum()
    assert inked.sum() < 1.2 * wanted.sum()


def test_a_continued_trail_begins_anew_with_the_trails(view):
    view.set_shown("legend", False)
    view.show_snapshot(snapshot(0.0, POSES))
    view.grab()
    view.show_snapshot(snapshot(1.0, POSES + [0.0, 1.0, 0.0]))
    with_trail = drawn(view)
    view.clear_trails()
    view.show_snapshot(snapshot(2.0, POSES + [0.0, 1.0, 0.0]))
    assert (drawn(view) != with_trail).any()
    view.set_shown("trails", False)
    none = drawn(view)
    view.set_shown("trails", True)
    changed = (drawn(view) != none).reshape(-1, 4).any(axis=1).sum()
    assert changed < 200  # [px] starts that the robots stand on


def test_robots_of_a_large_team_have_their_colours_too(view):
    poses = team(40)
    poses[:, 2] = 0.0
    view.show_team(poses)
    fresh = np.arange(40) != 5
    view.show_snapshot(snapshot(0.0, poses, fresh))
    view.set_shown("numbers", False)
    view.set_shown("trails", False)
    for row in (0, 1, 33):
        x, y, _ = poses[row]
        wanted = team_shade(row + 1, 40, QColor("white"))
        assert shade(view, x - 0.1, y) == wanted
    red, green, blue, _ = shade(view, *(poses[5, :2] - [0.1, 0.0])).getRgb()
    assert red == green == blue


def test_a_sprite_is_kept_until_its_kind_changes(app):
    sprites, painted = Sprites(), []
    canvas = QPixmap(100, 100)
    canvas.fill(QColor("white"))
    painter = QPainter(canvas)

    def paint(brush, key):
        painted.append(key)
        brush.fillRect(-2, -2, 4, 4, QColor("red"))

    places = np.array([[20.0, 30.0], [60.2, 30.0]])
    for style in ("a", "a", "b"):
        sprites.put(painter, style, 3.0, places, [7, 7], paint)
    painter.end()
    assert painted == [7, 7]
    image = canvas.toImage()
    red = [(x, y) for x in range(100) for y in range(100) if image.pixelColor(x, y).green() < 99]
    assert red == [(x, y) for x in [*range(18, 22), *range(58, 62)] for y in range(28, 32)]


def test_numbers_that_would_cover_another_are_left_out():
    places = np.array([[0.0, 0.0], [9.0, 0.0], [11.0, 0.0], [9.0, 6.0], [-9.0, -4.9]])
    assert geometry.apart(places, 10.0, 5.0) == [0, 2, 3]


# Kinds, legend, many robots


def test_each_robot_is_drawn_and_found_as_its_kind_is(view):
    kinds = [kind(name) for name in ("husky", "robotino3", "f1tenth")]
    view.show_topology([], True)
    poses = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
    view.show_team(poses)
    view.show_kinds(kinds)
    view.set_shown("numbers", False)
    ground = shade(view, 1.13, 1.17)

    def is_body(x, y):
        return shade(view, x, y) != ground

    # A Husky's bumper, nothing beside it, and a wheel.
    assert is_body(0.48, 0.0) and not is_body(0.48, 0.3) and is_body(0.3, 0.3)
    assert is_body(2.2, 0.05) and is_body(2.05, 0.2) and not is_body(2.2, 0.2)  # a disc has none
    assert (
        is_body(4.43, 0.1) and is_body(3.97, 0.12) and not is_body(3.92, 0.12)
    )  # ahead of its axle
    rows = [view.robot_at(np.array(view.to_screen(x, y))) for x, y in ((0.47, 0.3), (4.44, 0.1))]
    assert rows == [0, 2]
    view.show_team(np.array([[0.0, 0.0, 0.0], [0.9, 0.0, 0.0], [4.0, 0.0, 0.0]]))
    assert view.team.overlapping == set()
    view.show_team(np.array([[0.0, 0.0, 0.0], [0.7, 0.0, 0.0], [4.0, 0.0, 0.0]]))
    assert view.team.overlapping == {1, 2}  # as their own bodies do
    view.show_team(np.zeros((2, 3)))
    assert len(view.team.shapes.which) == 2  # of another team than the kinds are of


def test_sprites_of_many_robots_are_of_their_own_kinds(view):
    poses = team(40)
    poses[:, 2] = 0.0
    kinds = [kind("epuck" if row % 2 else "husky") for row in range(40)]
    view.show_team(poses)
    view.show_kinds(kinds)
    view.set_shown("numbers", False)
    view.set_shown("trails", False)
    wanted = [team_shade(row + 1, 40, QColor("white")) for row in (2, 3)]
    assert shade(view, poses[2, 0] - 0.35, poses[2, 1]) == wanted[0]
    assert shade(view, poses[3, 0] - 0.35, poses[3, 1]) != wanted[1]


@pytest.mark.parametrize("scale", [3.0, 10.0, 30.0, 33.0, 47.0, 90.0, 400.0])
def test_each_axis_has_some_ticks_however_low_the_map_is(view, scale):
    view.resize(900, 19 * view.fontMetrics().height())
    view.frame.scale = scale
    style = MapStyle.of(view)
    step, ticks = axes._ticks(view.frame, style, view.fontMetrics())
    assert min(map(len, ticks)) >= 3
    labels = [axes._label(tick * step, axes._digits(step)) for tick in ticks[0]]
    widest = max(map(view.fontMetrics().horizontalAdvance, labels))
    assert widest + 0.3 * style.line < step * scale


def test_the_legend_explains_the_visible_signs(view):
    assert view.legend() == set()
    view.show_topology([(1, 2)], True)
    view.show_targets(POSES[:, :2])
    assert view.legend() == {"directed edge", "target"}
    fresh = np.array([True] * (len(POSES) - 1) + [False])
    view.show_snapshot(snapshot(0.0, POSES, fresh).replace(real=np.arange(len(POSES)) == 0))
    assert view.legend() == {"directed edge", "target", "start", "trail", "real", "stale"}
    shown = drawn(view)
    view.set_shown("legend", False)
    assert (drawn(view) != shown).any()
    view.resize(220, 200)  # no room for words
    without = drawn(view)
    view.set_shown("legend", True)
    assert (drawn(view) == without).all()


def test_rings_of_collisions_do_not_bury_many_robots(view):
    def inked(n):
        view.show_team(team(n))
        before = drawn(view)
        view.flashes.add(*team(n)[n // 2, :2])
        return (drawn(view) != before).reshape(-1, 4).any(axis=1).sum()

    assert inked(200) < 0.35 * inked(9)


def test_heights_of_robots_in_the_air_are_shown_by_number_and_shadow(view, app):
    view.set_shown("legend", False)
    ground, middle = view.grab().toImage(), at(view, *POSES[0, :2])
    view.show_team(POSES, np.array([4.0, 0.0, 1.0]))
    assert view.grab().toImage() != ground
    QApplication.sendEvent(view, QHelpEvent(QEvent.ToolTip, middle, view.mapToGlobal(middle)))
    assert "z = 4.000 m" in QToolTip.text()
    QToolTip.hideText()
    assert "aloft" in view.legend()
    spatial = upright(POSES[:, 2], [0.0, 0.0, 0.0])
    view.show_snapshot(snapshot(0.0, POSES).replace(spatial=spatial))
    assert "aloft" not in view.legend()


def test_a_robot_dragged_in_the_air_keeps_its_height(view):
    view.show_team(POSES, np.array([4.0, 0.0, 1.0]))
    view.set_mode("poses")
    edited = emitted(view.pose_edited)
    begin = at(view, *POSES[0, :2])
    drag(view, begin, begin + QPoint(60, -30))
    assert {call[0] for call in edited} == {1} and view.team.state.z.tolist() == [4.0, 0.0, 1.0]


def test_robots_above_each_other_do_not_overlap(view):
    view.show_team(np.zeros((2, 3)), np.array([0.0, 3.0]))
    assert view.team.overlapping == set()
    view.show_team(np.zeros((2, 3)))
    assert view.team.overlapping == {1, 2}


@pytest.mark.parametrize(
    "z, text", [(0.054, "0.05 m"), (0.996, "1.0 m"), (9.94, "9.9 m"), (12.4, "12 m")]
)
def test_heights_are_written_in_few_digits(z, text):
    assert height_text(z) == text


def carried_snapshot(world):
    """Return the ``Snapshot`` of a ``world`` as the GUI takes it from the stage."""
    message = team_state(world, rospy.Time(1), "world", (1, 0))
    return _from_state(message, True)


def test_arms_and_their_load_are_drawn_and_saved(view, app):
    given = load_scenario(scenario_path("carrying.yaml"))
    world = World.from_scenario(given)
    view.show_team(given.poses)
    view.show_kinds(world.team.kinds)
    view.set_shown("targets", False)
    app.processEvents()

    def like(colour):
        picture = view.grab().toImage()
        return sum(
            abs(picture.pixelColor(x, y).red() - colour[0]) < 12
            and abs(picture.pixelColor(x, y).blue() - colour[1]) < 12
            for x in range(0, picture.width(), 4)
            for y in range(0, picture.height(), 4)
        )

    wood = 255 - 0.55 * 255 * (1 - 0.76), 255 - 0.55 * 255 * (1 - 0.36)
    before = like(wood)
    snapshot = carried_snapshot(world)
    view.show_snapshot(snapshot)
    assert view.scene().carried is None  # no load reported
    view.show_load(given.load)
    app.processEvents()
    assert like(wood) > before + 20
    load, carried = view.scene().carried
    assert load is given.load and all(map(np.array_equal, carried, snapshot.load))
    history = History()
    history.append(snapshot)
    kept = history.state.load
    for mine, theirs in zip(kept, snapshot.load):
        np.testing.assert_array_equal(mine[0], theirs)
    np.testing.assert_array_equal(history.state.joints[0], snapshot.joints)


def test_heights_cover_no_numbers(view, monkeypatch):
    put = []
    original = Sprites.put

    def recorded(self, painter, kind, half, places, keys, paint):
        put.append((self, np.array(places), list(keys)))
        original(self, painter, kind, half, places, keys, paint)

    monkeypatch.setattr(Sprites, "put", recorded)
    poses = np.zeros((2, 3))
    poses[1, 1] = -0.55
    drones = [kind("ardrone2")] * 2
    for gap in np.linspace(0.3, 2.0, 18):
        poses[1, 1] = -gap
        view.show_kinds(drones)
        view.show_team(poses, np.array([1.0, 2.0]))
        put.clear()
        view.repaint()
        texts = {key: place for _, places, keys in put for place, key in zip(places, keys)}
        assert {1, 2, "2.0 m"} <= set(texts)
        if "1.0 m" in texts:
            across, down = np.abs(texts["1.0 m"] - texts[2])
            assert down >= 0.7 * view.fontMetrics().height() or across >= 10
    assert "1.0 m" in texts


@pytest.mark.parametrize("count", [7, 8, 12, 20, 100])
def test_trails_of_robots_of_one_colour_differ_in_their_dashes(count):
    numbers = np.arange(1, count + 1)
    looks = list(zip(colours.places(numbers, count), colours.dash_places(numbers, count)))
    if count <= 12:
        assert len(set(looks)) == count
    assert all(looks[row][1] != looks[row - 1][1] for row in range(1, count) if count > 12)
    if count <= 7:
        assert set(colours.dash_places(numbers, count)) == {0}


def test_the_dashes_of_trails_are_those_of_their_robots(view, monkeypatch):
    drawn = {}
    original = map_ground.TrailPainter._pen

    def recorded(self, row):
        pen = drawn[row] = original(self, row)
        return pen

    monkeypatch.setattr(map_ground.TrailPainter, "_pen", recorded)
    poses = team(20)
    for step in range(6):
        view.show_snapshot(snapshot(0.1 * step, poses + (0.2 * step, 0.0, 0.0)))
        view.repaint()
    dashes = [tuple(drawn[row].dashPattern()) for row in range(20)]
    assert set(dashes) == set(map_ground.DASHES) and dashes[0] != dashes[1] == dashes[5]
