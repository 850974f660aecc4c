"""The bodies of a scene as triangles, and the 3D view with and without OpenGL."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from PyQt5.QtGui import QColor, QImage
from PyQt5.QtWidgets import QApplication

from mrs_simulator.pictures.instances import NOSE, instances, triangles
from mrs_simulator.pictures.scene import Scene
from mrs_simulator.pictures.solids import kind_model, model_of
from mrs_simulator.rqt_plugin.map.team import resting
from mrs_simulator.rqt_plugin.view import canvas as canvases
from mrs_simulator.rqt_plugin.view.canvas import Canvas
from mrs_simulator.scenario.surroundings.obstacles import Box
from mrs_simulator.vehicles import kind
from mrs_simulator.vehicles.shape import Part

APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors")
POSES = np.array([[0.0, 0.0, 0.5 * np.pi], [3.0, 1.0, 0.0], [np.nan, 0.0, 0.0]])


def scene(**parts):
    kinds = (kind("pioneer3dx"),) * 3
    shades = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    return Scene(kinds, resting((1, 2, 3), POSES), shades)._replace(**parts)


def test_triangles_cover_each_face_and_face_outwards():
    model = kind_model(kind("pioneer3dx"))
    rows = triangles(model, with_nose=False)
    assert len(rows) == 3 * int((model.counts - 2).sum())
    corners, normals = rows[:, :3].reshape(-1, 3, 3), rows[::3, 3:6]
    turned = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("td,td->t", turned, normals) > 0.0).all()
    assert (triangles(model, with_nose=True)[len(rows) :, 9] == NOSE).all()


def test_what_is_round_is_lit_as_such_and_what_is_flat_stays_flat():
    parts = (
        Part("cylinder", (0.5, 1.0)),
        Part("box", (1.0, 1.0, 1.0), (3.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
    )
    model = model_of(parts)
    rows = triangles(model, with_nose=False)
    around, box = rows[rows[:, 0] < 1.0], rows[rows[:, 0] > 1.0]
    is_side = np.abs(around[:, 5]) < 0.5
    sides, caps = around[is_side], around[~is_side]
    assert np.allclose(sides[:, 3:5], sides[:, :2] / 0.5, atol=1e-6)
    assert np.allclose(np.abs(caps[:, 5]), 1.0)
    tile = triangles(model._replace(crisp=np.zeros(len(model.crisp), dtype=bool)), with_nose=False)
    for flat in (box, tile[tile[:, 0] > 1.0]):  # a tile has no edges of its own, and is no ball
        assert np.allclose(np.abs(flat[:, 3:6]).max(axis=1), 1.0)


def test_robots_of_known_pose_and_obstacles_are_placed():
    crate = Box(name="crate", x=5.0, y=2.0, length=0.5, width=0.5, height=0.4, yaw=0.0)
    team, wheels, box = instances(scene(obstacles=(crate,)), (0.7, 0.6, 0.5))
    assert team.place.tolist() == [[0.0, 0.0, 0.0], [3.0, 1.0, 0.0]] and team.has_nose
    assert team.turn[0] @ (1.0, 0.0, 0.0) == pytest.approx([0.0, 1.0, 0.0])
    assert len(wheels.place) == 4 and box.place.tolist() == [[5.0, 2.0, 0.2]]
    assert box.shades.tolist() == [[0.7, 0.6, 0.5]]


class Card:
    """In place of a ``GraphicsCard``: pictures of one colour."""

    def __init__(self, wrong=False, is_software=False):
        self.wrong, self.is_software = wrong, is_software
        self.sizes, self.fine = [], []

    def suits(self, scene):
        return not scene.edges

    def picture(self, _scene, _camera, size, _palette, is_fine):
        self.fine.append(is_fine)
        if self.wrong:
            raise RuntimeError("the driver is gone")
        self.sizes.append(tuple(size))
        image = QImage(*size, QImage.Format_RGB32)
        image.fill(QColor("#123456"))
        return image


def corner_of(canvas):
    return canvas.grab().toImage().pixelColor(1, 1).name()


def test_the_view_takes_the_cards_picture_and_paints_where_there_is_none():
    canvas = Canvas()
    canvas.resize(300, 200)
    canvas.card = None
    canvas.show_scene(scene(numbered=False))
    painted = corner_of(canvas)
    canvas.card = Card()
    assert corner_of(canvas) == "#123456" and canvas.card.sizes == [(300, 200)]
    canvas.show_scene(scene(numbered=False, edges=[(0, 1, 1.0)]))  # what it does not suit
    assert corner_of(canvas) == painted
    canvas.show_scene(scene(numbered=False))
    canvas.card = Card(wrong=True)
    assert corner_of(canvas) == painted and canvas.card is None


def test_by_software_edges_are_smooth_once_the_picture_stands_still(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(canvases.time, "monotonic", lambda: now[0])
    canvas = Canvas()
    canvas.resize(300, 200)
    for is_software in (True, False):
        canvas.card = card = Card(is_software=is_software)
        canvas.show_scene(scene(numbered=False))
        canvas.grab()
        assert canvas.refining.isActive() == is_software
        assert set(card.fine) == {not is_software}
        now[0] += canvases.STILL_FOR
        canvas.refining.stop()
        canvas.grab()
        assert card.fine[-1] and not canvas.refining.isActive()
