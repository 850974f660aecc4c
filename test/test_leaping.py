"""Several steps in one compiled call: the same trajectories, contacts and errors as step by step."""

import os

import numpy as np
import pytest

from mrs_simulator import PioneerControl, load_scenario
from mrs_simulator.control.array_law import array_law
from mrs_simulator.control.laws.formation import Formation
from mrs_simulator.core import compiled_terms, compiling, edge_terms
from mrs_simulator.core.parameters import Parameter
from mrs_simulator.core.scenario import scenario_from_dict
from mrs_simulator.study.experiment import Experiment, LawFailed
from mrs_simulator.world import kinematic, leaping

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
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


@pytest.fixture()
def compiled(monkeypatch):
    """Let stretches be made, by Python as it stands: what numba compiles is the same code."""

    def start():
        monkeypatch.setattr(compiling, "is_wanted", lambda: True)
        for module in (kinematic, edge_terms):  # only the stretches are on trial
            monkeypatch.setattr(module, "compiling", type("no", (), {"is_wanted": lambda: False}))

    function = kernel_of(lambda kernel: kernel)
    monkeypatch.setattr(leaping, "compiled_stretch", function)
    return start


def kernel_of(compile_):
    return lambda law: compiled_terms.kernel(law, leaping.stretch, compile_, compile_)


def recorded(scenario, protocol=None):
    """Return samples (m, n, 5), collisions, and how often the world made a step of its own."""
    experiment, own = Experiment(scenario, protocol), []
    step = experiment.world.step
    experiment.world.step = lambda: own.append(1) or step()
    rows = [np.column_stack(told[1:]) for told in experiment.samples()]
    return np.array(rows), experiment.collisions, len(own), experiment.world


def compare(start, scenario, protocol=None):
    by_step = recorded(scenario, protocol)
    start()
    by_leap = recorded(scenario, protocol)
    assert by_leap[0].shape == by_step[0].shape
    np.testing.assert_allclose(by_leap[0], by_step[0], rtol=0.0, atol=ROUNDING)
    assert len(by_leap[1]) == len(by_step[1])
    assert by_leap[3].time == by_step[3].time and by_leap[3].commanded.all()
    np.testing.assert_array_equal(by_leap[3]._commands.heard, by_step[3]._commands.heard)
    return by_step[2], by_leap[2]


@pytest.mark.parametrize("name", ["paper", "distance_formation", "bearing_formation"])
def test_shipped_laws_leap_to_where_steps_lead(name, compiled):
    steps, own = compare(compiled, shipped(name))
    assert own < 0.2 * steps


@pytest.mark.parametrize("saturation", ["none", "robot", "team"])
@pytest.mark.parametrize("rates", [(50, 10), (10, 10), (12.5, 50), (12.5, 5)])
def test_a_users_law_leaps_whatever_the_rates(saturation, rates, compiled):
    control = {"rate": rates[0], "saturation": saturation}
    limits = "firmware" if saturation == "robot" else "top"
    given = scenario(control=control, record_rate=rates[1], duration=1.9, limits=limits)
    steps, own = compare(compiled, given, Gather)
    assert own < steps


def test_robots_touch_as_they_do_step_by_step(compiled):
    given = scenario(poses={"layout": "circle", "radius": 1.0}, duration=8.0)
    steps, own = compare(compiled, given, Gather)
    assert 10 < own < steps


def test_a_law_that_breaks_fails_as_it_does_step_by_step(compiled):
    given, said = scenario(poses=[[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]], robots=2), []
    for _ in range(2):
        with pytest.raises(LawFailed) as error:
            recorded(given, Breaking)
        said.append(str(error.value))
        compiled()
    assert said[0] == said[1] and "not finite" not in said[0] and "nan" in said[0]


@pytest.mark.parametrize(
    ("protocol", "changes"),
    [
        (Turned, {}),
        (Filtered, {}),
        (Formation, {"odometry": "wheel"}),
        (Formation, {"fidelity": "point_mass"}),
        (Formation, {"model": ["robotino3"] * 2 + ["pioneer3dx"] * 3}),
        (Formation, {"links": {"delay": 0.1}}),
        (Formation, {"control": {"rate": 1}, "cmd_vel_timeout": 0.5}),
        (Formation, {"control": {"safety": {"arena": [-9, -9, 9, 9]}}}),
    ],
)
def test_what_more_decides_on_goes_step_by_step(protocol, changes, compiled):
    compiled()
    assert Experiment(scenario(**changes), protocol)._leaps() is None


def test_numba_gives_the_same(compiled, monkeypatch):
    pytest.importorskip("numba")
    jit = compiling.jit()
    monkeypatch.setattr(leaping, "compiled_stretch", kernel_of(jit))
    compare(compiled, shipped("paper", 5.0))
