"""Searches that are killed, and go on after the runs that they have kept."""

import json
import os
import resource
import signal
import subprocess
import sys

import pytest
from ros_fixtures import wait_until

from mrs_simulator.study.search import kept_runs
from mrs_simulator.study.search.assure_command import main as assure
from mrs_simulator.study.search.break_command import main as break_
from mrs_simulator.study.search.margins_command import main as margins

SCENARIO = """
poses: [[0, 0, 0], [3, 0, 0]]
fidelity: point_mass
limits: none
control: {protocol: law.py, rate: 10, saturation: none, parameters: {gain: 1.0}}
duration: 2
step: 0.1
requirements:
  agree: eventually[0, 1.9] always(distance < 2.9 m)
search:
  poses: {within: [-3, -3, 3, 3], apart: 1}
  control.parameters.gain: [0.2, 30]
"""
LAW = """
import os
import time
from mrs_simulator import PioneerControl
from mrs_simulator.core.fields import Parameter


class Meets(PioneerControl):
    PARAMETERS = (Parameter("gain", 1.0, "1/s"),)

    def pointMassLaw(self, hand):
        if os.path.exists({!r}):
            time.sleep(0.01)
        return -self.gain * (hand - hand.mean(axis=0))
"""
BREAK = "--runs", "12", "--seed", "5", "--optimiser", "random", "--jobs", "1", "--formats", ""
WRITTEN = "search.json", "counterexample.yaml", os.path.join("run", "run.csv")


@pytest.fixture
def path(tmp_path):
    (tmp_path / "law.py").write_text(LAW.format(str(tmp_path / "slow")))
    (tmp_path / "given.yaml").write_text(SCENARIO)
    return str(tmp_path / "given.yaml")


def run(command, *arguments):
    with pytest.raises(SystemExit) as caught:
        command([*map(str, arguments)])
    return caught.value.code


def lines_in(out):
    return (out / kept_runs.FILE).read_bytes().splitlines(True)


def test_a_killed_search_goes_on_to_the_same_result(path, tmp_path, capsys):
    whole, out, slow = tmp_path / "whole", tmp_path / "out", tmp_path / "slow"
    assert run(break_, path, "--out", whole, *BREAK) == 1
    slow.touch()  # so that it is killed within
    command = [sys.executable, "-m", "mrs_simulator", "break", path, "--out", str(out), *BREAK]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    try:
        wait_until(lambda: (out / kept_runs.FILE).exists() and len(lines_in(out)) > 5)
        assert run(margins, path, "--out", out) == 2
        said = capsys.readouterr().err
        assert "another search writes there" in said and "begins anew" not in said
    finally:
        process.kill()
        process.wait()
    assert not (out / "search.json").exists()
    slow.unlink()
    _, *kept = lines_in(out)
    with open(str(out / kept_runs.FILE), "ab") as file:
        file.write(b'{"variation": {}, "unt')  # the kill may have cut one off
    capsys.readouterr()
    assert run(break_, path, "--out", out, *BREAK) == 1
    assert "search: goes on after {} runs that are in".format(len(kept)) in capsys.readouterr().err
    for name in WRITTEN:
        assert (out / name).read_bytes() == (whole / name).read_bytes()
    assert set(lines_in(out)) == set(lines_in(whole))
    assert not set(kept) & set(lines_in(out)[1 + len(kept) :])  # none is run again


@pytest.mark.parametrize(
    "command, report, options",
    [
        (assure, "assurance.json", ("--seed", "2", "--at-least", "0.8", "--runs", "30")),
        (margins, "margins.json", ("--along", "control.parameters.gain=30", "--formats", "")),
    ],
)
def test_the_others_go_on_too(path, tmp_path, capsys, command, report, options):
    out = tmp_path / "out"
    code = run(command, path, "--out", out, *options)
    found, lines = (out / report).read_bytes(), lines_in(out)
    (out / report).unlink()
    (out / kept_runs.FILE).write_bytes(b"".join(lines[:9]))
    assert run(command, path, "--out", out, *options) == code
    assert "goes on after 8 runs" in capsys.readouterr().err
    assert (out / report).read_bytes() == found and set(lines_in(out)) == set(lines)


def change_law(path):
    law = os.path.join(os.path.dirname(path), "law.py")
    with open(law, "a") as file:
        file.write("# another\n")
    return ()


def change_scenario(path):
    with open(path, "w") as file:
        file.write(SCENARIO.replace("duration: 2\n", "duration: 2.0001\n"))
    return ()


@pytest.mark.parametrize(
    "change, said",
    [
        (lambda path: ("--seed", "6"), "(seed changed)"),
        (lambda path: ("--vary", "mismatch.delay=[0, 0.1]"), "(search changed)"),
        (change_scenario, "(scenario, law or version changed)"),
        (change_law, "(scenario, law or version changed)"),
    ],
)
def test_another_search_begins_anew(path, tmp_path, capsys, change, said):
    out = tmp_path / "out"
    run(break_, path, "--out", out, *BREAK)
    changed = change(path)
    capsys.readouterr()
    run(break_, path, "--out", out, *BREAK, *changed)
    told = capsys.readouterr().err
    assert "is of another search {}: it begins anew".format(said) in told and "goes on" not in told
    run(break_, path, "--out", tmp_path / "fresh", *BREAK, *changed)
    for name in ("search.json", kept_runs.FILE):
        assert (out / name).read_bytes() == (tmp_path / "fresh" / name).read_bytes()


def test_what_another_wrote_begins_anew(path, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / kept_runs.FILE).write_text('["no search"]\n')
    assert run(break_, path, "--out", out, *BREAK) == 1
    assert json.loads(lines_in(out)[0])["seed"] == 5


@pytest.mark.parametrize("command", ["break", "assure", "margins"])
def test_a_full_disk_is_named_before_the_first_run(path, tmp_path, command):
    out = tmp_path / "out"
    words = [sys.executable, "-m", "mrs_simulator", command, path, "--out", str(out)]
    limit = dict(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (50, 50)))
    done = subprocess.run(words, stderr=subprocess.PIPE, timeout=60, **limit)
    said = done.stderr.decode().splitlines()
    assert done.returncode == 2 and said[-1].startswith("{}: {}".format(command, out)), said
    assert said[-1].endswith("runs.jsonl: File too large") and "runs so far" not in str(said)


@pytest.mark.parametrize("command", [break_, assure, margins])
def test_a_directory_that_cannot_be_made_is_named_before_the_first_run(
    path, tmp_path, capsys, command
):
    (tmp_path / "file").write_text("")
    assert run(command, path, "--out", tmp_path / "file" / "out") == 2
    assert "{}: Not a directory".format(tmp_path / "file" / "out") in capsys.readouterr().err


def test_an_interrupted_search_says_that_it_goes_on(path, tmp_path):
    (tmp_path / "slow").touch()
    out = tmp_path / "out"
    words = [sys.executable, "-m", "mrs_simulator", "break", path, "--out", str(out), *BREAK]
    process = subprocess.Popen(words, stderr=subprocess.PIPE)
    try:
        wait_until(lambda: (out / kept_runs.FILE).exists() and len(lines_in(out)) > 3)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1].decode()
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 130 and "the same command goes on" in said
