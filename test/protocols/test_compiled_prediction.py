"""The paper's law looked ahead by a compiled loop: the same bits as by numpy."""

import numpy as np
import pytest

from mrs_simulator.core.graphs import Topology
from mrs_simulator.protocols.formation import equations


@pytest.mark.parametrize("closure, n", [("chain", 5), ("cycle", 4)])
@pytest.mark.parametrize("compiled", [False, True])
def test_the_loop_gives_the_same_bits(closure, n, compiled, monkeypatch):
    if compiled:
        pytest.importorskip("numba")
    loop = equations.compiled_steps() if compiled else equations.looked_up_steps
    draw = np.random.default_rng(n)
    start, steps = np.asfortranarray(draw.normal(size=(n, 2))), np.array([7, 0, 3, 3, 40])
    given = equations.line_offsets(n, 2.0), Topology.preset(closure, n), 0.03
    found = []
    for chosen in (None, loop):
        monkeypatch.setattr(equations, "same_bits", lambda *_, chosen=chosen: chosen)
        found.append(equations.predicted_after(steps, start, *given))
    assert found[0].tobytes() == found[1].tobytes()
    np.testing.assert_array_equal(found[0][1], start)
    np.testing.assert_allclose(found[0][2], equations.predict(start, *given, 3)[-1], rtol=1e-14)


def test_a_sum_over_several_neighbours_is_left_to_numpy(monkeypatch):
    monkeypatch.setattr(equations, "same_bits", lambda *_: pytest.fail("no look-up"))
    track = equations.predicted_after(
        [1], np.eye(3, 2), np.zeros((3, 2)), Topology.preset("path", 3), 0.5
    )
    np.testing.assert_allclose(track[0, 0], [0.5, 0.5])
