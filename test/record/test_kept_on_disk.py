"""Samples that are too many for memory, kept in a file that is mapped."""

import os
import re

import numpy as np
import pytest

from mrs_simulator.core import neighbours, sample_blocks
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.neighbours import least_distance_over
from mrs_simulator.core.sample_blocks import blocks
from mrs_simulator.protocols.formation import equations
from mrs_simulator.record import recording
from mrs_simulator.record.recording import Recorder, read_run_csv
from mrs_simulator.state.layout import basic_layout
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.draw import figure_process
from mrs_simulator.study.draw.figure_parts import extremes
from mrs_simulator.verdict.impossible_poses import first_jump, first_overlap
from mrs_simulator.verdict.judging import _unfit

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
    monkeypatch.setattr(sample_blocks, "MOST_SEEN", 5)


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="no files that are mapped")
def test_a_long_run_is_not_read_back(small, monkeypatch, tmp_path):
    recorder = recorded(tmp_path / "run.csv")
    assert not recorder.kept.is_shared
    assert os.listdir(str(tmp_path)) == ["run.csv"]
    written = read_run_csv(recorder.path)
    monkeypatch.setattr(recording, "read_run_csv", None)
    assert same(recorder.run(), written)
    sample_blocks.release()
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


def resident(directory):
    """Return how much of maps of files in ``directory`` is resident [bytes]."""
    with open("/proc/self/smaps") as file:
        _, *maps = file.read().split(str(directory))
    return sum(1024 * int(re.search(r"^Rss: *(\d+)", text, re.MULTILINE).group(1)) for text in maps)


LONG, FEW = 20000, 4  # samples and robots
TOPOLOGY = Topology(FEW, [(k, k + 1) for k in range(1, FEW)])
LOOKS = {
    "a look at all": lambda run: [run.pose[rows].sum() for rows in blocks(LONG, FEW)],
    "least distance": lambda run: least_distance_over(run.hand),
    "jumps": lambda run: first_jump(run.time, run.pose, np.full(FEW, 1.0)),
    "overlaps": lambda run: first_overlap(run.pose, 0.3),
    "places": _unfit,
    "extremes": lambda run: extremes(run.hand),
    "errors": lambda run: equations.error_norms(run.hand, np.zeros((FEW, 2)), TOPOLOGY),
}


@pytest.mark.skipif(not os.path.exists("/proc/self/smaps"), reason="no list of maps")
@pytest.mark.parametrize("name", LOOKS)
def test_looks_at_a_long_run_leave_little_of_it_in_memory(tmp_path, monkeypatch, name):
    monkeypatch.setattr(recording, "MOST_KEPT", 1000)
    monkeypatch.setattr(sample_blocks, "MOST_SEEN", LONG // 2)
    monkeypatch.setattr(sample_blocks, "AT_ONCE", LONG // 100)
    monkeypatch.setattr(neighbours, "AT_ONCE", LONG // 100)
    monkeypatch.setattr(equations, "SMALL_TEAM", 0)
    most, released = [0], sample_blocks.release

    def release():
        most[0] = max(most[0], resident(tmp_path))
        released()

    monkeypatch.setattr(sample_blocks, "release", release)
    kept = recording.Kept(range(1, 1 + FEW), basic_layout(), LONG, directory=str(tmp_path))
    places = 3.0 * np.arange(FEW)[:, np.newaxis] + np.zeros(kept.table.shape[2])
    some = np.broadcast_to(places, (100, *places.shape))
    for row in range(0, LONG, len(some)):
        kept.put(slice(row, row + len(some)), some)
    release()
    run = kept.run(0.1 * np.arange(LONG), None, ([], {}))
    assert run.hand.sum() == LONG * places[:, :2].sum()
    whole = resident(tmp_path)
    released()
    LOOKS[name](run)
    release()
    assert 0 < most[0] < whole / 2 and whole > 8 * 2 * LONG * FEW  # so much of it was looked at
