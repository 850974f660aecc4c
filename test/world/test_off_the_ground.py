"""Robots that leave the ground go through every room: world, control, recording, ROS, displays."""

import numpy as np
import pytest
from flying_fixtures import hoverer  # noqa: F401, a fixture

from mrs_simulator.control.pioneer_control import PioneerControl, Position
from mrs_simulator.control.twists import make_twist
from mrs_simulator.core.kinematics import compose, relative
from mrs_simulator.core.spatial import headings, turned, turned_about_z
from mrs_simulator.protocols.making import make_control
from mrs_simulator.ros.message_forms.messages import team_state
from mrs_simulator.ros.message_forms.planar_messages import PlanarOdometry
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.surroundings.obstacles import Box
from mrs_simulator.state.columns import Z
from mrs_simulator.study.results.report import read_run
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.vehicles import Team
from mrs_simulator.world.world import EVERY, World, WorldError


def flight(kind, content=()):
    """Return a scenario of two hoverers beside a Pioneer, at 2 m, 1 m and on the ground."""
    plain = {
        "poses": [[0, 0, 0.5], [3, 0, 0], [6, 0, 0]],
        "kind": [kind, kind, "pioneer3dx"],
        "altitude": [2.0, 1.0, 0.0],
        "duration": 2.0,
        "control": {"protocol": "consensus"},
        "topology": {"preset": "complete"},
    }
    return scenario_from_dict(dict(plain, **dict(content)))


def world_of(kind, poses, z, **options):
    return World((kind,) * len(poses), poses, z=z, **options)


def test_frames_there_and_back():
    origin = np.array([[1.0, 2.0, 0.7], [-1.0, 0.5, -2.0]])
    pose = np.array([[0.3, -0.2, 3.0], [4.0, 1.0, -3.0]])
    np.testing.assert_allclose(relative(origin, compose(origin, pose)), pose, atol=1e-12)
    angle = np.array([0.4, -2.0])
    np.testing.assert_allclose(
        turned(turned_about_z(angle), 0.3), turned_about_z(angle + 0.3), atol=1e-15
    )


def test_a_team_is_moved_in_space(hoverer):  # noqa: F811
    world = World((hoverer, "pioneer3dx"), [[0.0, 0.0, np.pi / 2], [5.0, 0.0, 0.0]], z=[1.0, 0.0])
    assert world.team.axes == ("linear.x", "linear.y", "linear.z", "angular.z")
    for _ in range(50):
        world.set_commands(EVERY, np.array([[0.4, 0.0, 0.2, 0.0], [0.3, 0.0, 0.0, 0.0]]))
        world.step()
    # Ramps of 2 and 1 m/s^2 cost 0.04 and 0.02 m; ahead is to the left of the common frame.
    np.testing.assert_allclose(world.pose[0], [0.0, 0.36, np.pi / 2], atol=1e-12)
    np.testing.assert_allclose(world.z, [1.18, 0.0], atol=1e-12)
    np.testing.assert_allclose(world.twist[0], [0.4, 0.0, 0.0], atol=1e-12)
    spatial = world.spatial
    np.testing.assert_allclose(spatial.twist, [[0.2, 0.0, 0.0], [0.0, 0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(headings(spatial.orientation), world.pose[:, 2], atol=1e-9)
    # It leans ahead by 0.1 rad for each m/s, the Pioneer stands upright.
    assert spatial.orientation[1].tolist() == [0.0, 0.0, 0.0, 1.0]
    up = 1.0 - 2.0 * (spatial.orientation[0, :2] ** 2).sum()
    assert up == pytest.approx(np.cos(0.04))
    world.reset()
    assert world.z.tolist() == [1.0, 0.0] and not world.spatial.twist.any()


def test_wheel_odometry_of_robots_without_wheels_is_what_they_know(hoverer):  # noqa: F811
    world = World((hoverer, "pioneer3dx"), [[1.0, 2.0, 1.0], [5.0, 0.0, 0.0]], z=[1.0, 0.0],
                  odometry_kind="wheel")  # fmt: skip
    assert not world.estimates.odometry().any()
    for _ in range(50):
        world.set_commands(EVERY, np.array([[0.4, 0.1, 0.2, 0.3], [0.3, 0.0, 0.0, 0.0]]))
        world.step()
    np.testing.assert_allclose(world.estimates.pose()[0], world.pose[0], atol=1e-12)
    assert np.abs(world.estimates.odometry()[0] - world.pose[0]).max() > 0.5
    told = world.estimates.spatial()
    np.testing.assert_allclose(
        headings(told.orientation[0]), world.estimates.odometry()[0, 2], atol=1e-9
    )
    assert told.z[0] == world.z[0] == world.estimates.z()[0]


@pytest.mark.parametrize(
    "z, said",
    [
        ([0.0, 1.0], "robot2: height 1 m, but a Pioneer 3-DX stays on the ground; wanted 0"),
        ([-1.0, 0.0], "robot1: height -1.0 m, wanted from 0"),
        ([np.nan, 0.0], "robot1: height nan m"),
        ([1.0], r"heights of shape \(1,\): wanted one of 2 robots"),
    ],
)
def test_heights_that_cannot_be_are_refused(hoverer, z, said):  # noqa: F811
    with pytest.raises(WorldError, match=said):
        World((hoverer, "pioneer3dx"), [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]], z=z)


def test_robots_above_each_other_do_not_touch(hoverer):  # noqa: F811
    here = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    with pytest.raises(WorldError, match="robot1 and robot2 overlap"):
        world_of(hoverer, here, [1.0, 1.05])
    world = world_of(hoverer, here, [1.0, 1.2])
    for _ in range(20):
        world.step()
    assert world.contacts.take() == [] and world.motion.closest() == pytest.approx(0.2)
    # Bodies of 0.1 m: the upper one comes down upon the other, which gives way by half.
    for _ in range(40):
        world.set_commands(EVERY, np.array([[0.0] * 4, [0.0, 0.0, -0.2, 0.0]]))
        world.step()
    (collision,) = world.contacts.take()
    assert collision.z == pytest.approx(1.1, abs=0.01)
    assert world.z[1] - world.z[0] == pytest.approx(0.1, abs=1e-6)
    np.testing.assert_allclose(world.pose[:, :2], 0.0, atol=1e-12)
    assert 0.8 < world.z[0] < 1.0


def test_robots_that_meet_across_part_across(hoverer):  # noqa: F811
    world = world_of(hoverer, [[0.0, 0.0, 0.0], [0.6, 0.0, np.pi]], [1.0, 1.02])
    for _ in range(60):
        world.set_commands(EVERY, np.tile([0.3, 0.0, 0.0, 0.0], (2, 1)))
        world.step()
    assert len(world.contacts.take()) == 1
    assert world.pose[1, 0] - world.pose[0, 0] == pytest.approx(0.4, abs=1e-6)
    np.testing.assert_allclose(world.z, [1.0, 1.02], atol=1e-12)


def test_a_pioneer_carries_who_lands_on_it_and_none_sinks(hoverer):  # noqa: F811
    kinds = (hoverer, "pioneer3dx", hoverer)
    poses = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]
    world = World(kinds, poses, z=[0.5, 0.0, 0.3])
    for _ in range(150):
        world.set_commands(
            EVERY, np.array([[0.0, 0.0, -0.3, 0.0], [0.0] * 4, [0.0, 0.0, -0.3, 0.0]])
        )
        world.step()
    height = world.team.kinds[1].body.height
    np.testing.assert_allclose(world.z, [height, 0.0, 0.0], atol=1e-9)
    (collision,) = world.contacts.take()  # a landing on the ground is none
    assert (collision.first, collision.second) == ("robot1", "robot2")
    assert world.spatial.twist[2, 0] == 0.0


def test_obstacles_are_flown_over_and_run_into(hoverer):  # noqa: F811
    wall = Box("wall", 1.0, 0.0, 0.0, 0.2, 4.0, 0.5)
    world = world_of(hoverer, [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]], [0.2, 0.6], obstacles=(wall,))
    for _ in range(150):
        world.set_commands(EVERY, np.tile([0.5, 0.0, 0.0, 0.0], (2, 1)))
        world.step()
    assert world.pose[0, 0] == pytest.approx(0.7, abs=1e-3) and world.pose[1, 0] > 1.2
    assert {c.first for c in world.contacts.take()} == {"robot1"}


def test_silence_is_answered_as_the_drive_does(hoverer):  # noqa: F811
    world = world_of(hoverer, [[0.0, 0.0, 0.0]], [0.5], cmd_vel_timeout=0.2)
    world.set_commands(EVERY, np.array([[0.5, 0.0, 0.0, 0.0]]))
    heights = []
    for _ in range(200):
        world.step()
        heights.append(world.z[0])
    assert heights[50] == 0.5  # it hovers for a second
    assert 0.0 < heights[90] < 0.5 and heights[-1] == 0.0  # and comes down
    assert world.twist[0, 0] == 0.0 and world.commands.timed_out.tolist() == [True]


def test_points_fly_without_forces(hoverer):  # noqa: F811
    world = world_of(hoverer, [[0.0, 0.0, 0.3]], [1.0], fidelity="point_mass")
    world.set_commands(EVERY, np.array([[0.5, 0.0, 0.25, 0.0]]))
    for _ in range(10):
        world.step()
    assert world.z[0] == pytest.approx(1.05) and world.spatial.twist[0, 0] == 0.25
    with pytest.raises(WorldError, match="robot1, Hoverer, has no motion with forces"):
        world_of(hoverer, [[0.0, 0.0, 0.0]], [1.0], fidelity="dynamic")


def test_a_mirrored_robot_is_where_it_is(hoverer):  # noqa: F811
    world = world_of(hoverer, [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], [1.0, 1.0], mirrored=(1,))
    world.place([1], [[4.0, 0.0, 0.1]], z=[2.5])
    world.step()
    assert world.z.tolist() == [1.0, 2.5] and world.pose[1, 0] == 4.0
    assert world.spatial.z.tolist() == [1.0, 2.5]


# Scenario and control --------------------------------------------------------------------------------


def test_a_scenario_says_how_high_robots_begin(hoverer):  # noqa: F811
    scenario = flight(hoverer)
    assert scenario.altitude.tolist() == [2.0, 1.0, 0.0]
    assert scenario_from_dict(scenario.to_dict()).altitude.tolist() == [2.0, 1.0, 0.0]
    assert scenario._replace(topology=None).with_robots(5).altitude.tolist() == [2.0, 1.0, 0, 0, 0]
    assert flight(hoverer, {"altitude": 0}).altitude is None
    groups = [
        {"number": 2, "kind": hoverer, "layout": "line", "altitude": 1.5},
        {"kind": "husky", "poses": [[9, 9, 0]]},
    ]
    assert scenario_from_dict({"groups": groups}).altitude.tolist() == [1.5, 1.5, 0.0]
    for wrong, said in (([1, 2], "list of 3"), (-1, "of at least 0|from 0"), ("up", "number")):
        with pytest.raises(ScenarioError, match="altitude.*wanted.*(" + said + ")"):
            flight(hoverer, {"altitude": wrong})
    with pytest.raises(ScenarioError, match="altitude: given beside groups"):
        scenario_from_dict({"groups": groups, "altitude": 1})


class Climb(PioneerControl):
    """Robots that can go to the height of robot 1; the others stay."""

    def calculateControlLaw(self, pos_map):
        twists = {number: make_twist(0.0, 0.0) for number in pos_map}
        self.seen = {
            number: (len(p), p.z, isinstance(p, Position)) for number, p in pos_map.items()
        }
        twists[2].linear.z = pos_map[1].z - pos_map[2].z
        return twists


def test_a_law_knows_heights_and_commands_them(hoverer):  # noqa: F811
    control = make_control(flight(hoverer), Climb)
    pose = np.array([[0.0, 0.0, 0.5, 2.0], [3.0, 0.0, 0.0, 1.75], [6.0, 0.0, 0.0, 0.0]])
    command = control.commands(pose)
    assert control.seen == {1: (3, 2.0, True), 2: (3, 1.75, True), 3: (3, 0.0, True)}
    assert command[1].tolist() == [0.0, 0.0, 0.25, 0.0]
    planar = control.commands(pose[:, :3])
    assert control.seen[1] == (3, 0.0, True) and not planar.any()


def test_a_planar_law_flies_at_its_altitude_and_the_run_is_recorded_in_space(
    hoverer,  # noqa: F811
    tmp_path,
):
    run_experiment(flight(hoverer), str(tmp_path), formats=())
    run = read_run(str(tmp_path / "run.csv"))
    assert run.kinds == ("hoverer", "hoverer", "pioneer3dx")
    np.testing.assert_array_equal(run.spatial.z, np.tile([2.0, 1.0, 0.0], (21, 1)))
    np.testing.assert_array_equal(run.points[:, :, 2], run.spatial.z)
    assert np.abs(np.diff(run.hand[:, :, 0], axis=0)).max() > 0.01
    assert np.abs(run.spatial.orientation[:, :2, 0]).max() > 0.0  # they lean
    np.testing.assert_allclose(headings(run.spatial.orientation), run.pose[:, :, 2], atol=1e-9)


def test_odometry_over_the_wire_tells_all_of_it():
    message = PlanarOdometry()
    message.prepare("odom", "base", [float(k) for k in range(36)], [0.5] * 36)
    message.stamp = __import__("rospy").Time(3)
    message.planar, message.body = (1.0, 2.0, 0.0), (0.1, 0.2, 0.3)
    message.lift = [4.0, 0.1, 0.2, 0.3, 0.9, 0.6, 0.7, 0.8]
    plain = _sent(message)
    pose, twist = plain.pose.pose, plain.twist.twist
    assert (pose.position.z, pose.orientation.x, pose.orientation.w) == (4.0, 0.1, 0.9)
    assert (twist.linear.z, twist.angular.x, twist.angular.y) == (0.6, 0.7, 0.8)
    assert (plain.pose.covariance[14], plain.pose.covariance[21]) == (0.0, 35.0)
    message.lift = None
    plain = _sent(message)
    assert plain.pose.pose.position.z == 0.0 and plain.pose.covariance[14] == 14.0


def _sent(message):
    from io import BytesIO

    from nav_msgs.msg import Odometry

    buffer = BytesIO()
    message.serialize(buffer)
    own = PlanarOdometry().deserialize(buffer.getvalue())
    plain = Odometry().deserialize(buffer.getvalue())
    assert own.z == plain.pose.pose.position.z
    return plain


def test_a_bag_of_the_stages_states_is_read_in_space(hoverer, tmp_path):  # noqa: F811
    import rosbag
    import rospy

    plain = tmp_path / "flight.yaml"
    plain.write_text(flight(hoverer, {"duration": 1.0}).to_yaml())
    scenario = load_scenario(str(plain))
    world = World.from_scenario(scenario)
    with rosbag.Bag(str(tmp_path / "run.bag"), "w") as bag:
        for step in range(50):
            world.set_commands(
                EVERY, np.array([[0.0, 0.0, 0.2, 0.0], [0.1, 0.0, 0.0, 0.0], [0.0] * 4])
            )
            stamp = rospy.Time.from_sec(1.0 + 0.02 * step)
            bag.write("/stage/state", team_state(world, stamp, "world", (1, 1)), stamp)
            world.step()
    run = read_run(str(tmp_path / "run.bag"), str(plain))
    assert run.axes == ("linear.x", "linear.y", "linear.z", "angular.z")
    assert run.kinds == ("hoverer", "hoverer", "pioneer3dx")
    # After 0.9 s, 0.2 s of them on a ramp.
    assert run.time[-1] == pytest.approx(0.9)
    np.testing.assert_allclose(run.spatial.z[-1], [2.16, 1.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(run.spatial.twist[-1, :, 0], [0.2, 0.0, 0.0], atol=1e-9)
    np.testing.assert_array_equal(run.points[:, :, 2], run.spatial.z)


# Over ROS --------------------------------------------------------------------------------------------


def test_over_ros_height_and_orientation_are_published_everywhere(ros, tmp_path):
    law = tmp_path / "climb.py"
    law.write_text(
        "import math\n"
        "from mrs_simulator import PioneerControl, make_twist\n"
        "class Climb(PioneerControl):\n"
        "    def calculateControlLaw(self, pos_map):\n"
        "        twists = {i: make_twist(0.0, 0.0) for i in pos_map}\n"
        "        twists[2].linear.z = pos_map[1].z - pos_map[2].z\n"
        # At its top speed it would lean no more, and the stage goes on after the recorder.
        "        twists[2].linear.x = 0.4 - 0.4 * math.cos(3.0 * self.time)\n"
        "        return twists\n"
    )
    scenario = tmp_path / "flight.yaml"
    changes = {"control": {"protocol": "{}:Climb".format(law), "rate": 20}, "step": 0.05}
    changes.update(duration=4.0, speed=0)
    scenario.write_text(flight("crazyflie2", changes).to_yaml())
    ros.node("stage", "--scenario", scenario, "_lockstep:=true", "_wait_for_recorders:=3")
    ros.node("markers")
    probe = ros.probe()
    probe.ask("watch_markers()")
    probe.ask("listen('/robot2/odom', Odometry)")
    ros.node("pioneer_control", "--scenario", scenario, "_lockstep:=true")
    record = ros.node("record", "--scenario", scenario, "--out", tmp_path / "out")
    ros.judged(record, tmp_path / "out")
    run = read_run(str(tmp_path / "out" / "run.csv"))
    assert run.spatial.z[0].tolist() == [2.0, 1.0, 0.0]
    assert run.spatial.z[-1, 1] == pytest.approx(2.0, abs=0.05)
    assert run.kinds == ("crazyflie2", "crazyflie2", "pioneer3dx")
    probe.wait(
        "state('z')[1] > 1.9 and transforms['robot2/base_link'].transform.translation.z > 1.9"
    )
    probe.wait("newest['/robot2/odom'].pose.pose.position.z > 1.9")
    probe.wait("abs(newest['/robot2/odom'].pose.pose.orientation.y) > 0.005")  # it leans
    probe.wait("[m for m in shown('CYLINDER') if m['place'][0] > 3.2]")
    run_experiment(load_scenario(str(scenario)), str(tmp_path / "headless"), formats=())
    headless = read_run(str(tmp_path / "headless" / "run.csv"))
    np.testing.assert_allclose(run.spatial.z, headless.spatial.z, atol=1e-6)
    np.testing.assert_allclose(run.pose, headless.pose, atol=1e-6)


def test_a_team_on_the_ground_pays_nothing():
    team = Team(("pioneer3dx", "robotino3"))
    assert not team.is_spatial and not Z.of(team)
    world = World(("pioneer3dx", "robotino3"), [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    assert world.z is None and world.spatial is None and world.estimates.z() is None


def test_robots_that_fly_and_begin_on_the_ground_are_noted():
    pose = np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0]])
    for heights, noted in ((None, True), (np.zeros(2), True), (np.array([0.0, 1.0]), False)):
        notes = World(Team(("pioneer3dx", "crazyflie2")), pose, z=heights).notes
        assert ["robot2: on the ground" in note for note in notes] == [True] * noted
