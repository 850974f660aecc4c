"""Headless experiments: the six points that a run of the paper's experiment must show, and the rest."""

import gc
import json
import os
import signal
import subprocess
import sys
import time
import tracemalloc
from math import comb

import numpy as np
import pytest
from ros_fixtures import heed_interrupts

from mrs_simulator import PioneerControl, load_scenario, make_twist, run_experiment
from mrs_simulator.control.user_code import call
from mrs_simulator.core.claims import centroid, stays_below
from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.protocols.formation import equations as formation
from mrs_simulator.protocols.loading import ProtocolError
from mrs_simulator.record.recording import RunError, read_run_csv
from mrs_simulator.study.results.report import FIGURES, begin_run, control_of, judged, read_run
from mrs_simulator.study.run.command import main
from mrs_simulator.study.run.experiment import Experiment, LawFailed, perform
from mrs_simulator.verdict.requirements.results import evaluated
from mrs_simulator.world.world import World

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def shipped(name, **changes):
    scenario = load_scenario(os.path.join(ROOT, "scenarios", name + ".yaml"))
    return scenario.changed(**changes) if changes else scenario


def with_control(scenario, **changes):
    control = dict(scenario.control._asdict(), **changes)
    return scenario.changed(control=control)


def samples(scenario):
    """Run to the end; return times (m,) and hand points (m, n, 2)."""
    experiment = Experiment(scenario)
    taken = [(stamp, hand_points(pose, 0.05)) for stamp, pose, _ in experiment.samples()]
    experiment.world.close()
    assert experiment.collisions == []
    times, hands = zip(*taken)
    return np.array(times), np.array(hands)


def chain_theory(scenario, steps):
    """Return the closed form for ``chain``, (steps + 1, n, 2): the binomial law of the edge errors."""
    n, k, c = scenario.n, 0.02, np.array([2.0, 0.0])
    start = hand_points(scenario.poses, 0.05)
    edge = start[:-1] - start[1:] - c
    track = np.empty((steps + 1, n, 2))
    track[:, -1] = start[-1]
    for t in range(steps + 1):
        for i in range(n - 2, -1, -1):
            weights = [comb(t, j) * k**j * (1 - k) ** (t - j) for j in range(min(t, n - 2 - i) + 1)]
            error = sum(w * edge[i + j] for j, w in enumerate(weights))
            track[t, i] = track[t, i + 1] + c + error
    return track


def matrix_theory(scenario, closure, steps):
    """Return ``d + M^t (alpha(0) - d)``, (steps + 1, n, 2), with M typed out for the closure."""
    n, k = scenario.n, 0.02
    heard = np.zeros((n, n))
    for i in range(n):
        if closure == "cycle":
            heard[i, (i + 1) % n] = 1.0
        else:
            beside = [j for j in (i - 1, i + 1) if 0 <= j < n]
            heard[i, beside] = 1.0 / len(beside)
    place = np.stack([2.0 * np.arange(n - 1, -1, -1), np.zeros(n)], axis=1)
    step = (1 - k) * np.eye(n) + k * heard
    away = hand_points(scenario.poses, 0.05) - place
    return np.array([place + np.linalg.matrix_power(step, t) @ away for t in range(steps + 1)])


# 1. Point masses follow the closed forms to 1e-9.


@pytest.mark.parametrize("closure", ["chain", "cycle", "path"])
def test_point_masses_follow_the_closed_form(closure):
    scenario = shipped("paper_theory")
    law = dict(scenario.control.parameters, closure=closure)
    _, hands = samples(with_control(scenario, parameters=law))
    steps = len(hands) - 1
    if closure == "chain":
        expected = chain_theory(scenario, steps)
    else:
        expected = matrix_theory(scenario, closure, steps)
    np.testing.assert_allclose(hands, expected, rtol=0.0, atol=1e-9)


# 2. Unicycles without limits, ten commands and more per T, keep within 0.1 m of theory.


@pytest.mark.parametrize("name", [pytest.param("paper", marks=pytest.mark.release), "paper_four"])
def test_unlimited_unicycles_keep_close_to_theory(name):
    scenario = shipped(name, limits="none", step=0.01)
    scenario = with_control(scenario, rate=100.0, saturation="none")
    times, hands = samples(scenario)
    assert np.linalg.norm(hands - chain_theory(scenario, len(times) - 1), axis=2).max() < 0.1
    np.testing.assert_allclose(formation.line_gaps(hands[-1]), 2.0, atol=1e-3)


@pytest.mark.parametrize(
    "name, robots",
    [
        ("paper", 7),
        ("paper", 60),
        ("consensus", 6),
        ("formation_crazyflies", 7),
        ("paper_dynamic", 7),
    ],
)
def test_the_closest_approach_is_the_same_in_both_files(name, robots, tmp_path):
    """Where samples are nearer than the world saw, and where 60 touch between them; in a report as well."""
    scenario = shipped(name, duration=1.5).overridden(robots=robots)
    scenario = scenario._replace(record_rate=1.0 if robots == 60 else scenario.record_rate)
    verdict = run_experiment(scenario, str(tmp_path), formats=())
    with open(tmp_path / "run.json", encoding="utf-8") as file:
        closest = json.load(file)["closest_approach"]
    assert closest == verdict["min_distance"] > 0.0
    run = read_run(str(tmp_path))
    assert judged(run, control_of(run))[0]["min_distance"] == closest


# 3. Limits on, 50 Hz; 4. full dynamics: the verdict has these tolerances.


@pytest.mark.parametrize(
    "name, gap, spread",
    [
        ("paper", 0.01, 0.01),
        ("paper_four", 0.01, 0.01),
        pytest.param("paper_dynamic", 0.05, 0.05, marks=pytest.mark.release),
    ],
)
def test_the_papers_experiment_passes_its_verdict(tmp_path, name, gap, spread):
    verdict = run_experiment(shipped(name), str(tmp_path), formats=())
    assert verdict["passed"], verdict
    np.testing.assert_allclose(verdict["final_gaps"], 2.0, atol=gap)
    assert verdict["y_spread"] < spread
    assert verdict["min_distance"] > 0.6
    with open(tmp_path / "run.json", encoding="utf-8") as file:
        assert json.load(file)["closest_approach"] == verdict["min_distance"]
    if name != "paper_dynamic":
        (settling,) = [c for c in verdict["checks"] if c["name"].startswith("settling")]
        # What held commands and limits cost, and a tenth of what points may be off.
        assert settling["tolerance"] < max(0.05 * settling["predicted"], 2.0)


# 5. The literal preset warns, and fails as it must.


def test_the_literal_preset_warns_and_fails(tmp_path):
    verdict = run_experiment(shipped("paper_literal"), str(tmp_path), formats=())
    assert not verdict["passed"]
    assert "spin for ever" in verdict["warnings"][0]


# 6. Impossible gains are refused with the reason.


@pytest.mark.parametrize("k, said", [(0.0, "diverges"), (-0.1, "diverges"), (1.0, "overshoots")])
def test_impossible_gains_are_refused(tmp_path, k, said):
    scenario = shipped("paper")
    law = dict(scenario.control.parameters, k=k)
    with pytest.raises(ValueError, match=said):
        run_experiment(with_control(scenario, parameters=law), str(tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_a_run_that_is_reported_again_has_the_same_verdict(tmp_path):
    scenario = shipped("paper_four", duration=12.0, topology={"preset": "complete"})
    scenario = scenario.with_protocol("consensus")  # with bodies, which meet
    verdict = run_experiment(scenario, str(tmp_path / "run"), formats=())
    collisions = [check for check in verdict["checks"] if check["name"] == "collisions"]
    assert collisions[0]["measured"] > 0 and not verdict["passed"]
    again = read_run(str(tmp_path / "run" / "run.csv"))
    assert judged(again, control_of(again))[0] == verdict
    (tmp_path / "run" / "run.json").unlink()
    again = read_run(str(tmp_path / "run" / "run.csv"))
    (check,) = [c for c in judged(again)[0]["checks"] if c["name"] == "collisions"]
    assert (check["passed"], check["note"]) == (None, "none was reported")


def test_a_run_writes_everything(tmp_path):
    verdict = run_experiment(shipped("paper_four", duration=2.0), str(tmp_path))
    drawn = ["trajectories", "x_states", "y_states", "inputs", "certificates"]
    assert set(FIGURES) - set(drawn) == {"trajectories_in_space", "z_states"}  # of robots that fly
    expected = ["provenance.json", "ro-crate-metadata.json"]
    expected += ["run.csv", "run.json", "scenario.yaml", "verdict.json"]
    expected += [name + ending for name in drawn for ending in (".png", ".pdf")]
    assert sorted(os.listdir(str(tmp_path))) == sorted(expected)
    assert json.load(open(str(tmp_path / "verdict.json"))) == verdict
    wanted = (
        "passed checks settle_time final_gaps y_spread min_distance real_time_factor seed versions"
    )
    assert set(wanted.split()) <= set(verdict)
    assert set(verdict["checks"][0]) == {
        "name",
        "question",
        "predicted",
        "measured",
        "tolerance",
        "passed",
        "difference",
        "note",
    }
    run = read_run_csv(str(tmp_path / "run.csv"))
    assert run.time[-1] == pytest.approx(2.0) and list(run.robots) == [1, 2, 3, 4]


@pytest.mark.parametrize("name", ["paper", "paper_dynamic"])
def test_the_same_seed_gives_the_same_bytes(tmp_path, name):
    scenario = shipped(name, duration=2.5, odometry="wheel", seed=7)
    made = []
    for out in ("one", "two"):
        perform(scenario, str(tmp_path / out))
        made.append((tmp_path / out / "run.csv").read_bytes())
    assert made[0] == made[1]
    if name == "paper":
        perform(scenario.changed(seed=8), str(tmp_path / "three"))
        assert (tmp_path / "three" / "run.csv").read_bytes() != made[0]


class FailsLater(PioneerControl):
    calls = 0

    def calculateControlLaw(self, pos_map):
        FailsLater.calls += 1
        if FailsLater.calls > 50:
            raise ZeroDivisionError("no neighbours")
        return {number: make_twist(0.1, 0.0) for number in pos_map}


def test_a_law_that_fails_stops_the_robots_and_keeps_the_run(tmp_path, capfd):
    FailsLater.calls = 0
    verdict = run_experiment(shipped("paper_four"), str(tmp_path), FailsLater, formats=())
    assert not verdict["passed"]
    assert "ZeroDivisionError: no neighbours" in verdict["ended"]
    assert "in calculateControlLaw" in capfd.readouterr().err
    assert read_run_csv(str(tmp_path / "run.csv")).time[-1] == pytest.approx(0.9)


class Collecting(PioneerControl):
    """Notes whether garbage is collected meanwhile; raises at the end."""

    def calculateControlLaw(self, pos_map):
        self.collects = [*getattr(self, "collects", []), gc.isenabled()]
        if len(self.collects) > 2:
            raise RuntimeError("enough")
        return [make_twist(0.1, 0.0) for _ in pos_map]


@pytest.mark.parametrize("robots, collects", [(7, True), (300, False)])
def test_no_garbage_is_looked_for_among_the_positions_of_many(robots, collects):
    poses = np.column_stack([2.0 * np.arange(robots), np.zeros((robots, 2))]).tolist()
    experiment = Experiment(shipped("paper", robots=robots, poses=poses), Collecting)
    with pytest.raises(LawFailed, match="enough"):
        list(experiment.samples())
    experiment.world.close()
    assert experiment.control.collects == [collects] * 3
    assert gc.isenabled()


class Leaves(PioneerControl):
    def calculateControlLaw(self, pos_map):
        raise SystemExit("I have had enough")


def test_a_law_that_fails_at_once_is_reported_too(tmp_path):
    verdict = run_experiment(shipped("paper_four"), str(tmp_path), Leaves, formats=("png",))
    assert verdict["ended"] == "at 0.000 s the law failed: SystemExit: I have had enough"
    assert not verdict["passed"] and (tmp_path / "trajectories.png").exists()


class Interrupts(PioneerControl):
    def calculateControlLaw(self, pos_map):
        raise KeyboardInterrupt


def test_an_interrupt_that_a_law_raises_itself_is_a_failure_of_the_law(tmp_path):
    verdict = run_experiment(shipped("paper_four"), str(tmp_path), Interrupts, formats=())
    assert verdict["ended"] == "at 0.000 s the law failed: KeyboardInterrupt: "


def await_interrupt():
    os.kill(os.getpid(), signal.SIGINT)
    for _ in range(100000):
        pass


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_from_the_keyboard_leaves_a_law_as_it_came():
    with pytest.raises(KeyboardInterrupt):
        call(await_interrupt)


def test_a_law_that_is_refused_leaves_no_world_open(monkeypatch):
    closed = []
    monkeypatch.setattr(World, "close", lambda world: closed.append(world))
    with pytest.raises(ProtocolError, match="odometer"):
        Experiment(shipped("paper_four"), type("Asks", (Forward,), {"SENSORS": ("odometer",)}))
    assert len(closed) == 1


def test_a_team_that_is_driven_apart_is_reported_as_far_as_it_went(tmp_path):
    scenario = shipped("consensus")
    parameters = dict(scenario.control.parameters, gain=40.0)
    apart = with_control(scenario.changed(fidelity="point_mass"), parameters=parameters)
    verdict = run_experiment(apart, str(tmp_path), formats=())
    assert "m away: the team is driven apart" in verdict["ended"] and not verdict["passed"]
    assert read_run_csv(str(tmp_path / "run.csv")).time[-1] > 0.0


class Forward(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {number: make_twist(0.1, 0.0) for number in pos_map}


class WrongClaims(Forward):
    def claims(self, start):
        return [stays_below(centroid)]


class WrongQuantity(Forward):
    def claims(self, start):
        return [stays_below(lambda hand: hand[:, 99], 1.0, "a hundredth robot")]


class WrongMeasures(Forward):
    def measures(self, run):
        return {"least": min([])}


@pytest.mark.parametrize(
    "law, name, said",
    [
        (WrongClaims, "claims() returns", "TypeError"),
        (WrongQuantity, "a hundredth robot", "IndexError"),
        (WrongMeasures, "measures() returns", "ValueError"),
    ],
)
def test_a_mistake_in_the_claims_costs_no_run(tmp_path, capfd, law, name, said):
    short = shipped("paper_four", duration=1.0)
    drawn = ("png",) if law is WrongClaims else ()  # the others' are called by the verdict alone
    verdict = run_experiment(short, str(tmp_path), law, formats=drawn)
    found = {check["name"]: check for check in verdict["checks"]}[name]
    assert not verdict["passed"] and found["passed"] is False and said in found["note"]
    assert verdict["ended"] == "complete" and (tmp_path / "trajectories.png").exists() == bool(
        drawn
    )
    assert "Traceback" in capfd.readouterr().err


def ended_by(number, scenario, out):
    """Send the signal ``number`` to a run that records; return its exit code and what it printed."""
    command = [sys.executable, "-m", "mrs_simulator.study.run.command", str(scenario)]
    process = subprocess.Popen(
        command + ["--out", str(out), "--duration", "5000", "--formats", ""],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        preexec_fn=heed_interrupts,
    )
    try:
        end = time.monotonic() + 60
        table = out / "run.csv"
        while time.monotonic() < end and not (table.exists() and table.stat().st_size > 5000):
            time.sleep(0.05)
        process.send_signal(number)
        output = process.communicate(timeout=60)[0].decode()
    finally:
        process.kill()
        process.wait()
    return process.returncode, output


def test_a_killed_run_is_known_to_be_simulated(tmp_path):
    given, out = tmp_path / "given.yaml", tmp_path / "run"
    asked = load_scenario(os.path.join(ROOT, "scenarios", "paper_dynamic.yaml")).changed(
        requirements={"slow": "always(speed < 50 m/s)"}
    )
    given.write_text(asked.to_yaml())
    code, _ = ended_by(signal.SIGKILL, given, out)
    assert code == -signal.SIGKILL and not (out / "verdict.json").exists()
    run = read_run(str(out))
    (slow,) = evaluated(None, run)
    assert slow["met"] and not run.are_real.any() and run.meta["collisions_unknown"]
    assert "twist.linear.x" not in (out / "run.csv").read_text()  # bytes of the first version


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 130)])
def test_an_interrupted_run_is_reported_as_far_as_it_went(tmp_path, number, code):
    scenario = os.path.join(ROOT, "scenarios", "paper_dynamic.yaml")
    ended, output = ended_by(number, scenario, tmp_path)
    assert ended == code
    assert "interrupted" in output
    verdict = json.loads((tmp_path / "verdict.json").read_text())
    assert verdict["ended"] == "interrupted" and not verdict["passed"]
    assert len(read_run_csv(str(tmp_path / "run.csv")).time) > 5


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["nowhere.yaml"], "nowhere.yaml"),
        (["{paper}", "--robots", "0"], "robots = 0"),
        (["{paper}", "--duration", "-1"], "duration"),
        (["{paper}", "--fidelity", "kinematics"], "kinematics"),
        (["{paper}", "--protocol", "formatoin"], "did you mean 'formation'"),
    ],
)
def test_bad_arguments_are_said_in_one_line(tmp_path, capsys, arguments, said):
    paper = os.path.join(ROOT, "scenarios", "paper.yaml")
    arguments = [argument.format(paper=paper) for argument in arguments]
    with pytest.raises(SystemExit) as ended:
        main(arguments + ["--out", str(tmp_path)])
    error = capsys.readouterr().err
    assert ended.value.code == 2
    assert said in error and error.count("\n") == 1


def test_overlapping_robots_are_refused_before_anything_is_written(tmp_path):
    scenario = shipped("paper_four")
    poses = scenario.poses.copy()
    poses[1] = poses[0] + 0.1
    with pytest.raises(ValueError, match="robot1 and robot2 overlap"):
        run_experiment(scenario._replace(poses=poses), str(tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_more_robots_than_the_scenario_lists(tmp_path):
    many = shipped("paper").with_robots(30)._replace(duration=1.0)
    verdict = run_experiment(many, str(tmp_path), formats=())
    assert verdict["robots"] == 30


def test_an_experiment_of_thousands_holds_no_matrix_of_all_pairs(tmp_path):
    n = 1000
    tracemalloc.start()
    try:
        scenario = shipped("paper", robots=n, poses={"layout": "grid"}, duration=0.2)
        verdict = run_experiment(scenario, str(tmp_path), formats=())
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert verdict["ended"] == "complete" and verdict["robots"] == n
    assert peak < 8 * n * n


def test_the_report_on_an_earlier_run_is_not_left_beside_another(tmp_path):
    short = shipped("paper_four", duration=0.2)
    run_experiment(short, str(tmp_path), formats=())
    for name in FIGURES:
        (tmp_path / (name + ".png")).touch()
    (tmp_path / "notes.txt").write_text("mine")
    begin_run(short, str(tmp_path)).close()
    assert sorted(os.listdir(str(tmp_path))) == ["notes.txt", "run.csv", "scenario.yaml"]


def test_a_shipped_scenario_is_found_by_its_name_from_anywhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["consensus.yaml", "--out", "out", "--duration", "30", "--formats", ""])
    assert ended.value.code == 0 and (tmp_path / "out" / "verdict.json").exists()
    with pytest.raises(SystemExit) as ended:
        main(["no_such.yaml", "--out", "out"])
    assert ended.value.code == 2


@pytest.mark.parametrize(
    "content, said",
    [
        ("poses: [[0, 0, 0], [0.1, 0, 0]]", "wrong.yaml: robot1 and robot2 overlap"),
        (
            "poses: [[0, 0, 0]]\ncontrol: {parameters: {kk: 1}}",
            "wrong.yaml: Formation: unknown 'kk'",
        ),
        ("poses: [[0, 0, 0]]\nlimts: none", "unknown 'limts'; did you mean 'limits'"),
    ],
)
def test_what_is_wrong_names_the_scenario(tmp_path, capsys, content, said):
    (tmp_path / "wrong.yaml").write_text(content)
    with pytest.raises(SystemExit) as ended:
        main([str(tmp_path / "wrong.yaml"), "--out", str(tmp_path / "out")])
    assert ended.value.code == 2 and said in capsys.readouterr().err


def test_files_that_cannot_be_used_are_named_once(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    with pytest.raises(SystemExit) as ended:
        main(["consensus.yaml", "--out", str(tmp_path / "file")])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and said.endswith("file: is a file, wanted a directory\n")
    with pytest.raises(RunError, match="run.csv: cannot be read: No such file or directory$"):
        read_run_csv(str(tmp_path / "run.csv"))


def test_robots_that_the_scenario_does_not_have_are_named(tmp_path, capsys):
    with pytest.raises(SystemExit):
        asked = ["--robots", "8", "--duration", "0.2", "--formats", ""]
        main(["consensus.yaml", "--out", str(tmp_path), *asked])
    said = capsys.readouterr().err
    assert "robots 7 to 8 are not in the scenario: put where there is room, without edges" in said


SEEDED = """
from mrs_simulator import Parameter, PioneerControl


class Seeded(PioneerControl):
    PARAMETERS = PioneerControl.PARAMETERS + (Parameter("seed", 0.0),)

    def pointMassLaw(self, hand):
        return 0.0 * hand
"""


def test_values_of_a_file_are_set_on_the_command_line(tmp_path, capsys):
    path = tmp_path / "scenario.yaml"
    path.write_text(
        "{poses: [[0, 0, 0], [9, 0, 0]], topology: {preset: path}, control: {protocol: consensus}}"
    )

    def run(*options):
        with pytest.raises(SystemExit) as caught:
            common = ["--out", str(tmp_path / "out"), "--duration", "0.4", "--formats", ""]
            main([str(path), *common, *options])
        return caught.value.code, capsys.readouterr().err

    assert run("--set", "gain=0.7", "--set", "mismatch.delay=0.2")[0] == 0
    scenario = load_scenario(tmp_path / "out" / "scenario.yaml")
    assert scenario.control.parameters["gain"] == 0.7 and set(scenario.mismatch.delay) == {0.2}
    assert run("--protocol", "discrete_consensus", "--set", "eps=0.3")[0] == 0
    control = load_scenario(tmp_path / "out" / "scenario.yaml").control
    assert (control.protocol, control.parameters["eps"]) == ("discrete_consensus", 0.3)
    assert run("--set", "topology={preset: path}", "--set", "poses=[[0, 0, 0], [7, 0, 0]]")[0] == 0
    scenario = load_scenario(tmp_path / "out" / "scenario.yaml")
    assert scenario.poses[1, 0] == 7.0 and len(scenario.topology.edges) == 1
    # No parameters of the law; the third has no edges, so that nothing spans.
    assert run("--set", "robots=3", "--set", "record_rate=10")[0] == 1
    scenario = load_scenario(tmp_path / "out" / "scenario.yaml")
    assert scenario.n == 3 and scenario.record_rate == 10.0
    code, said = run("--set", "robots=many")
    assert code == 2 and "--set robots: 'many', wanted a whole number" in said
    law = tmp_path / "own.py"
    law.write_text(SEEDED)
    assert run("--protocol", str(law), "--set", "seed=4")[0] == 0
    scenario = load_scenario(tmp_path / "out" / "scenario.yaml")
    assert scenario.control.parameters["seed"] == 4.0 and scenario.seed == 0
    code, said = run("--set", "robots=3", "--sweep", "seed=0..1", "--jobs", "1")
    assert code in (0, 1) and len(list((tmp_path / "out").glob("*/run.csv"))) == 2
    code, said = run("--set", "gian=1")
    assert code == 2 and "unknown 'gian'; did you mean 'gain'" in said
    code, said = run("--set", "gain")
    assert code == 2 and "--set 'gain': wanted NAME=VALUE" in said
    code, said = run("--set", "gain=1", "--sweep", "control.parameters.gain=1,2")
    assert code == 2 and "given and swept" in said


RAISING = """
from mrs_simulator import PioneerControl


def helper(hand):
    return hand[10]


class Raising(PioneerControl):
    def pointMassLaw(self, hand):
        try:
            return helper(hand) if self.time > 0.2 else 0.0 * hand
        except IndexError as error:
            raise RuntimeError("no tenth robot") from error

    def claims(self, start):
        return [helper(start)]
"""


@pytest.mark.parametrize("whole", ["0", "1"])
def test_of_a_law_that_raises_its_own_lines_are_printed_and_once(
    tmp_path, capfd, monkeypatch, whole
):
    monkeypatch.setenv("MRS_SIMULATOR_TRACEBACK", whole)
    (tmp_path / "my_raising.py").write_text(RAISING)
    scenario = shipped("paper_four", duration=1.0)
    name = "{}:Raising".format(tmp_path / "my_raising.py")
    verdict = run_experiment(scenario.with_protocol(name), str(tmp_path / "out"), formats=())
    said = capfd.readouterr().err
    files = [line for line in said.splitlines() if line.startswith('  File "')]
    own = [line for line in files if "my_raising.py" in line]
    assert len(own) == 5  # two of helper, its cause, and its claim's
    assert ("    return hand[10]" in said) and "RuntimeError: no tenth robot" in said
    assert (own == files) is (whole == "0")
    assert [check["name"] for check in verdict["checks"] if "IndexError" in check["note"]] == [
        "claims() returns"
    ]
