"""Vessels in the world: current, wind, waves, contacts, and other robots beside them."""

import numpy as np
import pytest
from protocol_fixtures import check, shipped, verdict_of

from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.surroundings.environment import CALM, Environment
from mrs_simulator.vehicles import Team
from mrs_simulator.world.world import EVERY, World

# The air goes with the water: a boat that is carried feels no wind.
CURRENT = Environment(current=(0.3, -0.1), wind=(0.3, -0.1))
AFLOAT = ("kinematic", "dynamic", "point_mass")


def sailed(world, command, duration):
    """Step ``world`` for ``duration`` [s] under one ``command`` (n, axes); return the poses."""
    for _ in range(int(round(duration / world.step_size))):
        world.set_commands(EVERY, np.array(command))
        world.step()
    return world.pose


def test_a_boat_without_forces_follows_and_is_carried():
    world = World(("heron",), [[0.0, 0.0, 0.0]], environment=CURRENT)
    # 1 m/s with the time constant of its controller, 48/56.45 s: 10 - 0.8503 m through the water.
    pose = sailed(world, [[1.0, 0.0]], 10.0)
    np.testing.assert_allclose(pose[0], [9.1497 + 3.0, -1.0, 0.0], atol=1e-3)
    np.testing.assert_allclose(world.twist[0], [1.3, -0.1, 0.0], atol=1e-4)


@pytest.mark.parametrize("fidelity", AFLOAT)
def test_a_boat_at_rest_in_the_water_goes_with_it(fidelity):
    world = World(
        ("heron", "otter"),
        [[0.0, 0.0, 1.0], [9.0, 0.0, 0.0]],
        fidelity=fidelity,
        environment=CURRENT,
    )
    for _ in range(100):
        world.step()
    moved = world.pose - [[0.0, 0.0, 1.0], [9.0, 0.0, 0.0]]
    np.testing.assert_allclose(moved, [[0.6, -0.2, 0.0]] * 2, atol=1e-9)
    speed = np.hypot(*world.twist[:, :2].T)
    if fidelity != "point_mass":
        np.testing.assert_allclose(speed, np.hypot(0.3, 0.1), atol=1e-9)


@pytest.mark.parametrize("fidelity", AFLOAT)
def test_keeping_station_in_proportion_leaves_an_offset(fidelity):
    """``u = -k p`` of the point rests V/k downstream: 0.2/0.25 = 0.8 m."""
    environment = Environment(current=(0.2, 0.0))
    kinds = "heron", "otter", "wamv"
    poses = [[-8.0, 20.0 * row + 1.0, 3.0] for row in range(len(kinds))]
    world = World(kinds, poses, fidelity=fidelity, environment=environment, limits="firmware")
    team, stations = Team(kinds), [[0.0, 20.0 * row] for row in range(len(kinds))]
    for _ in range(3000):
        u = -0.25 * (team.point(world.pose, world.joints, 0.05) - stations)
        world.set_commands(EVERY, team.command(u, world.pose, world.joints, 0.05, 0.02))
        world.step()
    off = team.point(world.pose, world.joints, 0.05) - stations
    # The speed's controller has an integral, which the Heron's waits long for.
    wanted = np.tile([0.8, 0.0], (len(kinds), 1))
    np.testing.assert_allclose(off, wanted, atol=0.03 if fidelity == "dynamic" else 5e-3)
    if fidelity != "point_mass":
        # With the bow upstream.
        assert (np.abs(np.cos(world.pose[:, 2]) + 1.0) < 1e-3).all()


def test_weather_is_the_seeds():
    environment = Environment((0.0, 0.0), (4.0, 1.0), 1.0, 2.0, 0.2, 4.0)
    poses = [[0.0, 0.0, 0.5], [9.0, 0.0, 0.5]]

    def drift(seed, count=2):
        world = World(("wamv",) * count, poses[:count], fidelity="dynamic", seed=seed,
                      environment=environment)  # fmt: skip
        for _ in range(200):
            world.step()
        return world.pose.copy()

    first = drift(1)
    np.testing.assert_array_equal(first, drift(1))
    assert np.abs(first - drift(2)).max() > 1e-4
    # Each robot has weather of its own, whoever is beside it.
    np.testing.assert_allclose(drift(1, 1)[0], first[0], rtol=1e-12)
    assert np.abs((first - poses)[0] - (first - poses)[1]).max() > 1e-4
    assert (first[:, 0] > np.array(poses)[:, 0]).all()


def test_waves_do_nothing_on_average():
    environment = Environment(wave_height=0.3, wave_period=3.0)
    world = World(("heron",) * 5, [[3.0 * i, 0.0, 0.0] for i in range(5)], fidelity="dynamic",
                  environment=environment)  # fmt: skip
    aside = []
    for _ in range(1200):
        world.step()
        aside.append(world.twist[:, 1].copy())
    # 6 N of force aside on 28 kg at 2.09 rad/s and 15.8 N s/m: some 0.1 m/s.
    assert 0.04 < np.std(aside) < 0.2
    assert abs(np.mean(aside)) < 0.01


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_boats_give_way_to_each_other_and_to_obstacles(fidelity):
    world = World(("heron",) * 2, [[0.0, 0.0, 0.0], [4.0, 0.2, np.pi]], fidelity=fidelity)
    pose = sailed(world, [[1.0, 0.0]] * 2, 8.0)
    assert pose[1, 0] - pose[0, 0] > 1.34
    assert [(each.first, each.second) for each in world.contacts.take()][:1] == [
        ("robot1", "robot2")
    ]
    assert (np.abs(world.twist[:, 0]) < 0.3).all()


@pytest.mark.parametrize("fidelity", ["kinematic", "point_mass"])
def test_no_current_carries_a_robot_on_the_shore(fidelity):
    world = World(
        ("pioneer3dx", "heron"), [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]], fidelity=fidelity,
        environment=CURRENT,
    )  # fmt: skip
    for _ in range(50):
        world.step()
    np.testing.assert_allclose(world.pose[0], 0.0)
    np.testing.assert_allclose(world.pose[1], [5.3, -0.1, 0.0], atol=1e-9)


def test_a_mirrored_boat_is_where_it_is_put():
    for fidelity in AFLOAT:
        world = World(("heron",) * 2, [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]], fidelity=fidelity,
                      environment=CURRENT, mirrored=(1,))  # fmt: skip
        for _ in range(10):
            world.step()
        np.testing.assert_allclose(world.pose[1], [5.0, 0.0, 0.0])
        assert world.pose[0, 0] > 0.05


def test_the_log_does_not_see_the_current():
    for fidelity in ("kinematic", "dynamic"):
        world = World(("otter",), [[0.0, 0.0, 0.0]], fidelity=fidelity, environment=CURRENT,
                      odometry_kind="wheel")  # fmt: skip
        sailed(world, [[1.0, 0.0]], 10.0)
        through = world.pose[0, :2] - [3.0, -1.0]
        np.testing.assert_allclose(world.estimates.pose()[0, :2], through, atol=0.1)


def test_limits_none_answers_at_once_without_forces_alone():
    world = World(("heron",), [[0.0, 0.0, 0.0]], limits=None)
    np.testing.assert_allclose(sailed(world, [[2.0, 0.0]], 1.0)[0], [2.0, 0.0, 0.0], atol=1e-9)
    world = World(("heron",), [[0.0, 0.0, 0.0]], limits=None, fidelity="dynamic")
    assert sailed(world, [[2.0, 0.0]], 1.0)[0, 0] < 1.5


def test_a_scenario_tells_current_wind_and_waves():
    content = {
        "model": "heron",
        "poses": [[0, 0, 0]],
        "environment": {
            "current": [0.2, -0.1],
            "wind": {"velocity": [4, 0], "gusts": 1.5},
            "waves": {"height": 0.3},
        },
    }
    scenario = scenario_from_dict(content)
    assert scenario.environment == Environment((0.2, -0.1), (4.0, 0.0), 1.5, 2.0, 0.3, 4.0)
    assert scenario_from_dict(scenario.to_dict()).environment == scenario.environment
    calm = scenario_from_dict({"model": "heron", "poses": [[0, 0, 0]]})
    assert calm.environment == CALM
    assert "environment" not in calm.to_dict()
    world = World.from_scenario(scenario)
    world.step()
    np.testing.assert_allclose(world.pose[0], [0.004, -0.002, 0.0], atol=1e-12)


@pytest.mark.parametrize(
    "environment, error",
    [
        ({"current": [1, 2, 3]}, "environment.current"),
        ({"current": [30, 0]}, "at most 20 m/s"),
        ({"curent": [0, 0]}, "curent"),
        ({"wind": {"gusts": 1.0}}, "without wind"),
        ({"waves": {"height": -1}}, "environment.waves.height"),
        ({"waves": {"period": 0}}, "environment.waves.period"),
    ],
)
def test_what_no_environment_is(environment, error):
    with pytest.raises(ScenarioError, match=error):
        scenario_from_dict({"poses": [[0, 0, 0]], "environment": environment})


def test_a_recording_has_the_point_ahead_of_the_bow(tmp_path):
    verdict = verdict_of(shipped("formation_boats", duration=1.0), tmp_path)
    run = read_run_csv(str(tmp_path / "run.csv"))
    pose, point = run.pose[0], run.hand[0]
    np.testing.assert_allclose(np.hypot(*(point - pose[:, :2]).T), 0.725, atol=1e-9)
    assert check(verdict, "commands off the published law [-]")["passed"]


def test_no_theory_of_still_water_applies_in_a_current(tmp_path):
    environment = {"current": [0.1, 0.0]}
    verdict = verdict_of(
        shipped("formation_boats", duration=2.0, environment=environment), tmp_path
    )
    told = check(verdict, "worst displacement error at the end [m]")
    assert told["passed"] is None
    assert "the current carries the robots" in told["note"]
