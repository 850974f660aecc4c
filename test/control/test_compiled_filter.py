"""The safety filter by compiled loops: the same bits as by numpy."""

import numpy as np
import pytest

from mrs_simulator import PioneerControl
from mrs_simulator.control.safety import (
    compiled_filter,
    compiled_passing,
    nearest_velocities,
    one_call,
)
from mrs_simulator.control.safety.bounds import Surroundings
from mrs_simulator.control.safety.nearest_velocities import Brakes, safe_velocities
from mrs_simulator.control.stopping import Stopping
from mrs_simulator.nodes.control.law_client import LawService
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.compile_ahead import compile_ahead
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.vehicles import Team, compiled_courses, courses

PERIOD = 0.05


def choose(monkeypatch, compiled, filter_loops, course_loops):
    """Let the filter and courses be computed by these loops if ``compiled``, else by numpy.

    One after the other, not all in one call.
    """
    monkeypatch.setattr(one_call, "same_bits", lambda *_: None)
    for module, loops in ((nearest_velocities, filter_loops), (courses, course_loops)):
        chosen = loops if compiled else None
        monkeypatch.setattr(module, "same_bits", lambda *_, chosen=chosen: chosen)


def crowd(n, seed, dimension):
    """Return velocities, points and distances of n robots of two sizes in a place that they fill."""
    draw = np.random.default_rng(seed)
    side = int(np.ceil(np.sqrt(n)))
    points = np.zeros((n, dimension))
    points[:, :2] = 1.2 * np.stack([np.arange(n) // side, np.arange(n) % side], axis=1)
    points = points + draw.uniform(-0.3, 0.3, points.shape)
    reach = np.where(np.arange(n) % 2, 0.3, 0.5)
    return draw.uniform(-0.4, 0.4, points.shape), points, reach[:, np.newaxis] + reach


CASES = {
    "plain": (2, {}),
    "brakes": (2, {"brakes": Brakes(np.full(9, 3.0), np.full(9, 0.3))}),
    "caps": (2, {"speed": np.full(9, 0.3)}),
    "in space": (3, {"squash": np.array([1.0, 1.0, 0.4]), "speed": np.full(9, 0.3)}),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("walls", [False, True])
def test_the_loops_give_the_same_bits(name, walls, monkeypatch):
    (dimension, more), solved = CASES[name], 0
    for seed in range(4):
        wanted, points, distance = crowd(9, seed, dimension)
        arena = Surroundings(arena=(-0.6, -0.6, 3.0, 3.0)) if walls else Surroundings()
        given = {"bounds": arena.bounds(points, np.full(9, 0.5)), **more}
        found = []
        for loops in (None, compiled_filter.plain_loops()):
            monkeypatch.setattr(nearest_velocities, "same_bits", lambda *_, loops=loops: loops)
            found.append(safe_velocities(wanted, points, distance, PERIOD, **given))
        assert found[0].tobytes() == found[1].tobytes(), seed
        solved += not np.array_equal(found[0], wanted)
    assert solved


def ring(model, n):
    """Return the scenario of n robots that cross a ring, and their law."""
    angle = 2.0 * np.pi * np.arange(n) / n
    points = 0.25 * n * np.stack([np.cos(angle), np.sin(angle)], axis=1)

    class Cross(PioneerControl):
        def pointMassLaw(self, hand):
            return -0.5 * (points + hand)

    content = {"robots": n, "model": model, "duration": 8.0, "limits": "firmware"}
    content["poses"] = np.column_stack([points, angle + np.pi]).tolist()
    content["control"] = {"rate": 10.0, "safety": True}
    return scenario_from_dict(content), Cross


def run(scenario, law):
    """Return the bytes of all poses and commands of a run."""
    experiment, found = Experiment(scenario, law), []
    try:
        for _, pose, command in experiment.samples():
            found.append(np.array(pose).tobytes() + np.array(command).tobytes())
    finally:
        experiment.world.close()
    return found


@pytest.mark.release  # compiling takes long
@pytest.mark.parametrize(
    "model, n", [("pioneer3dx", 12), ("robotino3", 8), (["pioneer3dx", "robotino3"], 6)]
)
def test_whole_runs_have_the_same_bits(model, n, monkeypatch):
    pytest.importorskip("numba")
    scenario, law = ring(model * (n // 2) if isinstance(model, list) else [model] * n, n)
    loops = compiled_filter.compiled_loops(), compiled_courses.compiled_courses()
    found = []
    for compiled in (False, True):
        choose(monkeypatch, compiled, *loops)
        found.append(run(scenario, law))
    assert found[0] == found[1]


def test_courses_have_the_same_bits_by_python(monkeypatch):
    scenario, law = ring(["pioneer3dx"] * 4, 4)
    scenario, found = scenario._replace(duration=2.0), []
    for compiled in (False, True):
        choose(
            monkeypatch, compiled, compiled_filter.plain_loops(), compiled_courses.plain_courses()
        )
        found.append(run(scenario, law))
    assert found[0] == found[1]


@pytest.mark.parametrize("speed", [None, 0.3])
def test_a_crowd_that_newtons_method_does_not_find_is_solved_as_exactly(speed, monkeypatch):
    # All want the middle: more pairs touch than hold.
    draw = np.random.default_rng(3)
    points = draw.uniform(-2.2, 2.2, (26, 2))
    rows = nearest_velocities._pair_rows(points, 0.5, PERIOD, 1.0)
    wanted, caps = -points, None if speed is None else np.full(26, speed)
    kept, begun = rows.part(rows.limit > 0.0), []
    newton = nearest_velocities._by_newton
    monkeypatch.setattr(
        nearest_velocities, "_by_newton", lambda *a: begun.append(newton(*a)) or begun[-1]
    )
    velocity = nearest_velocities._nearest(wanted, kept, caps)
    assert any(found is None for found in begun) and begun[-1] is not None
    assert (kept.pressure(velocity) - kept.limit).max() < 1e-8


def test_rows_that_contradict_each_other_are_given_up_at_once():
    # Six robots in the plane cannot close up fifteen gaps as fast as one likes.
    draw = np.random.default_rng(1)
    points, excess = draw.uniform(0.0, 3.0, (6, 2)), draw.uniform(0.0, 1.0, 15)
    rows = nearest_velocities._pair_rows(points, 0.9, PERIOD, 1.0)
    dual, free = nearest_velocities._Dual(np.zeros((6, 2)), rows), np.zeros(12)
    limits = 0.0, *(getattr(nearest_velocities, n) for n in ("RESIDUAL", "ASTRAY", "ELIMINATED"))
    columns, still = (*rows[:2], np.ascontiguousarray(rows.of_second.T), 0), np.zeros((2, 6))
    for count in (5, 15):
        active, own = np.arange(count), excess[:count]
        found = nearest_velocities._solved(dual, active, free, own)
        assert (found is None) == (count == 15)
        given = active, still, np.empty(0), own, limits
        looped, solved = compiled_filter.solved(columns, *given)
        assert solved == (count == 5)
        assert found is None or found.tobytes() == looped.tobytes()


@pytest.mark.release  # compiling takes long
def test_the_filter_is_compiled_ahead():
    pytest.importorskip("numba")
    assert compile_ahead(["formation_safely", "sensed_crossing"]) == ["formation_safely"]
    loops = *compiled_filter.compiled_loops(), *compiled_courses.compiled_courses()
    assert all(loop.signatures for loop in (*loops, compiled_passing.compiled_passing()))


def test_robots_that_wait_for_commands_are_not_kept_waiting_by_compilation(monkeypatch):
    def load():
        raise RuntimeError("takes seconds")

    monkeypatch.setenv("MRS_SIMULATOR_COMPILED", "1")
    monkeypatch.setattr(one_call, "compiled_passing", load)
    scenario, law = ring(["pioneer3dx"] * 2, 2)
    service = LawService(law)
    service.make(scenario)
    assert service.commands(scenario.starts, 0.0).shape == (2, 2)
    with pytest.raises(RuntimeError, match="takes seconds"):  # as where nobody waits
        service._control.commands(scenario.starts, 0.0)


def test_nor_is_who_foresees_whether_robots_still_stop(monkeypatch):
    def load():
        raise RuntimeError("takes seconds")

    monkeypatch.setenv("MRS_SIMULATOR_COMPILED", "1")
    monkeypatch.setattr(courses, "compiled_courses", load)
    stopping, pose = Stopping(Team(("pioneer3dx",) * 2), 0.2), np.zeros((2, 3))
    (course,) = stopping.courses(np.full((2, 2), 0.1), pose, 0.0)
    assert course.speed.shape == (2,)
    with pytest.raises(RuntimeError, match="takes seconds"):
        stopping._courses.course([np.zeros((2, 2))], pose, np.zeros(2), np.zeros((2, 2)), 0.2)
