"""Twenty-three laws of three robots, each written to be one thing, and what asking finds of each."""

import math

import numpy as np
import pytest
from asked_laws import PATH, STARTS, facts

PLACES = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
CYCLE = np.eye(3) - np.roll(np.eye(3), 1, axis=1)
ONE_LEFT_OUT = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [0.0, -1.0, 1.0]])
ONE_PUSHES = np.array([[-1.0, 1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
LED = np.array([[0.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])
CHAIN = np.array([[1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])
SIDES = np.array([[0.0, 3.0, 4.0], [3.0, 0.0, 5.0], [4.0, 5.0, 0.0]])  # [m]
IN_SPACE = np.column_stack([STARTS, [1.0, 2.0, 1.5]])


def in_range(hand, *_):
    near = (np.linalg.norm(hand[:, np.newaxis] - hand, axis=2) < 1.0) * 1.0
    return near @ hand - near.sum(axis=1, keepdims=True) * hand


def by_distances(hand, *_):
    apart = hand[:, np.newaxis] - hand
    stretch = (apart**2).sum(axis=2) - SIDES**2
    return -0.01 * (stretch[:, :, np.newaxis] * apart).sum(axis=1)


def pursuit(angle):
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return lambda hand, *_: -(CYCLE @ hand) @ turn.T


# (law, what is found: attributes of the facts, and of the linear theorem)
LINEAR = {
    "agreement": (lambda hand, *_: -PATH @ hand, dict(gradient=True, rotation=True), 1.0),
    "places": (lambda hand, *_: -PATH @ (hand - PLACES), dict(gradient=True, rotation=False), 1.0),
    "home": (lambda hand, *_: -0.3 * hand, dict(translation=False, rotation=True), 0.3),
    "one left out": (lambda hand, *_: -ONE_LEFT_OUT @ hand, dict(gradient=False), 1.0),
    "a cycle": (lambda hand, *_: -CYCLE @ hand, dict(gradient=False, rotation=True), 1.5),
    "pursuit": (pursuit(0.5), dict(gradient=False, rotation=True), None),
    "pursuit too far aside": (pursuit(1.2), dict(gradient=False, rotation=True), "unstable"),
    "a leader that stands": (lambda hand, *_: -LED @ hand, dict(gradient=False), 1.0),
    "a chain": (lambda hand, *_: -CHAIN @ hand, dict(translation=False), 1.0),
    "wrong sign": (lambda hand, *_: PATH @ hand, dict(gradient=True), "unstable"),
    "one wrong sign": (lambda hand, *_: -ONE_PUSHES @ hand, dict(gradient=False), "unstable"),
    "slower across": (lambda hand, *_: -PATH @ hand * [1.0, 0.5], dict(rotation=False), 0.5),
    "for ever round": (lambda hand, *_: hand @ TURN.T, dict(gradient=False), "unstable"),
    "in space": (lambda hand, *_: -PATH @ hand, dict(gradient=True, rotation=True), 1.0),
    "to a height": (lambda hand, *_: -hand * [0, 0, 0.4], dict(translation=False, rotation=True), 0.4),
}  # fmt: skip


@pytest.mark.parametrize("name", LINEAR)
def test_a_linear_law_is_what_it_was_written_to_be(name):
    law, attributes, decay = LINEAR[name]
    found = facts(law, IN_SPACE if name in ("in space", "to a height") else STARTS)
    assert found.memory == "" and not found.headings and found.residual < 1e-9
    assert {key: getattr(found, key) for key in attributes} == attributes
    assert found.linear.is_stable == (decay != "unstable")
    if isinstance(decay, float):
        assert found.linear.rate == pytest.approx(decay, abs=1e-6)
    assert found.linear.is_defective == (name in ("a chain", "a leader that stands"))


def test_pursuit_turns_as_its_angle_says_and_a_leader_drifts():
    mu = 1.0 - np.exp(2j * math.pi * np.arange(1, 3) / 3.0)
    turned = np.concatenate([mu * np.exp(0.5j), mu * np.exp(-0.5j)])
    assert facts(pursuit(0.5)).linear.rate == pytest.approx(turned.real.min(), abs=1e-9)
    found = facts(lambda hand, *_: -LED @ hand + [[0.1, 0.0], [0.0, 0.0], [0.0, 0.0]])
    drift = found.linear.drift.reshape(3, 2)
    assert drift == pytest.approx(np.tile([0.1, 0.0], (3, 1)), abs=1e-9)


@pytest.mark.parametrize("matrix", [PATH, ONE_LEFT_OUT, CYCLE, LED, CHAIN])
def test_who_receives_from_whom_is_what_the_matrix_says(matrix):
    who = np.any(facts(lambda hand, *_: -matrix @ hand).receives, axis=0)
    others = ~np.eye(3, dtype=bool)
    assert (who[others] == (matrix != 0.0)[others]).all()


@pytest.mark.parametrize(
    "law, memory, headings",
    [
        (lambda hand, time, call, theta: -hand * (2.0 + math.sin(time)), "time", False),
        (lambda hand, time, call, theta: -hand + 0.1 * call, "the states before", False),
        (lambda hand, *_: -hand + 0.01 * np.random.default_rng().random(), "chance", False),
        (lambda hand, time, call, theta: -hand * np.cos(theta)[:, np.newaxis], "", True),
    ],
)
def test_what_a_law_knows_besides_positions_is_named(law, memory, headings):
    found = facts(law)
    assert (found.memory, found.headings, found.linear) == (memory, headings, None)


def test_saturation_is_linear_near_agreement_alone():
    found = facts(lambda hand, *_: -np.tanh(PATH @ hand))
    assert found.residual > 0.1 and found.linear.rate == pytest.approx(1.0, abs=1e-6)
    assert [theorem.is_stable for _, theorem in found.equilibria] == [True]


def test_neighbours_in_range_are_fewer_farther_apart():
    found = facts(in_range)
    counts = [int(who.sum() - np.trace(who)) for who in found.receives]
    assert counts[0] > counts[2] and found.residual > 0.01
    flat = [theorem for _, theorem in found.equilibria if not theorem.eigenvalues.any()]
    assert len(flat) <= 1  # where none is in range of another, all alike


def test_a_sign_never_rests():
    found = facts(lambda hand, *_: -np.sign(hand))
    assert found.residual > 0.1 and found.equilibrium is None and found.linear is None


def test_two_wells_have_equilibria_of_several_kinds():
    found = facts(lambda hand, *_: hand - hand**3)  # each coordinate rests at -1, 0 or 1
    assert np.abs(found.equilibrium) == pytest.approx(np.ones((3, 2)), abs=1e-6)
    assert found.equilibria[0][1].is_stable and len(found.equilibria) >= 3
    for state, theorem in found.equilibria:
        resting = np.abs(state).round(6)
        assert set(resting.ravel()) <= {0.0, 1.0}
        wanted = np.sort(np.where(resting.ravel() > 0.5, 2.0, -1.0))
        assert np.sort(theorem.eigenvalues.real) == pytest.approx(wanted, abs=1e-4)
        assert theorem.is_stable == bool((resting > 0.5).all())


def test_a_shape_by_distances_stands_and_its_folded_forms_do_not():
    found = facts(by_distances)
    assert (found.translation, found.rotation, found.gradient) == (True, True, True)
    apart = np.linalg.norm(found.equilibrium[:, np.newaxis] - found.equilibrium, axis=2)
    assert apart == pytest.approx(SIDES, abs=1e-6)
    assert found.linear.zeros == 3 and found.linear.is_stable  # it may move and turn as a whole
    assert any(not theorem.is_stable for _, theorem in found.equilibria)
