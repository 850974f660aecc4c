"""What ``analyse`` finds out of laws by asking them, against closed forms."""

import json
import math

import numpy as np
import pytest
from asked_laws import PATH, facts

from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.linear_theorem import linear_theorem
from mrs_simulator.study.analyses.analyse_command import main
from mrs_simulator.study.run.simulating import simulate

CYCLE = Topology(3, [(1, 2), (2, 3), (3, 1)]).laplacian()


def law_of(matrix, constant=0.0):
    return linear_theorem(matrix, np.broadcast_to(constant, len(matrix)))


def test_a_path_of_three_has_what_its_laplacian_gives():
    law = law_of(PATH)
    assert law.eigenvalues == pytest.approx([0.0, 1.0, 3.0], abs=1e-12)
    assert law.rate == pytest.approx(1.0) and law.zeros == 1 and not law.is_defective
    assert law.longest_period == pytest.approx(2.0 / 3.0)
    assert law.longest_delay == pytest.approx(math.pi / 6.0)
    assert law.noise == pytest.approx((0.5 / 1.0 + 0.5 / 3.0) / 3.0)
    assert law.limit([[1.0], [2.0], [6.0]]) == pytest.approx(3.0 * np.ones((3, 1)))


def test_complex_eigenvalues_shorten_period_and_delay():
    law = law_of(CYCLE)  # 0, 1.5 +- i sqrt(3)/2
    assert law.rate == pytest.approx(1.5)
    assert law.longest_period == pytest.approx(1.0)
    assert law.longest_delay == pytest.approx((math.pi / 3.0) / math.sqrt(3.0))


def test_a_jordan_block_has_no_simple_decay():
    law = law_of(np.array([[0.2, -0.2], [0.0, 0.2]]), [0.4, -0.2])
    assert law.is_defective and law.is_stable and law.rate == pytest.approx(0.2)
    assert law.limit([[9.0], [7.0]]) == pytest.approx(np.array([[1.0], [-1.0]]))


def test_what_stays_may_drift_and_what_grows_is_unstable():
    assert law_of(PATH, 0.1).drift == pytest.approx([0.1, 0.1, 0.1])
    assert not law_of(np.diag([1.0, -0.1])).is_stable
    assert not law_of(np.array([[0.0, 1.0], [0.0, 0.0]])).is_stable  # zero, defective: grows with t
    assert law_of(np.diag([1.0, -0.1])).rate is None


@pytest.mark.parametrize("n", [4, 5, 6, 7])
def test_pursuit_at_its_threshold_turns_for_ever_and_has_no_rate(n):
    angle = math.pi / n  # from which on two eigenvalues are imaginary, but for rounding
    turn = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    law = law_of(np.kron(np.eye(n) - np.roll(np.eye(n), 1, axis=1), turn))
    assert not law.is_stable and law.rate is None and law.zeros == 2


# Laws that are asked -------------------------------------------------------------------------------


def test_a_linear_law_is_found_with_its_matrix_and_offset():
    wanted = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    found = facts(lambda hand, *_: -0.5 * PATH @ (hand - wanted))
    assert found.residual < 1e-12 and found.memory == "" and not found.headings
    assert found.translation and not found.rotation and found.gradient
    assert found.matrix == pytest.approx(0.5 * np.kron(PATH, np.eye(2)), abs=1e-9)
    assert found.linear.rate == pytest.approx(0.5)
    limit = found.linear.limit(np.zeros((3, 2)))
    assert limit == pytest.approx(wanted - wanted.mean(axis=0), abs=1e-9)


def test_a_missing_neighbour_shows_in_who_receives_from_whom():
    wrong = PATH.copy()
    wrong[1] = [0.0, 1.0, -1.0]  # robot 2 leaves robot 1 out
    who = np.any(facts(lambda hand, *_: -wrong @ hand).receives, axis=0)
    assert who.tolist() == [[True, True, False], [False, True, True], [False, True, True]]


def test_neighbours_in_range_show_at_their_scale_only():
    def law(hand, *_):
        apart = np.linalg.norm(hand[:, np.newaxis] - hand, axis=2)
        near = (apart < 1.0) * 1.0
        return near @ hand - near.sum(axis=1, keepdims=True) * hand

    counts = [int(who.sum() - np.trace(who)) for who in facts(law).receives]
    assert counts[0] > counts[2]


@pytest.mark.parametrize(
    "law, memory",
    [
        (lambda hand, time, call, theta: -hand + 0.1 * math.sin(time), "time"),
        (lambda hand, time, call, theta: -hand * (1.0 + 0.1 * call), "the states before"),
        (lambda hand, *_: -hand + 0.01 * np.random.default_rng().random(), "chance"),
    ],
)
def test_what_else_a_law_depends_on_is_named(law, memory):
    found = facts(law)
    assert found.memory == memory and found.linear is None


def test_a_law_of_headings_is_no_law_of_points():
    found = facts(lambda hand, time, call, theta: np.stack([np.cos(theta), np.sin(theta)], axis=1))
    assert found.headings and found.linear is None


def test_a_nonlinear_law_is_linearised_where_it_comes_to_rest():
    found = facts(lambda hand, *_: hand - hand**3)  # rests where each coordinate is -1, 0 or 1
    assert found.residual > 1e-3
    assert np.abs(found.equilibrium) == pytest.approx(np.ones((3, 2)), abs=1e-6)
    assert found.linear.eigenvalues == pytest.approx(2.0 * np.ones(6), abs=1e-5)


def test_a_law_that_never_rests_gets_no_theory():
    found = facts(lambda hand, *_: np.tanh(hand) + 1.0)
    assert found.equilibrium is None and found.linear is None


# The command ---------------------------------------------------------------------------------------

LAW = """
import numpy as np
from mrs_simulator import PioneerControl

class Own(PioneerControl):
    def pointMassLaw(self, hand):
        return -0.4 * (self.topology.laplacian() @ hand) + [[0.4, 0.0], [0.0, 0.0], [-0.4, 0.0]]
"""


def run(*arguments):
    with pytest.raises(SystemExit) as caught:
        main(list(map(str, arguments)))
    return caught.value.code


def test_what_a_law_prints_is_limited(tmp_path, capfd):
    path = tmp_path / "own.py"
    path.write_text(LAW.replace("        return", "        print('asked')\n        return"))
    assert run(path, "--robots", 3, "--topology", "path") == 0
    said = capfd.readouterr().out
    assert 150 < said.count("asked") < 170 and said.count("[more is not shown]") == 1


def test_what_is_printed_can_be_stated_as_claims(tmp_path, capsys):
    path = tmp_path / "own.py"
    path.write_text(LAW)
    assert run(path, "--robots", 3, "--topology", "path", "--out", tmp_path) == 0
    said = capsys.readouterr().out
    report = json.loads((tmp_path / "analysis.json").read_text())
    assert report["receives"] == report["declared"] == [[1, 2], [2, 1], [2, 3], [3, 2]]
    assert report["theory"]["rate"] == pytest.approx(0.4) and "0.4 1/s" in said
    lines = said.split("as claims of the law")[1].splitlines()[1:]
    claims = "\n".join(lines[2:])
    path.write_text("\n".join([*lines[:2], LAW, claims, ""]))
    content = {
        "poses": [[0, 0, 0], [6, 0, 0], [1, 5, 0]],
        "topology": {"preset": "path"},
        "fidelity": "point_mass",
        "limits": "none",
        "duration": 15,
        "control": {"protocol": str(path), "rate": 10, "saturation": "none"},
    }
    verdict = simulate(content).verdict
    assert verdict["outcome"] == "passed", verdict
    faster = claims.replace("0.4", "0.44").replace("0.8", "0.88")  # the same limit
    path.write_text(path.read_text().replace(claims, faster))
    assert simulate(content).verdict["outcome"] == "failed"


SAID = {  # what pointMassLaw returns: what must be said of it, and what must not
    "-0.4 * L @ hand + [0.1, 0.0]": ("else ends          each robot at 0.3333 x1 +", ["\n  ends "]),
    "-0.4 * (hand - [1.0, 2.0])": ("from any start at (1, 2), (1, 2), (1, 2)", []),
    "-0.4 * hand": ("from any start at (0, 0), (0, 0), (0, 0)", []),
    "hand.mean(axis=0) - hand": ("slowest decay      1 1/s", ["defective"]),
    "-np.sinh(hand - 1.0)": ("from starts near it at (1, 1), (1, 1), (1, 1)", ["any start"]),
    "-hand**3": ("linear             no", ["equilibria", "any start", "eigenvalues"]),
    "-np.tanh(L @ hand)": ("x3\n  slowest decay      1 1/s", ["moves for ever", "offset"]),
    "[[1, -2, 1], [2, -3, 1], [1, 0, -1]] @ hand": ("each robot at 1.5 x1 - 1 x2 + 0.5 x3", []),
    "-np.sign(np.round(L @ hand))": ("is a gradient      not told", ["gradient      yes"]),
    "np.random.randn() - 0.4 * L @ hand": ("chance", ["used and not declared", "robot1 from"]),
}


@pytest.mark.parametrize("law", SAID)
def test_what_is_said_of_a_law_is_so(law, tmp_path, capsys):
    path, (wanted, unwanted) = tmp_path / "own.py", SAID[law]
    body = "        L = self.topology.laplacian()\n        return " + law
    path.write_text(LAW.split("        return")[0] + body)
    assert run(path, "--robots", 3, "--topology", "path") == 0
    said = capsys.readouterr().out
    assert wanted in said and not any(each in said for each in unwanted), said


@pytest.mark.parametrize(
    "law, message",
    [
        ("no_such_law", "no_such_law"),
        ("wall_following.yaml", "asks for sensors sonar, wanted a law of positions"),
    ],
)
def test_what_cannot_be_asked_is_named(law, message, capsys):
    assert run(law) == 2
    assert message in capsys.readouterr().err


def test_the_shipped_containment_ends_where_its_theorem_says(capsys):
    assert run("containment.yaml") == 0
    said = capsys.readouterr().out
    assert "slowest decay      0.0475736 1/s" in said and "from whom the topology declares" in said


def test_a_law_in_space_is_asked_for_three_coordinates(tmp_path, capsys):
    assert (
        run("consensus", "--robots", 2, "--dimension", 3, "--topology", "path", "--out", tmp_path)
        == 0
    )
    report = json.loads((tmp_path / "analysis.json").read_text())
    assert np.array(report["theory"]["limit"]).shape == (2, 3)
    values = np.array(report["theory"]["eigenvalues"])[:, 0]
    assert values == pytest.approx([0.0] * 3 + [1.0] * 3, abs=1e-9)  # gain 0.5
