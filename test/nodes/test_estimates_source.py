"""Samples of a run beside the estimates of their time: which wait, and which are left out."""

from types import SimpleNamespace

import numpy as np
import pytest

from mrs_simulator.nodes.record import estimates_source
from mrs_simulator.state.columns import ESTIMATE
from mrs_simulator.state.state_table import StateTable


@pytest.fixture
def source(monkeypatch):
    subscriber = SimpleNamespace(get_num_connections=lambda: 1)
    monkeypatch.setattr(estimates_source.rospy, "Subscriber", lambda *_, **__: subscriber)
    monkeypatch.setattr(estimates_source.rospy, "logerr_throttle", lambda *_: None)
    monkeypatch.setattr(estimates_source, "PATIENCE", -1.0)
    zeros = np.zeros((1, 3))
    idle = StateTable(1.0, pose=zeros, command=zeros[:, :2], commanded=np.zeros(1, bool))
    stage = SimpleNamespace(
        PACED=False, next=lambda _: idle, begin=lambda: None, meta=dict, warnings=list
    )
    return estimates_source.EstimatesSource(lambda: stage, 1)


def test_a_sample_without_estimates_is_left_out_once_the_run_has_begun(source):
    """Also one of robots that nobody commands any more: the file has a column for what is not there."""
    assert not source.next(0.0).has(ESTIMATE)
    source.begin()
    assert source.next(0.0) is None
    assert source.warnings()[0].startswith("1 samples are left out")
