"""Terms over edges in compiled loops: numpy's results, from the same functions."""

import os
import subprocess
import sys
import types

import numpy as np
import pytest

from mrs_simulator.control.safety import compiled_filter
from mrs_simulator.core import compiled_terms, compiling, edge_terms
from mrs_simulator.core.compiled_terms import digest
from mrs_simulator.core.compiling import jit
from mrs_simulator.core.edge_terms import apart, inner, unit
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.neighbours import close_pairs
from mrs_simulator.protocols.consensus import equations as consensus_equations
from mrs_simulator.protocols.flocking import equations as flocking_equations
from mrs_simulator.protocols.formation import equations as formation_equations
from mrs_simulator.protocols.gathering import equations as gathering
from mrs_simulator.protocols.shapes import equations as formations
from mrs_simulator.vehicles import compiled_courses
from mrs_simulator.vehicles.drives import compiled_flight
from mrs_simulator.world.motion import compiled_rolling

EXACT, LIBM = 0.0, 1e-12  # [-] of the largest value, where the C library has a say
DIMENSIONS = (2, 3)


@pytest.fixture(autouse=True)
def plain_sums(monkeypatch):
    """Let ``edge_terms`` sum by numpy, whatever the environment says: loops are compared with it."""
    monkeypatch.setenv(compiling.VARIABLE, "0")
    edge_terms.compiled.cache_clear()
    yield
    edge_terms.compiled.cache_clear()


def same(function):
    return function


def case(name, dimension):
    """Return the term called ``name``, whether it is of pairs, rows, points and what else it takes."""
    points = np.random.default_rng(0).uniform(-3.0, 3.0, (9, dimension))
    arcs = Topology.random(9, 0.5, 2).arcs
    pairs, lattice = close_pairs(points, 4.0), flocking_equations.Lattice(2.0, 4.0)
    wanted = apart(points**2, arcs)
    return {
        "weighted": (edge_terms.weighted, False, arcs, (arcs[2],)),
        "spring": (formations.spring, False, arcs, (arcs[2], inner(wanted, wanted))),
        "off_bearing": (formations.off_bearing, False, arcs, (arcs[2], unit(wanted))),
        "beside_bearing": (formations.beside_bearing, False, arcs, (arcs[2], unit(wanted))),
        "tension": (gathering.tension, True, pairs, (20.0,)),
        "repulsion": (flocking_equations.repulsion, True, pairs, ()),
        "alpha": (flocking_equations.alpha, True, pairs, (apart(points**2, pairs), lattice, 0.7)),
    }[name] + (points,)


NAMES = ["weighted", "spring", "off_bearing", "beside_bearing", "tension", "repulsion", "alpha"]


def compare(name, dimension, compile_, compile_kept, allowed):
    term, both, rows, given, points = case(name, dimension)
    loops = compiled_terms.of_pairs if both else compiled_terms.of_edges
    kernel = compiled_terms.kernel(term, loops, compile_, compile_kept)
    found = kernel(points, rows[0], rows[1], *given)
    by_numpy = (edge_terms.pair_sum if both else edge_terms.edge_sum)(term, rows, points, *given)
    np.testing.assert_allclose(found, by_numpy, rtol=0.0, atol=allowed * np.abs(by_numpy).max())


@pytest.mark.parametrize("dimension", DIMENSIONS)
@pytest.mark.parametrize("name", NAMES)
def test_the_loops_give_numpys_bits(name, dimension):
    compare(name, dimension, same, same, EXACT)


@pytest.mark.release  # compiling takes long
@pytest.mark.parametrize("name", ["alpha", "off_bearing"])  # which call most of what there is
def test_the_compiled_loops_do(name):
    pytest.importorskip("numba")
    compare(name, 2, jit(), jit(cache=True), LIBM if name == "alpha" else EXACT)


def by_all(compile_, compile_kept):
    draw = np.random.default_rng(0)
    points, values = draw.uniform(-3.0, 3.0, (9, 3)), draw.normal(size=(9, 3))
    loops, given = compiled_terms.of_all, (0.4, 1.5, 1.0 / 9.0)
    kernel = compiled_terms.kernel(flocking_equations.influence, loops, compile_, compile_kept)
    by_numpy = edge_terms.weighted_differences(flocking_equations.influence, points, values, *given)
    np.testing.assert_allclose(kernel(points, values, *given), by_numpy, rtol=0.0, atol=1e-12)


def test_the_loops_over_all_robots():
    by_all(same, same)


@pytest.mark.release  # compiling takes long
def test_the_compiled_loops_over_all_robots():
    pytest.importorskip("numba")
    by_all(jit(), jit(cache=True))


def test_what_is_kept_is_known_by_what_it_computes():
    def doubled(apart):
        return 2.0 * apart

    def tripled(apart):
        return 3.0 * apart

    def by_helper(apart):
        return inner(apart, apart) * apart

    assert compiled_terms.digest(doubled) == compiled_terms.digest(doubled)
    known = {compiled_terms.digest(each) for each in (doubled, tripled, by_helper)}
    assert len(known) == 3
    before = compiled_terms.digest(flocking_equations.alpha)
    flocking_equations.EPSILON, kept = 0.2, flocking_equations.EPSILON
    try:
        assert compiled_terms.digest(flocking_equations.alpha) != before
    finally:
        flocking_equations.EPSILON = kept


@pytest.mark.parametrize(
    "made, plain",
    [
        (compiled_rolling.kernels, compiled_rolling.plain_loops),
        (compiled_flight.compiled_loops, compiled_flight.plain_loops),
        (compiled_filter.compiled_loops, compiled_filter.plain_loops),
        (compiled_courses.compiled_courses, compiled_courses.plain_courses),
    ],
)
def test_loops_are_kept_by_what_they_and_their_helpers_compute(made, plain):
    pytest.importorskip("numba")
    kept = [loop.py_func.__name__ for loop in made.__wrapped__()]
    names = [loop.__name__ for loop in plain()]
    assert kept == ["{}_{}".format(*each) for each in zip(names, map(digest, plain()))]


def test_a_constant_of_another_file_is_part_of_what_is_kept(monkeypatch):
    before = digest(compiled_rolling.roll_all)
    monkeypatch.setattr(compiled_rolling, "TINY", 2.0 * compiled_rolling.TINY)
    assert digest(compiled_rolling.roll_all) != before


def test_a_term_has_one_law_which_is_compiled_once():
    law = compiled_terms.flow_law(edge_terms.weighted)
    assert compiled_terms.flow_law(edge_terms.weighted) is law
    assert compiled_terms.flow_law(formations.spring) is not law


def test_constants_of_every_kind_are_part_of_what_is_kept():
    def digest(constant, default=1.0):
        def law(apart, gain=default):
            return gain * GAINS * apart  # noqa: F821

        law.__globals__["GAINS"] = constant
        return compiled_terms.digest(law)

    big = np.zeros(2000)
    other = big.copy()
    other[1000] = 1.0
    values = [
        1.0,
        2.0,
        True,
        (1.0, 2.0),
        (1.0, 3.0),
        big,
        other,
        big.reshape(2, -1),
        "a",
        np.float32(1),
    ]
    try:
        assert len({digest(value) for value in values}) == len(values)
        assert digest(big) == digest(big.copy()) and digest(1.0) != digest(1.0, default=2.0)
    finally:
        globals().pop("GAINS", None)

    def held(gain):
        return lambda apart: gain * apart

    def by_module(apart):
        return flocking_equations.EPSILON * apart

    assert compiled_terms.digest(held(1.0)) != compiled_terms.digest(held(2.0))
    before = compiled_terms.digest(by_module)
    flocking_equations.EPSILON, kept = 0.2, flocking_equations.EPSILON
    try:
        assert compiled_terms.digest(by_module) != before
    finally:
        flocking_equations.EPSILON = kept


NESTED = """
def twice(value):
    return 2.0 * value

def term(apart, shape=("a", "b")):
    share = lambda value: {} * twice(value)
    return share(sum([SCALE * each for each in (1.0, 2.0)])) * apart * (shape[0] in {{"a", "b", "c"}})
"""


def nested(constant=1.0, scale=2.0):
    space = {"SCALE": scale}
    exec(NESTED.format(constant), space)
    return space["term"]


def test_lambdas_and_comprehensions_are_known_by_what_they_compute():
    known = [compiled_terms.digest(nested(*each)) for each in ((), (3.0,), (1.0, 5.0))]
    assert len(set(known)) == 3 and known[0] == compiled_terms.digest(nested())
    program = "import test_compiled_terms as t; print(t.compiled_terms.digest(t.nested()), end='')"
    for seed in ("1", "2"):  # of the order of sets
        path = os.pathsep.join(
            [os.path.dirname(os.path.dirname(os.path.abspath(__file__))), *sys.path]
        )
        environment = dict(os.environ, PYTHONHASHSEED=seed, PYTHONPATH=path)
        said = subprocess.run(
            [sys.executable, "-c", program], env=environment, stdout=subprocess.PIPE, timeout=60
        )
        assert said.stdout.decode() == known[0]
    kept = []
    linked = compiled_terms.linked(nested(), lambda function: kept.append(function) or function)
    assert [each.__name__ for each in kept] == ["twice", "term"]  # what a lambda calls, too
    assert linked(1.0) == nested()(1.0) == 12.0


def test_what_was_used_longest_ago_is_removed(tmp_path):
    def compiled(name):
        stats = types.SimpleNamespace(cache_path=str(tmp_path))
        return types.SimpleNamespace(stats=stats, __name__=name)

    names = ["of_edges_term_{:012x}".format(i) for i in range(5)]
    for age, name in enumerate(names):
        for ending in ("nbi", "1.nbc", "2.nbc"):
            path = tmp_path / "compiled_terms.{}-112.py311.{}".format(name, ending)
            path.write_text("")
            os.utime(str(path), (1e9 + age, 1e9 + age))
    for other in ("world.carry-7.py311.nbi", "world.cpython-311.pyc"):
        (tmp_path / other).write_text("")
    compiling.bound_kept(compiled(names[0]), 5)
    assert len(list(tmp_path.iterdir())) == 17
    compiling.bound_kept(compiled(names[1]), 3)  # the first and the second were used after the rest
    left = {path.name.partition("-")[0] for path in tmp_path.iterdir()}
    assert left == {"compiled_terms." + names[i] for i in (0, 1, 4)} | {
        "world.carry",
        "world.cpython",
    }
    compiling.bound_kept(compiled("new"), 0)
    assert len(list(tmp_path.iterdir())) == 2
    compiling.bound_kept(lambda: None)  # of what is not kept


def test_the_environment_asks_for_them(monkeypatch):
    monkeypatch.setattr(compiled_terms, "jit", lambda **options: same)
    monkeypatch.setenv("MRS_SIMULATOR_COMPILED", "1")
    edge_terms.compiled.cache_clear()
    compiled_terms._kernel.cache_clear()
    try:
        assert edge_terms.compiled() is compiled_terms
        points, graph = np.arange(18.0).reshape(9, 2) ** 1.5, Topology.random(9, 0.5, 2)
        found = consensus_equations.consensus(points, graph)
        np.testing.assert_allclose(found, -graph.laplacian() @ points, atol=1e-12 * points.max())
        wanted = formation_equations.target_errors(points, np.zeros_like(points), graph)
        mean = points - graph.neighbour_mean(points)
        np.testing.assert_allclose(wanted, mean, atol=1e-12 * points.max())
        pulled = gathering.rendezvous_flow(1.0, np.array([[0, 1], [1, 2]]), 400.0).velocity(points)
        assert np.abs(pulled.sum(axis=0)).max() < 1e-12
    finally:
        edge_terms.compiled.cache_clear()
        compiled_terms._kernel.cache_clear()
    monkeypatch.setenv("MRS_SIMULATOR_COMPILED", "0")
    assert edge_terms.compiled() is None
    edge_terms.compiled.cache_clear()


def test_what_gives_the_same_bits_is_used_from_when_it_pays(monkeypatch):
    monkeypatch.delenv("MRS_SIMULATOR_COMPILED", raising=False)
    monkeypatch.setattr(compiling, "_asked", {})

    def missing():
        raise compiling.NotInstalled("numba is not installed")

    def asked(compiled):
        return [compiling.same_bits(compiled, 2) for _ in range(4)]

    monkeypatch.setattr(compiling, "_is_loaded", lambda: False)
    loop = "loop".upper
    assert asked(loop) == [None, None, "LOOP", "LOOP"] and asked(missing) == [None] * 4
    sized, soon = "sized".upper, "soon".upper
    given = [compiling.same_bits(sized, 20, size=9) for _ in range(4)]
    assert given == [None, None, "SIZED", "SIZED"]
    monkeypatch.setattr(compiling, "_is_loaded", lambda: True)
    given = [compiling.same_bits(soon, 20) for _ in range(4)]
    assert given == [None, None, "SOON", "SOON"]
    monkeypatch.setenv("MRS_SIMULATOR_COMPILED", "0")
    assert asked(loop) == [None] * 4
    monkeypatch.setenv("MRS_SIMULATOR_COMPILED", "1")
    with pytest.raises(compiling.NotInstalled):
        asked(missing)


def test_without_numba_they_are_refused(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)
    compiled_terms._kernel.cache_clear()
    with pytest.raises(ValueError, match="MRS_SIMULATOR_COMPILED=1: numba is not installed"):
        compiled_terms.edge_sum(edge_terms.weighted, Topology(2, [(1, 2)]).arcs, np.eye(2), 1.0)


def test_the_entry_of_a_kernel_returns_what_it_does_for_arguments_of_the_same_types():
    def scaled(tables, by):
        return tables[0].sum() * by, len(tables[1])

    kernel = jit()(scaled)
    entry = compiling.entry_of(kernel, ((np.ones((2, 3)), np.arange(3)), 2.0))
    for tables, by in (((np.ones((2, 3)), np.arange(3)), 2.0), ((np.eye(5), np.arange(0)), 0.5)):
        assert entry(tables, by) == kernel(tables, by) == scaled(tables, by)
    assert len(kernel.overloads) == 1 and compiling.entry_of(scaled, ()) is scaled
    with pytest.raises(TypeError):
        entry((np.ones((2, 3), np.float32), np.arange(3)), 2.0)
