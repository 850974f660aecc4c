"""A linear law's theorem, stated by its matrix in one line, on runs of points and against closed forms."""

import numpy as np
import pytest

from mrs_simulator import PioneerControl
from mrs_simulator.core.claims import Claim
from mrs_simulator.core.linear_theorem import linear_theorem
from mrs_simulator.study.run.simulating import simulate

CYCLE = {"preset": "cycle"}
POSES = [[0.0, 0.0, 0.0], [4.0, 0.0, 1.0], [4.0, 3.0, 2.0], [0.0, 4.0, 0.5]]
PLACES = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
START = np.array(POSES)[:, :2]
JORDAN = np.array([[0.2, -0.2], [0.0, 0.2]])
TURN = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])


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


def judged(protocol, **changes):
    scenario = {"poses": POSES, "topology": CYCLE, "duration": 40.0, "limits": "none"}
    return simulate(dict(scenario, fidelity="point_mass", **changes), protocol=protocol).verdict


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


def test_leaders_are_rows_of_zeros_and_their_hull_is_the_limit():
    matrix = np.array([[2.0, -1.0, -1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    limit = linear_theorem(matrix).limit(START[:3])
    np.testing.assert_allclose(limit, [[4.0, 1.5], START[1], START[2]], atol=1e-12)
