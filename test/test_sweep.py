"""Sweeps: axes, one table, one figure, and an interrupted sweep that resumes."""

import csv
import os

import pytest

from mrs_simulator.experiment import main
from mrs_simulator.sweep import SweepError, make_runs, read_axis, run_sweep

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOUR = os.path.join(ROOT, "scenarios", "paper_four.yaml")
K = "control.parameters.k"


@pytest.mark.parametrize(
    "text, expected",
    [
        ("seed=0..3", ("seed", [0, 1, 2, 3])),
        (K + "=0.01, 0.02", (K, [0.01, 0.02])),
        (
            "poses={layout: line},{layout: grid}",
            ("poses", [{"layout": "line"}, {"layout": "grid"}]),
        ),
        ("fidelity=kinematic", ("fidelity", ["kinematic"])),
    ],
)
def test_axes(text, expected):
    assert read_axis(text) == expected


@pytest.mark.parametrize("text", ["seed", "=3", "seed=", "seed=9..2", "k=[1"])
def test_bad_axes_are_refused(text):
    with pytest.raises(SweepError):
        read_axis(text)


def test_an_impossible_combination_is_refused_before_anything_runs():
    with pytest.raises(ValueError, match="duration: -1"):
        make_runs(FOUR, [("duration", [1.0, -1])])
    with pytest.raises(ValueError, match="unknown 'colour'"):
        make_runs(FOUR, [("colour", [1])])


def rows(out):
    with open(os.path.join(out, "sweep.csv"), newline="") as file:
        return list(csv.DictReader(file))


def test_a_sweep_in_parallel_gives_a_table_and_a_figure(tmp_path):
    runs = make_runs(FOUR, [(K, [0.02, 0.05]), ("seed", [0, 1]), ("duration", [80.0])])
    verdicts = run_sweep(runs, str(tmp_path), jobs=2)
    assert [verdict["ended"] for verdict in verdicts] == ["complete"] * 4
    table = rows(str(tmp_path))
    assert [(row[K], row["seed"]) for row in table] == [
        ("0.02", "0"), ("0.02", "1"), ("0.05", "0"), ("0.05", "1")
    ]  # fmt: skip
    assert float(table[0]["settle_time"]) == pytest.approx(35.4, abs=0.2)
    assert float(table[2]["settle_time"]) < float(table[0]["settle_time"])
    assert (tmp_path / "sweep.pdf").exists()


def test_what_was_finished_is_not_run_again(tmp_path):
    runs = make_runs(FOUR, [("seed", [0, 1]), ("duration", [1.0])])
    run_sweep(runs[:1], str(tmp_path), jobs=1)
    done = tmp_path / runs[0][0] / "run.csv"
    stamp = done.stat().st_mtime_ns
    run_sweep(runs, str(tmp_path), jobs=1)
    assert done.stat().st_mtime_ns == stamp
    assert len(rows(str(tmp_path))) == 2


def test_the_command(tmp_path, capsys):
    arguments = [FOUR, "--out", str(tmp_path), "--sweep", "seed=0..1", "--sweep", "duration=1"]
    with pytest.raises(SystemExit) as ended:
        main(arguments + ["--jobs", "2"])
    assert ended.value.code == 1  # too short to form
    assert "0 of 2 runs passed" in capsys.readouterr().out
    with pytest.raises(SystemExit) as ended:
        main(arguments + ["--sweep", "seed=3"])
    assert ended.value.code == 2 and "swept twice" in capsys.readouterr().err
