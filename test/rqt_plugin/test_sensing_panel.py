"""Sensors in the GUI: on the map and in their panel, listened to only while somebody looks."""

import math
import os
from types import SimpleNamespace

import numpy as np
import pytest
import rospy

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import gui, quiet_study  # noqa: F401, a fixture
from PyQt5.QtGui import QColor
from sensor_msgs.msg import PointCloud
from snapshots import snapshot_of
from std_msgs.msg import Float64, Header, Int8

from mrs_simulator.ros.message_forms.sensor_messages import forms_of
from mrs_simulator.rqt_plugin.map.legend import LEGEND
from mrs_simulator.rqt_plugin.map.recent_poses import RecentPoses
from mrs_simulator.rqt_plugin.map.sensor_drawing import MOST_ROBOTS, in_plane
from mrs_simulator.rqt_plugin.ros_side import sensors as sensors_module
from mrs_simulator.rqt_plugin.ros_side.diagnostics import Part
from mrs_simulator.rqt_plugin.ros_side.sensors import topic_in
from mrs_simulator.rqt_plugin.sensing.panel import SensorsPanel
from mrs_simulator.rqt_plugin.sensing.picture import NEAR_TO_FAR, UNKNOWN, round_end
from mrs_simulator.rqt_plugin.sensing.readings import ReceivedReading, mounts_of, spare_mounts_of
from mrs_simulator.rqt_plugin.sensing.robot_status import parts_of, status_rows
from mrs_simulator.scenario.incidents import Incident
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.sensors.types.battery import BatteryReading
from mrs_simulator.sensors.types.bumper import BumperReading
from mrs_simulator.sensors.types.camera import CameraReading
from mrs_simulator.sensors.types.inertial import CompassReading, ImuReading
from mrs_simulator.sensors.types.position import GpsReading
from mrs_simulator.sensors.types.range_bearing import RangeBearingReading
from mrs_simulator.sensors.types.ranging import RangeReading

NONE = float("nan")
MORE = {"others": {"type": "range_bearing"}, "bumper": {"type": "bumper", "front": 2, "rear": 2}}


def team_of(n):
    poses = [[4.0 * k, 0.0, 0.0] for k in range(n)]
    return scenario_from_dict({"poses": poses, "sensors": [{"mounts": MORE}]})


@pytest.fixture
def study(app, no_hidden_errors):
    """The GUI of two robots with nothing behind it; what it looks at is in ``watched``."""
    widget = quiet_study(team_of(2))
    widget.watched = {}
    widget.connection.watch_sensors.side_effect = lambda wanted: setattr(
        widget, "watched", set(wanted)
    )
    widget.connection.sensor_readings.return_value = {}
    widget.resize(1366, 768)
    widget.show()
    app.processEvents()
    yield widget
    widget.study.edited.close()
    widget.close()
    widget.deleteLater()
    app.processEvents()


def hear(study, *readings, age=0.01, number=1):
    """Have the connection hear ``(name, reading)`` of a robot, and the GUI show them."""
    received = {
        (number, name): ReceivedReading(each, age, 10.0, "/robot{}/{}".format(number, name))
        for name, each in readings
    }
    study.connection.sensor_readings.return_value = received
    study.sensing.show()


def shade(study, x, y):
    return QColor(study.map.grab().toImage().pixel(*map(round, study.map.to_screen(x, y))))


# Words


@pytest.mark.parametrize(
    "reading, text",
    [
        (
            RangeReading(0.0, np.array([2.0, np.inf, 0.5, NONE]), np.eye(4, 3, 2), 5.0),
            "nearest 0.50 m at 0.0\u00b0, 2 of 4 within 5 m, 1 lost",
        ),
        (RangeReading(0.0, np.array([np.inf]), np.zeros((1, 3)), 5.0), "0 of 1 within 5 m"),
        (
            RangeBearingReading(0.0, np.array([3]), np.array([1.25]), np.array([-np.pi / 2])),
            "robot 3: 1.25 m at \u221290.0\u00b0",
        ),
        (
            BumperReading(0.0, np.array([0, 1], dtype=bool), np.array([1, 0], dtype=bool)),
            "pressed: front 2; rear 1",
        ),
        (BatteryReading(0.0, 12.5, 0.75), "12.50 V, 75 % charged"),
        (BatteryReading(0.0, 12.5, NONE, True), "12.50 V, on the charger"),
        (CompassReading(0.0, np.pi), "heading 180.0\u00b0"),
        (GpsReading(0.0, NONE, NONE, NONE), "no fix"),
        (
            ImuReading(0.0, np.array([0.0, NONE, 9.81]), np.zeros(3)),
            "a = (0.00, \u2013, 9.81) m/s\u00b2, \u03c9 = (0.00, 0.00, 0.00) rad/s",
        ),
    ],
)
def test_a_reading_in_words(reading, text):
    assert reading.text() == text


# What is listened to


def test_nothing_is_listened_to_until_somebody_looks(study):
    study.sensing.show()
    assert not study.shown["sensors"].isChecked() and study.watched == set()
    study.shown["sensors"].setChecked(True)
    study.sensing.show()
    drawn = {(number, name) for number in (1, 2) for name in ("sonar", "others", "bumper")}
    assert study.watched == drawn
    study.shown["sensors"].setChecked(False)
    study.results_tabs.setCurrentWidget(study.sensors)
    study.sensing.show()
    assert study.watched == set()  # no robot is chosen yet
    study.map.robot_clicked.emit(2)
    study.sensing.show()
    # Those that the robot has, and those that its driver may tell besides.
    assert study.watched == {
        (2, each) for each in ("sonar", "others", "bumper", "laser", "battery")
    }
    study.results_tabs.setCurrentIndex(0)
    study.sensing.show()
    assert study.watched == set()


def test_of_a_large_team_the_map_shows_the_robot_chosen_alone(study):
    study.editing.take(team_of(MOST_ROBOTS + 1))
    study.shown["sensors"].setChecked(True)
    study.sensing.show()
    assert study.watched == set()
    study.sensors.robot_chosen.emit(5)
    study.sensing.show()
    assert {number for number, _ in study.watched} == {5} and study.map.selected == 5


def topics(**published):
    """Return what the master says, of topics by type, with ``/robot1/a`` written robot1__a."""
    kinds = {"/" + name.replace("__", "/"): kind for name, kind in published.items()}
    return {topic: ["driver"] for topic in kinds}, kinds


def test_a_sensor_is_found_under_the_names_of_drivers():
    mount, kind = mounts_of(team_of(1))[1, "sonar"]
    form = forms_of(mount, kind)[0]
    cloud = "sensor_msgs/PointCloud"
    published, kinds = topics(robot1__RosAria__sonar=cloud, robot2__sonar=cloud, robot1__x=cloud)
    assert topic_in(1, form, published, {}, kinds) == "/robot1/RosAria/sonar"
    published["/robot1/sonar"], kinds["/robot1/sonar"] = ["stage"], cloud
    assert topic_in(1, form, published, {}, kinds) == "/robot1/sonar"
    received = {"/robot1/RosAria/sonar": ["control"], "/robot1/x": ["control"]}
    assert topic_in(1, form, published, received, kinds, ["control"]) == "/robot1/RosAria/sonar"
    only = {"/robot1/x": ["driver"]}
    assert topic_in(1, form, only, received, kinds, ["control"]) == "/robot1/x"
    assert topic_in(1, form, only, {}, kinds) == ""
    assert topic_in(1, form, {"/robot1/sonar": []}, {}, {"/robot1/sonar": "other/Type"}) == ""


def test_the_first_reading_which_comes_at_once_does_not_count_for_the_rate():
    mount, kind = mounts_of(team_of(1))[1, "sonar"]
    subscription = sensors_module.SensorSubscription(mount, kind)
    for second in (0.3, 1.0, 2.0, 3.0):
        subscription.on_message(
            PointCloud(Header(0, rospy.Time(second), ""), [], []), subscription.form
        )
    assert subscription.newest(3.0).rate == pytest.approx(1.0)


def test_what_several_messages_tell_is_one_reading(monkeypatch):
    monkeypatch.setattr(sensors_module.rospy, "Subscriber", lambda *_, **__: SimpleNamespace())
    (mount, kind) = spare_mounts_of(team_of(1), 1)[1, "battery"]
    subscription = sensors_module.SensorSubscription(mount, kind)
    own = "/robot1/RosAria/battery_"
    kinds = {own + "voltage": "std_msgs/Float64", own + "recharge_state": "std_msgs/Int8"}
    reported = dict.fromkeys(kinds, ["driver"]), {}, kinds, None
    topics = sensors_module.topics_of(1, subscription, reported)
    assert list(topics) == list(kinds)
    kinds["/robot1/battery"] = "sensor_msgs/BatteryState"
    reported[0]["/robot1/battery"] = ["stage"]
    assert list(sensors_module.topics_of(1, subscription, reported)) == ["/robot1/battery"]
    subscription.listen(topics)
    voltage, recharging = topics.values()
    monkeypatch.setattr(sensors_module, "stamp_of", lambda _: rospy.Time(1.0))
    subscription.on_message(Int8(1), recharging)
    assert subscription.newest(None).reading is None
    subscription.on_message(Float64(12.5), voltage)
    reading = subscription.newest(None).reading
    assert (reading.voltage, reading.charging) == (12.5, True) and math.isnan(reading.charge)


# The map


def test_cones_rays_and_robots_seen_lie_where_they_were_sensed(study):
    study.shown["sensors"].setChecked(True)
    study.selection.choose(1)
    study.map.set_shown("legend", False)
    study.map.set_shown("edges", False)
    empty = {place: shade(study, *place) for place in ((1.0, 0.3), (-1.0, 0.3), (1.0, 1.7))}
    one_cone = RangeReading(0.0, np.array([1.5]), np.array([[0.0, 0.0, 0.25]]), 5.0, 0.2)
    hear(study, ("sonar", one_cone))
    changed = {place for place, before in empty.items() if shade(study, *place) != before}
    assert changed == {(1.0, 0.3)}
    fan = RangeReading(0.0, np.full(9, 2.0), np.linspace([0, 0, 1.2], [0, 0, 2.0], 9), 5.0)
    at = 0.9 * np.array([np.cos(1.6), np.sin(1.6)])
    before = shade(study, *at)
    hear(study, ("laser", fan))  # a name that this robot's kind has not fitted
    hear(study, ("sonar", fan))
    assert shade(study, *at) != before
    hear(study, ("sonar", fan), age=9.0)  # stale
    assert study.map.readings == {}


def moved(study, time, x):
    """Show both robots at ``time`` [s], the first of them at ``x`` [m]."""
    pose = np.array([[x, 0.0, 0.0], [8.0, 0.0, 0.0]])
    zeros, fresh = np.zeros((2, 3)), np.ones(2, dtype=bool)
    study.map.show_snapshot(snapshot_of(time, (1, 2), pose, zeros, np.zeros((2, 2)), fresh))


def test_what_was_sensed_stays_where_the_robot_was_then(study):
    study.shown["sensors"].setChecked(True)
    for layer in ("legend", "edges", "trails", "numbers"):
        study.shown[layer].setChecked(False)
    moved(study, 0.0, 0.0)
    moved(study, 1.0, 2.0)
    places = ((1.9, 0.0), (2.9, 0.0), (3.9, 0.0))
    empty = {place: shade(study, *place) for place in places}
    ahead = RangeReading(0.5, np.array([1.0]), np.array([[0.0, 0.0, 0.0]]), 5.0, 0.4)
    hear(study, ("sonar", ahead))  # of 0.5 s, when the robot was at x = 1
    moved(study, 1.1, 2.5)
    assert {place for place in places if shade(study, *place) != empty[place]} == {(1.9, 0.0)}


def test_poses_between_two_that_are_known():
    recent = RecentPoses()
    for time, heading in ((1.0, 3.0), (2.0, -3.0)):
        recent.add(time, np.array([[time, 0.0, heading]]))
    np.testing.assert_allclose(recent.at(0, 1.5)[[0, 2]], [1.5, np.pi])
    assert [recent.at(0, time)[0] for time in (0.0, 1.0, 2.0, 9.0)] == [1.0, 1.0, 2.0, 2.0]
    recent.add(0.5, np.zeros((1, 3)))  # another run
    assert recent.at(0, 1.5)[0] == 0.0


def test_what_others_sense_is_paler_than_what_the_robot_chosen_does(study):
    study.shown["sensors"].setChecked(True)
    for layer in ("legend", "edges"):
        study.shown[layer].setChecked(False)
    cone = RangeReading(0.0, np.array([1.5]), np.array([[0.0, 0.0, 0.0]]), 5.0, 0.3)
    empty = shade(study, 1.0, 0.1).lightness()
    dark = []
    for chosen in (0, 1, 2):
        study.map.select(chosen)
        received = {
            (number, "sonar"): ReceivedReading(cone, 0.0, 10.0, "/topic") for number in (1, 2)
        }
        study.connection.sensor_readings.return_value = received
        study.sensing.show()
        dark.append(empty - shade(study, 1.0, 0.1).lightness())
    assert dark[0] == dark[1] > 2 * dark[2] > 0


def test_the_legend_tells_what_is_drawn_of_sensors(study):
    cone = RangeReading(0.0, np.array([1.5]), np.zeros((1, 3)), 5.0, 0.3)
    touched = BumperReading(0.0, np.array([True]), np.array([False]))
    seen = RangeBearingReading(0.0, np.array([2]), np.ones(1), np.zeros(1))
    study.shown["sensors"].setChecked(True)
    hear(study, ("sonar", cone), ("others", seen), ("bumper", touched))
    assert {"cone", "seen", "pressed"} <= study.map.legend() <= set(LEGEND)
    hear(study, ("sonar", cone._replace(cone=0.0)), ("bumper", touched._replace(front=[False])))
    assert study.map.legend() & {"cone", "rays", "seen", "pressed"} == {"rays"}
    study.shown["sensors"].setChecked(False)
    assert not study.map.legend() & {"rays"}


def test_a_point_of_the_robots_frame_in_the_common_frame():
    place = in_plane(np.array([1.0, 2.0, np.pi / 2]), [[1.0, 0.5]])
    assert place == pytest.approx(np.array([[0.5, 3.0]]))


def test_a_section_of_a_bumper_is_drawn_on_its_own_side(study):
    study.shown["sensors"].setChecked(True)
    study.map.set_shown("legend", False)
    frame = study.map.frame
    frame.scale, frame.centre = 150.0, np.zeros(2)
    study.map.untouched = False
    body = study.map.team.shapes
    ahead = 0.5 * (body.front[0] - body.rear[0])
    radius = 1.1 * body.reach[0]
    places = {
        side: (ahead + radius * np.cos(angle), radius * np.sin(angle))
        for side, angle in (("left", np.pi / 4), ("right", -np.pi / 4), ("behind", 3.0))
    }
    pressed = BumperReading(0.0, np.array([True, False]), np.array([False, False]))
    hear(study, ("bumper", pressed))
    red = {s for s, place in places.items() if shade(study, *place).name() == "#e01b24"}
    assert red == {"left"}


# The panel


def test_the_panel_tells_state_rate_and_age(study):
    study.results_tabs.setCurrentWidget(study.sensors)
    study.sensors.grab()
    note, robots = study.sensors.note, study.sensors.robots
    assert note.isVisible() and note.geometry().left() > robots.geometry().right()
    study.selection.choose(2)
    compass = CompassReading(0.0, 0.5)
    hear(study, ("sonar", compass), number=2)
    table = study.sensors.table

    def row(name):
        rows = {table.text(k, 0): k for k in range(table.rowCount())}
        return [table.text(rows[name], column) for column in range(1, 5)]

    assert row("sonar") == ["heading 28.6\u00b0", "10 of 10 Hz", "0.01 s", "received"]
    assert row("bumper") == ["", "of 10 Hz", "", "not published"]
    hear(study, ("sonar", compass), number=2, age=3.0)
    assert row("sonar")[2:] == ["3.00 s", "stale"]
    study.connection.sensor_readings.return_value = {
        (2, "sonar"): ReceivedReading(
            topic="/robot2/sonar", trouble="8 echoes, but the mount has 16"
        ),
        (2, "bumper"): ReceivedReading(topic="/robot2/bumper_state"),
    }
    study.sensing.show()
    assert row("sonar")[3] == "refused: 8 echoes, but the mount has 16"
    assert row("bumper")[3] == "waiting"


STANDS = snapshot_of(
    0.0,
    (1, 2),
    np.array([[0.0, 0.0, 0.0], [1.0, 2.0, np.pi]]),
    np.array([[0.0, 0.0, 0.0], [0.3, 0.0, -0.1]]),
    np.zeros((2, 2)),
    np.array([False, True]),
)
QUIET = SimpleNamespace(real_silent=(), timed_out=())
RUNS = SimpleNamespace(stopped=(), stale=(), running=True, trouble="")


@pytest.mark.parametrize(
    "robot, stage, control, rows",
    [
        (1, {}, {}, [("motion", "stale"), ("controller", "good")]),
        (2, {}, {}, [("motion", "good"), ("controller", "good")]),
        (3, {}, {}, [("controller", "good")]),
        (2, {"timed_out": (2,)}, {"running": False}, [("stage", "warning"), ("controller", "warning")]),
        (2, {"real_silent": (2,)}, {"stale": (2,)}, [("stage", "error"), ("controller", "error")]),
        (2, {}, {"stopped": (2,)}, [("controller", "error")]),
    ],
)  # fmt: skip
def test_the_status_of_one_robot(robot, stage, control, rows):
    stage = SimpleNamespace(**{**vars(QUIET), **stage})
    control = SimpleNamespace(**{**vars(RUNS), **control})
    reported = status_rows(robot, STANDS, stage, control)
    assert set(rows) <= {(each.name, each.level) for each in reported}
    assert len(reported) == len(rows) + ("motion" not in dict(rows) and robot < 3)


def test_motion_in_words_and_nothing_where_nothing_is_received():
    (motion,) = status_rows(2, STANDS, None, None)
    wanted = "(1.00, 2.00) m, \u03b8 = 180.0\u00b0, v = 0.30 m/s, \u03c9 = \u22120.10 rad/s"
    assert motion.message == wanted and status_rows(1, None, None, None) == []


def part(name, hardware="", level="good"):
    return Part(name, level, "said", (("volts", "12"),), 0.5, hardware)


@pytest.mark.parametrize(
    "name, hardware, is_its",
    [
        ("/robot1/RosAria: battery", "", True),
        ("motors", "robot1", True),
        ("robot1", "", True),
        ("robot11/RosAria", "", False),
        ("myrobot1", "", False),
        ("stage", "stage", False),
    ],
)
def test_which_diagnostics_are_a_robots_own(name, hardware, is_its):
    assert bool(parts_of(1, [part(name, hardware)])) is is_its


def test_the_panel_has_the_robots_own_diagnostics_and_its_motion(study):
    study.results_tabs.setCurrentWidget(study.sensors)
    study.selection.choose(2)
    study.connection.snapshot.return_value = STANDS
    parts = [part("robot2/driver: motors", level="error"), part("robot1/driver"), part("stage")]
    study.connection.diagnostics.return_value = parts
    study.sensing.show()
    table = study.sensors.table
    rows = [[table.text(row, c) for c in (0, 1, 4)] for row in range(table.rowCount())]
    assert ["motion", status_rows(2, STANDS, None, None)[0].message, "good"] in rows
    assert rows[-1] == ["robot2/driver: motors", "said", "error"]
    assert "volts = 12" in table.item(len(rows) - 1, 0).toolTip()
    study.program_control.follow()
    study.connection.watch_diagnostics.assert_called_with(True)


def test_the_picture_of_a_camera_is_shown_in_its_colours(app, study):
    study.results_tabs.setCurrentWidget(study.sensors)
    study.selection.choose(2)
    image = np.zeros((4, 5, 3), dtype=np.uint8)  # a width whose lines are no whole words
    image[:2], image[2:] = (255, 0, 0), (0, 0, 255)
    hear(study, ("sonar", CameraReading(0.0, image, np.zeros((4, 5)), ())), number=2)
    app.processEvents()
    picture = study.sensors.picture
    shot = picture.grab().toImage()
    middle, away = shot.width() // 2, shot.width() * 4 // 5 // 4  # a quarter of the image's height
    places = (shot.height() // 2 + way * away for way in (-1, 1))
    colours = [QColor(shot.pixel(middle, y)).getRgb()[:3] for y in places]
    assert picture.isVisible() and colours == [(255, 0, 0), (0, 0, 255)]
    hear(study, ("sonar", CompassReading(0.0, 0.5)), number=2)
    assert not picture.isVisible()


def test_depth_is_shown_in_colours_with_a_scale_in_metres(app):
    panel = SensorsPanel()
    panel.resize(700, 240)
    scenario = scenario_from_dict(
        {"poses": [[0, 0, 0]], "sensors": [{"mounts": {"eye": {"type": "camera"}}}]}
    )
    (mount,) = [each for each, _ in mounts_of(scenario).values() if each.name == "eye"]
    depth = np.full((4, 5), 0.0)
    depth[:2], depth[3] = 1.6, np.nan
    seen = CameraReading(0.0, np.zeros((4, 5, 3), dtype=np.uint8), depth, ())
    panel.show()
    panel.looks.setCurrentIndex(1)
    assert panel.wants_depth
    panel.show_sensors({"eye": mount}, {}, "", ReceivedReading(seen))
    app.processEvents()
    picture = panel.picture
    assert picture.isVisible() and picture.most == 2.0
    shades = [QColor(picture.image.pixel(2, y)).getRgb()[:3] for y in (0, 2, 3)]
    assert shades == [tuple(NEAR_TO_FAR[204]), tuple(NEAR_TO_FAR[0]), UNKNOWN]
    panel.looks.setCurrentIndex(0)
    panel.show_sensors({"eye": mount}, {"eye": ReceivedReading(seen)})
    assert picture.most is None and panel.looks.isVisible()
    panel.show_sensors({}, {})
    assert not picture.isVisible() and not panel.looks.isVisible()
    panel.close()


@pytest.mark.parametrize(
    "most, end", [(0.3, 0.5), (1.0, 1.0), (1.6, 2.0), (5.1, 10.0), (30.0, 50.0)]
)
def test_scales_end_at_round_numbers(most, end):
    assert round_end(most) == pytest.approx(end)


def test_flight_states_and_incidents_of_the_robot_are_shown(study):
    incidents = [
        Incident(2.5, "robot2", "rotor_lost", 3),
        Incident(2.6, "robot1", "saturated"),
        Incident(2.75, "robot2", "upside_down"),
    ]
    study.connection.take.side_effect = lambda name: incidents if name == "incidents" else []
    study.live.show_frame()
    study.connection.take.side_effect = lambda name: []
    study.results_tabs.setCurrentWidget(study.sensors)
    stage = SimpleNamespace(flight=("hovering", "falling"), real_silent=(), timed_out=())
    study.connection.newest.side_effect = lambda name: stage if name == "stage" else None
    study.connection.is_fresh.side_effect = lambda name: name == "stage"
    study.selection.choose(2)
    study.sensing.show()
    state = study.sensors.state
    assert state.message == (
        "Falling; lost rotor 3 at 2.5 s; is upside down, its motors are cut at 2.8 s"
    )
    study.selection.choose(1)
    study.sensing.show()
    assert state.message == "Hovering; has rotors at their limit at 2.6 s"
    assert "robot2 lost rotor 3 at 2.50 s" in study.messages.toPlainText()
    study.history.clear()
    study.connection.is_fresh.side_effect = lambda name: False
    study.sensing.show()
    assert state.message == "" and not state.isVisible()


def test_only_the_depth_that_is_wanted_is_listened_to(study):
    study.editing.take(scenario_from_dict(
        {"poses": [[0, 0, 0]], "sensors": [{"mounts": {"eye": {"type": "camera"}}}]}
    ))  # fmt: skip
    study.results_tabs.setCurrentWidget(study.sensors)
    study.selection.choose(1)
    study.sensing.show()
    assert (1, "eye") in study.watched and (1, "eye depth") not in study.watched
    study.sensors.looks.setCurrentIndex(1)
    study.sensing.show()
    assert (1, "eye depth") in study.watched


def test_the_panel_says_why_it_is_empty(study):
    study.results_tabs.setCurrentWidget(study.sensors)
    study.sensing.show()
    assert "Choose a robot" in study.sensors.note.text()
    study.editing.take(
        scenario_from_dict({"poses": [[0, 0, 0]], "sensors": [{"mounts": {"sonar": None}}]})
    )
    study.selection.choose(1)
    study.sensing.show()
    assert "has no sensors" in study.sensors.note.text()


# Over ROS


def test_sensors_diagnostics_and_programs_over_ros(gui):  # noqa: F811
    gui("""
gui.selection.choose(1)
gui.results_tabs.setCurrentWidget(gui.sensors)
click("simulate")
table = gui.sensors.table
until(lambda: table.rowCount() and table.text(0, 4) == "received")
assert table.text(0, 0) == "sonar" and " of 16 within 5 m" in table.text(0, 1)
gui.shown["sensors"].setChecked(True)
until(lambda: len(gui.map.readings) == 4)
gui.shown["sensors"].setChecked(False)
gui.results_tabs.setCurrentIndex(0)
until(lambda: gui.connection._sensors.is_idle)
gui.results_tabs.setCurrentWidget(gui.programs)
panel, processes, reported = gui.programs, gui.study.processes, gui.connection.diagnostics
until(lambda: any(part.name == "stage" and part.level == "good" for part in reported()))
first = processes.running["stage"].pid

def press(name, action):
    panel.select(name)
    until(panel.buttons[action].isEnabled)
    panel.buttons[action].click()

press("stage", "restart")
until(lambda: processes.is_running("stage") and processes.running["stage"].pid != first)
until(lambda: gui.connection.is_fresh("stage"))
press("stage", "end")
until(lambda: processes.is_gone("stage"))
assert processes.code("stage") in (0, -2, 130), processes.code("stage")
""")


def test_of_a_recorded_run_motion_is_shown_and_no_sensor_that_is_waited_for(study, app):
    study.results_tabs.setCurrentWidget(study.sensors)
    study.sensors.show_robot(1)
    app.processEvents()
    study.sensing.show()
    now = study.sensors.table.rowCount()
    assert now > 0
    study.map.show_snapshot(STANDS)
    study.opened.run = SimpleNamespace(path="a run")
    study.sensing.show()
    table = study.sensors.table
    assert [table.text(row, 0) for row in range(table.rowCount())] == ["motion"]
    assert "not in a recorded run" in study.sensors.note.message
    study.opened.run = None
    study.sensing.show()
    assert table.rowCount() == now
