"""The tutorial that ends on two Pioneers, word for word, with the stand-ins that it starts itself."""

import json
import re
import subprocess

import pytest
from documentation import ROOT, page
from ros_fixtures import wait_until

TEXT = page("tutorial_robots.md")
BLOCKS = re.findall(r"^```sh\n(.*?)^```$", TEXT, re.M | re.S)
MARKS = ("experiment", "simulation.launch", "roscore", "rosaria_robot.py", "drivers:=false")
MARKS += ("preflight", "pioneer_control/start", "ports:=", "--compare")


def test_its_commands_are_those_that_are_tried_here():
    assert len(BLOCKS) == len(MARKS)
    assert all(mark in block for mark, block in zip(MARKS, BLOCKS))
    lab, robots = BLOCKS[4], BLOCKS[7]  # the robots' differs in its drivers alone
    assert re.sub(r"drivers:=\S+", "", lab).split() == re.sub(r"ports:=\S+", "", robots).split()


def outcome(run):
    return json.loads((run / "verdict.json").read_text())["outcome"]


@pytest.mark.release
def test_the_tutorial_of_two_pioneers_runs_as_it_stands(ros, tmp_path):
    for name, content in re.findall(r'```\w+ title="([^"]+)"\n(.*?)```', TEXT, re.S):
        (tmp_path / name).write_text(content)
    ros.environment["CLONE"] = ROOT
    commands = dict(zip(MARKS, (["bash", "-c", block] for block in BLOCKS)))
    given = {"cwd": str(tmp_path), "env": ros.environment}

    def done(mark):
        return subprocess.run(
            commands[mark], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=240, **given
        )

    for mark, name in (("experiment", "ideal"), ("simulation.launch", "rehearsal")):
        ended = done(mark)
        assert ended.returncode == 0, ended.stdout.decode()
        assert outcome(tmp_path / name) == "passed"
    ended = "trap 'kill $(jobs -p)' INT TERM\n{}wait\n".format(BLOCKS[3])
    ros.start("robots", ["bash", "-c", ended], directory=str(tmp_path))
    ros.start("lab", commands["drivers:=false"], directory=str(tmp_path))
    wait_until(lambda: done("preflight").returncode == 0)
    assert b"success: True" in done("pioneer_control/start").stdout
    wait_until(lambda: (tmp_path / "monday" / "verdict.json").exists())
    assert outcome(tmp_path / "monday") == "passed"
    compared = done("--compare").stdout.decode()
    assert "as a scenario takes it: mismatch: {delay:" in compared, compared
