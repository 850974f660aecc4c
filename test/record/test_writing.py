"""Files on disks that are full: told by name, nothing half written, and runs go on."""

import contextlib
import json
import os
import resource
import subprocess
import sys

import numpy as np
import pytest

from mrs_simulator.core import writing
from mrs_simulator.core.writing import Blocks, naming, write_text
from mrs_simulator.record.recording import Recorder, read_run_csv
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.run.experiment import run_experiment

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


class Disk:
    """A file on a disk with so much room; a write takes what there is, as the kernel does."""

    def __init__(self, file, room):
        self._file, self.room = file, room
        self.fileno, self.seek = file.fileno, file.seek

    @property
    def closed(self):
        return self._file.closed

    def close(self):
        self._file.close()

    def write(self, content):
        free = self.room - os.fstat(self.fileno()).st_size
        if free <= 0:
            raise OSError(28, "No space left on device")
        return self._file.write(bytes(content)[:free])


@contextlib.contextmanager
def file_limit(size):
    """Let no file of this process grow beyond ``size`` [bytes]: the kernel says EFBIG."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture
def impatient(monkeypatch):
    monkeypatch.setattr(writing, "FLUSH_PERIOD", 0.0)
    monkeypatch.setattr(writing, "RETRY_PERIOD", 0.0)


def test_whole_blocks_are_kept_and_the_rest_follows_when_there_is_room(tmp_path, impatient):
    path = str(tmp_path / "run.csv")
    blocks = Blocks(path, "head\n")
    disk = blocks._file = Disk(blocks._file, 25)
    for k in range(6):
        blocks.add(["block {}\n".format(k)])
    with open(path) as file:
        assert file.read() == "head\nblock 0\nblock 1\n"
    assert blocks.trouble == "No space left on device" and not blocks.lost
    disk.room = 1000
    blocks.add(["block 6\n"])
    assert not blocks.trouble
    blocks.close()
    blocks.close()
    with open(path) as file:
        assert file.read() == "head\n" + "".join("block {}\n".format(k) for k in range(7))


def test_a_block_of_several_texts_is_in_the_file_whole_or_not_at_all(
    tmp_path, impatient, monkeypatch
):
    monkeypatch.setattr(writing, "AT_ONCE", 8)  # each text by a call of its own
    path = str(tmp_path / "run.csv")
    blocks = Blocks(path, "head\n")
    disk = blocks._file = Disk(blocks._file, 35)
    for k in range(3):
        blocks.add(["block {}, ".format(k), "its end\n"])
    with open(path) as file:
        assert file.read() == "head\nblock 0, its end\n"
    disk.room = 1000
    blocks.close()
    with open(path) as file:
        assert file.read() == "head\n" + "".join("block {}, its end\n".format(k) for k in range(3))


def test_blocks_in_a_row_are_kept_one_by_one_where_there_is_no_room(tmp_path, impatient):
    path = str(tmp_path / "run.csv")
    blocks = Blocks(path, "head\n")
    disk = blocks._file = Disk(blocks._file, 12)
    content = bytearray(b"first\nsecond\nthird\n")
    blocks.extend(content, [6, 13, 19])
    content[:] = b"x" * len(content)
    with open(path) as file:
        assert file.read() == "head\nfirst\n"
    assert blocks.trouble and not blocks.lost
    disk.room = 1000
    blocks.extend(b"fourth\n", [7])
    assert not blocks.trouble
    blocks.add(["fifth\n"])
    blocks.extend(b"sixth\n", [6])
    blocks.close()
    with open(path) as file:
        assert file.read() == "head\nfirst\nsecond\nthird\nfourth\nfifth\nsixth\n"


def test_memory_is_bounded_and_what_is_lost_is_counted(tmp_path, impatient, monkeypatch):
    monkeypatch.setattr(writing, "MOST_PENDING", 100)
    blocks = Blocks(str(tmp_path / "run.csv"), "head\n")
    blocks._file = Disk(blocks._file, 10)
    for _ in range(100):
        blocks.add(["0123456789\n"])
    assert blocks._size < 150 and blocks.lost == 90
    blocks.close()
    assert blocks.lost == 100


def recorded(path, samples, room_until, room_again):
    """Record ``samples`` of two robots on a disk that is full in between; return what was told."""
    told = []
    recorder = Recorder(path, [1, 2], warn=told.append)
    disk = recorder._file._file = Disk(recorder._file._file, 10**9)
    for k in range(samples):
        if k == room_until:
            disk.room = os.path.getsize(path) + 30
        elif k == room_again:
            disk.room = 10**9
        recorder.sample(
            0.1 * k, StateTable(pose=np.full((2, 3), float(k)), command=np.zeros((2, 2)))
        )
    recorder.close()
    return recorder, told


def test_a_run_goes_on_when_there_is_room_again_and_tells_of_it(tmp_path, impatient):
    path = str(tmp_path / "run.csv")
    recorder, told = recorded(path, 20, 5, 12)
    assert told == recorder.warnings() == [
        path + ": from 0.500 s No space left on device",
        path + ": at 1.200 s samples are in the file again",
    ]  # fmt: skip
    np.testing.assert_array_equal(read_run_csv(path).pose[:, 0, 0], np.arange(20.0))


def test_a_disk_that_stays_full_keeps_the_rows_so_far(tmp_path, impatient):
    path = str(tmp_path / "run.csv")
    recorder, _ = recorded(path, 20, 5, -1)
    assert recorder.warnings()[-1] == path + ": 15 samples lost"
    np.testing.assert_array_equal(read_run_csv(path).pose[:, 0, 0], np.arange(5.0))


def test_an_experiment_on_a_full_disk_names_the_file_and_keeps_its_rows(tmp_path):
    out = str(tmp_path / "out")
    code = (
        "import resource, sys; sys.dont_write_bytecode = True;"  # which would be cut off as well
        "resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000));"
        "from mrs_simulator.study.run.command import main; main(sys.argv[1:])"
    )
    arguments = ["paper_four.yaml", "--duration", "30", "--out", out]
    ended = subprocess.run(
        [sys.executable, "-c", code, *arguments], stderr=subprocess.PIPE, timeout=100
    )
    said = ended.stderr.decode()
    assert ended.returncode == 2 and "Traceback" not in said
    assert "experiment: {}: from ".format(os.path.join(out, "run.csv")) in said
    assert "File too large" in said
    assert "samples lost" in json.load(open(os.path.join(out, "run.json")))["warnings"][-1]
    run = read_run_csv(os.path.join(out, "run.csv"))
    assert len(run.time) > 10 and os.path.getsize(os.path.join(out, "run.csv")) <= 20000


def test_a_disk_with_room_for_results_leaves_a_marked_run(tmp_path, monkeypatch, impatient):
    scenario = load_scenario(os.path.join(ROOT, "scenarios", "paper_four.yaml"))
    opened = Recorder.__init__

    def on_small_disk(self, *arguments, **named):
        opened(self, *arguments, **named)
        self._file._file = Disk(self._file._file, 5000)

    monkeypatch.setattr(Recorder, "__init__", on_small_disk)
    out = str(tmp_path)
    verdict = run_experiment(scenario._replace(duration=5.0), out, formats=())
    assert not verdict["passed"] and verdict["ended"] == "cut short"
    assert any("No space left" in warning for warning in verdict["warnings"])
    assert any("samples lost" in warning for warning in verdict["warnings"])


def test_a_text_is_written_whole_or_not_at_all(tmp_path):
    path = str(tmp_path / "run.json")
    write_text(path, "before")
    with pytest.raises(OSError) as caught, file_limit(1000):
        write_text(path, "x" * 5000)
    assert caught.value.filename == path
    assert os.listdir(str(tmp_path)) == ["run.json"]
    with open(path) as file:
        assert file.read() == "before"


def test_a_device_is_written_to_as_it_is_and_named():
    with pytest.raises(OSError) as caught:
        write_text("/dev/full", "text")
    assert caught.value.filename == "/dev/full" and not os.path.exists("/dev/full.part")
    with pytest.raises(OSError) as caught, naming("a"):
        open("/missing/file")
    assert caught.value.filename == "/missing/file"


@pytest.mark.parametrize("period, there", [(0.0, 1), (1000.0, 0)])
def test_samples_are_written_after_the_period_and_at_the_end(tmp_path, monkeypatch, period, there):
    monkeypatch.setattr(writing, "FLUSH_PERIOD", period)
    path = str(tmp_path / "run.csv")
    with Recorder(path, [1, 2]) as recorder:
        for k in range(4):  # the first is always due
            state = StateTable(pose=np.full((2, 3), float(k)), command=np.zeros((2, 2)))
            recorder.sample(0.1 * k, state)
            with open(path) as file:
                assert len(file.readlines()) == 3 + 2 * k * there
    np.testing.assert_array_equal(read_run_csv(path).pose[:, 1, 0], range(4))
