"""Presets of robots in the air and on the water: what their nodes say moves the simulated ones alike."""

import math
import types

import numpy as np
import pytest
from optional_packages import vehicle_packages  # noqa: F401, a fixture
from ros_fixtures import log_of, wait_until

from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.vehicles.drives.rotors import GRAVITY, greatest_thrust
from mrs_simulator.vehicles.firmware import ardrone, crazyflie, heron
from mrs_simulator.vehicles.registry import kind
from mrs_simulator.world.world import World

rospy = pytest.importorskip("rospy")

from geometry_msgs.msg import Twist, Wrench  # noqa: E402
from std_msgs.msg import Empty, Float32  # noqa: E402

from mrs_simulator.nodes.stage.driver_presets import preset_drivers  # noqa: E402
from mrs_simulator.nodes.stage.presets import PRESETS  # noqa: E402


class Wire:
    """Topics and services without a master."""

    def __init__(self):
        self.topics, self.services, self.published, self.logged = {}, {}, {}, []

    def Subscriber(self, name, kind, callback, callback_args=None, **_):
        self.topics[name] = lambda message: callback(message, callback_args)
        return types.SimpleNamespace(unregister=lambda: self.topics.pop(name))

    def Publisher(self, name, kind, **_):
        return Published(name, self.published)

    def Service(self, name, kind, handler):
        self.services[name] = handler
        return types.SimpleNamespace(shutdown=lambda: self.services.pop(name))

    def logwarn(self, text, *values):
        self.logged.append(text % values)

    logwarn_throttle = lambda self, _, text: self.logged.append(text)  # noqa: E731
    ServiceException = rospy.ServiceException


class Published:
    def __init__(self, name, kept):
        self._name, self._kept = name, kept

    def publish(self, message):
        self._kept[self._name] = message

    def get_num_connections(self):
        return 1

    def unregister(self):
        self._kept.pop(self._name, None)


class AtOnce:
    def ask(self, act):
        try:
            return True, act()
        except ValueError as error:
            return False, str(error)


class Bench:
    """A world behind a preset, and its node's side of topics and services."""

    def __init__(self, monkeypatch, preset, kinds, fidelity="dynamic", z=None, poses=None):
        self.wire = Wire()
        self.wire.Publisher = type("Publisher", (Published,), {"__init__": lambda one, name, kind, **_:
                                   Published.__init__(one, name, self.wire.published)})  # fmt: skip
        from mrs_simulator.nodes.stage.driver_presets import ardrone as ardrone_node
        from mrs_simulator.nodes.stage.driver_presets import crazyswarm, wamv

        for module in (preset_drivers, ardrone_node, crazyswarm, wamv):
            monkeypatch.setattr(module, "rospy", self.wire)
        poses = [[10.0 * i, 0.0, 0.0] for i in range(len(kinds))] if poses is None else poses
        self.world = World(kinds, poses, fidelity=fidelity, z=z)
        self.drivers = PRESETS[preset].drivers(self.world, AtOnce())
        self.drivers.follow_team(None)

    def send(self, name, message=None, **fields):
        self.wire.topics[name](Empty() if message is None else message(**fields))

    def call(self, name, request, **fields):
        return self.wire.services[name](request(**fields))

    def run(self, seconds, again=None):
        for _ in range(int(round(seconds / self.world.step_size))):
            if again is not None:
                again()
            self.drivers.advance()
            self.world.step()

    @property
    def place(self):
        world = self.world
        return np.column_stack([world.pose[:, :2], world.z])

    def published(self):
        self.drivers.report(rospy.Time(1), list(range(self.world.n)))
        return self.wire.published


def hover_thrust():
    """Return the ``thrust`` of an attitude that carries a Crazyflie."""
    each = kind("crazyflie2")
    return crazyflie.FULL * GRAVITY * each.mass / greatest_thrust(each.numbers)


def twist(x=0.0, y=0.0, z=0.0, turn=0.0, **angular):
    message = Twist()
    message.linear.x, message.linear.y, message.linear.z, message.angular.z = x, y, z, turn
    for name, value in angular.items():
        setattr(message.angular, name, value)
    return message


# The firmware's arithmetic ---------------------------------------------------------------------------


def test_a_planned_flight_is_at_rest_at_its_ends_and_half_way_in_the_middle():
    piece = crazyflie.from_rest_to_rest([0.0, 1.0, 0.0, 0.0], [2.0, 1.0, 0.5, math.pi], 4.0)
    flight = crazyflie.Flight([piece], begin=10.0)
    begin, middle, end = flight.goal(10.0), flight.goal(12.0), flight.goal(14.0)
    np.testing.assert_allclose(
        [*begin.place, *begin.velocity, *begin.acceleration], [0, 1] + [0] * 7
    )
    np.testing.assert_allclose(middle.place, [1.0, 1.0, 0.25])
    assert middle.velocity[0] == pytest.approx(35.0 / 16.0 * 2.0 / 4.0)  # ds/dt at 1/2 is 35/16
    np.testing.assert_allclose([*end.place, *end.velocity], [2, 1, 0.5, 0, 0, 0], atol=1e-12)
    assert end.yaw == pytest.approx(math.pi)


def test_a_trajectory_goes_slower_backwards_and_from_where_the_robot_is():
    line = np.zeros((4, 8))
    line[0, 1] = 1.0  # x = t
    more = np.zeros((4, 8))
    more[0, :2] = 1.0, 2.0  # x = 1 + 2 t
    pieces = [crazyflie.Piece(line, 1.0), crazyflie.Piece(more, 1.0)]
    slow = crazyflie.Flight(pieces, 0.0, scale=2.0)
    assert slow.goal(1.0).place[0] == pytest.approx(0.5)
    assert slow.goal(3.0).place[0] == pytest.approx(2.0) and slow.goal(3.0).velocity[0] == 1.0
    back = crazyflie.Flight(pieces, 0.0, reverse=True)
    assert back.goal(0.5).place[0] == pytest.approx(2.0) and back.goal(0.5).velocity[0] == -2.0
    assert back.goal(9.0).place[0] == pytest.approx(0.0) and back.goal(9.0).velocity[0] == 0.0
    one = crazyflie.Commander(kind("crazyflie2"), 0.02)
    state = crazyflie.State(np.array([5.0, 6.0, 7.0]), np.zeros(3), 0.0)
    one.upload(3, 0, pieces)
    one.start(0.0, state, 3, 1.0, False, True)
    np.testing.assert_allclose(one._flight.goal(0.0).place, state.place)
    for wrong, said in ((4, "trajectory 4: wanted one that is uploaded .3."),):
        with pytest.raises(ValueError, match=said):
            one.start(0.0, state, wrong, 1.0, False, True)
    with pytest.raises(ValueError, match="no place beyond 31"):
        one.upload(1, 30, pieces)
    with pytest.raises(ValueError, match="duration 0: wanted above 0"):
        one.take_off(0.0, state, 1.0, 0.0)


def test_the_signs_of_setpoints_are_the_firmwares():
    one = crazyflie.Commander(kind("crazyflie2"), 0.02)
    rest = crazyflie.State(np.zeros(3), np.zeros(3), 0.5 * math.pi)  # looks along y
    hover = hover_thrust()
    assert hover == pytest.approx(65535.0 / 2.2476, rel=1e-3)  # thrust to weight, at 9.81 m/s^2
    ahead, _ = one.attitude(10.0, 0.0, 0.0, hover)(rest)
    right, rate = one.attitude(0.0, 10.0, 20.0, hover)(rest)
    assert (
        ahead[1] > 0.0 and abs(ahead[0]) < 1e-12 and right[0] > 0.0 and rate == math.radians(20.0)
    )
    fall, _ = one.attitude(0.0, 0.0, 0.0, 900.0)(rest)
    assert fall[2] < -0.5 and (one.attitude(0, 0, 0, 65535.0)(rest)[0] == one.attitude(0, 0, 0,
    6e4)(rest)[0]).all()  # fmt: skip
    assert one.velocity_world([0.1, 0.2, 0.3], 90.0)(rest)[1] == pytest.approx(-0.5 * math.pi)
    velocity, rate = one.hover(0.1, 0.2, 90.0, 0.5)(rest)
    np.testing.assert_allclose(velocity, [-0.2, 0.1, 1.0], atol=1e-12)
    assert rate == pytest.approx(-0.5 * math.pi)
    velocity, rate = one.position([0.0, 0.5, 0.0], 90.0)(rest)
    np.testing.assert_allclose(velocity, [0.0, 1.0, 0.0])
    assert rate == pytest.approx(0.0)


def test_a_drones_twist_is_shares_of_its_angles_and_speeds():
    drone, top = kind("ardrone2"), np.array([2.0, 2.0, 0.7, 1.75])
    still = np.zeros(3), 0.0, drone, top, np.ones(3)
    assert not ardrone.command(np.zeros(6), np.ones(3), 0.0, drone, top, np.ones(3)).any()  # hover
    x, y, z, turn = ardrone.command(np.array([1.0, -0.5, 0.5, 0.0, 0.0, -1.0]), *still)
    assert x == pytest.approx(9.81 * math.tan(0.21), rel=1e-6)
    assert y == pytest.approx(-9.81 * math.tan(0.105) / math.cos(0.21), rel=1e-6)
    assert (z, turn) == (pytest.approx(0.35), -1.75)
    level = ardrone.command(np.array([0, 0, 0, 1.0, 0, 0]), np.array([1.0, 0, 0]), *still[1:])
    assert level[0] == pytest.approx(1.0)  # no auto-hover: level, it goes on
    np.testing.assert_array_equal(
        ardrone.shares(np.array([3.0, -2.0, np.nan, 0, 0, 0])), [1, -1, 0, 0, 0, 0]
    )


def test_the_herons_commands_are_shares_of_thrust_and_courses():
    numbers = kind("heron").numbers
    np.testing.assert_array_equal(heron.drive(2.0, -0.5), [1.0, -0.5, np.nan, np.nan])
    assert heron.helm(0.5, numbers)[2] == 45.0 and heron.helm(-0.5, numbers)[2] == -25.0
    np.testing.assert_allclose(heron.course(-3.0, 1.0, 3.0), [1.0, 0.3 * (2.0 * math.pi - 6.0)])


# Behind the interfaces -------------------------------------------------------------------------------


@pytest.mark.parametrize("preset, said", [
    ("crazyswarm", "no robot is a quadrotor; wanted one, such as crazyflie2"),
    ("ardrone", "no robot is a quadrotor"), ("heron", "fidelity kinematic, wanted dynamic"),
    ("wamv", "fidelity kinematic, wanted dynamic")])  # fmt: skip
def test_a_preset_without_its_vehicles_is_refused(preset, said):
    with pytest.raises(ValueError, match="preset {}: .*{}".format(preset, said)):
        PRESETS[preset].behind(scenario_from_dict({"poses": [[0, 0, 0]]}))


def test_what_lacks_its_messages_is_named_and_left_out(monkeypatch):
    nothing = types.SimpleNamespace(import_module=missing)
    monkeypatch.setattr("mrs_simulator.ros.message_forms.optional_messages.importlib", nothing)
    bench = Bench(monkeypatch, "crazyswarm", ("crazyflie2",))
    (said,) = bench.wire.logged
    assert said.startswith(
        "stage: preset crazyswarm: crazyswarm is not installed; left out: cmd_full_state, "
    )
    assert "upload_trajectory" in said and "crazyswarm.srv" in said
    assert sorted(bench.wire.topics) == ["/cf1/cmd_stop", "/cf1/cmd_vel"]
    assert list(bench.wire.services) == ["/emergency"]
    assert "heron_msgs" in Bench(monkeypatch, "heron", ("heron",)).wire.logged[0]
    assert "ardrone/navdata" in Bench(monkeypatch, "ardrone", ("ardrone2",)).wire.logged[0]


def missing(name, *_):
    raise ModuleNotFoundError(name)


def test_a_crazyflie_takes_off_goes_follows_a_trajectory_and_lands(monkeypatch, vehicle_packages):  # noqa: F811
    from crazyswarm.msg import TrajectoryPolynomialPiece
    from crazyswarm.srv import (
        GoToRequest,
        LandRequest,
        StartTrajectoryRequest,
        TakeoffRequest,
        UploadTrajectoryRequest,
    )

    bench = Bench(monkeypatch, "crazyswarm", ("crazyflie2",) * 2)  # with forces
    assert not bench.wire.logged
    seconds = rospy.Duration.from_sec
    bench.call("/takeoff", TakeoffRequest, height=0.5, duration=seconds(1.5))
    bench.run(2.5)
    np.testing.assert_allclose(bench.place, [[0.0, 0.0, 0.5], [10.0, 0.0, 0.5]], atol=0.03)
    request = GoToRequest(yaw=0.5, duration=seconds(2.0), relative=True)
    request.goal.x, request.goal.z = 0.6, 0.2
    bench.wire.services["/cf1/go_to"](request)
    bench.run(3.0)
    np.testing.assert_allclose(bench.place, [[0.6, 0.0, 0.7], [10.0, 0.0, 0.5]], atol=0.03)
    assert bench.world.pose[0, 2] == pytest.approx(0.5, abs=0.05)
    line = [0.0] * 8
    line[4:] = [35.0 / 2**4, -84.0 / 2**5, 70.0 / 2**6, -20.0 / 2**7]  # 1 m in 2 s
    piece = TrajectoryPolynomialPiece(line, [0.0] * 8, [0.0] * 8, [0.0] * 8, seconds(2.0))
    bench.call("/cf2/upload_trajectory", UploadTrajectoryRequest, trajectoryId=1, pieces=[piece])
    bench.call("/cf2/start_trajectory", StartTrajectoryRequest, trajectoryId=1, timescale=1.0,
               relative=True)  # fmt: skip
    bench.run(3.0)
    np.testing.assert_allclose(bench.place[1], [11.0, 0.0, 0.5], atol=0.04)
    bench.call("/cf1/land", LandRequest, height=0.04, duration=seconds(1.5))
    bench.run(3.0)
    assert bench.place[0, 2] == 0.0 and bench.place[1, 2] == pytest.approx(0.5, abs=0.02)
    with pytest.raises(rospy.ServiceException, match="trajectory 9"):
        bench.call("/cf2/start_trajectory", StartTrajectoryRequest, trajectoryId=9, timescale=1.0)
    bench.world.close()


def test_setpoints_stream_have_priority_and_groups_are_heeded(monkeypatch, vehicle_packages):  # noqa: F811
    from crazyswarm.msg import FullState, Hover, Position, VelocityWorld
    from crazyswarm.srv import NotifySetpointsStopRequest, SetGroupMaskRequest, TakeoffRequest

    bench = Bench(monkeypatch, "crazyswarm", ("crazyflie2",) * 2, "kinematic", z=[1.0, 0.0])

    def streaming(topic, message):
        bench.run(1.0, lambda: bench.wire.topics["/cf1/" + topic](message))

    moving = VelocityWorld()
    moving.vel.x = 0.5
    streaming("cmd_velocity_world", moving)
    assert bench.place[0, 0] == pytest.approx(0.377, abs=0.02)  # 0.5 (1 - 0.25 (1 - exp(-4)))
    streaming("cmd_position", Position(x=0.8, y=0.2, z=1.2, yaw=90.0))
    bench.run(0.4)
    np.testing.assert_allclose(bench.place[0], [0.8, 0.2, 1.2], atol=0.08)
    streaming("cmd_hover", Hover(vx=0.3, zDistance=0.8))  # ahead is where it looks, along y by now
    assert bench.place[0, 1] > 0.35 and bench.place[0, 2] < 1.0
    whole = FullState()
    whole.pose.position.x, whole.pose.position.z, whole.pose.orientation.w = 1.0, 1.0, 1.0
    streaming("cmd_full_state", whole)
    before = bench.place[0].copy()
    with pytest.raises(rospy.ServiceException, match="cf1 obeys setpoints"):
        bench.call("/cf1/takeoff", TakeoffRequest, height=2.0, duration=rospy.Duration(1))
    bench.call("/cf1/notify_setpoints_stop", NotifySetpointsStopRequest)
    bench.call("/cf2/set_group_mask", SetGroupMaskRequest, groupMask=2)
    bench.call("/takeoff", TakeoffRequest, groupMask=2, height=0.5, duration=rospy.Duration(1))
    bench.run(2.0)
    assert bench.place[1, 2] == pytest.approx(0.5, abs=0.03)
    assert bench.place[0, 2] == pytest.approx(before[2], abs=0.1)
    moving.vel.x = float("nan")
    bench.wire.topics["/cf1/cmd_velocity_world"](moving)
    bench.drivers.advance()
    assert bench.world.commands.refused.tolist() == [1, 0]


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_cmd_vel_of_a_crazyflie_is_an_attitude_and_cmd_stop_cuts_the_motors(fidelity, monkeypatch):
    bench = Bench(monkeypatch, "crazyswarm", ("crazyflie2",), fidelity, z=[2.0])
    hover = hover_thrust()
    bench.run(0.5, lambda: bench.wire.topics["/cf1/cmd_vel"](twist(10.0, 0.0, hover)))
    # g tan 10 degrees for half a second, less the attitude's lag.
    assert bench.world.twist[0, 0] == pytest.approx(
        9.81 * math.tan(math.radians(10)) * 0.5, rel=0.35
    )
    assert bench.place[0, 2] == pytest.approx(2.0, abs=0.05)
    bench.send("/cf1/cmd_stop")
    bench.run(0.3)
    assert bench.world.flights.states()[0] == "falling" and bench.place[0, 2] < 1.8
    bench.world.close()


def test_poses_and_transforms_of_crazyflies_are_published(monkeypatch):
    bench = Bench(monkeypatch, "crazyswarm", ("crazyflie2",), "kinematic", z=[1.5])
    told = bench.published()
    assert told["/cf1/pose"].header.frame_id == "world" and told["/cf1/pose"].pose.position.z == 1.5
    (move,) = told["/tf"].transforms
    assert (move.header.frame_id, move.child_frame_id) == ("world", "cf1")


def test_an_ardrone_takes_off_tilts_hovers_lands_and_is_reset(monkeypatch, vehicle_packages):  # noqa: F811
    bench = Bench(monkeypatch, "ardrone", ("ardrone2", "pioneer3dx"), "kinematic")

    def told(message):
        values = [message.linear.x, message.linear.y, message.linear.z, 0.0, 0.0, message.angular.z]
        return lambda: bench.drivers.taken([0], [values])

    bench.run(0.5, told(twist(1.0)))
    assert not bench.place[0].any()  # it has landed
    bench.send("/robot1/ardrone/takeoff")
    bench.run(0.5)
    assert bench.published()["/robot1/ardrone/navdata"].state == 6
    bench.run(4.0)
    assert bench.place[0, 2] == pytest.approx(1.0, abs=0.03)
    bench.run(1.0, told(twist(0.5, 0.0, 0.5, 1.0)))
    data = bench.published()["/robot1/ardrone/navdata"]
    assert data.state == 3 and data.vx > 400.0 and data.rotZ > 45.0
    assert data.altd == pytest.approx(1350, abs=150)  # mm
    bench.run(2.0, told(twist()))
    assert bench.published()["/robot1/ardrone/navdata"].state == 4
    assert np.abs(bench.world.twist[0, :2]).max() < 0.1
    inertial = bench.published()["/robot1/ardrone/imu"]
    assert inertial.linear_acceleration.z == pytest.approx(9.81, abs=0.5)
    height = bench.published()["/robot1/ardrone/odometry"].pose.pose.position.z
    assert height == pytest.approx(bench.place[0, 2])
    bench.send("/robot1/ardrone/land")
    bench.run(5.5, told(twist(0.5)))
    assert bench.place[0, 2] == 0.0 and bench.published()["/robot1/ardrone/navdata"].state == 2
    bench.send("/robot1/ardrone/takeoff")
    bench.run(1.0)
    bench.send("/robot1/ardrone/reset")
    bench.run(1.0)
    assert bench.place[0, 2] < 0.05 and bench.published()["/robot1/ardrone/navdata"].state == 0
    bench.send("/robot1/ardrone/takeoff")
    bench.run(0.5)
    assert "does not take off" in bench.wire.logged[-1]
    bench.world.close()


def test_a_heron_obeys_thrusters_helm_course_and_wrench(monkeypatch, vehicle_packages):  # noqa: F811
    from heron_msgs.msg import Course, Drive, Helm

    bench = Bench(monkeypatch, "heron", ("heron",) * 2, poses=[[0, 0, 0], [0, 90, 0]])
    top = (-16.45 + math.sqrt(16.45**2 + 4 * 2.942 * 45.0)) / (2 * 2.942)  # at 45 N, closed form

    def streaming(seconds, topic, kind, **fields):
        bench.run(seconds, lambda: bench.send("/robot1/" + topic, kind, **fields))

    streaming(9.0, "cmd_drive", Drive, left=0.5, right=0.5)
    assert bench.world.twist[0, 0] == pytest.approx(top, rel=0.01)
    streaming(6.0, "cmd_helm", Helm, thrust=0.5, yaw_rate=0.2)
    assert bench.world.twist[0, 0] == pytest.approx(top, rel=0.1)  # it slips in the turn
    assert bench.world.twist[0, 2] == pytest.approx(0.2, abs=0.05)
    bench.run(12.0, lambda: bench.send("/robot1/cmd_course", Course, yaw=-1.5, speed=1.0))
    assert bench.world.pose[0, 2] == pytest.approx(-1.5, abs=0.1)
    wrench = Wrench()
    wrench.force.x = 45.0
    bench.run(9.0, lambda: bench.wire.topics["/robot1/cmd_wrench"](wrench))
    assert bench.world.twist[0, 0] == pytest.approx(top, rel=0.02)
    bench.run(3.0)  # told nothing more: after 1.5 s thrusters stand, nothing brakes
    assert 0.5 < bench.world.twist[0, 0] < top
    np.testing.assert_allclose(bench.world.pose[1], [0.0, 90.0, 0.0], atol=1e-6)
    bench.send("/robot1/cmd_drive", Drive, left=float("nan"), right=0.0)
    bench.drivers.advance()
    assert bench.world.commands.refused[0] == 1


def test_a_wamv_obeys_the_thruster_topics_of_its_simulator(monkeypatch):
    bench = Bench(monkeypatch, "wamv", ("wamv",))
    both = ["/robot1/thrusters/{}_thrust_cmd".format(side) for side in ("left", "right")]

    def full():
        for name in both:
            bench.send(name, Float32, data=1.0)

    bench.run(15.0, full)
    assert bench.world.twist[0, 0] == pytest.approx(2.259, abs=0.01)  # 485.3 N, closed form
    bench.run(6.0, lambda: bench.send(both[1], Float32, data=0.5))
    assert (
        bench.world.twist[0, 2] > 0.05
    )  # the right one pushes to the left; the left one's time is out
    bench.run(9.0)
    assert np.abs(bench.world.twist[0]).max() < 0.7
    bench.send("/robot1/thrusters/left_thrust_angle", Float32, data=0.3)
    bench.drivers.advance()
    assert "left_thrust_angle is left out" in bench.wire.logged[-1]


NODE = """
# A node as it is written for the real vehicles.
import sys
import rospy
from crazyswarm.msg import VelocityWorld
from crazyswarm.srv import GoTo, Land, Takeoff
from geometry_msgs.msg import Point, PoseStamped

rospy.init_node("show")
place = {}
rospy.Subscriber("/cf1/pose", PoseStamped, lambda m: place.update(z=m.pose.position.z, x=m.pose.position.x))
for name in ("takeoff", "go_to", "land"):
    rospy.wait_for_service("/cf1/" + name, 60)

def until(there):
    while not (place and there()):
        rospy.sleep(0.05)

rospy.ServiceProxy("/cf1/takeoff", Takeoff)(0, 0.5, rospy.Duration(1.0))
until(lambda: abs(place["z"] - 0.5) < 0.03)
rospy.ServiceProxy("/cf1/go_to", GoTo)(0, False, Point(0.4, 0.0, 0.6), 0.0, rospy.Duration(1.0))
until(lambda: abs(place["x"] - 0.4) < 0.03)
stream = rospy.Publisher("/cf1/cmd_velocity_world", VelocityWorld, queue_size=1)
message = VelocityWorld()
message.vel.x = 0.5
while place["x"] < 0.8:
    stream.publish(message)
    rospy.sleep(0.05)
rospy.sleep(1.0)

def landing():
    try:
        return rospy.ServiceProxy("/cf1/land", Land)(0, 0.02, rospy.Duration(1.0))
    except rospy.ServiceException:
        return False  # the last setpoint came late

until(landing)
until(lambda: place["z"] == 0.0)
print("landed")
"""


def test_a_node_for_real_crazyflies_flies_simulated_ones(ros, vehicle_packages, tmp_path):  # noqa: F811
    scenario = tmp_path / "one.yaml"
    scenario.write_text("{model: crazyflie2, poses: [[0, 0, 0]], fidelity: kinematic}\n")
    ros.paths.append(vehicle_packages)
    stage = ros.node("stage", "--scenario", scenario, "--preset", "crazyswarm", "_speed:=8")
    assert "landed" in ros.python(NODE)
    # Every robot that flies has these, too.
    ros.python(STOPS)
    wait_until(lambda: "robot1 has its motors off at" in log_of(stage))


STOPS = """
import rospy
from mrs_simulator.msg import Incident, StageStatus
from std_srvs.srv import SetBool, Trigger

rospy.init_node("stops")
states, found = [], []
rospy.Subscriber("/stage/status", StageStatus, lambda m: states.append(m.flight[0]))
incidents = rospy.Subscriber("/stage/incidents", Incident, lambda m: found.append(m.what))

def until(there):
    while not there():
        rospy.sleep(0.05)

until(incidents.get_num_connections)
assert rospy.ServiceProxy("/stage/reset", Trigger)().success
rospy.wait_for_service("/cf1/go_to", 60)
assert rospy.ServiceProxy("/robot1/takeoff", Trigger)().success
until(lambda: states[-1:] == ["hovering"])
cut = rospy.ServiceProxy("/robot1/cut_motors", SetBool)
refused = cut(False)
assert not refused.success and "would fall" in refused.message, refused
assert states[-1] == "hovering" and not found
assert cut(True).success
until(lambda: states[-1:] == ["motors off"])
until(lambda: found)
assert found == ["motors_off"]
assert rospy.ServiceProxy("/robot1/takeoff", Trigger)().success
until(lambda: states[-1:] == ["hovering"])
assert rospy.ServiceProxy("/robot1/land", Trigger)().success
until(lambda: states[-1:] == ["landed"])
"""
