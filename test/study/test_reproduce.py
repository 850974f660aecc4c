import json
import os
import re
import shutil
import subprocess

import pytest

from mrs_simulator.core.compiling import VARIABLE
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.draw.canvas import new_figure, save, settle
from mrs_simulator.study.draw.style import look
from mrs_simulator.study.results import provenance as provenance_file
from mrs_simulator.study.results import reproduce
from mrs_simulator.study.results.provenance import (
    LOCKSTEP,
    ROBOTS,
    provenance,
    read_provenance,
    write_provenance,
)
from mrs_simulator.study.results.report import control_of, read_run, write_report
from mrs_simulator.study.results.reproduce import AGREES, DISAGREES, main
from mrs_simulator.study.results.stamp import digest, stamp_of
from mrs_simulator.study.run.experiment import run_experiment

LAW = """
from helper import GAIN
from mrs_simulator import PioneerControl


class Home(PioneerControl):
    def pointMassLaw(self, hand):
        return -GAIN * hand
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    (folder / "helper.py").write_text("GAIN = 0.5\n")
    (folder / "law.py").write_text(LAW)
    scenario = load_scenario(scenario_path("paper_four"))._replace(
        duration=0.5, path=str(folder / "a.yaml")
    )
    scenario = scenario.with_protocol("law.py:Home")
    run_experiment(scenario, str(folder / "run"), formats=("png",), look=look("column"))
    return folder


@pytest.fixture
def run(made, tmp_path):
    shutil.copytree(str(made), str(tmp_path / "copy"))
    yield tmp_path / "copy" / "run"
    (made / "helper.py").write_text("GAIN = 0.5\n")


def reproduced(path, capsys):
    with pytest.raises(SystemExit) as caught:
        main([str(path)])
    said = capsys.readouterr()
    return caught.value.code, said.out + said.err


def test_a_run_says_how_it_was_made(made):
    found = read_provenance(str(made / "run"))
    assert {path.rpartition("/")[2] for path in found["inputs"]} == {
        "law.py",
        "helper.py",
        "scenario.yaml",
    }
    assert {"run.csv", "trajectories.png"} <= set(found["outputs"])
    assert not {"verdict.json", "run.json"} & set(found["outputs"])
    assert found["look"]["width"] == 3.5 and found["seed"] == 0
    assert found["versions"]["numpy"] and found["processor"]


def test_figures_carry_the_hash_of_their_inputs_wherever_these_lie(made, tmp_path):
    stamp = read_provenance(str(made / "run"))["stamp"]
    assert re.fullmatch("inputs sha256 [0-9a-f]{64}", stamp)
    assert stamp.encode() in (made / "run" / "trajectories.png").read_bytes()
    for name in ("law.py", "helper.py"):
        shutil.copy(str(made / name), str(tmp_path / name))
    scenario = load_scenario(str(made / "run" / "scenario.yaml"))
    control = scenario.control._replace(protocol="law.py:Home")
    moved = scenario._replace(path=str(tmp_path / "a.yaml"), control=control)
    assert stamp_of(moved) == stamp
    assert stamp_of(moved._replace(seed=1)) != stamp
    (tmp_path / "helper.py").write_text("GAIN = 0.75\n")
    assert stamp_of(moved) != stamp


@pytest.mark.parametrize("kind", ["png", "pdf", "svg"])
def test_each_format_carries_it_and_equal_figures_stay_equal_bytes(kind, tmp_path):
    made = []
    for name in ("a", "b"):
        figure = new_figure(2.0, 1.5)
        figure.subplots().plot([0, 1], [0, 1])
        settle(figure)
        path = save(figure, str(tmp_path / "{}.{}".format(name, kind)), "inputs sha256 0123")
        with open(path, "rb") as file:
            made.append(file.read())
    assert made[0] == made[1] and b"inputs sha256 0123" in made[0]


def test_the_same_bytes_are_made_again(run, capsys):
    code, said = reproduced(run / "trajectories.png", capsys)
    assert code == 0 and said == "trajectories.png: the same bytes\n"


def test_what_has_changed_is_named(made, run, capsys):
    (made / "helper.py").write_text("GAIN = 0.75\n")
    code, said = reproduced(run / "run.csv", capsys)
    assert code == 1 and "run.csv: other bytes\n" in said
    assert "changed: {} is another".format(made / "helper.py") in said and "law.py" not in said


def test_of_a_law_that_is_another_it_is_told_by_its_hash_and_whether_the_run_agrees(
    made, run, capsys
):
    helper = made / "helper.py"
    was = read_provenance(str(run))["inputs"][str(helper)]
    helper.write_text("GAIN = 0.5  # 1/s\n")
    now, changed = (
        digest(str(helper)),
        "  changed: {} is another: sha256 {:.12}..., was {:.12}...\n",
    )
    agrees = changed.format(helper, now, was) + AGREES + "\n"
    code, said = reproduced(run / "run.csv", capsys)
    assert (code, said) == (0, "run.csv: the same bytes\n" + agrees)
    code, said = reproduced(run / "trajectories.png", capsys)
    but = "the same bytes but for the hash of all inputs, which it carries\n"
    assert (code, said) == (1, "trajectories.png: " + but + agrees)
    helper.write_text("GAIN = 0.75\n")
    code, said = reproduced(run / "trajectories.png", capsys)
    assert code == 1 and DISAGREES in said and AGREES not in said


def test_an_edited_file_is_distinguished_from_one_made_otherwise(run, capsys):
    (run / "run.csv").write_text("edited")
    code, said = reproduced(run / "run.csv", capsys)
    assert code == 1 and "run.csv: edited since it was made; made again it has its first" in said
    assert "has changed" not in said


@pytest.mark.parametrize("where", ["loose", "packed", "worktree", "detached"])
def test_the_commit_of_a_clone_is_told_however_it_is_checked_out(where, tmp_path, monkeypatch):
    clone = tmp_path / "clone"

    def git(*words, at=clone):
        own = ["git", "-c", "user.name=a", "-c", "user.email=a@b", "-C", str(at), *words]
        return subprocess.run(own, check=True, stdout=subprocess.PIPE).stdout.decode().strip()

    clone.mkdir()
    git("init", "-q")
    git("commit", "-q", "--allow-empty", "-m", "first")
    first = git("rev-parse", "HEAD")
    if where == "packed":
        git("pack-refs", "--all")
    if where == "worktree":
        git("worktree", "add", "-q", "-b", "own/one", "../other")
        clone = tmp_path / "other"
        git("commit", "-q", "--allow-empty", "-m", "second", at=clone)
        first = git("rev-parse", "HEAD", at=clone)
    if where == "detached":
        git("checkout", "-q", "--detach")
    monkeypatch.setattr(provenance_file, "PACKAGE", str(clone / "src" / "mrs_simulator"))
    assert len(first) == 40 and provenance_file.commit() == first
    monkeypatch.setattr(provenance_file, "PACKAGE", str(tmp_path / "lib" / "site-packages" / "own"))
    assert provenance_file.commit() == ""


def test_the_commit_is_that_of_the_clone_whose_modules_run():
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    git = ["git", "-C", root, "rev-parse", "HEAD"]
    head = subprocess.run(git, stdout=subprocess.PIPE).stdout.decode().strip()
    if not head:
        pytest.skip("no clone, or one of another user")
    assert provenance_file.commit() == head


def test_what_no_run_made_is_refused(run, tmp_path, capsys):
    code, said = reproduced(run / "photo.png", capsys)
    assert code == 2 and "not among what the run made" in said
    (tmp_path / "empty").mkdir()
    code, said = reproduced(tmp_path / "empty", capsys)
    assert code == 2 and "empty: wanted a run's directory" in said and "provenance.json" in said
    code, said = reproduced(tmp_path / "gone.png", capsys)
    assert code == 2 and "gone.png: wanted a run's directory, or one of its files" in said
    (run / "provenance.json").write_text(json.dumps({"command": ""}))
    code, said = reproduced(run, capsys)
    assert code == 2 and "no versions" in said


def test_a_run_is_a_crate_that_describes_its_files(run):
    crate = json.loads((run / "ro-crate-metadata.json").read_text())
    assert crate["@context"] == "https://w3id.org/ro/crate/1.1/context"
    graph = {each["@id"]: each for each in crate["@graph"]}
    about, dataset = graph["ro-crate-metadata.json"], graph["./"]
    assert about["conformsTo"]["@id"] == "https://w3id.org/ro/crate/1.1"
    assert all(dataset[key] for key in ("name", "description", "datePublished", "license"))
    assert about["about"] == {"@id": "./"} and dataset["@type"] == "Dataset"
    assert dataset["name"] and dataset["datePublished"][:2] == "20"
    named = {each["@id"] for each in dataset["hasPart"]}
    there = {path.name for path in run.iterdir()}
    assert named == there - {"ro-crate-metadata.json"}
    assert all(graph[name]["contentSize"] == str((run / name).stat().st_size) for name in named)
    action = graph[dataset["mentions"]["@id"]]
    assert action["instrument"]["@id"] in graph and action["object"] == {"@id": "scenario.yaml"}


def write_compiled(run, value):
    path = run / "provenance.json"
    found = json.loads(path.read_text())
    assert "compiled" in found
    found.pop("compiled") if value == "absent" else found.update(compiled=value)
    path.write_text(json.dumps(found))


@pytest.mark.parametrize(
    "was, now, wanted", [(None, "1", None), ("0", "1", "0"), ("1", None, "1"), ("absent", "0", "0")]
)
def test_it_is_run_again_compiled_or_not_as_it_was(was, now, wanted, run, monkeypatch, capsys):
    write_compiled(run, was)
    monkeypatch.delenv(VARIABLE, raising=False)
    if now is not None:
        monkeypatch.setenv(VARIABLE, now)
    seen = []
    monkeypatch.setattr(
        reproduce, "run_experiment", lambda *_, **__: seen.append(os.environ.get(VARIABLE))
    )
    assert reproduced(run / "run.csv", capsys)[0] == 1  # nothing was made
    assert seen == [wanted] and os.environ.get(VARIABLE) == now


def test_a_run_says_whether_it_was_compiled(run, tmp_path, monkeypatch):
    scenario = load_scenario(str(run / "scenario.yaml"))
    for said in ("0", "1"):
        monkeypatch.setenv(VARIABLE, said)
        assert provenance(scenario, str(run), look("column"))["compiled"] == said


def test_what_is_no_text_is_refused(run, capsys):
    write_compiled(run, 1)
    code, said = reproduced(run / "run.csv", capsys)
    assert code == 2 and "compiled: 1, wanted a text" in said


def test_what_robots_did_is_not_run_again_but_its_figures_are_made_of_it(run, capsys):
    given = (run / "run.csv").read_text()
    rows = given.replace(",10.0,-5.0", ",11.0,-5.0", 1)  # robot 1's point is elsewhere
    (run / "run.csv").write_text(rows)
    recorded = read_run(str(run))
    write_report(recorded, str(run), ("png",), control_of(recorded), look("column"))
    write_provenance(recorded.scenario, str(run), look("column"), ROBOTS)
    code, said = reproduced(run, capsys)
    assert code == 0 and said.startswith("recorded of robots in time: run.csv stays as it is")
    assert said.count("the same bytes") == len(read_provenance(str(run))["outputs"]) > 3
    (run / "run.csv").write_text(rows.replace(",11.0,-5.0", ",12.0,-5.0", 1))
    code, said = reproduced(run, capsys)
    assert code == 1 and "run.csv: other bytes, and the file was edited" in said
    assert "trajectories.png: other bytes" in said and "changed: run.csv is another" in said


def test_what_acts_over_ros_alone_is_named_where_bytes_differ(run, capsys):
    (run / "run.csv").write_text("otherwise")
    write_provenance(load_scenario(run / "scenario.yaml"), str(run), look("column"), LOCKSTEP)
    code, said = reproduced(run / "run.csv", capsys)
    assert code == 1 and "run.csv: other bytes" in said
    assert "over ROS alone: a driver's preset" in said and "nothing" not in said


@pytest.mark.parametrize("preset", ["rosaria", "none"])
def test_the_preset_of_a_stage_is_named_with_the_launch_that_makes_its_run_again(
    preset, run, capsys
):
    (run / "run.csv").write_text("otherwise")
    told = look("column"), LOCKSTEP
    write_provenance(load_scenario(run / "scenario.yaml"), str(run), *told, preset=preset)
    code, said = reproduced(run / "run.csv", capsys)
    assert code == 1 and "nothing" not in said and "a driver's preset" not in said
    assert ("with the preset rosaria: run again without ROS" in said) == (preset == "rosaria")
    assert ("made with the preset rosaria, which" in said) == (preset == "rosaria")
    given = "scenario:={} {}lockstep:=true speed:=0"
    own = "preset:=rosaria " if preset == "rosaria" else ""
    assert given.format(run / "scenario.yaml", own) in said


def test_all_runs_of_a_study_are_run_again(made, tmp_path, capsys):
    study, scenario = tmp_path / "study", load_scenario(str(made / "run" / "scenario.yaml"))
    for out in (study / "run", study / "gains" / "other"):
        run_experiment(scenario, str(out), formats=())
    code, said = reproduced(study, capsys)
    assert code == 0 and said.count("run.csv: the same bytes") == 2
    assert said.splitlines()[-1] == "2 of 2 runs: the same bytes"
    (study / "gains" / "other" / "scenario.yaml").write_text("robots: -1\n")
    code, said = reproduced(study, capsys)
    assert code == 2 and "poses: nothing given" in said and "1 of 2 runs: the same bytes" in said
