"""The preset rosaria: what a Pioneer behind the driver does, without ROS and over it."""

import math

import numpy as np
import pytest
from ros_fixtures import PATIENCE, log_of, wait_until
from test_stage_node import start

from mrs_simulator.core.kinematics import Limits
from mrs_simulator.nodes.stage.driver_presets.rosaria import behind_rosaria, driver_commands
from mrs_simulator.scenario.scenario import scenario_from_dict, scenario_from_yaml
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.vehicles import Team

# Factory settings of the Pioneer's firmware, in m and rad.
FIRMWARE_LIMITS = Limits(0.75, math.radians(100.0), 0.3, math.radians(100.0))

PRESET = "_preset:=rosaria"
FAST = "_speed:=3"  # as far as commands at 20 Hz of wall time come before the driver's watchdog
TOP_TURN = math.radians(100.0)  # [rad/s]


@pytest.mark.parametrize(
    "given, expected",
    [
        ([0.3, 0.3], [0.3, 0.29670597]),  # as measured: 17 deg/s
        ([0.00149, 0.0087], [0.001, 0.0]),
        ([-0.0017, -0.3], [-0.002, -0.29670597]),
        ([2.0, -9.0], [0.75, -TOP_TURN]),
        ([np.nan, 0.2], [0.0, math.radians(11.0)]),
        ([0.2, np.inf], [0.2, TOP_TURN]),
        ([0.2, -np.inf], [0.2, -TOP_TURN]),
        ([0.2, np.nan], [0.2, 0.0]),
    ],
)
def test_commands_are_whole_and_never_beyond_the_robot(given, expected):
    done = driver_commands(np.array([given]), np.array(FIRMWARE_LIMITS[:2]))
    np.testing.assert_allclose(done, [expected], atol=1e-8)


def test_the_scenario_gets_the_drivers_odometry_limits_and_watchdog():
    given = {
        "poses": [[1.0, 2.0, 0.5]],
        "limits": Limits(3.0, 9.0, 9.0, 9.0)._asdict(),
        "cmd_vel_timeout": 2.0,
    }
    changed = behind_rosaria(scenario_from_dict(given))
    assert (changed.odometry, changed.limits, changed.cmd_vel_timeout) == ("wheel", "firmware", 0.6)
    with pytest.raises(ValueError, match="preset rosaria: fidelity point_mass, wanted kinematic"):
        behind_rosaria(scenario_from_dict(dict(given, fidelity="point_mass")))


def test_the_sensors_are_what_the_driver_tells():
    given = {"poses": [[0.0, 0.0, 0.0]] * 2, "model": ["pioneer3dx", "turtlebot3_burger"]}
    own = [{"robots": 1, "mounts": {"bumper": None, "sonar": {"turns": 1}}}]
    for sensors, names, turns in (
        ([], ["sonar", "bumper", "battery"], 8),
        (own, ["sonar", "battery"], 1),
    ):
        changed = behind_rosaria(scenario_from_dict(dict(given, sensors=sensors)))
        mounts = fitted_mounts(Team.from_scenario(changed), changed.sensors)
        assert [mount.name for mount in mounts[0]] == names
        assert mounts[0][0].settings[-2:] == (turns, 0.04)
        assert dict(mounts[0][0].noise)[""].quantum == 0.001
        assert mounts[0][-1].rate == 10.0 and dict(mounts[0][-1].noise)[""].quantum == 0.1
        assert [mount.name for mount in mounts[1]] == ["laser"]
        again = behind_rosaria(scenario_from_yaml(changed.to_yaml()))
        assert again.to_yaml() == changed.to_yaml()  # the scenario of a run starts the same one


def test_odometry_and_topics_are_the_drivers(ros):
    _, probe = start(ros, "--robots", 1, PRESET, FAST)
    probe.ask("listen('/robot1/odom', Odometry)")
    odom = probe.wait("odom(1)")
    assert {tuple(each) for each in probe.ask("rospy.get_published_topics('/robot1')")} >= {
        ("/robot1/battery_recharge_state", "std_msgs/Int8"),
        ("/robot1/battery_state_of_charge", "std_msgs/Float32"),
        ("/robot1/battery_voltage", "std_msgs/Float64"),
        ("/robot1/bumper_state", "rosaria/BumperState"),
        ("/robot1/motors_state", "std_msgs/Bool"),
        ("/robot1/sonar", "sensor_msgs/PointCloud"),
        ("/robot1/sonar_pointcloud2", "sensor_msgs/PointCloud2"),
    }
    assert odom["pose"] == [0.0, 0.0, 0.0] and odom["covariance"] == [0.0] * 36
    assert probe.ask("list(newest['/robot1/odom'].twist.covariance)") == [0.0] * 36
    # Stamps lie 0.1 s apart, however few of them come through.
    later = probe.wait("odom(1)['stamp'] > {} and odom(1)".format(odom["stamp"]))
    assert (later["stamp"] - odom["stamp"]) % 100000000 == 0
    probe.ask("drive([1], 5.0, 0.0)")
    probe.wait("0.7 < (state('vx') or [0])[0] <= 0.75 and state('command_v') == [0.75]")
    probe.wait("odom(1)['pose'][0] > 0.5")


def test_commands_are_rounded_and_what_is_not_finite_is_replaced_and_counted(ros):
    stage, probe = start(ros, "--robots", 3, "--preset", "rosaria")
    probe.ask("drive([1], 0.1004, 0.3) and drive([2], float('nan'), 0.2)")
    probe.ask("drive([3], 0.1, float('-inf'))")
    told = "(lambda s: all(s.get('commanded') or [False]) and [s['command_v'], s['command_omega']])"
    v, omega = probe.wait(told + "(plain('/stage/state'))")
    assert v == pytest.approx([0.1, 0.0, 0.1])
    assert omega == pytest.approx([math.radians(17.0), math.radians(11.0), -TOP_TURN])
    probe.wait("(status('refused') or [0] * 3)[1] >= 3 and status('refused')[2] >= 3")
    assert probe.ask("status('refused')[0]") == 0
    wait_until(lambda: "robot2, robot3: not finite" in log_of(stage))


def test_the_watchdog_stops_a_silent_robot(ros):
    stage, probe = start(ros, "--robots", 1, PRESET)
    probe.ask("drive([1], 0.3, 0.0)")
    probe.wait("(state('vx') or [0])[0] > 0.2")
    probe.ask("release()")
    probe.wait("status('timed_out') == [1] and state('vx') == [0.0]")
    wait_until(lambda: "robot1 stopped: no command for 0.6 s" in log_of(stage))


def test_the_watchdog_looks_every_tenth_of_a_second(ros):
    _, probe = start(ros, "--robots", 1, PRESET, "_paused:=true")

    def step(steps):
        now = probe.ask("now()")
        assert probe.wait("call('/stage/step', StepStage, {})".format(steps))[0] is True
        probe.wait("abs(now() - {!r}) < 1e-6".format(now + 0.02 * steps))
        return probe.wait("[state('commanded')] if abs(stamp() - now()) < 1e-6 else None")[0]

    probe.wait("state('commanded')")
    step(2)
    probe.ask("drive([1], 0.1, 0.0)")
    probe.wait("state('commanded') == [True]")
    probe.ask("release()")
    probe.wait("counts['clock'] > {} + 10".format(probe.ask("counts['clock']")))
    # Silent for 0.6 s at 0.64 s; looked at 0.7 s.
    assert step(33) == [True]
    assert step(1) == [False]


def test_disabled_motors_ignore_commands_and_odometry_goes_on(ros):
    _, probe = start(ros, "--robots", 2, PRESET, FAST)
    probe.ask("[listen('/robot{}/motors_state'.format(n), Bool) for n in (1, 2)]")
    probe.ask("listen('/robot1/odom', Odometry) and drive([1, 2], 0.3, 0.0)")
    probe.wait("plain('/robot1/motors_state').get('data')")
    probe.wait("min(state('vx') or [0]) > 0.2")
    assert probe.ask("switch('/robot1/disable_motors')")
    probe.wait("plain('/robot1/motors_state')['data'] is False")
    probe.wait("state('vx')[0] == 0.0")
    probe.wait_simulated(0.5)
    probe.wait("state('commanded')[0] and state('vx')[1] > 0.2")
    assert probe.ask("state('vx')[0]") == 0.0
    assert probe.wait("plain('/robot2/motors_state')")["data"] is True
    seen = probe.ask("odom(1)['stamp']")
    probe.wait("odom(1)['stamp'] > {}".format(seen))
    # Asked twice, told once: the topic is published on change.
    told = probe.ask("counts['/robot1/motors_state']")
    assert probe.ask("switch('/robot1/disable_motors')")
    assert probe.ask("switch('/robot1/enable_motors')")
    probe.wait("plain('/robot1/motors_state')['data'] and state('vx')[0] > 0.2")
    assert probe.ask("counts['/robot1/motors_state']") == told + 1


def test_motors_come_and_go_with_the_team_and_real_robots_have_their_own(ros):
    _, probe = start(ros, "--robots", 3, "--real", 2, PRESET)
    topics = "sorted(name for name, _ in rospy.get_published_topics() if 'motors' in name)"
    states = ["/robot{}/motors_state".format(robot) for robot in (1, 3)]
    probe.wait("{} == {}".format(topics, states))
    assert probe.ask("set_team([[0, 0, 0], [5, 0, 0]])") == [True, "2 robots"]
    probe.wait("{} == {}".format(topics, states[:1]))


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["--preset", "p2os"], "preset = 'p2os': wanted one of none, rosaria"),
        (["_preset:=3"], "wanted one of none, rosaria"),
        (["--fidelity", "point_mass", PRESET], "fidelity point_mass, wanted kinematic or dynamic"),
    ],
)
def test_what_cannot_be_is_said(ros, arguments, said):
    stage = ros.node("stage", *arguments)
    assert stage.wait(PATIENCE) == 2
    assert said in log_of(stage) and "Traceback" not in log_of(stage)
