"""A stage waits for all that its recorders subscribe to."""

from mrs_simulator.nodes.stage.readiness import RESTING, Recorders


def test_a_recorder_is_complete_once_no_further_connection_comes():
    now, connected = [10.0], [4]
    recorders = Recorders(2, lambda: connected[0], lambda: now[0])
    assert recorders.missing(1, "/stage/state") == "1 recorders on /stage/state"
    assert recorders.missing(2, "/stage/state") == "the recorders' other topics"
    now[0] += 0.9 * RESTING
    connected[0] += 1  # that of a sensor
    assert recorders.missing(2, "/stage/state")
    now[0] += 0.9 * RESTING
    assert recorders.missing(2, "/stage/state")
    now[0] += 0.2 * RESTING
    assert recorders.missing(2, "/stage/state") == ""


def test_without_recorders_a_stage_waits_for_nothing():
    assert Recorders(0, lambda: 1 / 0).missing(0, "/stage/state") == ""
