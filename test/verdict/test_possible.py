"""Recorded data that cannot be are remarked upon: jumps, and bodies in one place."""

import numpy as np
import pytest

from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.verdict.impossible_poses import first_jump, first_overlap, jump
from mrs_simulator.verdict.impossible_runs import impossibilities
from mrs_simulator.verdict.judging import judged


def track(m=50, n=4, apart=2.0, speed=0.2, period=0.1):
    """Return times (m,) and poses (m, n, 3) of robots abreast that go along x."""
    time = period * np.arange(m)
    pose = np.zeros((m, n, 3))
    pose[:, :, 0] = speed * time[:, np.newaxis]
    pose[:, :, 1] = apart * np.arange(n)
    return time, pose


def run_of(time, pose, **meta):
    scenario = load_scenario(scenario_path("lab_four.yaml")).changed(duration=float(time[-1]))
    n = pose.shape[1]
    return Run(
        time,
        np.arange(1, n + 1),
        pose,
        pose[:, :, :2],
        np.full(pose.shape[:2] + (2,), 0.1),
        scenario=scenario,
        meta=meta,
    )


def test_jumps_are_found():
    time, pose = track()
    assert first_jump(time, pose, np.full(4, 0.75)) is None
    pose[20:, 2, 0] += 0.5
    assert first_jump(time, pose, np.full(4, 0.75)) == (20, 2, pytest.approx(0.52))
    assert first_jump(time, pose, np.full(4, np.inf)) is None
    assert jump(pose[19], pose[20], 0.1, np.full(4, 0.75)) == (2, pytest.approx(0.52))
    assert jump(pose[18], pose[19], 0.1, 0.75) is None
    assert first_jump(time[:1], pose[:1], 0.75) is None


def test_a_gap_in_time_explains_a_way():
    time, pose = track(speed=0.7)
    keep = np.r_[0:10, 40:50]
    assert first_jump(time[keep], pose[keep], np.full(4, 0.75)) is None


def test_bodies_in_one_place_are_found():
    _, pose = track(apart=0.5)
    assert first_overlap(pose, 0.2) is None
    assert first_overlap(pose, [0.2, 0.2, 0.35, 0.2])[:3] == (0, 1, 2)
    pose[30, 3, 1] = pose[30, 2, 1] + 0.03
    assert first_overlap(pose, 0.2) == (30, 2, 3, pytest.approx(0.03))
    assert first_overlap(pose[:, :1], 0.2) is None


def test_a_real_run_with_robots_in_one_place_fails_its_verdict():
    time, pose = track()
    assert impossibilities(run_of(time, pose, collisions_unknown=True)) == []
    pose[25:, 1, 1] = pose[25:, 0, 1] + 0.03
    found = impossibilities(run_of(time, pose, collisions_unknown=True))
    said = [(each.name, each.holds, each.why) for each in found]
    assert said[0][:2] == ("no robot jumps", False) and "robot2 by 1.97 m" in said[0][2]
    assert said[1][:2] == ("bodies are apart", False)
    assert said[1][2] == "at 2.500 s robot1 and robot2 were 0.03 m apart, and fill 0.42 m"
    verdict, _ = judged(run_of(time, pose, collisions_unknown=True))
    assert verdict["outcome"] == "failed"
    failed = [check["name"] for check in verdict["checks"] if check["passed"] is False]
    assert failed == ["no robot jumps", "bodies are apart"]


def test_collisions_that_the_simulator_tells_of_are_left_to_it():
    time, pose = track(apart=0.1)
    assert impossibilities(run_of(time, pose)) == []
    scenario = load_scenario(scenario_path("paper.yaml")).changed(fidelity="point_mass")
    run = run_of(*track(n=7, apart=0.1), collisions_unknown=True)
    assert impossibilities(run._replace(scenario=scenario)) == []
    assert impossibilities(run._replace(scenario=None)) == []


def test_a_jump_up_is_a_jump_and_bodies_above_each_other_are_apart():
    time, pose = 0.1 * np.arange(10), np.zeros((10, 2, 3))
    z = np.zeros((10, 2))
    z[:, 1], z[6:, 1] = 1.0, 2.0
    assert first_jump(time, pose, 0.75) is None
    assert first_jump(time, pose, 0.75, z) == (6, 1, pytest.approx(1.0))
    pose[6:, 1] = np.nan  # it falls
    assert first_jump(time, pose, 0.75, z) is None
    pose[:] = 0.0
    assert first_overlap(pose, 0.2)[:3] == (0, 0, 1)
    assert first_overlap(pose, 0.2, z, np.array([0.5, 0.5])) is None
    assert first_overlap(pose, 0.2, z, np.array([1.1, 0.5]))[:3] == (0, 0, 1)
