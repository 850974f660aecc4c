"""Hand points too near the axle: the warning, and the headings that swing."""

import numpy as np
import pytest

from mrs_simulator import PioneerControl
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.vehicles import Team

ANGLES = np.radians([20.0, 60.0, 150.0])
FAR = 1e4  # [m]


class Away(PioneerControl):
    """Sends hand points far along the x axis."""

    def pointMassLaw(self, hand):
        return 0.3 * (np.array([FAR, 0.0]) - hand)


def free(length, rate=10.0, model="pioneer3dx", **values):
    """Return the scenario of robots without others near, by ``l`` and commands at ``rate``."""
    poses = np.column_stack([np.zeros(3), 50.0 * np.arange(3), ANGLES])
    control = {"rate": rate, "parameters": {"l": length}, **values.pop("control", {})}
    given = {"limits": "firmware", "duration": 40.0, **values}
    return scenario_from_dict(
        {"model": [model] * 3, "poses": poses.tolist(), "control": control, **given}
    )


def swing(scenario):
    """Return the largest heading [rad] of the last 10 s."""
    experiment = Experiment(scenario, Away)
    pose = np.array([pose for _, pose, _ in experiment.samples()])
    experiment.world.close()
    return np.abs(np.sin(pose[-len(pose) // 4 :, :, 2])).max()


@pytest.mark.parametrize("model, rate", [("pioneer3dx", 10.0), ("amigobot", 5.0)])
def test_headings_swing_where_the_run_warns_and_settle_where_it_does_not(model, rate):
    top = Team([model], "firmware").speeds[0, 0]
    for share, swings in ((0.9, True), (1.01, False)):
        scenario = free(share * top / rate, rate, model)
        assert bool(make_control(scenario, Away).foreseen) == swings
        assert (swing(scenario) > 0.7) == swings and (swing(scenario) < 0.02) != swings


def test_wheels_that_speed_up_no_faster_than_they_grip_swing_where_the_run_warns():
    limits = {"v_max": 1.5, "omega_max": 6.2832}  # without ramps
    for share, swings in ((0.6, True), (1.01, False)):
        scenario = free(share * 0.15, fidelity="dynamic", limits=limits, duration=9.0)
        assert bool(make_control(scenario, Away).foreseen) == swings
        assert make_control(scenario.changed(fidelity="kinematic"), Away).foreseen == []
        assert (swing(scenario) > 0.5) == swings and (swing(scenario) < 0.03) != swings


def test_the_warning_says_which_length_and_rate_would_do():
    scenario = free(0.05)
    (text,) = Experiment(scenario, Away).warnings
    assert "robot1" in text and "0.075 m or more, or 15 Hz or more" in text
    for mended in (free(0.075), free(0.05, rate=15.0)):
        assert Experiment(mended, Away).warnings == []


def test_a_capped_speed_no_ramps_and_laws_that_give_twists_are_not_warned_of():
    class Turning(PioneerControl):
        def calculateControlLaw(self, pos_map):
            return np.zeros((3, 2))

    capped = free(0.05, control={"safety": {"speed": 0.4}})
    assert make_control(capped, Away).foreseen == []
    assert make_control(free(0.05, limits={"v_max": 0.75, "omega_max": 2.0}), Away).foreseen == []
    assert make_control(free(0.05, fidelity="point_mass", limits=None), Away).foreseen == []
    assert make_control(free(0.05), Turning).foreseen == []
    assert make_control(free(0.05), Away).foreseen != []
