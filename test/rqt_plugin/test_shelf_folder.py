"""The user's folder of runs: what is listed, marked, deleted and brought back, and what makes room."""

import json
import os
import shutil
import time

import numpy as np
import pytest

from mrs_simulator.rqt_plugin.shelf.comparison import (
    ComparedRun,
    claim_rows,
    parameter_rows,
    told_apart,
)
from mrs_simulator.rqt_plugin.shelf.differences import differing, flat, telling
from mrs_simulator.rqt_plugin.shelf.folder import Shelf
from mrs_simulator.rqt_plugin.shelf.run_list import RunModel
from mrs_simulator.rqt_plugin.shelf.run_row import ENTRY, broken
from mrs_simulator.rqt_plugin.shelf.tracks import tracks_of
from mrs_simulator.rqt_plugin.sweep.cells import SweepCells, read_news

HEAD = "time,robot,x,y,theta,alpha_x,alpha_y,v,omega\n"
SCENARIO = (
    "title: {}\ncontrol:\n  protocol: formation\n  parameters: {{k: {}, T: 0.1}}\nduration: 8.0\n"
)


def make_run(folder, name, when, k=0.02, size=0):
    """Make a run of two robots that go along x, recorded at ``when`` [s] since 1970."""
    path = folder / name
    path.mkdir(parents=True)
    lines = [
        "{0},{1},{2},{1},0,0,0,0,0\n".format(t / 10, i, t * i) for t in range(50) for i in (1, 2)
    ]
    (path / "run.csv").write_text(HEAD + "".join(lines))
    (path / "scenario.yaml").write_text(SCENARIO.format(name, k))
    verdict = {"checks": [], "passed": True, "outcome": "passed", "title": name}
    (path / "verdict.json").write_text(json.dumps(verdict))
    (path / "figure.pdf").write_bytes(b"0" * size)
    for each in (path / "run.csv", path):
        os.utime(str(each), (when, when))
    return str(path)


@pytest.fixture
def shelf(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    return Shelf(str(tmp_path / "home"))


def names(shelf):
    return [entry.name for entry in shelf.scan()]


def test_runs_of_the_folder_of_watched_ones_and_single_ones_are_listed_the_newest_first(
    shelf, tmp_path
):
    own, others = tmp_path / "home" / "runs", tmp_path / "others"
    make_run(own, "first", 1e9)
    make_run(others, "second", 2e9)
    make_run(others, "third", 1.5e9)
    single = make_run(tmp_path / "elsewhere", "fourth", 1.7e9)
    assert shelf.add(str(others)) is None
    assert shelf.add(os.path.join(single, "run.csv")) == single
    assert names(shelf) == ["second", "fourth", "third", "first"]
    entry = shelf.scan()[0]
    assert (entry.protocol, entry.outcome) == ("formation", "passed")
    assert entry.keys["control.parameters.k"] == 0.02
    # Another window knows the same, and a run that is gone is not listed.
    shutil.rmtree(single)
    assert names(Shelf(shelf.home)) == ["second", "third", "first"]
    with pytest.raises(ValueError, match="no run: wanted a folder with a run.csv, or a bag"):
        shelf.add(str(tmp_path / "nothing"))


def test_saved_results_are_listed_too_and_deleted_by_nobody_but_the_user(shelf, tmp_path):
    path = make_run(tmp_path / "mrs_runs", "saved", 1e9)
    assert names(shelf) == ["saved"] and shelf.add(path) == path
    assert not os.path.exists(shelf.home)  # there was nothing to note
    with pytest.raises(ValueError, match="its folder is watched"):
        shelf.delete(path)
    shelf.change(watched=[])
    assert names(shelf) == []


def test_a_copy_is_listed_once_its_original_is_gone_or_it_is_added(shelf, tmp_path):
    original = make_run(tmp_path / "home" / "runs", "run", 1e9)
    copy = make_run(tmp_path / "mrs_runs", "copy", 2e9)
    shelf.note_copy(copy, original)
    assert names(shelf) == ["run"]
    deleted = shelf.delete(original)
    assert names(shelf) == ["copy"]
    shelf.restore(deleted)
    assert names(shelf) == ["run"]
    assert shelf.add(copy) == copy and names(shelf) == ["copy", "run"]


def test_runs_stay_listed_where_another_folder_is_chosen(shelf, tmp_path):
    path = make_run(tmp_path / "home" / "runs", "old", 1e9)
    shelf.keep_in(str(tmp_path))
    new = make_run(tmp_path / "mrs_simulator_runs", "new", 2e9)
    assert names(shelf) == ["new", "old"] and shelf.holds(new) and not shelf.holds(path)
    assert [entry.path for entry in shelf.own(shelf.scan())] == [new]
    assert shelf.new_directory("A b").startswith(os.path.join(shelf.folder, "a_b_"))


def test_marks_are_kept_and_nothing_is_written_to_folders_of_others(shelf, tmp_path):
    path = make_run(tmp_path / "others", "a", 1e9)
    before = sorted(os.listdir(path))
    shelf.add(path)
    shelf.mark(path, name="the good one", note="k halved")
    shelf.mark(path, pinned=True)
    (entry,) = Shelf(shelf.home).scan()
    assert entry.name == "the good one" and entry.marks == ("the good one", "k halved", True)
    assert sorted(os.listdir(path)) == before
    shelf.delete(path)
    assert names(shelf) == [] and os.path.exists(path)


def test_a_deleted_run_comes_back_until_the_window_is_closed(shelf, tmp_path):
    path = make_run(tmp_path / "home" / "runs", "a", 1e9)
    shelf.mark(path, note="kept")
    deleted = shelf.delete(path)
    assert names(shelf) == [] and not os.path.exists(path)
    assert shelf.restore(deleted) == path
    assert shelf.scan()[0].marks.note == "kept"
    shelf.empty([shelf.delete(path)])
    assert names(shelf) == [] and not os.listdir(os.path.join(shelf.folder, ".deleted"))


def test_the_oldest_make_room_but_neither_pinned_ones_nor_the_newest(shelf, tmp_path):
    own = tmp_path / "home" / "runs"
    paths = [make_run(own, name, 1e9 + when, size=10000) for when, name in enumerate("abcde")]
    shelf.mark(paths[0], pinned=True)
    shelf.change(most_bytes=45000)
    assert shelf.make_room([paths[-1]]) == ["b", "c"]
    assert names(shelf) == ["e", "d", "a"]
    shelf.change(most_bytes=1)
    assert shelf.make_room([paths[-1]]) == ["d"]
    assert names(shelf) == ["e", "a"]


def test_what_lies_where_runs_are_kept_is_never_removed(shelf, tmp_path):
    mine = make_run(tmp_path / "mine", "precious", 1e9, size=10000)
    shelf.keep_in(str(tmp_path / "mine"))
    shelf.change(most_bytes=1)
    made = make_run(tmp_path / "mine" / "mrs_simulator_runs", "a", 2e9)
    assert names(shelf) == ["a"] and shelf.make_room() == ["a"]
    assert os.path.exists(mine) and not os.path.exists(made)
    shelf.keep_in(shelf.folder)
    assert shelf.folder == str(tmp_path / "mine" / "mrs_simulator_runs")


def test_what_is_wrong_in_settings_and_runs_is_left_out(shelf, tmp_path):
    path = make_run(tmp_path / "home" / "runs", "a", 1e9)
    for name in ("scenario.yaml", "verdict.json"):
        with open(os.path.join(path, name), "w", encoding="utf-8") as file:
            file.write("{")
    settings = {
        "most_bytes": "many",
        "marks": {path: {"name": 3, "note": "so"}},
        "watched": [str(tmp_path)],
    }
    with open(os.path.join(shelf.home, "shelf.json"), "w", encoding="utf-8") as file:
        json.dump(settings, file)
    (entry,) = shelf.scan()
    assert (entry.name, entry.outcome, entry.marks.note) == ("a", "", "so")
    assert shelf.settings()["most_bytes"] == 2e9


def test_what_differs_between_scenarios_is_named_in_few_words():
    content = {
        "title": "a",
        "control": {"rate": 50.0, "parameters": {"k": 0.5}},
        "poses": [[1.0] * 30],
    }
    other = {"title": "b", "control": {"rate": 20.0, "parameters": {"k": 1.0}}, "seed": 3}
    found = differing((flat(content), flat(other)))
    texts = [each.text for each in found]
    assert texts == ["k 0.5 \u2192 1", "rate 50 \u2192 20", "other poses", "seed \u2013 \u2192 3"]
    assert differing((flat(content), flat(content))) == []
    laws = [
        {"control": {"protocol": law, "parameters": {name: 0.5, "l": 0.1}}, "seed": seed}
        for law, name, seed in (("formation", "k", 0), ("consensus", "gain", 3))
    ]
    found = differing(list(map(flat, laws)))
    assert len(found) == 4
    assert [each.text for each in telling(found)] == [
        "protocol formation \u2192 consensus",
        "seed 0 \u2192 3",
    ]


def test_a_difference_names_the_run_it_is_against_and_a_what_if_the_one_it_begins_as(
    shelf, tmp_path
):
    folder = tmp_path / "home" / "runs"
    paths = [make_run(folder, "run", 1e9, 0.02), make_run(folder, "what_if", 1.1e9, 0.05)]
    paths += [make_run(folder, name, when, 0.05) for name, when in (("a", 1.2e9), ("b", 1.3e9))]
    shelf.note_origin(paths[1], "run", 1e9)
    first, second = (time.strftime("%Y-%m-%d %H:%M", time.localtime(t)) for t in (1e9, 1.2e9))
    runs = RunModel()

    def texts():
        runs.take(shelf.scan())
        return [runs.data(runs.index(row), ENTRY)[1] for row in range(len(runs.entries))]

    against = "k 0.02 \u2192 0.05, against " + first
    assert texts() == ["as " + second, against, "else as run, " + first, ""]
    shelf.delete(paths[2])
    assert texts() == [against, "else as run, " + first, ""]
    make_run(folder / "again", "run", 1.4e9, 0.1)  # of the same title as the first
    shelf.add(str(folder / "again" / "run"))
    assert texts()[0] == "k 0.02 \u2192 0.1, against " + first


def test_runs_of_one_name_are_told_apart_by_what_differs():
    runs = [ComparedRun("line", {"k": k, "T": 0.1, "seed": k}, None) for k in (1.0, 2.0)]
    assert [run.name for run in told_apart(runs)] == ["k 1, seed 1", "k 2, seed 2"]
    assert [run.name for run in told_apart([runs[0], runs[0]])] == ["line", "line (2)"]
    named = [runs[0], runs[1]._replace(name="other")]
    assert told_apart(named) == named
    assert parameter_rows(runs) == [["k", "1", "2"], ["seed", "1", "2"]]


def test_claims_that_turned_out_otherwise_come_first_beside_those_of_the_other_run():
    def check(name, passed, measured):
        return {"name": name, "passed": passed, "predicted": 1.0, "measured": measured}

    first = {"checks": [check("a", True, 1.0), check("b", True, 1.0)]}
    second = {"checks": [check("a", True, 1.1), check("b", False, 9.0), check("c", None, 0.0)]}
    rows = claim_rows([ComparedRun("1", {}, first), ComparedRun("2", {}, second)])
    assert [name for name, _ in rows] == ["b", "c", "a"]
    assert [each and each["measured"] for each in rows[1][1]] == [None, 0.0]
    assert claim_rows([ComparedRun("1", {}, None)] * 2) == []


def test_a_few_positions_of_a_long_run_are_read_with_its_ends(tmp_path):
    path = make_run(tmp_path, "a", 1e9)
    tracks = tracks_of(os.path.join(path, "run.csv"), samples=8)
    assert list(tracks) == [1, 2]
    np.testing.assert_allclose(tracks[2][[0, -1]], [[0.0, 2.0], [98.0, 2.0]])
    assert (np.diff(tracks[1][:, 0]) > 0.0).all() and len(tracks[1]) < 20


def test_what_differs_is_broken_into_two_lines_where_one_is_too_short():
    class Metrics:
        @staticmethod
        def horizontalAdvance(text):
            return 10 * len(text)

    text = "k 0.02 \u2192 0.05, T 0.1 \u2192 0.2, other topology"
    assert broken(text, Metrics, 1000) == [text]
    first, second = broken(text, Metrics, 300)
    assert first == "k 0.02 \u2192 0.05, T 0.1 \u2192 0.2," and second == "other topology"
    assert broken("duration 20 \u2192 40", Metrics, 120) == ["duration 20", "\u2192 40"]
    assert broken("indivisible", Metrics, 50) == ["indivisible"]


def make_sweep(folder, name, when, planned=False):
    """Make a sweep of four runs over k and rate, of which three have ended."""
    path, rows, runs = folder / name, [], []
    for count, (k, rate) in enumerate(((0.5, 10), (0.125, 10), (0.5, 20), (0.125, 20))):
        run, values = "k={}_{}".format(k, count), {KEYS[0]: k, KEYS[1]: rate}
        runs.append({"run": run, "values": values, "holds": True, "why": ""})
        if count < 3:
            make_run(path, run, when, k)
            rows.append("{},{},{},{}\n".format(run, k, rate, "failed" if count else "passed"))
    (path / "sweep.csv").write_text("run,{},{},outcome\n".format(*KEYS) + "".join(rows))
    if planned:
        values = {KEYS[0]: [0.5, 0.125], KEYS[1]: [10, 20]}
        plan = {"keys": KEYS, "units": {}, "values": values, "runs": runs}
        (path / "sweep.json").write_text(json.dumps(plan))
    os.utime(str(path / "sweep.csv"), (when, when))
    return str(path)


KEYS = ["control.parameters.k", "control.rate"]


def test_a_sweep_is_one_line_of_the_list_below_which_its_runs_can_be(shelf, tmp_path):
    make_run(tmp_path / "mrs_runs", "saved", 1e9)
    sweep = make_sweep(tmp_path / "mrs_runs", "swept", 2e9)
    assert names(shelf)[1:] == ["saved"]
    first = shelf.scan()[0]
    assert first.path == sweep and first.sweep == (("k", "rate"), 3, 1)
    listed = shelf.scan({sweep})
    runs = ["k 0.5, rate 10", "k 0.125, rate 10", "k 0.5, rate 20"]
    assert [entry.name for entry in listed[1:]] == [*runs, "saved"]
    assert {entry.within for entry in listed[1:4]} == {sweep} and not listed[4].within
    with pytest.raises(ValueError, match="belongs to a sweep"):
        shelf.delete(listed[1].path)
    elsewhere = make_sweep(tmp_path / "elsewhere", "other", 3e9, planned=True)
    assert shelf.add(elsewhere) == elsewhere and shelf.scan()[0].path == elsewhere
    shelf.delete(elsewhere)
    assert shelf.scan()[0].path == sweep


@pytest.mark.parametrize("planned", [False, True])
def test_the_cells_of_an_earlier_sweep_are_those_of_its_plan_or_of_its_table(tmp_path, planned):
    path = make_sweep(tmp_path, "swept", 1e9, planned)
    plan, verdicts = read_news(path, set(), False)
    cells = SweepCells.of_plan(plan)
    cells.take_verdicts(verdicts)
    assert cells.keys == tuple(KEYS) and cells.values == [[0.125, 0.5], [10, 20]]
    assert cells.cells[0, 1].run == "k=0.5_0" and cells.cells[0, 1].holds == (planned or None)
    assert [cell and cell.outcome for cell in cells.cells.flat][:2] == ["passed", "passed"]
    assert cells.are_known() != planned  # of those that are only planned the table says nothing


@pytest.mark.parametrize(
    "values", [{"a": [1, 2]}, {"a": [1, 2], "b": [1]}, {"a": [1, 2], "b": "xy"}]
)
def test_of_what_is_no_map_it_is_said_over_what_it_is(values):
    with pytest.raises(ValueError, match="a sweep over a.*: wanted two keys of numbers"):
        SweepCells.of_plan({"keys": list(values), "values": values, "units": {}, "runs": []})
