"""Figures drawn by processes of their own."""

import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from mrs_simulator import load_scenario, run_experiment
from mrs_simulator.record.recording import Recorder
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.draw import figure_process, figures
from mrs_simulator.study.draw.style import MISSING
from mrs_simulator.study.run.command import main

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAPER = os.path.join(ROOT, "scenarios", "paper.yaml")
PROGRAM = """
import os, sys
os.sched_getaffinity = lambda process: {0, 1}
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.run.command import main
main(sys.argv[1:])
"""
TELLING = """
import os, sys
fork = os.fork
def told():
    print("forked", "numpy" in sys.modules, flush=True)
    return fork()
os.fork, os.sched_getaffinity = told, lambda process: {0, 1}
from mrs_simulator.__main__ import main
main(sys.argv[1:])
"""


@pytest.mark.parametrize(
    "name, count",
    [pytest.param("paper", 5, marks=pytest.mark.release), ("crazyflies_bearings", 7)],
)
def test_what_draws_apart_loads_at_once_and_draws_as_here(tmp_path, monkeypatch, name, count):
    apart, here = tmp_path / "apart", tmp_path / "here"
    scenario = os.path.join(ROOT, "scenarios", name + ".yaml")
    command = [sys.executable, "-c", TELLING, "experiment", scenario, "--duration", "1"]
    command += ["--formats", "png", "--out", str(apart)]
    done = subprocess.run(command, stdout=subprocess.PIPE, timeout=120)
    assert done.returncode in (0, 1)
    # What draws begins to load before numpy does; and its twin once matplotlib is loaded.
    assert done.stdout.decode().splitlines().count("forked False") == 1
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0})  # draws here
    run_experiment(load_scenario(scenario).changed(duration=1.0), str(here), formats=("png",))
    drawn = sorted(p.name for p in apart.iterdir() if p.suffix == ".png")
    assert len(drawn) == count
    for name in drawn:
        assert (apart / name).read_bytes() == (here / name).read_bytes(), name


class Waited(Exception):
    """Figures were waited for."""


@pytest.mark.parametrize("cores", [{0, 1}, {0}])
def test_the_verdict_is_printed_before_figures_are_waited_for(monkeypatch, capfd, tmp_path, cores):
    def wait(*arguments):
        assert (tmp_path / "verdict.json").exists()
        raise Waited(capfd.readouterr().out)

    monkeypatch.setattr(os, "sched_getaffinity", lambda process: cores)
    monkeypatch.setattr(figure_process.Drawing, "finish", wait)  # by processes apart
    # By the program itself: on one core, or where it has other threads, as the tests' own may have.
    monkeypatch.setattr(figures, "figures", wait)
    monkeypatch.setattr(figures, "warm_up", lambda formats: None)
    with pytest.raises(Waited, match="NOT JUDGED"):
        main([PAPER, "--out", str(tmp_path), "--duration", "0.1", "--formats", "png"])


def test_what_a_drawing_raises_is_raised_here(monkeypatch, tmp_path):
    def fail(run, *options):
        raise OSError(28, "No space left on device", run.pose.shape)

    monkeypatch.setattr(figures, "figures", fail)
    drawing = figure_process.Drawing()
    drawing.warm_up(("png",))
    assert not drawing.is_able
    recorder = Recorder(str(tmp_path / "run.csv"), (1, 2), kept=3, memory=drawing.memory)
    drawing.begin(recorder)
    for stamp in (0.0, 0.1, 0.2):  # seen there as well
        recorder.sample(stamp, StateTable(pose=np.zeros((2, 3)), command=np.zeros((2, 2))))
    assert drawing.is_able
    recorder.close()
    drawing.figures(recorder.run(), str(tmp_path))
    with pytest.raises(OSError, match="(3, 2, 3)"):
        drawing.finish()
    drawing.close()
    with pytest.raises(ChildProcessError):
        os.waitpid(drawing._process, 0)


def test_a_process_that_cannot_draw_is_reported(monkeypatch, tmp_path):
    def missing(formats):
        raise ImportError("no matplotlib")

    monkeypatch.setattr(figures, "warm_up", missing)
    drawing = figure_process.Drawing()
    drawing.warm_up(("png",))
    memory = drawing.memory
    with Recorder(str(tmp_path / "run.csv"), (1,), kept=1, memory=memory) as recorder:
        recorder.sample(0.0, StateTable(pose=np.zeros((1, 3)), command=np.zeros((1, 2))))
    drawing.begin(recorder)
    drawing.figures(recorder.run(), str(tmp_path))  # the run is judged all the same
    with pytest.raises(ChildProcessError, match="ended before it had drawn"):
        drawing.finish()
    drawing.close()


def without_matplotlib(command, *arguments):
    """Run a ``command`` of the package where matplotlib is not installed."""
    program = "import os, sys\nsys.modules['matplotlib'] = None\n" + PROGRAM.replace(
        "study.run.command", "__main__"
    )
    whole = [sys.executable, "-c", program, command, *map(str, arguments)]
    return subprocess.run(whole, stderr=subprocess.PIPE, timeout=120, text=True)


def test_without_matplotlib_a_run_and_its_verdict_are_kept(tmp_path):
    done = without_matplotlib("experiment", PAPER, "--out", tmp_path, "--duration", "1")
    assert done.returncode == 0 and done.stderr == MISSING + "\n"
    assert {"run.csv", "run.json", "verdict.json"} <= {path.name for path in tmp_path.iterdir()}
    done = without_matplotlib("figure", tmp_path, "--out", tmp_path / "figure.png")
    assert done.returncode == 2 and done.stderr == "figure: {}\n".format(MISSING)


def test_without_matplotlib_a_sweep_has_its_table(tmp_path):
    arguments = "control.rate=20", "--out", tmp_path, "--duration", "1", "--jobs", "1"
    done = without_matplotlib("sweep", PAPER, *arguments)
    assert MISSING in done.stderr and "Traceback" not in done.stderr
    assert done.returncode == 0 and (tmp_path / "sweep.csv").exists()


def test_nothing_is_forked_without_formats_or_on_one_core(monkeypatch):
    monkeypatch.setattr(figure_process, "Drawing", None)
    with figure_process.drawing(()) as apart:
        assert apart is None
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0})
    with figure_process.drawing(("png",)) as apart:
        assert apart is None
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 1})
    monkeypatch.setattr(sys, "platform", "darwin")
    with figure_process.drawing(("png",)) as apart:
        assert apart is None


def test_a_run_that_never_begins_waits_for_no_drawing(monkeypatch):
    monkeypatch.setattr(figures, "warm_up", lambda formats: time.sleep(1000.0))
    with pytest.raises(ValueError, match="no such scenario"), figure_process.drawing(("png",)):
        raise ValueError("no such scenario")


def test_what_runs_is_loaded_beside_what_draws():
    code = """
import sys
import mrs_simulator.study.run.command
heavy = "mrs_simulator.study.run.experiment", "mrs_simulator.world.world", "matplotlib", "pybullet"
print([name for name in heavy if name in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, timeout=60)
    assert done.stdout.decode().strip() == "[]"


@pytest.fixture
def two_cores(monkeypatch):
    monkeypatch.setattr(figure_process, "cores", lambda: 2)
    monkeypatch.setattr(threading, "active_count", lambda: 1)
    monkeypatch.setattr(figures, "warm_up", lambda formats: None)


def has_ended(drawing):
    with pytest.raises(ChildProcessError):
        os.waitpid(drawing._process, os.WNOHANG)
    return True


def test_what_was_begun_ahead_draws_and_ends(two_cores):
    with figure_process.ahead([PAPER, "--out", "here"]):
        (begun,) = figure_process._begun
        with figure_process.drawing(("png",)) as first:
            assert first is begun
            with figure_process.drawing(("png",)) as second:
                assert second is not begun
        assert has_ended(first) and has_ended(second)


@pytest.mark.parametrize("formats", [None, ()])
def test_what_was_begun_ahead_and_draws_nothing_ends_with_the_command(two_cores, formats):
    with pytest.raises(SystemExit), figure_process.ahead([PAPER, "--out", "here"]):
        (begun,) = figure_process._begun
        if formats is not None:
            with figure_process.drawing(formats) as apart:
                assert apart is None
        raise SystemExit(2)
    assert has_ended(begun) and not figure_process._begun


@pytest.mark.parametrize("other", ["--help", "--sweep=seed=0..3", "--sweep"])
def test_nothing_is_begun_ahead_where_no_run_is_drawn(two_cores, other):
    with figure_process.ahead([PAPER, other]):
        assert not figure_process._begun
