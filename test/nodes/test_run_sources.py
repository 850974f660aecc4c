"""A recorded run ends where the stage begins another."""

import numpy as np
import pytest
import rospy

from mrs_simulator.control.guards import JumpBounds, Tracks
from mrs_simulator.core.spatial import upright
from mrs_simulator.msg import Incident, StageStatus, TeamState
from mrs_simulator.nodes.record import run_sources
from mrs_simulator.ros.message_forms.planar_messages import QuickTwist
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.state.columns import SPATIAL
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.team_in_space import team_of

PERIOD = 0.02  # [s]
TWIST = [[0.3, 0.1, 0.2], [0.0, 0.0, 0.0]]


@pytest.fixture
def source(monkeypatch):
    return stage_source(monkeypatch, Team.from_scenario(paper()))


def paper():
    return load_scenario(scenario_path("paper.yaml")).with_robots(2)


def stage_source(monkeypatch, team):
    monkeypatch.setattr(run_sources.rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(run_sources.rospy, "logerr_throttle", lambda *_: None)
    return run_sources.StageSource(team)


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


@pytest.mark.parametrize(
    "field, value, why",
    [
        ("theta", [0.0], "state: 2 robots, 1 theta; wanted as many of each"),
        ("joint", [0.0] * 3, "state: 2 robots, 3 joint; wanted as many of each robot"),
        ("joint", [0.0, np.nan], "state: column joints of robot2 is not finite"),
        ("y", [np.inf, 0.0], "state: column pose of robot1 is not finite"),
        ("z", [0.0, np.nan], "state: column z of robot2 is not finite"),
        ("command_v", [0.0, np.nan], "state: column command of robot2 is not finite"),
        ("command_arm", [0.1, 0.2], "state: axes linear.x, angular.z, arm.1 and 1 joints"),
    ],
)
def test_a_malformed_state_is_refused_and_counted(source, field, value, why):
    heard(source, state(1.0))
    source.begin()
    broken = state(1.0 + PERIOD)
    setattr(broken, field, value)
    assert heard(source, broken, state(1.0 + 2.0 * PERIOD)) == [False, True]
    assert not source.broken()
    assert source.warnings()[0].startswith("1 messages of the stage are left out: " + why)
    assert source.silence().startswith("the stage fell silent, refused: " + why)


def test_states_of_a_team_without_the_arms_of_the_run_are_refused(monkeypatch):
    carrying = load_scenario(scenario_path("carrying.yaml"))
    source = stage_source(monkeypatch, team_of(carrying))
    assert heard(source, state(1.0, (0.0, 2.0, 4.0))) == [False]
    assert "wanted linear.x, angular.z, arm.1" in source.silence()


def test_an_unknown_incident_is_refused_and_counted(source):
    source.begin()
    source._on_incident(Incident(robot=1, what="evaporated"))
    assert not source.incidents and "incidents: incident 'evaporated'" in source.warnings()[0]


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


class Frame:
    """A common frame of robots that stand at the origin and move by ``TWIST``."""

    numbers = (1, 2)

    def __init__(self):
        self.tracks = Tracks(2, [JumpBounds(0.2, 0.5, 1.0)] * 2)
        for row in (0, 1):
            self.put(row, 0.0, 0.0)

    def put(self, row, x, now):
        """Report robot ``row`` at ``x`` [m] at ``now`` [s]."""
        self.tracks.take(row, (x, 0.0, 0.0), (now, now))

    def jumped(self):
        return self.tracks.jumps

    def jump_texts(self):
        return {row: "robot{} {}".format(row + 1, jump) for row, jump in self.jumped().items()}

    def accept(self):
        self.tracks.accept()

    def missing(self, _):
        return ""

    def pose(self):
        return self.tracks.pose.copy()

    def twists(self):
        return np.array(TWIST)

    def spatial(self):
        return upright(np.zeros(2), [1.0, 2.0])


def real(monkeypatch, kinds):
    """Return the source of two real robots of ``kinds``."""
    monkeypatch.setattr(run_sources.rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(run_sources.rospy, "get_time", lambda: 1.0)
    monkeypatch.setattr(run_sources, "make_common_frame", lambda _: Frame())
    monkeypatch.setattr(run_sources, "command_topics", lambda _: ["/a", "/b"])
    scenario = load_scenario(scenario_path("paper.yaml")).with_robots(2)._replace(kinds=kinds)
    return run_sources.RobotsSource(scenario, Team.from_scenario(scenario))


def test_real_robots_are_recorded_with_twists_and_heights(monkeypatch):
    sample = real(monkeypatch, ("crazyflie2", "robotino3")).next(1.0)
    assert sample.twist.tolist() == TWIST and sample.spatial.z.tolist() == [1.0, 2.0]
    sample = real(monkeypatch, ("robotino3", "robotino3")).next(1.0)
    assert sample.twist.tolist() == TWIST and not sample.has(SPATIAL)


def test_a_jump_before_the_run_is_no_part_of_it_and_one_in_it_ends_it(monkeypatch):
    source = real(monkeypatch, ("pioneer3dx", "pioneer3dx"))
    source.frame.put(1, 3.0, 0.1)  # its driver was restarted
    assert source.next(1.0).pose[1, 0] == 3.0 and not source.broken()
    source.frame.put(1, 4.0, 0.2)  # once more, just before the first command
    assert source.next(1.0).pose[1, 0] == 4.0
    source.begin()
    assert not source.broken()
    source.frame.put(1, 4.02, 0.3)
    assert source.next(1.0).pose[1, 0] == 4.02 and not source.broken()
    source.frame.put(0, 1.0, 0.4)
    assert source.next(1.0).pose[0, 0] == 0.0
    assert source.broken().startswith("robot1 jumped by 1.00 m")


def test_real_cars_are_recorded_with_the_steering_to_which_commands_lead(monkeypatch):
    clock = iter(np.arange(100.0, 110.0, 0.01))
    monkeypatch.setattr(run_sources.time, "monotonic", lambda: next(clock))
    source, told = real(monkeypatch, ("f1tenth", "pioneer3dx")), QuickTwist()
    assert source.next(1.0).joints.tolist() == [0.0, 0.0]
    told.values = (1.0, 0.0, 0.0, 0.0, 0.0, 0.5)
    for _ in range(50):
        source._on_command(told, 0)
        source._on_command(told, 1)
    (car, wheels), team = source.next(1.0).joints, source._team
    (group,) = team.jointed
    wanted = group.inner_command(np.array([[1.0, 0.5]]), np.zeros(1))
    assert car == pytest.approx(float(group.joints_of(wanted)[0])) and car > 0.1 and wheels == 0.0
