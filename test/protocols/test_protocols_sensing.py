"""Protocols of robots that know what they sense: equations by hand, verdicts, and what they depend on."""

import numpy as np
import pytest
from protocol_fixtures import check, failed, shipped, verdict_of

from mrs_simulator.core.compiling import VARIABLE
from mrs_simulator.protocols.exploration import equations as floors
from mrs_simulator.protocols.exploration.law import Exploration
from mrs_simulator.protocols.making import make_control
from mrs_simulator.protocols.sensing import equations as laws
from mrs_simulator.scenario.surroundings.obstacles import Cylinder, wall
from mrs_simulator.sensors.types.ranging import RangeReading
from mrs_simulator.study.run.experiment import Experiment, played
from mrs_simulator.study.run.simulating import simulate
from mrs_simulator.study.run.snapshots import Copied


def test_the_smallest_circle_goes_through_two_or_three_points():
    np.testing.assert_allclose(laws.smallest_circle([[0, 0], [4, 0], [2, 1]]), [2, 0])
    np.testing.assert_allclose(laws.smallest_circle([[0, 0], [4, 0], [2, 3]]), [2, 5 / 6])
    np.testing.assert_allclose(laws.smallest_circle([[1, 2], [1, 2]]), [1, 2])
    np.testing.assert_allclose(laws.smallest_circle([[0, 0], [1, 1], [3, 3]]), [1.5, 1.5])
    np.testing.assert_allclose(laws.smallest_circle([[0, 0], [4, 0]]), [2, 0])
    np.testing.assert_allclose(laws.smallest_circle([[0, 0], [1, 0], [0, 1], [1, 1]]), [0.5, 0.5])
    points = np.random.default_rng(3).normal(size=(9, 2))
    centre = laws.smallest_circle(points)
    radius = np.linalg.norm(points - centre, axis=1).max()
    for other in centre + 0.01 * np.random.default_rng(4).normal(size=(50, 2)):
        assert np.linalg.norm(points - other, axis=1).max() >= radius - 1e-12


def test_no_robot_goes_where_another_may_lose_it():
    # One at V ahead: to the middle at once, V/2 away, and no farther.
    np.testing.assert_allclose(laws.limited_visibility([[4.0, 0.0]], 4.0, 1.0, 1.0), [2.0, 0.0])
    # At V, and two behind at V: c = 0.
    step = laws.limited_visibility([[4.0, 0.0], [-4.0, 0.0]], 4.0, 1.0, 1.0)
    np.testing.assert_allclose(step, [0.0, 0.0], atol=1e-12)
    # c = (2, 0.5); within 2 of (2, 0) and of (0, 2) one may go t: t = e.h + sqrt(4 - |h|^2 + (e.h)^2).
    step = laws.limited_visibility([[4.0, 0.0], [0.0, 4.0]], 4.0, 1.0, 1.0)
    np.testing.assert_allclose(step, [2.0, 2.0])
    draw = np.random.default_rng(5)
    for _ in range(50):
        others = draw.uniform(-2.5, 2.5, (4, 2))
        new = laws.limited_visibility(others, 4.0, 1.0, 1.0)
        assert np.linalg.norm(new - 0.5 * others, axis=1).max() <= 2.0 + 1e-9
    assert not laws.limited_visibility(np.empty((0, 2)), 4.0, 1.0, 1.0).any()


def test_two_transducers_tell_distance_and_angle_of_a_wall():
    # A wall 1.5 m to the left of a robot that heads 0.1 rad towards it.
    angle, distance = 0.1, 1.5
    places = [(0.069, 0.136), (-0.157, 0.136)]
    ranges = [distance - x * np.sin(angle) - y * np.cos(angle) for x, y in places]
    found = laws.wall_beside(*((*place, r) for place, r in zip(places, ranges)))
    np.testing.assert_allclose(found, [distance, angle], atol=1e-12)
    # Along the wall lies 0.1 rad to the right of the heading.
    u = laws.along_wall(0.3, 0.0, angle)
    np.testing.assert_allclose(u, [0.3 * np.cos(0.1), -0.3 * np.sin(0.1)])
    np.testing.assert_allclose(laws.along_wall(0.0, 0.2, 0.5 * np.pi), [0.2, 0.0], atol=1e-12)


def test_ranges_of_a_convoy():
    np.testing.assert_allclose(laws.steady_ranges(0.3, 0.0, [0.2] * 3, 0.8, 0.5), [1.4, 1.4])
    # Circles: r_0 = 5; R^2 + (0.8 + 0.12 R)^2 = 25, so R = 4.8704, and 0.8 + 0.12 R = 1.3844.
    ranges = laws.steady_ranges(0.3, 0.06, [0.2, 0.2], 0.8, 0.5)
    radius = (ranges[0] - 0.8) / 0.12
    assert radius**2 + ranges[0] ** 2 == pytest.approx(25.0)
    assert ranges[0] == pytest.approx(1.376, abs=1e-3)
    assert laws.steady_ranges(0.1, 0.5, [0.2, 0.2], 0.8, 0.5) is None


@pytest.mark.parametrize(
    "name, robots, seconds",
    [
        ("limited_visibility", 9, 22.0),
        ("sensed_following", 3, 30.0),
        ("wall_following", 2, 38.0),
        pytest.param("sensed_following", 5, 60.0, marks=pytest.mark.release),
        pytest.param("wall_following", 4, 40.0, marks=pytest.mark.release),
    ],
)
def test_what_they_claim_is_so(name, robots, seconds, tmp_path):
    poses = shipped(name).poses[:robots].tolist()
    verdict = verdict_of(shipped(name, robots=robots, poses=poses, duration=seconds), tmp_path)
    assert verdict["outcome"] == "passed" and not failed(verdict)
    assert all(each["passed"] is not None for each in verdict["checks"])


def test_a_convoy_that_loses_sight_fails(tmp_path):
    short = {"neighbours": {"range": 1.0}}
    scenario = shipped("sensed_following", {"gain": 1.0}, duration=24.0)
    sensors = [scenario.to_dict()["sensors"][0], {"robots": 3, "mounts": short}]
    poses = scenario.to_dict()["poses"][:3]  # a convoy of five needs longer
    verdict = verdict_of(scenario.changed(robots=3, poses=poses, sensors=sensors), tmp_path)
    assert "worst range from the steady one at the end [m]" in failed(verdict)


def test_a_convoy_on_a_circle_has_as_long_as_its_slowest_errors_need():
    scenario = shipped("sensed_following", duration=20.0, record_rate=5.0)
    found = check(simulate(scenario).verdict, "worst range")
    assert found["passed"] is None and "wanted a run of" in found["note"]
    control = make_control(scenario)
    slowest = control._slowest(np.array([1.6, 1.3]))
    assert slowest == pytest.approx(0.5 * (1.0 - 0.8 / 1.3))  # across, to the nearest
    control.set_parameters({**control.parameters, "turn": 0.0})
    assert control._slowest(np.array([1.6, 1.3])) == 0.5


def seeing(**changes):
    """Return the scenario that ships with another sensor of the others."""
    mount = {"type": "range_bearing", "range": 4.0, "occlusion": False, "rate": 10, **changes}
    return shipped("limited_visibility", sensors=[{"mounts": {"neighbours": mount}}], duration=22.0)


def test_of_robots_that_see_less_far_than_they_think_no_theorem_speaks(tmp_path):
    verdict = verdict_of(seeing(range=2.6), tmp_path)
    seen = check(verdict, "all within the radius are seen")
    assert seen["measured"] == "does not hold" and seen["passed"] is None
    assert seen["note"] == "robot1 sees others up to 2.6 m, the radius is 4 m"
    assert verdict["outcome"] == "not_judged" and seen["name"] in verdict["reason"]
    # They do lose each other, which is measured all the same.
    extent = check(verdict, "extent of the team at the end [m]")
    assert extent["measured"] > 1.0 and extent["passed"] is None


@pytest.mark.parametrize(
    "changes, holds",
    [({}, True), ({"range": 5.0}, True), ({"range": 3.9}, False), ({"view": 3.0}, False)]
    + [({"occlusion": True}, False), ({"noise": {"bearing": {"dropout": 0.1}}}, False)],
)
def test_all_within_the_radius_have_to_be_seen(changes, holds):
    scenario = seeing(**changes)
    claims = make_control(scenario).claims(scenario.poses[:, :2])
    condition = {claim.name: claim for claim in claims}["all within the radius are seen"]
    assert condition.holds == holds and bool(condition.why) != holds


ROOM = [
    wall(str(k), a, b, 0.1, 0.5)
    for k, (a, b) in enumerate(
        [((0, 0), (4, 0)), ((4, 0), (4, 2)), ((4, 2), (0, 2)), ((0, 2), (0, 0)), ((2, 0), (2, 1.2))]
    )
]


def test_ways_go_round_walls():
    floor = floors.floor_of(ROOM, 0.2, 0.2)
    assert floor.free.shape == (20, 10) and 0.0 < floor.open.mean() < floor.free.mean() < 1.0
    begin, goal = floor.cell([0.9, 0.5]), floor.cell([3.1, 0.5])
    way = floors.ways(floor.open, floor.size, begin)
    # Over the wall's end at (2, 1.2): no shorter than two straight lines, no longer than the grid makes it.
    assert 2.0 * np.hypot(1.1, 0.7) < way[goal] < 1.2 * 2.0 * np.hypot(1.1, 0.9)
    # The way back is as long, each step down it is a step nearer.
    back = floors.ways(floor.open, floor.size, goal)
    assert back[begin] == pytest.approx(way[goal])
    assert floors.downhill(way, goal, 200) == begin
    closed = ROOM[:4] + [wall("to the end", (2, 0), (2, 2), 0.1, 0.5)]
    floor = floors.floor_of(closed, 0.2, 0.2)
    way = floors.beside(floors.ways(floor.open, floor.size, begin), floor.free, floor.size, 10)
    assert np.isinf(way[goal]) and np.isfinite(way[begin])


def test_a_scan_shows_the_cells_before_what_it_meets():
    floor = floors.floor_of(ROOM[:4] + [Cylinder("post", 3.0, 1.0, 0.2, 0.5)], 0.2, 0.2)
    places = np.zeros((181, 3))
    places[:, 2] = np.radians(np.arange(-90.0, 91.0))
    ranges = np.full(181, 1.5)
    ranges[85:96] = 0.8
    ranges[96:109] = np.nan
    scan = RangeReading(0.0, ranges, places, 5.0)
    seen = np.zeros(floor.free.shape, dtype=bool)
    free = np.flatnonzero(floor.free)
    seen.ravel()[floors.seen_by(floor, np.array([1.0, 1.0, 0.0]), scan, free)] = True

    def at(r, degrees):
        place = 1.0 + r * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
        return bool(seen[floor.cell(place)])

    assert at(0.6, 0.0) and not at(1.1, 0.0) and at(1.1, 30.0) and at(0.7, -60.0)
    assert not at(1.8, 20.0) and not at(0.6, 180.0) and not at(0.9, 12.0)


def corridor(duration):
    scenario = shipped("exploration", duration=duration)
    rooms = [o for o in scenario.to_dict()["obstacles"] if o["name"] in ("west", "room1", "room4")]
    for name, x in (("south", -1.2), ("north", 1.2)):
        rooms.append({"type": "wall", "name": name, "from": [-4.6, x], "to": [0.0, x]})
    rooms.append({"type": "wall", "name": "east", "from": [0.0, -1.2], "to": [0.0, 1.2]})
    return scenario.changed(obstacles=rooms)


def test_a_team_looks_at_a_whole_floor(tmp_path):
    verdict = verdict_of(corridor(20.0), tmp_path)
    assert verdict["outcome"] == "passed" and verdict["seconds_to_50_percent"] <= 20.0
    assert check(verdict, "share of the floor")["measured"] >= 0.99


def test_explorers_wait_for_lower_numbers_and_behind_those_who_wait_for_them():
    control = make_control(shipped("exploration"))
    hand = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 0.0]])  # robot 3 between 1 and 2

    def waits(*ways):
        return control._waits(hand, np.array(ways)).tolist()

    west, east, north = [-0.4, 0.0], [0.4, 0.0], [0.0, 0.4]
    assert waits(north, west, west) == [False, True, True]
    assert waits(north, west, north) == [False, False, False]
    assert waits(east, west, east) == [False, False, True]  # 3 for 2; none is lower than 1


@pytest.mark.parametrize(
    "poses, seconds",
    [
        ([[-4.55, 0.18, -0.53], [-6.02, 0.17, 1.29], [-3.19, 0.12, 2.4]], 10.0),
        ([[-4.42, -0.12, -0.92], [-6.38, 0.03, -1.47], [-2.99, -0.14, 0.25]], 12.0),
    ],
)
def test_explorers_that_want_through_one_door_make_room_and_do_not_touch(poses, seconds):
    verdict = simulate(shipped("exploration", duration=seconds).changed(poses=poses)).verdict
    assert verdict["min_distance"] > 0.65 and not failed(verdict)
    assert check(verdict, COMMANDS)["passed"]


@pytest.mark.parametrize("pose", [[4.11, -1.4, -2.62], [4.12, -1.27, -1.35]])
def test_an_explorer_whose_goal_lies_behind_it_turns_beside_a_wall_without_touching(pose):
    poses = [[-4.6, 0.0, 0.0], [-6.2, 0.0, 0.0], pose]
    verdict = simulate(shipped("exploration", duration=2.0).changed(poses=poses)).verdict
    assert not failed(verdict) and check(verdict, COMMANDS)["passed"]


def test_an_explorer_whose_goal_lies_behind_it_turns_beside_another_without_touching():
    poses = [[-5.47, -0.34, -0.32], [-6.12, 0.1, 1.96], [-0.84, 0.12, 0.0]]
    verdict = simulate(shipped("exploration", duration=2.0).changed(poses=poses)).verdict
    assert not failed(verdict) and check(verdict, COMMANDS)["passed"]


def test_what_was_seen_is_known_of_the_run_that_is_asked_for():
    experiment = Experiment(corridor(2.0))
    runs = [played(corridor(seconds))[0] for seconds in (1.0, 2.0)]
    found = [experiment.control.shares(run)[1] for run in (*runs, runs[1], runs[0])]
    assert len(found[0]) < len(found[1])
    assert found[2] is found[1] and found[3] is not found[0]
    np.testing.assert_array_equal(found[3], found[0])
    list(experiment.samples())
    assert isinstance(experiment.snapshot(), Copied)  # of a control that has looked at a run
    experiment.world.close()


def test_a_team_that_stands_has_not_seen_it(tmp_path, monkeypatch):
    law = "mrs_simulator.protocols.exploration.law.Exploration._towards"
    monkeypatch.setattr(law, lambda control, row, point: np.zeros(2))
    wrong = failed(verdict_of(corridor(18.0), tmp_path))
    assert wrong == ["share of the floor that is seen [-]", COMMANDS]
    early = check(verdict_of(corridor(2.0), tmp_path), "share of the floor")
    assert early["passed"] is None and "wanted a run of" in early["note"]


def test_a_team_that_is_still_on_its_way_has_not_missed_the_rest(monkeypatch):
    monkeypatch.setattr(Exploration, "_seconds", lambda control, run: 1.0)
    near = [{"mounts": {"laser": {"range": [0.1, 1.0]}}}]
    share = check(simulate(corridor(3.0).changed(sensors=near)).verdict, "share of the floor")
    assert share["passed"] is None and "still on their way" in share["note"]


@pytest.mark.parametrize("compiled", ["0", pytest.param("1", marks=pytest.mark.release)])
@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 7)])
def test_ways_are_the_shortest_by_free_steps_not_past_corners(shape, compiled, monkeypatch):
    if compiled == "1":
        pytest.importorskip("numba")
    monkeypatch.setenv(VARIABLE, compiled)
    random = np.random.default_rng(7)
    for _ in range(5):
        passable = random.uniform(size=shape) > 0.3
        begin = tuple(random.integers(0, shape).tolist())
        far = floors.ways(passable, 0.3, begin)
        known, passable[begin] = {begin: 0.0}, True
        changed = [begin]  # Bellman and Ford
        while changed:
            x, y = changed.pop(0)
            for dx, dy in floors.STEPS:
                to, sides = (x + dx, y + dy), ((x + dx, y), (x, y + dy))
                inside = all(0 <= k < count for k, count in zip(to, shape))
                length = known[x, y] + 0.3 * np.hypot(dx, dy)
                leads = inside and passable[to] and all(passable[each] for each in sides)
                if leads and length < known.get(to, np.inf):
                    known[to] = length
                    changed.append(to)
        wanted = np.full(shape, np.inf)
        for cell, length in known.items():
            wanted[cell] = length
        np.testing.assert_array_equal(far, wanted)


COMMANDS = "commands off the published law [-]"
SENSED = {
    "limited_visibility": {"neighbours": {"type": "range_bearing", "range": "4 m"}},
    "sensed_following": {"neighbours": {"type": "range_bearing", "range": "6 m"}},
}
BY_ROBOTS = {
    "noise": {"noise": {"range": {"stddev": 0.05, "bias": {"stddev": 0.1}, "bias_walk": 0.01}}},
    "losses": {"noise": {"bearing": {"stddev": 0.1, "dropout": 0.2, "quantum": 0.01}}},
    "latency": {"noise": {"range": {"latency": "250 ms"}}},
    "rate": {"rate": "2 Hz"},
    "bodies that hide others": {"occlusion": True, "place": [0.1, -0.1, 0.2]},
}


def off_the_law(out, name, **changes):
    """Return the error and the outcome of the check on commands of a few seconds of a scenario."""
    found = check(verdict_of(shipped(name, **{"duration": 2.0, **changes}), out), COMMANDS)
    return found["measured"], found["passed"]


@pytest.mark.parametrize("name", SENSED)
@pytest.mark.parametrize("what", BY_ROBOTS)
def test_commands_follow_from_what_others_were_seen_at(tmp_path, name, what):
    mount = {**SENSED[name]["neighbours"], **BY_ROBOTS[what]}
    error, passed = off_the_law(tmp_path, name, sensors=[{"mounts": {"neighbours": mount}}])
    assert passed and error < 1e-9


def test_commands_follow_from_what_sonars_should_have_read(tmp_path):
    for noise in ({}, {"stddev": 0.02, "dropout": 0.1}):
        sensors = [{"mounts": {"sonar": {"noise": noise}}}]
        error, passed = off_the_law(tmp_path, "wall_following", sensors=sensors)
        assert passed and error < 1e-9


def claims_of(name, mount, noise, **changes):
    """Return the claims by name of a scenario whose sensor ``mount`` has ``noise``."""
    sensors = [*mounted(name), {"mounts": {mount: {"noise": noise}}}]
    scenario = shipped(name, sensors=sensors, **changes)
    claims = make_control(scenario).claims(scenario.poses[:, :2])
    return {claim.name: claim for claim in claims}


def mounted(name):
    if name == "wall_following":
        return []
    view = {"type": "range_bearing", "range": 6.0, "view": 2.0944, "rate": 20.0}
    return [{"mounts": {"neighbours": view}}]


def test_tolerances_grow_with_the_noise_of_the_sensors():
    name = "decay rate of the distances [1/s]"
    fine, coarse = (
        claims_of("wall_following", "sonar", {"stddev": d})[name] for d in (0.29e-3, 5e-3)
    )
    # gain 0.2 at 10 Hz, transducers 0.069 m before and 0.157 m behind the centre, hand point at 0.2 m
    c = (0.2 * (0.069 - 0.2) - 0.3) / 0.226
    begun = 1.0 - np.array([0.3, -0.2, 0.1, -0.3]) - 1.0
    deviation = np.sqrt(0.04) * 5e-3 * np.hypot(0.2 - c, c) / np.linalg.norm(begun)
    assert coarse.tolerance == pytest.approx(0.02 * coarse.predicted + 3.0 * deviation, rel=1e-6)
    assert fine.tolerance < 0.03 * fine.predicted < coarse.tolerance
    name = "worst range from the steady one at the end [m]"
    noise = {"range": {"stddev": 0.05}}
    seen = claims_of("sensed_following", "neighbours", noise)[name]
    assert seen.tolerance == pytest.approx(0.03 + 3.0 * 0.05 * np.sqrt(0.5 * 0.5 * 0.05))


@pytest.mark.parametrize(
    "noise, holds",
    [({"stddev": 0.05}, True), ({"dropout": 0.1}, False), ({"bias": 0.01}, False)]
    + [({"latency": late}, late < 0.1) for late in (0.05, 0.2)],
)
def test_theory_knows_no_lost_biased_or_late_readings(noise, holds):
    condition = claims_of("wall_following", "sonar", noise)["readings off by chance alone"]
    assert condition.holds == holds


def test_robots_whose_commands_jump_with_noise_between_samples_are_not_said_to_disobey():
    (view,) = mounted("sensed_following")
    view["mounts"]["neighbours"]["noise"] = {"range": {"stddev": 0.05}}
    for rate, fitted in ((10.0, False), (20.0, True)):
        scenario = shipped("sensed_following", sensors=[view], record_rate=rate, duration=6.0)
        names = [check["name"] for check in simulate(scenario).verdict["checks"]]
        assert any(name.startswith("gain of wheels") for name in names) == fitted


def test_a_law_that_is_three_percent_too_fast_by_its_sonar_is_noticed(tmp_path, monkeypatch):
    right = laws.along_wall
    monkeypatch.setattr(laws, "along_wall", lambda v, w, a: right(v, 1.03 * w, a))
    error, passed = off_the_law(tmp_path, "wall_following")
    assert passed is False and 1e-3 < error < 0.05


def test_a_robot_that_goes_beyond_its_bound_is_noticed(tmp_path, monkeypatch):
    right = laws.limited_visibility
    poses = [[0.0, 0.0, 0.4], [-0.3, 0.0, 1.0], [3.4, 1.9, 0.0], [3.4, -1.9, 2.0]]
    changes = {"duration": 0.5, "parameters": {"gain": 10.0}, "poses": poses, "robots": 4}
    assert off_the_law(tmp_path, "limited_visibility", **changes)[1]
    monkeypatch.setattr(
        laws, "limited_visibility", lambda seen, V, *rest: right(seen, 2 * V, *rest)
    )
    assert off_the_law(tmp_path, "limited_visibility", **changes)[1] is False


def test_transducers_that_fire_in_turns_are_not_judged(tmp_path):
    found = off_the_law(tmp_path, "wall_following", sensors=[{"mounts": {"sonar": {"turns": 4}}}])
    assert found == (None, None)


def test_commands_of_exploration_follow_from_what_its_lasers_should_have_read(tmp_path):
    error, passed = off_the_law(tmp_path, "exploration", duration=1.5)
    assert passed and error < 1e-9


@pytest.mark.parametrize(
    "name, wrong",
    [
        ("_towards", lambda right: lambda self, *given: 1.03 * right(self, *given)),
        ("_waits", lambda right: lambda self, hand, u: np.zeros(len(hand), dtype=bool)),
    ],
)
def test_explorers_that_go_too_fast_or_do_not_wait_are_noticed(tmp_path, monkeypatch, name, wrong):
    monkeypatch.setattr(Exploration, name, wrong(getattr(Exploration, name)))
    assert off_the_law(tmp_path, "exploration", duration=1.0)[1] is False


def test_explorers_that_do_not_share_the_floor_are_noticed(tmp_path, monkeypatch):
    right = floors.beside
    monkeypatch.setattr(floors, "beside", lambda *given: np.round(right(*given)))
    assert off_the_law(tmp_path, "exploration", duration=1.0)[1] is False
