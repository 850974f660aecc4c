"""The control hook: what it gets, what it may return, what is refused."""

import copy
import pickle

import numpy as np
import pytest
from geometry_msgs.msg import Twist, Vector3

from mrs_simulator import Parameter, PioneerControl, make_twist
from mrs_simulator.control.pioneer_control import ControlError, Position
from mrs_simulator.control.twists import commands_of
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import Limits, hand_points, unicycle_from_point_mass
from mrs_simulator.protocols.formation.law import Formation
from mrs_simulator.protocols.loading import ProtocolError, load_protocol
from mrs_simulator.scenario.team.robots import DEFAULT_KIND
from mrs_simulator.vehicles import Team

POSE = np.array([[9.95, -5.0, 0.0], [4.95, -2.0, 0.0], [1.95, 8.0, 0.0]])
LIMITS = Limits(0.75, 1.745, 0.3, 1.745)


class Forward(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {number: make_twist(0.1 * number, 0.0) for number in pos_map}


class Rendezvous(PioneerControl):
    PARAMETERS = (Parameter("gain", 0.5, "1/s", low=0.0, meaning="of the consensus"),)

    def pointMassLaw(self, hand):
        return self.gain * (
            self.topology.neighbour_sum(hand) - hand * self.topology.in_degree()[:, None]
        )


def returning(value):
    class Law(PioneerControl):
        def calculateControlLaw(self, pos_map):
            return value

    return Law(range(1, 4))


def test_the_hook_gets_numbers_and_positions():
    seen = {}

    class Watch(PioneerControl):
        def calculateControlLaw(self, pos_map):
            seen.update(pos_map)
            return [Twist() for _ in pos_map]

    Watch(range(1, 4)).commands(POSE)
    assert list(seen) == [1, 2, 3]
    assert (seen[2].x, seen[2].y, seen[2].theta) == (4.95, -2.0, 0.0)


def test_twists_by_number_or_in_order():
    expected = [[0.1, 0.0], [0.2, 0.0], [0.3, 0.0]]
    np.testing.assert_allclose(Forward(range(1, 4)).commands(POSE), expected)
    in_order = returning([make_twist(v, 0.0) for v in (0.1, 0.2, 0.3)])
    np.testing.assert_allclose(in_order.commands(POSE), expected)


def test_planar_twists_are_twists_whose_vectors_may_be_read_written_and_copied():
    twist = make_twist(0.25, -0.5)
    assert isinstance(twist, Twist) and twist == full_twist(0.25, -0.5) == make_twist(0.25, -0.5)
    assert twist != full_twist(0.25, 0.5) and make_twist(0.25, 0.0) != twist
    for other in (copy.deepcopy(make_twist(0.25, -0.5)), pickle.loads(pickle.dumps(twist))):
        assert other == twist and str(other) == str(twist)
    assert type(make_twist(0.25, -0.5))() == Twist()
    twist.linear.x += 1.0
    assert (twist.linear.x, twist.linear.z, twist.angular.z) == (1.25, 0.0, -0.5)
    with pytest.raises(AttributeError, match="'speed'"):
        twist.speed  # noqa: B018


@pytest.mark.parametrize("read", [(), (1,), (1, 2, 3)])
def test_commands_are_those_of_twists_whoever_made_and_read_them(read):
    twists = [make_twist(0.1, 0.2), make_twist(np.float64(0.3), 1), full_twist(0.5, 0.6)]
    for number in read:
        twists[number - 1].angular.z += 0.125
    wanted = [[0.1, 0.2], [0.3, 1.0], [0.5, 0.6]]
    wanted = [[v, omega + 0.125 * (row + 1 in read)] for row, (v, omega) in enumerate(wanted)]
    team = Team((DEFAULT_KIND,) * 3, None)
    by_number = {3: twists[2], 1: twists[0], 2: twists[1]}
    for given in (twists, by_number, dict(zip((1, 2, 3), twists)), [*twists[:2], twists[2]]):
        np.testing.assert_array_equal(commands_of(given, (1, 2, 3), team), wanted)
    np.testing.assert_array_equal(
        commands_of(list(map(make_twist, (1, 2), (3, 4))), (1, 2), Team((DEFAULT_KIND,) * 2, None)),
        [[1.0, 3.0], [2.0, 4.0]],
    )


def test_planar_twists_that_were_written_to_tell_what_was_written():
    twists = [make_twist(0.1, 0.2), make_twist(0.3, 0.4), make_twist(0.6, 0.7)]
    twists[1].linear.x = 0.5
    twists[2].angular = Vector3(0.0, 0.0, 0.8)
    found = commands_of(twists, (1, 2, 3), Team((DEFAULT_KIND,) * 3, None))
    np.testing.assert_array_equal(found, [[0.1, 0.2], [0.5, 0.4], [0.6, 0.8]])
    twist = make_twist(0.1, 0.2)
    twist.linear = Vector3(0.5, 0.0, 0.0)
    assert twist == full_twist(0.5, 0.2)


def test_commands_just_beyond_a_limit_are_not_within():
    team = Team((DEFAULT_KIND,) * 2, Limits(0.5, 1.0, 1.0, 1.0))
    for command, within in (((0.5, -1.0), True), ((0.5001, 0.0), False), ((0.0, -1.0001), False)):
        assert team.is_within(np.array([(0.1, 0.1), command])) == within
    assert not team.is_within(np.full((2, 2), np.nan))
    assert not Team((DEFAULT_KIND,) * 2, None).is_within(np.zeros((2, 2)))  # nobody knows


def full_twist(v, omega):
    twist = Twist()
    twist.linear.x, twist.angular.z = v, omega
    return twist


def test_default_law_is_the_papers():
    control = Formation(range(1, 4))
    # u_1 = -0.2 (3, -3): v = -0.6, omega = 0.6/0.05
    np.testing.assert_allclose(control.commands(POSE)[0], [-0.6, 12.0])
    np.testing.assert_allclose(control.commands(POSE)[2], [0.0, 0.0])


def test_hook_and_arrays_agree_to_the_bit():
    control = Formation(range(1, 4), limits=LIMITS)
    twists = control.calculateControlLaw(dict(zip(control.numbers, POSE)))
    by_hook = np.array([[twists[n].linear.x, twists[n].angular.z] for n in (1, 2, 3)])
    unlimited = Formation(range(1, 4)).commands(POSE)
    np.testing.assert_array_equal(by_hook, unlimited)


def test_commands_keep_within_limits_and_keep_their_direction():
    free = Formation(range(1, 4)).commands(POSE)
    for saturation in ("robot", "team"):
        kept = Formation(range(1, 4), limits=LIMITS, saturation=saturation).commands(POSE)
        assert np.all(np.abs(kept) <= np.array([0.75, 1.745]) + 1e-12)
        np.testing.assert_allclose(kept[:, 0] * free[:, 1], kept[:, 1] * free[:, 0], atol=1e-12)


def test_array_route_with_own_parameter_and_topology():
    control = Rendezvous(range(1, 4), Topology.preset("path", 3), parameters={"gain": 2.0})
    u = -2.0 * Topology.preset("path", 3).laplacian() @ hand_points(POSE, 0.05)
    expected = np.stack([u[:, 0], u[:, 1] / 0.05], axis=1)
    np.testing.assert_allclose(control.commands(POSE), expected)
    assert [parameter.name for parameter in Rendezvous.PARAMETERS] == ["gain", "l"]


@pytest.mark.parametrize(
    "value, said",
    [
        (None, "returned NoneType, wanted 3 Twists"),
        ([Twist()], "returned list of 1, wanted 3 Twists"),
        ({1: Twist(), 2: Twist()}, "Twists for robots 1, 2, wanted 1, 2, 3"),
        ({1: Twist(), 2: Twist(), 4: Twist()}, "robots 1, 2, 4, wanted 1, 2, 3"),
        ([Twist(), Twist(), 3.0], "returned float for robot 3"),
        ([make_twist(0.0, 0.0), make_twist(float("nan"), 0.0), Twist()], "robot 2 v = nan"),
        ([make_twist(0.0, float("inf")), Twist(), Twist()], "robot 1 v = 0.0 m/s, omega = inf"),
    ],
)
def test_wrong_returns_are_named(value, said):
    with pytest.raises(ControlError, match=said):
        returning(value).commands(POSE)


def test_wrong_shape_of_the_array_route():
    class Wrong(PioneerControl):
        def pointMassLaw(self, hand):
            return hand[:2]

    with pytest.raises(ControlError, match=r"shape \(2, 2\), wanted \(3, 2\)"):
        Wrong(range(1, 4)).commands(POSE)


def test_complex_velocities_are_none():
    class Wrong(PioneerControl):
        def pointMassLaw(self, hand):
            return 1j * hand

    with pytest.raises(ControlError, match="returned ndarray of complex128, wanted an array"):
        Wrong(range(1, 4)).commands(POSE)


@pytest.mark.parametrize(
    "k, said", [(0.0, "diverges for k <= 0"), (-0.1, "k = -0.1"), (1.0, "overshoots")]
)
def test_impossible_gains_are_refused_with_the_reason(k, said):
    with pytest.raises(ValueError, match=said):
        Formation(range(1, 4), parameters={"k": k})


@pytest.mark.parametrize(
    "given", [{"T": 0.0}, {"l": -1.0}, {"c": float("nan")}, {"closure": "ring"}]
)
def test_other_parameters_are_checked(given):
    with pytest.raises(ValueError, match=next(iter(given))):
        Formation(range(1, 4), parameters=given)


def test_an_unknown_parameter_names_the_nearest():
    with pytest.raises(ValueError, match="did you mean 'closure'"):
        Formation(range(1, 4), parameters={"closur": "chain"})


def test_a_refused_change_leaves_everything_as_it_was():
    control = Formation(range(1, 4), parameters={"k": 0.05})
    with pytest.raises(ValueError):
        control.set_parameters({"k": 0.1, "T": -1.0})
    assert (control.k, control.T) == (0.05, 0.1)


def test_literal_numbers_warn_and_the_defaults_do_not():
    assert "spin" in Formation(range(1, 4), period=0.1).warnings(POSE)[0]
    assert Formation(range(1, 4), period=0.02).warnings(POSE) == []
    assert Formation(range(1, 4), limits=LIMITS, period=0.1).warnings(POSE) == []


def test_the_topology_changes_while_running():
    control = Formation(range(1, 4))
    control.set_topology(Topology(3, [(1, 3)]))
    assert (control.closure, control.topology.neighbours(1)) == ("topology", [3])
    # Robot 1 belongs 2 c = 4 m ahead of robot 3.
    hand = hand_points(POSE, 0.05)
    np.testing.assert_allclose(control.targets(hand)[0], hand[2] + [4.0, 0.0])
    with pytest.raises(ValueError, match="over 4 robots, wanted 3"):
        control.set_topology(Topology(4, []))


def test_a_parameter_may_not_hide_what_the_class_uses():
    with pytest.raises(TypeError, match="may not be called 'limits'"):

        class Hides(PioneerControl):
            PARAMETERS = (Parameter("limits", 1.0),)


LAW = """
from mrs_simulator import PioneerControl, make_twist

class Turn(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {i: make_twist(0.0, 0.5) for i in pos_map}
"""


def test_protocols_are_found_by_file_module_and_name(tmp_path, monkeypatch):
    (tmp_path / "turn.py").write_text(LAW)
    beside = str(tmp_path / "scenario.yaml")
    for name in ("turn.py", "turn.py:Turn", str(tmp_path / "turn.py")):
        found = load_protocol(name, beside)
        np.testing.assert_array_equal(found([1]).commands(POSE[:1]), [[0.0, 0.5]])
    assert load_protocol("formation") is Formation
    assert load_protocol("mrs_simulator.control.pioneer_control:PioneerControl") is PioneerControl


@pytest.mark.parametrize(
    "name, said",
    [
        ("formatoin", "did you mean 'formation'"),
        ("nowhere.py", "not found"),
        ("no_such_module:Law", "importing no_such_module raised"),
        ("mrs_simulator.control.pioneer_control:Pioneer", "did you mean 'PioneerControl'"),
        ("json:JSONDecoder", "unknown 'JSONDecoder'"),
    ],
)
def test_protocols_that_cannot_be_had(name, said):
    with pytest.raises(ProtocolError, match=said):
        load_protocol(name)


def test_a_protocol_file_that_fails_says_so(tmp_path):
    (tmp_path / "broken.py").write_text("raise RuntimeError('half done')")
    with pytest.raises(ProtocolError, match="RuntimeError: half done"):
        load_protocol(str(tmp_path / "broken.py"))


class Gather(PioneerControl):
    def neighbourLaw(self, robot, theta, neighbours):
        return sum(n.weight * n.x for n in neighbours), sum(n.weight * n.y for n in neighbours)


class GatherWithoutCompass(Gather):
    LOCAL_FRAMES = True


def test_a_law_of_neighbours_alone_is_the_same_consensus():
    pose = np.array([[0.0, 0.0, 0.3], [2.0, 1.0, -2.0], [1.0, 4.0, 1.1]])
    topology = Topology(3, [(1, 2, 0.5), (2, 3), (3, 1, 2.0)])
    u = -topology.laplacian() @ hand_points(pose, 0.05)
    expected = unicycle_from_point_mass(u, pose[:, 2], 0.05)
    for law in (Gather, GatherWithoutCompass):
        np.testing.assert_allclose(law(range(1, 4), topology).commands(pose), expected, atol=1e-12)


def test_local_frames_show_neighbours_as_the_robot_sees_them():
    seen = {}

    class Look(PioneerControl):
        LOCAL_FRAMES = True

        def neighbourLaw(self, robot, theta, neighbours):
            seen[robot] = theta, neighbours
            return 0.0, 0.0

    # Robot 2 stands 2 m to the left of robot 1, which looks along y.
    pose = np.array([[0.0, 0.0, np.pi / 2], [-2.0, 0.0, np.pi / 2]])
    Look([1, 2], Topology(2, [(1, 2)])).commands(pose)
    theta, (neighbour,) = seen[1]
    assert theta == 0.0 and neighbour.number == 2
    assert (neighbour.x, neighbour.y) == pytest.approx((0.0, 2.0))
    assert seen[2] == (0.0, ())


MIXED = ("pioneer3dx", "robotino3", "f1tenth")


def twist_with(**components):
    twist = Twist()
    for name, value in components.items():
        setattr(getattr(twist, name[:-2]), name[-1], value)
    return twist


@pytest.mark.parametrize(
    "twists, said",
    [
        ([twist_with(linear_y=0.1), Twist(), Twist()],
         r"robot 1 linear.y = 0.1, which a Pioneer 3-DX does not obey; wanted 0 \(it obeys linear.x"),
        ([Twist(), twist_with(linear_y=0.1), twist_with(linear_y=float("nan"))],
         "robot 3 linear.y = nan, which a"),
        ([Twist(), twist_with(linear_z=-2.0), Twist()], "robot 2 linear.z = -2, which a"),
        ([Twist(), twist_with(angular_x=1.0), Twist()], "robot 2 angular.x = 1, which a"),
    ],
)  # fmt: skip
def test_a_component_that_a_robot_does_not_obey_is_refused_by_name(twists, said):
    control = returning(twists)
    control.__init__(range(1, 4), team=Team(MIXED))
    with pytest.raises(ControlError, match=said):
        control.commands(POSE)


def test_a_mixed_team_has_a_column_for_each_axis():
    given = [make_twist(0.1, 0.2), twist_with(linear_x=0.1, linear_y=0.2), make_twist(0.5, 0.1)]
    control = returning(given)
    control.__init__(range(1, 4), team=Team(MIXED), period=0.1)
    wanted = [[0.1, 0.0, 0.2], [0.1, 0.2, 0.0], [0.5, 0.0, 0.1]]
    np.testing.assert_allclose(control.commands(POSE), wanted)


def test_points_of_a_mixed_team_move_as_the_law_wants():
    class Drift(PioneerControl):
        def pointMassLaw(self, points):
            return np.full((3, 2), 0.05)

    control = Drift(range(1, 4), team=Team(MIXED), parameters={"l": 0.2})
    command = control.commands(POSE)
    moved = control.team.velocity(command, POSE, np.zeros(3), control.l, control.period)
    np.testing.assert_allclose(moved, 0.05)
    steered = control.commands(POSE, 0.02)  # by now the car's wheel is known to have turned
    assert control.joints[2] > 0.0 and not np.allclose(steered[2], command[2])


def test_a_position_unpacks_to_three_and_knows_its_height():
    x, y, theta = position = Position(1.0, 2.0, 3.0)
    assert (x, y, theta) == (1.0, 2.0, 3.0) and position.z == 0.0


@pytest.mark.parametrize("value", [float("nan"), 1e300])
def test_a_law_by_arrays_that_gives_cars_no_finite_velocity_learns_of_which_robot(value):
    class Astray(PioneerControl):
        def pointMassLaw(self, hand):
            return np.array([[0.1, 0.0], [value, 0.0], [0.1, 0.0]])

    control = Astray((1, 2, 3), team=Team(("f1tenth",) * 3, "top"))
    if value > 1e299:  # absurd, yet a number: within limits all the same
        assert np.isfinite(control.commands(np.zeros((3, 3)))).all()
        return
    with pytest.raises(ControlError, match="robot 2 linear.x = nan|robot 2 v = nan"):
        control.commands(np.zeros((3, 3)))
