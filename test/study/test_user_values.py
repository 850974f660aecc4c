"""What laws give for a verdict: values of numpy are converted, others named, and runs always reported."""

import json

import numpy as np
import pytest
from protocol_fixtures import shipped

from mrs_simulator import PioneerControl
from mrs_simulator.core.claims import Claim, Condition
from mrs_simulator.core.doc_links import named, with_page
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.study.run.sweep import make_runs, run_sweep
from mrs_simulator.verdict.user_values import claim_of, measures_of, plain, texts_of
from mrs_simulator.verdict.verdict import verdict_text
from mrs_simulator.verdict.verdict_file import read_verdict

GAP = Claim("gap [m]", 0.0, 1e3, lambda run: 0.0)


class Mute(Exception):
    def __str__(self):
        raise RuntimeError("no words")


def mute(*_):
    raise Mute


def verdict_under(tmp_path, **methods):
    """Return the verdict file on a short run of a law with these ``methods``, and its text."""
    methods = {"pointMassLaw": lambda self, hand: 0.0 * hand, **methods}
    law = type("Law", (PioneerControl,), methods)
    verdict = run_experiment(shipped("paper_four", duration=0.1), str(tmp_path), law, formats=())
    return read_verdict(str(tmp_path / "verdict.json")), verdict_text(verdict)


def test_values_of_numpy_become_plain_ones():
    given = {
        "a": np.float32(1.5),
        "b": np.int64(3),
        "c": np.array([[1.0, np.nan], [np.inf, 2.0]]),
        "d": (np.bool_(True), np.str_("x"), None, np.longdouble(0.5), np.array(7)),
        "e": {np.int8(2): float("nan")},
    }
    values, faults = measures_of(given)
    told = [[1.0, None], [None, 2.0]]
    wanted = {"a": 1.5, "b": 3, "c": told, "d": [True, "x", None, 0.5, 7], "e": {"2": None}}
    assert values == wanted and faults == []
    assert json.loads(json.dumps(values, allow_nan=False)) == wanted


def test_what_cannot_be_a_measure_is_named_and_the_others_are_kept():
    endless = []
    endless.append(endless)
    given = {"set": {1}, "endless": endless, "y_spread": "wide", "final_gaps": 3.0, "z": 1j}
    given.update({"outcome": "passed", 4: 1.0, "keys": {(1, 2): 3}, "good": 2.0})
    values, faults = measures_of(given)
    assert values == {"good": 2.0}
    begins = ("'set': set, wanted a number", "'endless'[0]", "'y_spread': 'wide', wanted a number")
    begins += ("'final_gaps': 3.0, wanted a list of numbers", "'z': complex, wanted a number")
    begins += ("'outcome': a name of the verdict's own", "a name of type int", "'keys': a key of")
    assert len(faults) == len(begins) and all(map(str.startswith, faults, begins))
    assert measures_of(None) == ({}, ["returned NoneType, wanted a mapping of values by name"])


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"predicted": np.zeros(2)}, r"Claim 'gap \[m\]': predicted = ndarray, wanted one finite"),
        ({"predicted": float("nan")}, "predicted = nan, wanted one finite number"),
        ({"tolerance": None}, "tolerance = nothing given, wanted one finite number"),
        ({"tolerance": np.float32("inf")}, "tolerance = .*inf.*, wanted one finite number"),
        ({"relation": "equals"}, "relation = 'equals', wanted one of equal, at most, at least"),
        ({"measure": 3.0}, "measure = 3.0, wanted a function of the run"),
        ({"name": 3}, "Claim 3: name = 3, wanted a text"),
        ({"unproved": np.True_}, "unproved = .*True.*, wanted a text"),
        ({"free": np.ones(2)}, "free = ndarray, wanted True or False"),
        ({"place": "home"}, r"place = 'home', wanted points \(4, 2\)"),
    ],
)
def test_a_claim_with_a_wrong_field_is_named(changes, said):
    with pytest.raises((TypeError, ValueError), match=said):
        claim_of(GAP._replace(**changes), (4, 2))


def test_claims_of_numpy_are_judged_as_plain_ones():
    claim = claim_of(GAP._replace(predicted=np.float32(0.5), tolerance=np.array(2)), (4, 2))
    assert (type(claim.predicted), type(claim.tolerance)) == (float, int)
    assert claim_of(Condition("c", np.bool_(False)), (4, 2)).holds is False
    with pytest.raises(TypeError, match="Condition 'c': holds = ndarray, wanted True or False"):
        claim_of(Condition("c", np.array([True, False])), (4, 2))


def test_warnings_are_texts():
    assert texts_of(np.array(["a", "b"]), "f") == ["a", "b"] and texts_of("abc", "f") == ["abc"]
    assert texts_of([np.str_("a"), 3.0], "f") == ["a", "f returned 3.0 among them, wanted texts"]
    assert texts_of(None, "f") == ["f returned nothing given, wanted a list of texts"]


def test_an_error_without_words_is_named():
    assert named(Mute()) == "Mute: its __str__ raised RuntimeError"
    assert with_page(Mute()) == "its __str__ raised RuntimeError"


@pytest.mark.parametrize(
    "methods, said",
    [
        ({"measures": lambda self, run: {"m": {1}}}, "measures() returns"),
        ({"measures": mute}, "(Mute: its __str__ raised RuntimeError)"),
        ({"claims": lambda self, start: [GAP._replace(predicted=start)]}, "claims() returns"),
        ({"claims": lambda self, start: [GAP._replace(measure=mute)]}, "Mute: its __str__ raised"),
        ({"claims": lambda self, start: [GAP._replace(measure=lambda run: 10**400)]}, "Overflow"),
        ({"warnings": lambda self, pose: [3.0]}, "warning: Law.warnings() returned 3.0"),
        ({"warnings": mute}, "warning: Law.warnings() raised Mute: its __str__ raised"),
        ({"pointMassLaw": mute}, "the law failed: Mute: its __str__ raised RuntimeError"),
    ],
)
def test_every_run_is_reported_whatever_its_law_gives(tmp_path, methods, said):
    verdict, text = verdict_under(tmp_path, **methods)
    assert said in text and (verdict["warnings"] or verdict["outcome"] == "failed")


def test_measures_of_numpy_are_in_the_verdict(tmp_path):
    told = {"m": np.float32(1.5), "y_spread": np.float64(2.0), "n": np.nan}
    claim = GAP._replace(measure=lambda run: np.int64(2), tolerance=np.float32(3.0))
    methods = {"measures": lambda self, run: told, "claims": lambda self, start: [claim]}
    verdict, _ = verdict_under(tmp_path, **methods)
    assert (verdict["m"], verdict["y_spread"], verdict["n"]) == (1.5, 2.0, None)
    assert verdict["outcome"] == "passed" and verdict["checks"][0]["measured"] == 2


def test_a_difference_that_overflows_is_written(tmp_path):
    claim = GAP._replace(predicted=-1.7e308, measure=lambda run: 1.7e308)
    verdict, _ = verdict_under(tmp_path, claims=lambda self, start: [claim])
    assert verdict["checks"][0]["difference"] is None and verdict["outcome"] == "failed"
    assert plain({"a": float("inf")}) == {"a": None}


def test_a_sweep_reports_runs_that_raise_without_words(tmp_path):
    law = tmp_path / "law.py"
    law.write_text(
        "from mrs_simulator import PioneerControl\n\n\nclass Mute(Exception):\n"
        "    def __str__(self):\n        raise RuntimeError\n\n\nclass Law(PioneerControl):\n"
        "    def pointMassLaw(self, hand):\n        return 0.0 * hand\n\n"
        "    def points(self, pose):\n        if self.time:\n            raise Mute\n"
        "        return super().points(pose)\n"
    )
    path = tmp_path / "s.yaml"
    path.write_text("poses: [[0, 0, 0]]\nduration: 0.1\ncontrol: {protocol: law.py}\n")
    (verdict,) = run_sweep(make_runs(str(path), [("seed", [1])]), str(tmp_path / "out"), jobs=1)
    assert verdict["ended"]


def test_a_prediction_of_texts_is_named_and_figures_are_drawn(tmp_path):
    def prediction(self, start, time):
        return np.full((len(time), *start.shape), "x")

    methods = {"pointMassLaw": lambda self, hand: 0.0 * hand, "prediction": prediction}
    law, scenario = type("Law", (PioneerControl,), methods), shipped("paper_four", duration=0.1)
    verdict = run_experiment(scenario, str(tmp_path), law, formats=("png",))
    assert "could not convert string to float" in verdict["checks"][0]["note"]
    assert (tmp_path / "trajectories.png").exists()
