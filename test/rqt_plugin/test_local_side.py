"""The window without ROS: its engine, and a study through the real window."""

import os
import pickle
import re
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
from multiprocessing.connection import Client
from pathlib import Path

import forked
import numpy as np
import pytest
import yaml
from forked import MODULES_OF_ROS, forker_without_ros

from mrs_simulator.core import compiling
from mrs_simulator.core.graphs import Topology
from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.rqt_plugin.local_side.connection import LocalConnection
from mrs_simulator.rqt_plugin.local_side.engine import Engine
from mrs_simulator.rqt_plugin.local_side.processes import LocalProcesses
from mrs_simulator.rqt_plugin.local_side.run_record import RunRecord
from mrs_simulator.rqt_plugin.run import staged
from mrs_simulator.rqt_plugin.run.recorded_run import UNANSWERED, copy_recorded
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.study.run.experiment import Experiment, run_experiment

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAPER = os.path.join(ROOT, "scenarios", "paper_four.yaml")
LOADED = "PyQt5.QtTest", "mrs_simulator.rqt_plugin.study_widget"
PRELUDE = """
import os, subprocess, sys, time, types
sys.modules.update(dict.fromkeys({modules}))
os.environ["QT_QPA_PLATFORM"] = "offscreen"
sys.path.append({tests!r})
from forked import OwnForker, forking_subprocess
from mrs_simulator.control import worker_process
from mrs_simulator.rqt_plugin.run import processes
forking = forking_subprocess(OwnForker())
if {forks}:
    worker_process.subprocess = forking
def opened(command, **given):
    return (forking if {forks} or "report" in command else subprocess).Popen(command, **given)
processes.subprocess = types.SimpleNamespace(**dict(vars(subprocess), Popen=opened))
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from mrs_simulator.rqt_plugin.local_side.connection import LocalConnection
from mrs_simulator.rqt_plugin.local_side.processes import LocalProcesses
from mrs_simulator.rqt_plugin import study_widget
from mrs_simulator.rqt_plugin.curves import drawn
from mrs_simulator.rqt_plugin.window.main_window import open_application
from mrs_simulator.scenario.scenario import load_scenario
application = open_application("gui")
# Most of the window's work while tests wait is pictures that nobody sees.
study_widget.FRAME = 100  # [ms]
drawn.DrawnCurves.tick = drawn._Canvas.draw = lambda *_: None
connection = LocalConnection()
gui = study_widget.StudyWidget(connection, LocalProcesses(connection), load_scenario(sys.argv[1]))
gui.resize(1280, 740)
gui.show()

def until(condition, limit=60.0):
    end = time.monotonic() + limit
    while not condition():
        application.processEvents()
        time.sleep(0.005)
        if time.monotonic() > end:
            print(gui.messages.toPlainText(), gui.study.processes.output("stage"), flush=True)
            os._exit(1)

def click(name):
    until(lambda: gui.bar.button(name).isEnabled())
    QTest.mouseClick(gui.bar.button(name), Qt.LeftButton)

def begin():
    click("simulate")
    click("control")
    until(gui.study.is_controlled)

def save(directory):
    results = []
    take = connection.take_results
    connection.take_results = lambda: results.extend(take()) or results[len(results):]
    gui.study.files.save(gui.history, directory)
    until(lambda: any(name == "save" for name, _, _ in results))
    connection.take_results = take

def end():
    gui.close_study()
    gui.study.processes.wait_closed()
    print("done", flush=True)
    os._exit(0)
"""


def in_window(code, path, tmp_path, *arguments, forks=True):
    """Return what a piece of Python in the process of a window printed, without a module of ROS.

    ``forks``: whether its simulation and laws are forks, which load nothing, as what draws figures is.
    """
    script, log = tmp_path / "window.py", tmp_path / "window.log"
    tests = os.path.dirname(forked.__file__)
    prelude = PRELUDE.format(modules=MODULES_OF_ROS, tests=tests, forks=forks)
    script.write_text(prelude + textwrap.dedent(code) + "\nend()\n")
    with tempfile.TemporaryDirectory() as temporary:  # short, as paths of sockets have to be
        environment = dict(os.environ, HOME=str(tmp_path), TMPDIR=temporary)
        given = list(map(str, (path, *arguments)))
        process = forker_without_ros().start(
            str(script), given, environment, log, log, loaded=LOADED
        )
        try:
            code = process.wait(120)
        finally:
            process.kill()
        left = [name for name in os.listdir(temporary) if name.startswith("mrs_simulator")]
    output = log.read_text()
    assert code == 0 and output.rstrip().endswith("done"), output[-3000:]
    assert not left
    return output


def kept_run(home):
    (path,) = home.glob(".local/share/mrs_simulator/runs/*/run.csv")
    return read_run_csv(str(path))


def read(path):
    return yaml.safe_load(path.read_text())


def test_a_run_in_the_window_is_to_the_byte_that_without_one(tmp_path):
    code = """
    from mrs_simulator.rqt_plugin.run import history
    history.MOST_VALUES = history.FEWEST_SAMPLES = 10  # the window holds few of the samples
    gui.bar.set_speed(0)
    begin()
    until(lambda: connection.newest("stage").paused)  # the duration is over
    until(lambda: len(gui.history.time))
    save(sys.argv[2])
    assert gui.history._stride > 1
    assert not gui.bar.button("preflight").isVisible() and gui.bar.more.isVisible()
    details = gui.program_control._panels.programs.details
    assert not details.isTabEnabled(1) and "without ROS" in details.tabToolTip(1)
    assert "ros" not in gui.program_control._panels.programs.command.placeholderText()
    print(gui.status["master"].toolTip())
    """
    scenario = load_scenario(PAPER)._replace(duration=4.0)
    path = tmp_path / "four.yaml"
    path.write_text(scenario.to_yaml())
    output = in_window(code, path, tmp_path, tmp_path / "window", forks=False)
    run_experiment(scenario, str(tmp_path / "alone"), formats=())
    alone, window = (tmp_path / out / "run.csv" for out in ("alone", "window"))
    assert alone.read_bytes() == window.read_bytes()
    for name in ("scenario.yaml", "run.json", "verdict.json"):
        alone, window = (read(tmp_path / out / name) for out in ("alone", "window"))
        assert alone.pop("real_time_factor", None) is not None or name == "scenario.yaml"
        window.pop("real_time_factor", None)
        assert alone == window
    alone, window = (read(tmp_path / out / "provenance.json") for out in ("alone", "window"))
    assert alone["stamp"] == window["stamp"] and alone["inputs"] == window["inputs"]
    assert alone["outputs"]["run.csv"] == window["outputs"]["run.csv"]
    for key in ("versions", "commit", "processor", "seed"):
        assert alone[key] == window[key]
    crate = read(tmp_path / "window" / "ro-crate-metadata.json")
    (about,) = [each for each in crate["@graph"] if each["@id"] == "./"]
    assert {"@id": "provenance.json"} in about["hasPart"] and {"@id": "run.csv"} in about["hasPart"]
    assert (tmp_path / "window" / "trajectories.pdf").exists()
    assert "without ROS: real robots and bags need mrs_gui" in output


def test_the_team_is_edited_after_a_run_and_the_next_one_begins_there(tmp_path):
    code = """
    gui.bar.set_speed(0)
    table = gui.team.model
    for x in (9.5, 8.5):
        table.setData(table.index(0, 1), str(x))
        click("run")
        until(lambda: not gui.whole.waits)  # the run before is over, too
        until(lambda: gui.study.state.is_over() and gui.verdict.verdict is not None)
        until(lambda: gui.team.number.isEnabled() and gui.results.can_be_saved())
        assert gui.team.locked.message == "" and gui.study.is_controlled()
        print("began at", gui.history.pose[0, 0, 0])
    gui.protocol._choose("consensus")  # robots that stand are not set going by a choice
    until(lambda: not gui.study.is_controlled())
    assert not gui.study.processes.is_running("control")
    """
    path = tmp_path / "four.yaml"
    path.write_text(load_scenario(PAPER)._replace(duration=2.0).to_yaml())
    output = in_window(code, path, tmp_path)
    assert "began at 9.5" in output and "began at 8.5" in output


def test_one_click_runs_the_scenario_and_shows_its_verdict_and_another_does_so_again(tmp_path):
    code = """
    gui.bar.set_speed(0)
    def saved():
        return gui.messages.toPlainText().count("saved to")
    do, held = connection.do, []
    connection.do = lambda name, work: held.append(work) if name == "save" else do(name, work)
    click("run")
    until(lambda: gui.verdict.verdict)  # before it is saved
    until(lambda: held)
    assert saved() == 0
    connection.do = do
    do("save", held.pop())
    until(lambda: saved() == 1)
    assert gui.results_tabs.currentWidget() is gui.verdict
    until(lambda: connection.newest("stage").paused)
    click("run")
    until(lambda: not gui.bar.button("run").isEnabled())
    until(lambda: saved() == 2)
    """
    scenario = load_scenario(PAPER)._replace(duration=2.0)
    path = tmp_path / "four.yaml"
    path.write_text(scenario.to_yaml())
    in_window(code, path, tmp_path)
    run_experiment(scenario, str(tmp_path / "alone"), formats=())
    wanted = (tmp_path / "alone" / "run.csv").read_bytes()
    runs = list(tmp_path.glob(".local/share/mrs_simulator/runs/*/run.csv"))
    assert [run.read_bytes() for run in runs] == 2 * [wanted]


def test_the_verdict_on_robots_that_stood_is_marked_once_their_graph_is_edited(tmp_path):
    code = """
    gui.bar.set_speed(0)
    click("run")
    until(lambda: gui.messages.toPlainText().count("saved to") == 1)
    until(lambda: gui.study.state.is_over())
    assert gui.verdict.verdict and not gui.past.remark
    gui.topology.add_edge(1, 2)
    until(lambda: gui.past.remark)
    print(gui.verdict.title.message)
    """
    scenario = load_scenario(os.path.join(ROOT, "scenarios", "consensus.yaml"))
    scenario = scenario._replace(duration=2.0, topology=Topology(scenario.n, []))
    path = tmp_path / "alone.yaml"
    path.write_text(scenario.to_yaml())
    assert "Last run, before your edits" in in_window(code, path, tmp_path)


def test_a_law_that_hangs_freezes_nothing_and_can_be_killed(tmp_path):
    law = tmp_path / "hangs.py"
    law.write_text(
        textwrap.dedent(
            """
            import time
            import numpy as np
            from mrs_simulator.control.pioneer_control import PioneerControl

            class Hangs(PioneerControl):
                calls = -np.inf  # theory asks, too, before the run

                def start(self):
                    super().start()
                    self.calls = 0

                def pointMassLaw(self, p):
                    self.calls += 1
                    while self.calls > 25:  # five in each sample
                        pass
                    return np.zeros_like(p)
            """
        )
    )
    content = {"poses": [[0, 0, 0], [2, 0, 0]], "control": {"protocol": str(law)}}
    path = tmp_path / "hangs.yaml"
    path.write_text(scenario_from_dict(content, "test").to_yaml())
    code = """
    from mrs_simulator.rqt_plugin.run import study_state
    study_state.HANGS = 0.5
    click("simulate")
    click("control")
    until(lambda: "its law hangs at hangs.py:1" in gui.banners.text("hangs"))
    assert "in pointMassLaw, or takes too long" in gui.banners.text("hangs")
    print(gui.study.state.lines()["controller"])
    until(lambda: connection.is_fresh("stage"))  # which goes on
    gui.banners.button("hangs", "Kill controller").click()
    until(lambda: not gui.study.processes.is_running("stage"))
    until(lambda: gui.bar.button("simulate").isEnabled())
    gui.study.files.keep(gui.history)
    """
    assert "has not answered" in in_window(code, path, tmp_path)
    run = kept_run(tmp_path)
    assert len(run.time) == 5  # each sample before the call that hangs
    assert run.meta["ended"] == UNANSWERED


def test_a_law_that_ends_its_process_is_reported_and_its_run_is_kept(tmp_path):
    law = tmp_path / "ends.py"
    law.write_text(
        textwrap.dedent(
            """
            import os
            import numpy as np
            from mrs_simulator.control.pioneer_control import PioneerControl

            class Ends(PioneerControl):
                calls = -np.inf

                def start(self):
                    self.calls = 0

                def pointMassLaw(self, p):
                    self.calls += 1
                    if self.calls > 25:
                        os._exit(3)
                    return np.zeros_like(p)
            """
        )
    )
    content = {"poses": [[0, 0, 0], [2, 0, 0]], "control": {"protocol": str(law)}}
    path = tmp_path / "ends.yaml"
    path.write_text(scenario_from_dict(content, "test").to_yaml())
    code = """
    click("simulate")
    click("control")
    until(lambda: "ended with 3" in gui.messages.toPlainText())
    until(lambda: gui.bar.button("simulate").isEnabled())
    gui.study.files.keep(gui.history)
    """
    in_window(code, path, tmp_path)
    assert len(kept_run(tmp_path).time) == 5


def command(prelude, *arguments):
    """Return the exit code and output of the command ``gui`` in a program that begins with ``prelude``."""
    code = (
        prelude
        + "\nfrom mrs_simulator.rqt_plugin.local_side.command import main\nmain(sys.argv[1:])"
    )
    done = subprocess.run(
        [sys.executable, "-c", "import sys\n" + code, *arguments],
        timeout=60,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    return done.returncode, done.stdout.decode()


def test_without_qt_one_line_says_what_to_install():
    prelude = "sys.modules.update(dict.fromkeys(('PyQt5', 'python_qt_binding')))"
    code, output = command(prelude)
    assert code == 2 and output.count("\n") == 1 and "pip install PyQt5" in output
    code, output = command(prelude, "--help")
    assert code == 0 and "SCENARIO" in output.upper()


# The engine --------------------------------------------------------------------------------------


class Over(Exception):
    """There are no more requests."""


class Script:
    """A ``Link`` to nobody: gives ``requests`` in turn, each after ``steps`` samples of the last one."""

    def __init__(self, *requests):
        self.left, self.sent, self._samples = list(requests), [], 0

    def send(self, name, value=None):
        self.sent.append((name, value))
        self._samples += name == "state" and value[1]

    def requests(self, wait):
        if not self.left:
            raise Over
        if self._samples < self.left[0][0]:
            return []
        _, *request = self.left.pop(0)
        self._samples = 0
        return [request]

    def all(self, name):
        return [value for kind, value in self.sent if kind == name]

    def samples(self):
        """Return the recorded states of each run."""
        runs = []
        for name, value in self.sent:
            if name == "run":
                runs.append([])
            elif name == "state" and value[1]:
                runs[-1].append(value[0])
        return runs


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "scenario.yaml"
    path.write_text(load_scenario(PAPER)._replace(duration=100.0).to_yaml())
    return str(path)


def played(path, *requests, speed=0.0):
    """Return the ``Script`` of an engine asked ``requests``, ``(samples before, name, arguments)``."""
    script = Script(*requests, (0, "pause", (True,)))
    engine = Engine(script, load_scenario(path), speed, os.path.dirname(path))
    with pytest.raises(Over):
        engine.spin()
    engine.close()
    return script


def test_time_begins_with_the_controller(path):
    script = played(path, (0, "control", (path,)), (20, "stop", ()))
    (run,) = script.samples()
    assert run[0].time == 0.0 and np.any(run[0].command)
    assert np.diff([state.time for state in run]) == pytest.approx(0.1)
    np.testing.assert_array_equal(run[0].pose, load_scenario(path).poses)
    assert script.all("result")[0] == ("stop", True, "stopped")


@pytest.mark.parametrize("speed, waits", [(0.0, False), (2.0, True)])
def test_a_run_that_somebody_watches_does_not_wait_for_compilation(path, speed, waits, monkeypatch):
    seen, go_on = set(), Experiment.go_on

    def asked(self, commanded=True):
        seen.add(compiling._is_in_time())
        return go_on(self, commanded)

    monkeypatch.setattr(Experiment, "go_on", asked)
    played(path, (0, "control", (path,)), (3, "stop", ()), speed=speed)
    assert seen == {waits} and not compiling._is_in_time()


def test_a_robot_that_is_held_is_pushed_by_events_that_repeat_the_run(path, tmp_path):
    hold, go = (5, "hold", (1, (3.0, -3.0))), (4, "hold", (1, None))
    script = played(path, (0, "control", (path,)), hold, go, (8, "stop", ()))
    (run,) = script.samples()
    (recorded,) = [each for each in script.all("run") if each]
    scenario = load_scenario(os.path.join(recorded, "scenario.yaml"))
    times = [each.at for each in scenario.events]
    assert {(each.robot, each.event) for each in scenario.events} == {(2, "pushed")}
    rows = np.rint(np.array(times) / 0.1).astype(int)
    assert len(rows) >= 4 and np.all(np.diff(rows) == 1)  # once in each sample, until it was let go
    held = np.array([run[row + 1].pose[1, :2] for row in rows])
    assert np.abs(held - [3.0, -3.0]).max() < 0.2
    assert np.hypot(*(run[rows[0]].pose[1, :2] - held[0])) > 0.5
    assert sum(map(len, script.all("incidents"))) == len(rows)
    run_experiment(scenario, str(tmp_path / "again"), formats=())
    again = tmp_path / "again" / "run.csv"
    lines = [file.read_text().splitlines() for file in (Path(recorded, "run.csv"), again)]
    same = 1 + 4 * (rows[-1] + 4)  # before the stop
    assert lines[0][:same] == lines[1][:same]


def test_a_controller_is_known_before_its_first_step_which_may_take_long(path):
    sent = played(path, (0, "control", (path,)), (3, "stop", ())).sent
    names = [name for name, _ in sent]
    samples = [row for row, (name, value) in enumerate(sent) if name == "state" and value[1]]
    assert names.index("run") < names.index("control") < samples[0]
    assert sent[names.index("control")][1].running


def test_who_stops_stands_and_who_starts_again_begins_a_run_there(path):
    script = played(
        path, (0, "control", (path,)), (20, "stop", ()), (20, "start", ()), (20, "stop", ())
    )
    first, second = script.samples()
    assert not np.any(first[-1].command) and np.any(second[0].command)
    assert second[0].time == 0.0
    np.testing.assert_array_equal(second[0].pose, first[-1].pose)


def test_a_reset_puts_the_robots_back_and_ends_the_controller(path):
    script = played(path, (0, "control", (path,)), (20, "reset", ()), (0, "step", (1,)))
    assert script.all("control_ended") == [""]
    states = [state for state, _, _ in script.all("state")]
    np.testing.assert_array_equal(states[-1].pose, load_scenario(path).poses)


def test_a_reset_after_another_controller_puts_the_robots_to_where_they_began(path):
    """Another protocol was chosen in the middle of the run: it goes on from where the robots were."""
    script = played(
        path,
        (0, "control", (path,)),
        (20, "end_control", ()),
        (0, "control", (path,)),
        (20, "reset", ()),
        (0, "step", (1,)),
    )
    first, second = (run for run in script.samples() if run)
    assert np.abs(second[0].pose - first[-1].pose).max() < 0.2  # steps, after the last sample
    states, home = [state for state, _, _ in script.all("state")], load_scenario(path).poses
    assert np.abs(second[0].pose - home).max() > 0.5
    np.testing.assert_array_equal(states[-1].pose, home)


def test_another_team_is_simulated_from_its_places(path):
    poses = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 1.0]])
    team = poses, ("amigobot", "amigobot"), None
    script = played(path, (0, "set_team", team), (0, "control", (path,)))
    assert script.all("result")[0] == ("set_team", True, "2 robots")
    assert script.all("control_ended") == [
        "a controller of 4 robots, wanted one of the simulated 2"
    ]
    assert script.all("state")[-1][0].kinds == ["amigobot", "amigobot"]


def test_sensors_that_the_window_shows_are_read_and_sent(path):
    """From the middle of a run on, in the law's time; what the run does stays the same."""
    watched = {0: ["sonar"], 2: ["sonar"]}
    script = played(
        path,
        (0, "control", (path,)),
        (5, "watch", (watched,)),
        (150, "watch", ({},)),
        (5, "stop", ()),
    )
    stamp, readings = script.all("readings")[-1]
    assert {row for row, own in readings.items() if "sonar" in own} >= set(watched)
    assert 0.0 <= stamp - readings[0]["sonar"].stamp < 0.2
    pickle.dumps(readings)
    plain = played(path, (0, "control", (path,)), (160, "stop", ()))
    (seen,), (alone,) = script.samples(), plain.samples()
    np.testing.assert_array_equal(seen[150].pose, alone[150].pose)


def test_the_emergency_stop_holds_until_it_is_released(path):
    script = played(
        path,
        (0, "control", (path,)),
        (10, "emergency", (True,)),
        (5, "start", ()),
        (0, "emergency", (False,)),
        (0, "start", ()),
        (5, "stop", ()),
    )
    results = [each for each in script.all("result") if each[0] == "start"]
    assert results[0][1] is False and "release it first" in results[0][2]
    assert results[1][1] is True
    first, second = script.samples()
    assert not np.any(first[-1].command) and np.any(second[0].command)
    ended = [read(Path(directory) / "run.json")["ended"] for directory in script.all("run")]
    assert re.fullmatch(r"at [0-9.]+ s emergency stop", ended[0]) and ended[1] == "complete"


def test_parameters_and_graph_are_set_in_the_run_and_published(path):
    scenario = load_scenario(path)
    script = played(
        path,
        (0, "control", (path,)),
        (5, "set_parameters", (dict(scenario.control.parameters, k=0.5),)),
        (5, "set_parameters", ({"k": -1.0},)),
        (0, "set_topology", ([(1, 2, 1.0), (2, 3, 1.0), (3, 4, 1.0)], True)),
    )
    results = {name: (good, said) for name, good, said in script.all("result")}
    assert results["set_parameters"][0] is False and "k" in results["set_parameters"][1]
    settings = [settings for _, settings in script.all("applied")]
    assert settings[1]["control"]["parameters"]["k"] == 0.5
    assert results["set_topology"][0], results


@pytest.mark.parametrize("statement", ['raise ValueError("of its own")', 'sys.exit("of its own")'])
def test_a_law_that_raises_ends_nothing_and_is_reported(path, tmp_path, statement):
    law = tmp_path / "raises.py"
    law.write_text(
        textwrap.dedent(
            """
            import sys
            from mrs_simulator.control.pioneer_control import PioneerControl

            class Raises(PioneerControl):
                def pointMassLaw(self, p):
                    STATEMENT
            """
        ).replace("STATEMENT", statement)
    )
    text = load_scenario(path).with_protocol(str(law)).to_yaml()
    other = tmp_path / "other.yaml"
    other.write_text(text)
    script = played(path, (0, "control", (str(other),)), (3, "reset", ()))
    engine_says = [control.trouble for control in script.all("control")]
    assert any("the law failed" in trouble and "of its own" in trouble for trouble in engine_says)


def test_a_team_driven_apart_ends_its_run_as_without_a_window(path, tmp_path, monkeypatch):
    monkeypatch.setattr("mrs_simulator.study.run.experiment.FARTHEST", 1.0)
    script = played(path, (0, "control", (path,)), (3, "reset", ()))
    assert any("driven apart" in control.trouble for control in script.all("control"))
    (name,) = [name for name in script.all("run") if name]
    assert "driven apart" in read(Path(name) / "run.json")["ended"]


def test_a_run_that_is_changed_stopped_and_gone_beyond_says_so(path, tmp_path):
    parameters = dict(load_scenario(path).control.parameters, k=0.5)
    script = played(
        path,
        (0, "control", (path,)),
        (5, "set_parameters", (parameters,)),
        (5, "stop", ()),
        (2, "pause", (True,)),
    )
    (directory,) = script.all("run")
    facts = read(Path(directory) / "run.json")
    assert [change[1] for change in facts["changes"]] == ["control"]
    assert any("was stopped" in warning for warning in facts["warnings"])
    run = read_run_csv(os.path.join(directory, "run.csv"))
    assert run.time[-1] == read(Path(directory) / "scenario.yaml")["duration"]


def test_looking_at_a_run_changes_nothing_of_it(tmp_path, monkeypatch):
    monkeypatch.setattr("mrs_simulator.rqt_plugin.local_side.engine.STATUS", 0.0)
    path = tmp_path / "carrying.yaml"
    scenario = load_scenario(os.path.join(ROOT, "scenarios", "carrying.yaml"))
    path.write_text(scenario._replace(duration=1.0).to_yaml())
    script = played(str(path), (0, "control", (str(path),)), (11, "stop", ()))
    experiment = Experiment(load_scenario(str(path)))
    for _ in experiment.samples():
        pass
    facts = read(Path(script.all("run")[0]) / "run.json")
    assert facts["closest_approach"] == experiment.world.contacts.closest
    experiment.world.close()


def test_what_is_saved_of_a_run_that_goes_on_is_what_it_was_when_asked(path, tmp_path):
    experiment = Experiment(load_scenario(path))
    source, saved = tmp_path / "source", tmp_path / "saved"
    source.mkdir()
    record, found = RunRecord(experiment, str(source)), None
    experiment.begin()
    for _ in range(60):
        if experiment.go_on():
            record.sample()
            found = found or (record.write() if experiment.world.time > 0.35 else None)
    copy_recorded(str(source), str(saved), found, None, lambda share: None)
    assert read_run_csv(str(saved / "run.csv")).time == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert read(saved / "scenario.yaml")["duration"] == pytest.approx(0.4)
    assert not (source / "run.json").exists()  # of a run that goes on
    record.close()
    assert read(source / "scenario.yaml")["duration"] == pytest.approx(1.1)
    experiment.world.close()


def test_after_the_duration_time_waits(path, tmp_path):
    short = tmp_path / "short.yaml"
    short.write_text(load_scenario(path)._replace(duration=1.0).to_yaml())
    script = played(
        str(short), (0, "control", (str(short),)), (11, "pause", (False,)), (5, "stop", ())
    )
    (run,) = script.samples()
    assert [name for name, _, _ in script.all("result")][0] == "paused"
    assert run[10].time == pytest.approx(1.0) and len(run) > 11


def test_runs_are_recorded_where_files_go_once_the_simulation_has_ended():
    connection = LocalConnection()
    processes, launched = LocalProcesses(connection), []
    processes.launch = lambda name, command: launched.append(command)
    processes.start("stage", "stage", "--scenario", "any.yaml", "_speed:=1.0")
    (recorded,) = [word for word in launched[0] if os.path.isdir(word)]
    connection.close()  # while the simulation may still write
    assert os.path.isdir(recorded)
    processes.close()
    processes.wait_closed()
    assert not os.path.exists(recorded)


def test_a_scenario_that_comes_is_read_once_by_the_thread_that_receives_it(monkeypatch):
    read = []

    def reading(text, _where):
        read.append(threading.current_thread())
        return text.upper()

    monkeypatch.setattr(staged, "scenario_from_yaml", reading)
    staged.staged_scenario.cache_clear()
    connection = LocalConnection()
    with Client(connection.address) as engine:
        engine.send(("scenario", "poses"))
        end = time.monotonic() + 60.0
        while connection.newest("scenario") is None:
            assert time.monotonic() < end
            time.sleep(0.01)
    assert staged.staged_scenario("poses") == staged.staged_scenario("poses") == "POSES"
    assert len(read) == 1 and read[0] is not threading.main_thread()
    staged.staged_scenario.cache_clear()
    connection.close()
