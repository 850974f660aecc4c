import contextlib
import io
import json
import os

import numpy as np
import pytest
from protocol_fixtures import shipped

from mrs_simulator import PioneerControl, make_twist
from mrs_simulator.control.array_law import of_samples
from mrs_simulator.protocols import HOMES
from mrs_simulator.protocols import shipped as protocol_of
from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.requirements import SIGNALS
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.analyses.signal_listing import main as list_signals
from mrs_simulator.study.results.report import read_run
from mrs_simulator.study.run.experiment import played, run_experiment
from mrs_simulator.study.run.simulating import simulate
from mrs_simulator.verdict.judging import judged
from mrs_simulator.verdict.requirements.results import evaluated, requirement_lines
from mrs_simulator.verdict.requirements.signals import VALUES, Absent, signal_of
from mrs_simulator.verdict.verdict import (
    exit_code,
    verdict_text,
    with_requirements,
    write_verdict,
)
from mrs_simulator.verdict.verdict_file import read_verdict

SCENARIO = {
    "poses": [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]],
    "fidelity": "point_mass",
    "control": {"protocol": "consensus", "rate": 10},
    "topology": {"edges": [[1, 2], [2, 3]], "directed": False},
    "duration": 2.0,
    "step": 0.02,
    "record_rate": 1.0,
}


def scenario(**requirements):
    return scenario_from_dict({**SCENARIO, "requirements": requirements})


def run_of(**requirements):
    """Return a run of two Pioneers: robot 2 passes robot 1 at 1 m, 0.5 m/s."""
    time = np.arange(5.0)
    pose = np.zeros((5, 3, 3))
    pose[:, 1, 0], pose[:, 1, 1] = 0.5 * time - 1.0, 1.0
    pose[:, 2] = [9.0, 9.0, 0.0]
    numbers = np.array([1, 2, 3])
    given = scenario(**requirements)._replace(fidelity="kinematic")
    return Run(time, numbers, pose, pose[:, :, :2], np.zeros((5, 3, 2)), scenario=given)


def result(formula, control=None):
    return evaluated(control, run_of(wanted=formula))[0]


def test_every_signal_that_may_be_named_can_be_measured():
    assert list(VALUES) == list(SIGNALS)


def test_distances_and_clearances_are_those_of_the_robots():
    found = result("always(each pair(distance >= 1.2 m))")
    assert found["met"] is False and found["margin"] == pytest.approx(-0.2)
    assert (found["time"], found["member"]) == (2.0, "robot1 and robot2")
    assert found["decided_at"] == 1.0  # 1.118 m already
    # Pioneers side by side: 1 m less twice half of a width of 0.425 m.
    assert signal_of("clearance", None, run_of()).values.min() == pytest.approx(
        1.0 - 0.425, abs=1e-9
    )
    assert np.allclose(signal_of("speed", None, run_of()).values[1], [0.0, 0.5, 0.5, 0.5, 0.5])


def of_real_robots(**columns):
    """Return :func:`run_of` real robots; the second's pose comes late at 2 s, and is 1 m on at 3 s."""
    run = run_of(wanted="always(speed < 0.6 m/s)")
    run.pose[2, 1] = run.pose[1, 1]
    twist = np.zeros((5, 3, 3))
    twist[:, 1] = [0.5, 0.0, 0.1]
    meta = {"collisions_unknown": True}
    given = dict(vars(run), meta=meta, **{"twist": twist, **columns})
    return Run(**{name: each for name, each in given.items() if each is not None})


def test_speeds_of_real_robots_are_those_that_they_measure():
    run = of_real_robots()
    assert signal_of("speed", None, run).values[1].tolist() == [0.5] * 5
    assert signal_of("turn_rate", None, run).values[1].tolist() == [0.1] * 5
    assert evaluated(None, run)[0]["margin"] == pytest.approx(0.1)
    # Among simulated ones.
    real = np.zeros((5, 3), dtype=bool)
    simulated = run_of().replace(real=real, twist=run.twist)
    assert signal_of("speed", None, simulated).values[1].tolist() == [0.0] + [0.5] * 4
    real[:, 1] = True
    assert signal_of("speed", None, simulated).values[1].tolist() == [0.5] * 5


@pytest.mark.parametrize(
    "changes, reason",
    [
        ({"twist": None}, "report on their bag"),
        ({"twist": np.zeros((5, 3, 3))}, "robot2: its odometry"),
    ],
)
def test_speeds_that_real_robots_do_not_tell_are_not_guessed(changes, reason):
    run = of_real_robots().replace(**changes)
    found = evaluated(None, run)[0]
    assert found["met"] is None and reason in found["note"]


def test_contacts_of_real_robots_are_not_known():
    found = evaluated(
        None, of_real_robots().replace(scenario=scenario(none="always(contacts < 1)"))
    )
    assert found[0]["met"] is None
    assert found[0]["note"] == "nothing reports collisions of real robots"


def test_of_a_killed_run_it_is_known_who_was_real():
    twist = np.full((5, 3, 3), 0.1)
    unknown = of_real_robots(twist=None).replace(meta={"collisions_unknown": True, "real": []})
    assert signal_of("speed", None, unknown).values[1, 1] == 0.5  # of poses
    mixed = unknown.replace(meta={"collisions_unknown": True, "real": [3]}, twist=twist)
    assert signal_of("speed", None, mixed).values[1, 1] == 0.5
    assert np.allclose(signal_of("speed", None, mixed).values[2], np.hypot(0.1, 0.1))
    with pytest.raises(Absent, match="killed: collisions are not known"):
        signal_of("contacts", None, mixed)


AT_ONCE = [name for name in HOMES if hasattr(protocol_of(name).targets, "of_samples")]


@pytest.mark.parametrize("name", AT_ONCE)
def test_places_wanted_in_all_samples_are_those_of_each_alone_to_the_bit(name, monkeypatch):
    run, control = played(shipped(name, duration=1.0))
    run, ended = run.in_space(control.dimension), control.time
    law, asked = type(control), []
    places = law.targets

    def counted(self, hand):
        asked.append(hand.shape)
        return places(self, hand)

    for lay in (np.asarray, np.ascontiguousarray, np.asfortranarray):  # in memory
        laid = run.replace(hand=lay(run.hand))
        monkeypatch.setattr(law, "targets", of_samples(counted))
        at_once = signal_of("error", control, laid).values
        assert asked == [run.hand.shape] and control.time == ended and at_once.any()
        monkeypatch.setattr(law, "targets", lambda self, hand: counted(self, hand))
        np.testing.assert_array_equal(signal_of("error", control, laid).values, at_once)
        assert asked[1:] == len(run.time) * [run.hand[0].shape]
        asked.clear()


def test_what_a_run_does_not_have_leaves_a_requirement_open():
    found = result("always error < 1 m")
    assert found["met"] is None and "protocol" in found["note"]
    found = result("eventually[0, 60] distance > 99 m")
    assert found["met"] is None and found["high"] is None and found["note"] == ""


@pytest.mark.parametrize(
    "given, message",
    [
        (
            {"apart": "always(distnce > 1)"},
            "apart: signal: unknown 'distnce'; did you mean 'distance'",
        ),
        ({"apart": "always(distance > 1 s)"}, "1 s beside a signal in m"),
        ({"apart": 3}, r"wanted the text of a formula, got 3(?!\n)"),
        ({1: "distance > 1"}, "wanted a name of a requirement"),
        (["distance > 1"], "wanted a mapping of formulas by name"),
    ],
)
def test_wrong_requirements_are_refused_when_the_scenario_is_read(given, message):
    with pytest.raises(ScenarioError, match=message):
        scenario_from_dict({**SCENARIO, "requirements": given})


def test_a_scenario_keeps_its_requirements():
    given = scenario(apart="always(distance > 0 m)")
    again = scenario_from_dict(given.to_dict())
    assert again.requirements == given.requirements == (("apart", "always(distance > 0 m)"),)


def test_verdict_tells_requirements_and_fails_for_a_broken_one(tmp_path):
    given = scenario(kept="always(each edge(length <= 6 m))", still="always(speed <= 0.1 m/s)")
    verdict = run_experiment(given, str(tmp_path), formats=())
    kept, still = verdict["requirements"]
    assert kept["met"] is True and kept["margin"] == pytest.approx(1.0) and kept["time"] == 0.0
    assert still["met"] is False and verdict["outcome"] == "failed" and exit_code(verdict) == 1
    text = verdict_text(verdict)
    assert "requirement kept: met, margin +1 m by robot2 and robot3 at 0.00 s" in text
    assert "requirement still: BROKEN" in text
    with open(os.path.join(str(tmp_path), "verdict.json")) as file:
        assert json.load(file)["requirements"] == verdict["requirements"]


def test_a_met_requirement_judges_no_theory(tmp_path):
    given = scenario(kept="always(length <= 6 m)")
    run = run_of()._replace(scenario=given)
    verdict, _ = judged(run)
    assert verdict["outcome"] == "not_judged" and exit_code(verdict) == 0
    assert verdict["requirements"][0]["met"] is None  # without a protocol no graph is known
    run = run._replace(scenario=scenario(far="always(distance >= 0.1 m)"))
    assert judged(run)[0]["reason"].endswith("requirements met: 1 of 1")


def test_formulas_see_every_step_and_not_the_samples_alone(tmp_path):
    # Samples lie 1 s apart, steps 0.02 s: the window holds no sample but the steps.
    given = scenario(early="eventually[0.1, 0.2](distance < 4.9 m)")
    verdict = run_experiment(given, str(tmp_path), formats=())
    found = verdict["requirements"][0]
    assert found["met"] is True and found["period"] == pytest.approx(0.02)
    run = read_run(str(tmp_path))
    assert judged(run)[0]["requirements"] == verdict["requirements"]  # kept in run.json
    other = run._replace(scenario=scenario(other="always distance > 0.1 m"))
    assert judged(other)[0]["requirements"][0]["period"] == pytest.approx(1.0)


def test_a_passed_run_says_that_a_requirement_is_open():
    passed = {"outcome": "passed", "passed": True, "reason": ""}
    met, still, broken = ({"met": each} for each in (True, None, False))
    assert with_requirements(passed, [met])["reason"] == ""
    found = with_requirements(passed, [met, still])
    assert (found["outcome"], found["reason"]) == ("passed", "requirements met: 1 of 2")
    assert with_requirements(passed, [broken, still])["outcome"] == "failed"
    failed = {**passed, "outcome": "failed", "passed": False}
    assert with_requirements(failed, [still])["reason"] == ""


def test_a_protocol_that_raises_leaves_the_requirement_open(capsys):
    class Broken:
        time = 0.0

        def targets(self, hand):
            raise ValueError("no idea")

    found = result("always error < 1 m", Broken())
    assert found["met"] is None and found["note"] == "ValueError: no idea"
    assert "no idea" in requirement_lines([found])[0]


def listed(*arguments):
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        list_signals([*map(str, arguments)])
    return text.getvalue()


def test_the_signals_are_listed():
    assert all(name in listed() for name in (*SIGNALS, "curve.NAME", "sensor.NAME.FIELD"))


def test_of_a_scenario_those_that_it_has_are_listed_and_why_others_not(tmp_path):
    path = tmp_path / "scenario.yaml"
    path.write_text(scenario(apart="always(distance > 0 m)").to_yaml())
    text = listed(path)
    assert "apart: always(distance > 0 m)" in text
    has, absent = text.split("not in this scenario")
    assert all(("  " + name + " ") in has + absent for name in SIGNALS)
    assert "Consensus wants no place of each robot" in absent and "  distance " in has


def test_a_requirement_of_what_the_scenario_has_not_is_told(tmp_path):
    path = tmp_path / "scenario.yaml"
    formulas = {
        "near": "always(sensor.front.rangez > 1)",
        "odd": "always(curve.speed < 1 or x > 0 m)",
    }
    path.write_text(scenario(**formulas, apart="always(distance > 0 m)").to_yaml())
    lines = listed(path).splitlines()
    open_ = {
        lines[k - 1].split(":")[0].strip(): each for k, each in enumerate(lines) if "open" in each
    }
    assert open_ == {
        "near": "    is left open: the scenario has no sensor.front.rangez",
        "odd": "    is left open: the scenario has no curve.speed",
    }


def test_curves_and_sensors_of_a_scenario_are_listed_by_the_names_that_formulas_take():
    text = listed("exploration.yaml")
    wanted = "curve.floor_seen", "sensor.sonar.ranges", "sensor.laser.ranges"
    assert all(name in text for name in wanted) and "sensor.sonar.places" not in text


def test_signals_in_space_are_those_of_a_law_of_three_coordinates():
    text = listed("crazyflies_cube.yaml")
    assert "not in this scenario" not in text and "  error " in text


OWN = """
import numpy as np
from mrs_simulator import PioneerControl, make_twist
from mrs_simulator.protocols.curves import Curve

class Own(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {i: make_twist(0.1 * (i == 1), 0.0) for i in pos_map}

    def curves(self, run):
        time = run.time - run.time[0]
        gap = run.pose[:, 1, 0] - run.pose[:, 0, 0]
        return [Curve("Gap of the pair [m]", time, gap), Curve("no", [1], [2], across="Robot")]
"""


def own_results(tmp_path, **requirements):
    (tmp_path / "own.py").write_text(OWN)
    content = {
        "poses": [[0, 0, 0], [3, 0, 0]],
        "control": {"protocol": str(tmp_path / "own.py"), "rate": 10},
        "duration": 1.0,
        "requirements": requirements,
    }
    return {each["name"]: each for each in simulate(content).verdict["requirements"]}


def test_curves_of_the_law_are_signals(tmp_path):
    found = own_results(
        tmp_path,
        gap="always curve.gap_of_the_pair >= 2.95",
        unknown="always curve.gap >= 0",
        other="always curve.no >= 0",
    )
    assert found["gap"]["met"] is False and found["gap"]["margin"] == pytest.approx(-0.04, abs=0.02)
    for name in ("unknown", "other"):
        assert found[name]["met"] is None and "wanted one of gap_of_the_pair" in found[name]["note"]


def test_readings_of_sensors_are_signals_at_each_step(tmp_path):
    found = own_results(
        tmp_path,
        near="always each robot(sensor.sonar.ranges > 2.4)",
        far="always each robot(sensor.sonar.ranges > 2.5)",  # robot 2 is that far ahead until 0.5 s
        field="always sensor.sonar.rangs > 2.2",
    )
    assert found["near"]["met"] and found["far"]["met"] is False
    assert found["far"]["member"] == "robot1" and -0.1 < found["far"]["margin"] < 0.0
    assert found["field"]["met"] is None and "never had such a reading" in found["field"]["note"]


def test_a_sensor_that_no_robot_has_is_refused_before_the_run(tmp_path):
    with pytest.raises(ValueError, match="compass"):
        own_results(tmp_path, seen="always sensor.compass.heading > 0")


def test_results_are_read_back_and_what_is_none_is_refused(tmp_path):
    verdict = run_experiment(scenario(far="always distance > 1 m"), str(tmp_path), formats=())
    path = str(tmp_path / "verdict.json")
    assert read_verdict(path)["requirements"] == verdict["requirements"]
    for wrong in ({"met": "yes"}, {"margin": "0.2"}):
        bad = dict(verdict, requirements=[{**verdict["requirements"][0], **wrong}])
        write_verdict(bad, path)
        with pytest.raises(ValueError, match="requirement 1: " + next(iter(wrong))):
            read_verdict(path)
    write_verdict(dict(verdict, requirements=[{"name": "far"}]), path)
    with pytest.raises(ValueError, match="requirement 1: no formula"):
        read_verdict(path)


class HeadOn(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return [make_twist(0.4, 0.0) for _ in pos_map]


@pytest.mark.parametrize("turned", [0.0, 0.4])
def test_bodies_collide_at_the_step_at_which_their_clearance_ends(turned):
    """A wider clearance is lost before, by a margin whose number is no clearance."""
    given = {"poses": [[0.0, 0.0, 0.0], [2.0, 0.1, np.pi - turned]], "duration": 4.0}
    least = {"touch": 1e-9, "near": 0.1}
    requirements = {k: "always(each pair(clearance >= {} m))".format(v) for k, v in least.items()}
    study = simulate({**given, "requirements": requirements}, protocol=HeadOn)
    found = {each["name"]: each for each in study.verdict["requirements"]}
    collided, step = study.run.collisions[0].time, study.run.scenario.step
    assert found["touch"]["decided_at"] == pytest.approx(collided, abs=0.5 * step)
    assert found["near"]["decided_at"] < collided - 4.0 * step
    assert "near: BROKEN, margin -0.1 m by robot1 and robot2" in verdict_text(study.verdict)
