"""Rays in compiled loops: numpy's results to the bit, from the same operations."""

import collections
import math

import numpy as np
import pytest

from mrs_simulator.core.compiling import jit
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.sensors import scenery
from mrs_simulator.sensors.compiled_rays import ROUGH, bearing_of, cast_by, make_loops, spread_of
from mrs_simulator.sensors.scenery import CarriedRays, Rays, Scenery, cast
from mrs_simulator.sensors.state import State
from mrs_simulator.vehicles import Team


def same(function):
    return function


def scene(seed=0, n=6, k=9):
    draw = np.random.default_rng(seed)
    obstacles = [Box("b{}".format(i), *draw.uniform(-5, 5, 3), 1.5, 0.4, 0.5) for i in range(6)]
    obstacles += [
        Cylinder("c{}".format(i), *draw.uniform(-5, 5, 2), 0.4, 0.1 + i) for i in range(3)
    ]
    poses = draw.uniform(-5.0, 5.0, (n, 3))
    team = Team(("pioneer3dx", "robotino3") * (n // 2))
    angle = poses[:, 2:] + np.append(np.linspace(-1.5, 1.5, k - 1), -poses[0, 2])
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    origin = poses[:, np.newaxis, :2] + draw.normal(0.0, 0.1, (n, k, 2))
    rays = Rays(origin, direction, np.linspace(0.05, 0.3, n), np.arange(n))
    return Scenery(team, obstacles).at(State(0.0, poses, 0.0 * poses)), rays


def compare_rays(loops):
    shapes, rays = scene(k=40)
    others = np.array([1, 2, 3, 4, 5, 0])
    for origin in (rays.origin, rays.origin[:, :1]):
        for cone, unseen in ((0.0, None), (0.0, others), (math.radians(15.0), None)):
            given = rays._replace(origin=origin), 6.0, cone, unseen
            wanted = cast(shapes, *given)
            np.testing.assert_array_equal(cast_by(loops, shapes, *given), wanted)
            assert 0.1 < np.isfinite(wanted).mean() < 1.0
            if unseen is not None:
                assert (wanted != cast(shapes, *given[:3])).any()


def scans(n):
    """Yield shapes, scans of n lasers, and their distances by all rays and all shapes.

    Lasers in any place, also beside, within and behind shapes, and twice around.
    """
    draw, met = np.random.default_rng(4), 0
    for span, k in ((1.0, 90), (6.26, 360), (6.26, 7), (11.0, 50), (1e-3, 40)):
        for size in (0.4, 3.0):
            poses = draw.uniform(-size, size, (n, 3))
            boxes = [Box("b{}".format(i), *draw.uniform(-5, 5, 3), 1.5, 0.4, 0.5) for i in range(5)]
            boxes += [Cylinder("c", 0.5, 0.5, 0.4, 0.5), Box("thin", 2.0, 0.0, 0.0, 9.0, 1e-9, 0.5)]
            boxes += [Cylinder("dot", -1.0, 0.2, 1e-9, 0.5)]
            angle = np.linspace(0.0, span, k) - draw.uniform(0.0, 4.0)
            along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
            team = Team(("pioneer3dx", "robotino3") * (n // 2))
            shapes = Scenery(team, boxes).at(State(0.0, poses, 0.0 * poses))
            place = draw.normal(0.0, 0.3, (1, 2))
            rays = CarriedRays(poses, place, along, np.full(n, 0.2), np.arange(n))
            wanted = cast(shapes, rays, 6.0)
            met += np.isfinite(wanted).sum()
            yield shapes, rays, wanted
            yield shapes, rays._replace(step=span / (k - 1)), wanted
    assert met > 100 * n


def compare_scans(loops, n=60):
    for shapes, rays, wanted in scans(n):
        np.testing.assert_array_equal(cast_by(loops, shapes, rays, 6.0, 0.0, None), wanted)


def compare_echoes(loops):
    """Echoes of transducers all around, of cones from a needle's to nearly half a turn's."""
    draw = np.random.default_rng(5)
    for degrees in (1e-6, 0.1, 15.0, 40.0, 85.0):
        shapes, rays = scene(seed=int(degrees), n=6, k=9)
        poses = draw.uniform(-5.0, 5.0, (6, 3))
        angle = draw.uniform(-3.0, 3.0, 9)
        along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        carried = CarriedRays(poses, draw.normal(0.0, 0.2, (9, 2)), along, *rays[2:])
        for given in (rays, carried):
            wanted = cast(shapes, given, 6.0, math.radians(degrees))
            found = cast_by(loops, shapes, given, 6.0, math.radians(degrees), None)
            np.testing.assert_array_equal(found, wanted)
            assert np.isfinite(wanted).any()


def test_the_loops_give_what_numpy_gives():
    loops = make_loops(same)
    compare_rays(loops)
    compare_scans(loops, n=4)
    compare_echoes(loops)


def test_of_scans_only_rays_are_tried_that_can_meet_a_body(monkeypatch):
    tried, before = collections.Counter(), scenery._to_shapes

    def counted(form, origin, direction, *others):
        tried[scenery.MOST] += direction.shape[0] * direction.shape[1]
        return before(form, origin, direction, *others)

    monkeypatch.setattr(scenery, "_to_shapes", counted)
    for shapes, rays, wanted in scans(20):
        for most in (10**9, 0):
            monkeypatch.setattr(scenery, "MOST", most)
            np.testing.assert_array_equal(cast(shapes, rays, 6.0), wanted)
        monkeypatch.undo()
        monkeypatch.setattr(scenery, "_to_shapes", counted)
    assert 0 < tried[0] < 0.7 * tried[10**9]


@pytest.mark.release  # compiling takes long
def test_compiled_loops_give_what_numpy_gives():
    pytest.importorskip("numba")
    loops = make_loops(jit())
    compare_rays(loops)
    compare_scans(loops)
    compare_echoes(loops)


def test_bearings_and_arc_sines_are_as_near_as_scans_need():
    angles = np.linspace(-math.pi, math.pi, 100001).tolist()
    wrong = [abs(bearing_of(math.cos(angle), math.sin(angle)) - angle) for angle in angles]
    shares = np.linspace(0.0, 1.0, 10001)
    assert 2.0 * max(wrong) < 0.5 * ROUGH
    assert (spread_of(shares) >= np.arcsin(shares) + 0.999 * ROUGH).all()


def test_what_is_compiled_is_found_again_by_other_processes():
    """numba looks for it by the code, and by what closures hold, which is never the same."""
    numba = pytest.importorskip("numba")
    for kernel in make_loops(numba.njit):
        assert kernel.py_func.__closure__ is None
        row = kernel.py_func.__globals__["cast_row"].py_func
        assert row.__globals__["lower"].py_func.__closure__ is None


def test_what_cannot_be_kept_is_compiled_all_the_same():
    pytest.importorskip("numba")
    space = {}
    exec(compile("def more(x):\n    return x + 1.0", "/none such/x.py", "exec"), space)
    assert jit(cache=True)(space["more"])(1.0) == 2.0


def test_the_environment_asks_for_them(monkeypatch):
    shapes, rays = scene(n=2, k=3)
    plain = cast(shapes, rays, 6.0)
    monkeypatch.setenv("MRS_SIMULATOR_COMPILED", "1")
    asked = []
    loops = make_loops(same)
    name = "mrs_simulator.sensors.scenery.compiled_loops"
    monkeypatch.setattr(name, lambda: asked.append(1) or loops)
    np.testing.assert_array_equal(cast(shapes, rays, 6.0), plain)
    assert asked


def test_they_are_used_once_numpy_has_cast_many_rays(monkeypatch):
    """Without a word of the environment, after as many as take about as long as numba to load."""
    monkeypatch.delenv("MRS_SIMULATOR_COMPILED", raising=False)
    shapes, rays = scene(n=2, k=9)
    plain, loops, asked = cast(shapes, rays, 6.0), make_loops(same), []
    name = "mrs_simulator.sensors.scenery.compiled_loops"
    monkeypatch.setattr(name, lambda: asked.append(1) or loops)
    monkeypatch.setattr("mrs_simulator.sensors.scenery.CAST", 0.01)
    for _ in range(3):
        np.testing.assert_array_equal(cast(shapes, rays, 6.0), plain)
    assert asked
