"""The 3D view drawn by OpenGL, in a process with a screen of its own, beside the painted one."""

import importlib.util
import os
import shutil
import subprocess
import sys

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from PyQt5.QtGui import QImage

from mrs_simulator.pictures.camera import Camera, on_screen
from mrs_simulator.pictures.palette import LIGHT

WIDTH, HEIGHT = 480, 360
POSES = np.array([(0.0, 0.0, 0.3), (3.0, 0.5, 1.5), (1.5, 3.0, -2.0)])
SHADES = np.array([(0.85, 0.15, 0.1), (0.1, 0.6, 0.2), (0.15, 0.3, 0.85)])
WAY = np.array([(-0.3, -1.6, 0.0), (0.2, -1.2, 0.0), (0.5, -0.7, 0.0)])
CAMERA = Camera((1.3, 1.0, 0.0), 6.5, 20.0, -18.0)  # which has the horizon in its picture
NONE_HERE = 77
# ``graphics_card`` hides what is wrong with OpenGL: whether there is one is asked of Qt alone.
PROGRAM = """
import sys
from PyQt5.QtGui import QOffscreenSurface, QOpenGLContext, QSurfaceFormat
from PyQt5.QtWidgets import QApplication
application = QApplication([])
wanted, context = QSurfaceFormat(), QOpenGLContext()
wanted.setVersion(3, 3)
wanted.setProfile(QSurfaceFormat.CoreProfile)
context.setFormat(wanted)
if not context.create() or context.format().version() < (3, 3):
    sys.exit({none_here})
del context
import numpy as np
from mrs_simulator.pictures.camera import Camera
from mrs_simulator.pictures.scene import Beams, Scene, ghosts_at
from mrs_simulator.rqt_plugin.map.team import resting
from mrs_simulator.rqt_plugin.view.canvas import Canvas
from mrs_simulator.scenario.surroundings.obstacles import Box
from mrs_simulator.vehicles import kind
poses, shades, way, camera = (np.array(each) for each in {given})
kinds = (kind("pioneer3dx"),) * 3
scene = Scene(
    kinds, resting((1, 2, 3), poses), shades, trails=(way, np.empty((0, 3)), np.empty((0, 3))),
    obstacles=(Box(name="crate", x=-2.0, y=3.0, length=0.8, width=0.8, height=0.5, yaw=0.0),),
    numbered=False,
)
canvas = Canvas()
canvas.resize({width}, {height})
assert canvas.card is not None and canvas.card.suits(scene), "OpenGL is there, and is not used"
for name in ("plain", "fine", "painted"):
    if name == "painted":
        canvas.card = None
    canvas.show_scene(scene)
    canvas._moved -= 1e6 * (name == "fine")
    canvas._untouched, canvas.camera = False, Camera(tuple(camera[:3]), *camera[3:])
    has_card = canvas.card is not None
    assert canvas.grab().toImage().save(name + ".png")
    assert has_card == (canvas.card is not None), "OpenGL has failed"
coast = Box(name="coast", x=0.0, y=-19.6, length=60.0, width=40.0, height=0.0, yaw=0.0)
for by, card in (("opengl", Canvas().card), ("painter", None)):
    canvas.card = card
    canvas.show_scene(scene._replace(obstacles=(coast,)))
    assert canvas.grab().toImage().save("coast_by_" + by + ".png")
print("drawn", flush=True)
import os
os._exit(0)
"""


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """Return the pictures (height, width, 3), in 0..1, by OpenGL without and with smooth edges, painted."""
    if not (shutil.which("xvfb-run") and shutil.which("xauth")):
        pytest.skip("no virtual screen (packages xvfb, xauth)")
    if importlib.util.find_spec("OpenGL") is None:
        pytest.skip("no PyOpenGL")
    folder = tmp_path_factory.mktemp("opengl")
    given = POSES.tolist(), SHADES.tolist(), WAY.tolist(), [*CAMERA.target, *CAMERA[1:]]
    program = PROGRAM.format(none_here=NONE_HERE, given=given, width=WIDTH, height=HEIGHT)
    command = ["xvfb-run", "-a", "-s", "-screen 0 800x600x24", sys.executable, "-c", program]
    environment = dict(os.environ, QT_QPA_PLATFORM="xcb", LIBGL_ALWAYS_SOFTWARE="1")
    with open(str(folder / "log"), "w") as log:
        ended = subprocess.run(
            command, cwd=str(folder), env=environment, stdout=log, stderr=log, timeout=240
        )
    if ended.returncode == NONE_HERE:
        pytest.skip("no OpenGL 3.3 on a virtual screen")
    assert ended.returncode == 0, (folder / "log").read_text()[-3000:]
    return {path.stem: _read(str(path)) for path in folder.glob("*.png")}


def _read(path):
    image = QImage(path).convertToFormat(QImage.Format_RGB888)
    assert (image.width(), image.height()) == (WIDTH, HEIGHT)
    rows = np.frombuffer(image.constBits().asstring(image.byteCount()), dtype=np.uint8)
    rows = rows.reshape(HEIGHT, image.bytesPerLine())[:, : 3 * WIDTH]
    return rows.reshape(HEIGHT, WIDTH, 3) / 255.0


def at(points):
    """Return where ``points`` (k, 3) [m] are, (k, 2) [px]: column, row."""
    return on_screen(CAMERA.seen(np.asarray(points, dtype=float)), WIDTH, HEIGHT)


def around(picture, point, half):
    """Return the pixels (k, 3) within ``half`` [px] of a ``point`` (3,) [m]."""
    column, row = np.round(at([point])[0]).astype(int)
    part = picture[row - half : row + half + 1, column - half : column + half + 1]
    return part.reshape(-1, 3)


def of_hue(picture, shade):
    """Return which pixels are of the colour ``shade`` (3,), lit more or less: of the same direction."""
    apart = picture - picture.min(axis=-1, keepdims=True)
    wanted = np.asarray(shade) - np.min(shade)
    size = np.linalg.norm(apart, axis=-1)
    along = apart @ wanted / np.linalg.norm(wanted)
    return (size > 0.12) & (along > 0.97 * size)


BY_OPENGL = pytest.mark.parametrize("way", ("plain", "fine"))


@BY_OPENGL
def test_robots_are_where_they_are_painted_and_as_large(pictures, way):
    rows = np.arange(3)
    column, row = at(POSES * (1.0, 1.0, 0.0))[:, :, np.newaxis, np.newaxis].swapaxes(0, 1)
    near = (np.abs(np.arange(WIDTH) - column) < 45) & (
        np.abs(np.arange(HEIGHT)[:, np.newaxis] - row) < 45
    )
    for robot in rows:
        drawn, painted = (
            np.argwhere(of_hue(pictures[each], SHADES[robot]) & near[robot])
            for each in (way, "painted")
        )
        assert len(painted) > 100
        assert len(drawn) == pytest.approx(len(painted), rel=0.35)
        assert np.abs(drawn.mean(axis=0) - painted.mean(axis=0)).max() < 3.0


@BY_OPENGL
def test_ground_and_sky_are_in_their_colours_and_the_ground_has_its_grid(pictures, way):
    picture = pictures[way]
    free = around(picture, (3.6, -0.9, 0.0), 12)
    assert np.median(free, axis=0) == pytest.approx(LIGHT.ground, abs=0.03)
    assert free.min() < 0.86  # a line
    assert picture[2].min() > 0.6 and picture[2, :, 2].mean() > picture[2, :, 0].mean()
    lines = np.abs(picture[-120:] - np.array(LIGHT.ground)).max(axis=2) > 0.05
    assert 0.02 < lines.mean() < 0.3


@BY_OPENGL
def test_bodies_are_lit_from_aside_and_cast_one_shadow(pictures, way):
    picture, shadow = pictures[way], np.array(LIGHT.ground) * (1.0 - LIGHT.shadow)
    for pose in POSES:
        part = around(picture, pose * (1.0, 1.0, 0.0), 30)
        assert (np.abs(part - shadow).max(axis=1) < 0.03).sum() > 40
    dark = np.abs(picture - shadow * (1.0 - LIGHT.shadow)).max(axis=2) < 0.01
    assert dark.mean() < 0.002  # where two bodies shade the ground it is no darker
    front, right = (
        around(picture, place, 2).mean() for place in ((-2.1, 2.6, 0.2), (-1.6, 3.1, 0.2))
    )
    assert front > right + 0.08  # the crate's, of which the light comes to one


@BY_OPENGL
def test_obstacles_and_trails_are_drawn(pictures, way):
    crate = around(pictures[way], (-2.0, 3.0, 0.25), 6)
    crate -= crate.mean(axis=1, keepdims=True)
    obstacle = np.array(LIGHT.obstacle)
    assert np.abs(crate - (obstacle - obstacle.mean())).max() < 0.06
    assert np.median(around(pictures[way], (-2.0, 3.0, 0.25), 6)) < 0.85
    for share in (0.2, 0.5, 0.8):
        place = WAY[0] + share * (WAY[2] - WAY[0])
        assert of_hue(around(pictures[way], place, 2), SHADES[0]).any()


@BY_OPENGL
def test_nothing_is_black_that_is_not_painted_black(pictures, way):
    black = {name: (pictures[name].max(axis=2) < 0.1).mean() for name in (way, "painted")}
    assert black[way] < 1.5 * black["painted"] + 0.002


def test_smooth_edges_differ_from_steps_at_edges_alone(pictures):
    apart = np.abs(pictures["plain"] - pictures["fine"]).max(axis=2) > 0.02
    assert 0.001 < apart.mean() < 0.12


def test_land_in_the_water_is_where_it_is_painted(pictures):
    by_opengl, painted = pictures["coast_by_opengl"], pictures["coast_by_painter"]
    for picture in (by_opengl, painted):
        for place, colour in (((2.3, -0.9, 0.0), LIGHT.ground), ((0.2, 1.2, 0.0), LIGHT.water)):
            part = around(picture, place, 8)
            assert np.median(part, axis=0) == pytest.approx(colour, abs=0.03)
    blue = [picture[..., 2] - picture[..., 0] > 0.05 for picture in (by_opengl, painted)]
    assert (blue[0] != blue[1])[HEIGHT // 3 :].mean() < 0.05  # above, it fades to the horizon
    shadow = np.array(LIGHT.ground) * (1.0 - LIGHT.shadow)  # of the robot that stands on the land
    part = around(by_opengl, POSES[0] * (1.0, 1.0, 0.0), 30)
    assert (np.abs(part - shadow).max(axis=1) < 0.03).sum() > 40
    lines = np.abs(by_opengl[-80:] - np.array(LIGHT.ground)).max(axis=2) > 0.05
    assert 0.02 < lines.mean() < 0.3
