"""Three outcomes of a run: passed, failed, and not judged with the reason."""

import csv
import json
import sys

import pytest
from protocol_fixtures import shipped, verdict_of

from mrs_simulator import PioneerControl, make_twist
from mrs_simulator.study.results import report
from mrs_simulator.study.run import command
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.study.run.sweep import make_runs, run_sweep, summary
from mrs_simulator.verdict import verdict as verdicts

NOT_DERIVED = "no linear theory is derived from the law, which depends on headings"
NO_CLAIMS = "the protocol states no claims; " + NOT_DERIVED


class Stand(PioneerControl):
    """Without claims."""

    def calculateControlLaw(self, pos_map):
        return {number: make_twist(0.0, 0.1) for number in pos_map}


def short(**changes):
    return shipped("paper_four", duration=1.0, **changes)


def without_claims(tmp_path, duration):
    """Return the path of a scenario under a protocol of one's own."""
    (tmp_path / "turn.py").write_text(
        "from mrs_simulator import PioneerControl, make_twist\n\n\n"
        "class Turn(PioneerControl):\n"
        "    def calculateControlLaw(self, pos_map):\n"
        "        return {i: make_twist(0.0, 0.1) for i in pos_map}\n"
    )
    path = tmp_path / "scenario.yaml"
    scenario = short().with_protocol(str(tmp_path / "turn.py"))
    path.write_text(scenario.changed(duration=duration).to_yaml())
    return path


def test_a_protocol_without_claims_is_not_judged(tmp_path):
    verdict = run_experiment(short(), str(tmp_path), Stand, formats=())
    assert (verdict["outcome"], verdict["passed"]) == ("not_judged", False)
    assert verdict["reason"] == NO_CLAIMS
    text = verdicts.verdict_text(verdict).splitlines()[0]
    assert text.endswith(": NOT JUDGED ({})".format(NO_CLAIMS))


def test_a_long_text_leaves_the_tables_columns_in_place(tmp_path):
    verdict = run_experiment(short(), str(tmp_path), Stand, formats=())
    ended = next(check for check in verdict["checks"] if check["name"] == "ended")
    ended.update(measured="at 1.00 s the law failed: RuntimeError: gone", passed=False)
    lines = verdicts.verdict_text(verdict).splitlines()
    end = lines[1].index("tolerance") + len("tolerance")
    row = next(line for line in lines if line.startswith("    ended"))
    assert row[:end].split() == ["ended", "complete", "-"]
    assert row[end:] == "  FAILED: at 1.00 s the law failed: RuntimeError: gone"


def test_a_verdict_answers_three_questions_in_turn(tmp_path):
    verdict = verdict_of(short(), tmp_path)
    asked = [check["question"] for check in verdict["checks"]]
    order = ["theorem", "law", "robots"]
    assert verdict["schema"] == 2 and list(dict.fromkeys(asked)) == order
    assert asked == sorted(asked, key=order.index)
    lines = verdicts.verdict_text(verdict).splitlines()
    heads = [line.split(":")[0].strip() for line in lines if line[2:3] != " " and "?" in line]
    assert heads == order


def test_what_goes_wrong_fails_without_claims_too(tmp_path):
    poses = [[0.0, 0.0, 0.0], [0.55, 0.0, 0.0]]

    class Turn(Stand):
        def calculateControlLaw(self, pos_map):
            return {number: make_twist(0.5 * (number == 1), 0.0) for number in pos_map}

    scenario = short(poses=poses, robots=2)
    verdict = run_experiment(scenario, str(tmp_path), Turn, formats=())
    assert verdict["outcome"] == "failed" and verdict["reason"] == ""


def test_the_safety_filter_alone_judges_no_theory(tmp_path):
    control = dict(short().control._asdict(), safety=True)
    verdict = run_experiment(short().changed(control=control), str(tmp_path), Stand, formats=())
    (least,) = [one for one in verdict["checks"] if one["name"].startswith("least distance")]
    assert least["passed"] and verdict["outcome"] == "not_judged"


def test_a_recording_without_commands_is_not_judged(tmp_path):
    verdict_of(short(), tmp_path)
    facts = json.loads((tmp_path / "run.json").read_text())
    (tmp_path / "run.json").write_text(json.dumps(dict(facts, uncommanded=True)))
    run = report.read_run(str(tmp_path / "run.csv"))
    verdict, _ = report.judged(run, report.control_of(run))
    assert verdict["outcome"] == "not_judged" and "the controller did not run" in verdict["reason"]


def test_without_a_protocol_nothing_is_judged(tmp_path):
    verdict_of(short(), tmp_path)
    (tmp_path / "scenario.yaml").unlink()
    verdict, _ = report.judged(report.read_run(str(tmp_path / "run.csv")))
    assert verdict["outcome"] == "not_judged" and "no protocol is known" in verdict["reason"]


@pytest.mark.parametrize(
    "outcome, required, code",
    [("passed", True, 0), ("failed", True, 1), ("not_judged", False, 0), ("not_judged", True, 3)],
)
def test_exit_codes(outcome, required, code):
    assert verdicts.exit_code({"outcome": outcome, "passed": outcome == "passed"}, required) == code


def test_verdicts_of_earlier_versions_are_read():
    assert verdicts.outcome_of({"passed": True}) == "passed"
    assert verdicts.outcome_of({"passed": False}) == "failed"


@pytest.mark.parametrize("options, code", [([], 0), (["--require-verdict"], 3)])
def test_programs_exit_with_it(tmp_path, monkeypatch, capsys, options, code):
    path, options = without_claims(tmp_path, 1.0), [*options, "--formats", ""]
    with pytest.raises(SystemExit) as ended:
        command.main([str(path), "--out", str(tmp_path / "out"), *options])
    assert ended.value.code == code
    with pytest.raises(SystemExit) as ended:
        again = ["--out", str(tmp_path / "again")]
        report.main([str(tmp_path / "out" / "run.csv"), *again, *options])
    assert ended.value.code == code
    arguments = ["verdict", str(tmp_path / "out" / "verdict.json"), *options[:-2]]
    monkeypatch.setattr(sys, "argv", arguments)
    with pytest.raises(SystemExit) as ended:
        verdicts.main()
    assert ended.value.code == code
    assert capsys.readouterr().out.count("NOT JUDGED") == 3


def test_a_sweep_counts_and_lists_what_was_not_judged(tmp_path):
    path = without_claims(tmp_path, 0.2)
    runs = make_runs(str(path), [("seed", [0, 1])])
    found = run_sweep(runs, str(tmp_path / "sweep"), jobs=1)
    lines = summary(found)
    assert lines[0] == "0 of 2 runs passed, 2 not judged"
    assert lines[1] == "  2 x not judged: " + NO_CLAIMS
    with open(str(tmp_path / "sweep" / "sweep.csv")) as file:
        assert [row["outcome"] for row in csv.DictReader(file)] == ["not_judged"] * 2
