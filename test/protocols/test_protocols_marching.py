"""Formations that move: paths, feed-forward and lag, l-psi control, and their scenarios."""

import numpy as np
import pytest
from protocol_fixtures import (
    as_points,
    check,
    ended_early,
    failed,
    part_of_shipped,
    shipped,
    verdict_of,
)

from mrs_simulator.core.graphs import Topology
from mrs_simulator.protocols.making import make_control
from mrs_simulator.protocols.marching import equations as laws
from mrs_simulator.protocols.marching.law import LeaderFollower, Marching, tree

HOLDS = {
    "marching": ["steady displacement error [m]", "drift of the centre from the path [m]"],
    "marching_lag": ["lag of robot 1 [m]", "worst difference from the lags [m]"],
    "marching_patrol": ["steady displacement error [m]", "distance from the path's places [m]"],
    "leader_follower": [
        "worst separation error at the end [m]",
        "decay rate of the separation error [1/s]",
    ],
}


# Paths.


def test_paths_pass_where_they_should():
    half = np.pi * 2.0
    passes = lambda path, s, wanted: np.testing.assert_allclose(  # noqa: E731
        path.at([s])[0], wanted, atol=1e-9
    )
    passes(laws.make_path("line"), 7.0, [7, 0, 0])
    circle = laws.make_path("circle", 2.0)
    passes(circle, half, [0, 4, np.pi])
    passes(circle, 3 * half, [0, 4, 3 * np.pi])
    eight = laws.make_path("eight", 2.0)
    passes(eight, half, [0, 4, np.pi])
    passes(eight, 2 * half, [0, 0, 2 * np.pi])
    passes(eight, 3 * half, [0, -4, np.pi])
    passes(eight, 4 * half, [0, 0, 0])
    square = laws.make_path("polygon", 1.0, [[0, 0], [6, 0], [6, 4], [0, 4]])
    passes(square, 0.0, [3, 0, 0])
    passes(square, 2.0, [5, 0, 0])
    passes(square, 2.0 + np.pi / 2, [6, 1, np.pi / 2])
    passes(square, 4.0 + np.pi / 2, [6, 3, np.pi / 2])
    assert square.length == pytest.approx(20.0 - 8.0 + 2.0 * np.pi)
    passes(square, square.length + 2.0, [5, 0, 2.0 * np.pi])


@pytest.mark.parametrize("name", laws.PATHS)
def test_paths_are_passed_at_constant_speed_without_a_jump(name):
    path = laws.make_path(name, 1.2, [[0, 0], [9, 1], [7, 8], [4, 3], [-2, 6]])
    pose = path.at(np.arange(0.0, 120.0, 0.01))
    np.testing.assert_allclose(np.hypot(*np.diff(pose[:, :2], axis=0).T), 0.01, rtol=1e-4)
    assert np.abs(np.diff(pose[:, 2])).max() < 0.01 / 1.2 + 1e-9


def test_a_path_that_cannot_be_is_refused():
    with pytest.raises(ValueError, match="corner at waypoint 2 has room for 1 m"):
        laws.make_path("polygon", 3.0, [[0, 0], [2, 0], [2, 2], [0, 2]])
    for text in ("", "1 2, 3 4", "1 2, 3, 4 5", "a b, c d, e f", "0 0, 1 0, nan 1"):
        with pytest.raises(ValueError, match="at least three points"):
            laws.read_waypoints(text)
    with pytest.raises(ValueError, match="wanted one of line, circle"):
        laws.make_path("spiral")
    control = make_control(shipped("marching_patrol"))
    with pytest.raises(ValueError, match="room for"):
        control.set_parameters(dict(control.parameters, radius=50.0))
    assert control.radius == 4.0  # all or nothing


def test_the_reference_turns_and_swings():
    places = np.array([[1.0, 0.0], [0.0, 2.0]])
    circle = laws.make_path("circle", 2.0)
    wanted = laws.reference(circle, places, [0.0, np.pi], [1.0, 1.5], turning=True)
    np.testing.assert_allclose(wanted[0], places, atol=1e-12)
    # A quarter of the circle on: at (2, 2), heading along y.
    np.testing.assert_allclose(wanted[1], [[2.0, 3.5], [-1.0, 2.0]], atol=1e-12)


# Equations, typed out.


def test_marching():
    points = np.array([[0.0, 0.0], [3.0, 0.0]])
    wanted = np.array([[1.0, 1.0], [2.0, 1.0]])
    graph = Topology(2, [(1, 2)])
    velocity = np.array([[0.5, 0.0], [0.0, 0.25]])
    u = laws.marching(points, wanted, velocity, graph, 0.5, anchor=0.1)
    # 0.5 (3 - 1) from the edge, 0.1 (1, 1) from the anchor.
    np.testing.assert_allclose(u, [[1.6, 0.1], [-0.1, 0.35]])


def test_leader_follower_straight_behind():
    pose, leader = np.array([[-2.1, 0.0, 0.0]]), np.zeros((1, 3))
    command = laws.leader_follower(
        pose, leader, np.array([[1.0, 0.0]]), 1.0, np.pi, k1=0.5, k2=1.0, l=0.1
    )
    np.testing.assert_allclose(command, [[1.5, 0.0]], atol=1e-12)


def test_leader_follower_is_the_printed_law():
    """v and omega of Desai, Ostrowski, Kumar (2001), with their divisions by cos gamma."""
    draw = np.random.default_rng(1)
    k1, k2, d = 0.7, 0.4, 0.3
    for _ in range(20):
        leader, pose = draw.uniform(-1, 1, 3), draw.uniform(-1, 1, 3)
        pose[:2] -= [2.0, 1.0]
        v, omega = draw.uniform(0.1, 1.0, 2)
        x, y = pose[:2] + d * np.array([np.cos(pose[2]), np.sin(pose[2])]) - leader[:2]
        length, psi = np.hypot(x, y), np.arctan2(y, x) - leader[2]
        psi = (psi + np.pi) % (2 * np.pi) - np.pi
        wanted, angle = 1.5, psi + 0.3
        gamma = leader[2] + psi - pose[2]
        rho = (k1 * (wanted - length) + v * np.cos(psi)) / np.cos(gamma)
        turn = (np.cos(gamma) / d) * (
            k2 * length * (angle - psi)
            - v * np.sin(psi)
            + length * omega
            + rho * np.sin(gamma)
        )  # fmt: skip
        forward = rho - d * turn * np.tan(gamma)
        found = laws.leader_follower(
            pose[np.newaxis], leader[np.newaxis], np.array([[v, omega]]), wanted, angle, k1, k2, d
        )
        np.testing.assert_allclose(found, [[forward, turn]], rtol=1e-9)


def test_who_follows_whom():
    leader, levels = tree(Topology(6, [(2, 1), (4, 2), (3, 1), (5, 6), (6, 5)]))
    assert leader.tolist() == [0, 0, 0, 1, 5, 4]
    assert [rows.tolist() for rows in levels] == [[0], [1, 2], [3]]


# Theorems.


@pytest.mark.parametrize("path", laws.PATHS)
@pytest.mark.parametrize("anchor", [0.0, 0.5])
def test_point_masses_march_without_steady_error(path, anchor):
    parameters = {"path": path, "anchor": anchor, "swing": 0.3, "gain": 1.0}
    given = as_points(shipped("marching_patrol", parameters))
    control = make_control(given)
    start = given.poses[:, :2] + 1.0
    hand, track = start.copy(), []
    for step in range(1600):
        control.time = 0.02 * step
        if step % 400 == 0:
            track.append(hand)
        hand = hand + 0.02 * control.pointMassLaw(hand)
    expected = control.prediction(start, 0.02 * np.array([0, 400, 800, 1200, 1600]))
    np.testing.assert_allclose(track + [hand], expected, rtol=0.0, atol=1e-9)
    control.time = 32.0
    np.testing.assert_allclose(control.targets(hand), hand, atol=1e-4)
    on_path = np.linalg.norm(hand - control.wanted([32.0])[0], axis=1).max()
    assert (on_path < 1e-4) == (anchor > 0.0)


def test_without_feed_forward_a_chain_lags_by_i_v_over_kappa():
    given = as_points(shipped("marching_lag"))
    control = make_control(given)
    hand = given.poses[:, :2].copy()
    for step in range(3000):
        control.time = 0.02 * step
        hand = hand + 0.02 * control.pointMassLaw(hand)
    behind = hand - control.wanted([60.0])[0]
    lag = behind[4] - behind
    # Follower i counts from the leader, robot 5: i 0.3/0.6.
    np.testing.assert_allclose(lag[:, 0], [2.0, 1.5, 1.0, 0.5, 0.0], atol=1e-9)
    np.testing.assert_allclose(lag[:, 1], 0.0, atol=1e-9)


@ended_early({"marching": 0.3, "marching_lag": 0.6, "marching_patrol": 0.4, "leader_follower": 0.3})
def test_the_shipped_scenario_passes(tmp_path, name, share):
    # With fewer commands a second the rate on the patrol is not judged.
    rate = 10 if share < 1.0 and name != "marching_patrol" else None
    verdict = verdict_of(part_of_shipped(name, share, rate=rate), tmp_path)
    assert verdict["passed"], failed(verdict)
    # Nothing was left out: theory speaks of the whole run.
    assert all(check["passed"] for check in verdict["checks"])
    assert set(HOLDS[name]) <= {check["name"] for check in verdict["checks"]}
    assert verdict["min_distance"] > 1.0


def test_the_rate_on_points_is_that_of_theory(tmp_path):
    verdict = verdict_of(as_points(shipped("marching", rate=10, duration=40.0)), tmp_path)
    assert verdict["passed"], failed(verdict)
    rate = check(verdict, "decay rate of the error [1/s]")
    assert rate["note"] == "" and rate["measured"] == pytest.approx(rate["predicted"], rel=0.02)


@pytest.mark.parametrize("name", ["marching", "leader_follower"])
def test_who_starts_in_place_passes_without_a_rate(tmp_path, name):
    given = shipped(name, duration=5.0)
    places = make_control(given).places()
    poses = np.column_stack([places - [given.hand_length, 0.0], np.zeros(given.n)])
    if name == "leader_follower":  # followers' hand points are placed about the leader's centre
        poses[0, 0] += given.hand_length
    verdict = verdict_of(given._replace(poses=poses), tmp_path)
    assert verdict["passed"], failed(verdict)
    rates = [one for one in verdict["checks"] if one["name"].startswith("decay rate")]
    assert rates and {one["passed"] for one in rates} == {None}


def test_a_follower_that_turns_far_in_its_first_commands_passes(tmp_path):
    """Commands held for 0.2 s turn it by 1 rad: far from where the linearised law's rates hold."""
    poses = [
        [-0.018, 0.065, 0.476],
        [-1.506, 1.318, 0.353],
        [-2.423, -1.446, -0.086],
        [-3.723, 1.805, 0.772],
        [-3.489, -3.327, 0.383],
    ]
    given = shipped("leader_follower", rate=5.0, poses=poses, duration=42.0)
    verdict = verdict_of(given, tmp_path)
    assert verdict["passed"], failed(verdict)
    rates = [one for one in verdict["checks"] if one["name"].startswith("decay rate")]
    assert rates and all(one["passed"] for one in rates)


def test_a_row_of_followers_keeps_separation_and_bearing(tmp_path):
    """Each follows the one ahead and knows its command, so that no error is handed on."""
    row = [[-1.6 * i, 0.1 * i, 0.0] for i in range(4)]
    given = shipped(
        "leader_follower",
        {"shape": "line", "path": "circle", "l": 0.3},
        poses=row,
        robots=4,
        topology={"edges": [[2, 1], [3, 2], [4, 3]]},
        limits="none",
        duration=20.0,
    )
    verdict = verdict_of(given, tmp_path)
    assert verdict["passed"], failed(verdict)
    assert check(verdict, "decay rate of the separation error [1/s]")["passed"]


# Broken variants fail.


class NoFeedForward(Marching):
    """Claims what needs the feed-forward, and has none."""

    def pointMassLaw(self, hand):
        now = self.wanted([self.time])[0]
        return laws.marching(hand, now, np.zeros_like(hand), self.topology, self.gain, self.anchor)


class WrongSign(Marching):
    def pointMassLaw(self, hand):
        return -super().pointMassLaw(hand)


@pytest.mark.parametrize(
    "name, protocol",
    [("marching", NoFeedForward), ("marching", WrongSign), ("marching_patrol", NoFeedForward)],
)
def test_a_broken_march_fails(tmp_path, name, protocol):
    verdict = verdict_of(shipped(name, rate=10, duration=20.0), tmp_path, protocol)
    steady = check(verdict, "steady displacement error")
    touched = "touched at" in steady["note"]  # and so no theorem speaks of the rest
    assert steady["name"] in failed(verdict) or touched
    assert "commands off the published law [-]" in failed(verdict)


def test_a_follower_whose_edge_is_down_half_the_time_lags_twice_as_far(tmp_path):
    edges = [[i, i + 1] for i in range(1, 5)]
    links = {"switching": {"graphs": [edges, []], "dwell": 0.1}}
    scenario = shipped("marching_lag", rate=10, duration=32.0, links=links)
    verdict = verdict_of(scenario, tmp_path)
    lag = check(verdict, "lag of robot 1 [m]")
    assert lag["measured"] == pytest.approx(2.0 * lag["predicted"], rel=0.01)


def test_a_feed_forward_that_everybody_has_leaves_no_lag(tmp_path):
    class Everybody(Marching):
        def _listens(self):
            return np.zeros(5, dtype=bool) if self.running else super()._listens()

        running = True

        def claims(self, start):
            self.running = False
            return super().claims(start)

    verdict = verdict_of(shipped("marching_lag", rate=10, duration=24.0), tmp_path, Everybody)
    assert check(verdict, "lag of robot 1 [m]")["measured"] == pytest.approx(0.0, abs=0.01)
    assert "lag of robot 1 [m]" in failed(verdict)


@pytest.mark.parametrize(
    "name, topology, parameters, said",
    [
        ("marching", {"edges": [[1, 2], [4, 5]], "directed": False}, {}, "spanning tree"),
        ("marching", None, {"gain": -0.1}, "gain above 0"),
        ("marching", None, {"gain": 60.0}, "Tc < 2/(gain lambda_max + anchor) [s]"),
        ("marching", None, {"feed_forward": False}, "straight path"),
        ("marching_lag", None, {"anchor": 0.1}, "no anchor"),
        ("marching_lag", {"preset": "cycle"}, {}, "one leader"),
        ("leader_follower", {"edges": [[2, 1], [3, 1], [4, 2]]}, {}, "spanning tree"),
        ("leader_follower", {"preset": "path"}, {}, "one leader each"),
        ("leader_follower", None, {"k1": -0.1}, "k1 and k2 above 0"),
        ("leader_follower", None, {"k2": 100.0}, "k Tc < 2"),
        ("leader_follower", None, {"speed": 0.0}, "moving forward"),
    ],
)
def test_outside_the_theorem_the_verdict_says_so(tmp_path, name, topology, parameters, said):
    changes = {"duration": 0.4}
    if topology is not None:
        changes["topology"] = topology
    verdict = verdict_of(shipped(name, parameters, **changes), tmp_path)
    sufficient = {"straight path", "no anchor", "one leader", "one leader each", "moving forward"}
    assert (said in failed(verdict)) == (said not in sufficient)
    assert verdict["outcome"] == ("not_judged" if said in sufficient else "failed")
    assert check(verdict, said)["note"]


def test_points_cannot_keep_a_bearing(tmp_path):
    verdict = verdict_of(as_points(shipped("leader_follower", duration=0.4)), tmp_path)
    assert verdict["outcome"] == "not_judged" and "robots with headings" in verdict["reason"]


def test_a_follower_that_ignores_its_leaders_motion_fails(tmp_path):
    class Alone(LeaderFollower):
        def calculateControlLaw(self, pos_map):
            twists = super().calculateControlLaw(pos_map)
            for number in self.numbers[1:]:
                twists[number].linear.x -= self.speed
            return twists

    given = shipped("leader_follower", duration=12.0)
    assert "worst separation error at the end [m]" in failed(verdict_of(given, tmp_path, Alone))


def test_the_wrong_sign_of_the_separation_fails(tmp_path):
    class Away(LeaderFollower):
        def calculateControlLaw(self, pos_map):
            self.k1 = -self.parameters["k1"]
            try:
                return super().calculateControlLaw(pos_map)
            finally:
                self.k1 = self.parameters["k1"]

    given = shipped("leader_follower", duration=10.0)
    assert "worst separation error at the end [m]" in failed(verdict_of(given, tmp_path, Away))


def test_followers_are_wanted_beside_their_leader():
    given = shipped("leader_follower")
    control = make_control(given)
    hand = given.poses[:, :2] + [given.hand_length, 0.0]
    assert control.targets(hand) is None  # before any pose is known
    control.commands(given.poses)
    targets = control.targets(hand)
    places = control.places()
    np.testing.assert_allclose(targets[1:], (places - places[0])[1:], atol=1e-9)
    np.testing.assert_allclose(targets[0], hand[0])


def test_robots_that_turn_while_commands_are_held_keep_their_rates(tmp_path):
    poses = [
        [0.4, -0.1, -0.3],
        [-1.8, 2.1, -0.2],
        [-1.8, -1.2, 0.5],
        [-3.7, 1.8, 0.4],
        [-3.4, -3.2, 0.8],
    ]
    verdict = verdict_of(
        shipped("leader_follower", rate=10.0, duration=30.0, poses=poses), tmp_path
    )
    rate = check(verdict, "decay rate of the bearing error [1/s]")
    assert rate["passed"] and rate["measured"] == pytest.approx(
        0.6, abs=0.005
    )  # k2, as if not held
    assert rate["predicted"] == pytest.approx(-np.log(1.0 - 0.6 * 0.1) / 0.1)
