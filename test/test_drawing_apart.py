"""Figures drawn by processes of their own."""

import os
import subprocess
import sys

import numpy as np
import pytest

from mrs_simulator import load_scenario, run_experiment
from mrs_simulator.core.recording import Recorder
from mrs_simulator.study import drawing_apart, figures

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PAPER = os.path.join(ROOT, "scenarios", "paper.yaml")
PROGRAM = """
import os, sys
os.sched_getaffinity = lambda process: {0, 1}
from mrs_simulator.study.command import main
main(sys.argv[1:])
"""


def test_figures_drawn_apart_are_those_drawn_here(tmp_path):
    apart, here = tmp_path / "apart", tmp_path / "here"
    command = [sys.executable, "-c", PROGRAM, PAPER, "--out", str(apart), "--duration", "1"]
    command += ["--formats", "png"]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, timeout=120)
    assert done.returncode in (0, 1)
    run_experiment(load_scenario(PAPER).changed(duration=1.0), str(here), formats=("png",))
    drawn = sorted(p.name for p in apart.iterdir() if p.suffix == ".png")
    assert len(drawn) == 5
    for name in drawn:
        assert (apart / name).read_bytes() == (here / name).read_bytes(), name


def test_what_a_drawing_raises_is_raised_here(monkeypatch, tmp_path):
    def fail(run, *options):
        raise OSError(28, "No space left on device", run.pose.shape)

    monkeypatch.setattr(figures, "figures", fail)
    recorder = Recorder(str(tmp_path / "run.csv"), (1, 2), kept=3)
    drawing = drawing_apart.Drawing(("png",))
    assert not drawing.is_able
    drawing.fork(recorder, None)
    for time in (0.0, 0.1, 0.2):  # only now, and seen there all the same
        recorder.sample(time, np.zeros((2, 3)), np.zeros((2, 2)))
    assert drawing.is_able
    recorder.close()
    drawing.figures(recorder.run(), str(tmp_path))
    with pytest.raises(OSError, match="(3, 2, 3)"):
        drawing.finish()
    drawing.close()
    with pytest.raises(ChildProcessError):
        os.waitpid(drawing._process, 0)


def test_a_process_that_cannot_draw_is_told_of(monkeypatch, tmp_path):
    def missing(formats):
        raise ImportError("no matplotlib")

    monkeypatch.setattr(figures, "warm_up", missing)
    with Recorder(str(tmp_path / "run.csv"), (1,), kept=1) as recorder:
        recorder.sample(0.0, np.zeros((1, 3)), np.zeros((1, 2)))
    drawing = drawing_apart.Drawing(("png",))
    drawing.fork(recorder, None)
    with pytest.raises(RuntimeError, match="ended before it had drawn"):
        drawing.figures(recorder.run(), str(tmp_path))
        drawing.finish()
    drawing.close()


def test_nothing_is_forked_without_formats_or_on_one_core(monkeypatch):
    monkeypatch.setattr(drawing_apart, "Drawing", None)
    with drawing_apart.drawing(()) as apart:
        assert apart is None
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0})
    with drawing_apart.drawing(("png",)) as apart:
        assert apart is None
