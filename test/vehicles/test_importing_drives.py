"""Robots whose description names no drive, beside which the user names one."""

import math
import os

import numpy as np
import pytest
import yaml
from robot_descriptions import urdf, write_package

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.vehicles import kind
from mrs_simulator.vehicles.registry import DIRECTORY
from mrs_simulator.world.world import World

# A shipped model, of which the importer knows its URDF alone; its kind's file has the right numbers.
DRIVES = {"f1tenth": "car", "robotino3": "omnidirectional", "youbot": "omnidirectional"}
FLYER = """<robot name="flyer">
  <properties arm="0.04" kf="3e-10" km="8e-12" thrust2weight="2" max_speed_kmh="36"/>
  <link name="base_link">
    <inertial><mass value="0.03"/><inertia ixx="1e-5" iyy="2e-5" izz="3e-5"/></inertial>
    <collision><geometry><cylinder radius="0.06" length="0.02"/></geometry></collision>
  </link>
</robot>
"""


def shipped(name):
    return os.path.join(DIRECTORY, name + ".urdf")


def limits_of(name):
    axes = {"car": ("linear.x",), "omnidirectional": ("linear.x", "linear.y", "angular.z")}
    return {"firmware": {axis: {"max": 0.5} for axis in axes[DRIVES[name]]}}


def brought(directory, path, drive, **keys):
    """Return the ``Kind`` of the description at ``path``."""
    content = dict(keys, **{"import": {"urdf": str(path), "drive": drive}})
    (directory / "mine.yaml").write_text(yaml.safe_dump(content))
    return kind("mine.yaml", str(directory))


def test_a_car_is_read_from_its_hinges_and_wheels(tmp_path):
    mine = brought(tmp_path, shipped("f1tenth"), "car", limits=limits_of("f1tenth"))
    numbers, right = mine.numbers, kind("f1tenth").numbers
    for key in ("wheelbase", "track", "radius", "steering_max", "steering_rate"):
        assert getattr(numbers, key) == pytest.approx(getattr(right, key))
    assert numbers.mass_ahead == pytest.approx(right.mass_ahead, rel=1e-3)
    assert mine.mass == pytest.approx(3.74) and mine.body.front == pytest.approx(0.46145)
    about_axle = 0.04712 + 3.74 * right.mass_ahead**2  # the shipped one is about the centre of mass
    assert mine.inertia == pytest.approx(about_axle, rel=0.05)


@pytest.mark.parametrize("name", ["robotino3", "youbot"])
def test_an_omnidirectional_base_is_read_from_where_its_wheels_stand(tmp_path, name):
    mine = brought(tmp_path, shipped(name), "omnidirectional", limits=limits_of(name))
    rows = [sorted(map(tuple, np.round(k.numbers.rolling, 5) + 0.0)) for k in (mine, kind(name))]
    np.testing.assert_allclose(*rows, atol=1e-5)
    assert mine.mass == pytest.approx(kind(name).mass)


def test_a_differential_drive_is_read_from_its_wheels(tmp_path):
    path = write_package(tmp_path, urdf(plugin=""))
    numbers = brought(tmp_path, path, "differential").numbers
    assert (numbers.track, numbers.radius) == pytest.approx((0.2, 0.04))


def test_a_quadrotor_takes_its_rotors_from_properties(tmp_path):
    (tmp_path / "flyer.urdf").write_text(FLYER)
    flight = {
        "motor_lag": 0.07,
        "tilt": 0.5,
        "drag": {"across": 0.0, "up": 0.0},
        "poles": {"tilt": 30.0, "turn": 12.0},
        "response": {"across": 0.1, "up": 0.1},
    }
    limits = {"firmware": {"linear.z": {"max": 1.0}, "angular.z": {"max": 2.0}}}
    mine = brought(tmp_path, "flyer.urdf", "quadrotor", limits=limits, flight=flight)
    assert (mine.body.round, mine.body.front, mine.body.height) == (True, 0.06, 0.02)
    assert mine.numbers.inertia == pytest.approx((1e-5, 2e-5, 3e-5))
    # At full speed four rotors pull twice the weight: 4 k w^2 = 2 m g, with k per (rad/s)^2.
    thrust = 3e-10 * (30.0 / math.pi) ** 2
    assert 4.0 * thrust * mine.numbers.speed_max**2 == pytest.approx(2.0 * 0.03 * 9.81, rel=1e-3)
    assert mine.limits["firmware"][0].top == pytest.approx(10.0)
    with pytest.raises(ScenarioError, match="mine.yaml: limits.firmware.linear.z.max: nothing"):
        brought(tmp_path, "flyer.urdf", "quadrotor", flight=flight)


@pytest.mark.parametrize("name", sorted(DRIVES))
def test_an_imported_robot_moves_with_forces_as_commanded(tmp_path, name):
    brought(tmp_path, shipped(name), DRIVES[name], limits=limits_of(name))
    scenario = {"model": "mine.yaml", "poses": [[0.0, 0.0, 0.0]], "fidelity": "dynamic"}
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario))
    world = Experiment(load_scenario(str(tmp_path / "scenario.yaml"))).world
    command = [0.4, 0.4] if DRIVES[name] == "car" else [0.2, 0.1, 0.2]
    for _ in range(75):
        world.set_commands([0], [command])
        world.step()
    twist = world.twist[0]
    world.close()
    wanted = [0.4, 0.0, 0.4] if DRIVES[name] == "car" else command
    np.testing.assert_allclose(twist, wanted, atol=0.03)


@pytest.mark.parametrize("given", [{}, {"torque": 6.0}])
def test_motors_of_an_unknown_torque_let_heavy_wheels_slide_in_a_turn(tmp_path, given):
    limits = {"firmware": {"linear.x": {"max": 1.0}, "angular.z": {"max": 2.0}}}
    husky = brought(tmp_path, shipped("husky"), "differential", limits=limits, wheels=given)
    told = [note for note in husky.notes if "no torque given" in note]
    world = World((husky,), [[0.0, 0.0, 0.0]], fidelity="dynamic")
    for _ in range(75):
        world.set_commands([0], np.array([[0.0, 1.0]]))
        world.step()
    turn = world.twist[0, 2]
    world.close()
    if given:
        assert turn < 0.5 and not told  # too weak for 44 kg, as the user wants it
    else:
        assert turn == pytest.approx(1.0, rel=0.1) and len(told) == 1


@pytest.mark.parametrize(
    "name, drive, keys, wanted",
    [
        ("f1tenth", "omnidirectional", {}, "rear_right_wheel_joint'; wanted three or four that"),
        ("youbot", "car", {}, "wanted four, the front two on joints with a vertical axis"),
        ("robotino3", "differential", {}, "wanted as many left as right, which turn about y"),
        ("f1tenth", "car", {}, "linear.x.max: nothing given, and .*f1tenth.urdf does not give it"),
        ("crazyflie2", "quadrotor", {}, "linear.x.max: nothing given"),
        ("f1tenth", "boat", {}, "import.drive: 'boat', wanted one of differential, car"),
    ],
)
def test_a_drive_that_does_not_fit_is_refused(tmp_path, name, drive, keys, wanted):
    with pytest.raises(ScenarioError, match=wanted) as caught:
        brought(tmp_path, shipped(name), drive, **keys)
    assert "\n" not in str(caught.value)


def test_hinges_without_limits_and_askew_wheels_are_refused(tmp_path):
    with open(shipped("f1tenth")) as file:
        text = file.read()
    (tmp_path / "car.urdf").write_text(text.replace('type="revolute"', 'type="continuous"'))
    limits = limits_of("f1tenth")
    with pytest.raises(ScenarioError, match="wheels.steering: nothing given, and joint 'front_le"):
        brought(tmp_path, "car.urdf", "car", limits=limits)
    mine = brought(tmp_path, "car.urdf", "car", limits=limits, wheels={"steering": "20 deg"})
    assert mine.numbers.steering_max == pytest.approx(math.radians(20.0))
    with open(shipped("robotino3")) as file:
        text = file.read()
    (tmp_path / "omni.urdf").write_text(text.replace('axis xyz="-1 0 0"', 'axis xyz="0 1 0"'))
    with pytest.raises(ScenarioError, match="joint 'wheel2_joint': turns about .*wanted the ray"):
        brought(tmp_path, "omni.urdf", "omnidirectional", limits=limits_of("robotino3"))
