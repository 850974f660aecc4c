"""Laws that state nothing, judged by the linear theory that follows from their answers."""

import pytest

from mrs_simulator.study.run.simulating import simulate
from mrs_simulator.verdict.judging import judged
from mrs_simulator.verdict.verdict import exit_code, verdict_text

LAW = """
import numpy as np
from mrs_simulator import PioneerControl, make_twist

class Own(PioneerControl):
    def pointMassLaw(self, hand):
        return {}
"""
CONTENT = {
    "poses": [[0, 0, 0], [6, 0, 0], [1, 5, 0]],
    "topology": {"preset": "path"},
    "fidelity": "point_mass",
    "limits": "none",
    "duration": 15,
    "step": 0.05,
    "control": {"saturation": "none", "rate": 20},
}
AGREE = "-0.4 * self.topology.laplacian() @ hand"
APART = "-0.4 * self.topology.laplacian() @ (hand - [[0, 0], [2, 0], [0, 2]])"


def study(tmp_path, law, **changes):
    path = tmp_path / "own.py"
    path.write_text(law if "class" in law else LAW.format(law))
    content = {**CONTENT, **changes}
    content["control"] = {**CONTENT["control"], **changes.get("control", {}), "protocol": str(path)}
    return simulate(content)


def failed(verdict):
    return [each["name"] for each in verdict["checks"] if each["passed"] is False]


def test_a_law_that_states_nothing_agrees_with_itself_and_never_passes(tmp_path):
    verdict = study(tmp_path, AGREE).verdict
    assert (verdict["outcome"], verdict["passed"]) == ("self_consistent", False)
    assert verdict["derived"] and "derived from the law" in verdict["reason"]
    rate = next(each for each in verdict["checks"] if each["name"].startswith("decay rate"))
    assert rate["passed"] and rate["predicted"] == pytest.approx(0.4, rel=0.02)
    assert (exit_code(verdict), exit_code(verdict, required=True)) == (0, 3)
    text = verdict_text(verdict)
    assert ": SELF-CONSISTENT (by linear theory derived from the law" in text
    assert "commands off the derived law" in text and "published" not in text


def test_on_pioneers_it_is_judged_of_the_rest_after_limits(tmp_path):
    own = {"fidelity": "kinematic", "limits": "firmware", "control": {"saturation": "robot"}}
    verdict = study(tmp_path, APART, **own).verdict
    assert verdict["outcome"] == "self_consistent", verdict_text(verdict)
    assert any("after robot" in each["note"] for each in verdict["checks"])


@pytest.mark.parametrize(
    "changes",
    [
        {"fidelity": "dynamic"},
        {"odometry": "wheel"},
        {"control": {"safety": True, "saturation": "robot"}},
        {"mismatch": {"delay": 0.3}},
        {"model": "youbot"},
        {"model": "crazyflie2", "altitude": 1.0},
    ],
)
def test_correct_runs_on_robots_of_all_sorts_do_not_fail(changes, tmp_path):
    content = {"fidelity": "kinematic", "limits": "firmware", "duration": 16, **changes}
    content.setdefault("control", {"saturation": "robot"})
    verdict = study(tmp_path, APART.replace("2]", "4]").replace("[2, ", "[4, "), **content).verdict
    assert verdict["outcome"] == "self_consistent", verdict_text(verdict)


@pytest.mark.parametrize(
    "law, why",
    [
        ("0.4 * self.topology.laplacian() @ hand", "not all that moves decays"),
        ("-0.4 * np.tanh(hand)", "which is not linear"),
        ("-0.4 * hand * (1.0 + 0.1 * np.sin(self.time))", "which depends on time"),
        ("-0.4 * hand * (np.abs(hand).max() < 8.0)", "which is not linear"),
        ("-0.4 * hand if abs(hand).max() < 9.0 else 1 / 0", "raised ZeroDivisionError"),
        ("0.0 * hand", ""),
        (
            LAW.replace("pointMassLaw(self, hand)", "calculateControlLaw(self, pos_map)").format(
                "{i: make_twist(0.1, 0.0) for i in pos_map}"
            ),
            "which depends on headings",
        ),
    ],
)
def test_what_has_no_linear_theory_is_not_judged_and_says_why(law, why, tmp_path):
    verdict = study(tmp_path, law, duration=1.0).verdict
    assert verdict["outcome"] == "not_judged" and not verdict.get("derived")
    assert (
        verdict["reason"].startswith("the protocol states no claims") and why in verdict["reason"]
    )
    assert why or ";" not in verdict["reason"]


@pytest.mark.parametrize("start", [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0]])
def test_a_law_of_one_velocity_everywhere_has_no_limit(start, tmp_path):
    alone = {"poses": [start], "topology": {"edges": []}, "duration": 20.0}
    verdict = study(tmp_path, "0.0 * hand + [0.3, 0.0]", **alone).verdict
    assert verdict["outcome"] == "not_judged" and not verdict.get("derived"), verdict_text(verdict)


def test_commands_that_are_held_too_long_fail(tmp_path):
    slow = {"rate": 1.0}  # Tc = 1 s, while the largest eigenvalue is 3 /s
    verdict = study(tmp_path, AGREE.replace("0.4", "1.0"), control=slow, step=1.0).verdict
    assert verdict["outcome"] == "failed" and "Tc below its bound [s]" in failed(verdict)
    assert "derived from the law" in verdict["reason"]


def test_a_run_of_another_law_fails(tmp_path):
    run = study(tmp_path, AGREE).run
    (tmp_path / "other").mkdir()
    other = study(tmp_path / "other", AGREE.replace("0.4", "0.42"))
    verdict, _ = judged(run, other._control)
    assert "commands off the derived law [-]" in failed(verdict) and verdict["outcome"] == "failed"


def test_what_the_law_prints_when_it_is_asked_is_not_shown(tmp_path, capfd):
    own = LAW.replace("return", "print('asked')\n        return").format(AGREE)
    assert study(tmp_path, own, duration=20).verdict["outcome"] == "self_consistent"
    assert capfd.readouterr().out.count("asked") in (400, 401)


def test_a_law_that_states_no_claims_on_purpose_is_not_asked(tmp_path):
    stated = LAW + "\n    def claims(self, start):\n        return []\n"
    verdict = study(tmp_path, stated.format(AGREE), duration=1.0).verdict
    assert verdict["reason"] == "the protocol states no claims"


def test_requirements_stand_beside_it(tmp_path):
    kept = {"requirements": {"apart": "always each pair distance < 9 m"}}
    verdict = study(tmp_path, AGREE, **kept).verdict
    assert verdict["outcome"] == "self_consistent" and "1 of 1" in verdict["reason"]
    broken = {"requirements": {"apart": "always each pair distance < 5 m"}}
    assert study(tmp_path, AGREE, **broken).verdict["outcome"] == "failed"
