"""Readings as messages and back, and topics that are served only while somebody listens."""

import io
import math

import numpy as np
import pytest
import rospy
from sensor_msgs.msg import NavSatFix
from std_msgs.msg import Header

from mrs_simulator.nodes.record.bag_recording import command_of
from mrs_simulator.nodes.stage import sensor_topics
from mrs_simulator.nodes.stage.robot_topics import Frames
from mrs_simulator.ros.message_forms import defined_types, sensor_messages
from mrs_simulator.ros.message_forms.messages import MessageError
from mrs_simulator.ros.message_forms.sensor_forms.cloud import Cloud
from mrs_simulator.ros.message_forms.sensor_messages import FORMS, forms_of, others_of, topic_of
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.sensors.mounts import fitted_mounts, spare_mounts
from mrs_simulator.sensors.noise import Draws, Streams
from mrs_simulator.sensors.suite import Suite, of_robot
from mrs_simulator.sensors.types import TYPES
from mrs_simulator.vehicles import Team
from mrs_simulator.world.world import World

# [m, rad] by which values may differ on their way
FLOAT32 = {"sonar": 4e-7, "front": 4e-7, "laser": 4e-7}
ROUNDED = dict.fromkeys(("compass", "mocap", "encoders"), 1e-15)
ALL = {
    "laser": {"range": [0.1, 5.0]},
    "seen": {"type": "range_bearing"},
    "beacons": {"type": "beacons", "points": [[0.5, 0.2], [9.0, 0.0], [-3.0, 1.0]]},
    "bumper": {"type": "bumper"},
    "encoders": {"type": "encoders", "noise": {"quantum": "1 mm"}},
    "imu": {"type": "imu", "noise": {"rate": {"stddev": 0.01}}},
    "compass": {"type": "compass", "noise": {"stddev": "1 deg"}},
    "altimeter": {"type": "altimeter"},
    "gps": {"type": "gps", "origin": [49.1, 12.3, 400.0], "noise": {"dropout": 0.5}},
    "mocap": {"type": "motion_capture", "noise": {"position": {"stddev": "1 mm"}}},
    "front": {"type": "sonar", "transducers": [["0.1 m", 0.0, 0.0]]},
}


def scenario(**more):
    wall = {"type": "box", "name": "wall", "center": [2.0, 0.0], "size": [0.2, 9.0]}
    content = {
        "poses": [[0.0, 0.0, 0.0], [-2.0, 0.3, 0.4]],
        "obstacles": [wall],
        "sensors": [{"mounts": ALL}],
    }
    return scenario_from_dict(dict(content, **more))


def sent(form, item):
    """Return the message of ``item`` as it arrives."""
    bytes_sent = io.BytesIO()
    form.message(item, Header(0, rospy.Time(3, 4), "robot1/x")).serialize(bytes_sent)
    message = form.MESSAGE().deserialize(bytes_sent.getvalue())
    assert message.header.stamp == rospy.Time(3, 4) and message.header.frame_id == "robot1/x"
    return message


@pytest.fixture(scope="module")
def sensors():
    """Sensors after a second of driving, and the team that has them."""
    world = World.from_scenario(scenario())
    suite = Suite.of_scenario(scenario(), world.team, world.obstacles)
    suite.activate({row: [m.name for m in mounts] for row, mounts in enumerate(suite.mounts)})
    world.set_commands([0, 1], np.array([[0.3, 0.1], [0.2, 0.0]]))
    for _ in range(50):
        suite.update(world.steps, world.sensed)
        world.step()
    return {sensor.mount.name: sensor for sensor in suite.active}, world


def test_every_type_of_sensor_has_forms():
    assert {form.TYPE for form in FORMS if form.PUBLISHED} == set(TYPES)


@pytest.mark.parametrize("name", ["sonar", *ALL])
def test_what_is_written_is_what_is_read(sensors, name):
    sensor, reading = sensors[0][name], sensors[0][name].known(1.0)
    form = forms_of(sensor.mount, sensors[1].team.kinds[0])[0]
    for k, item in enumerate(form.rows(reading)):
        wanted, read = of_robot(reading, k), form.reading(sent(form, item), reading.stamp)
        assert type(read) is type(wanted)
        for a, b in zip(wanted, read):
            np.testing.assert_allclose(b, a, rtol=0.0, atol={**FLOAT32, **ROUNDED}.get(name, 0.0))


def test_a_battery_tells_charge_and_voltage():
    world = World.from_scenario(scenario(sensors=[{"mounts": {"battery": {"type": "battery"}}}]))
    (mount,) = [each for each in Suite.of_scenario(
        scenario(sensors=[{"mounts": {"battery": {"type": "battery"}}}]), world.team
    ).mounts[0] if each.type == "battery"]  # fmt: skip
    form = forms_of(mount, world.team.kinds[0])[0]
    read = form.reading(sent(form, [12.25, 0.5]), 2.0)
    assert read == (2.0, 12.25, 0.5, None)


def test_echoes_are_points_in_the_robots_axes():
    world = World.from_scenario(scenario(poses=[[0.0, 0.0, 0.0]]))
    suite = Suite.of_scenario(scenario(poses=[[0.0, 0.0, 0.0]]), world.team, world.obstacles)
    mount = suite.mounts[0][0]._replace(noise=())
    sonar = TYPES["sonar"](mount, np.array([0]), world.team)
    suite.activate({0: ["sonar"]})
    reading = sonar.read(world.sensed(), suite._scenery, _Exact())
    cloud, cloud2 = forms_of(mount, world.team.kinds[0])
    points = sent(cloud, cloud.rows(reading)[0]).points
    # The wall's face at 1.9 m; the fourth transducer at (166, 27) mm looks along 10 deg, its cone 15 deg
    # to both sides, so that it hears the point straight ahead.
    ahead = 1.9 - 0.166
    echo = (
        0.166 + ahead * math.cos(math.radians(10.0)),
        0.027 + ahead * math.sin(math.radians(10.0)),
    )
    assert points[3] == pytest.approx([*echo, 0.0], abs=1e-6)
    # Nothing is behind: the point lies at the greatest distance.
    assert np.hypot(*(points[11, :2] - [-0.255, -0.027])) == pytest.approx(5.0, abs=1e-6)
    assert cloud.frame == (0.0, 0.0, 0.17, 0.0)
    message = sent(cloud2, cloud2.rows(reading)[0])
    assert [field.name for field in message.fields] == ["x", "y", "z"]
    assert np.frombuffer(message.data, "<f4").reshape(16, 3) == pytest.approx(points)


class _Exact:
    def noisy(self, values, quantity=""):
        return values


def test_what_drivers_mark_as_ignored_is_lost(sensors):
    form = forms_of(sensors[0]["laser"].mount, sensors[1].team.kinds[0])[0]
    message = sent(form, [1.0] * 181)
    message.range_min, message.range_max = 0.0, 4.0  # as RosAria's LaserScan may say
    message.ranges = [-1.0, 4.0, 4.1, 0.3, math.inf] + [2.0] * 176
    found = form.reading(message, 0.0).ranges
    assert math.isnan(found[0]) and (found[[1, 2, 4]] == math.inf).all() and found[3] == 0.3
    message.range_min = 0.35
    assert math.isnan(form.reading(message, 0.0).ranges[3])


def test_a_transducer_without_an_echo_of_any_is_lost(sensors):
    # RosAria tells one that has not fired since the sonars were switched on at the robot's centre.
    form = forms_of(sensors[0]["sonar"].mount, sensors[1].team.kinds[0])[0]
    points = form.rows(sensors[0]["sonar"].known(1.0))[0]
    whole = form.reading(sent(form, points), 0.0).ranges
    points[8:] = 0.0  # a robot without the array behind
    found = form.reading(sent(form, points), 0.0).ranges
    assert np.isnan(found[8:]).all() and (found[:8] == whole[:8]).all()
    with pytest.raises(MessageError, match="no transducer has fired yet"):
        form.reading(sent(form, np.zeros((16, 3))), 0.0)


def test_another_sensor_than_the_mounts_is_refused(sensors):
    fitted, world = sensors

    def refusal(sensor, **changed):
        form = forms_of(fitted[sensor].mount, world.team.kinds[0])[0]
        message = sent(form, form.rows(fitted[sensor].known(1.0))[0])
        for key, value in changed.items():
            setattr(message, key, value(message) if callable(value) else value)
        with pytest.raises(MessageError) as error:
            form.reading(message, 0.0)
        return str(error.value)

    said = refusal("sonar", points=np.zeros((8, 3)))
    assert said == "8 echoes, but the mount has 16 transducers"
    assert "not where the mount's transducer looks" in refusal(
        "sonar", points=lambda message: message.points + [0.0, 0.1, 0.0]
    )
    assert refusal("laser", ranges=[1.0] * 180) == "180 rays, but the mount has 181"
    assert "but the mount has -1.571" in refusal("laser", angle_min=-1.5)
    assert "wanted left_wheel_joint too" in refusal("encoders", name=["a", "b"])
    assert "wanted" not in refusal("bumper", rear_bumpers=[])


def test_p2os_tells_distances_up_to_the_last_that_has_fired(sensors):
    form = others_of(sensors[0]["sonar"].mount, sensors[1].team.kinds[0])[0]
    kind = sensors[1].team.kinds[0]
    told = form.MESSAGE(ranges_count=9, ranges=[1.5, 5.0, 0.3] + [2.0] * 6)
    reading = form.reading(told, 3.0)
    assert reading.stamp == 3.0 and reading.ranges[:3].tolist() == [1.5, math.inf, 0.3]
    assert (reading.ranges[3:9] == 2.0).all() and np.isnan(reading.ranges[9:]).all()
    assert reading.places.shape == (16, 3) and reading.most == 5.0
    with pytest.raises(MessageError, match="use_sonar"):
        form.reading(form.MESSAGE(), 3.0)
    with pytest.raises(MessageError, match="17 distances, but the mount has 16 transducers"):
        form.reading(form.MESSAGE(ranges=[1.0] * 17), 3.0)
    mount = next(each for each in spare_mounts(kind) if each.name == "battery")
    voltage = others_of(mount, kind)[-1]
    assert voltage.reading(voltage.MESSAGE(voltage=12.5), 1.0).voltage == 12.5


def test_a_topic_may_have_messages_of_several_types(sensors, monkeypatch):
    mount, kind = sensors[0]["sonar"].mount, sensors[1].team.kinds[0]
    forms = [forms_of(mount, kind)[0], *others_of(mount, kind)]
    asked, heard, refused = [], [], []
    monkeypatch.setattr(
        sensor_messages.rospy, "Subscriber", lambda *given, **_: asked.append(given)
    )
    sensor_messages.listen(
        "/a",
        forms,
        lambda message, form: heard.append((message, form)),
        lambda *why: refused.append(why),
    )
    name, kind_asked, callback = asked[0]
    assert name == "/a" and kind_asked is rospy.AnyMsg

    def come(message, **header):
        raw = rospy.AnyMsg()
        raw._buff = io.BytesIO()
        message.serialize(raw._buff)
        raw._buff = raw._buff.getvalue()
        told = {"type": message._type, "md5sum": message._md5sum, "callerid": "/driver"}
        raw._connection_header = {**told, **header}
        callback(raw)

    come(forms[1].MESSAGE(ranges=[1.0]))
    come(forms[0].message(np.ones((16, 3)), Header()))
    assert [form for _, form in heard] == forms[::-1]
    assert heard[0][0].ranges == (1.0,) and heard[1][0].points.shape == (16, 3)
    assert heard[0][0]._connection_header["callerid"] == "/driver"
    come(Header())
    come(forms[1].MESSAGE(), md5sum="0")
    wanted = "wanted sensor_msgs/PointCloud or p2os_msgs/SonarArray"
    assert [why for _, why in refused] == [
        "a std_msgs/Header, " + wanted,
        "a p2os_msgs/SonarArray, " + wanted,
    ]


def test_definitions_have_the_packages_checksums():
    assert defined_types.BumperState._md5sum == "f81947761ff7e166a3bbaf937b9869b5"
    assert defined_types.SonarArray._md5sum == "2984921c09aef26ad253c7629937a5bb"
    assert defined_types.P2osBattery._md5sum == "b72130f0e7ffec93b2b5f573eb2542cb"
    assert defined_types.DiagnosticArray._md5sum == "60810da900de1dd6ddd437c3503511da"


class FakePublisher:
    """Stands for a topic with as many listeners as the test says."""

    made = {}

    def __init__(self, name, kind, first, listener):
        self.heard, self.messages, self.closed = 0, [], False
        FakePublisher.made[name] = self

    def get_num_connections(self):
        return self.heard

    def publish(self, message):
        self.messages.append(message)

    def unregister(self):
        self.closed = True


class CountedWorld:
    """A world that counts how often sensors look at it."""

    def __init__(self, world):
        self._world, self.looks = world, 0

    def __getattr__(self, name):
        return getattr(self._world, name)

    def sensed(self):
        self.looks += 1
        return self._world.sensed()


@pytest.fixture
def topics(monkeypatch):
    monkeypatch.setattr(FakePublisher, "made", {})
    monkeypatch.setattr(sensor_topics, "prompt_publisher", FakePublisher)
    world = CountedWorld(World.from_scenario(scenario()))
    topics = sensor_topics.SensorTopics(world, Frames())
    topics.follow_team(scenario())
    return topics, world, FakePublisher.made


def run(topics, world, steps):
    for _ in range(steps):
        world.step()
        topics.after_step()


def test_no_sensor_is_read_without_a_subscriber(topics):
    topics, world, made = topics
    run(topics, world, 100)
    assert world.looks == 0 and not any(each.messages for each in made.values())


def test_those_with_subscribers_are_published_and_no_others(topics):
    topics, world, made = topics
    sonar = made["/robot1/sonar"]
    sonar.heard = 1
    topics.peer_subscribe()
    run(topics, world, 25)  # half a second
    # At once, at the first step, and at the samples of the run: 0.1 s and so on.
    stamps = [message.header.stamp.to_sec() for message in sonar.messages]
    assert stamps == pytest.approx([1.02, 1.1, 1.2, 1.3, 1.4, 1.5])
    assert world.looks == 6
    assert [name for name, each in made.items() if each.messages] == ["/robot1/sonar"]
    assert (
        isinstance(sonar.messages[0], Cloud) and sonar.messages[0].header.frame_id == "robot1/sonar"
    )
    sonar.heard = 0
    topics.peer_unsubscribe()
    run(topics, world, 25)
    assert world.looks == 6 and len(sonar.messages) == 6


def test_a_late_listener_changes_no_value(topics):
    topics, world, made = topics
    early, late = made["/robot2/gps"], made["/robot2/sonar"]
    early.heard = 1
    topics.peer_subscribe()
    run(topics, world, 7)
    late.heard = 1
    topics.peer_subscribe()
    run(topics, world, 13)
    suite = Suite.of_scenario(scenario(), world.team, world.obstacles)
    suite.activate({1: ["sonar"]})
    suite.update(world.steps, world.sensed)
    form = forms_of(suite.mounts[1][0], world.team.kinds[1])[0]
    wanted = form.rows(suite.readings(world.time) and suite.active[0].known(world.time))
    assert late.messages[-1].points == pytest.approx(wanted[1], abs=0.0)


def test_a_team_has_the_topics_of_its_sensors(topics):
    topics, world, made = topics
    told = {(parent, child): place for parent, child, place in topics.fixed_frames()}
    assert told["robot1/base_link", "robot1/laser"] == pytest.approx((0.021, 0.0, 0.3, 0.0))
    assert ("robot2/base_link", "robot2/gps") in told and (
        "robot1/base_link",
        "robot1/imu",
    ) not in told
    assert {"/robot1/sonar_pointcloud2", "/robot1/bumper_state", "/robot1/front_range"} <= set(made)
    less = scenario(sensors=[], poses=[[0.0, 0.0, 0.0]])
    world._world = World.from_scenario(less)
    topics.follow_team(less)
    left = {name for name, each in made.items() if not each.closed}
    assert left == {"/robot1/sonar", "/robot1/sonar_pointcloud2"}


def test_a_sensor_named_as_a_topic_of_the_robots_own_is_refused(topics):
    wrong = scenario(sensors=[{"mounts": {"odom": {"type": "compass"}}}])
    with pytest.raises(ValueError, match="robot1: a sensor called odom"):
        topics[0].follow_team(wrong)


def test_rates_that_are_not_kept_are_said(topics, monkeypatch):
    topics, world, made = topics
    made["/robot1/laser"].heard = 1
    topics.peer_subscribe()
    assert topics.slow(1.0, 1.0) == []  # nobody is read yet
    topics.after_step()
    made["/robot1/laser"].impl = type("", (), {"connections": [type("", (), {"left_out": 3})]})
    late, lost = topics.slow(1.0, 0.6)
    assert late == "laser: 6 Hz of wall time, wanted 10: simulated time is late"
    assert lost == "/robot1/laser: a listener was too slow for 3 messages"
    monkeypatch.setattr(sensor_topics, "LATELY", 0.0)
    assert topics.slow(1.0, 0.95) == []  # the three are long gone
    assert (
        topic_of(3, forms_of(topics._suite.mounts[0][0], world.team.kinds[0])[0]) == "/robot3/sonar"
    )


def test_a_bag_holds_what_the_scenario_has_recorded():
    command = command_of(scenario(record=["bumper", "laser"]), "/some/where", ["__name:=rosbag"])
    assert command[:6] == [
        "rosrun",
        "rosbag",
        "record",
        "--tcpnodelay",
        "-O",
        "/some/where/run.bag",
    ]
    assert command[-1] == "__name:=rosbag" and "/stage/state" in command
    topics = ["/robot{}/{}".format(k, name) for name in ("bumper_state", "laser") for k in (1, 2)]
    assert command[-6:-1] == ["/map", *topics]
    seen = scenario(sensors=[{"mounts": {"eye": {"type": "camera"}}}], record=["eye"])
    assert "/robot2/eye" in command_of(seen, ".")  # pictures are in bags alone
    plain = command_of(scenario(), ".")
    assert not any("robot" in topic or topic == "/map" for topic in plain)


NOISE = {"stddev": 0.02, "quantum": 0.05, "bias": 0.01}


@pytest.mark.parametrize(
    "kind, quantity, told",
    [
        ("gps", "", lambda m: (m.position_covariance, m.position_covariance_type)),
        ("imu", "acceleration", lambda m: (m.linear_acceleration_covariance,)),
        ("imu", "rate", lambda m: (m.angular_velocity_covariance,)),
        ("motion_capture", "heading", lambda m: ((m.pose.covariance[35],),)),
    ],
)
def test_variances_are_those_of_ten_thousand_draws(kind, quantity, told):
    noise = {quantity: NOISE} if quantity else NOISE
    made = scenario(sensors=[{"mounts": {"it": {"type": kind, "noise": noise}}}])
    (mount,) = [
        m for m in fitted_mounts(Team.from_scenario(made), made.sensors)[0] if m.name == "it"
    ]
    draws = Draws(dict(mount.noise), Streams(3, [1], "it"), 0.02)
    # Far from a multiple of the quantum, and from sample to sample elsewhere.
    true = np.linspace(0.0, 7.0, 10000)
    errors = [draws.at(k).noisy(np.array([[v]]), quantity)[0, 0] - v for k, v in enumerate(true)]
    squares = np.square(errors)
    item = {
        "gps": [0.1, 0.2, 3.0],
        "imu": [(0, 0, 9.8), (0, 0, 0)],
        "motion_capture": [1.0, 2.0, 0.5],
    }
    form = forms_of(mount, Team.from_scenario(made).kinds[0])[-1]
    (known, *of), mean = told(form.message(item[kind], Header())), squares.mean()
    assert known[0] == pytest.approx(mean, abs=4.0 * squares.std() / 100.0)
    assert of in ([], [NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN])
    if kind == "imu":
        assert form.message(item[kind], Header()).orientation_covariance[0] == -1.0


def test_what_is_lost_or_without_noise_has_no_known_variance():
    for noise, item in (({}, [0.1, 0.2, 3.0]), ({"stddev": 1.0}, [math.nan] * 3)):
        made = scenario(sensors=[{"mounts": {"it": {"type": "gps", "noise": noise}}}])
        mounts = fitted_mounts(Team.from_scenario(made), made.sensors)[0]
        (form,) = forms_of(next(m for m in mounts if m.name == "it"), None)
        message = form.message(item, Header())
        assert message.position_covariance_type == NavSatFix.COVARIANCE_TYPE_UNKNOWN
        assert not any(message.position_covariance)


def test_filters_learn_what_motion_capture_does_not_measure():
    made = scenario(
        sensors=[{"mounts": {"it": {"type": "motion_capture", "noise": {"position": NOISE}}}}]
    )
    mounts = fitted_mounts(Team.from_scenario(made), made.sensors)[0]
    plain, surely = forms_of(next(m for m in mounts if m.name == "it"), None)
    message = sent(surely, [1.0, 2.0, 0.5])
    assert message.pose.pose == plain.message([1.0, 2.0, 0.5], Header()).pose
    variance = 0.02**2 + 0.05**2 / 12.0 + 0.01**2
    known = [variance, variance, 1e6, 1e6, 1e6, 1e-6]
    assert np.reshape(message.pose.covariance, (6, 6)) == pytest.approx(np.diag(known))
    assert surely.reading(message, 3.0) == plain.reading(message.pose, 3.0)
