"""What becomes of tests that several processes run."""

import subprocess
import sys

TESTS = """
import os
import signal
import warnings

import pytest

@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    yield os.getpid()
    with open(os.environ["ENDED"], "a") as file:
        file.write("ended\\n")

@pytest.mark.parametrize("number", range(20))
def test_right(shared, number):
    assert shared == os.getpid()

def test_wrong():
    warnings.warn("beware")
    print("what it printed")
    assert False, "why"

def test_that_kills_its_process(shared):
    os.kill(os.getpid(), signal.SIGKILL)

def test_that_comes_after_it():
    assert os.environ["BEGUN"] == "yes"
"""
PROGRAM = """
import os, sys, pytest
sys.path.insert(0, sys.argv[1])
from workers import Workers
def begin():
    os.environ["BEGUN"] = "yes"
workers = Workers(3, begin, lambda item: "kills" in item.name)
sys.exit(pytest.main(["-p", "no:cacheprovider", *sys.argv[2:]], [workers]))
"""


def outcome(tmp_path, monkeypatch, *options):
    """Return the exit code, what pytest printed, and what fixtures wrote as they ended."""
    path, ended = tmp_path / "test_theirs.py", tmp_path / "ended"
    path.write_text(TESTS)
    ended.write_text("")
    monkeypatch.setenv("ENDED", str(ended))
    helpers = __file__.rsplit("/", 2)[0]
    command = [sys.executable, "-c", PROGRAM, helpers, "-c", str(tmp_path / "none.ini"), *options]
    (tmp_path / "none.ini").write_text("[pytest]\n")
    run = subprocess.run(
        [*command, str(path)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )
    return run.returncode, run.stdout.decode(), ended.read_text()


def test_each_runs_once_and_what_fails_is_reported(tmp_path, monkeypatch):
    code, said, ended = outcome(tmp_path, monkeypatch)
    assert code == 1 and "2 failed, 21 passed, 1 warning" in said, said
    assert "why" in said and "what it printed" in said and "beware" in said
    assert "the process of this test ended with status 0x9" in said
    assert ended  # each process ends what it has begun


def test_the_first_failure_ends_all_where_that_is_asked(tmp_path, monkeypatch):
    code, said, ended = outcome(tmp_path, monkeypatch, "-x", "-k", "wrong or right")
    assert code == 1 and "stopping after 1 failures" in said and "1 failed" in said, said
