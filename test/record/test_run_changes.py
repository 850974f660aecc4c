"""What a controller obeyed during a run: its record, and verdicts on runs with changes on the way."""

import json

import numpy as np
import pytest
from protocol_fixtures import shipped

from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import Collision, read_run_csv, write_facts
from mrs_simulator.record.run_changes import (
    Change,
    ControllerRecord,
    changed_by,
    changes_text,
    controller_settings,
    to_plain,
)
from mrs_simulator.ros.message_forms.messages import (
    MessageError,
    control_scenario,
    read_control_scenario,
)
from mrs_simulator.scenario.requirements import Requirement
from mrs_simulator.scenario.scenario import ScenarioError
from mrs_simulator.study.results.report import control_of
from mrs_simulator.study.run.applied_scenario import what_ran
from mrs_simulator.study.run.experiment import perform
from mrs_simulator.vehicles.portable import portable
from mrs_simulator.verdict.judging import judged


def with_gain(scenario, gain, name="gain"):
    values = dict(scenario.control.parameters, **{name: gain})
    control = scenario.control._replace(parameters=values)
    return scenario._replace(control=control)


def with_edges(scenario, edges):
    return changed_by(scenario, [Change(0.0, "topology", {"edges": edges, "directed": False})])


# The record --------------------------------------------------------------------------------------


def test_what_was_in_force_at_the_begin_and_what_changed_until_the_end():
    record, scenario = ControllerRecord(), shipped("consensus", {"gain": 0.5})
    assert record.during(0.0, 1.0) == (None, [])
    for stamp, gain in [(1.0, 0.1), (2.0, 0.2), (5.5, 0.3), (7.0, 0.4), (9.0, 0.5)]:
        record.note(stamp, controller_settings(with_gain(scenario, gain)))
    first, changes = record.during(4.0, 8.0)
    assert first["control"]["parameters"]["gain"] == 0.2
    assert [(c.time, c.key) for c in changes] == [(1.5, "control"), (3.0, "control")]
    assert changed_by(scenario, changes).control.parameters["gain"] == 0.4
    assert record.during(0.5, 0.6)[0]["control"]["parameters"]["gain"] == 0.1  # heard a little late


def test_another_run_begins_with_what_is_in_force_though_time_goes_back():
    record, scenario = ControllerRecord(), shipped("consensus")
    for stamp, gain in [(1.0, 0.1), (50.0, 0.2)]:
        record.note(stamp, controller_settings(with_gain(scenario, gain)))
    record.begin_run()
    first, changes = record.during(2.0, 60.0)
    assert (first["control"]["parameters"]["gain"], changes) == (0.2, [])


def test_the_message_carries_it_and_refuses_anything_else():
    obeyed = controller_settings(shipped("formation_lossy"))
    assert {"control", "topology", "links"} <= set(obeyed)
    message = control_scenario(obeyed)
    message.header.stamp.secs = 3
    assert read_control_scenario(message) == (3.0, obeyed)
    message.obeyed = json.dumps(dict(obeyed, top_speeds={"v_max": 0.25}))
    assert read_control_scenario(message)[1]["top_speeds"] == {"v_max": 0.25}
    for speeds in ('{"v_max": "fast"}', '{"v_max": NaN}', '{"v_max": -1.0}', '{"v": 1.0}', "[]"):
        message.obeyed = '{{"top_speeds": {}}}'.format(speeds)
        with pytest.raises(MessageError, match="top_speeds: .* wanted numbers of at least 0 for"):
            read_control_scenario(message)
    for wrong in ("", "[]", "3", '{"poses": []}', '"control"', "[" * 100000):
        message.obeyed = wrong
        with pytest.raises(MessageError):
            read_control_scenario(message)


# What ran ----------------------------------------------------------------------------------------


def test_a_scenario_takes_what_stage_and_controller_have_otherwise():
    edited = shipped("paper_four", title="Four robots")
    edited = edited._replace(requirements=(Requirement("apart", "always(distance > 1 m)"),))
    stage = portable(shipped("paper_four", fidelity="dynamic").with_robots(6))[0]
    ran, unknown = what_ran(
        edited, stage, controller_settings(with_gain(shipped("consensus"), 0.7))
    )
    assert (ran.n, ran.fidelity, ran.control.protocol, unknown) == (6, "dynamic", "consensus", "")
    assert ran.control.parameters["gain"] == 0.7
    assert ran.title == "6 robots, consensus"
    assert (ran.duration, ran.requirements) == (edited.duration, edited.requirements)


def test_a_scenario_that_ran_as_it_stands_stays_as_it_is():
    edited = shipped("formation_mixed", title="Mine")
    assert what_ran(edited, portable(edited)[0], controller_settings(edited)) == (edited, "")


def test_no_robot_is_faster_than_its_controller_lets_it():
    mine, speeds = shipped("consensus"), {"v_max": 0.25}
    record = ControllerRecord()
    record.note(0.0, dict(controller_settings(mine), top_speeds=speeds))
    record.note(2.0, dict(controller_settings(mine), top_speeds={"v_max": 0.1}))
    obeyed, changes = record.during(1.0, 3.0)
    ran, unknown = what_ran(mine, portable(mine)[0], obeyed)
    assert (ran.limits.v_max, unknown, changes) == (0.25, "", [])
    assert ran == mine._replace(limits=ran.limits)
    assert what_ran(ran, portable(mine)[0], obeyed).scenario.limits == ran.limits


def test_a_law_that_a_topic_names_is_named_and_runs_no_code(tmp_path):
    (tmp_path / "law.py").write_text("raise SystemExit('code was run')")
    law = "{}:Law".format(tmp_path / "law.py")
    obeyed = controller_settings(shipped("consensus"))
    obeyed["control"] = dict(obeyed["control"], protocol=law)
    ran, unknown = what_ran(shipped("consensus", duration=1.0), obeyed=obeyed)
    assert (ran.control.protocol, unknown) == (law, law)
    run, _ = perform(shipped("consensus", duration=1.0), str(tmp_path / "run"))
    meta = dict(run.meta, unknown_law=unknown)
    run = run._replace(scenario=ran._replace(path=str(tmp_path)), meta=meta)
    assert control_of(run) is None
    assert law in judged(run)[0]["reason"]


# Verdicts ----------------------------------------------------------------------------------------


def changed_run(scenario, changed, out, at=4.0, key="control"):
    """Return the run of ``scenario`` that goes on as ``changed`` at ``at`` [s], and its control."""
    first, _ = perform(scenario._replace(duration=at), str(out / "first"))
    begun = changed._replace(poses=first.pose[-1])
    rest, _ = perform(begun, str(out / "rest"))
    time = np.concatenate([first.time[:-1], first.time[-1] + rest.time])
    joined = {
        name: np.concatenate([getattr(first, name)[:-1], getattr(rest, name)])
        for name in ("pose", "hand", "command", "twist")
        if getattr(first, name) is not None
    }
    changes = [Change(at, key, controller_settings(changed)[key])]
    meta = dict(rest.meta, changes=changes)
    return first._replace(time=time, scenario=scenario, meta=meta, **joined), make_control(scenario)


def points(name, **changes):
    return shipped(name, fidelity="point_mass", limits=None, **changes)


def test_theory_is_compared_with_what_comes_after_a_change(tmp_path):
    scenario = with_gain(points("consensus", duration=25.0), 0.2)
    run, control = changed_run(scenario, with_gain(scenario, 0.5), tmp_path)
    verdict, track = judged(run, control)
    assert verdict["outcome"] == "passed", verdict
    told = "gain 0.2 -> 0.5 at 4.00 s"
    judged_checks = [c for c in verdict["checks"] if "from 4.1 s on" in c["note"]]
    assert judged_checks and all(told in c["note"] for c in judged_checks)
    assert any(told in text for text in verdict["warnings"])
    assert track["time"][0] == run.time[41]  # at the change the command may still be the one before
    # Nothing of it passes as a run with the gain it began with.
    meta = {key: value for key, value in run.meta.items() if key != "changes"}
    assert judged(run._replace(meta=meta), control)[0]["outcome"] == "failed"


def test_a_collision_before_the_change_is_no_fault_of_the_law(tmp_path, capfd):
    scenario = with_gain(points("consensus", duration=6.0), 0.2)
    run, control = changed_run(scenario, with_gain(scenario, 0.5), tmp_path)
    touched = run._replace(collisions=[Collision(1.0, "robot1", "robot2", 0.0, 0.0)])
    verdict, _ = judged(touched, control)
    assert verdict["outcome"] == "failed"
    assert [c["name"] for c in verdict["checks"] if c["passed"] is False] == ["collisions"]
    assert "Traceback" not in capfd.readouterr().err


def test_another_graph_is_judged_from_then_on(tmp_path):
    scenario = points("consensus", duration=25.0)
    edges = [[i, i + 1, 1.0] for i in range(1, scenario.n)]
    changed = with_edges(scenario, edges)
    run, control = changed_run(scenario, changed, tmp_path, key="topology")
    verdict, _ = judged(run, control)
    assert verdict["outcome"] == "passed", verdict
    assert any("edges" in text and "at 4.00 s" in text for text in verdict["warnings"])


def test_a_law_with_a_memory_is_not_judged_after_a_change(tmp_path):
    scenario = points("second_order_consensus", duration=6.0)
    assert not make_control(scenario).MEMORYLESS
    run, control = changed_run(scenario, with_gain(scenario, 3.0, "g"), tmp_path)
    verdict, track = judged(run, control)
    assert (verdict["outcome"], track) == ("not_judged", None)
    assert "changed during the run" in verdict["reason"]


def test_changes_are_read_back_and_checked(tmp_path):
    scenario = points("consensus", duration=1.0)
    perform(scenario, str(tmp_path))
    path = str(tmp_path / "run.csv")
    changes = [Change(0.5, "control", controller_settings(with_gain(scenario, 0.9))["control"])]
    write_facts(path, meta={"changes": to_plain(changes)})
    assert read_run_csv(path, scenario).meta["changes"] == changes
    assert "gain" in changes_text(scenario, changes)
    write_facts(path, meta={"changes": [[0.5, "poses", []]]})
    with pytest.raises(ValueError, match="poses"):
        read_run_csv(path, scenario)


def test_a_change_that_no_scenario_has_is_named():
    with pytest.raises(ScenarioError, match="rate"):
        changed_by(shipped("consensus"), [Change(1.0, "control", {"rate": -1.0})])
