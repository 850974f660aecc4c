"""Rays in compiled loops: numpy's results to the bit, from the same operations."""

import math

import numpy as np
import pytest

from mrs_simulator.core.compiling import jit
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.sensors.compiled_rays import cast_by, make_kernel
from mrs_simulator.sensors.scenery import Rays, Scenery, cast
from mrs_simulator.sensors.state import State
from mrs_simulator.vehicles import Team


def same(function):
    return function


def scene(seed=2, n=6, k=9):
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


def compare(compile_):
    shapes, rays = scene()
    kernel = make_kernel(compile_)
    others = np.array([1, 2, 3, 4, 5, 0])
    for origin in (rays.origin, rays.origin[:, :1]):
        for cone, unseen in ((0.0, None), (0.0, others), (math.radians(15.0), None)):
            given = rays._replace(origin=origin), 6.0, cone, unseen
            wanted = cast(shapes, *given)
            np.testing.assert_array_equal(cast_by(kernel, shapes, *given), wanted)
            assert 0.1 < np.isfinite(wanted).mean() < 1.0


def test_the_loops_give_what_numpy_gives():
    compare(same)


def test_compiled_loops_give_what_numpy_gives():
    pytest.importorskip("numba")
    compare(jit())


def test_what_is_compiled_is_found_again_by_other_processes():
    """numba looks for it by the code, and by what closures hold, which is never the same."""
    numba = pytest.importorskip("numba")
    kernel = make_kernel(numba.njit)
    assert kernel.py_func.__closure__ is None
    assert kernel.py_func.__globals__["meet"].py_func.__closure__ is None


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
    kernel = make_kernel(same)
    name = "mrs_simulator.sensors.compiled_rays.compiled_kernel"
    monkeypatch.setattr(name, lambda: asked.append(1) or kernel)
    np.testing.assert_array_equal(cast(shapes, rays, 6.0), plain)
    assert asked
