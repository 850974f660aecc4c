"""Cameras: pictures and depths of a known scene, intrinsics, and when they are rendered."""

import io
import math

import numpy as np
import pytest

from mrs_simulator.core.spatial import rotated
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.world.rendering.pinhole import depths
from mrs_simulator.world.world import World

pytest.importorskip("pybullet")
WALL = {"type": "box", "name": "wall", "center": [4.05, 0.0], "size": [0.1, 2.0], "height": 1.0}
EYE = {
    "type": "camera",
    "place": [0.3, 0.0, 0.5],
    "width": 80,
    "height": 60,
    "rate": 5,
    "range": [0.1, 20.0],
}


def sensed(mount=EYE, obstacles=(WALL,), poses=((0.0, 0.0, 0.0),), steps=1):
    """Return the readings of the robots' camera after ``steps`` of the world, and their suite."""
    content = {"poses": [list(pose) for pose in poses], "obstacles": list(obstacles)}
    scenario = scenario_from_dict(dict(content, sensors=[{"mounts": {"eye": mount}}]))
    world = World.from_scenario(scenario)
    suite = Suite.of_scenario(scenario, *world.senses)
    suite.activate({row: ["eye"] for row in range(len(poses))})
    for step in range(steps):
        suite.update(step, world.sensed)
        world.step()
    return [suite.readings(world.time)[row]["eye"] for row in range(len(poses))], suite


def pixel(reading, x, y, z):
    """Return row and column at which a point to the right, down and ahead of the camera is."""
    fx, fy, cx, cy = reading.intrinsics
    return int(round(fy * y / z + cy)), int(round(fx * x / z + cx))


def test_a_wall_is_where_and_as_far_as_geometry_has_it():
    (reading,), _ = sensed()
    assert reading.image.shape == (60, 80, 3) and reading.image.dtype == np.uint8
    assert reading.depth.shape == (60, 80)
    assert reading.depth[29, 39] == pytest.approx(3.7, abs=0.01)  # 4.0 less the camera's 0.3
    # Its edges are 1 m to the sides and 0.5 m above and below the camera; depth is along the axis.
    assert reading.depth[pixel(reading, 0.9, -0.4, 3.7)] == pytest.approx(3.7, abs=0.01)
    assert reading.depth[pixel(reading, 1.1, -0.3, 3.7)] == np.inf
    assert reading.depth[pixel(reading, 0.0, -0.6, 3.7)] == np.inf
    # The ground ahead, 0.5 m below: at 1.6 m.
    assert reading.depth[pixel(reading, 0.0, 0.5, 1.6)] == pytest.approx(1.6, abs=0.06)


def test_turned_and_lowered_it_looks_there():
    (reading,), _ = sensed(dict(EYE, down="90 deg"))
    assert reading.depth[30, 40] == pytest.approx(0.5, abs=0.02)
    (left,), _ = sensed(
        dict(EYE, yaw="90 deg"), obstacles=[dict(WALL, center=[0.3, 2.0], size=[1.0, 0.2])]
    )
    assert left.depth[29, 39] == pytest.approx(1.9, abs=0.01)


def test_its_axis_meets_the_picture_where_the_intrinsics_say():
    """By planes aslant of the axis, whose inverse depth is linear across the picture."""
    (reading,), _ = sensed(dict(EYE, down="30 deg"), obstacles=())
    rows = np.arange(30.0, 60.0)  # of the ground, 0.5 m below
    fx, fy, cx, cy = reading.intrinsics
    slope, first = np.polyfit(rows, 1.0 / reading.depth[30:, 40], 1)
    away = math.cos(math.radians(30.0)) / (fy * slope)
    middle = (0.5 - first * away) * fy / math.cos(math.radians(30.0))
    assert away == pytest.approx(0.5, abs=2e-3) and middle == pytest.approx(cy, abs=0.1)
    wall = dict(WALL, center=[3.5, 0.0], size=[1.0, 40.0])
    (reading,), _ = sensed(dict(EYE, place=[0.0, 0.0, 0.5], yaw="45 deg"), obstacles=[wall])
    columns = np.arange(40.0, 80.0)
    slope, first = np.polyfit(columns, 1.0 / reading.depth[29, 40:], 1)
    away = math.sqrt(0.5) / (fx * slope)
    middle = (math.sqrt(0.5) - first * away) * fx / math.sqrt(0.5)
    assert away == pytest.approx(3.0, abs=0.01) and middle == pytest.approx(cx, abs=0.1)


def test_other_robots_are_seen_from_each():
    given, suite = sensed(poses=((0.0, 0.0, 0.0), (2.0, 0.0, math.pi)), obstacles=())
    for reading in given:
        row, column = pixel(reading, 0.0, 0.3, 1.5)
        assert reading.depth[row, column - 3 : column + 3].min() < 1.7
    assert len(suite.mounts) == 2


def test_the_field_of_view_sets_the_intrinsics():
    (reading,), _ = sensed(dict(EYE, view="90 deg"))
    assert reading.intrinsics == pytest.approx((40.0, 40.0, 39.5, 29.5))


def test_it_is_rendered_when_due_and_listened_to_alone(monkeypatch):
    from mrs_simulator.world.rendering.view import View

    seen, plain = [], View.seen
    monkeypatch.setattr(View, "seen", lambda *given: seen.append(1) or plain(*given))
    sensed(steps=21)  # 0.4 s at 5 Hz: at 0, 0.2 and 0.4 s
    assert len(seen) == 3
    scenario = scenario_from_dict({"poses": [[0, 0, 0]], "sensors": [{"mounts": {"eye": EYE}}]})
    world = World.from_scenario(scenario)
    suite = Suite.of_scenario(scenario, *world.senses)
    suite.update(0, world.sensed)
    assert len(seen) == 3 and suite.is_idle


def test_depths_are_lost_and_noisy_and_colours_are_not():
    (plain,), _ = sensed()
    (noisy,), _ = sensed(dict(EYE, noise={"depth": {"stddev": 0.05, "dropout": 0.1}}))
    np.testing.assert_array_equal(plain.image, noisy.image)
    assert np.isnan(noisy.depth).mean() == pytest.approx(0.1, abs=0.02)
    wall = plain.depth < 3.8
    assert np.nanstd((noisy.depth - plain.depth)[wall]) == pytest.approx(0.05, rel=0.1)


def test_a_camera_of_colours_alone_knows_no_depth():
    (reading,), _ = sensed(dict(EYE, depth=False))
    np.testing.assert_array_equal(reading.image, sensed()[0][0].image)
    assert np.isnan(reading.depth).all()
    with pytest.raises(ScenarioError, match="depth: 1, wanted true or false"):
        sensed(dict(EYE, depth=1))


def test_a_depth_buffer_is_undone():
    far = np.array([0.1, 0.5, 5.0])
    buffer = 20.0 * (far - 0.1) / (far * (20.0 - 0.1))
    np.testing.assert_allclose(depths(buffer, 0.1, 20.0), far)
    assert depths(np.array([1.0]), 0.1, 20.0)[0] == np.inf


def test_what_cannot_be_shown_is_said():
    with pytest.raises(ScenarioError, match="width: 0"):
        sensed(dict(EYE, width=0))


def test_what_moves_is_shown_where_it_is_at_the_stamp():
    mount = dict(EYE, noise={"depth": {"latency": 0.3}})
    cart = dict(WALL, track={"to": [[9.05, 0.0]], "speed": 1.0})
    (reading,), _ = sensed(mount, obstacles=[cart], steps=65)  # of 1.3 s, what was at 1 s
    assert reading.stamp == pytest.approx(1.0)
    assert reading.depth[29, 39] == pytest.approx(3.7 + 1.0, abs=0.02)


def test_messages_tell_picture_depth_and_intrinsics():
    pytest.importorskip("rospy")
    from std_msgs.msg import Header

    from mrs_simulator.ros.message_forms import sensor_messages as messages
    from mrs_simulator.ros.message_forms.messages import MessageError

    (reading,), suite = sensed()
    (mount,) = [each for each in suite.mounts[0] if each.name == "eye"]
    colours, far, raw, pinhole, far_pinhole = messages.forms_of(mount, None)
    item = [reading.image, reading.depth]
    told = colours.message(item, Header())
    buffer = io.BytesIO()
    told.serialize(buffer)
    np.testing.assert_array_equal(
        colours.reading(told.deserialize(buffer.getvalue()), 1.0).image, reading.image
    )
    known = np.isfinite(reading.depth)
    for form, encoding, off in ((far, "32FC1", 1e-6), (raw, "16UC1", 5.1e-4)):
        depth = form.message(item, Header())
        assert depth.encoding == encoding
        back = form.reading(depth, 1.0).depth
        np.testing.assert_allclose(back[known], reading.depth[known], atol=off)
        is_nothing = np.isposinf if form is far else np.isnan
        assert known.any() and not known.all() and is_nothing(back[~known]).all()
    lost = np.where(known, reading.depth, np.nan)
    assert np.isnan(
        far.reading(far.message([reading.image, lost], Header()), 1.0).depth[~known]
    ).all()
    nothing = np.frombuffer(raw.message(item, Header()).data, "<u2").reshape(60, 80)[~known]
    assert not nothing.any()
    for form in (pinhole, far_pinhole):
        info = form.message(item, Header())
        told_of = info.K[0], info.K[2], info.K[5]
        assert told_of == pytest.approx((reading.intrinsics[0], 39.5, 29.5))
    told.width = 81
    with pytest.raises(MessageError, match="wanted rgb8 of 80 x 60"):
        colours.reading(told, 1.0)


def test_a_camera_of_colours_alone_tells_no_depth():
    pytest.importorskip("rospy")
    from mrs_simulator.ros.message_forms import sensor_messages as messages

    for has_depth, forms, parts in ((True, 5, ["", "_depth"]), (False, 2, [""])):
        (mount,) = [m for m in sensed(dict(EYE, depth=has_depth))[1].mounts[0] if m.name == "eye"]
        assert len(messages.forms_of(mount, None)) == forms
        assert [form.SUFFIX for form in messages.parts_of(mount, None)] == parts


def test_optical_axes_lie_to_the_right_down_and_ahead():
    pytest.importorskip("rospy")
    from mrs_simulator.ros.message_forms import sensor_messages as messages

    def axes(**changed):
        scenario = scenario_from_dict(
            {"poses": [[0, 0, 0]], "sensors": [{"mounts": {"eye": dict(EYE, **changed)}}]}
        )
        (mount,) = [
            each for each in Suite.of_scenario(scenario, World.from_scenario(scenario).team).mounts[0]
            if each.name == "eye"
        ]  # fmt: skip
        optics = messages.forms_of(mount, None)[0].optics
        return rotated(np.tile(optics, (3, 1)), np.eye(3))

    np.testing.assert_allclose(axes(), [[0, -1, 0], [0, 0, -1], [1, 0, 0]], atol=1e-12)
    lowered = axes(down="30 deg")
    s, c = math.sin(math.pi / 6), math.cos(math.pi / 6)
    np.testing.assert_allclose(lowered, [[0, -1, 0], [-s, 0, -c], [c, 0, -s]], atol=1e-12)


def test_software_renders_and_the_log_says_why(monkeypatch, caplog):
    from mrs_simulator.world.rendering import renderers

    caplog.set_level("INFO", renderers.LOG.name)
    monkeypatch.setattr(renderers.LOG, "propagate", True)
    monkeypatch.setattr(renderers.glob, "glob", lambda pattern: [])
    assert renderers.chosen_renderer(0) == renderers.SOFTWARE
    assert "software renderer: there is no graphics card" in caplog.text
    # A device that is none: the plugin is tried, and says no.
    monkeypatch.setattr(renderers.glob, "glob", lambda pattern: ["/dev/dri/renderD0"])
    monkeypatch.setattr(renderers.pybullet, "loadPlugin", lambda *_, **__: -1)
    assert renderers.chosen_renderer(0) == renderers.SOFTWARE
    assert "/dev/dri/renderD0 is there, but EGL does not open it" in caplog.text
    with monkeypatch.context() as patched:
        patched.setattr(renderers.importlib.util, "find_spec", lambda name: None)
        assert renderers.chosen_renderer(0) == renderers.SOFTWARE
    assert "built without EGL" in caplog.text
    (reading,), _ = sensed()
    assert reading.depth[29, 39] == pytest.approx(3.7, abs=0.01)
