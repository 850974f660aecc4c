"""What the GUI reads back of results: a file that is not as it should be gives one clear line."""

import json
import os

import pytest

from mrs_simulator.rqt_plugin.run.preflight_run import read_findings
from mrs_simulator.verdict.verdict_file import read_verdict

CHECK = {"name": "spread", "predicted": 1.0, "measured": 1.0, "tolerance": 0.1, "passed": True}
VERDICT = {"passed": True, "checks": [CHECK]}


def written(path, content):
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return str(path)


def test_a_verdict_of_an_earlier_version_is_read_with_what_it_lacks(tmp_path):
    verdict = read_verdict(written(tmp_path / "verdict.json", VERDICT))
    assert verdict["checks"] == [dict(CHECK, difference=None, note="", question="theorem")]
    assert verdict["schema"] == 1
    assert verdict["title"] == "" and verdict["warnings"] == [] and verdict["min_distance"] is None


@pytest.mark.parametrize(
    "content, told",
    [
        ("", "Expecting value"),
        ("[" * 100000, "too deep"),
        ('{"passed": NaN}', "NaN, wanted a finite number"),
        ([1, 2], "wanted a verdict"),
        (dict(VERDICT, passed="yes"), "passed: 'yes', wanted true or false"),
        (dict(VERDICT, outcome="good"), "outcome: 'good', wanted one of passed, failed"),
        (dict(VERDICT, checks=["spread"]), "checks: 'spread', wanted a list of mappings"),
        (dict(VERDICT, checks=[dict(CHECK, passed=1)]), "check 1 ('spread'): passed: 1"),
        (dict(VERDICT, checks=[{"name": "spread"}]), "passed: nothing given, wanted true"),
        (dict(VERDICT, checks=[{"passed": True}]), "check 1: name: nothing given, wanted a text"),
        (
            dict(VERDICT, checks=[dict(CHECK, question="why")]),
            "question: 'why', wanted one of theorem",
        ),
        (dict(VERDICT, final_gaps=["far"]), "final_gaps: 'far', wanted a list of numbers"),
        (dict(VERDICT, warnings="none"), "warnings: 'none', wanted a list of texts"),
        (dict(VERDICT, min_distance="near"), "min_distance: 'near', wanted a number"),
    ],
)
def test_what_is_no_verdict_is_refused_with_the_place_that_is_wrong(tmp_path, content, told):
    with pytest.raises(ValueError) as caught:
        read_verdict(written(tmp_path / "verdict.json", content))
    assert told in str(caught.value)


def test_checks_of_earlier_versions_get_the_question_that_they_answer(tmp_path):
    names = {
        "gain above 0": "theorem",
        "commands off the published law [-]": "law",
        "energy off its predicted change [-]": "law",
        "largest distance from the exact solution [m]": "robots",
        "least distance of two robots [m]": "robots",
        "collisions": "robots",
        "ended": "robots",
    }
    checks = [dict(CHECK, name=name) for name in names]
    verdict = read_verdict(written(tmp_path / "verdict.json", dict(VERDICT, checks=checks)))
    assert {check["name"]: check["question"] for check in verdict["checks"]} == names


def test_a_pipe_is_no_verdict(tmp_path):
    os.mkfifo(str(tmp_path / "verdict.json"))
    with pytest.raises(OSError, match="pipe"):
        read_verdict(str(tmp_path / "verdict.json"))


@pytest.mark.parametrize(
    "content, told",
    [
        ("{", "Expecting"),
        ({}, "wanted a list of checks"),
        ([3], "check 1: 3, wanted a mapping"),
        ([{"what": "odometry"}], "check 1: passed: nothing given, wanted true or false"),
        ([{"passed": False, "value": 3}], "check 1: value: 3, wanted a text"),
        ([{"passed": False, "robots": "robot1"}], "check 1: unknown"),
    ],
)
def test_what_the_check_of_robots_has_not_written_is_refused(tmp_path, content, told):
    with pytest.raises(ValueError) as caught:
        read_findings(written(tmp_path / "preflight.json", content))
    assert told in str(caught.value)


def test_the_findings_are_those_checks_that_did_not_pass(tmp_path):
    row = {"robot": "robot1", "what": "odometry", "value": "none", "wanted": "some"}
    rows = [dict(row, passed=True, judged=False), dict(row, passed=False, judged=True)]
    passed, (finding,) = read_findings(written(tmp_path / "preflight.json", rows))
    assert passed == 1 and finding == ("robot1", "odometry", "none", "some", True)
