"""Robots that fly: how they stop, what fences hold them, and how far apart the safety filter keeps them."""

import numpy as np
import pytest

from mrs_simulator.control.guards import Violations, checked_fence, outside, pairs_nearer
from mrs_simulator.control.safety.bounds import Surroundings
from mrs_simulator.control.safety.nearest_velocities import safe_velocities
from mrs_simulator.nodes.control.command_gate import AGAIN, CommandGate
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.surroundings.obstacles import Box
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.vehicles import Team
from mrs_simulator.world.world import EVERY, World

TEAM = Team(("crazyflie2", "pioneer3dx"))


class Topics:
    def __init__(self):
        self.published = []

    def publish(self, command, answered=None):
        self.published.append(command.tolist())


def test_the_emergency_stop_lands_and_pressed_again_still_lands():
    now, topics = [0.0], Topics()
    gate = CommandGate(topics, 2, clock=lambda: now[0], axes=TEAM.axes, landing=TEAM.landing)
    landing, hover = TEAM.landing.tolist(), np.zeros_like(TEAM.landing).tolist()
    assert landing[0][TEAM.axes.index("linear.z")] == -0.3 and not any(landing[1])
    flying = np.ones_like(TEAM.landing)
    gate.open()
    gate.send(flying)
    gate.shut()
    assert topics.published == [flying.tolist(), hover]  # a plain stop hovers
    gate.open()
    for _ in range(2):
        gate.alarm(True)
        assert topics.published[-1] == landing
    gate.open()
    gate.send(flying)
    assert topics.published[-1] == landing
    count = len(topics.published)
    for _ in range(100):
        now[0] += 1.5 * AGAIN
        gate.insist()
    assert topics.published[count:] == [landing] * 100
    gate.alarm(False)
    gate.send(flying)
    assert topics.published[-1] == hover  # who is still in the air waits for a start


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_landing_ends_on_the_ground_and_stays_there(fidelity):
    world = World(("crazyflie2",), [[0.0, 0.0, 0.5]], z=[0.3], fidelity=fidelity)
    for _ in range(150):
        world.set_commands(EVERY, world.team.landing)
        world.step()
        assert world.z[0] >= 0.0
    assert world.z[0] == 0.0 and abs(world.pose[0, :2]).max() < 1e-3


def test_a_fence_has_a_ceiling():
    fence = checked_fence((-1.0, -1.0, 1.0, 1.0, 0.2, 2.0))
    pose = np.array([[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 2.5], [0.0, 0.0, 0.0, 0.1]])
    assert outside(pose, fence) == [1, 2] and outside(pose[:, :3], fence) == []
    with pytest.raises(ValueError, match="z_min < z_max"):
        checked_fence((0.0, 0.0, 1.0, 1.0, 2.0, 2.0))
    said = Violations((1, 2, 3), fence, 0.0).causes(pose)
    assert said[1] == "outside the geofence at (0.00, 0.00, 2.50)"


def test_distances_count_heights():
    pose = np.array([[0.0, 0.0, 0.0, 1.0], [0.0, 0.3, 0.0, 1.4]])
    assert pairs_nearer(pose[:, :3], 0.4) == [(0, 1, 0.3)] and pairs_nearer(pose, 0.4) == []
    assert pairs_nearer(pose, 0.6)[0][2] == pytest.approx(0.5)


# The safety filter ---------------------------------------------------------------------------------


def swapping(safety, **more):
    """Return the scenario of four robots that change places through one point, two straight up and down."""
    content = {
        "model": "crazyflie2",
        "poses": [[-1.0, 0.0, 0.0], [1.0, 0.05, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
        "altitude": [1.6, 1.6, 0.4, 2.8],
        "control": {"protocol": "consensus", "dimension": 3, "rate": 20, "safety": safety},
        "topology": {"preset": "complete"},
        "duration": 3.5,
        "step": 0.05,
    }
    content["control"]["parameters"] = {"gain": 0.2}
    return scenario_from_dict(dict(content, **more))


CAPPED = {"obstacles": True, "speed": 0.25}


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_flying_robots_keep_an_ellipsoid_apart(fidelity, tmp_path):
    scenario = swapping(CAPPED, fidelity=fidelity)
    verdict = run_experiment(scenario, str(tmp_path), formats=())
    kept = [c for c in verdict["checks"] if c["name"].startswith("least distance")]
    assert len(kept) == 1 and kept[0]["passed"] is True and "2.5 times" in kept[0]["name"]
    assert next(c for c in verdict["checks"] if c["name"] == "collisions")["passed"]
    if fidelity == "dynamic":
        return
    unsafe = run_experiment(swapping(False, fidelity=fidelity), str(tmp_path), formats=())
    assert not next(c for c in unsafe["checks"] if c["name"] == "collisions")["passed"]


def test_no_pair_gets_into_the_ellipsoid():
    draw = np.random.default_rng(2)
    squash, distance, period = np.array([1.0, 1.0, 0.4]), 0.5, 0.1
    checked = 0
    for _ in range(40):
        points = draw.uniform(-1.0, 1.0, (5, 3))
        apart = points[:, None] - points
        size = np.linalg.norm(apart * squash, axis=2)[np.triu_indices(5, 1)]
        if size.min() < distance:
            continue
        wanted = draw.normal(0.0, 2.0, (5, 3))
        given = safe_velocities(wanted, points, distance, period, squash=squash)
        after = (points + period * given) * squash
        size = np.linalg.norm(after[:, None] - after, axis=2)[np.triu_indices(5, 1)]
        assert size.min() > distance - 1e-6
        checked += 1
    assert checked > 5


def test_the_tracking_error_is_what_a_stop_takes():
    """Closed form: from v the velocity falls by A a second down to A T, from there on exponentially."""
    numbers = TEAM.groups[0].numbers
    time, most = 1.0 / 4.0 + 1.0 / 10.0, 9.81 * np.tan(np.radians(30.0))
    found = TEAM.tracking(np.array([1.0, 0.7]))
    assert found[0] == pytest.approx(1.0 * time) and found[1] == 0.0
    fast = 4.0
    ramp = fast - most * time
    wanted = 0.5 * (fast + most * time) * ramp / most + most * time * time
    assert TEAM.tracking(np.full(2, fast))[0] == pytest.approx(wanted)
    assert numbers.downwash == 2.5 and TEAM.downwash == 2.5


def test_a_robot_flies_over_an_obstacle():
    surroundings = Surroundings((Box("box", 0.0, 0.0, 0.0, 2.0, 2.0, 1.0),), (-5.0, -5.0, 5.0, 5.0))
    points = np.array(
        [[0.0, 0.0, 1.5], [2.0, 0.0, 0.5], [2.0, 0.0, 2.0], [0.9, 0.0, 0.5], [0, 0, 0.9]]
    )
    bounds = surroundings.bounds(points, np.full(5, 0.1))
    np.testing.assert_allclose(
        bounds.gap[:5], [0.4, 0.9, np.sqrt(2.0) - 0.1, -0.2, -0.2], atol=1e-9
    )
    half = np.sqrt(0.5)
    out = [[0, 0, 1], [1, 0, 0], [half, 0, half], [1, 0, 0], [0, 0, 1]]
    np.testing.assert_allclose(bounds.way_out[:5], out, atol=1e-9)
    assert bounds.way_out.shape == (25, 3)


def test_the_filter_of_a_planar_team_is_the_planar_one():
    scenario = scenario_from_dict(
        {"poses": [[0, 0, 0], [2, 0, 0]], "control": {"protocol": "consensus", "safety": True}}
    )
    control = make_control(scenario)
    assert control.safety_filter.squash is None
    # Of two Pioneers whose point lies 0.05 m ahead, and which follow at once: their farthest corners.
    apart = 2.0 * (np.hypot(0.301, 0.2125) + 0.05)
    assert control.safety_filter.distance == pytest.approx(apart, rel=1e-12)
