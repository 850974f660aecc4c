"""Rows of numbers as text by compiled loops: the bytes that Python writes."""

import numpy as np
import pytest

from mrs_simulator.core import compiling
from mrs_simulator.record import number_rows
from mrs_simulator.record.recording import Recorder
from mrs_simulator.state.layout import basic_layout
from mrs_simulator.state.state_table import StateTable

pytest.importorskip("numba")
COUNT = 4000


@pytest.fixture(autouse=True)
def compiled(monkeypatch):
    monkeypatch.setenv(compiling.VARIABLE, "1")


def with_neighbours(numbers):
    return np.concatenate([np.nextafter(numbers, -1.0), numbers, np.nextafter(numbers, 1e16)])


def drawn(name):
    draw = np.random.default_rng(0)
    signs = draw.choice([-1.0, 1.0], COUNT)
    if name == "positions":
        return 10.0 * draw.normal(size=COUNT)
    if name == "sizes":
        return signs * 10.0 ** draw.uniform(-323.0, 15.9, COUNT)
    if name == "short":
        return np.round(signs * 10.0 ** draw.uniform(-6.0, 9.0, COUNT), 4)
    if name == "whole":
        return with_neighbours(signs * np.floor(10.0 ** draw.uniform(0.0, 15.0, COUNT)))
    if name == "halves":  # as near to the middle of two decimals as numbers are
        return with_neighbours(
            draw.integers(0, 1 << 52, COUNT) / 2.0 ** draw.integers(0, 60, COUNT)
        )
    if name == "powers of two":
        return with_neighbours(np.ldexp(1.0, np.arange(-1074, 53)))
    if name == "powers of ten":
        return with_neighbours(np.array([float("1e{}".format(k)) for k in range(-320, 16)]))
    numbers = draw.integers(0, 1 << 63, COUNT, dtype=np.uint64).view(float)  # all bits
    return numbers[numbers < 1e16]


NAMES = "positions, sizes, short, whole, halves, powers of two, powers of ten, bits"


@pytest.mark.parametrize("name", NAMES.split(", "))
def test_numbers_are_as_python_writes_them(name):
    table = np.concatenate([drawn(name), number_rows.TRICKY, -number_rows.TRICKY])[:, np.newaxis]
    rows = range(len(table))
    content, _ = number_rows.Lines(rows, [""] * len(table)).filled([0.5], table[np.newaxis])
    wanted = ["0.5,{},{}\n".format(*each) for each in zip(rows, number_rows.python_rows(table))]
    assert str(content, "utf-8").splitlines(True) == wanted


def test_lines_hold_what_they_do_by_python():
    tables = 1e6 * np.random.default_rng(0).normal(size=(3, 4, 5))
    stamps, ends = [0.0, 1e-05, 12.300000000000001], [",a%s", "", ",ä,b", ',"q"']
    lines = number_rows.Lines([1, 20, 300, 4000], ends)
    content, samples = lines.filled(stamps, tables)
    wanted = ["".join(texts).encode("utf-8") for texts in lines.texts(stamps, tables)]
    assert [bytes(content[a:b]) for a, b in zip((0, *samples), samples)] == wanted


@pytest.mark.parametrize("odd", [1e16, -1e300, np.nan, -np.inf])
def test_what_it_does_not_write_python_does(tmp_path, odd):
    table = np.ones((1, 2, 7))
    assert number_rows.Lines([1, 2], ["", ""]).filled([0.0], table) is not None
    table[0, 1, 3] = odd
    assert number_rows.Lines([1, 2], ["", ""]).filled([0.0], table) is None
    poses = np.array([[[abs(odd), 0.0, 0.0]]])
    with Recorder(str(tmp_path / "run.csv"), [1]) as recorder:
        recorder.block([0.0], poses, np.zeros((1, 1, 2)))
    assert "1,{},".format(repr(abs(odd))) in (tmp_path / "run.csv").read_text()


def recorded(path, n, samples):
    draw = np.random.default_rng(0)
    layout = basic_layout()._replace(kinds=("é,%d",) * n) if n > 1 else None
    with Recorder(str(path), range(1, n + 1), layout=layout) as recorder:
        for k in range(samples):
            pose, command = draw.normal(size=(n, 3)), np.zeros((n, 2))
            state = StateTable(pose=pose, command=command)
            recorder.sample(0.1 * k, state if k % 2 else state.replace(hand=pose[:, :2] + 1.0))
        poses, commands = draw.normal(size=(50, n, 3)), draw.normal(size=(50, n, 2))
        recorder.block([0.1 * (samples + k) for k in range(50)], poses, commands)
    return path.read_bytes()


@pytest.mark.parametrize("n", [1, 3, 700])
def test_files_have_the_same_bytes(tmp_path, n, monkeypatch):
    by_loops = recorded(tmp_path / "loops.csv", n, 5)
    monkeypatch.setenv(compiling.VARIABLE, "0")
    assert recorded(tmp_path / "python.csv", n, 5) == by_loops
    assert by_loops.count(b"\n") == 1 + 55 * n


def test_loops_are_used_where_numba_is_and_that_pays(monkeypatch):
    monkeypatch.delenv(compiling.VARIABLE)
    monkeypatch.setattr(compiling, "_asked", {})
    lines, table = number_rows.Lines(range(1000), [""] * 1000), np.ones((100, 1000, 2))
    monkeypatch.setattr(compiling, "_is_loaded", lambda: False)
    assert lines.filled(range(100), table) is None
    monkeypatch.setattr(compiling, "_is_loaded", lambda: True)
    assert lines.filled(range(1), table[:1]) is None
    assert lines.filled(range(100), table) is not None
    with compiling.in_time():
        assert lines.filled(range(100), table) is None
