"""A thread that writes what a run records: the same files, warnings and errors as without it."""

import contextlib
import gc
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from mrs_simulator.core import compiling, writing
from mrs_simulator.record import recording
from mrs_simulator.record.beside import MOST_WAITING, Beside
from mrs_simulator.record.recording import Recorder, read_run_csv
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.run import experiment

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAPER = os.path.join(ROOT, "scenarios", "paper.yaml")
ROBOTS, SAMPLES = 3, 60
SCRIPT = """
import os, signal, sys
import numpy as np
from mrs_simulator.core import writing
from mrs_simulator.record import recording

writing.FLUSH_PERIOD = 0.0
recording.Recorder._pays_beside = lambda self: True
recorder = recording.Recorder(sys.argv[1], [1, 2])
recorder.write_together()
for k in range(50):
    recorder.block([float(k)], np.full((1, 2, 3), float(k)), np.zeros((1, 2, 2)))
{}
"""


@pytest.fixture
def threaded(monkeypatch):
    """Return what says whether recorders have a thread from now on; they write all at once."""
    monkeypatch.setattr(writing, "FLUSH_PERIOD", 0.0)
    monkeypatch.setattr(writing, "RETRY_PERIOD", 0.0)

    def choose(wanted):
        monkeypatch.setattr(Recorder, "_pays_beside", lambda self: wanted)

    choose(True)
    return choose


def add_blocks(recorder, samples=SAMPLES, most=7, before=lambda at: None, begin=0):
    """Let ``recorder`` take blocks of up to ``most`` random samples, after ``before`` of the first.

    From the row ``begin`` up to ``samples``.
    """
    draw, at = np.random.default_rng(0), begin
    recorder.write_together()
    while at < samples:
        count = min(1 + at % most, samples - at)
        before(at)
        poses, commands = (draw.normal(size=(count, ROBOTS, width)) for width in (3, 2))
        recorder.block([0.1 * k for k in range(at, at + count)], poses, commands)
        at += count


def add_samples(recorder, samples=5):
    draw = np.random.default_rng(1)
    for k in range(SAMPLES, SAMPLES + samples):
        pose, command = draw.normal(size=(ROBOTS, 3)), draw.normal(size=(ROBOTS, 2))
        recorder.sample(0.1 * k, StateTable(pose=pose, command=command))


@pytest.mark.parametrize("together", [1, 6, 30, 1000])
def test_files_and_runs_are_the_same(tmp_path, threaded, monkeypatch, together):
    monkeypatch.setattr(recording, "TOGETHER", together)
    found = {}
    for wanted in (False, True):
        threaded(wanted)
        path = tmp_path / "{}.csv".format(wanted)
        with Recorder(str(path), range(1, 1 + ROBOTS), kept=2 * SAMPLES) as recorder:
            add_blocks(recorder)
            add_samples(recorder)
            assert (recorder._beside is not None) == wanted
            recorder.flush()
            assert path.read_bytes().count(b"\n") == 1 + ROBOTS * (SAMPLES + 5)
            add_blocks(recorder, 2 * SAMPLES, begin=SAMPLES + 5)
        found[wanted] = path.read_bytes(), recorder.run(), read_run_csv(str(path))
    assert found[True][0] == found[False][0]
    for run in found[True][1:]:
        for name in ("time", "pose", "hand", "command"):
            np.testing.assert_array_equal(getattr(run, name), getattr(found[False][1], name))


class Disk:
    """A file on a disk that is full while ``is_full``; calls ``before`` it is written to."""

    def __init__(self, file):
        self._file, self.is_full, self.before = file, False, lambda: None

    def __getattr__(self, name):
        return getattr(self._file, name)

    def write(self, content):
        self.before()
        if self.is_full:
            raise OSError(28, "No space left on device")
        return self._file.write(content)


def of_full_disk(path, room_again):
    """Return what was told, in which threads, warnings, content of a run whose disk is full for a while.

    From 0.3 of the samples up to ``room_again`` of them.
    """
    told, threads = [], set()

    def warn(text):
        told.append(text)
        threads.add(threading.current_thread())

    recorder = Recorder(path, range(1, 1 + ROBOTS), warn=warn)
    disk = recorder._file._file = Disk(recorder._file._file)

    def before(at):
        if recorder._beside:
            recorder._beside.settle()  # so that the disk is full for the same samples
        disk.is_full = 0.3 * SAMPLES <= at < room_again * SAMPLES

    add_blocks(recorder, before=before)
    recorder.close()
    with open(path, "rb") as file:
        return told, threads, recorder.warnings(), file.read()


@pytest.mark.parametrize("room_again, pending", [(0.7, 10**6), (0.7, 1000), (2.0, 10**6)])
def test_a_full_disk_is_told_as_without_it(tmp_path, threaded, monkeypatch, room_again, pending):
    monkeypatch.setattr(writing, "MOST_PENDING", pending)
    path = str(tmp_path / "run.csv")
    threaded(False)
    wanted = told, threads, warnings, _ = of_full_disk(path, room_again)
    threaded(True)
    assert of_full_disk(path, room_again) == wanted
    assert "No space left on device" in told[0] and threads == {threading.current_thread()}
    assert ("samples lost" in warnings[-1]) == (room_again > 1.0 or pending == 1000)


def test_a_full_disk_is_told_with_the_time_of_the_sample(tmp_path, threaded):
    told, recorded = [], threading.Event()
    recorder = Recorder(str(tmp_path / "run.csv"), [1], warn=told.append)
    disk = recorder._file._file = Disk(recorder._file._file)
    disk.is_full, disk.before = True, recorded.wait
    recorder.write_together()
    for k in range(3):
        recorder.block([0.1 * k], np.zeros((1, 1, 3)), np.zeros((1, 1, 2)))
    recorded.set()
    recorder.close()
    assert "from 0.000 s" in told[0]


def test_an_error_ends_the_run_and_nothing_is_written_after_it(tmp_path, threaded, monkeypatch):
    path, failing = tmp_path / "run.csv", []
    written = Recorder._file_away

    def file_away(self, stamps, *text):
        if stamps[-1] >= 2.0:
            failing.append(stamps)
            raise MemoryError("no more")
        written(self, stamps, *text)

    monkeypatch.setattr(Recorder, "_file_away", file_away)
    with pytest.raises(MemoryError, match="no more"), Recorder(
        str(path), range(1, 1 + ROBOTS)
    ) as recorder:
        add_blocks(recorder, most=1)
    assert len(failing) == 1 and recorder._file._file.closed and recorder._beside is None
    assert path.read_bytes().count(b"\n") == 1 + 20 * ROBOTS
    recorder.close()


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_while_the_disk_is_slow_loses_nothing(tmp_path, threaded):
    path, interrupted = str(tmp_path / "run.csv"), threading.Event()
    recorder = Recorder(path, range(1, 1 + ROBOTS), kept=SAMPLES)
    disk = recorder._file._file = Disk(recorder._file._file)

    def interrupt():
        while not (recorder._beside._waiting.not_full._waiters or interrupted.is_set()):
            time.sleep(0.001)
        if not interrupted.is_set():
            signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
            interrupted.wait()

    disk.before = interrupt
    with pytest.raises(KeyboardInterrupt):
        add_blocks(recorder)
    interrupted.set()
    check_whole(recorder)


def check_whole(recorder):
    """Close ``recorder`` and check that all of its samples are there, once."""
    recorder.close()
    run = read_run_csv(recorder.path)
    assert len(run.time) == recorder._samples > MOST_WAITING and recorder.has_kept_all
    for name in ("time", "pose", "hand", "command"):
        np.testing.assert_array_equal(getattr(run, name), getattr(recorder.run(), name))


def test_an_interrupt_once_it_was_asked_writes_nothing_twice(tmp_path, threaded, monkeypatch):
    asked, ask = [], Beside.ask

    def interrupted(self, function):
        asked.append(function)
        ask(self, function)
        if len(asked) == 4:
            raise KeyboardInterrupt

    monkeypatch.setattr(Beside, "ask", interrupted)
    recorder = Recorder(str(tmp_path / "run.csv"), range(1, 1 + ROBOTS), kept=SAMPLES)
    with pytest.raises(KeyboardInterrupt):
        add_blocks(recorder)
    check_whole(recorder)


def test_what_an_interrupt_left_half_kept_is_read_back(tmp_path, threaded, monkeypatch):
    threaded(False)
    recorder = Recorder(str(tmp_path / "run.csv"), range(1, 1 + ROBOTS), kept=SAMPLES)
    add_blocks(recorder, 10)

    def interrupted(rows, numbers):
        raise KeyboardInterrupt

    monkeypatch.setattr(recorder.kept, "put", interrupted)
    with pytest.raises(KeyboardInterrupt):
        add_blocks(recorder, 20, begin=10)
    recorder.close()
    assert not recorder.has_kept_all
    assert len(recorder.run().time) == 10


def test_what_waits_is_bounded():
    beside, free, asked = Beside(), threading.Event(), threading.Semaphore(0)

    def ask():
        for _ in range(10):
            beside.ask(free.wait)
            asked.release()

    asking = threading.Thread(target=ask)
    asking.start()
    try:
        for _ in range(1 + MOST_WAITING):  # one is being done
            asked.acquire()
        assert not asked.acquire(timeout=0.1)
    finally:
        free.set()
        asking.join()
        beside.settle()
        beside.close()


def test_the_thread_ends_with_whoever_has_it(tmp_path, threaded):
    before = set(threading.enumerate())
    recorder = Recorder(str(tmp_path / "run.csv"), range(1, 1 + ROBOTS))
    add_blocks(recorder)
    assert len(set(threading.enumerate()) - before) == 1
    recorder.close()
    assert set(threading.enumerate()) == before
    recorder = Recorder(str(tmp_path / "run.csv"), range(1, 1 + ROBOTS))
    add_blocks(recorder)
    (thread,) = set(threading.enumerate()) - before
    del recorder
    gc.collect()
    thread.join(60.0)
    assert not thread.is_alive()


@pytest.mark.parametrize(
    "end, code",
    [
        ("raise ValueError", 1),
        ("recorder._beside.settle(); os.kill(os.getpid(), signal.SIGKILL)", -signal.SIGKILL),
    ],
)
def test_what_was_recorded_is_there_after_any_end(tmp_path, end, code):
    path = str(tmp_path / "run.csv")
    ended = subprocess.run(
        [sys.executable, "-c", SCRIPT.format(end), path], stderr=subprocess.DEVNULL, timeout=300
    )
    assert ended.returncode == code
    np.testing.assert_array_equal(read_run_csv(path).time, range(50))


@pytest.mark.parametrize("rows", [1, 4000])
def test_experiments_write_by_it(tmp_path, threaded, monkeypatch, rows):
    monkeypatch.setattr(experiment, "ROWS_AT_ONCE", rows)
    scenario = load_scenario(PAPER)._replace(duration=3.0)
    path, found = tmp_path / "run.csv", []
    for wanted in (False, True):
        threaded(wanted)
        made = experiment.Experiment(scenario)
        with contextlib.closing(made.world), Recorder(
            str(path), made.control.numbers, layout=made.layout
        ) as recorder:
            assert sum(made.record(recorder)) == 31
            assert (recorder._beside is not None) == wanted
        found.append(path.read_bytes())
    assert found[0] == found[1]


def has_thread(tmp_path, samples):
    with Recorder(str(tmp_path / "run.csv"), range(1, 1 + ROBOTS)) as recorder:
        add_blocks(recorder, samples)
        return recorder._beside is not None


def test_there_is_one_only_where_it_pays(tmp_path, monkeypatch):
    pytest.importorskip("numba")
    few, many = recording.BESIDE // ROBOTS // 2, 2 * recording.BESIDE // ROBOTS
    monkeypatch.setattr(recording, "cores", lambda: 2)
    monkeypatch.setenv(compiling.VARIABLE, "1")
    assert has_thread(tmp_path, many) and not has_thread(tmp_path, few)
    monkeypatch.setenv(compiling.VARIABLE, "0")
    assert not has_thread(tmp_path, many)
    monkeypatch.setenv(compiling.VARIABLE, "1")
    monkeypatch.setattr(recording, "cores", lambda: 1)
    assert not has_thread(tmp_path, many)
