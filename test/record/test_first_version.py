"""Recordings of the first version, kept in ``data/first_version``, are read for ever.

The bags hold the messages as they were defined then: two robots on their way to each other over
ROS in lockstep, by the topics of whole teams (``stage.bag``) and by each robot's own (``robots.bag``).
"""

import os

import numpy as np
import pytest

from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.record.recording import Recorder, read_run_csv
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.results.bag_reading import read_bag
from mrs_simulator.verdict.verdict import judge

DATA = os.path.join(
    os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "data", "first_version"
)
LAST_POSE = [
    [0.7706596409, 0.1885656621, 0.1152170450],
    [1.2518803029, 0.2656832250, -2.6230281227],
]
LAST_COMMAND = [[0.1954540493, 0.0165906001], [0.1800948943, -1.5190526739]]


def path(name):
    return os.path.join(DATA, name)


def test_a_run_file_is_read_and_written_again_to_the_byte(tmp_path):
    scenario = load_scenario(path("scenario.yaml"))
    run = read_run_csv(path("run.csv"), scenario)
    assert run.pose.shape == (16, 2, 3) and run.command.shape == (16, 2, 2)
    assert len(run.collisions) == 1 and run.meta["ended"] == "complete"
    with Recorder(str(tmp_path / "run.csv"), run.robots, scenario.hand_length) as recorder:
        for stamp, pose, command, hand in zip(run.time, run.pose, run.command, run.hand):
            recorder.sample(stamp, StateTable(pose=pose, command=command, hand=hand))
    with open(path("run.csv"), "rb") as old:
        assert (tmp_path / "run.csv").read_bytes() == old.read()
    # The sines of other processors and libraries differ in the last bit.
    np.testing.assert_allclose(hand_points(run.pose, scenario.hand_length), run.hand, atol=1e-12)
    assert judge(run)["passed"] is False  # they collide


def test_a_bag_of_the_stages_states_is_read():
    run = read_bag(path("stage.bag"))
    assert len(run.time) == 16 and run.time[-1] == pytest.approx(3.0)
    np.testing.assert_allclose(run.pose[-1], LAST_POSE, atol=1e-9)
    np.testing.assert_allclose(run.command[-1], LAST_COMMAND, atol=1e-9)
    assert [c.first for c in run.collisions] == ["robot1", "robot1"]
    assert run.scenario.control.protocol == "consensus"


def test_a_bag_of_the_robots_own_topics_is_read():
    run = read_bag(path("robots.bag"))
    np.testing.assert_allclose(run.pose[-1, 0], [0.768622, 0.188330, 0.115073], atol=1e-6)
    np.testing.assert_allclose(run.command[-1, 1], [0.178252, -1.745329], atol=1e-6)
    assert run.meta["collisions_unknown"] is True
