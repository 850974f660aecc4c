"""The safety filter: the nearest safe velocities, and robots that never touch."""

import numpy as np
import pytest

from mrs_simulator import PioneerControl, run_experiment
from mrs_simulator.control.safety import nearest_velocities as safety
from mrs_simulator.control.safety.bounds import Surroundings
from mrs_simulator.control.safety.nearest_velocities import margins, safe_velocities
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import played

PERIOD = 0.02


def test_what_is_safe_passes_unchanged():
    points = np.array([[0.0, 0.0], [5.0, 0.0]])
    wanted = np.array([[-1.0, 0.3], [1.0, 0.0]])
    np.testing.assert_array_equal(safe_velocities(wanted, points, 1.0, PERIOD), wanted)


def test_head_on_is_slowed_to_the_bound_by_half_each():
    points = np.array([[0.0, 0.0], [1.2, 0.0]])
    wanted = np.array([[1.0, 0.0], [-1.0, 0.0]])
    safe = safe_velocities(wanted, points, 1.0, PERIOD, gamma=1.0, swirl=0.0)
    # h = 0.44: 2 * 1.2 * (u_1 - u_2) <= 0.44^3, shared alike.
    approach = 0.44**3 / 2.4
    np.testing.assert_allclose(safe, [[0.5 * approach, 0.0], [-0.5 * approach, 0.0]], atol=1e-6)


def test_the_nearest_velocities_are_those_of_a_plain_solver():
    draw = np.random.default_rng(2)
    points = np.array([[0.0, 0.0], [1.1, 0.1], [0.4, 1.2]])
    wanted = draw.normal(0.0, 1.0, (3, 2)) - points
    safe = safe_velocities(wanted, points, 1.0, PERIOD, swirl=0.0)
    # Hildreth's method, one constraint after another until nothing changes.
    h, first, second = margins(points, 1.0)
    limit = np.minimum(h**3, h / PERIOD)
    rows = np.zeros((3, 6))
    for k, (i, j) in enumerate(zip(first, second)):
        rows[k, 2 * i : 2 * i + 2] = -2.0 * (points[i] - points[j])
        rows[k, 2 * j : 2 * j + 2] = 2.0 * (points[i] - points[j])
    force, plain = np.zeros(3), wanted.ravel().copy()
    for _ in range(5000):
        for k in range(3):
            change = max(-force[k], (rows[k] @ plain - limit[k]) / (rows[k] @ rows[k]))
            force[k] += change
            plain -= change * rows[k]
    np.testing.assert_allclose(safe.ravel(), plain, atol=1e-4)


@pytest.mark.parametrize(
    "n, apart, steps",
    [
        (2, 1.5, 400),
        (10, 1.5, 150),
        (50, 0.81, 15),
        pytest.param(10, 1.5, 400, marks=pytest.mark.release),
        pytest.param(50, 0.81, 40, marks=pytest.mark.release),
    ],
)
def test_points_sent_into_one_place_never_come_too_close(n, apart, steps):
    draw = np.random.default_rng(n)
    places = np.stack(np.meshgrid(np.arange(10.0), np.arange(10.0)), -1)
    points = apart * places.reshape(-1, 2)[:n]
    goal = points.mean(axis=0) + draw.normal(0.0, 0.1, 2)
    for _ in range(steps):
        points = points + PERIOD * safe_velocities(2.0 * (goal - points), points, 0.8, PERIOD)
        assert margins(points, 0.8)[0].min() >= -1e-12


@pytest.mark.parametrize("period", [PERIOD, 0.1])
def test_robots_that_stand_are_not_pushed_into_each_other(period):
    points = np.stack([0.95 * np.arange(5), np.zeros(5)], axis=1)
    wanted = np.zeros((5, 2))
    wanted[0, 0] = 1.2
    for _ in range(100):
        points = points + period * safe_velocities(wanted, points, 0.9, period)
        assert margins(points, 0.9)[0].min() >= -1e-12
    assert points[1, 0] > 0.951  # it is pushed


class Meet(PioneerControl):
    def pointMassLaw(self, hand):
        return 0.5 * (hand.mean(axis=0) - hand)


class Swap(PioneerControl):
    def pointMassLaw(self, hand):
        return self.goal - hand


def crossing(safety, fidelity="kinematic"):
    angle = 2.0 * np.pi * np.arange(6) / 6
    poses = np.stack([3.0 * np.cos(angle), 3.0 * np.sin(angle), angle + 2.0], axis=1)
    return scenario_from_dict(
        {
            "poses": poses.tolist(),
            "fidelity": fidelity,
            "limits": {"v_max": 0.75, "omega_max": 3.0},
            "duration": 8.0,
            "control": {"safety": safety},
        }
    )


@pytest.mark.parametrize("fidelity", ["point_mass", "kinematic", "dynamic"])
def test_robots_with_bodies_never_touch(tmp_path, fidelity):
    verdict = run_experiment(crossing(True, fidelity), str(tmp_path), Meet, formats=())
    checks = {check["name"]: check for check in verdict["checks"]}
    assert checks["least distance of two robots [m]"]["passed"], verdict
    assert checks["collisions"]["measured"] == 0
    assert verdict["min_distance"] < 2.0  # they did come close


def test_without_the_filter_they_do(tmp_path):
    verdict = run_experiment(crossing(False), str(tmp_path), Meet, formats=())
    assert not verdict["passed"] and verdict["checks"][-2]["measured"] > 0


def test_a_symmetric_crossing_does_not_deadlock():
    class Cross(Swap):
        goal = -np.array([[3.0, 0.0], [-3.0, 0.0]])

    scenario = crossing(True)
    scenario = scenario._replace(
        poses=np.array([[3.0, 0.0, np.pi], [-3.0, 0.0, 0.0]]),
        kinds=scenario.kinds[:2],
        duration=25.0,
    )
    end = played(scenario, Cross)[0].hand[-1]
    assert np.linalg.norm(end - Cross.goal, axis=1).max() < 0.3


def crowd(n, seed):
    """Return velocities, points and distances of n robots of two sizes in a place that they fill."""
    draw = np.random.default_rng(seed)
    side = int(np.ceil(np.sqrt(n)))
    points = 1.4 * np.stack([np.arange(n) // side, np.arange(n) % side], axis=1)
    points = points + draw.uniform(-0.2, 0.2, (n, 2))
    reach = np.where(np.arange(n) % 2, 0.3, 0.5)
    return draw.uniform(-0.4, 0.4, (n, 2)), points, reach[:, np.newaxis] + reach


@pytest.mark.parametrize("seed", range(5))
def test_pairs_that_are_left_out_would_change_nothing(seed, monkeypatch):
    wanted, points, distance = crowd(60, seed)
    brakes = safety.Brakes(np.full(60, 1.0 / 0.3), np.full(60, 0.3))
    terms = wanted, points, distance, 0.02
    given = safety.safe_velocities(*terms, brakes=brakes)
    within = safety._most_distant(
        safety.FASTER * np.linalg.norm(wanted, axis=1).max(), *terms[2:], 1.0, None, brakes
    )
    assert within < np.ptp(points)
    monkeypatch.setattr(safety, "_most_distant", lambda *terms: np.inf)
    np.testing.assert_array_equal(given, safety.safe_velocities(*terms, brakes=brakes))


def test_pairs_that_were_left_out_and_are_too_near_are_found(monkeypatch):
    monkeypatch.setattr(safety, "FASTER", 0.1)
    broken, breaks = [], safety._breaks
    monkeypatch.setattr(safety, "_breaks", lambda *a: broken.append(breaks(*a)) or broken[-1])
    for seed in range(5):
        wanted, points, distance = crowd(60, seed)
        brakes = safety.Brakes(np.full(60, 1.0 / 0.3), np.full(60, 0.3))
        found = []
        for distant in (lambda speed, *_: 0.7 if speed < 0.1 else 9.0, lambda *_: np.inf):
            monkeypatch.setattr(safety, "_most_distant", distant)
            found.append(safety.safe_velocities(wanted, points, distance, 0.02, brakes=brakes))
        np.testing.assert_array_equal(*found)
    assert broken == [True] * 5


@pytest.mark.parametrize("cap", [None, 0.3])
def test_newtons_method_and_gradients_find_the_same(cap, monkeypatch):
    wanted, points, distance = crowd(30, 1)
    speed = None if cap is None else np.full(30, cap)
    monkeypatch.setattr(safety, "same_bits", lambda *_: None)
    given = safety.safe_velocities(wanted, points, distance, 0.02, speed=speed)
    monkeypatch.setattr(safety, "_by_newton", lambda *terms: None)
    monkeypatch.setattr(safety, "SWEEPS", 4000)
    by_gradients = safety.safe_velocities(wanted, points, distance, 0.02, speed=speed)
    np.testing.assert_allclose(given, by_gradients, atol=1e-3)  # these stop a little outside
    assert not np.array_equal(given, wanted)


@pytest.mark.parametrize("dimension", [2, 3])
def test_elimination_and_conjugate_gradients_solve_the_same(dimension):
    draw = np.random.default_rng(2)
    points = draw.uniform(0.0, 9.0, (40, dimension))
    walls = Surroundings(arena=(-1.0, -1.0, 10.0, 10.0)).bounds(points, np.full(40, 0.4))
    rows = safety._joined(safety._pair_rows(points, 0.8, PERIOD, 1.0), walls, PERIOD)
    dual, free = safety._Dual(points, rows), np.zeros(points.size)
    pairs = len(rows.limit) - rows.alone
    _, single = np.unique(rows.first[pairs:], return_index=True)  # a wall of each robot
    for count in (1, 20, 30):
        own = np.sort(draw.choice(pairs, count, replace=False))
        own = np.concatenate([own, pairs + single[:count:3]])
        excess = draw.normal(0.0, 1.0, len(own))
        change, fallen = dual.eliminated(own, excess), dual.slope(own, free)
        np.testing.assert_allclose(fallen(change), excess, atol=1e-12)
        by_gradients = safety._by_conjugate_gradients(fallen, excess)
        np.testing.assert_allclose(change, by_gradients, atol=1e-9)
    dual.cap(np.ones(40))
    assert dual.eliminated(own, excess) is None


def test_rows_that_depend_on_each_other_are_not_eliminated():
    points = np.random.default_rng(2).uniform(0.0, 9.0, (8, 2))
    rows = safety._pair_rows(points, 0.8, PERIOD, 1.0)  # 28 of 16 coordinates
    dual = safety._Dual(points, rows)
    assert dual.eliminated(np.arange(28), np.ones(28)) is None
    assert dual.eliminated(np.arange(10), np.ones(10)) is not None


@pytest.mark.parametrize("caps", [None, np.full(9, 0.5)])
def test_the_slope_of_constraints_is_that_of_differences(caps):
    draw = np.random.default_rng(4)
    points = np.stack(np.meshgrid(np.arange(3.0), np.arange(3.0)), -1).reshape(-1, 2)
    walls = Surroundings(arena=(-0.5, -0.5, 2.5, 2.5)).bounds(points, np.full(9, 0.4))
    rows = safety._joined(safety._pair_rows(points, 0.8, PERIOD, 1.0), walls, PERIOD)
    dual = safety._Dual(draw.normal(0.0, 1.0, (9, 2)), rows, caps)
    change = draw.normal(0.0, 1.0, len(rows.limit))
    free, little = dual.free(0.0 * change), 1e-6 * change
    assert caps is None or dual.is_capped(free)
    fallen = dual.slope(np.arange(len(change)), free)(change)
    less, more = (dual.excess(dual.free(each)) for each in (-little, little))
    np.testing.assert_allclose(fallen, (less - more) / 2e-6, atol=1e-7)


def test_what_breaks_no_bound_is_not_solved_for(monkeypatch):
    points = np.array([[0.0, 0.0], [1.6, 0.0], [0.1, 4.0]])
    wanted = np.array([[0.25, 0.4], [-0.25, -0.4], [0.0, 0.3]])

    def passed():
        return safety.safe_velocities(wanted, points, 1.0, 0.05)

    monkeypatch.setattr(safety, "same_bits", lambda *_: None)
    solved = []
    nearest = safety._nearest
    monkeypatch.setattr(safety, "_nearest", lambda *a: solved.append(a) or nearest(*a))
    quick = passed()
    assert not solved
    monkeypatch.setattr(safety, "LEAST", -np.inf)
    assert passed().tobytes() == quick.tobytes() and solved
    assert (quick != wanted).any()  # they turn aside
