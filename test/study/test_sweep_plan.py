"""What a sweep foretells before it runs: directories, units, theory's word on each run, its boundary."""

import os

import numpy as np
import pytest

from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.run import command, sweep
from mrs_simulator.study.run.sweep_plan import PLAN, foretold, read_plan, write_plan

GAIN, RATE = "control.parameters.gain", "control.rate"


def planned(name, axes, out):
    path = scenario_path(name)
    runs = sweep.make_runs(path, map(sweep.read_axis, axes))
    write_plan(runs, sweep.theorem_boundary(path), str(out))
    return runs, read_plan(str(out))


def test_the_boundary_is_where_the_held_commands_become_too_large(tmp_path):
    axes = GAIN + "=0.5..8/7", RATE + "=2..20/6"
    runs, plan = planned("consensus", axes, tmp_path)
    step = 2.0 / 4.0  # the largest eigenvalue of a cycle of six is 4
    assert plan["keys"] == [GAIN, RATE] and plan["units"] == {GAIN: "1/s", RATE: "Hz"}
    assert [each["run"] for each in plan["runs"]] == [name for name, _, _ in runs]
    assert plan["values"][RATE] == [2.0, 5.6, 9.2, 12.8, 16.4, 20.0]
    for each in plan["runs"]:
        gain, rate = each["values"][GAIN], each["values"][RATE]
        assert each["holds"] is (gain / rate < step), each
        assert ("gain Tc < 2/lambda_max" in each["why"]) is not each["holds"]
    line = np.concatenate(plan["boundary"]["lines"])
    assert len(line) > 20 and "lambda" in plan["boundary"]["name"]
    steps = np.array([7.5 / 6, 3.6])
    assert (np.abs(line[:, 0] - step * line[:, 1]) < 0.1 * steps[0]).all()  # of a cell
    # from half a step before the first values to half a step behind the last, never to 0 or below
    assert line[:, 0].min() < 0.5 and line.min() > 0.0
    assert (line <= np.array([8.0, 20.0]) + 0.5 * steps + 1e-9).all() and line[:, 0].max() > 8.0


def test_without_a_threshold_the_theorem_s_conditions_decide(tmp_path):
    _, plan = planned("paper_four", ("control.parameters.T=1,4", RATE + "=0.2,20"), tmp_path)
    found = {tuple(each["values"].values()): each for each in plan["runs"]}
    assert found[4, 20]["holds"] is True and found[4, 20]["why"] == ""
    assert plan["boundary"] == {"name": "", "lines": []}
    scenario = load_scenario(scenario_path("consensus"))
    control = scenario.control._replace(protocol="no_such.py")
    refused = foretold(scenario._replace(control=control))
    assert refused["holds"] is None and refused["why"].startswith("refused: ")


def test_no_line_is_drawn_over_one_key_or_over_words(tmp_path):
    assert planned("consensus", (GAIN + "=1,2",), tmp_path)[1]["boundary"]["lines"] == []
    axes = GAIN + "=1,2", "limits=none,top"
    assert planned("consensus", axes, tmp_path)[1]["boundary"]["lines"] == []


def test_a_file_of_something_else_is_no_plan(tmp_path):
    (tmp_path / PLAN).write_text("[1]")
    with pytest.raises(ValueError, match="no plan of a sweep"):
        read_plan(str(tmp_path))


def test_the_command_writes_it_where_it_is_asked_to(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("mrs_simulator.study.draw.sweep_figures.sweep_figure", lambda *_: None)
    words = ["consensus", GAIN + "=0.4,0.5", "--duration", "2", "--jobs", "1"]
    for more, there in (([], False), (["--plan"], True)):
        out = tmp_path / str(there)
        with pytest.raises(SystemExit):
            command.sweep_main([*words, "--out", str(out), *more])
        assert (out / PLAN).exists() is there
    plan = read_plan(str(tmp_path / "True"))
    assert all(os.path.isdir(str(tmp_path / "True" / each["run"])) for each in plan["runs"])
    assert "2 runs" in capsys.readouterr().out
