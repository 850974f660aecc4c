"""Runs that were not recorded in lockstep: their delay, and commands judged in spite of it."""

import numpy as np
import pytest
from protocol_fixtures import check, shipped

from mrs_simulator.protocols import shipped as law_of
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import Experiment, perform
from mrs_simulator.verdict.judging import judged
from mrs_simulator.verdict.law.late_commands import late_commands

COMMANDS = "commands off the published law"


def sizes(row, command):
    return np.abs(command).sum(axis=1)


def decay(time, rate=1.0):
    return np.exp(-rate * time)[:, np.newaxis, np.newaxis] * np.ones((1, 2, 1))


def test_a_delay_is_found_and_costs_nothing():
    time = 0.1 * np.arange(60)
    found = late_commands(time, decay(time), decay(time - 0.25), sizes, 0.05)
    assert found.delay == pytest.approx(0.25, abs=0.011) and found.error < 1e-6
    # 20 % less cannot be a delay: that would be of -0.22 s.
    weak = late_commands(time, decay(time), 0.8 * decay(time), sizes, 0.05)
    assert weak.delay < 0.02 and weak.error > 0.1


def test_single_messages_may_be_late_and_stopped_robots_are_left_out():
    time = 0.1 * np.arange(100)
    recorded = decay(time)
    recorded[50] = recorded[30]
    recorded[60:70] = 0.0  # the controller was stopped
    assert late_commands(time, decay(time), recorded, sizes, 0.05).error < 0.01
    recorded[:10] *= 0.8  # at the start, where most is wanted
    assert late_commands(time, decay(time), recorded, sizes, 0.05).error > 0.05
    assert late_commands(time, decay(time), 0.0 * recorded, sizes, 0.05) is None


def recorded(name, protocol=None, late=7, **changes):
    """Return a run of a shipped scenario whose commands are ``late`` periods behind, each fifth sample."""
    scenario = shipped(name, duration=12.0)._replace(**changes)
    experiment = Experiment(scenario._replace(record_rate=scenario.control.rate), protocol)
    time, pose, command = (np.array(each) for each in zip(*experiment.samples()))
    control = make_control(scenario)
    rows = np.arange(late, len(time), 5)
    robots, hand = np.arange(1, scenario.n + 1), control.points(pose)
    at = time[rows] - time[rows[0]]
    run = Run(at, robots, pose[rows], hand[rows], command[rows - late], [], scenario, {})
    return run, control


def test_robots_over_ros_are_judged_by_their_commands():
    verdict, _ = judged(*recorded("displacement_formation"))
    found = check(verdict, COMMANDS)
    assert found["passed"] and found["measured"] < 0.01 and found["tolerance"] == 0.03
    assert verdict["command_delay"] == pytest.approx(0.14, abs=0.02)


def test_a_weak_law_over_ros_is_noticed():
    class Weak(law_of("displacement_formation")):
        def pointMassLaw(self, hand):
            return 0.8 * super().pointMassLaw(hand)

    run, _ = recorded("displacement_formation", Weak)
    verdict, _ = judged(run, make_control(run.scenario))
    assert check(verdict, COMMANDS)["passed"] is False and verdict["outcome"] == "failed"


def test_a_law_with_a_memory_is_not_judged_so_and_the_line_says_why():
    verdict, _ = judged(*recorded("flocking"))
    found = check(verdict, COMMANDS)
    assert found["passed"] is None and "memory" in found["note"]


def test_data_that_cannot_be_fail_all_the_same():
    run, control = recorded("displacement_formation")
    run.pose[50:, 2, 0] += 5.0
    run.hand[50:, 2, 0] += 5.0
    verdict, _ = judged(run, control)
    assert verdict["outcome"] == "failed" and check(verdict, "no robot jumps")["passed"] is False


DRIFTING = {
    "poses": [[2.0, 0.0, 0.5], [-1.0, 1.7, 3.0], [-1.0, -1.7, -2.0]],
    "odometry": "wheel",
    "odometry_errors": {"alpha": [0.02, 0.0, 0.0, 0.02, 0.004, 0.004]},
    "control": {"protocol": "displacement_formation", "parameters": {"shape": "circle", "size": 3.0}},
    "topology": {"preset": "ring"},
    "duration": 4.0,
}  # fmt: skip


@pytest.mark.parametrize("lockstep", (True, False))
def test_drift_of_odometry_is_not_taken_for_another_law(tmp_path, lockstep):
    """Where nobody recorded what it told, that cannot be known; where somebody did, it costs nothing."""

    def judged_with(**more):
        scenario = scenario_from_dict(dict(DRIFTING, **more))
        out = str(tmp_path / "-".join(["run", *more]))
        run, control = perform(scenario, out)
        run = run._replace(meta=dict(run.meta, lockstep=lockstep))
        return check(judged(run, control)[0], COMMANDS), run, control

    unknown, run, control = judged_with()
    assert unknown["passed"] is None and "wanted estimates: odometry" in unknown["note"]
    real = run._replace(
        meta=dict(run.meta, collisions_unknown=True)
    )  # whose poses are what was told
    assert lockstep or check(judged(real, control)[0], COMMANDS)["passed"] is False
    told, run, control = judged_with(estimates="odometry")
    assert told["passed"] and told["tolerance"] == (1e-6 if lockstep else 0.05)
    weak = run._replace(command=0.8 * run.command)
    assert not check(judged(weak, control)[0], COMMANDS)["passed"]
