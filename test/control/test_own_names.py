"""Names of PioneerControl's own: a law that takes one for itself is told which, and where."""

import copy

import numpy as np
import pytest

from mrs_simulator import Parameter, PioneerControl
from mrs_simulator.control.class_checks import OWN
from mrs_simulator.control.twists import ControlError
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import scenario_from_dict

POSE = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])


class Still(PioneerControl):
    def pointMassLaw(self, hand):
        return np.zeros_like(hand)


@pytest.mark.parametrize("name", sorted(OWN))
def test_a_name_of_its_own_is_refused(name):
    control = Still([1, 2])
    with pytest.raises(ControlError, match="Still: self.{} is PioneerControl's own".format(name)):
        setattr(control, name, ["red", "blue"])
    control.commands(POSE)  # nothing is broken


@pytest.mark.parametrize("name", ["points", "start", "targets", "claims", "carried"])
def test_a_method_is_not_replaced_by_a_value(name):
    with pytest.raises(ControlError, match="Still: self.{} is a method or property".format(name)):
        setattr(Still([1, 2]), name, np.zeros((2, 2)))


def test_a_method_may_be_replaced_by_another():
    control = Still([1, 2])
    control.targets = lambda hand: hand + 1.0
    np.testing.assert_array_equal(control.targets(np.zeros((2, 2))), np.ones((2, 2)))


def test_the_law_that_takes_a_name_is_named_where_it_is_made():
    class Teams(PioneerControl):
        def __init__(self, *given, **named):
            super().__init__(*given, **named)
            self.team = ["red", "blue"]

        def pointMassLaw(self, hand):
            return np.zeros_like(hand)

    scenario = scenario_from_dict({"robots": 2, "poses": POSE.tolist()})
    with pytest.raises(ValueError, match="self.team is PioneerControl's own, the robots' vehicles"):
        make_control(scenario, Teams)


def test_a_name_taken_while_running_is_reported():
    class Joints(PioneerControl):
        def pointMassLaw(self, hand):
            self.joints = hand
            return np.zeros_like(hand)

    with pytest.raises(ControlError, match="Joints: self.joints is PioneerControl's own"):
        Joints([1, 2]).commands(POSE)


@pytest.mark.parametrize(
    "name, value, what",
    [
        ("team", ("red", "blue"), "the robots' vehicles"),
        ("joints", lambda self: [], "inner joints"),
        ("time", 0.0, "sets at each command"),
        ("_keep", lambda self, x: x, "laws do not see"),
        ("_given_topology", None, "the scenario's topology"),
        ("safety_filter", None, "keeps robots apart"),
        ("targets", [(0.0, 0.0)], "a method"),
    ],
)
def test_a_class_that_hides_a_name_is_refused(name, value, what):
    with pytest.raises(TypeError, match="Hiding defines '{}'.*{}".format(name, what)):
        type("Hiding", (Still,), {name: value})


@pytest.mark.parametrize("name", ["team", "safety", "runner", "time", "points"])
def test_a_parameter_is_not_called_so(name):
    with pytest.raises(TypeError, match="may not be called '{}'".format(name)):
        type("Named", (Still,), {"PARAMETERS": (Parameter(name, 1.0),)})


def test_names_of_ones_own_are_free():
    class Own(PioneerControl):
        PARAMETERS = (Parameter("gain", 1.0),)

        def start(self):
            self.memory, self._last = {}, None

        def pointMassLaw(self, hand):
            self.memory[self.time] = hand
            self.topology = self.topology
            return np.zeros_like(hand)

    control = Own([1, 2])
    control.start()
    control.commands(POSE)
    assert list(control.memory) == [0.0]


@pytest.mark.parametrize("given", [3, (), (1,), (2, 3, 4), "23"])
def test_dimensions_are_two_or_three(given):
    with pytest.raises(TypeError, match="Wrong.DIMENSIONS = .*wanted some of"):
        type("Wrong", (Still,), {"DIMENSIONS": given})


class Pull(PioneerControl):
    PARAMETERS = (Parameter("gain", 1.0),)
    _network = _heights = None  # names that the runner keeps to itself

    def pointMassLaw(self, hand):
        self._network = self._heights = "of the law"
        return -self.gain * hand


def test_a_copy_runs_its_own_law_and_filter():
    control = Pull([1, 2], safety=0.3)
    other = copy.copy(control)
    other.set_parameters({"gain": 0.0})
    other._keep(safety=0.0)
    other.safety_filter.acts = False
    assert not other.commands(POSE).any() and control.commands(POSE).any()
    assert control.safety_filter.acts and control.safety_filter.body_radii.tolist() == [0.3, 0.3]
    assert other.safety_filter.body_radii.tolist() == [0.0, 0.0]


def test_a_law_may_call_its_attributes_as_parts_call_theirs():
    control = Pull([1, 2])
    first = control.commands(POSE)
    np.testing.assert_array_equal(control.commands(POSE), first)
    assert control._network == "of the law"
