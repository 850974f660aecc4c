"""Robots beside their simulation: what was made different is found, and a scenario takes it."""

import json

import numpy as np
import pytest

from mrs_simulator.record.recording import Run, RunError, read_run_csv
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.scenario.team.mismatch import NO_MISMATCH, CommandMismatch, Mismatch
from mrs_simulator.study.results.compare import compared, comparison_text, fit
from mrs_simulator.study.results.report import main as report
from mrs_simulator.study.run.experiment import played, run_experiment
from mrs_simulator.world.world import EVERY, World

TRUE = {"delay": 0.2, "speed": [0.93, 1.04, 1.0, 0.97], "track": [1.06, 0.95, 1.0, 1.02]}
POSES = [[0, 0, 0.3], [0, 4, 1.0], [0, 8, -1.0], [0, 12, 2.0]]


def driven(mismatch=NO_MISMATCH, seconds=40.0, rate=10):
    """Return a run in which robots get commands that change all the time."""
    world = World(("pioneer3dx",) * 4, POSES, mismatch=mismatch, limits="firmware")
    rows, phase = [], np.arange(4)
    for step in range(int(seconds / world.step_size)):
        v = 0.3 + 0.15 * np.sin(0.5 * world.time + phase) + 0.05 * np.sin(2.1 * world.time)
        omega = 0.4 * np.sin(0.7 * world.time + 2.0 * phase)
        world.set_commands(EVERY, np.column_stack([v, omega]))
        if step % int(round(1.0 / (rate * world.step_size))) == 0:
            rows.append((world.time, world.pose.copy(), world.command.copy()))
        world.step()
    time, pose, command = map(np.array, zip(*rows))
    return Run(time, np.arange(1, 5), pose, pose[:, :, :2], command)


def mismatch_of(plain):
    return scenario_from_dict({"poses": POSES, "mismatch": plain}).mismatch


def test_what_was_made_different_is_found():
    found = compared(driven(mismatch_of(TRUE)), driven())
    assert found["mismatch"]["delay"] == pytest.approx(TRUE["delay"], abs=0.02)
    np.testing.assert_allclose(found["mismatch"]["speed"], TRUE["speed"], atol=0.01)
    np.testing.assert_allclose(found["mismatch"]["track"], TRUE["track"], atol=0.01)
    again = compared(driven(mismatch_of(TRUE)), driven(mismatch_of(found["mismatch"])))
    before = max(robot["most_apart"] for robot in found["robots"])
    after = max(robot["most_apart"] for robot in again["robots"])
    assert before > 0.5 and after < 0.1 * before
    assert all(robot["speed_left"][0] < 0.06 for robot in found["robots"])


def test_what_ramps_make_of_commands_is_no_difference_between_robots():
    """One gets sudden commands, the other slow ones: a factor of either alone is far from 1."""
    content = {
        "poses": [[1.5, 1.0, 0.0], [-1.5, -1.0, 0.0]],
        "limits": "firmware",
        "control": {
            "protocol": "displacement_formation",
            "parameters": {"gain": 1.0, "shape": "line", "size": 1.5, "l": 0.4},
        },
        "topology": {"preset": "complete"},
        "duration": 20.0,
    }
    sudden = scenario_from_dict(content)
    lowered = {"preset": "firmware", "v_max": 0.2, "omega_max": 0.5}
    slow = scenario_from_dict(dict(content, limits=lowered, mismatch={"delay": 0.1}))
    found = compared(played(slow)[0], played(sudden)[0])
    assert found["mismatch"]["delay"] == pytest.approx(0.1, abs=0.02)
    np.testing.assert_allclose(found["mismatch"]["speed"], 1.0, atol=0.02)
    np.testing.assert_allclose(found["mismatch"]["track"], 1.0, atol=0.02)


def test_a_dead_robot_is_compared_too():
    dead = mismatch_of({"speed": [1.0, 0.0, 1.0, 1.0]})
    found = compared(driven(dead, seconds=8.0), driven(seconds=8.0))  # nobody touches it
    scale = found["robots"][1]["speed_scale"], found["robots"][1]["speed_scale_error"]
    assert scale == (0.0, 0.0)
    np.testing.assert_allclose(found["mismatch"]["speed"], [1.0, 0.0, 1.0, 1.0], atol=0.01)
    assert "robot2       0.000 +- 0.000" in comparison_text(found)


def test_two_runs_of_the_same_robots_do_not_differ():
    found = compared(driven(), driven())
    assert found["mismatch"] == {"delay": 0.0, "speed": [1.0] * 4, "track": [1.0] * 4}
    assert max(robot["most_apart"] for robot in found["robots"]) == 0.0


def test_what_a_run_does_not_record_is_not_reported():
    run = driven()
    still = run._replace(command=run.command * [1.0, 0.0])
    robots = compared(still, still)["robots"]
    assert [robot["track_scale"] for robot in robots] == [None] * 4
    assert robots[0]["speed_scale"] == 1.0


def test_runs_that_cannot_be_compared_are_refused():
    run = driven(seconds=3.0)
    with pytest.raises(RunError, match="wanted two runs of the same"):
        compared(run, run._replace(robots=np.arange(2, 6)))
    with pytest.raises(RunError, match="at least 10"):
        fit(driven(seconds=0.5))
    with pytest.raises(RunError, match="share no time"):
        compared(run, run._replace(time=run.time + 100.0))


def test_report_compares_two_runs(tmp_path, capsys):
    scenario = load_scenario(scenario_path("paper_four.yaml"))._replace(duration=20.0)
    run_experiment(scenario, str(tmp_path / "simulated"), formats=())
    odd = scenario._replace(mismatch=Mismatch((0.1,), (0.9,), (1.1,)))
    run_experiment(odd, str(tmp_path / "real"), formats=())
    runs = [str(tmp_path / name / "run.csv") for name in ("real", "simulated")]
    report(["--compare", *runs, "--out", str(tmp_path / "out"), "--formats", "png"])
    said = capsys.readouterr().out
    assert "as a scenario takes it: mismatch: {delay: " in said
    found = json.loads((tmp_path / "out" / "compare.json").read_text())
    assert found["robots"][1]["speed_scale"] == pytest.approx(0.9, abs=0.02)
    assert (tmp_path / "out" / "compare.png").stat().st_size > 10000
    again = load_scenario(str(tmp_path / "real" / "scenario.yaml"))
    assert again.mismatch == odd.mismatch and len(read_run_csv(runs[0]).time)
    with pytest.raises(SystemExit) as ended:
        report(["--out", str(tmp_path)])
    assert ended.value.code == 2 and "wanted a run, or --compare" in capsys.readouterr().err


def test_commands_are_obeyed_late_and_by_their_factors():
    mismatch = Mismatch((0.0, 0.04), (1.0, 0.5), (1.0, 2.0))
    obedience = CommandMismatch(mismatch, ("linear.x", "angular.z"), 2, 0.02)
    came = [obedience.applied(np.full((2, 2), float(k))).tolist() for k in range(1, 5)]
    assert [rows[0] for rows in came] == [[k, k] for k in (1.0, 2.0, 3.0, 4.0)]
    assert [rows[1] for rows in came] == [[0.0, 0.0], [0.0, 0.0], [0.5, 0.25], [1.0, 0.5]]


@pytest.mark.parametrize(
    "given, said",
    [
        ({"delay": -1}, "mismatch.delay: -1, wanted a number from 0 to 2"),
        ({"speed": [1, 1]}, r"mismatch.speed: \[1, 1\], wanted a number from 0 to 5, or 4"),
        ({"track": [1, 1, 1, 9]}, r"mismatch.track\[3\]: 9, wanted a number from 0.2 to 5"),
        ({"sped": 1}, "mismatch: unknown 'sped'; did you mean 'speed'"),
        ([], "wanted a mapping"),
    ],
)
def test_impossible_mismatches_are_refused(given, said):
    with pytest.raises(ScenarioError, match=said):
        mismatch_of(given)


def test_a_smaller_team_keeps_its_own_mismatch():
    scenario = scenario_from_dict({"poses": POSES, "mismatch": TRUE})
    assert scenario.with_robots(2).mismatch.speed == (0.93, 1.04)
    assert scenario.with_robots(5).mismatch.speed[4] == 0.97
    poses = scenario.poses[:3].tolist()
    fewer = scenario.changed(robots=3, poses=poses, model=["pioneer3dx"] * 3)
    assert fewer.mismatch.track == (1.06, 0.95, 1.0)


def test_robots_that_go_sideways_are_compared_by_what_they_do_ahead():
    plain = driven()
    command = np.insert(plain.command, 1, 0.7, axis=2)
    other = plain._replace(command=command, axes=("linear.x", "linear.y", "angular.z"))
    assert compared(other, other)["robots"] == compared(plain, plain)["robots"]
