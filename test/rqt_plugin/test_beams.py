"""Sensors in the 3D view: rays up to what they met, cones, and what a camera sees."""

import math
import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from PyQt5.QtWidgets import QApplication

from mrs_simulator.pictures.camera import Camera as Eye
from mrs_simulator.pictures.drawing import Lines
from mrs_simulator.pictures.palette import LIGHT
from mrs_simulator.pictures.scene import drawn
from mrs_simulator.pictures.view import View
from mrs_simulator.rqt_plugin.local_side.connection import LocalConnection
from mrs_simulator.rqt_plugin.map.beams import ARC, MOST_RAYS, SEEN, of_camera, of_reading
from mrs_simulator.rqt_plugin.map.view import MapView
from mrs_simulator.rqt_plugin.sensing.readings import ReceivedReading
from mrs_simulator.sensors.mounts import Mount
from mrs_simulator.sensors.types.camera import CameraSettings
from mrs_simulator.sensors.types.ranging import RangeReading

APP = QApplication.instance() or QApplication([])
POSE, SHADE = np.array([1.0, 2.0, 0.5 * np.pi]), (1.0, 0.0, 0.0)


def reading(ranges, cone=0.0):
    ways = np.linspace(-0.5 * np.pi, 0.5 * np.pi, len(ranges))
    places = np.column_stack([np.full(len(ranges), 0.2), np.zeros(len(ranges)), ways])
    return RangeReading(0.0, np.array(ranges, dtype=float), places, 4.0, cone)


def test_rays_end_where_they_met_something_and_at_the_range_of_the_robot_chosen():
    few = of_reading(POSE, 0.3, reading([np.nan, 2.0, np.inf]), SHADE, whole=False)
    assert few.segments[0].tolist() == pytest.approx(np.array([(1, 2.2, 0.3), (1, 4.2, 0.3)]))
    assert (
        few.hits.tolist() == pytest.approx(np.array([(1.0, 4.2, 0.3)])) and len(few.segments) == 1
    )
    whole = of_reading(POSE, 0.3, reading([np.nan, 2.0, np.inf]), SHADE, whole=True)
    assert len(whole.segments) == 2 and len(whole.hits) == 1
    assert whole.segments[1, 1] == pytest.approx((1.0 - 4.0, 2.2, 0.3))  # 4 m to its left
    assert whole.opacity[1] < whole.opacity[0]
    many = of_reading(POSE, 0.3, reading([1.0] * 700), SHADE, whole=False)
    assert MOST_RAYS // 2 < len(many.segments) <= MOST_RAYS and len(many.hits) == 700


def test_a_cone_is_drawn_by_its_sides_and_the_arc_of_its_echo():
    cone = of_reading(POSE, 0.1, reading([np.inf, 2.0, np.inf], 0.2), SHADE, whole=False)
    away = np.linalg.norm(cone.segments.reshape(-1, 3) - (1.0, 2.2, 0.1), axis=1)
    assert len(cone.segments) == ARC + 2 and not len(cone.hits)
    assert sorted(away.round(9).tolist()) == [0.0] * 2 + [2.0] * (2 * ARC + 2)


@pytest.mark.parametrize("down", [0.0, 0.4])
def test_a_camera_sees_a_pyramid_about_its_axis(down):
    view = math.radians(90.0)
    mount = Mount("eye", "camera", (0.1, 0.0, 0.4, 0.0), 5.0, (), None)
    mount = mount._replace(settings=CameraSettings(200, 100, view, down, 0.1, 30.0))
    seen = of_camera(POSE, 1.0, mount, SHADE)
    eye = np.array([1.0, 2.1, 1.4])
    assert len(seen.segments) == 8 and np.allclose(seen.segments[:4, 0], eye)
    corners = seen.segments[:4, 1]
    axis = np.array([0.0, math.cos(down), -math.sin(down)])
    assert np.allclose((corners - eye) @ axis, SEEN)
    assert np.ptp(corners[:, 0]) == pytest.approx(2.0 * SEEN)  # 90 degrees from side to side
    assert corners.mean(axis=0) == pytest.approx(eye + SEEN * axis)


def test_the_3d_view_has_what_the_switch_of_the_map_shows():
    laser = Mount("laser", "laser", (0.2, 0.0, 0.25, 0.0), 10.0, (), None)
    settings = CameraSettings(160, 120, 1.0, 0.0, 0.1, 30.0)
    camera = Mount("eye", "camera", (0.0,) * 4, 5.0, (), settings)
    shown = MapView()
    shown.show_team([POSE, POSE + (2.0, 0.0, 0.0)])
    received = ReceivedReading(reading([1.0, 2.0, 1.5]), 0.0, 10.0, "laser")
    mounts = {(1, "laser"): laser, (2, "laser"): laser, (2, "eye"): camera, (9, "eye"): camera}
    before = shown.revision
    shown.show_readings({(1, "laser"): received}, mounts)
    assert shown.revision > before and not shown.scene().beams
    shown.set_shown("sensors", True)
    of_laser, of_eye = shown.scene().beams
    assert len(of_laser.hits) == 3 and (of_laser.hits[:, 2] == 0.25).all()
    assert of_eye.segments[0, 0] == pytest.approx((3.0, 2.0, 0.0))
    picture = drawn(shown.scene(), Eye(), 300, 200, LIGHT)
    rays = [each for each in picture.layers if isinstance(each, Lines) and len(each.segments) == 11]
    begin = View(Eye(), 300, 200, LIGHT).lines(of_laser.segments, np.ones((3, 4)), 1.0).segments
    assert np.allclose(rays[0].segments[:3], begin)
    shown.show_readings({}, {})
    assert not shown.scene().beams


def test_a_simulation_that_begins_is_asked_for_what_is_watched_already():
    from multiprocessing.connection import Client

    connection = LocalConnection()
    try:
        connection.watch_sensors({(1, "sonar"): (None, None, 1), (3, "laser"): (None, None, 1)})
        with Client(connection.address) as engine:
            assert engine.poll(30.0)
            assert engine.recv() == ("watch", ({0: ["sonar"], 2: ["laser"]},))
    finally:
        connection.close()


def test_readings_that_stay_paint_nothing():
    shown = MapView()
    shown.show_team([POSE])
    taken, before = reading([1.0, 2.0]), shown.revision
    shown.show_readings({(1, "laser"): ReceivedReading(taken, 0.1, 10.0, "laser")})
    painted = shown.revision
    shown.show_readings({(1, "laser"): ReceivedReading(taken, 0.2, 10.0, "laser")})
    assert painted == before + 1 == shown.revision
    shown.show_readings({(1, "laser"): ReceivedReading(reading([1.0, 2.0]), 0.0, 10.0, "laser")})
    assert shown.revision == painted + 1
