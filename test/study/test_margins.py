"""How far robots may differ: what ``margins`` finds, and what the preflight makes of it."""

import json

import pytest
import yaml

from mrs_simulator.control.guards import limited
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.team.limits import LoweredLimits
from mrs_simulator.study.draw.margins_figure import NEUTRAL, WORDS, margins_figure
from mrs_simulator.study.draw.sweep_figures import PASSED
from mrs_simulator.study.results.stamp import stamp_of
from mrs_simulator.study.run.simulating import simulate
from mrs_simulator.study.search.margin_checks import (
    MarginsError,
    margin_checks,
    read_margins,
    read_measured,
    scenario_check,
)
from mrs_simulator.study.search.margins import USUAL, Axis, axes_of
from mrs_simulator.study.search.margins_command import lines_of, main
from mrs_simulator.study.search.space import content_with

# Points with held commands agree for gains below 2/(lambda_max Tc): 20/3 /s for three in a row at 10 Hz,
# and with gain 3 /s above 4.5 Hz.
SCENARIO = """
poses: [[0, 0, 0], [3, 0, 0], [1, 2, 0]]
fidelity: point_mass
limits: none
control: {protocol: consensus, rate: 10, saturation: none, parameters: {gain: 3.0}}
topology: {edges: [[1, 2], [2, 3]], directed: false}
duration: 10
requirements:
  agree: eventually[0, 9] always(distance < 0.1 m)
  near: always(distance < 10 m)
"""

# In which what grows slowly is large at the end.
LONG = SCENARIO.replace("duration: 10", "duration: 20").replace("[0, 9]", "[0, 19]")

TWO = scenario_from_dict({"poses": [[0, 0, 0], [3, 0, 0]]})


def run(*arguments):
    with pytest.raises(SystemExit) as caught:
        main([*map(str, arguments), "--jobs", "1"])
    return caught.value.code


def scenario_file(folder, text=SCENARIO):
    path = folder / "scenario.yaml"
    path.write_text(text)
    return path


def test_rates_fit_the_step_that_a_scenario_states(tmp_path, capsys):
    # Periods of whole steps: 0.2 s holds for gain 3 /s, and 0.25 s, 3 gain Tc = 2.25 > 2, does not.
    stated = scenario_file(tmp_path, SCENARIO + "step: 0.05\n")
    out = tmp_path / "out"
    assert run(stated, "--out", out, "--along", "control.rate=2", "--formats", "") == 0
    (axis,) = json.loads((out / "margins.json").read_text())["axes"]
    assert (axis["tried"], axis["refused"]) == (8, "")
    assert axis["breaks"]["near"] == [5.0, 4.0]


def test_delays_are_told_in_the_whole_steps_that_robots_obey(tmp_path, capsys):
    text = SCENARIO.replace("gain: 3.0", "gain: 2.0") + "links: {delay: 0.0}\n"
    text = text.replace("duration: 10", "duration: 10\nstep: 0.05")
    out = tmp_path / "out"
    along = ["--along", "mismatch.delay=0.73", "--along", "links.delay=0.73"]
    assert run(scenario_file(tmp_path, text), "--out", out, *along, "--formats", "") == 0
    robots, edges = json.loads((out / "margins.json").read_text())["axes"]
    for axis, grain in ((robots, 0.05), (edges, 0.1)):
        for pair in axis["breaks"].values():
            if pair:
                steps = round(pair[0] / grain)
                assert pair == pytest.approx([steps * grain, (steps + 1) * grain], abs=1e-9)
    holds, _ = robots["breaks"]["agree"]
    assert holds > 0.0


def test_margins_are_those_of_theory(tmp_path, capsys):
    path, out = scenario_file(tmp_path, LONG), tmp_path / "out"
    along = ["--along", "control.parameters.gain=12", "--along", "control.rate=2"]
    assert run(path, "--out", out, *along, "--formats", "png") == 0
    report = json.loads((out / "margins.json").read_text())
    gain, rate = report["axes"]
    for axis, theory in ((gain, 20.0 / 3.0), (rate, 4.5)):
        holds, breaks = axis["breaks"]["near"]
        assert (holds, breaks) == pytest.approx((theory, theory), rel=0.01)
    assert holds > breaks  # of the rate, which falls
    assert gain["breaks"]["agree"][1] == pytest.approx(20.0 / 3.0, rel=0.05)  # too slow before it
    # The box's worst corner is the high gain at the low rate, which needs 1.5 gain < rate.  Both by
    # ratios to the ends found: 4.5 (6.61/3)^s = 10 (4.58/10)^s at s = 0.51.
    together = report["together"]
    assert together["share"] == pytest.approx(0.51, abs=0.02) and together["breaks"] == "agree"
    assert set(together["corner"]) == {"control.parameters.gain", "control.rate"}
    # Whoever is dead, the others come to it.
    assert report["dead"] == {"1": [], "2": [], "3": []}
    assert b"inputs sha256 " in (out / "margins.png").read_bytes()
    said = capsys.readouterr().out
    assert "breaks at 6.6" in said and "dead robot" in said and "together: " in said


def test_dead_robots_never_move():
    content = {"poses": [[0, 0, 0], [3, 0, 0]], "topology": {"preset": "path"}, "duration": 2}
    content.update(control={"protocol": "consensus"}, mismatch={"speed": [0.0, 1.0]})
    pose = simulate(content).run.pose
    assert (pose[:, 0] == pose[0, 0]).all() and pose[-1, 1, 0] < 2.9


@pytest.mark.parametrize(
    "text, along, message",
    [
        (SCENARIO, "gain", "--along 'gain': wanted KEY=END"),
        (SCENARIO, "control.rate=nan", "--along 'control.rate=nan': wanted KEY=END, END a number"),
        (SCENARIO, "control.protocol=1", "control.protocol: wanted a number"),
        (SCENARIO, "control.rte=1", "--along.control: unknown 'rte'; did you mean 'rate'?"),
        (SCENARIO, "control.parameters.gian=1", "unknown 'gian'; did you mean 'gain'?"),
        (SCENARIO, "control.parameters.slope=1", "unknown 'slope' (known: gain, l)"),
        (SCENARIO, "control.parameters.l=1", "wanted a number in the scenario"),
        (SCENARIO, "control.rate=10", "--along control.rate=10: the scenario's own value, wanted"),
        (SCENARIO.replace("10 m", "1 m"), "control.rate=1", "near has no margin"),
    ],
)
def test_bad_input_is_named(tmp_path, capsys, text, along, message):
    path = scenario_file(tmp_path, text)
    assert run(path, "--out", tmp_path / "out", "--along", along) == 2
    assert message in capsys.readouterr().err


def test_usual_axes_begin_at_what_the_scenario_has():
    content = {"control": {"rate": 20}, "mismatch": {"delay": 0.1, "speed": [1.0, 0.9]}}
    axes = {(axis.key, axis.end): axis.nominal for axis in axes_of(TWO, content)}
    assert axes["control.rate", 1.0] == 20.0 and axes["mismatch.delay", 1.0] == 0.1
    assert axes["links.loss", 0.9] == 0.0
    assert not any(key == "mismatch.speed" for key, _ in axes)  # a list is no number


NOISY = """
odometry_errors: {alpha: [0.01, 0, 0, 0.02, 0, 0], Ed: 1.01, gyro: {bias: 0.1, walk: 0.3}}
sensors:
  - mounts: &mounts
      gps: {type: gps, rate: 5 Hz, noise: {stddev: 5 cm, bias: {stddev: 0.1}, dropout: 0.1}}
      imu: {type: imu, noise: {rate: {stddev: 1 deg/s, bias: 0.2}}}
  - {robots: [2], mounts: *mounts}
"""


def test_noise_is_an_axis_where_a_scenario_states_some():
    content = dict(yaml.safe_load(NOISY), poses=[[0, 0, 0], [3, 0, 0]])
    axis = axes_of(TWO, content)[-1]
    assert (axis.key, axis.nominal, axis.end) == ("noise", 1.0, 10.0)
    larger = content_with(content, {"noise": 3.0})
    errors = larger["odometry_errors"]
    assert errors["alpha"] == pytest.approx([0.09, 0, 0, 0.18, 0, 0])  # variances
    assert errors["gyro"] == {"bias": 0.1, "walk": pytest.approx(0.9)} and errors["Ed"] == 1.01
    for mounts in (each["mounts"] for each in larger["sensors"]):
        gps, imu = mounts["gps"]["noise"], mounts["imu"]["noise"]
        assert gps["stddev"] == "15.0 cm" and gps["bias"]["stddev"] == pytest.approx(0.3)
        assert imu == {"rate": {"stddev": "3.0 deg/s", "bias": 0.2}} and gps["dropout"] == 0.1
    assert content["odometry_errors"]["alpha"][0] == 0.01  # a copy was changed
    with pytest.raises(ScenarioError, match="noise: -1, wanted"):
        content_with(content, {"noise": -1})
    del content["odometry_errors"], content["sensors"]
    assert "noise" not in {axis.key for axis in axes_of(TWO, content)}


def test_axes_begin_at_entries_of_lists():
    content = {"mismatch": {"speed": [1.0, 0.9]}, "sensors": [{"noise": {"range": 0.02}}]}
    wanted = [("mismatch.speed[1]", 0.5), ("sensors[0].noise.range", 0.2)]
    assert [axis.nominal for axis in axes_of(TWO, content, wanted)] == [0.9, 0.02]


@pytest.mark.parametrize("key", ["mismatch.speed[2]", "mismatch.speed.1", "mismatch.speed[-1]"])
def test_what_is_no_entry_of_a_list_is_refused(key):
    with pytest.raises(ScenarioError, match="wanted a number in the scenario"):
        axes_of(TWO, {"mismatch": {"speed": [1.0, 0.9]}}, [(key, 0.5)])


def test_rates_are_spaced_by_ratios():
    rate = Axis("control.rate", 16.0, 1.0, "Hz")
    assert rate.at(0.5) == 4.0 and rate.share(2.0) == pytest.approx(0.75)
    delay = Axis("mismatch.delay", 0.0, 1.0, "s")
    assert delay.at(0.5) == 0.5 and delay.share(0.25) == 0.25


AXES = [
    {
        "key": "mismatch.delay",
        "unit": "s",
        "nominal": 0.0,
        "end": 1.0,
        "breaks": {"kept": [0.21, 0.2101], "near": None},
    }
]


@pytest.mark.parametrize("delay, passed", [(0.1, True), (0.155, False), (0.3, False)])
def test_what_is_measured_is_compared_with_the_margin(delay, passed):
    (check,) = margin_checks({"axes": AXES}, {"mismatch.delay": [0.0, delay]})
    assert check.passed is passed and check.subject == "margin of mismatch.delay"
    assert check.text.startswith("{:g} s measured, kept breaks at 0.21 s".format(delay))
    assert ("wanted 1.5 times" in check.text) is not passed


def report_with(names):
    breaks = dict.fromkeys(names)
    breaks[names[0]] = [0.21, 0.2101]
    axes = [dict(AXES[0], breaks=breaks, tried=8, refused="")]
    axes.append(dict(axes[0], key="links.loss", unit="", breaks=dict.fromkeys(names)))
    rest = {"dead": {}, "together": None, "failed": "", "runs": 9}
    return {"nominal": dict.fromkeys(names, 1.0), "axes": axes, **rest}


def test_a_wide_table_is_listed_axis_by_axis():
    claims = [
        "{} of the team at the end of the run [m]".format(k) for k in ("worst", "mean", "rms")
    ]
    assert lines_of(report_with(claims)) == [
        "mismatch.delay [s] 0 to 1: 2 of 3 hold",
        "  worst of the team at the end of the run [m]  breaks at 0.2101",
        "links.loss 0 to 1: all 3 hold",
        "9 runs",
    ]
    without = report_with(claims)
    without["axes"][1]["acts"] = False
    assert lines_of(without)[2] == "links.loss 0 to 1: no effect"
    assert "  near" in lines_of(report_with(["kept", "near"]))[0]  # which fits a table


TRACKING = SCENARIO.replace("consensus", "trajectory").replace(
    "agree: eventually[0, 9] ", "apart: "
)


def test_an_axis_without_effect_is_said_to_have_none(tmp_path, capsys):
    """The law receives no messages, of which none is lost, then; its robots obey late."""
    path, out = scenario_file(tmp_path, TRACKING.replace("< 0.1", "> 0.1")), tmp_path / "out"
    along = "--along", "links.loss=0.9", "--along", "mismatch.delay=0.2"
    assert run(path, "--out", out, *along, "--formats", "") == 0
    report = read_margins(str(out))
    assert [axis["acts"] for axis in report["axes"]] == [False, True]
    said = capsys.readouterr().out
    assert "links.loss 0 to 0.9          no effect" in said
    assert "same to spare, to the bit, at each value tried of links.loss\n" in said
    (check,) = margin_checks(report, {"links.loss": [0.1]})
    assert check.passed and check.text == "0.1 measured, no effect to 0.9"
    for row in report["axes"]:
        row["breaks"] = dict.fromkeys(report["nominal"])
    figure = margins_figure(report, 5.0)
    grey, green = [{line.get_color() for line in panel.lines} for panel in figure.axes]
    assert NEUTRAL in grey - green and PASSED in green - grey
    texts = [each.get_text() for each in figure.axes[0].get_legend().get_texts()]
    assert texts == ["scenario", "holds", "breaks", "no effect"]


def test_the_figure_has_words_and_units_of_every_usual_axis():
    figure = margins_figure(report_with(["kept", "near"]), 3.5)
    labels = [panel.get_xlabel() for panel in figure.axes if panel.get_xlabel()]
    assert labels == ["delay of commands [s]", "share of lost messages [-]"]
    assert {axis.key for axis in USUAL} == set(WORDS)
    assert all("[{}]".format(axis.unit or "-") in WORDS[axis.key] for axis in USUAL)


def test_the_worst_corner_stands_in_the_figure():
    report = report_with(["kept", "near"])
    assert not any(
        line.get_linestyle() == "-." for line in margins_figure(report, 5.0).axes[0].lines
    )
    report["together"] = {"corner": {"mismatch.delay": 0.25, "links.loss": 0.125}}
    figure = margins_figure(report, 5.0)
    for panel, value in zip(figure.axes, (0.25, 0.125)):
        (line,) = [each for each in panel.lines if each.get_linestyle() == "-."]
        assert list(line.get_xdata()) == [value, value]
    texts = [each.get_text() for each in figure.axes[0].get_legend().get_texts()]
    assert texts[-1] == "worst corner, together"


def test_what_is_not_measured_or_does_not_break_is_no_trouble():
    (check,) = margin_checks({"axes": AXES}, {"control.rate": [9.0]})
    assert check.passed and check.text == "not measured, kept breaks at 0.21 s"
    free = [dict(AXES[0], breaks={"near": None})]
    (check,) = margin_checks({"axes": free}, {"mismatch.delay": [0.3]})
    assert check.passed and "all hold to 1 s" in check.text
    assert margin_checks({"axes": free}, {}) == []
    (check,) = margin_checks({"axes": free}, {"mismatch.delay": [1.5]})
    assert not check.passed and check.text == "1.5 s measured, tried only to 1 s"


def test_margins_are_of_the_scenario_and_law_as_they_are_now(tmp_path):
    path, out = scenario_file(tmp_path), tmp_path / "out"
    assert run(path, "--out", out, "--along", "control.rate=9", "--formats", "") == 0
    report = read_margins(str(out))

    def check(text):
        path.write_text(text)
        scenario = load_scenario(path)
        return scenario_check(report, scenario, scenario.limits)

    assert check(SCENARIO).passed
    changed = check(SCENARIO.replace("gain: 3.0", "gain: 4.0"))
    assert not changed.passed and str(path) in changed.text
    del report["stamp"]
    assert not check(SCENARIO).passed


def test_margins_are_of_the_speeds_that_robots_are_held_to():
    stated = scenario_from_dict({"poses": [[0, 0, 0], [3, 0, 0]]})  # of Pioneers

    def check(measured, v_max):
        report = {"stamp": stamp_of(stated._replace(limits=measured))}
        return scenario_check(report, stated, limited(stated.limits, v_max))

    assert check("firmware", 0.8).passed  # which lowers nothing
    assert check(LoweredLimits("firmware", 0.2), 0.2).passed
    held = check("firmware", 0.2)
    assert not held.passed and held.text.startswith("at up to 0.75 m/s and 1.75 rad/s, robots are")
    assert "held to 0.2 m/s and 1.75 rad/s: measure them again with such limits" in held.text
    other = check(LoweredLimits("firmware", 0.3), 0.2)
    assert not other.passed and "of another scenario or law" in other.text


def test_files_of_other_programs_are_named(tmp_path):
    path = tmp_path / "margins.json"
    path.write_text("[]")
    for read, wanted in ((read_margins, "margins wrote"), (read_measured, "--compare wrote")):
        with pytest.raises(MarginsError, match=wanted):
            read(str(path))
    path.write_text("{")
    with pytest.raises(MarginsError, match="margins.json"):
        read_margins(str(tmp_path))
    path.write_text('{"mismatch": {"delay": 0.12, "speed": [0.98, 1.01]}}')
    measured = {"mismatch.delay": [0.12], "mismatch.speed": [0.98, 1.01]}
    assert read_measured(str(path)) == measured


def test_speed_may_be_zero_and_not_negative():
    content = {"poses": [[0, 0, 0]], "mismatch": {"speed": -0.1}}
    with pytest.raises(ValueError, match="mismatch.speed"):
        scenario_from_dict(content)


def test_an_axis_of_which_no_value_is_possible_is_refused_before_any_run(tmp_path, capsys):
    out = tmp_path / "out"
    arguments = "--out", out, "--along", "mismatch.delay=-3", "--formats", ""
    assert run(scenario_file(tmp_path), *arguments) == 2
    said = capsys.readouterr().err
    assert (
        "margins: --along mismatch.delay=-3: mismatch.delay: -3.0, wanted a number from 0" in said
    )
    assert not out.exists()


def test_values_that_are_refused_are_said_to_be(tmp_path, capsys):
    out = tmp_path / "out"
    arguments = "--out", out, "--along", "mismatch.delay=4", "--formats", ""
    assert run(scenario_file(tmp_path), *arguments) == 0
    said = capsys.readouterr().out
    assert "mismatch.delay: refused at some values: " in said and "from 0 to 2 [s]" in said
    (axis,) = json.loads((out / "margins.json").read_text())["axes"]
    assert axis["tried"] == 4 and axis["breaks"]["agree"]


def test_an_axis_that_is_refused_is_said_to_be():
    report = report_with(["kept"])
    report["axes"][1].update(tried=0, refused="no")
    assert "links.loss 0 to 1          refused" in lines_of(report)


def test_a_law_that_gives_nan_is_reported_and_margins_are_not(tmp_path, capsys):
    (tmp_path / "law.py").write_text(
        "from mrs_simulator import PioneerControl\n\n\nclass Nan(PioneerControl):\n"
        "    def pointMassLaw(self, hand):\n        return hand * float('nan')\n"
    )
    path = scenario_file(tmp_path, SCENARIO.replace("consensus", "law.py").replace("gain: 3.0", ""))
    assert run(path, "--out", tmp_path / "out") == 2
    said = capsys.readouterr().err
    assert "law has no margin" in said and "Traceback" not in said
    study = simulate(str(path))
    assert study.verdict["outcome"] == "failed" and "nan" in study.verdict["ended"]
    assert {each["note"] for each in study.verdict["requirements"]} == {
        "the run ended at its first command"
    }
