"""Random starts inside the theorems' hypotheses: what fails is seen, judged in part or wholly, and kept."""

import json
import os
import sys

import pytest

from mrs_simulator.protocols.consensus.law import Consensus

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "benchmarks"))
import hypotheses  # noqa: E402 (beside the package)

RATE = "decay rate of the disagreement [1/s]"
PARTLY, WHOLLY = 3, hypotheses.WHOLE  # starts judged by the theorem alone, and by the whole verdict


@pytest.mark.parametrize("seed", [PARTLY, WHOLLY])
def test_a_start_inside_the_hypotheses_keeps_all_claims(seed):
    found = hypotheses.run(("consensus", seed))
    assert found["outcome"] == "passed" and not found["failed"] and not found["error"]
    assert found["judged"] == 3 and found["outside"] == []


@pytest.mark.parametrize("seed", [PARTLY, WHOLLY])
def test_a_false_claim_fails(seed, monkeypatch):
    own = Consensus.claims

    def false(control, start):
        claims = own(control, start)
        return [c._replace(predicted=1.03 * c.predicted) if c.name == RATE else c for c in claims]

    monkeypatch.setattr(Consensus, "claims", false)
    assert list(hypotheses.run(("consensus", seed))["failed"]) == [RATE]


def test_a_start_outside_the_hypotheses_is_not_judged():
    found = hypotheses.run(("rendezvous", 0))
    assert found["outside"] == ["gain Tc curvature of the tension < 2"]
    assert found["judged"] == 0 and not found["failed"]


def test_a_campaign_goes_on_where_it_was_and_counts_each_start_once(tmp_path, monkeypatch, capsys):
    path, row = tmp_path / "results.jsonl", {"failed": {}, "error": "", "outcome": "passed"}
    rows = [dict(row, protocol="consensus", seed=k, judged=3, outside=[]) for k in (0, 2, 2)]
    rows.append(dict(row, protocol="consensus", seed=4, judged=0, outside=["spanning tree"]))
    path.write_text("".join(json.dumps(each) + "\n" for each in rows) + '{"cut off')
    left, done = hypotheses.tasks_left(["consensus"], 5, str(path))
    assert left == [("consensus", 1), ("consensus", 3)] and len(done) == 3
    monkeypatch.setattr(sys, "argv", ["hypotheses.py", "--results", str(path), "--table"])
    assert hypotheses.main() == 0
    assert capsys.readouterr().out.splitlines()[-1] == "| `consensus` | 3 | 2 | 2 | 0 |"
    rows[0]["failed"] = {RATE: "false"}
    path.write_text("".join(json.dumps(each) + "\n" for each in rows))
    assert hypotheses.main() == 1


def test_a_rate_is_measured_where_others_no_longer_feed_a_mode_that_a_start_nearly_lacks():
    found = hypotheses.run(("distance_formation", 1112))
    assert (found["failed"], found["outside"], found["judged"]) == ({}, [], 4)
