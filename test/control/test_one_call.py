"""The safety filter of unicycles in one call: the same bits as step by step."""

import numpy as np
import pytest

from mrs_simulator import PioneerControl
from mrs_simulator.control.safety import (
    compiled_passing,
    deadlock_detector,
    nearest_velocities,
    one_call,
)
from mrs_simulator.control.safety.bounds import Surroundings
from mrs_simulator.control.safety.braking_certificate import WayOut
from mrs_simulator.control.twist_message import make_twist
from mrs_simulator.core import compiling
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import Experiment, LawFailed
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.compiled_courses import roll
from mrs_simulator.vehicles.courses import columns_of, instants_of


def start(n, spacing):
    """Return points (n, 2) [m] of a ring and angles (n,) [rad] about its middle."""
    angle = 2.0 * np.pi * np.arange(n) / n
    return spacing * n / 6.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1), angle


class Across(PioneerControl):
    """Wants the other side of the ring."""

    def pointMassLaw(self, hand):
        return -0.5 * (hand + start(len(hand), 1.2)[0])


class Outwards(PioneerControl):
    """Goes on into the walls left and right."""

    def pointMassLaw(self, hand):
        return 0.5 * np.sign(start(len(hand), 1.2)[0]) * (1.0, 0.0)


class Ahead(PioneerControl):
    """Goes on into the middle, by Twists."""

    def calculateControlLaw(self, positions):
        return {number: make_twist(0.3, 0.05 * number) for number in positions}


# The law, scenario keys and the filter's, of 6 robots by default.
CASES = {
    "alike": (Across, {}, True),
    "of two sizes": (Across, {"model": ["pioneer3dx", "husky"] * 3}, True),
    "capped": (Across, {}, {"speed": 0.2}),
    "near walls": (Across, {"duration": 3.0}, {"arena": [-1.7, -1.7, 1.7, 1.7]}),
    "between far walls": (Across, {}, {"arena": [-9.0, -9.0, 9.0, 9.0]}),
    "by Twists": (Ahead, {}, True),
    "capped and apart": (Outwards, {}, {"speed": 0.2}),
    "slowed down together": (Across, {"control": {"saturation": "team"}}, True),
    "without limits": (Across, {"control": {"saturation": "none"}, "duration": 3.0}, True),
    "held by walls": (Outwards, {}, {"arena": [-1.9, -1.9, 1.9, 1.9]}),
}


def experiment_of(law, changes, safety):
    """Return the ``Experiment`` of robots in a ring that head for its middle."""
    points, angle = start(6, 1.2)
    content = {"robots": 6, "model": "pioneer3dx", "duration": 4.0, "limits": "firmware", **changes}
    content["poses"] = np.column_stack([points, angle + np.pi]).tolist()
    content["control"] = {"rate": 10.0, "safety": safety, **changes.get("control", {})}
    return Experiment(scenario_from_dict(content), law)


def run(case, loop, monkeypatch):
    """Return the bytes of each sample's poses and commands and who was held still, and how often the
    ``loop``, if any, found a way out and how often it left that open."""
    found, ends = [], []

    def counted(*given):
        ends.append(loop(*given))
        return ends[-1]

    monkeypatch.setattr(one_call, "same_bits", lambda *_: loop and counted)
    monkeypatch.setattr(deadlock_detector, "PATIENCE", 0.0)
    experiment = experiment_of(*case)
    try:
        for _, pose, command in experiment.samples():
            held = experiment.control.safety_filter.deadlock
            found.append((np.array(pose).tobytes(), np.array(command).tobytes(), held))
    finally:
        experiment.world.close()
    said = [end[0] for end in ends]
    return found, said.count(compiled_passing.FREE), said.count(compiled_passing.STAND)


@pytest.mark.parametrize("name", CASES)
def test_one_call_gives_the_same_bits(name, monkeypatch):
    steps, _, _ = run(CASES[name], None, monkeypatch)
    whole, free, stand = run(CASES[name], compiled_passing.pass_all, monkeypatch)
    assert whole == steps
    assert free and (stand > 0) == (name in ("near walls", "held by walls"))
    assert any(held for _, _, held in steps) or name not in ("alike", "of two sizes")


def test_pairs_that_were_left_out_and_are_too_near_are_found(monkeypatch):
    broken, breaks = [], compiled_passing.breaks
    monkeypatch.setattr(
        compiled_passing, "breaks", lambda *a: broken.append(breaks(*a)) or broken[-1]
    )
    for module in (nearest_velocities, compiled_passing):
        monkeypatch.setattr(module, "FASTER", 0.1)
        monkeypatch.setattr(module, "most_distant", lambda speed, *_: 0.9 + 3.0 * speed)
    steps, _, _ = run(CASES["alike"], None, monkeypatch)
    assert run(CASES["alike"], compiled_passing.pass_all, monkeypatch)[0] == steps
    assert True in broken and False in broken


def test_commands_that_leave_no_way_out_are_slowed_down_to_the_same_bits(monkeypatch):
    n, period, slowed, near = 6, 0.2, set(), []
    nobody = (*np.empty((2, 0), dtype=int), 0.0)  # of points that are closer than 0 m

    def rolled(*given):
        # Courses that are not computed again are those that would be.
        roll(*given)
        whole = [np.empty_like(each) for each in given[-1]]
        roll(*given[:-2], np.ones(n, dtype=bool), whole)
        for kept, new in zip(given[-1][:2], whole):
            assert kept[near].tobytes() == new[near].tobytes()

    monkeypatch.setattr(compiled_passing, "roll", rolled)
    team = Team(("pioneer3dx",) * n)
    limits = team.groups[0].limits
    limits.acceleration[0] *= 0.1  # slowed down it stands sooner, and all are looked at more finely
    way_out = WayOut(team, team.reach, period, "kinematic")
    top, rates = np.ascontiguousarray(limits.top), np.ascontiguousarray(limits.acceleration)
    times = (period, columns_of(team.axes), *instants_of(period))
    for seed in range(10):
        draw = np.random.default_rng(seed)
        pose = np.column_stack([0.9 * draw.uniform(-1.0, 1.0, (n, 2)), draw.uniform(-3, 3, n)])
        pose[:, :2] += 0.8 * start(n, 1.2)[0]
        inner = draw.uniform(-1.0, 1.0, (n, 2)) * top
        command, speeds = draw.uniform(-1.0, 1.0, (n, 2)) * top, np.abs(inner[:, 0])
        way_out.note(inner, command, speeds, 0.0)
        wanted = way_out.certified(command, pose, np.ones(n), 0.0, Surroundings())
        given, columns = np.ascontiguousarray(pose.T), command.T.copy()
        robots = speeds, team.speeds[:, 0], period, *way_out.columns[:2]
        ways = compiled_passing.braking_ways(columns, *robots)
        pairs = compiled_passing.meeting(given, team.reach, ways, 0.0, nobody)
        states, near[:] = (inner, top, rates), np.unique(pairs)
        compiled_passing.let(columns, given, states, team.reach, times, *pairs)
        assert columns.T.tobytes() == wanted.tobytes(), seed
        slowed.update(np.round(wanted[:, 0] / command[:, 0], 6).tolist())
    assert slowed >= {1.0, 0.5, 0.0}


def test_a_law_that_gives_no_number_is_named_as_step_by_step(monkeypatch):
    class Lost(Across):
        def pointMassLaw(self, hand):
            wanted = super().pointMassLaw(hand)
            wanted[2] = np.nan if self.time > 0.55 else 0.0
            return wanted

    texts = []
    for loop in (None, compiled_passing.pass_all):
        monkeypatch.setattr(one_call, "same_bits", lambda *_, loop=loop: loop)
        experiment = experiment_of(Lost, {}, True)
        try:
            with pytest.raises(LawFailed) as failed:
                list(experiment.samples())
        finally:
            experiment.world.close()
        texts.append(str(failed.value))
    assert texts[0] == texts[1] and "0.6" in texts[0] and "robot 3" in texts[0]


def test_a_class_that_limits_commands_by_itself_is_asked(monkeypatch):
    class Slow(Across):
        def saturated(self, command, scope):
            return 0.5 * super().saturated(command, scope)

    case = Slow, {"duration": 2.0}, True
    steps, _, _ = run(case, None, monkeypatch)
    assert run(case, compiled_passing.pass_all, monkeypatch)[0] == steps


def test_no_pair_is_left_out_that_might_touch():
    n, period = 8, 0.2
    team, nobody = Team(("pioneer3dx",) * n), (*np.empty((2, 0), dtype=int), 0.0)
    way_out, limits = WayOut(team, team.reach, period, "kinematic"), team.groups[0].limits
    times, left_out, slowed = (period, columns_of(team.axes), *instants_of(period)), 0, 0
    for seed in range(
        34, 46
    ):  # among which are some that miss a pair if any part of the bound is left out
        draw = np.random.default_rng(seed)
        side = draw.uniform(0.8, 2.5) * np.sqrt(n) / 2.0
        pose = np.stack([*draw.uniform(-side, side, (n, 2)).T, draw.uniform(-3.0, 3.0, n)])
        sizes = [1.0, 0.1, 0.0], (n, 2), True, [0.6, 0.2, 0.2]
        share = draw.choice(*sizes)
        inner = draw.uniform(-1.0, 1.0, (n, 2)) * limits.top * share
        command = draw.uniform(-1.0, 1.0, (n, 2)) * limits.top * draw.choice(*sizes)
        found, states = np.stack([command.T, command.T]), (inner, limits.top, limits.acceleration)
        given = np.abs(inner[:, 0]), team.speeds[:, 0], period, *way_out.columns[:2]
        ways = compiled_passing.braking_ways(found[0], *given)
        every = compiled_passing.meeting(pose, team.reach, ways, 0.0, nobody)
        spread = compiled_passing.spreads(found[0], states, team.reach, times)
        turned = np.cos(pose[2]), np.sin(pose[2])
        some = compiled_passing.approaching(pose, *turned, spread, *every)
        for columns, pairs in zip(found, (every, some)):
            compiled_passing.let(columns, pose, states, team.reach, times, *pairs)
        assert found[0].tobytes() == found[1].tobytes(), seed
        left_out += len(every[0]) - len(some[0])
        slowed += not np.array_equal(found[0], command.T)
    assert left_out > 10 and slowed > 5


@pytest.mark.release  # compiling takes long
@pytest.mark.parametrize("name", CASES)
def test_so_it_does_compiled(name, monkeypatch):
    pytest.importorskip("numba")
    steps, _, _ = run(CASES[name], None, monkeypatch)
    assert run(CASES[name], compiled_passing.compiled_passing(), monkeypatch)[0] == steps


OTHERS = {  # for what the call does not do
    "one kind that is no unicycle": ({"model": "robotino3"}, True),
    "two drives": ({"model": ["pioneer3dx", "robotino3"] * 3}, True),
    "points": ({"fidelity": "point_mass"}, True),
    "an obstacle that moves": (
        {
            "obstacles": [{"type": "cylinder", "name": "cart", "center": [5.0, 5.0], "radius": 0.2,
                           "track": {"to": [[6.0, 5.0]], "speed": 0.2}}],
        },
        {"obstacles": True},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", OTHERS)
def test_others_are_filtered_step_by_step(name, monkeypatch):
    def refused(*_):
        raise AssertionError("not for these")

    monkeypatch.setattr(one_call, "same_bits", lambda *_: refused)
    changes, safety = OTHERS[name]
    experiment = experiment_of(Across, dict(changes, duration=0.4), safety)
    try:
        assert len(list(experiment.samples())) == 5
    finally:
        experiment.world.close()


def test_it_is_compiled_once_that_pays_and_its_parts_are_not(monkeypatch):
    monkeypatch.delenv(compiling.VARIABLE, raising=False)
    monkeypatch.setattr(compiling, "_asked", {})
    monkeypatch.setattr(one_call, "WORTH", 20 * (one_call.FIXED + 6))
    calls = []

    def loop(*given):
        calls.append(given)
        return compiled_passing.pass_all(*given)

    monkeypatch.setattr(one_call, "compiled_passing", lambda: loop)
    monkeypatch.setattr(compiling, "_is_loaded", lambda: False)
    experiment = experiment_of(Across, {"duration": 3.0}, True)
    try:
        assert len(list(experiment.samples())) == 31
    finally:
        experiment.world.close()
    # Commands after the first 20 are made by it; what it is made of was not even asked for.
    assert len(calls) in (10, 11)
    assert all(
        each.__name__ == "<lambda>" for each in compiling._asked if "filter" in each.__module__
    )


def test_who_is_held_still_is_noted_as_by_numpy(monkeypatch):
    draw, since = np.random.default_rng(1), np.full(4, np.nan)
    detector = deadlock_detector.DeadlockDetector(4)
    for time in (0.5, 1.0, 1.5, 2.0, 0.0, 0.5, 1.0):  # it goes back: another run
        held = draw.uniform(size=4) < 0.7
        monkeypatch.setattr(deadlock_detector, "held_still", lambda *_, held=held: held)
        detector.note(time, None, None, None, None)
        compiled_passing.note_held(held, since, time)
        np.testing.assert_array_equal(since, detector.since)
    assert np.isfinite(since).any() and np.isnan(since).any()
