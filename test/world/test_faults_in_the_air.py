"""What befalls robots that fly: rotors lost, motors cut, tumbling, saturation, numbers that are none."""

import json

import numpy as np
import pytest
from protocol_fixtures import verdict_of

from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.scenario.incidents import Event
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.vehicles.drives import quadrotor, quadrotor_forces, vessel
from mrs_simulator.verdict.verdict import NOT_JUDGED
from mrs_simulator.world.world import EVERY, World, WorldError

BOTH = pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
PLACES = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
LOST = {"at": 1.0, "robot": 2, "event": "rotor_lost", "rotor": 3}


def flown(world, duration, command=0.0):
    for _ in range(int(round(duration / world.step_size))):
        world.set_commands(EVERY, np.zeros((world.n, len(world.team.axes))) + command)
        world.step()


def pair(fidelity, **more):
    places = [[0.0, 0.0, 0.3], [1.0, 0.0, 0.0]]
    return World(("crazyflie2",) * 2, places, z=[1.0, 1.5], fidelity=fidelity, **more)


def told(world):
    return [(each.robot, each.what, each.ordered) for each in world.faults.take()]


# Scenario --------------------------------------------------------------------------------------------


def test_events_are_read_in_the_order_of_their_times_and_written_back():
    off = {"at": 0.5, "robot": 1, "event": "motors_off"}
    content = {"model": "crazyflie2", "poses": PLACES, "altitude": 1, "events": [LOST, off]}
    scenario = scenario_from_dict(content)
    assert scenario.events == (Event(0.5, 1, "motors_off"), Event(1.0, 2, "rotor_lost", 3))
    assert scenario_from_dict(scenario.to_dict()).events == scenario.events
    for fewer in (scenario.with_robots(1), scenario.changed(robots=1, poses=PLACES[:1])):
        assert fewer.events == scenario.events[:1]


@pytest.mark.parametrize(
    "wrong, said",
    [
        ({"at": -1.0}, "events.0..at: -1.0"),
        ({"robot": 3}, "robot: 3, wanted a whole number from 1 to 2"),
        ({"event": "explodes"}, "wanted one of rotor_lost, motors_off, pushed"),
        ({"rotor": 5}, "rotor: 5, wanted a whole number from 1 to 4"),
        ({"event": "motors_off"}, "rotor"),
    ],
)
def test_wrong_events_are_refused_by_name(wrong, said):
    content = {
        "model": "crazyflie2",
        "poses": PLACES,
        "altitude": 1,
        "events": [dict(LOST, **wrong)],
    }
    with pytest.raises(ScenarioError, match=said):
        scenario_from_dict(content)
    with pytest.raises(ScenarioError, match="wanted a list"):
        scenario_from_dict(dict(content, events="rotor_lost"))


POINTS = {"model": "crazyflie2", "fidelity": "point_mass"}


@pytest.mark.parametrize(
    "more, said", [({}, "Pioneer 3-DX without rotors"), (POINTS, "point_mass")]
)
def test_robots_without_rotors_lose_none(more, said):
    content = {"poses": [[0, 0, 0], [2, 0, 0]], "events": [LOST]}
    with pytest.raises(WorldError, match=said):
        World.from_scenario(scenario_from_dict(dict(content, **more)))


# Faults ----------------------------------------------------------------------------------------------


@BOTH
def test_a_robot_that_loses_a_rotor_falls_and_the_other_flies_on(fidelity):
    world = pair(fidelity, events=[Event(0.2, 2, "rotor_lost", 1)])
    flown(world, 0.2)
    assert not world.faults.take()
    flown(world, 0.2)
    assert world.flights.states() == {0: "hovering", 1: "falling"}
    flown(world, 2.6, [0.1, 0.0, 0.2, 0.0])
    found = told(world)
    assert found[0] == ("robot2", "rotor_lost", True)
    # With forces three rotors turn it over, and its motors are cut.
    over = [("robot2", "upside_down", True)] if fidelity == "dynamic" else []
    assert found[1:] == over
    assert world.z[1] < 0.05 and world.z[0] > 1.2
    assert np.abs(world.twist[1]).max() < 0.05  # it lies
    with pytest.raises(WorldError, match="robot2 has lost a rotor"):
        world.flights.take_off([1])
    world.close()


def test_a_fall_takes_as_long_as_a_stone():
    world = pair("kinematic", events=[Event(0.0, 1, "motors_off")])
    flown(world, 0.4)
    assert world.z[0] == pytest.approx(1.0 - 0.5 * 9.81 * 0.4**2, abs=1e-9)
    flown(world, 0.1)
    assert world.z[0] == 0.0 and world.flights.states()[0] == "motors off"  # sqrt(2 h/g) = 0.45 s


@BOTH
def test_motors_are_cut_in_the_air_only_where_the_fall_is_confirmed(fidelity):
    world = pair(fidelity)
    flown(world, 0.1)
    with pytest.raises(WorldError, match="robot1 is 1.00 m high and would fall"):
        world.flights.cut_motors([0])
    flown(world, 0.5)
    assert world.z[0] == pytest.approx(1.0, abs=0.02) and not world.faults.take()
    world.flights.cut_motors([0], falls=True)
    flown(world, 1.5)
    assert told(world) == [("robot1", "motors_off", True)] and world.z[0] < 0.03
    flown(world, 0.5, [0.0, 0.0, 0.5, 0.0])
    assert world.z[0] < 0.03 and world.flights.states()[0] == "motors off"  # it obeys nothing
    world.flights.take_off([0], 0.6)
    flown(world, 4.0)
    assert world.z[0] == pytest.approx(0.6, abs=0.02) and world.flights.states()[0] == "hovering"
    world.close()


@BOTH
def test_take_off_and_landing_are_done_whatever_is_commanded(fidelity):
    world = World(("crazyflie2", "ardrone2"), [[0.0, 0.0, 0.3], [2.0, 0.0, 0.0]], fidelity=fidelity)
    assert world.flights.states() == {0: "landed", 1: "landed"}
    world.flights.take_off([0, 1], 0.5)
    flown(world, 0.5, [0.5, 0.0, -0.5, 0.0])
    assert world.flights.states() == {0: "taking off", 1: "taking off"}
    flown(world, 3.5)
    np.testing.assert_allclose(world.z, 0.5, atol=0.02)
    np.testing.assert_allclose(world.pose[:, :2], [[0.0, 0.0], [2.0, 0.0]], atol=1e-3)
    world.flights.land(EVERY)
    flown(world, 0.3, [0.0, 0.0, 0.5, 0.0])
    assert world.flights.states() == {0: "landing", 1: "landing"}
    world.flights.land(EVERY)  # told again, they still land
    flown(world, 2.2, [0.5, 0.0, 0.5, 0.0])
    assert not world.z.any() and world.flights.states() == {0: "landed", 1: "landed"}
    world.flights.take_off(0, 0.4)
    for _ in range(200):  # told to take off, and nothing more, it hovers
        world.step()
    assert world.z[0] == pytest.approx(0.4, abs=0.02) and world.z[1] == 0.0
    world.close()


def test_who_does_not_fly_is_named():
    world = World(("crazyflie2", "heron"), [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]], mirrored=[0])
    for row, said in ((1, "robot2 is a Clearpath Heron"), (0, "robot1 is a real one")):
        for act in (world.flights.take_off, world.flights.land, world.flights.cut_motors):
            with pytest.raises(WorldError, match=said):
                act([row])
    with pytest.raises(WorldError, match="height -1"):
        pair("kinematic").flights.take_off([0], -1)


def test_rotors_at_their_limit_are_reported_after_half_a_second(tmp_path):
    heavy = {"base": "crazyflie2", "mass": "60 g"}  # of 60.7 that they lift
    scenario = scenario_from_dict({"model": "heavy", "kinds": {"heavy": heavy}, "poses": [[0, 0, 0]],
                                   "altitude": 1.0, "fidelity": "dynamic"})  # fmt: skip
    world = World.from_scenario(scenario)
    flown(world, 0.4)
    assert not world.faults.take()
    flown(world, 2.0)
    assert told(world) == [("robot1", "saturated", False)]


@pytest.mark.parametrize("kind, drive, function, fidelity", [
    ("crazyflie2", quadrotor, "flown", "kinematic"),
    ("crazyflie2", quadrotor_forces, "flown", "dynamic"),
    ("heron", vessel, "forced", "dynamic"),
])  # fmt: skip
def test_a_state_that_is_no_number_is_reported_and_stops_that_robot_alone(
    kind, drive, function, fidelity, monkeypatch
):
    z, right = None if kind == "heron" else [1.0, 1.0], getattr(drive, function)
    world = World((kind,) * 2, [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]], z=z, fidelity=fidelity)
    forward = np.eye(1, len(world.team.axes)) * 0.3
    flown(world, 1.0, forward)
    before = world.pose.copy()

    def wrong(*arguments):
        result = right(*arguments)
        inner = result[1] if kind == "heron" else result
        (inner.flight if hasattr(inner, "flight") else inner).velocity[0, 0] = np.nan
        return result

    monkeypatch.setattr(drive, function, wrong)
    flown(world, 0.02, forward)
    monkeypatch.setattr(drive, function, right)
    flown(world, 0.02, forward)  # what is wrong with a boat shows where it has come to
    assert told(world) == [("robot1", "not_finite", False)]
    np.testing.assert_allclose(world.pose[0], before[0], atol=0.01)
    flown(world, 1.5, forward)
    assert np.isfinite(world.pose).all() and world.pose[1, 0] > before[1, 0] + 0.1
    assert not world.faults.take()
    if kind != "heron":
        assert world.flights.states()[0] == "motors off" and world.z[1] > 0.9
    world.close()


def test_commands_that_are_no_numbers_are_refused_and_counted():
    world = pair("dynamic")
    world.set_commands([0], np.array([[np.nan, 0.0, 0.0, 0.0]]))
    world.step()
    assert world.commands.refused.tolist() == [1, 0] and world.z[0] == pytest.approx(1.0, abs=1e-3)


# Runs and verdicts -----------------------------------------------------------------------------------


def gathering(fidelity):
    """Return a scenario of three Crazyflies at half a metre's height."""
    control = {
        "protocol": "displacement_formation",
        "parameters": {"gain": 0.2, "shape": "circle", "size": 0.6},
    }
    return scenario_from_dict({
        "model": "crazyflie2", "poses": PLACES + [[0.3, 0.8, 0.0]], "altitude": 0.5, "control": control,
        "topology": {"preset": "complete"}, "duration": 9.0, "fidelity": fidelity, "record_rate": 20,
    })  # fmt: skip


def test_a_run_tells_what_befell_and_is_judged_until_then(tmp_path):
    scenario = gathering("kinematic").changed(events=[dict(LOST, at=6.0)], duration=7.0)
    verdict = run_experiment(scenario, str(tmp_path), formats=())
    facts = json.loads((tmp_path / "run.json").read_text())
    assert facts["incidents"][0] == [pytest.approx(6.0), "robot2", "rotor_lost", 3, True]
    found = {check["name"]: check for check in verdict["checks"]}
    assert found["incidents"]["passed"] is None
    assert "robot2 lost rotor 3 at 6.0 s" in found["incidents"]["note"]
    assert verdict["outcome"] == NOT_JUDGED and "the law is confirmed" in verdict["reason"]
    assert not any(check["passed"] is False for check in verdict["checks"])
    assert any(
        "until robot2 lost rotor 3 at 6.0 s" in str(check["note"]) for check in found.values()
    )
    run = read_run_csv(str(tmp_path / "run.csv"), scenario)
    assert run.meta["incidents"][0].text == "robot2 lost rotor 3"


def test_robots_take_off_before_their_law_begins(tmp_path):
    scenario = gathering("dynamic").changed(takeoff=True, duration=4.5)
    assert scenario_from_dict(scenario.to_dict()).takeoff
    verdict = verdict_of(scenario, tmp_path)
    assert verdict["passed"], verdict["checks"]
    run = read_run_csv(str(tmp_path / "run.csv"), scenario)
    assert run.time[0] == 0.0
    np.testing.assert_allclose(run.spatial.z[0], scenario.altitude, atol=0.02)
    with pytest.raises(ScenarioError, match="takeoff: true, but no robot has an altitude"):
        scenario_from_dict({"poses": [[0, 0, 0]], "takeoff": True})


# Contact ---------------------------------------------------------------------------------------------


def test_two_that_fly_into_each_other_touch_and_are_reported():
    world = World(
        ("crazyflie2",) * 2, [[0.0, 0.0, 0.0], [0.8, 0.0, 0.0]], z=[1.0, 1.0], fidelity="dynamic"
    )
    flown(world, 1.6, np.array([[0.5, 0.0, 0.0, 0.0], [-0.5, 0.0, 0.0, 0.0]]))
    first = world.contacts.take()[0]
    assert (first.first, first.second) == ("robot1", "robot2")
    assert (first.x, first.y, first.z) == pytest.approx((0.4, 0.0, 1.01), abs=0.03)
    assert np.diff(world.pose[:, 0]) > 0.11  # bodies of 6 cm radius
    # Momentum is kept: equal masses stay about their middle.
    assert world.pose[:, 0].mean() == pytest.approx(0.4, abs=0.01)
    world.close()


def test_one_flown_onto_the_floor_rests_on_it():
    world = World(("crazyflie2",), [[0.0, 0.0, 0.0]], z=[0.5], fidelity="dynamic")
    flown(world, 1.5, [0.0, 0.0, -1.0, 0.0])
    assert world.z[0] == 0.0 and np.abs(world.twist).max() < 1e-6
    assert not world.contacts.take()
    world.close()


def test_one_flown_into_a_wall_stops_there_and_over_it_does_not():
    from mrs_simulator.scenario.surroundings.obstacles import Box

    wall = Box("wall", 1.0, 0.0, 0.0, 0.1, 4.0, 2.0)
    kinds, places = ("crazyflie2",) * 2, [[0.3, 0.0, 0.0], [0.3, 1.0, 0.0]]
    world = World(kinds, places, obstacles=[wall], z=[1.0, 2.3], fidelity="dynamic")
    flown(world, 2.0, [0.4, 0.0, 0.0, 0.0])
    found = {(each.first, each.second) for each in world.contacts.take()}
    assert found == {("robot1", "wall")}
    assert world.pose[0, 0] < 0.95 and world.pose[1, 0] > 0.95
    world.close()


def test_without_a_robot_near_no_solver_is_needed():
    world = pair("dynamic")
    flown(world, 0.5, [0.0, 0.0, 0.1, 0.0])
    (flight,) = world.motion._aloft.values()
    assert flight._touching._client is None


def test_a_body_that_tumbles_freely_gains_no_energy():
    world = World(("crazyflie2",), [[0.0, 0.0, 0.0]], z=[60.0], fidelity="dynamic")
    world.flights.cut_motors([0], falls=True)
    (part,) = world.motion._aloft.values()
    part._inner.flight.rates[0] = [40.0, 3.0, 60.0]
    part._inner.flight.rotors[:] = 0.0
    inertia = np.array([1.4e-5, 1.4e-5, 2.17e-5])

    def energy():
        return float(inertia @ part._inner.flight.rates[0] ** 2)

    before = energy()
    flown(world, 2.0)
    assert 0.5 * before < energy() <= before * (1.0 + 1e-9)
