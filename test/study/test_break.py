import functools
import json
import multiprocessing
import os
import re
import sys

import numpy as np
import pytest

from mrs_simulator.core.fields import Parameter
from mrs_simulator.core.graphs import Topology
from mrs_simulator.scenario.reading import ScenarioError, parse_yaml
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.search import search_from
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.run import workers
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.study.search import default_space
from mrs_simulator.study.search.assure_command import main as assure
from mrs_simulator.study.search.break_command import main as break_
from mrs_simulator.study.search.breaking import Search
from mrs_simulator.study.search.default_space import default_search
from mrs_simulator.study.search.margins_command import main as margins
from mrs_simulator.study.search.space import Space, content_with
from mrs_simulator.study.search.trials import of_checks, share_of, try_variation
from mrs_simulator.vehicles.team import Team
from mrs_simulator.verdict.verdict import _compare

# Points with held commands agree for gains below 2/(lambda_max Tc): 10 /s for two, 20/3 for three in a row.
SCENARIO = """
poses: [[0, 0, 0], [3, 0, 0], [1, 2, 0]]
fidelity: point_mass
limits: none
control: {protocol: consensus, rate: 10, saturation: none, parameters: {gain: 1.0}}
topology: {edges: [[1, 2], [2, 3]], directed: false}
duration: 10
step: 0.1
requirements:
  agree: eventually[0, 9] always(distance < 1 m)
search:
  poses: {within: [-3, -3, 3, 3], apart: 1}
  robots: [2, 3]
  control.parameters.gain: [0.2, 12]
"""


@pytest.fixture
def path(tmp_path):
    result = tmp_path / "scenario.yaml"
    result.write_text(SCENARIO)
    return str(result)


def run(command, *arguments):
    with pytest.raises(SystemExit) as caught:
        command([*map(str, arguments), "--jobs", "1"])
    return caught.value.code


@pytest.mark.parametrize("optimiser", ["random", "cma"])
def test_the_threshold_of_held_commands_is_found_without_theory(path, tmp_path, capsys, optimiser):
    out = tmp_path / "out"
    options = "--runs", 60, "--seed", 2, "--optimiser", optimiser, "--formats", ""
    code = run(break_, path, "--out", out, *options)
    assert code == 1
    said = capsys.readouterr().out
    report = json.loads((out / "search.json").read_text())
    ((key, holds, breaks),) = report["thresholds"]
    robots = report["variation"]["robots"]
    theory = {2: 10.0, 3: 20.0 / 3.0}[robots]
    assert key == "control.parameters.gain"
    assert holds < breaks and holds == pytest.approx(theory, rel=0.02)
    assert "found after" in said and "holds at" in said
    (told,) = [line for line in said.splitlines() if "run it again" in line]
    scenario = "experiment {} --out ".format(out / "counterexample.yaml")
    assert scenario in told  # which is wanted
    again = run_experiment(
        load_scenario(str(out / "counterexample.yaml")), str(tmp_path / "again"), formats=()
    )
    kept = json.loads((out / "run" / "verdict.json").read_text())
    assert again["outcome"] == kept["outcome"] == "failed"
    first, second = (d / "run.csv" for d in (out / "run", tmp_path / "again"))
    assert first.read_bytes() == second.read_bytes()


def test_the_optimiser_is_loaded_by_searches_that_come_to_it_alone(
    path, tmp_path, monkeypatch, capsys
):
    out, few = tmp_path / "out", ("--formats", "", "--vary", "control.parameters.gain=[0.2, 0.4]")
    (tmp_path / "cma.py").write_text("raise ImportError('no library')")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "cma", raising=False)
    assert run(break_, path, "--out", out, *few, "--runs", 2) == 0
    assert json.loads((out / "search.json").read_text())["optimiser"] == "cma"
    assert run(break_, path, "--out", out, *few, "--runs", 30) == 2  # twenty are drawn at first
    assert "--optimiser cma: no library" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "cma", None)  # as where it is not installed
    assert run(break_, path, "--out", out, *few, "--runs", 2) == 0
    assert "cma is not installed: runs are drawn at random" in capsys.readouterr().err
    assert run(break_, path, "--out", out, *few, "--optimiser", "cma") == 2
    assert "wanted the Python package cma" in capsys.readouterr().err


@pytest.mark.parametrize(
    "options, message",
    [
        (["--width", "wide"], "width 'wide'"),
        (["--vary", "seed"], "wanted"),
        (["--vary", "control.rate=[1, 2"], "not valid YAML"),
    ],
)
def test_bad_input_is_named_before_anything_runs(path, tmp_path, capsys, options, message):
    assert run(break_, path, "--out", tmp_path / "out", *options) == 2
    said = capsys.readouterr().err
    assert said.startswith("break: ") and message in said and "Traceback" not in said
    assert not (tmp_path / "out").exists()


def test_the_threshold_of_a_delay_is_two_steps_of_the_world_that_follow_each_other(path, tmp_path):
    out = tmp_path / "out"
    vary = "--vary", "mismatch.delay=[0, 0.9]", "--vary", "control.parameters.gain=[2, 2.5]"
    assert run(break_, path, "--out", out, "--optimiser", "random", "--formats", "", *vary) == 1
    thresholds = json.loads((out / "search.json").read_text())["thresholds"]
    holds, breaks = next(pair for key, *pair in thresholds if key == "mismatch.delay")
    step = load_scenario(str(out / "counterexample.yaml")).step
    assert holds / step == pytest.approx(round(holds / step), abs=1e-6)
    assert abs(breaks - holds) == pytest.approx(step, abs=1e-9)


def test_nothing_found_is_no_proof(path, tmp_path, capsys):
    out = tmp_path / "out"
    options = "--vary", "control.parameters.gain=[0.5, 2]", "--optimiser", "random"
    assert run(break_, path, "--out", out, "--runs", 12, *options) == 0
    assert "no proof" in capsys.readouterr().out
    report = json.loads((out / "search.json").read_text())
    assert report["found"] is False and report["runs"] >= 12
    assert not os.path.exists(str(out / "counterexample.yaml"))


@pytest.mark.parametrize(
    "option, value", [("--jobs", -3), ("--jobs", 0), ("--seed", -1), ("--runs", 1)]
)
def test_numbers_that_mean_nothing_are_refused_before_anything_runs(
    option, value, path, tmp_path, capsys
):
    assert run(break_, path, "--out", tmp_path / "out", option, value) == 2
    assert "argument {}: {}: wanted a whole number".format(option, value) in capsys.readouterr().err
    assert not os.path.exists(str(tmp_path / "out"))


def test_what_a_law_prints_is_limited_over_all_runs(path, tmp_path, capfd, monkeypatch):
    # A fork server, which Python 3.14 has by default, prints where its first user did.
    fork = functools.partial(
        workers.ProcessPoolExecutor, mp_context=multiprocessing.get_context("fork")
    )
    monkeypatch.setattr(workers, "ProcessPoolExecutor", fork)
    law = tmp_path / "own.py"
    law.write_text(
        "from mrs_simulator import PioneerControl\n\n\nclass Own(PioneerControl):\n"
        "    def pointMassLaw(self, hand):\n        print('asked')\n        return -2.0 * hand\n"
    )
    text = SCENARIO.replace("consensus", str(law)).replace(", parameters: {gain: 1.0}", "")
    text = text.replace("duration: 10", "duration: 2").replace("[0, 9]", "[0, 1]")
    text = text.replace("  control.parameters.gain: [0.2, 12]\n", "").replace("step: 0.1\n", "")
    with open(path, "w") as file:
        file.write(text)
    searched = ["--runs", 12, "--optimiser", "random"]
    for command, more in ((break_, searched), (margins, ["--along", "control.rate=8"])):
        more = [*more, "--formats", ""]
        assert run(command, path, "--out", tmp_path / command.__module__, *more) in (0, 1)
        said = capfd.readouterr().out
        assert 150 < said.count("asked") < 170 and said.count("[more is not shown]") == 1


def test_the_same_seed_finds_the_same(path, tmp_path):
    options, kept = ("--runs", 20, "--seed", 5, "--optimiser", "random", "--formats", ""), []
    for name in ("a", "b"):
        assert run(break_, path, "--out", tmp_path / name, *options) == 1
        kept.append((tmp_path / name / "search.json").read_bytes())
    assert kept[0] == kept[1]


@pytest.mark.parametrize(
    "key, said",
    [
        ("control.parameters.gian", "search.control.parameters: unknown 'gian'; did you mean 'gain'"),
        ("mismatch.dely", "search.mismatch: unknown 'dely'; did you mean 'delay'"),
        ("sead", "unknown 'sead'; did you mean 'seed'"),
        ("gain", "gain: wanted control.parameters.gain, a parameter of the law"),
        ("events[0].at", "events[0] is no entry of a list"),
    ],
)  # fmt: skip
def test_keys_that_are_none_are_refused_before_anything_runs(path, tmp_path, capsys, key, said):
    assert run(break_, path, "--out", tmp_path / "out", "--vary", key + "=[1, 2]") == 2
    told = capsys.readouterr().err
    assert said in told and "runs" not in told
    assert not (tmp_path / "out").exists()


def test_parameters_of_a_law_that_varies_itself_are_left_to_the_runs(path, tmp_path):
    text = SCENARIO.replace(", parameters: {gain: 1.0}", "")
    with open(path, "w") as file:
        file.write(text.replace("  control.parameters.gain: [0.2, 12]\n", ""))
    laws = "control.protocol={choices: [discrete_consensus, discrete_consensus]}"
    varied = "--vary", laws, "--vary", "control.parameters.eps=[0.1, 0.2]"
    options = "--runs", 2, "--optimiser", "random", "--formats", ""
    assert run(break_, path, "--out", tmp_path / "out", *options, *varied) in (0, 1)


KILLED = """
import os
import re
from mrs_simulator import PioneerControl


class Killed(PioneerControl):
    def pointMassLaw(self, hand):
        if os.path.exists({0!r}):
            os.remove({0!r})
            os.kill(os.getpid(), 9)
        return -2.0 * (hand - hand.mean(axis=0))
"""


def test_a_search_whose_worker_is_killed_finds_the_same(path, tmp_path):
    law, marker = tmp_path / "own.py", tmp_path / "killed"
    law.write_text(KILLED.format(str(marker)))
    text = SCENARIO.replace("consensus", str(law)).replace(", parameters: {gain: 1.0}", "")
    text = text.replace("  control.parameters.gain: [0.2, 12]\n", "").replace(
        "duration: 10", "duration: 2"
    )
    with open(path, "w") as file:
        file.write(text.replace("[0, 9]", "[0, 1]"))
    kept = []
    for name in ("a", "b"):
        options = "--runs", 12, "--seed", 5, "--optimiser", "random", "--formats", ""
        run(break_, path, "--out", tmp_path / name, *options)
        kept.append((tmp_path / name / "search.json").read_bytes())
        assert not marker.exists()
        marker.touch()  # of the second search one process dies
    assert kept[0] == kept[1]


def test_enough_clean_runs_show_a_share_and_one_failure_does_not(path, tmp_path, capsys):
    options = "--vary", "control.parameters.gain=[0.5, 2]", "--at-least", 0.9
    assert run(assure, path, "--out", tmp_path / "out", *options) == 0
    assert (
        "at least 90 % of the runs drawn from this search keep it: 29 of 29"
        in capsys.readouterr().out
    )
    assert run(assure, path, "--out", tmp_path / "out", "--at-least", 0.9) == 1
    assert "not shown" in capsys.readouterr().out
    failed = load_scenario(str(tmp_path / "out" / "failed.yaml"))
    assert failed.control.parameters["gain"] > 20.0 / 3.0 * 0.98


@pytest.mark.parametrize(
    "formulas, why",
    [
        (["always error < 1 m"], "agree left open"),
        (["eventually[50, 60](distance < 1 m)"], "agree left open"),
        (["distance < 9 m", "eventually[50, 60](distance < 1 m)"], "also left open"),
    ],
)
def test_what_a_run_leaves_open_is_neither_assured_nor_has_a_margin(
    path, tmp_path, capsys, formulas, why
):
    text = "\n  also: ".join(formulas)
    text = SCENARIO.replace("eventually[0, 9] always(distance < 1 m)", text)
    with open(path, "w") as file:
        file.write(text.replace("duration: 10", "duration: 1"))
    assert run(assure, path, "--out", tmp_path / "out", "--at-least", 0.5) == 1
    said = capsys.readouterr().out
    assert "not shown" in said and "0 of 1" in said and "({})".format(why) in said
    options = "--along", "mismatch.delay=0.1", "--formats", ""
    if len(formulas) == 1:
        assert run(margins, path, "--out", tmp_path / "margins", *options) == 2
        assert "nothing is judged" in capsys.readouterr().err
        return
    assert run(margins, path, "--out", tmp_path / "margins", *options) == 0
    said = capsys.readouterr().out
    assert "leaves it open: also" in said and "also" not in said.splitlines()[0]


@pytest.mark.parametrize(
    "option, message",
    [
        (("--at-least", "99%"), "99%: wanted a number between 0 and 1"),
        (("--confidence", "1"), "1: wanted a number between 0 and 1"),
        (("--runs", "0"), "0: wanted a whole number of at least 1"),
        (
            ("--at-least", "0.99999999"),
            "299,573,225 runs without a failure, wanted at most 1,000,000",
        ),
    ],
)
def test_shares_and_runs_that_are_none_are_refused(path, tmp_path, capsys, option, message):
    assert run(assure, path, "--out", tmp_path / "out", *option) == 2
    assert message in capsys.readouterr().err


def test_a_search_that_is_left_empty_is_none(path, tmp_path, capsys):
    with open(path, "w") as file:
        file.write(
            SCENARIO[: SCENARIO.index("search:")].replace("duration: 10", "duration: 1")
            + "search:\n"
        )
    assert run(assure, path, "--out", tmp_path / "out") == 2
    assert "nothing varies" in capsys.readouterr().err


def test_evidence_goes_on_after_failures(path, tmp_path):
    options = "--vary", "control.parameters.gain=[0.2, 12]", "--runs", 60, "--at-least", 0.3
    assert run(assure, path, "--out", tmp_path / "out", *options) == 0
    report = json.loads((tmp_path / "out" / "assurance.json").read_text())
    assert report["good"] < report["runs"] <= 60 and report["lower_bound"] >= 0.3


def test_draws_keep_robots_apart_and_within():
    search = search_from(
        {"poses": {"within": [0, 0, 4, 4], "apart": 1.5}, "robots": [2, 4]}, "search"
    )
    space, random = Space(search, 3), np.random.default_rng(0)
    for _ in range(50):
        variation = space.variation(space.draw(random))
        places = np.array(variation["poses"])[:, :2]
        assert len(places) == variation["robots"] in (2, 3, 4)
        assert space.too_near(variation) == 0.0
        assert (places >= 0.0).all() and (places <= 4.0).all()
    crowded = search_from({"poses": {"within": [0, 0, 1, 1], "apart": 2.0}}, "search")
    with pytest.raises(ScenarioError, match="no room for 3 robots 2 m apart"):
        Space(crowded, 3).draw(random)


def test_an_interrupted_search_says_how_far_it_was(path, tmp_path, capsys, monkeypatch):
    def interrupted(search, runs, seed, optimiser):
        search.runs += 20
        raise KeyboardInterrupt

    monkeypatch.setattr(Search, "find", interrupted)
    assert run(break_, path, "--out", tmp_path / "out") == 130
    assert "search: interrupted: none of 21 runs broke a requirement" in capsys.readouterr().err


EDITED = {"edges": {"cut": 2, "add": 1}, "dead": 1}


def test_edges_are_cut_and_added_and_robots_die():
    graph = Topology(3, [(1, 2), (2, 3)], directed=False)
    space, random = Space(search_from(EDITED, "search"), 3, graph), np.random.default_rng(0)
    drawn = [space.variation(space.draw(random)) for _ in range(400)]
    cuts = {str(each["edges"]["cut"]) for each in drawn if "edges" in each}
    assert cuts == {"[]", "[[1, 2]]", "[[2, 3]]", "[[1, 2], [2, 3]]"}
    assert {str(each["edges"]["add"]) for each in drawn if "edges" in each} == {"[]", "[[1, 3]]"}
    assert {str(each.get("dead")) for each in drawn} == {"None", "[1]", "[2]", "[3]"}
    assert any(not each for each in drawn)
    with pytest.raises(ScenarioError, match="no topology whose edges"):
        Space(search_from(EDITED, "search"), 3)


def test_edits_become_a_topology_and_a_mismatch():
    content = {
        "robots": 4,
        "poses": {"layout": "circle", "radius": 3.0},
        "topology": {"preset": "path"},
        "mismatch": {"speed": 0.9},
    }
    edits = {"edges": {"cut": [[2, 3]], "add": [[1, 4]]}, "dead": [4]}
    changed = content_with(content, edits)
    pairs = [each[:2] for each in changed["topology"]["edges"]]
    assert [2, 3] not in pairs and [1, 4] in pairs and len(pairs) == 3
    assert changed["mismatch"]["speed"] == [0.9, 0.9, 0.9, 0.0] and "speed" in content["mismatch"]
    assert scenario_from_dict(changed).topology.n == 4 and content["topology"] == {"preset": "path"}


def test_pushes_are_drawn_and_become_events():
    search = search_from({"pushes": {"most": 2, "within": 0.5, "until": 4}}, "search")
    assert search_from(search.to_plain(), "search") == search
    space, random = Space(search, 3), np.random.default_rng(0)
    drawn = [space.variation(space.draw(random)).get("pushes", []) for _ in range(200)]
    assert {len(each) for each in drawn} == {0, 1, 2}
    pushes = np.array(sum(drawn, []))
    assert set(pushes[:, 1]) == {1, 2, 3} and (np.abs(pushes[:, 2:]) <= 0.5).all()
    assert pushes[:, 0].min() >= 0.0 and 3.5 < pushes[:, 0].max() <= 4.0
    content = {"robots": 2, "poses": {"layout": "circle", "radius": 3.0}}
    changed = content_with(content, {"pushes": [[1.0, 2, 0.1, 0.2], [2.0, 3, 0.1, 0.2]]})
    assert changed["events"] == [{"at": 1.0, "robot": 2, "event": "pushed", "by": [0.1, 0.2]}]
    assert scenario_from_dict(changed).to_dict()["events"] == changed["events"]


@pytest.mark.parametrize(
    "vary, found",
    [
        pytest.param("edges={cut: 2, add: 1}", "edges", marks=pytest.mark.release),
        pytest.param("dead=2", "dead", marks=pytest.mark.release),
        ("pushes={most: 2, within: 3.6, until: 10}", "pushes"),
    ],
)
def test_one_edit_that_breaks_is_found_and_shrunk_to(path, tmp_path, vary, found):
    text = SCENARIO[: SCENARIO.index("search:")].replace("[1, 2, 0]", "[9, 2, 0]")
    with open(path, "w") as file:
        # With a short hand length headings swing, and rounding decides.
        file.write(
            text.replace("point_mass", "kinematic").replace("gain: 1.0", "gain: 1.0, l: 0.5")
        )
    options = "--runs", 30, "--seed", 1, "--optimiser", "random", "--formats", "", "--vary", vary
    assert run(break_, path, "--out", tmp_path / "out", *options) == 1
    report = json.loads((tmp_path / "out" / "search.json").read_text())
    edits = report["variation"][found]
    assert sum(map(len, edits.values())) == 1 if found == "edges" else len(edits) == 1
    if found == "pushes":  # rounded, but not out of what was asked for
        assert max(map(abs, edits[0][2:])) <= 3.6
    assert load_scenario(str(tmp_path / "out" / "counterexample.yaml")).n == 3


@pytest.mark.parametrize(
    "search, message",
    [
        ({"edges": {"cut": 0}}, "wanted cut or add above 0"),
        ({"edges": {"cuts": 1}}, "did you mean 'cut'"),
        ({"dead": -1}, "search.dead: -1, wanted"),
        ({"pushes": {"within": 0, "until": 1}}, "search.pushes.within: 0, wanted"),
        ({"poses": {"within": [1, 0, 0, 1]}}, "wanted x_min, y_min, x_max, y_max"),
        ({"control.rate": 3}, "wanted \\[from, to\\] or"),
        ({"control.rate": [3, 1]}, "wanted two numbers, the second the larger"),
        ({"seed": [0.5, 3]}, "wanted two whole numbers"),
        ({"robots": [2, 5]}, "wanted poses beside it"),
        ({"topology": {"choices": ["path"]}}, "a list of at least two values"),
        ({"topology.edges": {"cut": 2}}, "{'cut': 2}, wanted \\[from, to\\] or"),
        ({"posse": {"within": [-3, -3, 3, 3]}}, "search: unknown 'posse'; did you mean 'poses'"),
        ({"poses": {"within": [0, 0, 1, 1], "aprt": 2}}, "did you mean 'apart'"),
        (
            {"poses": {"within": [0, 0, 1, 1], "headings": [3, 1]}},
            "headings: \\[3.0, 1.0\\], wanted",
        ),
        ([1], "wanted a mapping of ranges by key"),
    ],
)
def test_wrong_searches_are_refused(search, message):
    with pytest.raises(ScenarioError, match=message):
        scenario_from_dict({"poses": [[0, 0, 0]], "search": search})


def test_a_search_is_kept_by_its_scenario(path):
    scenario = load_scenario(path)
    assert scenario_from_dict(scenario.to_dict()).search == scenario.search
    assert scenario.search.robots.high == 3


def test_variations_change_what_they_name_and_nothing_else(path):
    content = {"robots": 3, "topology": {"edges": [[1, 2], [2, 3]]}, "search": {}, "title": "t"}
    changed = content_with(content, {"poses": [[0, 0, 0], [1, 0, 0]], "mismatch.delay": 0.1})
    assert changed["robots"] == 2 and changed["topology"]["edges"] == [[1, 2]]
    assert changed["mismatch"] == {"delay": 0.1} and "search" not in changed
    assert content["robots"] == 3


def test_a_law_that_raises_breaks_the_run_of_every_scenario_alike(path):
    content = {
        "poses": [[0, 0, 0]],
        "requirements": {"slow": "always speed < 1 m/s"},
        "duration": 0.2,
    }
    refused = try_variation(content, path, {"control.rate": -1.0})
    assert np.isinf(refused.value) and "control" in refused.error and "Error" not in refused.error
    kept = try_variation(content, path, {})
    assert not kept.is_broken and kept.value == pytest.approx(1.0)


@pytest.mark.parametrize(
    "change, said",
    [
        (("parameters.gain: [", "parameters.gian: ["), "did you mean 'gain'"),
        (("robots: [2, 3]", "robots: {choices: [2, 3]}"), "search.robots: {"),
    ],
)
def test_a_search_whose_runs_are_all_refused_is_no_search(path, tmp_path, capsys, change, said):
    with open(path) as file:
        text = file.read()
    with open(path, "w") as file:
        file.write(text.replace(*change))
    options = "--runs", 5, "--optimiser", "random", "--formats", ""
    assert run(break_, path, "--out", tmp_path / "out", *options) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    "formula, told",
    [
        ("always error < 1 m", "agree: open (the protocol Consensus wants no place"),
        ("always(each edge(length < 9 m))", "agree: met (there is none of which it speaks)"),
    ],
)
def test_where_nothing_could_be_found_it_is_told_why(path, tmp_path, capsys, formula, told):
    text = SCENARIO.replace("eventually[0, 9] always(distance < 1 m)", formula)
    text = text.replace("edges: [[1, 2], [2, 3]]", "edges: []").replace(
        "duration: 10", "duration: 1"
    )
    with open(path, "w") as file:
        file.write(text)
    options = "--runs", 4, "--optimiser", "random", "--vary", "robots=[2, 4]"
    assert run(break_, path, "--out", tmp_path / "out", *options, "--formats", "") == 0
    said = capsys.readouterr()
    assert "not found" in said.out and "in the scenario as it stands: " + told in said.out


def test_a_scenario_that_breaks_as_it_stands_is_told(path, tmp_path, capsys):
    with open(path, "w") as file:
        file.write(SCENARIO.replace("gain: 1.0", "gain: 6.7"))
    options = "--runs", 4, "--optimiser", "random", "--no-shrink", "--formats", ""
    assert run(break_, path, "--out", tmp_path / "out", *options) == 1
    assert "the scenario is broken as it stands: margin -" in capsys.readouterr().err


def test_progress_says_once_a_batch_how_near_and_in_which_unit(path, tmp_path, capsys):
    out, options = tmp_path / "out", ("--runs", 43, "--optimiser", "random", "--no-shrink")
    run(
        break_,
        path,
        "--out",
        out,
        *options,
        "--vary",
        "control.parameters.gain=[0.2, 4]",
        "--formats",
        "",
    )
    said = [line for line in capsys.readouterr().err.splitlines() if " runs, " in line]
    counts = [line.split()[1] for line in said]
    assert said and len(set(counts)) == len(counts)
    assert all(re.fullmatch(r"search: \d+ runs, margin \S+ m of agree", line) for line in said), (
        said
    )


def test_what_a_claim_has_to_spare_is_said_of_its_tolerance():
    content = {**parse_yaml(SCENARIO, "scenario"), "requirements": {}, "duration": 40}
    text = try_variation(content, "scenario.yaml", {}).text
    assert re.fullmatch(r"margin \+\S+ of the tolerance of .*\[.*\]", text), text


def bound(measured, name):
    """Return the check of a claim of at most 1."""
    check = {"name": name, "note": "at most", "predicted": 1.0, "tolerance": 1e-6}
    return {**check, "difference": measured - 1.0, "passed": measured <= 1.0}


def test_a_claim_that_stays_at_its_bound_hides_no_other_from_a_search():
    far, near = (
        of_checks([bound(0.98, "met at the start"), bound(x, "other")]) for x in (0.4, 0.9)
    )
    assert far.value == near.value == pytest.approx(0.02, abs=1e-5)
    assert far.worst["name"] == near.worst["name"] == "met at the start"
    assert near.objective < far.objective - 0.1
    broken = of_checks([bound(0.98, "met at the start"), bound(1.1, "other")])
    assert broken.is_broken and broken.worst["name"] == "other"
    assert broken.objective < near.objective
    assert of_checks([]).value == 1.0 and not of_checks([]).is_broken


def test_a_scenario_without_a_search_is_searched_within_its_theorem(tmp_path, capsys):
    """Consensus agrees inside its hypotheses; with a wrong sign it does not, and that is found."""
    (tmp_path / "my_wrong.py").write_text(WRONG)
    content = {**parse_yaml(SCENARIO, "scenario"), "requirements": {}, "duration": 20}
    del content["search"]
    for protocol, code in (("consensus", 0), ("my_wrong.py:Wrong", 1)):
        content["control"]["protocol"] = protocol
        given = tmp_path / "given.yaml"
        given.write_text(json.dumps(content))
        options = "--runs", 25, "--optimiser", "random", "--no-shrink", "--formats", ""
        assert run(break_, given, "--out", tmp_path / "out", *options) == code
        said = capsys.readouterr()
        assert "this varies: poses, edges, control.parameters.gain" in said.err
    report = json.loads((tmp_path / "out" / "search.json").read_text())
    assert report["variation"]["control.parameters.gain"] > 3.0, report


WRONG = """
from mrs_simulator.protocols.consensus.law import Consensus


class Wrong(Consensus):
    def pointMassLaw(self, hand):
        return (-1.0 if self.gain > 3.0 else 1.0) * super().pointMassLaw(hand)
"""


def test_default_ranges_keep_to_what_parameters_and_bodies_allow():
    scenario = load_scenario(scenario_path("displacement_formation"))
    found = default_search(scenario)
    x_min, y_min, x_max, y_max = found["poses"]["within"]
    assert (scenario.poses[:, 0] > x_min).all() and (scenario.poses[:, 1] < y_max).all()
    body = Team.from_scenario(scenario).kinds[0].body
    assert found["poses"]["apart"] > 2.0 * max(body.front, body.rear)
    assert search_from(found, "search").poses.within == (x_min, y_min, x_max, y_max)
    spans = {
        "a": (2.0, {}),
        "b": (-1.0, {"high": -0.5}),
        "c": (1.0, {"high": 2.0, "open_high": True}),
    }
    ranges = {
        name: default_space._span(Parameter(name, value, **more), value)
        for name, (value, more) in spans.items()
    }
    assert ranges["a"] == [0.4, 10.0] and ranges["b"] == [-5.0, -0.5]
    assert ranges["c"][0] == 0.2 and 1.9 < ranges["c"][1] < 2.0


@pytest.mark.parametrize(
    "measured, relation, share",
    [(3.0, "at most", 0.7), (12.0, "at most", -0.2), (0.02, "equal", 0.8), (0.3, "equal", -2.0)],
)
def test_a_margin_is_a_share_of_the_tolerance_or_of_a_bound(measured, relation, share):
    bound, tolerance = (10.0, 1e-6) if relation == "at most" else (0.0, 0.1)
    check = _compare("name", bound, measured, tolerance, relation)._asdict()
    assert share_of(check) == pytest.approx(share, rel=1e-5)
