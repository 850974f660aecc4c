"""Steps from command to command in one compiled call, under laws that Python runs: with numpy's bits."""

import importlib
import pickle
import signal

import numpy as np
import pytest

from mrs_simulator import PioneerControl, make_twist
from mrs_simulator.core import compiling
from mrs_simulator.record.recording import Recorder
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run import stepping
from mrs_simulator.study.run.experiment import Experiment, LawFailed
from mrs_simulator.study.run.stepping import Stepping
from mrs_simulator.world.contact import bodies, collisions
from mrs_simulator.world.motion import commanded_steps
from mrs_simulator.world.motion.commanded_steps import (
    BY_STEP,
    CROWDED,
    DUE,
    ENOUGH,
    STALE,
)


class Walk(PioneerControl):
    """Points move at velocities that are drawn anew, and remember where they were."""

    SPEED = 1.0

    def start(self):
        self.draw, self.u, self.met = np.random.default_rng(0), None, []

    def pointMassLaw(self, hand):
        self.met.append((self.time, hand))
        if self.u is None or self.time % 1.0 < 0.3:
            self.u = self.draw.uniform(-self.SPEED, self.SPEED, hand.shape)
        return self.u


class Raises(Walk):
    def pointMassLaw(self, hand):
        if self.time > 0.7:
            raise ValueError("enough")
        return super().pointMassLaw(hand)


class Stops(Walk):
    def pointMassLaw(self, hand):
        if self.time > 0.7:
            signal.raise_signal(signal.SIGINT)
        return super().pointMassLaw(hand)


class Breaks(Walk):
    def pointMassLaw(self, hand):
        return super().pointMassLaw(hand) + (np.nan if self.time > 0.7 else 0.0)


class Hurries(Walk):
    def pointMassLaw(self, hand):
        return super().pointMassLaw(hand) * (3e12 if self.time > 0.7 else 1.0)


class Flees(Walk):
    def pointMassLaw(self, hand):
        return super().pointMassLaw(hand) * (0.9e12 if self.time > 0.7 else 1.0)


class Stands(Walk):
    SPEED = 0.0


class ByHook(PioneerControl):
    """Robots are told speeds that are drawn anew, and remember where they were."""

    LATE = 1.0  # [-] by which speeds are greater from 0.7 s on

    def start(self):
        self.draw, self.speeds, self.met = np.random.default_rng(0), None, []

    def calculateControlLaw(self, pos_map):
        self.met.append((self.time, np.array([pos_map[number] for number in self.numbers])))
        if self.speeds is None or self.time % 1.0 < 0.3:
            self.speeds = self.draw.uniform(-1.0, 1.0, (len(pos_map), 2)).tolist()
        late = self.LATE if self.time > 0.7 else 1.0
        return {i: make_twist(late * v, 2.0 * w) for i, (v, w) in zip(pos_map, self.speeds)}


class ByNeighbours(PioneerControl):
    """Points keep away from those whose data they receive, and remember where these were."""

    def start(self):
        self.met = []

    def neighbourLaw(self, robot, theta, neighbours):
        away = np.array([[other.x, other.y] for other in neighbours])
        self.met.append((self.time, np.append(away.ravel(), theta)))
        return np.sin(3.0 * self.time + robot) * away.sum(axis=0)


class RaisesByHook(ByHook):
    def calculateControlLaw(self, pos_map):
        twists = super().calculateControlLaw(pos_map)
        return {} if self.time > 0.7 else twists


class BreaksByHook(ByHook):
    LATE = np.nan


class HurriesByHook(ByHook):
    LATE = 3e12


def crowd(**changes):
    content = {
        "robots": 12,
        "poses": {"layout": "grid", "spacing": 0.7},
        "limits": "top",
        "duration": 2.0,
    }
    content.update(changes)
    return scenario_from_dict(content, "test")


@pytest.fixture(params=["loops", pytest.param("numba", marks=pytest.mark.release)])
def compiled(request, monkeypatch):
    """Return a function from which on steps are made by the loops, as Python runs them or compiled."""
    if request.param == "numba":
        pytest.importorskip("numba")
    by_loops = [commanded_steps.steps_between, commanded_steps.compiled_steps]
    monkeypatch.setattr(stepping, "same_bits", lambda *_, **__: None)
    monkeypatch.setattr(stepping, "is_kept", lambda step: True)  # whatever was compiled before

    def start():
        step, ends = by_loops[0] if request.param == "loops" else by_loops[1](), []

        def noted(*given):
            result = step(*given)
            ends.append(result[1])
            return result

        monkeypatch.setattr(stepping, "same_bits", lambda *_, **__: noted)
        return ends

    return start


def run(scenario, law, tmp_path):
    """Return all that a run under ``law`` tells, and what became of its experiment."""
    experiment, said = Experiment(scenario, law), None
    path = tmp_path / "run.csv"
    with Recorder(path, experiment.control.numbers, layout=experiment.layout) as file:
        try:
            counts = list(experiment.record(file))
        except (LawFailed, KeyboardInterrupt) as error:
            counts, said = None, repr(error)
    world, met = experiment.world, experiment.control.met
    motion = world.motion
    told = [path.read_bytes(), experiment.collisions, said, world.contacts.closest, experiment.step]
    told += [world.time, world.pose.tobytes(), world.twist.tobytes(), world.command.tobytes()]
    told += [motion._inner.tobytes(), list(motion.contacts()), world.commands.received.tolist()]
    told += [world.commands.commanded.tolist(), world.commands.refused.tolist()]
    told += [[(time, points.tobytes()) for time, points in met]]
    return told, counts, experiment


CASES = {
    "crowd": {},
    "of two kinds": {
        "model": ["pioneer3dx", "husky"] * 6,
        "poses": {"layout": "grid", "spacing": 1.0},
    },
    "apart": {"poses": {"layout": "grid", "spacing": 8.0}},
    "two": {"robots": 2, "poses": [[0.0, 0.0, 0.3], [0.72, 0.0, 2.0]], "duration": 8.0},
    "rates": {"control": {"rate": 12.5}, "record_rate": 5, "duration": 3.02},
    "rarely": {"control": {"rate": 5}, "record_rate": 12.5, "duration": 2.98},
    "unsaturated": {"control": {"saturation": "none"}},
    "as a team": {"control": {"saturation": "team"}},
    "without limits": {"limits": None},
}


@pytest.mark.parametrize("case", CASES)
def test_robots_go_from_command_to_command_as_step_by_step(case, compiled, tmp_path):
    wanted, each, by_step = run(crowd(**CASES[case]), Walk, tmp_path)
    ends = compiled()
    told, counts, experiment = run(crowd(**CASES[case]), Walk, tmp_path)
    assert told == wanted
    assert max(each) == 1 < max(counts) and sum(counts) == sum(each)
    assert bool(experiment.collisions) == (case != "apart")
    assert set(ends) <= {DUE, ENOUGH, STALE, BY_STEP, CROWDED}
    assert ends.count(BY_STEP) < 0.1 * by_step.step


HOOKED = [
    (ByHook, case) for case in ("crowd", "apart", "rates", "rarely", "unsaturated", "as a team")
]


@pytest.mark.parametrize("law, case", [*HOOKED, (ByNeighbours, "crowd")])
def test_laws_of_commands_go_from_command_to_command_as_step_by_step(law, case, compiled, tmp_path):
    given = crowd(**CASES[case], topology={"preset": "ring"})
    wanted, each, by_step = run(given, law, tmp_path)
    ends = compiled()
    told, counts, experiment = run(given, law, tmp_path)
    assert told == wanted
    assert max(each) == 1 < max(counts) and sum(counts) == sum(each)
    assert bool(experiment.collisions) == (case != "apart")
    assert DUE in ends and ends.count(BY_STEP) < 0.1 * by_step.step


POSTS = [{"type": "cylinder", "center": [x, 1.7], "radius": 0.2} for x in (-0.7, 0.7)]
SEEN = {
    "laser": {"type": "laser", "rays": 12, "rate": 10, "noise": {"stddev": "1 cm", "latency": 0.05}}
}
SEEN.update(
    imu={"type": "imu", "rate": 12.5},
    bumper={"type": "bumper", "rate": 50},
    battery={"type": "battery"},
)
AMONG = {
    "crowd": {},
    "apart": {"poses": {"layout": "grid", "spacing": 2.0}},
    "among posts": {"poses": {"layout": "grid", "spacing": 3.0}, "obstacles": POSTS},
    "round": {"model": "epuck", "poses": {"layout": "grid", "spacing": 0.5}},
    "rarely": {
        "control": {"rate": 5},
        "record_rate": 12.5,
        "poses": {"layout": "grid", "spacing": 2.0},
    },
}


def felt(control):
    """Remember what the robots of ``control`` read, where it is new."""
    if control.readings is not getattr(control, "felt", None):
        control.felt = control.readings
        known = [list(vars(control.readings[number]).values()) for number in control.numbers]
        control.met.append((control.time, np.array(pickle.dumps(known))))


class Feels(Walk):
    SENSORS = ("laser", "imu", "bumper")

    def pointMassLaw(self, hand):
        felt(self)
        scan = self.readings[1].laser
        return super().pointMassLaw(hand) * (0.2 if scan is None else min(1.0, scan.ranges.min()))


class FeelsByHook(ByHook):
    SENSORS = ("laser", "battery")

    def calculateControlLaw(self, pos_map):
        felt(self)
        return super().calculateControlLaw(pos_map)


@pytest.mark.parametrize("law", [Feels, FeelsByHook])
@pytest.mark.parametrize("case", AMONG)
def test_sensors_are_read_between_commands_as_step_by_step(law, case, compiled, tmp_path):
    given = crowd(**AMONG[case], sensors=[{"mounts": SEEN}], robots=6, duration=2.0)
    wanted, each, by_step = run(given, law, tmp_path)
    ends = compiled()
    told, counts, _ = run(given, law, tmp_path)
    assert told == wanted
    assert max(each) == 1 < max(counts) and DUE in ends


class Ahead(ByHook):
    def calculateControlLaw(self, pos_map):
        super().calculateControlLaw(pos_map)
        return [make_twist(0.4, 0.0) for _ in pos_map]


FACING = {"robots": 2, "poses": [[0.0, 0.0, 0.0], [2.0, 0.0, 3.1]], "duration": 9.0}
POST = [{"type": "cylinder", "center": [1.2, 0.0], "radius": 0.2}]


@pytest.mark.parametrize("changes", [{"obstacles": POST}, {"model": "epuck"}], ids=str)
def test_steps_in_which_other_bodies_are_near_are_the_worlds(changes, compiled, tmp_path):
    wanted, _, _ = run(crowd(**FACING, **changes), Ahead, tmp_path)
    ends = compiled()
    told, _, experiment = run(crowd(**FACING, **changes), Ahead, tmp_path)
    assert told == wanted and experiment.collisions
    assert DUE in ends and 0 < ends.count(BY_STEP) < 20


ACTING = {
    "filter": {"control": {"safety": True}},
    "slow filter": {"control": {"safety": {"speed": 0.2}, "saturation": "team"}},
    "filter among posts": {
        "control": {"safety": {"obstacles": True}},
        "poses": {"layout": "grid", "spacing": 3.0},
        "obstacles": POSTS,
    },
    "filter by sensors": {
        "control": {"safety": {"sensed": "laser"}},
        "sensors": [{"mounts": SEEN}],
    },
    "deadband": {"control": {"deadband": 0.4}, "poses": {"layout": "grid", "spacing": 0.7}},
}


def each_once(laws, cases, alone):
    """Return all pairs; before a release alone those of a law of ``alone`` and a case beside its own."""
    return [
        pytest.param(law, case, marks=pytest.mark.release)
        if law in alone and case not in alone[law]
        else (law, case)
        for law in laws
        for case in cases
    ]


FILTERED = {ByHook: ("filter", "deadband"), ByNeighbours: ("slow filter", "filter by sensors")}


@pytest.mark.parametrize("law, acts", each_once([Walk, ByHook, ByNeighbours], ACTING, FILTERED))
def test_commands_that_a_filter_changes_are_obeyed_as_step_by_step(law, acts, compiled, tmp_path):
    changes = {"poses": {"layout": "grid", "spacing": 1.2}, "topology": {"preset": "ring"}}
    given = crowd(**{**changes, **ACTING[acts]})
    wanted, each, by_step = run(given, law, tmp_path)
    ends = compiled()
    told, counts, _ = run(given, law, tmp_path)
    assert told == wanted
    assert max(each) == 1 < max(counts) and sum(counts) == sum(each)
    assert DUE in ends and ends.count(BY_STEP) < 0.1 * by_step.step
    free, _, _ = run(given._replace(control=crowd().control), law, tmp_path)
    assert free[0] != told[0]


ENDS = [Raises, Stops, Breaks, Hurries, Flees, Stands, RaisesByHook, BreaksByHook, HurriesByHook]


CHANGES = {
    "": {},
    "unsaturated": CASES["unsaturated"],
    "deadband": ACTING["deadband"],
}
# What raises is not asked how its commands are limited.
ALIKE = dict.fromkeys((Raises, Stops, RaisesByHook, Stands), ("",))


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("law, case", each_once(ENDS, CHANGES, ALIKE))
def test_a_law_ends_a_run_as_step_by_step(law, case, compiled, tmp_path):
    changes = CHANGES[case]
    wanted, _, _ = run(crowd(**changes), law, tmp_path)
    compiled()
    told, _, _ = run(crowd(**changes), law, tmp_path)
    assert told == wanted
    limited = law in (Hurries, Flees, HurriesByHook) and changes != CASES["unsaturated"]
    assert (wanted[2] is None) == (law is Stands or limited)


@pytest.mark.parametrize("skin, loose", [(0.06, 0.02), (0.02, 0.3)])
def test_pairs_are_listed_anew_as_robots_go(skin, loose, compiled, tmp_path, monkeypatch):
    monkeypatch.setattr(bodies, "LOOSE", loose)
    for module in (bodies, collisions, commanded_steps):
        monkeypatch.setattr(module, "SKIN", skin)
    given = crowd(robots=7, poses={"layout": "circle", "radius": 0.9}, duration=3.0)
    wanted, _, _ = run(given, Walk, tmp_path)
    ends = compiled()
    told, _, _ = run(given, Walk, tmp_path)
    assert told == wanted
    assert ends.count(STALE) > 50 and ends.count(CROWDED) + ends.count(BY_STEP) > 0


def pushed(experiment):
    """Return the samples of an experiment whose robots are pushed, and stepped back once, meanwhile."""
    samples, told, kept = experiment.samples(), [], None
    for count in range(2, 24):
        told.append(np.column_stack(next(samples)[1:]).tobytes())
        if count == 8:
            kept = experiment.snapshot()
        if count % 5 == 0:
            experiment.push(3, (0.3, -0.1))
        if count == 14:
            experiment.restore(kept)
            samples = experiment.samples()
    return told, experiment.collisions, experiment.world.time


def test_robots_that_are_pushed_between_samples_go_on_from_there(compiled):
    wanted = pushed(Experiment(crowd(), Walk))
    ends = compiled()
    assert pushed(Experiment(crowd(), Walk)) == wanted and DUE in ends


def watched(experiment):
    """Return what sensors read that are asked for in the midst of a run."""
    samples, read = experiment.samples(), []
    [next(samples) for _ in range(3)]
    for _ in range(8):
        experiment.watch({0: ("sonar",), 3: ("imu",)})
        next(samples)
        read.append(str(experiment.sensors.readings(experiment.world.time)))
    return read


def test_sensors_that_are_asked_for_in_the_midst_of_a_run_are_read(compiled):
    given = crowd(sensors=[{"mounts": {"imu": {"type": "imu", "rate": 12.5}}}])
    wanted = watched(Experiment(given, Walk))
    ends = compiled()
    assert watched(Experiment(given, Walk)) == wanted and DUE in ends
    assert len(set(wanted)) > 3 and "imu" in wanted[-1]


@pytest.mark.parametrize("apart, touch", [(0.7, True), (8.0, False)])
def test_crowds_that_touch_for_long_are_stepped_so_by_themselves(apart, touch, monkeypatch):
    asked = []
    monkeypatch.setattr(stepping, "same_bits", lambda _, size: asked.append(size))
    given = crowd(poses={"layout": "grid", "spacing": apart}, duration=1.0)
    for _ in Experiment(given, Walk).samples():
        pass
    assert (5 in asked) == touch and set(asked) <= {1.25, 5}


@pytest.mark.parametrize("is_kept", [True, False])
def test_robots_apart_are_stepped_so_where_that_need_not_be_compiled(is_kept, monkeypatch):
    made, looks, step = [], [], commanded_steps.steps_between
    monkeypatch.delenv("MRS_SIMULATOR_COMPILED", raising=False)
    monkeypatch.setattr(
        stepping, "same_bits", lambda *_, **__: lambda *g: made.append(g) or step(*g)
    )
    monkeypatch.setattr(stepping, "is_kept", lambda _: looks.append(1) or is_kept)
    given = crowd(poses={"layout": "grid", "spacing": 8.0}, duration=0.2)
    for _ in Experiment(given, ByHook).samples():
        pass
    assert bool(made) == is_kept and len(looks) == 1


def test_code_is_kept_until_its_source_changes(tmp_path, monkeypatch):
    pytest.importorskip("numba")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    source, text = tmp_path / "kept_doubled.py", "def doubled(x):\n    return 2 * x\n"
    source.write_text(text)

    def made():
        module = importlib.import_module("kept_doubled")
        return compiling.jit(cache=True)(importlib.reload(module).doubled)

    first = made()
    assert not compiling.is_kept(first)
    assert first(2) == 4 and compiling.is_kept(made())
    source.write_text(text + "# changed\n")
    assert not compiling.is_kept(made()) and not compiling.is_kept(compiling.jit()(made().py_func))


class Filtered(Walk):
    def commands(self, *known):
        return 0.5 * super().commands(*known)


@pytest.mark.parametrize(
    "law, changes",
    [
        (Filtered, {}),
        (Walk, {"requirements": {"near": "speed < 90 m/s"}}),
        (Walk, {"model": "robotino3"}),
        (Walk, {"robots": 1}),
        (Walk, {"odometry": "wheel"}),
    ],
)
def test_what_else_acts_goes_step_by_step(law, changes):
    assert Stepping.fits(Experiment(crowd(), Walk))
    assert not Stepping.fits(Experiment(crowd(**changes), law))
