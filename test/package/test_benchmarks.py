"""The history of benchmarks: what is kept, and how figures of other times are compared."""

import os
import subprocess

import pytest
from documentation import loaded


@pytest.fixture
def history(monkeypatch):
    found = loaded("benchmarks", "history")
    monkeypatch.delenv(found.OVERRIDE, raising=False)
    return found


def noted(history, monkeypatch, capsys, path, speed, value, unit, keep=True):
    monkeypatch.setattr(history, "reference", lambda: speed)
    monkeypatch.setattr(history, "others_load", lambda: 0.0)
    report = history.Report("made up", keep, path)
    assert report.note("case", 7, value, unit) == value
    report.close()
    return capsys.readouterr().out.splitlines()[-1].split("  ")[-1].strip()


@pytest.mark.parametrize(
    "unit, value, said",
    [
        ("x real time", 50.0, "x 1.00"),  # half as fast on a machine half as fast
        ("x real time", 30.0, "x 1.67 WORSE"),
        ("s", 200.0, "x 1.00"),
        ("s", 100.0, "x 0.50 better"),
        ("bytes", 100.0, "x 1.00"),
    ],
)
def test_figures_are_compared_as_multiples_of_the_reference(
    history, monkeypatch, capsys, tmp_path, unit, value, said
):
    path = str(tmp_path / "history.csv")
    first = noted(history, monkeypatch, capsys, path, 1000.0, 100.0, unit)
    assert first.endswith("-")
    again = noted(history, monkeypatch, capsys, path, 500.0, value, unit)
    assert again.endswith(said)
    rows = history.read(path)
    assert [float(row["value"]) for row in rows] == [100.0, value]
    assert tuple(rows[0]) == history.COLUMNS


def test_nothing_is_kept_unless_wanted_nor_compared_with_another_machine(
    history, monkeypatch, capsys, tmp_path
):
    path = str(tmp_path / "history.csv")
    noted(history, monkeypatch, capsys, path, 1000.0, 1.0, "s", keep=False)
    assert not os.path.exists(path)
    noted(history, monkeypatch, capsys, path, 1000.0, 1.0, "s")
    monkeypatch.setattr(history, "cpu_model", lambda: "another")
    assert noted(history, monkeypatch, capsys, path, 1000.0, 9.0, "s").endswith("-")


def test_figures_of_a_busy_machine_are_not_kept(history, monkeypatch, capsys, tmp_path):
    path = str(tmp_path / "history.csv")
    monkeypatch.setenv(history.OVERRIDE, "9")
    noted(history, monkeypatch, capsys, path, 1000.0, 1.0, "s", keep=False)
    with pytest.raises(SystemExit, match="figures of a busy machine are not kept"):
        noted(history, monkeypatch, capsys, path, 1000.0, 1.0, "s")
    assert not os.path.exists(path)


def test_a_unit_of_unknown_direction_is_refused(history):
    with pytest.raises(ValueError, match="unit 'miles': wanted one of"):
        history.slowness(1.0, "miles", 1.0)


def test_the_kept_history_can_be_read(history):
    for row in history.read():
        history.slowness(float(row["value"]), row["unit"], float(row["reference"]))


def test_a_busy_machine_is_refused_unless_that_is_said(history, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(history, "reference", lambda: 1000.0)
    monkeypatch.setattr(history, "others_load", lambda: 0.4)
    with pytest.raises(SystemExit, match="0.40 cores are in use by others, wanted at most 0.3"):
        history.Report("made up", path=str(tmp_path / "history.csv"))
    monkeypatch.setenv(history.OVERRIDE, "2")
    history.Report("made up", path=str(tmp_path / "history.csv"))
    assert "load 0.40 ({}=2)".format(history.OVERRIDE) in capsys.readouterr().out
    for wrong, said in (("nan", "wanted at most nan"), ("much", "wanted a number of cores")):
        monkeypatch.setenv(history.OVERRIDE, wrong)
        with pytest.raises(SystemExit, match=said):
            history.Report("made up", path=str(tmp_path / "history.csv"))


def test_the_load_is_what_other_programs_use(history, monkeypatch):
    """As /proc/stat counts: user, nice, system, idle, waiting, interrupts, stolen."""
    used = iter([10.0, 10.5])
    monkeypatch.setattr(history, "_used", lambda: next(used))
    monkeypatch.setattr(history.time, "sleep", lambda seconds: None)
    assert history.others_load(2.0) == 0.25


def test_the_commit_is_that_of_the_code_whatever_was_kept_since(history, monkeypatch, tmp_path):
    def git(*words):
        who = "-c", "user.name=me", "-c", "user.email=me@example.org"
        subprocess.run(
            ("git", "-C", str(tmp_path), *who, *words), check=True, stdout=subprocess.DEVNULL
        )

    kept, code = tmp_path / "benchmarks" / "history.csv", tmp_path / "law.py"
    kept.parent.mkdir()
    for path in (kept, code):
        path.write_text("first\n")
    git("init", "-q")
    git("add", ".")
    git("commit", "-qm", "first")
    monkeypatch.setattr(history, "ROOT", str(tmp_path))
    monkeypatch.setattr(history, "PATH", str(kept))
    clean = history.commit()
    kept.write_text("second\n")
    assert history.commit() == clean and not clean.endswith("+")
    code.write_text("second\n")
    assert history.commit() == clean + "+"
