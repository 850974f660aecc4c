"""Laws of points in space on robots that fly: from the scenario to the verdict."""

import numpy as np
import pytest

from mrs_simulator import PioneerControl
from mrs_simulator.protocols.loading import ProtocolError
from mrs_simulator.protocols.making import make_control
from mrs_simulator.protocols.published.drives import Quadrotors
from mrs_simulator.protocols.shapes.law import DisplacementFormation
from mrs_simulator.record.recording import closest_approach, read_run_csv
from mrs_simulator.scenario.scenario import ScenarioError, scenario_from_dict
from mrs_simulator.study.run.experiment import Experiment, run_experiment
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.team_in_space import TeamInSpace

N = 3
CUBE = {"gain": 0.25, "shape": "grid", "size": 1.0}


def team_of_three(protocol="displacement_formation", dimension=3, parameters=None, **more):
    control = {"protocol": protocol, "rate": 10, "parameters": parameters or CUBE}
    if dimension:
        control["dimension"] = dimension
    content = {
        "model": "crazyflie2",
        "poses": [[0.0, 0.0, 0.3], [2.0, 0.5, -1.0], [0.5, 2.0, 2.0]],
        "altitude": [0.8, 1.5, 2.0],
        "control": control,
        "topology": {"preset": "complete"},
        "duration": 8.0,
        "step": 0.1,
    }
    return scenario_from_dict(dict(content, **more))


def verdict_of(scenario, out, protocol=None, formats=()):
    return run_experiment(scenario, str(out), protocol, formats=formats)


@pytest.mark.parametrize("fidelity", ["point_mass", "kinematic", "dynamic"])
def test_theory_of_space_holds_on_robots(fidelity, tmp_path):
    scenario = team_of_three()._replace(fidelity=fidelity)
    verdict = verdict_of(scenario, tmp_path, formats=("svg",) if fidelity == "kinematic" else ())
    assert verdict["outcome"] == "passed", verdict["checks"]
    run = read_run_csv(str(tmp_path / "run.csv"), scenario).in_space(3)
    assert np.ptp(run.hand[:, :, 2], axis=0).min() > 0.05  # they climb or sink
    if fidelity == "kinematic":
        drawn = {path.stem for path in tmp_path.glob("*.svg")}
        assert {"z_states", "trajectories_in_space"} <= drawn


class Lazy(DisplacementFormation):
    """Climbs half as fast as it should."""

    def pointMassLaw(self, hand):
        return super().pointMassLaw(hand) * [1.0, 1.0, 0.5]


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_a_law_that_is_wrong_in_height_alone_fails(fidelity, tmp_path):
    scenario = team_of_three(duration=2.0)._replace(fidelity=fidelity)
    verdict = verdict_of(scenario, tmp_path, Lazy)
    wrong = [check["name"] for check in verdict["checks"] if check["passed"] is False]
    assert verdict["outcome"] == "failed" and "commands off the published law [-]" in wrong


def test_a_law_of_the_plane_stays_at_its_altitude():
    scenario = team_of_three(dimension=None)
    experiment = Experiment(scenario)
    for _ in experiment.samples():
        pass
    np.testing.assert_array_equal(experiment.world.z, scenario.altitude)
    assert experiment.control.dimension == 2
    assert "dimension" not in scenario.control.to_plain()


def test_a_scenario_says_the_dimension():
    scenario = team_of_three()
    again = scenario_from_dict(scenario.to_dict())
    assert again.control.dimension == 3 and make_control(again).dimension == 3
    np.testing.assert_array_equal(again.starts[:, 3], [0.8, 1.5, 2.0])
    with pytest.raises(
        ScenarioError, match="control.dimension: 4, wanted a whole number from 2 to 3"
    ):
        team_of_three(dimension=4)


def test_robots_on_the_ground_have_no_law_of_space():
    scenario = team_of_three(model="pioneer3dx", altitude=0.0)
    text = "control.dimension: 3, but robot1, a Pioneer 3-DX, stays at its height; wanted 2"
    with pytest.raises((ProtocolError, ValueError), match=text):
        make_control(scenario)


def test_a_protocol_for_space_alone_needs_no_dimension():
    class Up(PioneerControl):
        DIMENSIONS = (3,)

        def pointMassLaw(self, points):
            return np.tile([0.0, 0.0, 0.2], (len(points), 1))

    control = make_control(team_of_three(dimension=None, parameters={"l": 0.1}), Up)
    command = control.commands(team_of_three().starts)
    np.testing.assert_array_equal(command, [[0.0, 0.0, 0.2, 0.0]] * N)


def test_points_and_commands_are_each_others_inverse():
    team, draw = TeamInSpace(("crazyflie2", "ardrone2"), "firmware"), np.random.default_rng(1)
    pose, wanted, joints = draw.normal(size=(2, 4)), draw.normal(size=(2, 3)), np.zeros(2)
    np.testing.assert_array_equal(team.point(pose, joints, 0.1), pose[:, [0, 1, 3]])
    command = team.command(wanted, pose, joints, 0.1, 0.02)
    np.testing.assert_allclose(team.velocity(command, pose, joints, 0.1, 0.02), wanted, atol=1e-12)
    points = np.zeros((1, 2, 3))
    found = team.velocities_in(command[None], pose[None, :, :3], points, 0.1, 0.02)
    np.testing.assert_allclose(found[0], wanted, atol=1e-12)


def test_a_law_of_neighbours_is_that_of_the_points():
    class Agree(PioneerControl):
        DIMENSIONS = (2, 3)

        def neighbourLaw(self, robot, theta, neighbours):
            return sum(each.weight * np.array([each.x, each.y, each.z]) for each in neighbours)

    class Turned(Agree):
        LOCAL_FRAMES = True

    scenario = team_of_three("consensus", parameters={"gain": 1.0})
    wanted = make_control(scenario).commands(scenario.starts)
    for law in (Agree, Turned):
        found = make_control(scenario, law).commands(scenario.starts)
        np.testing.assert_allclose(found, wanted, atol=1e-12)


def test_the_hook_meets_heights_and_its_default_maps_them():
    class Seen(DisplacementFormation):
        def calculateControlLaw(self, pos_map):
            self.heights = [pos_map[number].z for number in self.numbers]
            return super().calculateControlLaw(pos_map)

    scenario = team_of_three()
    control = make_control(scenario, Seen)
    control.set_parameters(CUBE)
    command = control.commands(scenario.starts)
    assert control.heights == [0.8, 1.5, 2.0]
    np.testing.assert_array_equal(command, make_control(scenario).commands(scenario.starts))


def test_climbing_is_stated_twice():
    """The published motion of quadrotors is that of the world, also at the greatest climb and sink."""
    team = Team(("crazyflie2", "ardrone2"), "top")
    group, other = team.groups[0], Quadrotors(team.groups[0], 0.1, 0.1)
    inner = group.drive.begin(np.zeros((2, 3)), np.array([50.0, 60.0]), group.numbers)
    other.be(np.zeros(2, dtype=complex), np.zeros(2), None)
    other.begin_at(np.array([50.0, 60.0]))
    for climb in (1.0, -0.7, 0.3):
        command = np.tile([0.5, -0.2, climb, 0.1], (2, 1))
        for _ in range(4):
            inner = group.drive.flown(inner, command, group.limits, group.numbers, 0.1)
            other.move(command, 0.1)
        np.testing.assert_allclose(other.height, inner.place[:, 2], rtol=1e-9)
        np.testing.assert_allclose(other.rise, inner.velocity[:, 2], rtol=1e-9)


def test_robots_above_each_other_are_apart():
    pose = np.zeros((1, 2, 3))
    assert closest_approach(pose) == 0.0
    assert closest_approach(pose, np.array([[1.0, 2.5]])) == 1.5


def test_delayed_edges_carry_heights():
    links = {"delay": 0.2}
    scenario = team_of_three("consensus", parameters={"gain": 0.3}, links=links, duration=2.0)
    scenario = scenario._replace(fidelity="point_mass")
    experiment = Experiment(scenario)
    for _ in experiment.samples():
        pass
    assert np.ptp(experiment.world.z) < 0.8 < np.ptp(scenario.altitude)
