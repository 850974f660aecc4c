"""What the GUI does with a scenario and a run, without Qt and ROS: edits, what is sent, what is said."""

import threading
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pytest
from gui_fixtures import PREDICTS
from protocol_fixtures import shipped
from ros_fixtures import wait_until
from snapshots import snapshot_of

from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.nodes.stage.world_topics import stamp_at
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.controller_log import EMERGENCY, Interruptions, failure
from mrs_simulator.record.recording import Collision, read_run_csv
from mrs_simulator.record.run_changes import controller_settings
from mrs_simulator.ros.message_forms.messages import team_state
from mrs_simulator.rqt_plugin.ros_side import inbox
from mrs_simulator.rqt_plugin.run import history as history_module
from mrs_simulator.rqt_plugin.run.history import History
from mrs_simulator.rqt_plugin.run.study_run import WHOLE, StudyRun, how_ended, last_lines
from mrs_simulator.rqt_plugin.window import pending
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.study.results.report import predicted_settling, read_run
from mrs_simulator.study.run.experiment import Experiment, run_experiment
from mrs_simulator.vehicles.portable import portable
from mrs_simulator.verdict.estimation import UNKNOWN

pytestmark = pytest.mark.usefixtures("no_predictions", "forked_programs")
FAILED = failure(ValueError("no"))


class Connection:
    """What was received, all of it fresh, and ``asked``: what was asked for."""

    def __init__(self, snapshot=None, **received):
        self._snapshot, self.received, self.asked = snapshot, received, []
        self.controller, self.first_stamp = Interruptions(), lambda: 0.0

    registered = ()

    def silence(self, name):
        return 0.0 if name in self.received else None

    def newest(self, name):
        return self.received.get(name)

    def is_fresh(self, name):
        return name in self.received

    def forget(self, name):
        self.received.pop(name, None)

    def snapshot(self):
        return self._snapshot

    def __getattr__(self, name):
        return lambda *arguments: self.asked.append((name,) + arguments)


class Processes:
    """Programs ``running`` and ``ending``, by name, in ``directory``."""

    def __init__(self, running=(), ending=(), directory=""):
        self.running, self.ending, self.directory = set(running), set(ending), str(directory)
        self.ended = []

    def is_running(self, name):
        return name in self.running

    def is_ending(self, name):
        return name in self.ending

    def age(self, name):
        return 0.0

    def cancel(self, name):
        self.cancelled = name

    def start(self, name, *arguments, **__):
        self.running.add(name)
        self.arguments = arguments

    def stop(self, name):
        self.running.discard(name)

    def take_ended(self):
        ended, self.ended = self.ended, []
        return ended

    def run(self, *_, **__):
        return 0, ""


def study(scenario="consensus", connection=None, processes=None, **parameters):
    run = StudyRun(connection or Connection(), processes or Processes(), shipped("paper_four"))
    run.edited.take(shipped(scenario, parameters))
    return run


# Edits -------------------------------------------------------------------------------------------


def test_an_edit_that_the_protocol_refuses_leaves_all_as_it_was():
    run = study("containment")
    before = run.scenario, run.edited.derived
    assert "leaders = 4" in run.edited.set_team(run.scenario.poses[:2], run.scenario.kinds[:2])
    assert "no_such" in run.edited.set_protocol("no_such")
    assert "gain" in run.edited.set_parameters({"gain": "much"})
    assert (run.scenario, run.edited.derived) == before


@pytest.mark.parametrize("method", ["targets", "warnings", "prediction"])
def test_a_law_of_ones_own_that_raises_when_asked_is_not_taken_up(method, tmp_path):
    law = tmp_path / "law.py"
    law.write_text(
        "from mrs_simulator.control.pioneer_control import PioneerControl\n"
        "class Law(PioneerControl):\n"
        "    def pointMassLaw(self, hand): return 0.0 * hand\n"
        "    def targets(self, hand): return hand\n"
        "    def {}(self, *_): return len(3)\n".format(method)
    )
    run = study()
    before = run.scenario
    assert "TypeError: object of type 'int'" in run.edited.set_protocol(str(law))
    assert run.scenario is before
    with pytest.raises(ValueError, match="TypeError.*\n.*law.py:5, in {}".format(method)):
        run.edited.take(before.with_protocol(str(law)))
    assert run.scenario is before and run.edited.derived.protocol == "Consensus"


@PREDICTS
def test_the_prediction_is_computed_in_the_background_and_no_further_than_is_bearable():
    run = study("paper")
    when, error, settling = wait_until(run.edited.take_prediction)[0]
    assert len(when) == len(error) and when[-1] == run.scenario.duration
    assert settling == "49.7 s, its settling time"  # the verdict's own prediction
    assert run.edited.set_parameters({"T": 1e-4, "k": 1e-4}) == ""
    when, error, settling = wait_until(run.edited.take_prediction)[0]
    assert when[-1] == pytest.approx(2e6 / 7 * 1e-4) and len(error) == len(when)
    assert settling == ""


@pytest.mark.parametrize(
    "name, parameters, reported",
    [
        ("discrete_consensus", {}, "s to 2 %, at "),
        ("consensus", {"gain": 0.2}, "s to 2 %, at 0.2"),
        ("consensus", {"gain": -1.0}, ""),  # its condition does not hold
        ("flocking", {}, ""),
    ],
)
def test_the_settling_is_what_the_protocol_claims(name, parameters, reported):
    control = make_control(shipped(name, parameters))
    settling = predicted_settling(control, hand_points(shipped(name).poses, control.l))
    assert settling == reported or (reported and reported in settling)


# What runs follows -------------------------------------------------------------------------------

STANDS = SimpleNamespace(running=False, trouble="stopped", stale=[], command=[[0.0, 0.0]] * 6)


@pytest.mark.parametrize(
    "connection, processes, sent",
    [
        (Connection(control=STANDS), Processes(["control"]), True),
        (Connection(control=STANDS), Processes(), True),  # started elsewhere
        (Connection(), Processes(["control"]), True),  # about to start
        (Connection(control=STANDS), Processes(ending=["control"]), False),
        (Connection(), Processes(), False),
    ],
)
def test_an_edit_reaches_a_controller_that_stands(connection, processes, sent):
    run = study(connection=connection, processes=processes)
    assert (
        run.edited.set_parameters({"gain": 0.25})
        == run.edited.set_topology([(1, 2, 1.0)], True)
        == ""
    )
    wanted = [("set_parameters", {"gain": 0.25, "l": 0.05}), ("set_topology", [(1, 2, 1.0)], True)]
    assert connection.asked == (wanted if sent else [])


def test_a_controller_of_another_team_is_not_asked_to_start(tmp_path):
    run = study(connection=Connection(control=STANDS), processes=Processes(directory=tmp_path))
    run.do("control")
    assert run.connection.asked == [("ask", "start")] and not run.processes.running
    run.edited.set_team(run.scenario.poses[:5], run.scenario.kinds[:5])
    assert "controller started" in run.do("control") and run.processes.running == {"control"}


def test_what_a_running_stage_does_not_take_over_is_said():
    text = shipped("consensus", fidelity="dynamic", limits="top").to_yaml()
    received = {"stage": SimpleNamespace(), "scenario": text}
    run = study(connection=Connection(**received))
    assert "its own fidelity, limits: end it to use" in run.stage.kept()
    run.edited.take(shipped("consensus", fidelity="dynamic", limits="top"))
    assert run.stage.kept() == ""


def test_a_simulation_that_has_ended_is_none_to_attach_to():
    run = study(connection=Connection(stage=SimpleNamespace(), state=SimpleNamespace()))
    run.processes.ended = [("stage 123", 0, "")]
    assert run.ended_processes() == [] and run.connection.received == {}
    assert run.do("simulate") == "" and run.connection.asked == [("begin_simulated_time",)]


@pytest.mark.parametrize("protocol, law", [("marching", "Marching"), ("evil:Law", "Consensus")])
def test_attaching_takes_up_what_runs_but_no_code(protocol, law):
    reported = shipped("marching", speed=1.0)
    reported = reported._replace(control=reported.control._replace(protocol=protocol))
    received = {"stage": SimpleNamespace(speed=5.0), "scenario": reported.to_yaml()}
    run = study(connection=Connection(**received))
    assert run.do("simulate") == "attached to the running stage" and run.connection.asked == []
    assert run.scenario.poses.tolist() == reported.poses.tolist() and run.scenario.speed == 5.0
    assert run.edited.derived.protocol == law


@pytest.mark.parametrize(
    "own, said",
    [
        ({"base": "epuck", "mass": 3}, "attached to the running stage"),
        ({"base": "/tmp/epuck.yaml"}, "not attached: 'kinds.mine.base': a file"),
        ({"base": "epuck", "wheels": {"radius": -1}}, "not attached: kinds.mine"),
    ],
)
def test_attaching_takes_kinds_that_are_published_as_data(own, said):
    reported = shipped("consensus", speed=1.0)
    reported = reported._replace(kinds=("mine",) * reported.n, own_kinds={"mine": own})
    received = {"stage": SimpleNamespace(speed=1.0), "scenario": reported.to_yaml()}
    run = study(connection=Connection(**received))
    assert str(run.do("simulate")).startswith(said)
    assert (run.scenario.kinds[0] == "mine") == said.startswith("attached")


def test_a_stage_whose_scenario_cannot_be_read_is_not_attached_to():
    run = study(connection=Connection(stage=SimpleNamespace(speed=1.0, lockstep=False)))
    before = run.scenario
    assert "not attached" in run.do("simulate")
    run.connection.received["scenario"] = "poses: 3"
    assert "not attached: stage/scenario" in run.do("simulate") and run.scenario is before


def test_no_team_is_sent_to_robots_under_way():
    run = study(connection=Connection(control=SimpleNamespace(**dict(vars(STANDS), running=True))))
    assert "stop the controller" in run.send_team() and run.connection.asked == []


def test_a_team_is_sent_to_robots_of_a_run_that_is_over_once_their_controller_has_stopped():
    runs = SimpleNamespace(**dict(vars(STANDS), running=True))
    run = study(connection=Connection(control=runs))
    run.state.is_over = lambda: True
    assert run.state.team_locked() == "" and "press Reset" in run.state.poses_locked(4)
    assert run.send_team() == "" and run.connection.asked == [("ask", "stop")]
    run.take_result("stop", True, "stopped")
    assert run.connection.asked[-1][0] == "set_team" and len(run.connection.asked) == 2
    run.take_result("stop", True, "stopped")  # of the button Stop
    assert len(run.connection.asked) == 2


def test_a_team_edited_while_the_simulation_starts_is_sent_once_that_is_there(monkeypatch):
    monkeypatch.setattr(pending, "TEAM_REST", -1.0)
    connection, processes = Connection(), Processes(running=["stage"])
    run, sent = study(connection=connection, processes=processes), []
    monkeypatch.setattr(run, "send_team", lambda: sent.append(run.scenario) or "")
    team = pending.PendingTeam(run)
    team.changed()  # then the simulation starts, with this team
    assert team.send() == "" and team.is_settled()
    processes.age = lambda name: 10.0
    team.changed()
    assert team.send() == "" and not team.is_settled() and not sent
    connection.received["state"] = None
    assert team.send() == "" and sent == [run.scenario]
    team.answered(True)
    assert team.is_settled() and team.send() == "" and len(sent) == 1


@pytest.mark.parametrize("real", [(), (2,), (1, 2)])
def test_a_saved_run_keeps_its_collisions_where_anybody_tells(tmp_path, real):
    history, connection = History(), Connection()
    for second in range(4):  # the run begins with the command at 1 s
        command = np.full((2, 2), 0.1 * (second > 0))
        pose, twist, fresh = np.zeros((2, 3)), np.full((2, 3), 0.25), np.ones(2, dtype=bool)
        history.append(snapshot_of(second, (1, 2), pose, twist, command, fresh, frozenset(real)))
    early, late = (Collision(time, "robot1", "robot2", 0.0, 0.0) for time in (0.5, 2.5))
    history.collisions.extend([] if len(real) == 2 else [early, late])
    study("paper_four", connection).files.save(history, str(tmp_path))
    ((_, _, work),) = [asked for asked in connection.asked if asked[:2] == ("do", "save")]
    work()
    run = read_run_csv(str(tmp_path / "run.csv"))
    unknown = {"collisions_unknown": True} if len(real) == 2 else {}
    assert run.collisions == ([] if unknown else [late._replace(time=1.5)])
    assert run.meta == {"warnings": [], **unknown, **({"real": list(real)} if real else {})}
    assert (run.twist == 0.25).all() if real else run.twist is None


@pytest.mark.parametrize("last", [FAILED, EMERGENCY])
def test_a_saved_run_tells_what_its_controller_said(tmp_path, last):
    history, connection = History(), Connection()
    pose, fresh = np.zeros((2, 3)), np.ones(2, dtype=bool)
    for second in range(9):  # the run begins with the command at 1 s
        command = np.full((2, 2), 0.1 * (second > 0))
        history.append(snapshot_of(second, (1, 2), pose, pose, command, fresh, frozenset()))
    for stamp, text in ((0.0, "not started"), (1.0, ""), (3.0, "late"), (4.5, ""), (7.5, last)):
        connection.controller.note(stamp, not text, text)
    study("paper_four", connection).files.save(history, str(tmp_path))
    ((_, _, work),) = [asked for asked in connection.asked if asked[:2] == ("do", "save")]
    work()
    meta = read_run_csv(str(tmp_path / "run.csv")).meta
    assert meta["ended"] == "at 6.500 s " + last
    (warning,) = meta["warnings"]
    assert "2 times, 2.0 s in all: late; " + last in warning


def estimated_run(tmp_path, reported, real=()):
    """Return a saved run of 8 s of two robots; ``reported``: estimates, (time, value) each."""
    history, connection = History(), Connection()
    pose, fresh = np.ones((2, 3)), np.ones(2, dtype=bool)
    for time in np.arange(0.0, 9.0, 0.25):  # the run begins with the command at 1 s
        command = np.full((2, 2), 0.1 * (time >= 1.0))
        history.append(snapshot_of(time, (1, 2), pose, pose, command, fresh, frozenset(real)))
        # Some come before the samples of their times, some after.
        early = [each for each in reported if each[0] <= time + 0.3 * (int(time) % 2) - 0.1]
        history.take_estimates([(at, (1, 2), np.full((2, 3), value)) for at, value in early])
        reported = reported[len(early) :]
    study("paper_four", connection).files.save(history, str(tmp_path))
    ((_, _, work),) = [asked for asked in connection.asked if asked[:2] == ("do", "save")]
    work()
    return read_run_csv(str(tmp_path / "run.csv"))


def test_a_saved_run_has_the_newest_estimates_of_each_of_its_times(tmp_path):
    run = estimated_run(tmp_path, [(time, 10.0 + time) for time in np.arange(0.4, 8.5, 0.4)])
    begun = 1.0 + run.time
    assert run.time[0] == 0.0 and begun[-1] == 8.25  # of 8.5 nothing is known yet
    wanted = 10.0 + 0.4 * np.floor((begun + 1e-6) / 0.4)
    np.testing.assert_allclose(run.estimate[:, 0, 0], wanted, atol=1e-9)
    assert (run.pose == 1.0).all() and run.meta == {"warnings": []}


def test_samples_without_estimates_are_left_out_of_a_saved_run(tmp_path):
    """Estimates hold for half a second: none of 3.75 to 4.75 s are known."""
    reported = [(time, 0.0) for time in np.arange(0.0, 9.0, 0.25) if not 3.0 < time < 5.0]
    run = estimated_run(tmp_path, reported)
    gone = np.arange(3.75, 5.0, 0.25)
    begun = 1.0 + run.time
    assert not np.isin(begun, gone).any() and len(begun) == 31 - len(gone) and begun[-1] == 8.5
    (warning,) = run.meta["warnings"]
    assert warning.startswith("5 samples are left out")


def test_of_real_robots_a_saved_run_has_the_estimates_as_poses(tmp_path):
    run = estimated_run(tmp_path, [(time, 2.0) for time in np.arange(0.0, 9.0, 0.25)], real=(1, 2))
    assert run.meta["truth_unknown"] is True and UNKNOWN in run.meta["warnings"]
    assert (run.pose == 2.0).all() and (run.estimate == 2.0).all()


def test_estimates_that_tell_of_no_sample_of_a_run_are_not_saved(tmp_path):
    run = estimated_run(tmp_path, [(0.2, 2.0), (0.6, 2.0)])
    assert run.estimate is None and len(run.time) == 32 and run.meta == {"warnings": []}


def test_estimates_of_another_team_or_run_are_no_matter():
    history = commanded(History(), 4)
    history.take_estimates([(2.0, (1, 2, 3), np.zeros((3, 3)))])
    assert history.estimate is None
    history.take_estimates([(2.0, (1, 2), np.full((2, 3), 7.0))])
    np.testing.assert_array_equal(np.isfinite(history.estimate).all(axis=(1, 2)), [0, 0, 1, 0])
    history.clear()
    assert commanded(history, 4).estimate is None


@pytest.mark.parametrize(
    "code, output, said",
    [
        (-9, "[WARN] 1: collision", "killed by signal 9; its output is in the tab Programs"),
        (3, "[INFO] 1: ready\n[ERROR] 2: no map\n", "ended with 3: [ERROR] 2: no map"),
        (1, "[INFO] 1: ready", "ended with 1"),
    ],
)
def test_how_a_program_ended_in_words(code, output, said):
    assert how_ended(code, output) == said


def test_of_a_long_output_the_last_lines_are_shown_whole():
    lines = ["line {} {}".format(k, 60 * "x") for k in range(20)]
    reported = last_lines("\n".join(lines)).splitlines()
    assert 2 < len(reported) < 9 and reported == lines[-len(reported) :]
    assert last_lines(3000 * "x") == 500 * "x"


def test_a_recording_that_cannot_be_written_is_said(tmp_path, monkeypatch):
    run = study(processes=Processes(directory=tmp_path))
    (tmp_path / "mrs_runs").write_text("a file")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert "mrs_runs" in run.do("bag") and not run.processes.running


# A run that was not saved --------------------------------------------------------------------------


def commanded(history, seconds, command=0.1):
    zeros, fresh = np.zeros((2, 3)), np.ones(2, dtype=bool)
    for time in np.arange(history.time[-1] + 1.0 if len(history.time) else 0.0, 1e3)[:seconds]:
        history.append(snapshot_of(time, (1, 2), zeros, zeros, np.full((2, 2), command), fresh))
    return history


def test_a_run_is_unsaved_as_long_as_robots_moved_after_it_was_saved():
    history = History()
    assert not commanded(history, 5, 0.0).is_unsaved(2.0)
    assert commanded(history, 4).is_unsaved(2.0)
    history.saved = history.time[-1]
    assert not commanded(history, 60, 0.0).is_unsaved(2.0)
    assert commanded(history, 4).is_unsaved(2.0)


def test_an_unsaved_run_is_kept_when_another_team_or_time_begins_anew(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    run, history = study("paper_four"), History()
    history.before_clearing = lambda: said.append(run.files.keep(history))
    said = []
    commanded(history, 4)
    history.clear()
    history.clear()
    path = said[0].rpartition(" ")[2]
    assert len(said) == 1 and len(read_run_csv(path).time) == 4
    zeros = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 2)), np.ones(3, dtype=bool)
    commanded(history, 4)
    history.append(snapshot_of(0.0, (1, 2, 3), *zeros))
    assert len(said) == 2


def test_a_run_is_kept_aside_as_it_was_while_another_goes_on(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    run, history = study("paper_four"), commanded(History(), 4)
    asked = run.files._connection.do = mock.Mock()
    history.before_clearing = lambda: run.files.keep_aside(history)
    history.clear()
    commanded(history, 9, command=0.7)
    waiting = threading.Thread(target=run.files.wait_kept)
    waiting.start()
    (name, work), _ = asked.call_args
    done, said = work()
    waiting.join(20.0)
    assert not waiting.is_alive() and (name, done) == ("keep", True)
    kept = read_run_csv(said.rpartition(" ")[2])
    assert len(kept.time) == 4 and (kept.command == 0.1).all()


def test_a_frozen_run_stays_while_the_history_goes_on_and_thins_itself(monkeypatch):
    monkeypatch.setattr(history_module, "MOST_VALUES", 1)
    monkeypatch.setattr(history_module, "FEWEST_SAMPLES", 8)
    history = commanded(History(), 8)
    history.take_estimates([(time, (1, 2), np.full((2, 3), time)) for time in range(8)])
    frozen = history.frozen(2)
    commanded(history, 20, command=0.7)
    history.take_estimates([(time, (1, 2), np.full((2, 3), time)) for time in range(8, 28)])
    assert len(history.time) <= 8 and history.time[-1] > 20.0
    np.testing.assert_array_equal(frozen.time, np.arange(2.0, 8.0))
    assert (frozen.state.command == 0.1).all() and frozen.begun == 0.0
    np.testing.assert_array_equal(frozen.estimate[:, 0, 0], frozen.time)
    known = np.isfinite(history.estimate[:, 0, 0])
    assert known[-1] and (history.estimate[known, 1, 2] == history.time[known]).all()


def test_a_history_that_thins_itself_keeps_the_ends_of_the_run(monkeypatch):
    monkeypatch.setattr(history_module, "MOST_VALUES", 1)
    monkeypatch.setattr(history_module, "FEWEST_SAMPLES", 8)
    for still in range(8):
        history = commanded(commanded(History(), still, 0.0), 30)
        end = history.time[-1] + 1.0 if history.time[-1] == still + 29.0 else still + 29.0
        zeros, fresh = np.zeros((2, 3)), np.ones(2, dtype=bool)
        for _ in range(2):  # as a simulation that stands says again
            moving = np.full((2, 2), 0.1)
            history.append(snapshot_of(end, (1, 2), zeros, zeros, moving, fresh))
        assert history.begin == history.begun == still
        assert history.time[-1] == end and history.lasts(end - still)
        assert not history.lasts(end - still + 1.0)


def test_of_one_time_the_newest_is_kept_and_may_begin_the_run():
    history, fresh = History(), np.ones(2, dtype=bool)
    for place, speed in ((1.0, 0.0), (2.0, 0.3)):  # odometry, then the stage with the first command
        pose, command = np.full((2, 3), place), np.full((2, 2), speed)
        history.append(snapshot_of(1.0, (1, 2), pose, 0.0 * pose, command, fresh))
    assert history.begun == 1.0 and len(history.time) == 1
    assert (history.pose == 2.0).all() and (history.state.command == 0.3).all()


@pytest.mark.parametrize("name", ["formation_crazyflies", "formation_cars", "consensus"])
def test_a_kept_run_is_the_file_that_one_without_ros_writes(name, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    scenario = shipped(name)._replace(duration=0.5)
    run_experiment(scenario, str(tmp_path / "alone"), formats=())
    experiment, history, run = Experiment(scenario), History(), study(name)
    for stamp, _, _ in experiment.samples():
        message = team_state(experiment.world, stamp_at(stamp), "world", (1, 0))
        history.append(inbox._from_state(message, True))
    path = run.files.keep(history).rpartition(" ")[2]
    with open(path) as kept, open(str(tmp_path / "alone" / "run.csv")) as alone:
        header, rows = kept.readline(), kept.read().splitlines()
        assert header == alone.readline()
        for row, wanted in zip(rows, alone.read().splitlines()):
            given, wanted = row.split(","), wanted.split(",")
            assert given == wanted
    assert len(rows) == len(history.time) * scenario.n == 6 * scenario.n
    found = read_run_csv(path)
    if name == "formation_crazyflies":
        np.testing.assert_array_equal(found.spatial.z, history.state.spatial.z)
        np.testing.assert_array_equal(found.point_z[0], scenario.altitude)


def test_the_stage_gets_the_initial_heights():
    connection = Connection()
    run = study("formation_crazyflies", connection)
    run.send_team()
    ((name, poses, kinds, altitude),) = connection.asked
    assert name == "set_team" and len(poses) == len(kinds) == 7 and altitude.tolist() == [1.0] * 7


def test_a_run_without_a_controller_is_not_judged(tmp_path):
    connection = Connection()
    study("paper_four", connection).files.save(commanded(History(), 4, 0.0), str(tmp_path))
    connection.asked[-1][2]()
    assert read_run_csv(str(tmp_path / "run.csv")).meta["uncommanded"]


def test_a_run_whose_periods_were_missed_is_not_judged(tmp_path):
    stage = SimpleNamespace(
        robots=2, missed_periods=0, command_periods=0, stamp=0.0, lockstep=False
    )
    control = SimpleNamespace(**dict(vars(STANDS), running=True, period=0.1))
    connection = Connection(stage=stage, control=control)
    run = study("paper_four", connection)

    def reported(seconds, missed):
        stage.stamp, stage.command_periods = seconds, round(20 * seconds)
        stage.missed_periods = missed
        return run.note_timing()

    assert reported(10.0, 500) == "" and reported(20.0, 505) == ""  # of 200
    assert reported(30.0, 600) == run.missed.text() and "25%" in run.missed.text()
    run.files.save(commanded(History(), 4), str(tmp_path))
    connection.asked[-1][2]()
    assert "degraded" in read_run_csv(str(tmp_path / "run.csv")).meta["degraded"]
    assert reported(1.0, 0) == ""  # the stage was started again


@pytest.mark.parametrize(
    "action, speed, waits",
    [
        ("simulate", 1.0, "false"),
        ("simulate", 5.0, "true"),
        ("simulate", 0.0, "true"),
        (WHOLE, 1.0, "true"),
    ],
)
def test_a_whole_run_and_one_at_another_speed_than_1_wait_for_their_commands(
    tmp_path, action, speed, waits
):
    run = study(processes=Processes(directory=tmp_path))
    assert run.do(action, speed) == ""
    run.take_result("simulated_time", True, None)
    assert "_lockstep:=" + waits in run.processes.arguments
    run.control.launch()
    assert "_lockstep:=" + waits in run.processes.arguments


@pytest.mark.parametrize("success", [True, False])
def test_a_simulation_that_waits_for_the_masters_answer_is_not_gone(tmp_path, success):
    """Else a run by one button is given up where the answer takes longer than the window's next look."""
    processes = Processes(directory=tmp_path)
    processes.is_gone = lambda name: name not in processes.running
    run = study(processes=processes)
    assert run.stage.is_gone()
    assert run.do(WHOLE, 1.0) == "" and not run.stage.is_gone()
    run.take_result("simulated_time", success, None)
    assert run.stage.is_gone() != success


def test_the_duration_of_a_saved_run_has_no_noise_of_stamps(tmp_path):
    connection, history = Connection(), History()
    zeros, command = np.zeros((2, 3)), np.full((2, 2), 0.1)
    for row in range(4):
        time = 21.36 + 0.01 * row
        history.append(snapshot_of(time, (1, 2), zeros, zeros, command, np.ones(2, dtype=bool)))
    assert history.time[-1] - history.time[0] != 0.03
    study("paper_four", connection).files.save(history, str(tmp_path))
    connection.asked[-1][2]()
    assert load_scenario(str(tmp_path / "scenario.yaml")).duration == 0.03


def test_what_is_saved_can_be_given_up(tmp_path):
    connection = Connection()
    run = study("paper_four", connection)
    run.files.save(commanded(History(), 4), str(tmp_path))
    run.files.cancel()
    success, said = connection.asked[-1][2]()
    assert not success and "cancelled" in said and run.processes.cancelled == "report"
    assert (tmp_path / "run.csv").exists()


@PREDICTS
def test_theory_starts_where_the_robots_of_the_run_stood():
    run = study("paper_four")
    first = wait_until(run.edited.take_prediction)[0]
    begun = run.scenario.poses + [1.0, 2.0, 0.0] * np.arange(4)[:, np.newaxis]
    run.edited.predict_run(run.scenario, begun)
    assert wait_until(run.edited.take_run_prediction)[0].error[0] > first.error[0] + 0.5
    assert run.edited.take_prediction() is None


# What ran ----------------------------------------------------------------------------------------

LAW = (
    "from mrs_simulator.control.pioneer_control import PioneerControl\n"
    "class Law(PioneerControl):\n"
    "    def pointMassLaw(self, hand): return 0.0 * hand\n"
)


def saved(run, history, out):
    """Return the run that is saved now of ``history``."""
    run.files.save(history, str(out))
    run.connection.asked[-1][2]()
    return read_run(str(out))


def test_a_run_is_kept_with_the_law_that_ran_whatever_is_loaded_since(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    run, history = study("paper_four"), commanded(History(), 4)
    for name in ("raise3.py", "exitlaw.py"):
        (tmp_path / name).write_text(LAW)
    assert run.edited.set_protocol(str(tmp_path / "raise3.py") + ":Law") == ""
    history.scenario = run.scenario
    assert run.edited.set_protocol(str(tmp_path / "exitlaw.py") + ":Law") == ""
    path = run.files.keep(history).rpartition(" ")[2]
    assert "raise3.py" in read_run(path).scenario.control.protocol


def test_gains_set_on_the_way_stand_in_a_saved_run_with_their_times_and_later_ones_do_not(tmp_path):
    run, history = study("consensus", gain=0.2), commanded(History(), 9)
    history.scenario = run.scenario

    def obeyed(stamp, gain):
        assert run.edited.set_parameters({"gain": gain}) == ""
        history.applied.note(stamp, controller_settings(run.scenario))

    obeyed(-1.0, 0.3)
    obeyed(5.0, 0.4)
    obeyed(20.0, 0.6)
    run.edited.set_parameters({"gain": 0.7})
    found = saved(run, history, tmp_path)
    assert found.scenario.control.parameters["gain"] == 0.3
    (change,) = found.meta["changes"]
    assert (change.time, change.value["parameters"]["gain"]) == (5.0, 0.4)


def test_a_saved_run_is_of_the_stage_that_ran(tmp_path):
    run, history = study("paper_four"), commanded(History(), 4)
    staged = shipped("paper_four", fidelity="dynamic").changed(
        robots=2, poses=[[0, 0, 0], [3, 0, 0]]
    )
    history.scenario, history.staged = run.scenario, portable(staged)[0].to_yaml()
    found = saved(run, history, tmp_path).scenario
    assert (found.fidelity, found.n, found.title) == ("dynamic", 2, "2 robots, formation")
    assert run.files.suggested_name(history).startswith("2_robots_formation_")
    assert "Four" in run.scenario.title or "four" in run.scenario.title


def test_titles_tell_the_robots_that_ran(tmp_path):
    run = study("paper_four")
    run.edited.set_team(run.scenario.poses[:3], run.scenario.kinds[:3])
    assert run.scenario.title.startswith("3 robots") and "3_robots" in run.files.suggested_name()
    found = saved(run, commanded(History(), 4), tmp_path)  # of two real robots
    assert (found.scenario.n, found.scenario.title[:8]) == (2, "2 robots")


def test_what_cannot_have_run_is_said_and_the_run_is_saved(tmp_path):
    run, history = study("paper_four"), commanded(History(), 4)
    history.scenario, history.staged = run.scenario, "robots: none"
    assert (
        "the scenario of the run is not known" in saved(run, history, tmp_path).meta["warnings"][0]
    )


def test_another_run_begins_with_what_the_controller_obeys():
    history = commanded(History(), 4)
    history.scenario, history.staged = "edited", "staged"
    history.applied.note(50.0, {"seed": 1})
    history.clear()
    assert (history.scenario, history.staged) == (None, None)
    assert history.applied.during(0.0, 1.0) == ({"seed": 1}, [])


def test_a_reset_waits_until_the_controller_has_stopped():
    status = SimpleNamespace(running=True, trouble="", stale=(), command=[0] * 7)
    connection = Connection(control=status, stage=SimpleNamespace(speed=1.0))
    run = study(connection=connection)
    connection.asked.clear()
    run.do("reset")
    assert ("ask", "stop") in connection.asked and ("ask", "reset") not in connection.asked
    run.take_result("stop", True, "stopped")
    assert connection.asked[-1] == ("ask", "reset")
    connection.asked.clear()
    run.take_result("stop", True, "stopped")  # of the button Stop
    assert connection.asked == []
    status.running = False
    run.do("reset")
    assert connection.asked == [("ask", "reset")]


def test_a_file_that_ends_its_program_as_it_is_imported_is_named_with_the_line(tmp_path):
    law = tmp_path / "ends.py"
    law.write_text("import sys\n\nsys.exit(3)\n")
    run = study()
    said = run.edited.set_protocol(str(law))
    assert "SystemExit(3)" in said and "ends.py:3: sys.exit(3)" in said


def test_a_controller_elsewhere_that_runs_another_law_keeps_the_robots_standing(tmp_path):
    other = SimpleNamespace(**dict(vars(STANDS), protocol="Formation"))
    connection, processes = Connection(control=other), Processes(directory=tmp_path)
    connection.controller_arguments, connection.has_simulated_time = lambda _: [], lambda: False

    def all_pass(*words, **_):
        with open(words[words.index("--json") + 1], "w") as file:
            file.write("[]")
        return 0, ""

    processes.run = all_pass
    run = study(connection=connection, processes=processes)
    run.state.real = lambda: frozenset({1})
    run.do("control")
    ((_, name, work),) = [asked for asked in connection.asked if asked[0] == "do"]
    said = run.take_result(name, *work())
    assert "the controller is not started" in said
    assert run.preflight.findings == [("", "controller", "runs Formation", "Consensus", False)]
    assert not run.preflight.may_judge() and ("start",) not in connection.asked


@pytest.mark.parametrize(
    "drives, real, goes_on", [(True, (), True), (False, (), False), (True, (1,), False)]
)
def test_a_new_law_takes_over_simulated_robots_that_go_and_no_others(
    tmp_path, drives, real, goes_on
):
    processes = Processes(["control"], directory=tmp_path)
    run = study(connection=Connection(control=STANDS), processes=processes)
    run.state.drives, run.state.real = lambda: drives, lambda: frozenset(real)
    assert run.edited.set_protocol("formation") == ""
    said = run.control.follow_protocol()
    assert processes.is_running("control") == goes_on
    assert said == ("" if goes_on else "controller ended: start it for the new protocol")
