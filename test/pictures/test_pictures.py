"""Pictures in space: solids are closed, what is nearer hides what is farther, all of a team is in view."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest

from mrs_simulator.core.spatial import upright
from mrs_simulator.pictures import camera as cameras
from mrs_simulator.pictures import ground
from mrs_simulator.pictures.camera import Camera, clipped_polygon, clipped_segments, on_screen
from mrs_simulator.pictures.drawing import Lines, Paths, Polygons, Texts
from mrs_simulator.pictures.instances import instances
from mrs_simulator.pictures.palette import DARK, LIGHT, START
from mrs_simulator.pictures.scene import GHOST_SHOWN, Scene, drawn, drawn_signs, framed, ghosts_at
from mrs_simulator.pictures.solids import kind_model, obstacle_models, solid_of
from mrs_simulator.pictures.view import View
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.draw.paint import pixels
from mrs_simulator.vehicles import Team, kind
from mrs_simulator.vehicles.registry import shipped_kinds
from mrs_simulator.vehicles.shape import Part

WIDTH, HEIGHT = 320, 240
RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
ABOVE = Camera(pitch=-89.0)


def scene(pose, kinds="pioneer3dx", spatial=None, **given):
    pose = np.array(pose, dtype=float).reshape(-1, 3)
    kinds = [kinds] * len(pose) if isinstance(kinds, str) else kinds
    shades = np.tile(RED, (len(pose), 1))
    state = StateTable(0.0, tuple(range(1, len(pose) + 1)), pose=pose, spatial=spatial)
    return Scene(Team(kinds).kinds, state, shades)._replace(**given)


def layers(picture, kind_of_layer):
    return [layer for layer in picture.layers if isinstance(layer, kind_of_layer)]


# Solids ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "form, size, volume",
    [
        ("box", (2.0, 1.0, 0.5), 1.0),
        # Of the prism over a regular polygon of 16 corners: 8 sin(pi / 8) r^2 for its base.
        ("cylinder", (0.5, 2.0), 8.0 * np.sin(np.pi / 8.0) * 0.25 * 2.0),
        ("sphere", (0.5,), None),
    ],
)
def test_solids_are_closed_and_look_outwards(form, size, volume):
    solid = solid_of(Part(form, size, (1.0, -2.0, 0.3, 0.4, -0.2, 1.1)))
    middle, total = solid.vertices.mean(axis=0), 0.0
    edges = []
    for face in solid.faces:
        corners = solid.vertices[list(face)]
        for second, third in zip(corners[1:-1], corners[2:]):
            part = (
                np.dot(np.cross(second - corners[0], third - corners[0]), corners[0] - middle) / 6.0
            )
            assert part > 0.0
            total += part
        edges += list(zip(face, face[1:] + face[:1]))
    # Each edge borders two faces, once in each direction: the surface is closed.
    assert len(set(edges)) == len(edges) and {(b, a) for a, b in edges} == set(edges)
    ball = 4.0 / 3.0 * np.pi * 0.125
    assert 0.8 * ball < total < ball if volume is None else total == pytest.approx(volume)


@pytest.mark.parametrize("name", shipped_kinds())
def test_each_kind_has_a_model_of_its_size_in_the_robots_colour(name):
    each = kind(name)
    model = kind_model(each)
    low, high = model.vertices.min(axis=0), model.vertices.max(axis=0)
    assert high[2] <= each.body.height + 0.02 and model.own.max() == 1.0
    assert abs((high - low)[0] - each.body.length) < 0.35 * each.body.length
    assert len(kind_model(each, coarse=True).counts) <= len(model.counts)
    tip, left, right = model.nose
    assert tip[0] > left[0] == right[0] and left[1] > right[1]


def test_long_obstacles_are_of_tiles_that_fill_them():
    tiles = list(obstacle_models(Box("wall", 1.0, 2.0, np.pi / 2.0, 3.5, 0.2, 1.0), LIGHT.obstacle))
    assert len(tiles) == 4
    places = np.array([place for _, place in tiles])
    assert np.allclose(places[:, 0], 1.0) and np.ptp(places[:, 1]) == pytest.approx(3.5 * 3 / 4)


# The camera --------------------------------------------------------------------------------------


def test_a_camera_from_the_south_sees_the_east_on_the_right():
    camera = Camera((1.0, 2.0, 0.0), 5.0, 0.0, -30.0)
    assert np.allclose(camera.eye, (1.0, 2.0 - 5.0 * np.sqrt(0.75), 2.5))
    seen = camera.seen(np.array([(1.0, 2.0, 0.0), (2.0, 2.0, 0.0), (1.0, 2.0, 1.0)]))
    assert np.allclose(seen[0], (0.0, 0.0, 5.0))
    at = on_screen(seen, WIDTH, HEIGHT)
    assert np.allclose(at[0], (160.0, 120.0)) and at[1, 0] > 160.0 and at[2, 1] < 120.0
    # 40 degrees from bottom to top: at 5 m, 1 m takes 120 / tan(20 degrees) / 5 pixels.
    assert at[1, 0] - 160.0 == pytest.approx(120.0 / np.tan(np.radians(20.0)) / 5.0)


@pytest.mark.parametrize("yaw, pitch", [(0.0, -89.0), (35.0, -40.0), (-120.0, -10.0)])
def test_framing_brings_all_into_view_and_no_farther_than_needed(yaw, pitch):
    points = np.random.default_rng(3).uniform((-8.0, -2.0, 0.0), (20.0, 30.0, 3.0), (50, 3))
    camera = Camera(yaw=yaw, pitch=pitch).framed(points, WIDTH, HEIGHT)
    at = on_screen(camera.seen(points), WIDTH, HEIGHT)
    low, high = at.min(axis=0), at.max(axis=0)
    assert (low > -1e-6).all() and (high < (WIDTH + 1e-6, HEIGHT + 1e-6)).all()
    sides = np.concatenate([low, (WIDTH, HEIGHT) - high])
    assert (sides < 1e-6).sum() >= 2  # two opposite sides are touched
    assert np.allclose(low + high, (WIDTH, HEIGHT), atol=1.0)  # in the middle
    assert camera.target[2] == pytest.approx(0.0, abs=1e-9)
    inner = Camera(yaw=yaw, pitch=pitch).framed(points, WIDTH, HEIGHT, 0.8)
    at = on_screen(inner.seen(points), WIDTH, HEIGHT) / (WIDTH, HEIGHT)
    assert at.min() > 0.1 - 1e-6 and at.max() < 0.9 + 1e-6


def test_orbit_zoom_and_pan_stay_within_bounds():
    camera = Camera().turned(350.0, -100.0)
    assert camera.yaw == -10.0 and camera.pitch == cameras.STEEPEST
    assert Camera().turned(0.0, 100.0).pitch == cameras.FLATTEST
    assert Camera().zoomed(1e9).distance == cameras.FARTHEST
    assert Camera().zoomed(1e-9).distance == cameras.NEAREST
    # What is under the mouse follows it.
    moved = ABOVE.panned(10.0, 0.0, HEIGHT)
    before, after = (
        on_screen(each.seen(np.zeros((1, 3))), WIDTH, HEIGHT) for each in (ABOVE, moved)
    )
    assert np.allclose(after - before, [(10.0, 0.0)], atol=1e-6)


def test_what_is_behind_the_eye_is_cut_off():
    segments = np.array([[(0, 0, -1), (0, 0, 1)], [(0, 0, -2), (0, 0, -1)]], dtype=float)
    cut, left = clipped_segments(segments, near=0.5)
    assert left.tolist() == [True, False] and np.allclose(cut, [[(0, 0, 0.5), (0, 0, 1)]])
    square = np.array([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)], dtype=float)
    assert np.allclose(np.sort(clipped_polygon(square, 0.0)[:, 2]), (0, 0, 1, 1))
    assert clipped_polygon(square - (0, 0, 5), 0.0).shape == (0, 3)


# Scenes ------------------------------------------------------------------------------------------


def test_the_nearer_robot_hides_the_farther_one():
    # Two robots on one line of sight from the south: only the nearer one's colour is in the middle.
    team = scene([(0.0, 0.0, 0.0), (0.0, 0.6, 0.0)], "robotino3")
    camera = Camera((0.0, 0.0, 0.1), 3.0, 0.0, -5.0)
    for shades, wanted in (((RED, BLUE), 0), ((BLUE, RED), 2)):
        picture = pixels(drawn(team._replace(shades=np.array(shades)), camera, WIDTH, HEIGHT))
        middle = picture[120, 160].astype(int)
        assert np.argmax(middle) == wanted and middle.max() > 2 * sorted(middle)[1]


def test_a_wall_hides_what_is_behind_it_and_not_what_is_before_it():
    wall = (Box("wall", 0.0, 0.0, 0.0, 6.0, 0.2, 2.0),)
    camera = Camera((0.0, 0.0, 0.2), 6.0, 0.0, -8.0)
    for y, seen in ((-0.6, True), (0.6, False)):
        team = scene([(2.0, y, 0.0)], obstacles=wall, numbered=False)
        picture = pixels(drawn(team, camera, WIDTH, HEIGHT)).astype(int)
        red = picture[..., 0] > picture[..., 2] + 60
        assert red.any() == seen


@pytest.mark.parametrize("pitch", [-89.0, -40.0, -5.0])
@pytest.mark.parametrize(
    "name",
    ["pioneer3dx", "crazyflie2"]
    + [pytest.param(name, marks=pytest.mark.release) for name in ("husky", "wamv")],
)
def test_parts_hide_one_another_as_their_distances_tell(name, pitch):
    # The picture's faces against the nearest face on the ray of each of their middles.
    model = kind_model(kind(name))
    pairs = zip(model.pairs.beyond, model.pairs.within, model.pairs.apart)
    joined = [{first, second} for first, second, apart in pairs if not apart]
    for yaw in (0.0, 50.0, 160.0):
        camera = Camera((0.0, 0.0, 0.0), 6.0 * model.reach, yaw, pitch)
        eye = camera.eye
        screen = on_screen(camera.seen(model.vertices), WIDTH, HEIGHT)
        order = model.pairs.ranks(eye[np.newaxis], screen[np.newaxis], model.begins)[0]
        begins = np.cumsum(model.counts) - model.counts
        for face in range(len(model.counts)):
            corners = model.corners[begins[face] : begins[face] + model.counts[face]]
            middle = model.vertices[corners].mean(axis=0)
            hit = _parts_before(model, eye, middle, model.part[face])
            own = model.part[face]
            assert all(order[part] > order[own] for part in hit if {part, own} not in joined)


def _parts_before(model, eye, point, own):
    """Return the parts that the segment from ``eye`` passes through well before it reaches ``point``."""
    hit = []
    for part in set(model.part.tolist()) - {own}:
        faces = model.part == part
        begin = model.normals[faces] @ eye - model.offsets[faces]
        slope = model.normals[faces] @ (point - eye)
        with np.errstate(divide="ignore"):
            cross = -begin / slope
        enter = cross[slope < 0.0].max(initial=0.0)
        leave = cross[slope > 0.0].min(initial=np.inf)
        if (begin[slope == 0.0] > 0.0).any() or not enter < leave < 1.0:
            continue
        if (leave - enter) * np.linalg.norm(point - eye) > 0.02 * model.reach:
            hit.append(part)
    return hit


def test_robots_that_are_not_known_are_left_out():
    team = scene([(0.0, 0.0, 0.0), (np.nan, 1.0, 0.0)], trails=(np.zeros((0, 3)),) * 2)
    camera = framed(team, Camera(), WIDTH, HEIGHT)
    picture = drawn(team, camera, WIDTH, HEIGHT)
    assert [text.texts for text in layers(picture, Texts)][-1] == ("1",)
    for layer in picture.layers:
        assert np.isfinite(layer[0]).all()


def test_robots_behind_the_eye_and_far_away_are_left_out_or_marked():
    camera = Camera((0.0, 0.0, 0.0), 4.0, 0.0, -20.0)
    behind = drawn(scene([(0.0, -20.0, 0.0)]), camera, WIDTH, HEIGHT)
    assert not layers(behind, Texts)[1:] and not [
        p for p in layers(behind, Polygons) if len(p.counts) > 1
    ]
    far = drawn(scene([(0.0, 900.0, 0.0)]), camera, WIDTH, HEIGHT)
    marks = [each for each in layers(far, Polygons) if each.counts[0] == 12]
    assert marks and np.allclose(marks[-1].colours[0, :3], RED)


def test_heights_shadows_and_plumb_lines():
    team = scene([(0.0, 0.0, 0.0)], "crazyflie2", spatial=upright(np.zeros(1), np.array([1.5])))
    camera = framed(team, Camera(pitch=-20.0), WIDTH, HEIGHT)
    picture = drawn(team, camera, WIDTH, HEIGHT)
    shadow, robot = (layers(picture, Polygons)[k].points.mean(axis=0) for k in (-2, -1))
    assert robot[1] < shadow[1] - 20.0  # the shadow is on the ground below
    plumb = layers(picture, Lines)[-1].segments[0]
    assert np.allclose(plumb[:, 0], plumb[0, 0], atol=1e-6)
    assert np.ptp(plumb[:, 1]) == pytest.approx(shadow[1] - robot[1], abs=15.0)


def test_a_trail_is_of_the_robots_colour_and_of_few_points():
    t = np.linspace(0.0, 1.0, 5000)
    trail = np.column_stack([t, np.sin(6.0 * t), 0.0 * t])
    team = scene([(0.0, 0.0, 0.0)], trails=(trail,))
    picture = drawn(team, framed(team, Camera(), WIDTH, HEIGHT), WIDTH, HEIGHT)
    (path,) = layers(picture, Paths)
    assert path.counts.sum() == len(path.points) < 400 and np.allclose(path.colours[0, :3], RED)
    steps = np.hypot(*np.diff(path.points, axis=0).T)
    assert steps.max() < 8.0


def test_a_trail_that_passes_behind_the_eye_is_in_pieces():
    camera = Camera((0.0, 0.0, 0.0), 4.0, 0.0, -20.0)
    away = np.array([0.0, 1.0, -9.0, -9.0, 2.0, 3.0])
    trail = np.column_stack([0.0 * away, away, 0.0 * away])
    picture = drawn(scene([(0.0, 0.0, 0.0)], trails=(trail,)), camera, WIDTH, HEIGHT)
    (path,) = layers(picture, Paths)
    assert path.counts.tolist() == [2, 2]


@pytest.mark.parametrize("distance", [0.3, 1.0, 7.0, 40.0, 3000.0])
def test_the_grid_is_of_round_widths_and_says_which(distance):
    view = View(Camera(distance=distance), WIDTH, HEIGHT, LIGHT)
    wide = ground.step(view)
    assert "{:e}".format(wide)[0] in "125" and ground.unit(view).texts == (
        "grid {:g} m".format(wide),
    )
    assert ground.WIDTH <= wide * view.scale / distance <= 2.6 * ground.WIDTH


def test_the_horizon_is_where_level_lines_meet():
    view = View(Camera(pitch=-10.0, distance=5.0), WIDTH, HEIGHT, LIGHT)
    far = view.screen(view.seen(np.array([(0.0, 1e7, 0.0)])))[0, 1]
    assert ground.sky(view).points[:, 1].max() == pytest.approx(far, abs=1e-3)
    assert ground.sky(View(ABOVE, WIDTH, HEIGHT, LIGHT)) is None


def test_boats_are_on_water_and_ground_robots_are_not():
    for kinds, colour in (
        (["heron"], LIGHT.water),
        (["husky"], LIGHT.ground),
        (["crazyflie2"], LIGHT.ground),
    ):
        assert drawn(scene([(0, 0, 0)], kinds), Camera(), WIDTH, HEIGHT).ground == colour


def test_land_lies_in_water_and_is_no_thing_that_hides():
    beach = Box("beach", 0.0, 3.0, 0.0, 8.0, 6.0, 0.0)
    team = scene([(0.0, 1.0, 0.0), (0.0, -2.0, 0.0)], ["pioneer3dx", "heron"], obstacles=(beach,))
    camera = Camera((0.0, 0.0, 0.0), 9.0, 0.0, -60.0)
    picture = drawn(team, camera, WIDTH, HEIGHT)
    shown = pixels(picture).astype(int)
    assert picture.ground == LIGHT.water
    places = np.array([(2.3, 1.3, 0.0), (2.3, -1.7, 0.0)])
    (x, y), (u, v) = on_screen(camera.seen(places), WIDTH, HEIGHT).astype(int)
    land, water = shown[y, x], shown[v, u]
    assert np.abs(land - 255 * np.array(LIGHT.ground)).max() < 40 and water[2] - water[0] > 20
    assert land[2] - land[0] < 10


def test_an_edge_ends_with_its_head_at_the_body_of_its_receiver():
    team = scene([(-1, 0, 0), (1, 0, 0)], edges=[(0, 1, 2.0)])
    head = (*LIGHT.lines, 0.75)
    found = {}
    for directed in (True, False):
        picture = drawn(team._replace(directed=directed), ABOVE, WIDTH, HEIGHT)
        heads = [each for each in layers(picture, Polygons) if (each.colours == head).all()]
        found[directed] = [each.points for each in heads]
    (points,) = found[True]
    tip, scale = points[0], View(ABOVE, WIDTH, HEIGHT, LIGHT).scale / ABOVE.distance
    reach = kind("pioneer3dx").body.reach
    assert not found[False] and np.ptp(points[:, 0]) > 3.0
    assert tip[0] < points[1:, 0].min()  # it points from robot 2 to robot 1
    assert abs((tip[0] - 0.5 * WIDTH) / scale - (reach - 1.0)) < 0.1
    (line,) = [each.segments[0] for each in layers(picture, Lines) if (each.colours == head).all()]
    ends = (line[:, 0] - 0.5 * WIDTH) / scale
    assert np.allclose(ends, (1.0 - reach, reach - 1.0), atol=0.1)  # neither body is crossed


def test_a_trail_begins_with_a_dot():
    trails = (np.array([(-1.0, -1.0, 0.0), (0.0, 0.0, 0.0)]), np.zeros((0, 3)))
    picture = drawn(scene([(0, 0, 0), (1, 0, 0)], trails=trails), ABOVE, WIDTH, HEIGHT)
    (dot,) = [each for each in layers(picture, Polygons) if (each.colours == (*START, 1.0)).all()]
    scale = View(ABOVE, WIDTH, HEIGHT, LIGHT).scale / ABOVE.distance
    middle = dot.points.mean(axis=0) - (0.5 * WIDTH, 0.5 * HEIGHT)
    assert np.allclose(middle / scale, (-1.0, 1.0), atol=0.1)


def test_no_dot_lies_over_a_robot_that_is_where_it_began():
    trails = (np.array([(0.0, 0.0, 0.0), (0.1, 0.0, 0.0)]),)
    picture = drawn(scene([(0.1, 0, 0)], trails=trails), ABOVE, WIDTH, HEIGHT)
    assert not any((each.colours == (*START, 1.0)).all() for each in layers(picture, Polygons))


def test_of_long_walls_and_trails_what_is_near_is_framed_with_the_team():
    team = scene([(0, 0, 0), (2, 0, 0)], targets=np.array([(0, 3, 0), (2, 3, 0)], dtype=float))
    trails = (np.array([(-90.0, 0.0, 0.0), (0.0, 0.0, 0.0)]), np.zeros((0, 3)))
    alone = framed(team, Camera(), WIDTH, HEIGHT, whole=False)
    crate, wall = Box("crate", 3.0, 0.0, 0.0, 0.4, 0.4, 0.3), Box("wall", 20.0, 4, 0, 60, 0.2, 0.3)
    team = team._replace(obstacles=(crate, wall), trails=trails)
    near, far = (framed(team, Camera(), WIDTH, HEIGHT, whole=whole) for whole in (False, True))
    assert near.distance < 2.0 * alone.distance < 0.2 * far.distance
    at = on_screen(near.seen(np.array([(3.2, 0.2, 0.3), (2.0, 3.0, 0.0)])), WIDTH, HEIGHT)
    assert ((at > 0.0) & (at < (WIDTH, HEIGHT))).all()


@pytest.mark.parametrize("pitch", [-89.0, -40.0, -5.0])
def test_numbers_are_above_bodies_however_near(pitch):
    near = Camera(distance=2.0, pitch=pitch)
    (numbers,) = [
        each
        for each in layers(drawn(scene([(0, 0, 0.3)]), near, 600, 450), Texts)
        if each.texts == ("1",)
    ]
    seen = near.seen(kind_model(kind("pioneer3dx")).vertices @ np.eye(3))
    top = on_screen(seen, 600, 450)[:, 1].min()
    assert -45.0 < numbers.places[0, 1] - top < 0.0


def test_ghosts_are_faint_robots_with_ways_that_end_in_rings():
    shades = np.array([BLUE])
    way = np.array([(0.0, 0.0, 0.0), (1.0, 1.0, 0.0)])
    one = kind("pioneer3dx"), np.array([(1.0, 1.0, 0.0)]), np.zeros(1)
    ghosts = ghosts_at(one[:1], *one[1:], shades, [way], shades)._replace(ringed=True)
    team = scene([(0, 0, 0)])
    plain, picture = (
        drawn(each, ABOVE, WIDTH, HEIGHT) for each in (team, team._replace(ghosts=(ghosts,)))
    )
    assert len(picture.layers) == len(plain.layers) + 3  # the way, the ring, the robot
    path, ring = layers(picture, Paths)
    assert path.colours[0, :3].tolist() == list(BLUE) and 0.2 < path.colours[0, 3] < 0.7
    assert ring.counts.tolist() == [len(ring.points)] and np.allclose(
        ring.points[0], ring.points[-1]
    )
    scale = View(ABOVE, WIDTH, HEIGHT, LIGHT).scale / ABOVE.distance
    middle = ring.points[:-1].mean(axis=0) - (0.5 * WIDTH, 0.5 * HEIGHT)
    assert np.allclose(middle / scale, (1.0, -1.0), atol=0.1)
    assert GHOST_SHOWN in [each.colours[:, 3].max() for each in layers(picture, Polygons)]
    lost = ghosts._replace(place=np.full((1, 3), np.nan), paths=(), path_shades=())
    drawn(team._replace(ghosts=(lost,)), ABOVE, WIDTH, HEIGHT)
    (body,) = [
        each
        for each in instances(team._replace(ghosts=(ghosts,)), LIGHT.obstacle)
        if each.opacity < 1.0
    ]
    assert not body.casts and body.place.tolist() == [[1.0, 1.0, 0.0]]


def test_both_painters_show_the_same_picture():
    from PyQt5.QtGui import QImage, QPainter
    from PyQt5.QtWidgets import QApplication

    from mrs_simulator.rqt_plugin.view.painting import paint

    app = QApplication.instance() or QApplication([])
    obstacles = (Box("box", 1.0, 1.5, 0.3, 1.0, 0.5, 0.4), Cylinder("post", -1.0, 1.0, 0.2, 1.0))
    trails = (np.array([(-1.0, -1.0, 0.0), (0.0, 0.0, 0.0)]), np.zeros((0, 3)))
    team = scene([(0, 0, 0.5), (1, 0, 2.0)], ["pioneer3dx", "husky"], obstacles=obstacles)
    team = team._replace(trails=trails, targets=np.ones((2, 3)), edges=[(0, 1, 1.0)])
    picture = drawn(team, framed(team, Camera(), WIDTH, HEIGHT), WIDTH, HEIGHT, DARK)
    image = QImage(WIDTH, HEIGHT, QImage.Format_RGB888)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.Antialiasing)
    paint(painter, picture, {})
    painter.end()
    memory = image.constBits()
    memory.setsize(image.byteCount())
    other = np.frombuffer(memory, dtype=np.uint8).reshape(HEIGHT, -1)[:, : 3 * WIDTH]
    apart = np.abs(other.reshape(HEIGHT, WIDTH, 3).astype(int) - pixels(picture))
    assert (apart.max(axis=2) > 40).mean() < 0.03 and app is not None


def test_a_cross_marks_each_target_but_below_a_robot_that_is_there():
    team = scene([(-1, 0, 0), (1, 0, 0)])._replace(
        targets=np.array([(-1.0, 0.05, 0.0), (1.0, 1.0, 0.0)])
    )
    without = drawn(team._replace(targets=None), ABOVE, WIDTH, HEIGHT)
    for draw in (drawn, drawn_signs):
        with_targets = draw(team, ABOVE, WIDTH, HEIGHT)
        known = [each.segments.tolist() for each in layers(without, Lines)]
        (cross,) = [
            each for each in layers(with_targets, Lines) if each.segments.tolist() not in known
        ]
        scale = View(ABOVE, WIDTH, HEIGHT, LIGHT).scale / ABOVE.distance
        middle = cross.segments.mean(axis=(0, 1)) - (0.5 * WIDTH, 0.5 * HEIGHT)
        assert len(cross.segments) == 2 and np.allclose(middle / scale, (1.0, -1.0), atol=0.1)
