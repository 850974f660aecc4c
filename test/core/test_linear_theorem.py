"""A linear law's theorem, stated by its matrix in one line, on runs of points and against closed forms."""

import numpy as np
import pytest

from mrs_simulator import PioneerControl
from mrs_simulator.core.claims import Claim
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.linear_theorem import NAMES, Accuracy, Names, linear_theorem
from mrs_simulator.protocols.linear_errors import LinearErrors
from mrs_simulator.study.run.simulating import simulate
from mrs_simulator.verdict.theory import ideal_runs

CYCLE = {"preset": "cycle"}
POSES = [[0.0, 0.0, 0.0], [4.0, 0.0, 1.0], [4.0, 3.0, 2.0], [0.0, 4.0, 0.5]]
PLACES = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
START = np.array(POSES)[:, :2]
JORDAN = np.array([[0.2, -0.2], [0.0, 0.2]])
TURN = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
TURNED = np.kron(0.5 * Topology.preset("cycle", 4).laplacian(), TURN)


class Formation(PioneerControl):
    FACTOR, DRIFT = 1.0, 0.0

    def pointMassLaw(self, hand):
        return self.DRIFT - 0.5 * self.topology.laplacian() @ (hand - PLACES)

    def claims(self, start):
        matrix = self.FACTOR * 0.5 * self.topology.laplacian()
        return linear_theorem(matrix, matrix @ PLACES + self.DRIFT).claims(start, self.period)


class Drifting(Formation):
    DRIFT = np.array([0.1, 0.0])


class Faster(Formation):
    FACTOR = 1.03


class Rotating(PioneerControl):
    def matrix(self):
        return np.kron(0.5 * self.topology.laplacian(), TURN)

    def pointMassLaw(self, hand):
        return -(self.matrix() @ hand.ravel()).reshape(hand.shape)

    def claims(self, start):
        return linear_theorem(self.matrix()).claims(start, self.period)


class Stating(LinearErrors, PioneerControl):
    FACTOR, FAR = 1.0, 0.0

    def pointMassLaw(self, hand):
        return -(TURNED @ (hand - PLACES).ravel()).reshape(hand.shape)

    def error_matrix(self):
        return self.FACTOR * TURNED

    def reference(self, time):
        return PLACES + self.FAR * np.eye(4, 2)


class StatingFaster(Stating):
    FACTOR = 1.03


class StatingElsewhere(Stating):
    FAR = 0.1


def judged(protocol, **changes):
    scenario = {"poses": POSES, "topology": CYCLE, "duration": 24.0, "limits": "none"}
    scenario.update(fidelity="point_mass", control={"rate": 10}, step=0.1)
    return simulate(dict(scenario, **changes), protocol=protocol).verdict


@pytest.mark.parametrize("protocol", [Formation, Drifting, Rotating])
def test_places_drifts_and_rotations_are_stated_in_one_line(protocol):
    verdict = judged(protocol)
    names = [check["name"] for check in verdict["checks"] if check["passed"]]
    assert verdict["outcome"] == "passed", verdict["checks"]
    for name in (
        "distance from the limit [m]",
        "drift of what stays [m]",
        "decay rate of the error [1/s]",
    ):
        assert name in names


def test_a_law_that_states_matrix_and_reference_has_all_of_its_theory(monkeypatch):
    monkeypatch.setattr(ideal_runs, "MOST_COMMANDS", 10000)  # which is enough to tell false ones
    verdict = judged(Stating)
    names = [check["name"] for check in verdict["checks"] if check["passed"]]
    assert verdict["outcome"] == "passed", verdict["checks"]
    assert {*NAMES, "Tc below its bound [s]", "energy off its predicted change [-]"} <= {*names}
    assert judged(StatingFaster)["outcome"] == judged(StatingElsewhere)["outcome"] == "failed"


def test_a_matrix_that_is_3_per_cent_off_fails():
    assert judged(Faster)["outcome"] == "failed"


def test_a_period_beyond_its_bound_fails_the_condition():
    law = linear_theorem(np.diag([1.0, 3.0]))
    found = law.claims(START[:2], 0.7)
    assert [c.holds for c in found] == [True, False, True]
    assert [c.holds for c in law.claims(START[:2], 0.1, delay=0.6)] == [True, True, False]


@pytest.mark.parametrize("basis", [np.eye(2), np.array([[0.6, -0.8], [0.8, 0.6]])])
def test_a_jordan_block_dense_or_not_claims_no_rate(basis):
    found = linear_theorem(basis @ JORDAN @ basis.T).claims(START[:2], 0.1)
    names = [claim.name for claim in found if isinstance(claim, Claim)]
    assert names == ["distance from the limit [m]"]


def test_equal_eigenvalues_are_no_jordan_block():
    """Of a star with two leaders: rounding makes eigenvectors of the same eigenvalue nearly parallel."""
    matrix = 0.37 * Topology.preset("star", 20).laplacian()
    matrix[18:] = 0.0
    order = np.random.default_rng(20).permutation(20)
    assert not linear_theorem(matrix[np.ix_(order, order)]).is_defective
    chain = Topology.preset("chain", 20).laplacian()
    assert linear_theorem(chain[np.ix_(order, order)]).is_defective


def test_leaders_are_rows_of_zeros_and_their_hull_is_the_limit():
    matrix = np.array([[2.0, -1.0, -1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    limit = linear_theorem(matrix).limit(START[:3])
    np.testing.assert_allclose(limit, [[4.0, 1.5], START[1], START[2]], atol=1e-12)


@pytest.mark.parametrize("matrix", [np.zeros((0, 0)), np.zeros((1, 1))])
def test_where_nothing_moves_nothing_bounds_the_period(matrix):
    theorem = linear_theorem(matrix)
    assert not theorem.is_defective
    assert theorem.longest_period == np.inf and theorem.held_rate(0.1) == 0.0


def test_the_rate_of_held_inputs():
    path = linear_theorem(Topology.preset("path", 3).laplacian())
    # Eigenvalues 1 and 3, held for 0.5 s: factors 0.5 and -0.5.
    assert path.held_rate(0.5) == pytest.approx(2.0 * np.log(2.0))
    assert path.held_rate(0.7) < 0.0  # 0.7 * 3 above 2


def test_the_held_rate_with_a_delay_is_that_of_the_longer_state():
    """x+ = x - T M x_late, over x and its d last values."""
    matrix, period, steps = np.array([[1.0, -0.4], [0.9, 0.5]]), 0.1, 3
    shift = np.kron(np.eye(steps + 1, k=-1), np.eye(2))
    shift[:2, :2] += np.eye(2)
    shift[:2, -2:] -= period * matrix
    largest = np.abs(np.linalg.eigvals(shift)).max()
    found = linear_theorem(matrix).held_rate(period, steps)
    assert found == pytest.approx(-np.log(largest) / period)


def test_what_is_asked_for_is_claimed_under_its_name():
    theorem = linear_theorem([[1.0, -1.0], [-1.0, 1.0]])
    accuracy = Accuracy(0.3, 0.2, 0.1)
    found = theorem.consequences(START[:2], 0.1, accuracy, Names("limit", "kept", "rate"))
    assert [claim.name for claim in found] == ["limit", "kept", "rate"]
    assert [claim.tolerance for claim in found] == pytest.approx(
        [0.3, 0.2, 0.1 * theorem.held_rate(0.1)]
    )
    assert theorem.consequences(START[:2], 0.1, accuracy, Names("", "", "")) == []


def test_a_weak_edge_of_an_undirected_graph_joins_all_the_same():
    first, weak = np.array([1.0, -1.0, 0.0]), np.array([0.0, 1.0, -1.0])
    theorem = linear_theorem(np.outer(first, first) + 1e-9 * np.outer(weak, weak))
    assert theorem.zeros == 1 and theorem.rate == pytest.approx(1.5e-9, rel=1e-3)
    np.testing.assert_allclose(theorem.limit(START[:3]), [START[:3].mean(axis=0)] * 3, atol=1e-5)


def test_of_a_defective_zero_nothing_is_claimed():
    theorem = linear_theorem([[0.0, -1.0], [0.0, 0.0]])
    assert not theorem.is_stable and theorem.consequences(START[:2], 0.1) == []
