"""Kinematics: the paper's equations with typed-out numbers."""

import math
import sys

import numpy as np
import pytest

from mrs_simulator.core import compiling
from mrs_simulator.core import kinematics as kin
from mrs_simulator.vehicles.kind import Body
from mrs_simulator.world.contact.collisions import Footprints
from mrs_simulator.world.motion import compiled, kinematic

LIMITS = kin.Limits(0.75, 1.5, 0.3, 2.0)


def test_hand_point_lies_l_ahead():
    pose = np.array([[1.0, 2.0, math.pi / 2.0], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(kin.hand_points(pose, 0.05), [[1.0, 2.05], [0.05, 0.0]])


def test_mapping_of_a_point_mass_input():
    # Facing +y, wanted +x: all of it is turning right, omega = -ux/l.
    u = np.array([[0.1, 0.0], [0.1, 0.2]])
    command = kin.unicycle_from_point_mass(u, np.array([math.pi / 2.0, 0.0]), 0.05)
    np.testing.assert_allclose(command, [[0.0, -2.0], [0.1, 4.0]], atol=1e-12)


def test_mapping_and_its_inverse():
    draw = np.random.default_rng(1)
    u, theta = draw.normal(size=(20, 2)), draw.uniform(-4, 4, 20)
    command = kin.unicycle_from_point_mass(u, theta, 0.07)
    np.testing.assert_allclose(kin.point_mass_from_unicycle(command, theta, 0.07), u, atol=1e-12)


def test_arc_of_a_quarter_circle():
    pose = np.array([[0.0, 0.0, 0.0]])
    command = np.array([[math.pi / 2.0, math.pi / 2.0]])  # radius 1 m, a quarter in 1 s
    np.testing.assert_allclose(kin.arc(pose, command, 1.0), [[1.0, 1.0, math.pi / 2.0]], atol=1e-12)


def test_arc_without_turning_is_a_line():
    pose = np.array([[1.0, 1.0, math.pi / 6.0]])
    after = kin.arc(pose, np.array([[2.0, 0.0]]), 0.5)
    expected = [[1.0 + math.cos(math.pi / 6.0), 1.5, math.pi / 6.0]]
    np.testing.assert_allclose(after, expected, atol=1e-12)


def test_held_arc_turns_the_hand_error_as_stated():
    # alpha+ = alpha* + [I - kappa Tc sinc(D/2) R(D/2)] (alpha - alpha*)
    kappa, period, l = 0.2, 0.1, 0.05
    pose, error = np.array([[3.0, -1.0, 0.0]]), np.array([[0.4, 1.5]])
    command = kin.unicycle_from_point_mass(-kappa * error, pose[:, 2], l)
    moved = kin.hand_points(kin.arc(pose, command, period), l) - kin.hand_points(pose, l)
    half = 0.5 * command[0, 1] * period
    turn = np.array([[math.cos(half), -math.sin(half)], [math.sin(half), math.cos(half)]])
    expected = -kappa * period * math.sin(half) / half * turn @ error[0]
    np.testing.assert_allclose(moved[0], expected, atol=1e-12)


def test_ramp_reaches_its_target_and_covers_the_exact_distance():
    velocity = np.array([[0.0, 0.0]])
    after, mean = kin.ramp(velocity, np.array([[0.75, 0.1]]), np.array(LIMITS[2:]), 1.0)
    np.testing.assert_allclose(after, [[0.3, 0.1]])
    # 0.3 m/s^2 for 1 s covers 0.15 m; 2 rad/s^2 reaches 0.1 in 0.05 s: 0.0025 + 0.095 rad
    np.testing.assert_allclose(mean, [[0.15, 0.0975]])


def test_ramp_without_limits_is_immediate():
    target = np.array([[0.5, -1.0]])
    after, mean = kin.ramp(np.zeros((1, 2)), target, np.array(kin.NO_LIMITS[2:]), 0.02)
    np.testing.assert_array_equal(after, target)
    np.testing.assert_array_equal(mean, target)


def test_scaling_keeps_each_path_or_the_whole_motion():
    command, excess = np.array([[1.5, 0.3], [0.1, -3.0], [0.1, 0.1]]), np.array([2.0, 2.0, 0.2])
    np.testing.assert_allclose(
        kin.scaled(command, excess), [[0.75, 0.15], [0.05, -1.5], [0.1, 0.1]]
    )
    np.testing.assert_allclose(kin.scaled(command, excess, "team"), command / 2.0)


def test_wheels_and_body():
    wheels = kin.wheel_speeds(np.array([[0.5, 1.0]]), 0.4)
    np.testing.assert_allclose(wheels, [[0.3, 0.7]])
    np.testing.assert_allclose(kin.body_speeds(wheels, 0.4), [[0.5, 1.0]])


@pytest.mark.parametrize("sign", [1.0, -1.0])  # the same turn
def test_yaw_of_a_robot_that_rolls(sign):
    # rolled by 0.4 rad, then turned by 3 rad
    turn = 0.0140533125, 0.1981716615, 0.9776114979, 0.0693271672
    assert kin.yaw(*(sign * part for part in turn)) == pytest.approx(3.0, abs=1e-6)
    assert kin.yaw(0.0, 0.0, sign * 1.0, 0.0) == pytest.approx(math.pi)


def test_a_heading_comes_back_from_its_quaternion_to_the_bit():
    random = np.random.default_rng(0)
    small = random.uniform(-1.0, 1.0, 20000) * 10.0 ** random.uniform(-12.0, 0.0, 20000)
    special = [
        np.pi,
        -np.pi,
        0.0,
        0.5 * np.pi,
        0.236166700523017,
        -0.12499672993798529,
        0.16455275477351236,
    ]
    for theta in [*random.uniform(-np.pi, np.pi, 40000).tolist(), *small.tolist(), *special]:
        z, w = kin.turn_about_z(theta)
        assert kin.heading_about_z(z, w) == theta and abs(math.hypot(z, w) - 1.0) < 1e-15
        assert kin.yaw(0.0, 0.0, z, w) == pytest.approx(theta, abs=1e-15)
    assert kin.heading_about_z(-1.0, -0.0) == math.pi
    assert kin.heading_about_z(-0.6, -0.8) == kin.heading_about_z(0.6, 0.8)


def test_compose_and_wrap():
    origin = np.array([[1.0, 2.0, math.pi / 2.0]])
    pose = np.array([[1.0, 0.0, math.pi]])
    np.testing.assert_allclose(kin.compose(origin, pose), [[1.0, 3.0, -math.pi / 2.0]], atol=1e-12)
    np.testing.assert_allclose(
        kin.wrap_angle([math.pi, -math.pi, 7.0]), [-math.pi, -math.pi, 7.0 - 2.0 * math.pi]
    )


def test_sines_are_taken_of_contiguous_arrays_only(monkeypatch):
    # numpy's last bits of a strided one depend on where the heap put the result.
    def checked(function):
        def call(angle, *args, **kwargs):
            assert np.asarray(angle).flags.c_contiguous
            return function(angle, *args, **kwargs)

        return call

    pose, pairs = np.ones((5, 3)), np.ones((5, 2))
    monkeypatch.setattr(np, "cos", checked(np.cos))
    monkeypatch.setattr(np, "sin", checked(np.sin))
    for rows in (pose, np.asfortranarray(pose), pose[::2]):
        kin.hand_points(rows, 0.05)
        kin.unicycle_from_point_mass(pairs[: len(rows)], rows[:, 2], 0.05)
        kin.point_mass_from_unicycle(pairs[: len(rows)], rows[:, 2], 0.05)
        kin.compose(rows, rows)
        kin.origins(rows, rows)
        kin.arc(rows, pairs[: len(rows)], 0.02)
        Footprints([Body(0.2, 0.3, 0.4, 0.2)]).at(rows)


def same_motion(approached, carried_on):
    draw = np.random.default_rng(2)
    for limits in (LIMITS, kin.NO_LIMITS):
        pose = np.asfortranarray(draw.uniform(-np.pi, np.pi, (50, 3)))
        velocity = np.zeros((50, 2), order="F")
        for _ in range(60):
            command = np.asfortranarray(draw.normal(size=(50, 2)))
            command[::3, 1] = 0.0
            most = np.array(limits[2:])
            how = velocity, command, most, 0.1
            reach = kin.Reach.of(np.full((50, 2), 0.1 * most, order="F"))
            other = approached(velocity, command, reach)
            velocity, mean = kin.ramp(*how)
            for one, two in zip((velocity, mean), other):
                np.testing.assert_array_equal(one, two)
            sliding = np.column_stack([mean[:, 0], draw.normal(size=50), mean[:, 1]])
            for twist in (np.asfortranarray(sliding), mean):
                after = kin.displaced(pose, twist, 0.1)
                moved = twist * np.append(np.full(twist.shape[1] - 1, 0.1), 0.05)
                np.testing.assert_array_equal(carried_on(pose, np.asfortranarray(moved)), after)
            pose = after


@pytest.mark.parametrize("n", [1, 2, 7])
def test_cosines_are_those_of_contiguous_angles(n, monkeypatch):
    # numpy's routine for other angles has other last bits, and is taken where the heap makes it so.
    met, cos, sin = [], np.cos, np.sin
    monkeypatch.setattr(np, "cos", lambda angle: (met.append(angle.strides), cos(angle))[1])
    monkeypatch.setattr(np, "sin", lambda angle: (met.append(angle.strides), sin(angle))[1])
    poses = np.random.default_rng(n).uniform(-3.0, 3.0, (n, 3))
    for angle in (poses[:, 2], poses[:1, 2], np.asfortranarray(poses)[:, 2]):
        kin.cos_sin(angle)
    assert met == [(8,)] * 6


def test_the_kernels_give_numpys_bits():
    same_motion(
        *(twin(lambda kernel: kernel) for twin in (compiled.approached_by, compiled.carried_by))
    )


def test_the_compiled_kernels_give_numpys_bits():
    pytest.importorskip("numba")
    same_motion(compiled.compiled_approached(), compiled.compiled_carried())


def test_compiled_kernels_are_asked_for_by_the_environment(monkeypatch):
    monkeypatch.delenv("MRS_SIMULATOR_COMPILED", raising=False)
    monkeypatch.setattr(compiling, "_asked", {})
    assert kinematic.approached_function() is kin.ramped
    assert kinematic.carried_function() is kin.moved_along_arcs_wrapped
    monkeypatch.setenv("MRS_SIMULATOR_COMPILED", "yes")
    with pytest.raises(ValueError, match="MRS_SIMULATOR_COMPILED=yes: wanted 0 or 1"):
        kinematic.approached_function()
    monkeypatch.setenv("MRS_SIMULATOR_COMPILED", "1")
    monkeypatch.setitem(sys.modules, "numba", None)
    compiled.approach_twin.cache_clear()
    with pytest.raises(ValueError, match="numba is not installed"):
        kinematic.approached_function()


def test_a_twist_without_sideways_speed_moves_as_a_unicycle_does():
    draw = np.random.default_rng(5)
    pose, twist = draw.normal(size=(20, 3)), draw.normal(size=(20, 3))
    twist[:, 1] = 0.0
    np.testing.assert_array_equal(
        kin.displaced(pose, twist, 0.1), kin.displaced(pose, twist[:, ::2], 0.1)
    )


def test_an_arc_is_to_the_bit_what_a_quotient_with_exceptions_gives():
    draw = np.random.default_rng(5)
    for scale in (0.0, 1e-310, 1e-299, 1e-250, 1e-12, 1e-3, 1.0, 300.0):
        pose, twist = draw.normal(size=(40, 3)), draw.normal(size=(40, 2))
        twist[:, 1] *= scale
        twist[::5, 1] = 0.0
        half = 0.5 * 0.02 * twist[:, 1]
        share = np.ones(40)
        np.divide(np.sin(half), half, out=share, where=half != 0.0)
        along, middle = 0.02 * twist[:, 0] * share, pose[:, 2] + half
        wanted = [pose[:, 0] + along * np.cos(middle), pose[:, 1] + along * np.sin(middle)]
        for duration in (0.02, np.full((40, 1), 0.02)):
            after = kin.arc(pose, twist, duration)
            np.testing.assert_array_equal(after.T, [*wanted, middle + half])


def test_the_greatest_of_any_numbers():
    values = np.array([[1.0, -3.0, 2.0], [0.0, 2.5, -2.0]])
    for layout in (values, np.asfortranarray(values), values[:, ::-1], values[::2]):
        assert kin.max_abs(layout) == 3.0
    assert kin.max_abs(np.empty((0, 2))) == 0.0
    values[1, 1] = np.nan
    assert np.isnan(kin.max_abs(values))
    assert kin.max_abs(np.array([1.0, -np.inf])) == np.inf


@pytest.mark.parametrize("n", [1, 7, 6000])
def test_values_within_a_bound_are_those_whose_greatest_is(n):
    values = np.zeros((n, 2), order="F")
    values[-1, 1] = -2.0
    for bound, within in ((2.0, True), (2.5, True), (1.9, False), (1e12, True), (np.inf, True)):
        assert kin.are_within(values, bound) is within
    for other in (np.nan, np.inf, 1e200):
        values[n // 2, 1] = other
        assert not kin.are_within(values, 1e12)
    assert kin.are_within(np.empty((0, 2)), 1.0)


@pytest.mark.parametrize("shape", [(5, 1), (4, 3, 2), (2, 7, 4)])
def test_the_greatest_of_each_row(shape):
    values = np.random.default_rng(2).normal(size=shape)
    values[0, ..., -1] = np.nan
    for layout in (values, np.asfortranarray(values), values[::-1]):
        assert np.array_equal(kin.max_of_rows(layout), layout.max(axis=-1), equal_nan=True)
