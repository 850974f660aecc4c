"""Several steps in one compiled call: the same trajectories, contacts and errors as step by step."""

import functools
import os
import re

import numpy as np
import pytest

from mrs_simulator import PioneerControl, load_scenario
from mrs_simulator.control.array_law import array_law
from mrs_simulator.core import (
    compiled_neighbours,
    compiled_terms,
    compiling,
    edge_terms,
)
from mrs_simulator.core.fields import Parameter
from mrs_simulator.core.graphs import Topology
from mrs_simulator.protocols import HOMES
from mrs_simulator.protocols.exploration import compiled_ways
from mrs_simulator.protocols.formation.law import Formation
from mrs_simulator.protocols.loading import load_protocol
from mrs_simulator.record.recording import Recorder
from mrs_simulator.scenario.incidents import Event
from mrs_simulator.scenario.requirements import Requirement
from mrs_simulator.scenario.scenario import Control, Scenario, scenario_from_dict
from mrs_simulator.scenario.search import Range, Search
from mrs_simulator.scenario.surroundings.environment import Environment
from mrs_simulator.scenario.surroundings.moving_obstacles import Track
from mrs_simulator.scenario.surroundings.obstacles import Cylinder
from mrs_simulator.scenario.team.estimates import Estimates
from mrs_simulator.scenario.team.mismatch import Mismatch
from mrs_simulator.scenario.team.odometry_errors import OdometryErrors
from mrs_simulator.sensors import compiled_rays
from mrs_simulator.study.run.compile_ahead import compile_ahead, compile_loops
from mrs_simulator.study.run.compile_ahead import main as compile_main
from mrs_simulator.study.run.experiment import Experiment, LawFailed
from mrs_simulator.vehicles.drives import compiled_flight, quadrotor_forces
from mrs_simulator.world.contact import bodies, collisions, compiled_contacts, contacts
from mrs_simulator.world.incidents.faults import Faults
from mrs_simulator.world.motion import (
    commanded_steps,
    compiled_rolling,
    crowd_steps,
    fused_stepping,
    kinematic,
    planar,
    rolling_steps,
    stretches,
)
from mrs_simulator.world.motion import compiled as compiled_motion
from mrs_simulator.world.part import Part
from mrs_simulator.world.world import World

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
ROUNDING = 1e-9  # [m, rad, m/s]


class Gather(PioneerControl):
    PARAMETERS = (Parameter("gain", 0.5, "1/s"),)

    @array_law
    def pointMassLaw(hand, gain, first, second):
        u = np.zeros_like(hand)
        for edge in range(len(first)):
            u[first[edge]] += gain * (hand[second[edge]] - hand[first[edge]])
        return u


class Breaking(PioneerControl):
    @array_law
    def pointMassLaw(hand):
        return np.where(hand[:, :1] > 0.5, np.nan, 1.0) * np.ones((len(hand), 2))


class Raising(PioneerControl):
    @array_law
    def pointMassLaw(hand):
        if hand[0, 0] > 0.5:
            raise ValueError("too far")
        return np.ones((len(hand), 2))


class Narrowing(PioneerControl):
    @array_law
    def pointMassLaw(hand):
        return np.ones((len(hand), 1 if hand[0, 0] > 0.5 else 2))


class Averaging(PioneerControl):
    @array_law
    def pointMassLaw(hand):
        return hand.mean(axis=0) - hand


def halved(u, times):
    return halved(0.5 * u, times - 1) if times else u


class Recursive(PioneerControl):
    @array_law
    def pointMassLaw(hand):
        return halved(hand, 3)


class Shuttle(PioneerControl):
    @array_law
    def pointMassLaw(hand):
        return np.where(hand > 1.0, -0.5, 0.5) * np.array([1.0, 0.0])


class Turned(Formation):
    def pointMassLaw(self, hand):
        return -super().pointMassLaw(hand)


class Filtered(Formation):
    def commands(self, *known):
        return 0.5 * super().commands(*known)


def scenario(**changes):
    content = {
        "poses": {"layout": "circle", "radius": 3.0},
        "robots": 5,
        "topology": {"preset": "cycle"},
        "duration": 6.0,
        "control": {"rate": 10},
    }
    content.update(changes)
    return scenario_from_dict(content, "test")


def shipped(name, duration=10.0):
    return load_scenario(os.path.join(ROOT, "scenarios", name + ".yaml")).changed(duration=duration)


ROLLING = {"fidelity": "dynamic", "engine": "planar"}


@pytest.fixture()
def compiled(monkeypatch):
    """Let stretches be made, by Python as it stands: what numba compiles is the same code."""

    def start():
        monkeypatch.setattr(compiling, "_chosen", lambda: "1")
        # Only the stretches are on trial.
        monkeypatch.setattr(edge_terms, "compiling", type("no", (), {"is_wanted": lambda: False}))
        for module in (kinematic, bodies, contacts, collisions, planar, quadrotor_forces):
            monkeypatch.setattr(module, "same_bits", lambda *_, **__: None)

    function = kernel_of(lambda kernel: kernel)
    monkeypatch.setattr(fused_stepping, "compiled_stretch", function)
    return start


def kernel_of(compile_):
    return lambda law, loops: compiled_terms.kernel(law, loops, compile_, compile_)


def recorded(scenario, protocol=None):
    """Return samples (m, n, 5), collisions, and how often the world made a step of its own."""
    experiment, own = Experiment(scenario, protocol), []
    motion = experiment.world.motion
    advance = motion.advance
    motion.advance = lambda command: own.append(1) or advance(command)
    rows = [np.column_stack(told[1:]) for told in experiment.samples()]
    return np.array(rows), experiment.collisions, len(own), experiment.world


def compare(start, scenario, protocol=None):
    by_step = recorded(scenario, protocol)
    start()
    fused = recorded(scenario, protocol)
    assert fused[0].shape == by_step[0].shape
    np.testing.assert_allclose(fused[0], by_step[0], rtol=0.0, atol=ROUNDING)
    assert len(fused[1]) == len(by_step[1])
    assert fused[3].time == by_step[3].time and fused[3].commands.commanded.all()
    np.testing.assert_allclose(fused[3].twist, by_step[3].twist, rtol=0.0, atol=ROUNDING)
    np.testing.assert_array_equal(fused[3].commands.received, by_step[3].commands.received)
    return by_step[2], fused[2]


SHIPPED = ["paper", "consensus", "discrete_consensus", "containment", "rendezvous"]
SHIPPED += [
    "cyclic_pursuit",
    "displacement_formation",
    "distance_formation",
    "bearing_formation",
    "bearing_leaders",
]


def test_the_page_names_all_shipped_laws_that_are_compiled():
    with open(os.path.join(ROOT, "docs", "benchmarks.md"), encoding="utf-8") as file:
        (told,) = (line for line in file if "| compiled: each is one sum over edges" in line)
    laws = {name: load_protocol(name) for name in HOMES}
    forms = {name for name, law in laws.items() if hasattr(law.pointMassLaw, "form")}
    assert set(re.findall("`([a-z_]+)`", told)) == forms
    assert {shipped(name).control.protocol for name in SHIPPED} == forms


@pytest.mark.parametrize("name", SHIPPED)
def test_fused_steps_of_shipped_laws_lead_to_where_steps_lead(name, compiled):
    given = shipped(name, 4.0).changed(fidelity="kinematic", limits="top")
    steps, own = compare(compiled, given)
    assert own < 0.3 * steps


@pytest.mark.parametrize("name", SHIPPED)
def test_fused_steps_of_points_lead_to_where_steps_lead(name, compiled):
    given = shipped(name, 1.5).changed(fidelity="point_mass")
    steps, own = compare(compiled, given)
    assert steps == 1.5 / given.step and own == 0


@pytest.mark.parametrize("rates", [(50, 10), (10, 10), (12.5, 50), (12.5, 5)])
def test_steps_of_points_are_fused_whatever_the_rates(rates, compiled):
    control, run = {"rate": rates[0]}, {"record_rate": rates[1], "duration": 0.9}
    assert (
        compare(compiled, scenario(fidelity="point_mass", control=control, **run), Gather)[1] == 0
    )


@pytest.mark.parametrize("name", SHIPPED)
def test_fused_steps_of_omnidirectional_bases_lead_to_where_steps_lead(name, compiled):
    robots = {"fidelity": "kinematic", "model": "robotino3"}
    steps, own = compare(compiled, shipped(name, 2.0).changed(limits="top", **robots))
    assert own < 0.3 * steps


@pytest.mark.parametrize("saturation", ["none", "robot", "team"])
@pytest.mark.parametrize("kinds", [["robotino3"] * 5, ["robotino3", "youbot", "youbot"] * 2])
@pytest.mark.parametrize("limits", ["firmware", None])
def test_omnidirectional_bases_keep_to_rims_and_ramps(saturation, kinds, limits, compiled):
    given = scenario(model=kinds, robots=len(kinds), limits=limits, duration=3.0)
    control = given.control._replace(rate=12.5, saturation=saturation)
    steps, own = compare(compiled, given._replace(control=control), Gather)
    assert own < steps


def test_omnidirectional_bases_touch_as_they_do_step_by_step(compiled):
    given = scenario(model="robotino3", poses={"layout": "circle", "radius": 0.5}, duration=3.0)
    steps, own = compare(compiled, given, Gather)
    assert 10 < own < steps


def test_bases_that_turn_go_step_by_step():
    world = World(("robotino3",), [[0.0, 0.0, 0.0]])
    world.set_commands([0], np.array([[0.1, 0.0, 0.3]]))
    assert world.can_fuse(1)
    given = (5, 1, 1, 1), stretches.sliding_stretch, np.empty((5, 6, 1)), 0.05, 0
    assert world.fuse_steps(*given) == (0, 0, stretches.NEAR)


@pytest.mark.parametrize("saturation", ["none", "robot", "team"])
@pytest.mark.parametrize("rates", [(50, 10), (10, 10), (12.5, 50), (12.5, 5)])
def test_steps_of_a_users_law_are_fused_whatever_the_rates(saturation, rates, compiled):
    control = {"rate": rates[0], "saturation": saturation}
    limits = "firmware" if saturation == "robot" else "top"
    given = scenario(control=control, record_rate=rates[1], duration=0.9, limits=limits)
    steps, own = compare(compiled, given, Gather)
    assert own < steps


def test_robots_touch_as_they_do_step_by_step(compiled):
    given = scenario(poses={"layout": "circle", "radius": 1.0}, duration=8.0)
    steps, own = compare(compiled, given, Gather)
    assert 10 < own < steps


class Rising(PioneerControl):
    """Robots go up at ``climb`` [m/s], or down where that is negative, some of them faster."""

    DIMENSIONS, PARAMETERS = (3,), (Parameter("climb", 0.5, "m/s"),)

    @array_law
    def pointMassLaw(hand, climb):
        u = np.zeros_like(hand)
        for row in range(len(hand)):
            u[row, 0] = -0.3 * hand[row, 0]
            u[row, 2] = climb * (1.0 + row)
        return u

    @classmethod
    def at(cls, climb):
        """Return the law with another default."""
        return type("Other", (cls,), {"PARAMETERS": (Parameter("climb", climb, "m/s"),)})


def aloft(**changes):
    """Return a scenario of quadrotors with forces, some of which come near to the ground or to others."""
    poses = [[3.0, 0.0, 2.0], [-3.0, 1.0, -1.0], [0.0, -2.5, 3.0]]
    given = {"poses": poses, "robots": 3, "model": "crazyflie2", "altitude": 1.0}
    given.update(fidelity="dynamic", limits="top", duration=1.5, topology={"preset": "cycle"})
    given.update(changes)
    return scenario(**given)


@pytest.mark.parametrize(
    "rates, saturation",
    [
        ((50, 10), "none"),
        ((12.5, 5), "robot"),
        ((50, 10), "team"),
        pytest.param((12.5, 5), "none", marks=pytest.mark.release),
        pytest.param((50, 10), "robot", marks=pytest.mark.release),
        pytest.param((12.5, 5), "team", marks=pytest.mark.release),
    ],
)
def test_fused_steps_of_quadrotors_lead_to_where_steps_lead(rates, saturation, compiled):
    control = {"rate": rates[0], "saturation": saturation}
    wind = {"wind": {"velocity": [1.0, -0.5]}}
    given = aloft(control=control, record_rate=rates[1], environment=wind, duration=0.7)
    steps, own = compare(compiled, given, Gather)
    assert steps == 35 and own == 0


def test_steps_of_quadrotors_in_space_are_fused(compiled):
    given = shipped("crazyflies_cube", 0.6).changed(fidelity="dynamic", limits="top")
    steps, own = compare(compiled, given)
    assert steps == 12 and own < 0.2 * steps


def test_quadrotors_touch_obstacles_and_each_other_as_they_do_step_by_step(compiled):
    poses = [[0.15, 0.0, 2.0], [-0.15, 0.0, -1.0], [0.0, -0.9, 3.0]]
    post = {"type": "cylinder", "name": "post", "center": [0.0, -0.7], "radius": 0.1}
    given = aloft(poses=poses, obstacles=[post], topology={"preset": "complete"}, duration=1.0)
    steps, own = compare(compiled, given, Gather)
    assert 5 < own < steps


def test_quadrotors_come_down_as_they_do_step_by_step(compiled):
    given = aloft(control={"dimension": 3}, altitude=0.4)
    steps, own = compare(compiled, given, Rising.at(-0.3))
    assert 5 < own < steps


@pytest.mark.parametrize("climb", [-1.0, 40.0], ids=["hard landing", "climb"])
def test_incidents_of_quadrotors_are_those_of_steps(climb, compiled, monkeypatch):
    monkeypatch.setattr(quadrotor_forces, "AT_LIMIT", 0.7)
    told, given = [], aloft(control={"dimension": 3, "saturation": "none"}, limits=None)
    for _ in range(2):
        experiment = Experiment(given, Rising.at(climb))
        own, advance = [], experiment.world.motion.advance
        experiment.world.motion.advance = lambda each, go=advance, own=own: own.append(1) or go(
            each
        )
        rows = [np.column_stack(each[1:]) for each in experiment.samples()]
        told.append((rows, experiment.incidents, experiment.world.z, len(own)))
        compiled()
    np.testing.assert_allclose(*(each[0] for each in told), rtol=0.0, atol=ROUNDING)
    np.testing.assert_allclose(*(each[2] for each in told), rtol=0.0, atol=ROUNDING)
    assert told[0][1] == told[1][1] and 0 < told[1][3] < told[0][3]


@pytest.mark.parametrize(
    "changes",
    [
        {"environment": {"wind": {"velocity": [1.0, 0.0], "gusts": 0.5}}},
        {"events": [{"at": 0.5, "robot": 1, "event": "motors_off"}]},
        {"fidelity": "kinematic"},
        {
            "model": ["crazyflie2", "crazyflie2", "pioneer3dx"],
            "altitude": [1.0, 1.0, 0.0],
        },
    ],
    ids=["gusts", "faults", "without forces", "with others"],
)
def test_quadrotors_out_of_the_ordinary_go_step_by_step(changes):
    assert Experiment(aloft(), Gather)._is_compilable()
    assert not Experiment(aloft(**changes), Gather)._is_compilable()


@pytest.mark.parametrize(
    "rates, limits",
    [
        ((50, 10), "firmware"),
        ((12.5, 50), "top"),
        ((12.5, 5), "firmware"),
        pytest.param((50, 10), "top", marks=pytest.mark.release),
        pytest.param((12.5, 50), "firmware", marks=pytest.mark.release),
        pytest.param((12.5, 5), "top", marks=pytest.mark.release),
    ],
)
def test_steps_of_wheels_with_forces_are_fused_whatever_the_rates(rates, limits, compiled):
    control = {"rate": rates[0], "saturation": "team" if limits == "top" else "robot"}
    given = scenario(control=control, record_rate=rates[1], duration=0.9, limits=limits, **ROLLING)
    assert compare(compiled, given, Gather)[1] == 0


def test_wheels_with_forces_meet_as_they_do_step_by_step(compiled):
    poses = [[0.0, 0.0, 0.3], [3.0, 0.1, 2.9]]
    given = dict(ROLLING, poses=poses, robots=2, topology={"preset": "complete"})
    steps, own = compare(compiled, scenario(duration=3.0, limits="top", **given), Gather)
    assert 20 < own < steps - 10  # in the solver some of the time


def test_wheels_with_forces_tip_as_they_do_step_by_step(compiled):
    given = dict(ROLLING, poses=[[0.0, 0.0, 0.0], [0.0, 9.0, 0.0]], robots=2, limits="none")
    steps, own = compare(compiled, scenario(duration=3.0, **given), Shuttle)
    assert 20 < own < steps - 100  # in the solver where they turn back


@pytest.mark.parametrize("more", [{"model": "husky"}, {"model": ["pioneer3dx", "youbot"] * 2}])
def test_who_is_pushed_by_wheel_forces_goes_step_by_step(more):
    world = World.from_scenario(scenario(**dict(ROLLING, robots=4), **more))
    assert not world.can_fuse(1)
    world.close()


@pytest.mark.parametrize("law", ["Breaking", "Raising", "Narrowing"])
@pytest.mark.parametrize("fidelity", ["kinematic", "point_mass"])
def test_a_law_that_breaks_fails_as_it_does_step_by_step(fidelity, law, compiled):
    poses, said = [[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]], []
    given = scenario(poses=poses, robots=2, fidelity=fidelity)
    for _ in range(2):
        with pytest.raises(LawFailed) as error:
            recorded(given, globals()[law])
        said.append(str(error.value))
        compiled()
    assert said[0] == said[1] and "not finite" not in said[0]
    assert {"Breaking": "nan", "Raising": "too far", "Narrowing": "(2, 1)"}[law] in said[0]
    assert not said[0].startswith("at 0.000 s")


@pytest.mark.parametrize(
    "law, why",
    [
        # In words of the version of numba, which takes seconds to find them.
        pytest.param("Averaging", ".*mean", marks=pytest.mark.release),
        ("Recursive", "a function calls itself"),
    ],
)
def test_a_law_that_cannot_be_compiled_is_refused_by_name(law, why, compiled, monkeypatch):
    pytest.importorskip("numba")
    jit = compiling.jit()
    function = functools.partial(compiled_terms.kernel, compile_=jit, compile_kept=jit)
    monkeypatch.setattr(fused_stepping, "compiled_stretch", function)
    compiled()
    monkeypatch.setattr(fused_stepping, "compiled_stretch", function)
    wanted = "at 0.000 s the law failed: ControlError: {}: numba cannot compile pointMassLaw: {}"
    with pytest.raises(LawFailed, match=wanted.format(law, why)):
        recorded(scenario(), globals()[law])


def test_of_itself_such_a_law_goes_step_by_step(compiled, monkeypatch):
    def refuse(law, loops):
        raise compiling.NotInstalled("numba cannot be imported: too old")

    law, given = globals()["Averaging"], scenario(duration=1.0)
    plain = list(Experiment(given, law).samples())
    compiled()
    monkeypatch.setattr(compiling, "_chosen", lambda: None)
    monkeypatch.setattr(compiling, "seconds_saved", lambda *_: 1.0)
    monkeypatch.setattr(fused_stepping, "compiled_stretch", refuse)
    experiment = Experiment(given, law)
    assert experiment._can_fuse()
    for one, other in zip(plain, experiment.samples()):
        assert all(map(np.array_equal, one, other))
    assert experiment.step == 50
    (said,) = [each for each in experiment.warnings if "numba" in each]
    assert said.endswith("too old; robots go step by step")


def test_what_ships_is_compiled_ahead(compiled):
    compiled()
    ahead = ["paper", "reynolds", "paper_dynamic"]
    assert compile_ahead(ahead) == ["paper", "paper_dynamic"]  # by the fast engine


@pytest.mark.release  # compiling takes long
def test_contacts_and_forces_are_compiled_ahead():
    pytest.importorskip("numba")
    compile_loops()
    loops = [
        compiled_neighbours.compiled_pairs(),
        compiled_motion.compiled_feel(),
        compiled_contacts.compiled_push(),
        compiled_contacts.compiled_note(),
        crowd_steps.compiled_step(),
        commanded_steps.compiled_steps(),
        *compiled_rays.compiled_loops(),
        rolling_steps.compiled_roll_step(),
        *compiled_rolling.kernels(),
        *compiled_flight.compiled_loops(),
        compiled_ways.compiled_lengths(),
    ]
    assert [loop.__name__ for loop in loops if not loop.signatures] == []


@pytest.mark.parametrize(
    "seconds, robots, is_long", [(110.0, 3, False), (250.0, 3, True), (110.0, 90, True)]
)
def test_of_wheels_with_forces_shorter_runs_are_long(seconds, robots, is_long, monkeypatch):
    monkeypatch.delenv(compiling.VARIABLE, raising=False)
    monkeypatch.setattr(compiling, "find_spec", lambda name: True)
    poses = {"layout": "grid", "spacing": 3.0}
    experiment = Experiment(scenario(duration=seconds, poses=poses, robots=robots, **ROLLING))
    assert experiment._can_fuse() == is_long
    experiment.world.close()


def test_the_command_prints_for_what_it_compiled(compiled, capsys):
    compiled()
    compile_main(["paper", "reynolds"])
    assert capsys.readouterr().out == "compiled: paper\n"


@pytest.mark.parametrize(
    "spec, environment, said",
    [(None, "1", "numba is not installed, wanted"), (True, "0", "COMPILED=0: nothing is compiled")],
)
def test_the_command_says_why_it_compiles_nothing(spec, environment, said, monkeypatch, capsys):
    monkeypatch.setattr("mrs_simulator.study.run.compile_ahead.find_spec", lambda name: spec)
    monkeypatch.setenv(compiling.VARIABLE, environment)
    with pytest.raises(SystemExit) as ended:
        compile_main(["paper"])
    assert ended.value.code == 2 and said in capsys.readouterr().err


def test_long_runs_are_compiled_by_themselves(monkeypatch, capsys):
    monkeypatch.delenv(compiling.VARIABLE, raising=False)
    monkeypatch.setattr(compiling, "find_spec", lambda name: True)
    long = scenario(duration=3600.0)
    assert Experiment(long)._can_fuse()
    assert not Experiment(scenario(duration=110.0))._can_fuse()
    monkeypatch.setenv(compiling.VARIABLE, "0")
    assert not Experiment(long)._can_fuse()
    monkeypatch.delenv(compiling.VARIABLE)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(compiling, "find_spec", lambda name: None)
    assert not Experiment(long)._can_fuse()
    said = capsys.readouterr().err
    assert said.startswith("experiment: numba is not installed: this run takes some 5 s longer")


@pytest.mark.parametrize(
    ("protocol", "changes"),
    [
        (Turned, {}),
        (Filtered, {}),
        (Formation, {"odometry": "wheel"}),
        (Formation, {"fidelity": "dynamic"}),
        (Formation, {"fidelity": "point_mass", "model": "robotino3"}),
        (Formation, {"model": "f1tenth"}),
        (Formation, {"model": ["robotino3"] * 2 + ["pioneer3dx"] * 3}),
        (Formation, {"links": {"delay": 0.1}}),
        (Formation, {"control": {"rate": 1}, "cmd_vel_timeout": 0.5}),
        (Formation, {"control": {"safety": {"arena": [-9, -9, 9, 9]}}}),
    ],
)
def test_what_more_decides_on_goes_step_by_step(protocol, changes, compiled):
    compiled()
    assert not Experiment(scenario(**changes), protocol)._can_fuse()


def test_a_part_of_the_world_that_says_nothing_of_fusing_is_asked_at_each_step():
    world = World(("pioneer3dx",), [[0.0, 0.0, 0.0]])
    assert world.can_fuse(5)
    world.parts.append(Part())
    assert not world.can_fuse(5)


FUSED, STEP = True, False
TRACK = Track(((9.0, -9.0),), 0.1)
# An example of each field that a scenario has, and whether steps are fused then: a new one belongs here.
FIELDS = {
    "poses": (np.array([[0.0, 3.0 * k, 0.1] for k in range(5)]), FUSED),
    "kinds": (("robotino3",) * 5, FUSED),
    "title": ("other", FUSED),
    "fidelity": ("point_mass", FUSED),
    "limits": ("top", FUSED),
    "odometry": ("wheel", STEP),
    "control": (Control(safety=True, protocol="consensus"), STEP),
    "topology": (Topology(5, [(1, 2)]), FUSED),
    "links": (scenario(links={"delay": 0.1}).links, STEP),
    "mismatch": (Mismatch(speed=(0.9,)), STEP),
    "obstacles": ((Cylinder("post", 9.0, 9.0, 0.2, 1.0, track=TRACK),), STEP),
    "environment": (Environment(current=(0.1, 0.0)), FUSED),  # of the water
    "duration": (2.0, FUSED),
    "seed": (3, FUSED),
    "speed": (0.0, FUSED),
    "record_rate": (5.0, FUSED),
    "odometry_rate": (10.0, STEP),
    "cmd_vel_timeout": (0.05, STEP),
    "step": (0.01, FUSED),
    "path": ("other.yaml", FUSED),
    "own_kinds": ({}, FUSED),
    "altitude": (None, FUSED),  # of what flies, a kind
    "sensors": ((), FUSED),  # they act where they are read
    "odometry_errors": (OdometryErrors(factor=0.1), FUSED),  # of wheels, where these are told
    "map": (None, FUSED),  # boxes
    "estimates": (Estimates("odometry"), STEP),
    "events": ((Event(1.0, 1, "motors_off"),), STEP),
    "takeoff": (False, FUSED),  # of what flies
    "load": (None, FUSED),  # of arms, a kind
    "record": ((), FUSED),
    "engine": ("planar", FUSED),  # of motion with forces
    "requirements": ((Requirement("apart", "always(distance > 0.1)"),), STEP),
    "search": (Search(ranges=(Range("seed", 0, 9, True),)), FUSED),  # of many runs
}


def test_every_field_of_a_scenario_says_whether_steps_are_fused():
    assert set(FIELDS) == set(Scenario._fields)


@pytest.mark.parametrize("field", [field for field in FIELDS if field != "events"])
def test_steps_are_fused_where_nothing_but_the_law_moves_them(field, compiled):
    value, is_fused = FIELDS[field]
    compiled()
    given = scenario()._replace(**{field: value})
    assert Experiment(given)._can_fuse() == is_fused


@pytest.mark.parametrize("sensors", [("sonar",), ()])
def test_steps_of_robots_that_are_sensed_are_not_fused(sensors, compiled):
    compiled()
    experiment = Experiment(scenario())
    experiment.sensors.activate({0: sensors})
    assert experiment._can_fuse() != bool(sensors)


def test_a_run_of_fused_steps_goes_on_alike_from_a_snapshot(compiled):
    compiled()
    experiment = Experiment(shipped("paper", 3.0))
    samples = experiment.samples()
    [next(samples) for _ in range(5)]
    kept = experiment.snapshot()
    told = [np.column_stack(each[1:]).tobytes() for each in experiment.samples()]
    experiment.restore(kept)
    assert told == [np.column_stack(each[1:]).tobytes() for each in experiment.samples()]
    assert len(told) == 26 and experiment.world.clock.steps == 150


NEAR_TO = {"type": "cylinder", "center": [2.4, 0.8], "radius": 0.2}
TEAMS = {
    "apart": {},
    "touching": {"poses": {"layout": "circle", "radius": 0.6}},
    "at an obstacle": {"obstacles": [NEAR_TO], "duration": 5.0},
    "bases": {"model": "robotino3"},
    "points": {"fidelity": "point_mass"},
    "rates": {"control": {"rate": 12.5}, "record_rate": 5, "duration": 2.9},
    "wheels": dict(ROLLING, control={"rate": 12.5}, record_rate=5, duration=1.5),
    "wheels touching": dict(
        ROLLING, poses=[[0, 0, 0.3], [3, 0.1, 2.9]], robots=2, limits="top", duration=3.0
    ),
    "quadrotors": {
        "robots": 3,
        "model": "crazyflie2",
        "fidelity": "dynamic",
        "altitude": 2.0,
        "duration": 0.8,
    },
}


@pytest.mark.parametrize("team", TEAMS)
def test_how_many_samples_a_call_makes_changes_no_bit(team, compiled):
    compiled()
    told = []
    for most in (1, 6):
        experiment = Experiment(scenario(**{"duration": 3.0, **TEAMS[team]}), Gather)
        experiment.begin()
        blocks = list(zip(*experiment._fused_steps(most)))
        told.append([np.concatenate(each) for each in blocks] + [experiment.collisions])
    assert (
        len(told[0][0]) == experiment.scenario.duration * experiment.scenario.record_rate // 1 + 1
    )
    assert all(np.array_equal(*each) for each in zip(*told))
    assert bool(told[0][3]) == ("touching" in team or team == "at an obstacle")


@pytest.mark.parametrize("law", [Gather, Raising, Breaking])
def test_a_file_of_blocks_is_that_of_samples(law, compiled, tmp_path):
    compiled()
    poses = [[0.2, 2.0 * k, 0.1] for k in range(5)]
    given, said = scenario(poses=poses, duration=3.0), []
    for path in (tmp_path / "blocks.csv", tmp_path / "samples.csv"):
        experiment = Experiment(given, law)
        with Recorder(path, experiment.control.numbers, layout=experiment.layout, kept=31) as file:
            try:
                if path.stem == "blocks":
                    assert max(experiment.record(file)) > 10
                else:
                    for stamp, *each in experiment.samples():
                        file.sample(stamp, experiment.state(*each))
            except LawFailed as error:
                said.append(str(error))
        said.append(path.read_bytes())
        said.append(file.kept.table[: len(said[-1].splitlines()) // 5].tobytes())
    half = len(said) // 2
    assert said[:half] == said[half:] and half == 2 + (law is not Gather)


def test_robots_that_go_far_are_listed_anew(compiled):
    compiled()
    poses = [[-4.0, 0.0, 0.0], [4.0, 0.3, np.pi]]
    given = scenario(
        poses=poses, robots=2, topology={"preset": "cycle"}, duration=16.0, limits="top"
    )
    experiment = Experiment(given, Gather)
    experiment.begin()
    assert max(len(stamps) for stamps, *_ in experiment._fused_steps(most=160)) > 10
    assert 5.0 < experiment.collisions[0].time < 5.5


def test_what_is_to_befall_robots_stops_fusing():
    world = World(("pioneer3dx",), [[0.0, 0.0, 0.0]])
    world.parts = [Faults(world.motion, world.clock, [FIELDS["events"][0][0]])]
    assert not world.can_fuse(5)


@pytest.mark.release  # compiling takes long
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"fidelity": "point_mass"},
        {"model": "robotino3"},
        {"model": "crazyflie2", "fidelity": "dynamic", "altitude": 1.0},
    ],
    ids=["", "points", "bases", "quadrotors"],
)
def test_numba_gives_the_same(changes, compiled, monkeypatch):
    pytest.importorskip("numba")
    jit, kept = compiling.jit(), compiling.jit(cache=True)
    function = functools.partial(compiled_terms.kernel, compile_=jit, compile_kept=kept)
    monkeypatch.setattr(fused_stepping, "compiled_stretch", function)
    compare(compiled, shipped("paper", 5.0).changed(**changes))
