"""Samples that are too many for memory, kept in a file that is mapped."""

import os

import numpy as np
import pytest

from mrs_simulator.record import recording
from mrs_simulator.record.recording import Recorder, read_run_csv
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.draw import figure_process

SAMPLES, ROBOTS = 50, 3


def recorded(path, **options):
    """Return the ``Recorder`` of a finished run of random samples."""
    draw = np.random.default_rng(1)
    with Recorder(str(path), range(1, 1 + ROBOTS), kept=SAMPLES, **options) as recorder:
        for k in range(SAMPLES):
            pose, command = draw.normal(size=(ROBOTS, 3)), draw.normal(size=(ROBOTS, 2))
            recorder.sample(0.1 * k, StateTable(pose=pose, command=command))
    return recorder


def same(one, other):
    columns = "time", "pose", "hand", "command"
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in columns)


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(recording, "MOST_KEPT", 1000)
    monkeypatch.setattr(recording, "RELEASED", 300)


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="no files that are mapped")
def test_a_long_run_is_not_read_back(small, monkeypatch, tmp_path):
    recorder = recorded(tmp_path / "run.csv")
    assert not recorder.kept.is_shared
    assert os.listdir(str(tmp_path)) == ["run.csv"]
    written = read_run_csv(recorder.path)
    monkeypatch.setattr(recording, "read_run_csv", None)
    assert same(recorder.run(), written)
    recorder.kept.release()
    assert same(recorder.run(), written)


def test_what_is_not_finite_is_found_in_any_part(small, tmp_path):
    recorder = recorded(tmp_path / "run.csv")
    assert recorder.has_kept_all
    recorder.kept.table[-1, -1, 0] = np.inf
    assert not recorder.has_kept_all


@pytest.mark.parametrize("room", ["none", "unknown"])
def test_without_room_for_it_the_run_is_read_back(small, monkeypatch, tmp_path, room):
    if room == "none":
        monkeypatch.setattr(recording, "FREE", 1e30)
    else:

        def refuse(*arguments):
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(os, "posix_fallocate", refuse, raising=False)
    recorder = recorded(tmp_path / "run.csv")
    assert not recorder.has_kept_all
    assert same(recorder.run(), read_run_csv(recorder.path))


def test_processes_apart_do_not_draw_it(small, tmp_path):
    drawing = figure_process.Drawing.__new__(figure_process.Drawing)
    drawing.begin(recorded(tmp_path / "run.csv"))
    assert not drawing.is_able
