"""A recorded run ends where the stage begins another."""

import pytest
import rospy

from mrs_simulator.core.scenario import load_scenario
from mrs_simulator.msg import StageStatus, TeamState
from mrs_simulator.nodes.record import run_sources
from mrs_simulator.study.shipped import scenario_path
from mrs_simulator.vehicles import Team

PERIOD = 0.02  # [s]


@pytest.fixture
def source(monkeypatch):
    monkeypatch.setattr(run_sources.rospy, "Subscriber", lambda *_, **__: None)
    scenario = load_scenario(scenario_path("paper.yaml")).with_robots(2)
    return run_sources.StageSource(Team.from_scenario(scenario))


def state(stamp, x=(0.0, 2.0), stage=7, run=0):
    n = len(x)
    message = TeamState(stage=stage, run=run, robot=list(range(1, n + 1)), x=list(x))
    message.header.stamp = rospy.Time.from_sec(stamp)
    for name in ("y", "theta", "vx", "vy", "omega", "command_v", "command_omega"):
        setattr(message, name, [0.0] * n)
    message.commanded, message.real = [True] * n, [False] * n
    message.kind = ["pioneer3dx"] * n
    return message


def heard(source, *states):
    """Return whether each of ``states`` is a sample of the run."""
    for each in states:
        source._queue.put(each)
    return [source.next(0.0) is not None for _ in states]


@pytest.mark.parametrize(
    "what, said",
    [
        ({"stage": 8}, "the stage was started again"),
        ({"run": 1}, "the stage was reset, or given another team"),
        ({"x": (0.0, 2.0, 4.0)}, "given another team"),
        ({"stamp": 3.0}, "simulated time went back"),
        ({"x": (0.0, 2.5)}, "robot2 jumped by 0.50 m within 0.020 s"),
    ],
)
def test_what_comes_after_a_break_is_no_part_of_the_run(source, what, said):
    # Before the run began the stage may do what it likes.
    assert heard(source, state(8.0, stage=1), state(1.0), state(2.0, run=0)) == [True] * 3
    source.begin()
    assert heard(source, state(5.0), state(5.0 + PERIOD)) == [True, True] and not source.broken()
    broken = state(**{"stamp": 5.0 + 2.0 * PERIOD, **what})
    assert heard(source, broken, state(5.0 + 3.0 * PERIOD)) == [False, False]
    assert said in source.broken()


def test_a_run_whose_commands_simulated_time_outran_says_so(source):
    def told(stamp, missed, periods):
        message = StageStatus(robots=2, missed_periods=missed, command_periods=periods)
        message.header.stamp = rospy.Time.from_sec(stamp)
        source._on_status(message)

    told(1.0, 0, 50)
    told(2.0, 60, 150)  # before the run
    heard(source, state(2.0))
    source.begin()
    told(2.2, 60, 170)
    told(12.2, 90, 1170)
    assert "degraded" not in source.meta()
    told(22.2, 200, 2170)
    assert "timing was degraded: 7%" in source.meta()["degraded"]


def test_a_team_that_drives_fast_is_no_break(source):
    heard(source, state(1.0))
    source.begin()
    states = [state(1.0 + k * PERIOD, (0.75 * k * PERIOD, 2.0)) for k in range(1, 100)]
    assert all(heard(source, *states)) and not source.broken()
