"""The package's messages: what is packed comes back, old ones are read, broken ones are refused."""

from types import SimpleNamespace

import numpy as np
import pytest
import rospy

from mrs_simulator.core.spatial import upright
from mrs_simulator.msg import ControlStatus, TeamCommand, TeamState
from mrs_simulator.record.recording import Collision
from mrs_simulator.ros.message_forms import messages
from mrs_simulator.scenario.incidents import Incident
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.vehicles.registry import file_named
from mrs_simulator.vehicles.team import on_axes
from mrs_simulator.world.world import World

PLANAR = ("linear.x", "angular.z")
ALL = ("linear.x", "linear.y", "angular.z")
TWO = [[0.0, 0.0, 0.1], [5.0, 0.0, -0.2]]


def told(kinds, command):
    """Return the ``TeamState`` of a world of two robots under ``command``, and what is read of it."""
    world = World(kinds, TWO)
    world.set_commands([0, 1], command)
    message = messages.team_state(world, rospy.Time(3), "world", (7, 2))
    world.close()
    return message, messages.read_state(message)


def test_a_team_of_unicycles_tells_no_more_than_it_needs():
    message, state = told(("pioneer3dx",) * 2, [[0.2, 0.1], [0.3, -0.1]])
    empty = ("z", "orientation", "vz", "wx", "wy", "joint", "command_vy", "command_wx")
    assert all(len(getattr(message, name)) == 0 for name in empty)
    assert state.axes == PLANAR and messages.run_of(message) == (7, 2) and state.time == 3.0
    assert state.kinds == ("pioneer3dx",) * 2 and state.robots == (1, 2)
    np.testing.assert_array_equal(state.command, [[0.2, 0.1], [0.3, -0.1]])
    np.testing.assert_array_equal(state.pose, TWO)
    assert state.commanded.all() and not state.real.any()


def test_a_mixed_team_tells_the_commands_of_every_axis():
    _, state = told(("robotino3", "pioneer3dx"), [[0.2, 0.4, 0.1], [0.3, 0.0, -0.1]])
    assert state.axes == ALL and state.kinds == ("robotino3", "pioneer3dx")
    np.testing.assert_array_equal(state.command, [[0.2, 0.4, 0.1], [0.3, 0.0, -0.1]])
    np.testing.assert_array_equal(on_axes(state.command, ALL, PLANAR), [[0.2, 0.1], [0.3, -0.1]])


def test_a_message_of_the_first_version_is_read():
    names = ("x", "y", "theta", "vx", "vy", "omega", "command_v", "command_omega")
    fields = {name: [float(place)] for place, name in enumerate(names)}
    stamp = SimpleNamespace(stamp=rospy.Time(1))
    old = SimpleNamespace(header=stamp, robot=[4], commanded=[True], real=[False], **fields)
    state = messages.read_state(old)
    assert state.pose.tolist() == [[0.0, 1.0, 2.0]] and state.twist.tolist() == [[3.0, 4.0, 5.0]]
    assert state.command.tolist() == [[6.0, 7.0]] and state.axes == PLANAR
    assert state.kinds == () and state.joints.tolist() == [0.0] and messages.run_of(old) == (0, 0)


def test_commands_there_and_back():
    message = messages.team_command([1, 3], [[0.1, 0.2, 0.3], [0.4, 0.0, 0.6]], ALL)
    assert message.vy == [0.2, 0.0] and message.vz == []
    numbers, axes, command = messages.read_team_command(message)
    assert list(numbers) == [1, 3] and axes == ALL
    np.testing.assert_array_equal(command, [[0.1, 0.2, 0.3], [0.4, 0.0, 0.6]])


@pytest.mark.parametrize(
    "read, message, said",
    [
        (messages.read_team_command, TeamCommand(robot=[0], v=[0.0], omega=[0.0]), "robot 0"),
        (messages.read_team_command, TeamCommand(robot=[1, 2], v=[0.0]), "2 robots, 1 v"),
        (
            messages.read_team_command,
            TeamCommand(robot=[1], v=[0.0], omega=[0.0], vy=[0.0, 0.0]),
            "1 robots, 2 vy; wanted as many",
        ),
        (messages.read_state, TeamState(robot=[1]), "1 robots, 0 x"),
        (messages.read_control_status, ControlStatus(command_v=[1.0]), "0 command_omega"),
    ],
)
def test_arrays_that_do_not_fit_are_refused_by_name(read, message, said):
    with pytest.raises(messages.MessageError, match=said):
        read(message)


def test_what_a_controller_says_comes_back():
    message = messages.control_status(
        [[0.1, 0.2]], PLANAR, [(1, 2, 0.5)], [[3.0, 4.0]], protocol="Law", running=True, period=0.1
    )
    controller = messages.read_control_status(message)
    assert controller.edges == ((1, 2, 0.5),) and controller.targets.tolist() == [[3.0, 4.0]]
    assert controller.command.tolist() == [[0.1, 0.2]] and controller.protocol == "Law"
    assert messages.read_control_status(messages.control_status([], PLANAR, [], None)).edges == ()


@pytest.mark.parametrize(
    "content, named",
    [
        ({"model": "pioneer3dx"}, ""),
        ({"model": "/tmp/a.xacro"}, "/tmp/a.xacro"),
        ({"model": "b", "kinds": {"b": {"base": "pioneer3dx", "mass": 3}}}, ""),
        ({"model": "b", "kinds": {"b": {"base": "a.yaml"}}}, "kinds.b.base"),
        ({"model": "b", "kinds": {"b": {"import": {"urdf": "a.urdf"}}}}, "kinds.b.import"),
        ({"model": "b", "kinds": {"b": {"base": "husky", "model": "a.urdf"}}}, "kinds.b.model"),
    ],
)
def test_a_scenario_from_elsewhere_is_searched_for_files(content, named):
    assert file_named(scenario_from_dict({"poses": TWO, **content})) == named


def test_height_orientation_and_full_twist_there_and_back():
    pose, twist = np.array(TWO), np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
    spatial = upright(pose[:, 2], [1.0, 0.0])._replace(twist=np.array([[1.0, 2, 3], [4, 5, 6]]))
    message = messages.team_odometry((1, 2), pose, twist, rospy.Time(1), spatial)
    numbers, *came = messages.read_odometry(message)
    assert list(numbers) == [1, 2]
    np.testing.assert_array_equal(came[0], pose)
    np.testing.assert_array_equal(came[1], twist)
    for read, wrote in zip(came[2], spatial):
        np.testing.assert_array_equal(read, wrote)
    assert messages.read_odometry(messages.team_odometry((1, 2), pose, twist))[3] is None
    # A robot of which no orientation is told stands upright.
    message.orientation = []
    read = messages.read_odometry(message)[3]
    np.testing.assert_array_equal(read.orientation, spatial.orientation)
    message.vz = [0.0]
    with pytest.raises(messages.MessageError, match="2 robots, 1 vz; wanted as many"):
        messages.read_odometry(message)


def test_collisions_and_robots_to_place_have_a_height():
    collision = Collision(2.0, "robot1", "robot2", 1.0, 2.0, 3.0)
    message = messages.collision_message(collision, rospy.Time(2), "world")
    assert messages.read_collision(message) == collision
    names = ("header", "first", "second", "x", "y")
    old = SimpleNamespace(**{name: getattr(message, name) for name in names})
    assert messages.read_collision(old) == collision._replace(z=0.0)
    specs = messages.robot_specs(("", "husky"), TWO, [0.0, 1.5])
    assert messages.read_robot_specs(specs, "epuck") == (["epuck", "husky"], TWO, [0.0, 1.5])


def test_several_joints_of_a_robot_are_published_one_robot_after_the_other():
    message, _ = told(("f1tenth", "pioneer3dx"), [[0.2, 0.1], [0.3, -0.1]])
    message.joint = [0.1, 0.2, 0.3, 1.1, 0.0, 0.0]
    state = messages.read_state(message)
    assert state.joints.tolist() == [[0.1, 0.2, 0.3], [1.1, 0.0, 0.0]]
    message.joint = [0.1, 0.2, 0.3]
    with pytest.raises(messages.MessageError, match="2 robots, 3 joint; wanted as many of each"):
        messages.read_state(message)


def test_targets_in_space_have_their_heights():
    places = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    for targets in (places, places[:, :2]):
        message = messages.control_status(np.zeros((2, 2)), PLANAR, (), targets)
        np.testing.assert_array_equal(messages.read_control_status(message).targets, targets)
    message = messages.control_status(np.zeros((2, 2)), PLANAR, (), places)
    message.target_z = [3.0]
    with pytest.raises(messages.MessageError, match="2 target_x, 2 target_y, 1 target_z"):
        messages.read_control_status(message)


def test_incidents_are_reported_and_unknown_ones_refused():
    incident = Incident(4.0, "robot2", "rotor_lost", 3, True)
    message = messages.incident_message(incident, rospy.Time(4))
    assert messages.read_incident(message) == incident
    message.what = "exploded"
    with pytest.raises(messages.MessageError, match="incident 'exploded', wanted one of"):
        messages.read_incident(message)
