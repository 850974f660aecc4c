"""Drivers with a dead band: what small commands are sent as, and what claims allow for it."""

import shlex

import numpy as np
import pytest

from mrs_simulator.nodes.control import requests
from mrs_simulator.protocols.formation.law import Formation
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import ScenarioError, load_scenario, scenario_from_dict
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.run.experiment import perform, run_experiment
from mrs_simulator.verdict.judging import judged

BAND = 0.01  # [m/s, rad/s]
START = np.array([[2.5, -2.0], [0.5, 1.5], [-1.0, -1.5], [-2.5, 0.5]])


def lab(deadband=BAND, **more):
    scenario = load_scenario(scenario_path("lab_four.yaml"))
    return scenario._replace(control=scenario.control._replace(deadband=deadband), **more)


def test_a_scenario_has_a_dead_band_where_it_says_so():
    plain = lab(0.0).to_dict()
    assert plain["control"]["deadband"] == 0.0
    plain["control"]["deadband"] = BAND
    assert scenario_from_dict(plain).control.deadband == BAND
    assert scenario_from_dict(plain).to_dict() == plain
    plain["control"]["deadband"] = -1
    with pytest.raises(ScenarioError, match="control.deadband"):
        scenario_from_dict(plain)


def test_small_commands_are_zero_and_others_whole():
    control = make_control(lab(), Formation)
    pose = np.array([[4.5, 0.06, 0.0], [3.0, 0.02, 0.0], [1.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    # Robot 1 is 0.04 m beside its place, 0.008 m/s, which 0.02 rad/s at 0.4 m would give.
    command = control.commands(pose)
    assert command[0] == pytest.approx([0.0, -0.02]) and not command[1:].any()


def test_the_line_may_be_off_by_what_the_dead_band_swallows():
    exact, band = (
        {claim.name: claim for claim in make_control(lab(b), Formation).claims(START)}
        for b in (0.0, BAND)
    )
    # Each robot of the chain rests within sqrt(1 + l^2) deadband/kappa of its place; kappa = 0.2 /s.
    left = np.hypot(1.0, 0.4) * BAND / 0.2
    for name, times in (
        ("final gap, the worst [m]", 1),
        ("y spread [m]", 3),
        ("distance from final place [m]", 3),
    ):
        more = band[name].tolerance - exact[name].tolerance
        assert more == pytest.approx(times * left)


def test_a_run_with_a_dead_band_is_judged_by_it(tmp_path):
    verdict = run_experiment(lab(odometry="world", record_rate=10), str(tmp_path), formats=())
    assert verdict["outcome"] == "passed", verdict
    checks = {check["name"]: check for check in verdict["checks"]}
    # More than without: the dead band does show.
    assert checks["y spread [m]"]["measured"] > 0.1
    assert checks["commands off the published law [-]"]["passed"]


def test_what_a_dead_band_costs_is_allowed_once(tmp_path):
    run, control = perform(lab(odometry="world", record_rate=10), str(tmp_path))
    sharp = make_control(lab(0.0, odometry="world"))
    exact = {claim.name: claim for claim in sharp.all_claims(run.hand[0])}
    names = "final gap, the worst [m]", "y spread [m]", "distance from final place [m]"
    for lockstep in (True, False):
        verdict = judged(run._replace(meta=dict(run.meta, lockstep=lockstep)), control)[0]
        checks = {check["name"]: check for check in verdict["checks"]}
        for name in names:
            missed = abs(checks[name]["measured"] - checks[name]["predicted"])  # by sound robots
            allowed = checks[name]["tolerance"] - missed
            assert 0.0 <= allowed <= exact[name].tolerance + 1e-3, (name, lockstep)


def test_the_printed_preflight_has_all_that_a_launch_file_set(monkeypatch):
    given = {"deadband": 0.01, "geofence": "-4, -4, 4, 4", "v_max": [0.1, 0.2], "resume": ""}
    given.update(odom_topic="/robot{}/pose", min_distance=0.0, omega_max="", autostart=False)
    monkeypatch.setattr("rospy.get_param", lambda name, default=None: given.get(name[1:], default))
    monkeypatch.setattr("rospy.resolve_name", lambda name: "/pioneer_control/" + name[1:])
    argv = ["pioneer_control", "--scenario", "lab.yaml", "_v_max:=9", "__name:=c"]
    monkeypatch.setattr("sys.argv", argv)
    said = requests.how_to_start("formation")
    check, start = said.split(", then: ")
    assert start == "rosservice call /pioneer_control/start"
    assert shlex.split(check)[2:] == [
        *("preflight", "--scenario", "lab.yaml", "--protocol", "formation"),
        *("_geofence:=-4, -4, 4, 4", "_v_max:=[0.1, 0.2]", "_deadband:=0.01"),
        "_odom_topic:=/robot{}/pose",
    ]
