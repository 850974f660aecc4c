"""Whole runs over ROS: the launch file, lockstep, recorder, rosbag, and what theory says of them."""

import contextlib
import functools
import json
import os
import random
import re
import shlex
import signal
import subprocess
import threading
import xmlrpc.client

import numpy as np
import pytest
from protocol_fixtures import failed, near_the_line
from ros_fixtures import PATIENCE, log_of, wait_until

from mrs_simulator import load_scenario, run_experiment
from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.study.results.report import main as report
from mrs_simulator.study.results.report import read_run
from mrs_simulator.study.results.reproduce import reproduce

FAILS = """
from mrs_simulator import PioneerControl, make_twist

class Fails(PioneerControl):
    def calculateControlLaw(self, pos_map):
        if self.time >= {}:
            raise RuntimeError("gone")
        return {{i: make_twist(0.1, 0.0) for i in pos_map}}
"""
TWO = "--robots", 2
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LAW = """
from mrs_simulator import PioneerControl, make_twist

class Circle(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {i: make_twist(0.3, 0.1 * i + 0.5 * p.theta) for i, p in pos_map.items()}
"""


SWAYING = """
import numpy as np
from mrs_simulator import PioneerControl

class Swaying(PioneerControl):
    def pointMassLaw(self, hand):
        sway = 0.2 * np.array([np.cos(3.0 * self.time), np.sin(self.time)])
        return sway - 0.1 * self.topology.laplacian() @ hand
"""


def launch(ros, out, *arguments):
    """Run the launch file to its end; return the verdict."""
    given = "mrs_simulator", "simulation.launch", "out:=" + str(out), *arguments
    return verdict_of(ros.launch(*given), str(out))


def verdict_of(process, out):
    """Return the verdict of a launch, once it has ended."""
    process.wait(240)
    path = os.path.join(out, "verdict.json")
    assert os.path.exists(path), log_of(process)
    with open(path) as file:
        return json.load(file)


def text_of(path):
    with open(path) as file:
        return file.read()


def last_time(table):
    """Return the time [s] in the last whole row of a ``run.csv`` that may still grow, 0 without rows."""
    rows = text_of(table).split("\n")[1:-1]
    return float(rows[-1].partition(",")[0]) if rows else 0.0


def scenario(name):
    return "scenario:=" + os.path.join(ROOT, "scenarios", name + ".yaml")


@contextlib.contextmanager
def hindered(processes, seed=1):
    """Keep the processes off the cores by turns, some hundredths of a second each, as load does."""
    over, drawn = threading.Event(), random.Random(seed)

    def hinder():
        while not over.is_set():
            process = drawn.choice(processes)
            with contextlib.suppress(ProcessLookupError):  # it has ended
                os.kill(process.pid, signal.SIGSTOP)
                over.wait(drawn.uniform(0.01, 0.06))
                os.kill(process.pid, signal.SIGCONT)

    hindering = threading.Thread(target=hinder)
    hindering.start()
    try:
        yield
    finally:
        over.set()
        hindering.join()


@pytest.mark.release
@pytest.mark.parametrize("name, duration", [("paper", 6.0), ("paper_dynamic", 1.5)])
def test_the_papers_experiment_over_ros(ros, tmp_path, name, duration):
    """As far as it goes here, robots are where they are without ROS; they form in tests of that."""
    asked = "duration:={:g}".format(duration)
    verdict = launch(ros, tmp_path, scenario(name), asked, "speed:=0")  # which asks for lockstep
    assert not failed(verdict) and verdict["outcome"] != "failed", verdict
    with open(os.path.join(ros.directory, "launch.log")) as log:
        assert "no command from" not in log.read()  # nobody waits for an answer that was given
    alone = load_scenario(os.path.join(ROOT, "scenarios", name + ".yaml"))
    alone = run_experiment(alone._replace(duration=duration), str(tmp_path / "alone"), formats=())
    # Too short for the theorem, which is said with or without ROS.
    judged = [(each["outcome"], each["reason"]) for each in (verdict, alone)]
    assert judged[0] == judged[1] and judged[0][1].startswith("the law is confirmed"), judged
    np.testing.assert_allclose(verdict["final_gaps"], alone["final_gaps"], rtol=0.0, atol=1e-6)
    assert verdict["y_spread"] == pytest.approx(alone["y_spread"], abs=1e-6)
    names = "trajectories", "x_states", "y_states", "inputs", "certificates"
    assert sorted(os.listdir(str(tmp_path))) == sorted(["alone", *written(names)])


def written(figures):
    """Return the names of the files that a recorder writes, with these figures."""
    facts = "run.csv", "run.json", "scenario.yaml", "verdict.json", "provenance.json"
    drawn = [name + kind for name in figures for kind in (".png", ".pdf")]
    return [*facts, "ro-crate-metadata.json", *drawn]


def test_paced_by_the_clock_it_forms_too(ros, tmp_path):
    """Without lockstep the load of the machine shifts samples; the formation stands all the same."""
    near = "--scenario", near_the_line(tmp_path)
    ros.node("stage", *near, "_speed:=10", "_lockstep:=false", "_wait_for_recorders:=1")
    ros.node("pioneer_control", *near, "_speed:=10", "_lockstep:=false")
    record = ros.node("record", *near, "--duration", 16, "--out", tmp_path / "run")
    verdict = ros.judged(record, tmp_path / "run")
    begun = read_run_csv(str(tmp_path / "run" / "run.csv")).pose[0]
    assert np.ptp(begun[:, 1]) > 0.3  # not formed yet
    # On a busy machine its timing may be degraded, and nothing be judged.
    np.testing.assert_allclose(verdict["final_gaps"], 2.0, atol=0.05)
    assert verdict["y_spread"] < 0.1 and verdict["ended"] == "complete"


@pytest.mark.release
def test_a_controller_that_is_outrun_gives_a_run_that_is_not_judged(ros, tmp_path):
    hasty = "robots:=3", "speed:=0", "lockstep:=false", "duration:=16", "record:=true"
    # By roslaunch itself, which the recorder has to know.
    command = "roslaunch", "mrs_simulator", "simulation.launch", "out:={}".format(tmp_path), *hasty
    verdict = verdict_of(ros.start("launch", command), str(tmp_path))
    assert verdict["outcome"] == "not_judged" and "timing was degraded" in verdict["reason"]
    assert "degraded" in read_run_csv(str(tmp_path / "run.csv")).meta
    # Whoever looks at the terminal sees the verdict, below what roslaunch says of its nodes.
    log = os.path.join(ros.directory, "launch.log")
    end = "  figures and data: {}\n".format(tmp_path)
    said = wait_until(lambda: text_of(log).endswith(end) and text_of(log))
    assert said.index("shutting down processing monitor complete") < said.index("NOT JUDGED")
    with pytest.raises(SystemExit):
        report([str(tmp_path / "run.bag"), "--out", str(tmp_path / "again"), "--formats", "png"])
    again = (tmp_path / "again" / "verdict.json").read_text()
    # A bag that lacks the last moments, of which many pass in no time, is of a run cut short as well.
    assert "timing was degraded" in again and not json.loads(again)["passed"]


def recorded(ros, out, *stage_arguments, hindrance=contextlib.nullcontext):
    """Return the bytes of run.csv of 2 s of three robots in lockstep, as fast as the machine goes."""
    team, given = ("--robots", 3), ("_lockstep:=true", "_wait_for_recorders:=1", "_speed:=0")
    stage = ros.node("stage", *team, *given, *stage_arguments)
    control = ros.node("pioneer_control", *team, "_lockstep:=true")
    recorder = ros.node("record", *team, "--out", out, "--duration", 2)
    with hindrance([stage, control, recorder]):
        wait_until(lambda: (out / "verdict.json").exists() or recorder.poll() is not None)
    ros.judged(recorder, out)
    for node in (control, stage):
        ros.stop(node)
    return (out / "run.csv").read_bytes()


@pytest.mark.parametrize(
    "fidelity", ["kinematic", pytest.param("dynamic", marks=pytest.mark.release)]
)
def test_lockstep_gives_the_same_bytes_when_hindered_and_after_a_stall(ros, tmp_path, fidelity):
    chosen = "_fidelity:=" + fidelity
    freely = recorded(ros, tmp_path / "freely", chosen)
    assert freely.count(b"\n") == 1 + 3 * 21
    assert recorded(ros, tmp_path / "hindered", chosen, hindrance=hindered) == freely
    if fidelity == "kinematic":
        real_time = "_speed:=1"  # or the run would be over before it stalls
        table = tmp_path / "stalled" / "run.csv"
        stalled = functools.partial(stalling, ros, table)
        assert recorded(ros, table.parent, real_time, hindrance=stalled) == freely


@contextlib.contextmanager
def stalling(ros, table, nodes):
    """Stop the stage, once some of its run is recorded, until the control takes it for dead.

    The zeros of the control must not count as an answer.
    """
    stage, *_ = nodes
    probe = ros.probe()
    wait_until(lambda: table.exists() and table.stat().st_size > 1000)
    stage.send_signal(signal.SIGSTOP)
    probe.wait("'/clock is silent' in control('trouble')")
    stage.send_signal(signal.SIGCONT)
    yield


def test_lockstep_names_the_silent_robot(ros):
    stage = ros.node("stage", "--robots", 2, "_lockstep:=true", "_lockstep_timeout:=0.5")
    control = ros.node("pioneer_control", "--robots", 2, "_lockstep:=true")
    probe = ros.probe()
    probe.wait("(now() or 0) > 1.2")
    control.send_signal(signal.SIGSTOP)
    try:
        # Robot 1 may have had its answer before the controller was frozen.
        named = r"no command from (robot1, )?robot2 within 0\.5 s"
        wait_until(lambda: re.search(named, log_of(stage)))
        probe.wait("(status('waiting_for') or [])[-1:] == [2]")
        then = probe.ask("now()")
    finally:
        control.send_signal(signal.SIGCONT)
    probe.wait("now() > {!r} + 0.1".format(then))  # it goes on where it stood


def test_a_protocol_beside_the_user_and_a_bag_of_the_run(ros, tmp_path, capsys):
    (tmp_path / "my_law.py").write_text(LAW)
    leave_parameters(ros)
    command = ["roslaunch", "mrs_simulator", "simulation.launch", "out:=out", "record:=true"]
    command += ["robots:=3", "protocol:=my_law.py:Circle", "duration:=1.5"]
    command += ["speed:=0"]  # which asks for lockstep
    ros.environment["PWD"] = str(tmp_path)
    # Its nodes are no forks: here all of them load what they need.
    verdict = verdict_of(ros.start("launch", command, str(tmp_path)), str(tmp_path / "out"))
    with open(os.path.join(ros.directory, "launch.log")) as log:
        assert "no command from" not in log.read()  # nobody waits for an answer that was given
    assert verdict["outcome"] == "not_judged" and verdict["robots"] == 3  # a law without claims
    assert verdict["ended"] == "complete"
    run = read_run_csv(str(tmp_path / "out" / "run.csv"))
    np.testing.assert_allclose(run.command[-1, :, 0], 0.3)
    turns = [0.1, 0.2, 0.3] + 0.5 * run.pose[-1, :, 2]
    np.testing.assert_allclose(run.command[-1, :, 1], turns, atol=0.02)
    # Which is that without ROS.
    alone = load_scenario(str(tmp_path / "out" / "scenario.yaml"))
    run_experiment(alone, str(tmp_path / "alone"), formats=())
    over, alone = (text_of(tmp_path / name / "run.csv") for name in ("out", "alone"))
    assert over == alone and over.count("\n") == 1 + 3 * 16
    bag = tmp_path / "out" / "run.bag"
    wait_until(bag.exists)
    figures = "trajectories", "x_states", "y_states", "inputs"
    assert sorted(os.listdir(bag.parent)) == sorted(["run.bag", *written(figures)])
    # The same figures and verdict from the bag, which brings its own scenario.
    with pytest.raises(SystemExit) as ended:
        report([str(bag), "--out", str(tmp_path / "again"), "--formats", "pdf"])
    assert ended.value.code == 0
    assert (tmp_path / "again" / "trajectories.pdf").exists()
    again = json.loads((tmp_path / "again" / "verdict.json").read_text())
    assert again["min_distance"] == pytest.approx(verdict["min_distance"], abs=0.01)


def test_a_launch_ends_whose_controller_cannot_begin(ros):
    process = ros.launch("mrs_simulator", "simulation.launch", "protocol:=nowhere.py")
    assert process.wait(PATIENCE) is not None
    assert "nowhere.py" in log_of(process)


def test_a_report_of_a_csv_is_that_of_the_run(tmp_path, capsys):
    four = load_scenario(os.path.join(ROOT, "scenarios", "paper_four.yaml"))
    verdict = run_experiment(four, str(tmp_path / "run"), formats=())
    with pytest.raises(SystemExit) as ended:
        given = "--out", str(tmp_path / "report"), "--formats", "png"
        report([str(tmp_path / "run" / "run.csv"), *given])
    assert ended.value.code == 0
    again = json.loads((tmp_path / "report" / "verdict.json").read_text())
    same = ("passed", "settle_time", "final_gaps", "y_spread", "checks", "seed")
    assert {key: again[key] for key in same} == {key: verdict[key] for key in same}
    assert (tmp_path / "report" / "inputs.png").exists()


def test_the_recorder_keeps_what_it_has_when_the_stage_dies(ros, tmp_path):
    stage = ros.node("stage", *TWO, "_wait_for_recorders:=1", "_speed:=5")
    ros.node("pioneer_control", *TWO)
    record = ros.node("record", *TWO, "--out", tmp_path, "_silence:=2")
    table = tmp_path / "run.csv"
    wait_until(lambda: table.exists() and table.read_bytes().count(b"\n") > 40)
    stage.kill()
    verdict = ros.judged(record, tmp_path)
    assert verdict["ended"] == "the stage fell silent" and not verdict["passed"]
    assert len(read_run_csv(str(table)).time) > 10


def test_the_recorder_names_the_emergency_stop_that_ended_a_run(ros, tmp_path):
    ros.node("stage", *TWO, "_wait_for_recorders:=1", "_speed:=2")
    ros.node("pioneer_control", *TWO)
    record = ros.node("record", *TWO, "--duration", 4, "--out", tmp_path)
    probe = ros.probe()
    probe.wait("max(map(abs, state('vx'))) > 0.1")
    probe.ask("press(True)")
    verdict = ros.judged(record, tmp_path)
    facts = json.loads((tmp_path / "run.json").read_text())
    assert verdict["ended"] == facts["ended"] and not verdict["passed"]
    assert 0.0 < float(re.fullmatch("at ([0-9.]+) s emergency stop", facts["ended"]).group(1)) < 4.0
    assert any(text.endswith("in all: emergency stop") for text in verdict["warnings"])


def test_the_recorder_takes_what_the_stage_simulates(ros, tmp_path):
    paper = load_scenario(os.path.join(ROOT, "scenarios", "paper.yaml"))
    paper = paper.changed(requirements={"slow": "always(speed <= 50 m/s)"})
    asked, other = tmp_path / "asked.yaml", tmp_path / "other.yaml"
    asked.write_text(paper.to_yaml())
    other.write_text(paper.overridden(fidelity="point_mass").to_yaml())
    ros.node("stage", "--scenario", other, "_wait_for_recorders:=1", "_speed:=0")
    ros.node("pioneer_control", "--scenario", other)
    record = ros.node("record", "--scenario", asked, "--duration", "1", "--out", tmp_path / "run")
    ros.judged(record, tmp_path / "run")
    kept = load_scenario(str(tmp_path / "run" / "scenario.yaml"))
    assert (kept.fidelity, kept.duration) == ("point_mass", 1.0)
    # Requirements are evaluated at each step of the stage, not at what is recorded.
    (slow,) = json.loads((tmp_path / "run" / "run.json").read_text())["requirements"]
    assert slow["met"] and slow["period"] == pytest.approx(paper.step) and slow["time"] <= 1.0
    assert paper.record_period > 2.0 * paper.step


@pytest.mark.parametrize("when", [1.0, 0.0])
def test_a_law_that_fails_fails_its_run(ros, tmp_path, when):
    (tmp_path / "law.py").write_text(FAILS.format(when))
    # Slowly: what the recorder receives late is then short in simulated time.
    ros.node("stage", *TWO, "_wait_for_recorders:=1", "_speed:=0.5")
    record = ros.node("record", *TWO, "--protocol", tmp_path / "law.py", "--out", tmp_path)
    ros.node("pioneer_control", *TWO, "--protocol", tmp_path / "law.py")
    written = tmp_path / "verdict.json"
    wait_until(lambda: written.exists() or record.poll() is not None)
    if written.exists():  # the first zeros may have reached the robots
        verdict = ros.judged(record, tmp_path)
        assert not verdict["passed"] and "s the law failed: RuntimeError: gone" in verdict["ended"]
        assert verdict["duration"] == pytest.approx(when, abs=0.5)
    else:
        assert when == 0.0 and record.wait(PATIENCE) == 1
        assert "nothing was recorded: the law failed" in log_of(record)


def test_the_recorder_keeps_what_it_has_when_interrupted(ros, tmp_path):
    ros.node("stage", *TWO, "_wait_for_recorders:=1", "_speed:=5")
    ros.node("pioneer_control", *TWO)
    record = ros.node("record", *TWO, "--out", tmp_path)
    table = tmp_path / "run.csv"
    wait_until(lambda: table.exists() and table.read_bytes().count(b"\n") > 40)
    record.send_signal(signal.SIGINT)
    assert record.wait(3 * PATIENCE) == 1  # with its figures
    assert json.loads((tmp_path / "verdict.json").read_text())["ended"] == "interrupted"
    assert (tmp_path / "trajectories.png").exists()


def test_gains_and_edges_changed_while_recording_stand_in_the_run_with_their_times(ros, tmp_path):
    paper = load_scenario(os.path.join(ROOT, "scenarios", "paper_four.yaml"))
    gains = dict(paper.control.parameters, k=0.02)
    given = paper._replace(control=paper.control._replace(parameters=gains), duration=1000.0)
    (tmp_path / "given.yaml").write_text(given.to_yaml())
    out, probe = tmp_path / "out", ros.probe()
    ros.node("stage", "--scenario", tmp_path / "given.yaml", "_wait_for_recorders:=1", "_speed:=3")
    # The recorder's own scenario has another gain, as after an edit of the file.
    record = ros.node(
        "record", "--scenario", scenario("paper_four").partition("=")[2], "--out", out
    )
    ros.node("pioneer_control", "--scenario", tmp_path / "given.yaml")
    probe.wait("max(map(abs, state('vx') or [0.0])) > 0.0")  # the run begins with the first motion
    probe.wait_simulated(1.0)
    code = "import rospy; from dynamic_reconfigure.client import Client; rospy.init_node('c'); "
    ros.python(code + "Client('pioneer_control').update_configuration({'k': 0.05})")
    probe.ask("call('/pioneer_control/set_topology', SetTopology, [1, 2, 3], [2, 3, 4], [], False)")
    # What the recorder was sent of the states may be behind: until it has one of later on.
    now, table = probe.ask("now()"), out / "run.csv"
    wait_until(lambda: last_time(table) > now)
    record.send_signal(signal.SIGINT)
    verdict = ros.judged(record, out)
    run = read_run(str(out))
    assert run.scenario.control.parameters["k"] == 0.02
    changes = run.meta["changes"]
    assert [change.key for change in changes] == ["control", "control", "topology"]
    assert changes[0].value["parameters"]["k"] == 0.05
    assert 0.5 < changes[0].time <= changes[1].time == changes[2].time < run.time[-1]
    assert any("k 0.02 -> 0.05 at" in text for text in verdict["warnings"]), verdict["warnings"]


def test_messages_and_services_are_shown(ros):
    assert "float64[] theta" in ros.call("rosmsg", "show", "mrs_simulator/TeamState")
    assert "geometry_msgs/Pose2D pose" in ros.call("rossrv", "show", "mrs_simulator/SetTeam")


def test_why_a_launch_failed_is_reported_once_without_the_rest(ros, tmp_path):
    (tmp_path / "typo.yaml").write_text("poses: [[0, 0, 0]]\nduraton: 3\n")
    given = "scenario:={}".format(tmp_path / "typo.yaml")
    process = ros.launch("mrs_simulator", "simulation.launch", given)
    process.wait(120)
    (tmp_path / "other.log").write_text("".join("{}\n".format(i) for i in range(40)))
    told = "root={} && . {}/tools/prepare.sh && reasons ".format(ROOT, ROOT)
    said = subprocess.check_output(["bash", "-c", told + process.log]).decode()
    assert said.count("unknown 'duraton'") == 1 and len(said.splitlines()) == 1, said
    said = subprocess.check_output(["bash", "-c", told + str(tmp_path / "other.log")]).decode()
    assert said.split() == [str(i) for i in range(15, 40)]


def leave_parameters(ros):
    """Leave on the master what an earlier launch may have set; none of it is to count in the next."""
    left = {"enable_motors": "/robot{}/nobody", "geofence": "0, 0, 0.1, 0.1", "lockstep": True}
    master = xmlrpc.client.ServerProxy(ros.uri)
    master.setParam("/test", "/pioneer_control", dict(left, dry_run=True, frame_source="tf"))
    master.setParam("/test", "/stage", {"paused": True, "preset": "none such"})
    master.setParam("/test", "/record", {"silence": -1.0})


def test_external_poses_can_be_rehearsed_with_odometry_from_zero(ros, tmp_path):
    given = ["odometry:=wheel", "preset:=rosaria", "frame_source:=external", "speed:=4"]
    ros.launch("mrs_simulator", "simulation.launch", "robots:=2", *given)
    probe = ros.probe()
    probe.ask("listen('/robot2/pose', PoseStamped)")
    probe.wait("'/robot2/pose' in newest and state('x')")
    x = "newest['/robot2/pose'].pose.position.x"
    # Both are of a robot that moves at 0.75 m/s at most, at other times: the latest it stands.
    probe.wait("abs({} - state('x')[1]) < 0.5".format(x))
    probe.wait("max(control('command_v') or [0]) > 0.0 and control('trouble') == ''")


def test_a_run_in_lockstep_has_the_bytes_of_one_without_ros(ros, tmp_path):
    """Times are whole steps of the world again, and headings those that quaternions were made of."""
    (tmp_path / "my_swaying.py").write_text(SWAYING)
    given = tmp_path / "three.yaml"
    given.write_text(
        "{poses: [[0, 0, 0.3], [3, 0.4, 2], [1, 2, -1]], topology: {preset: path}, duration: 3,"
        " control: {protocol: my_swaying.py, rate: 50}}"
    )
    fast = "--scenario", given, "_lockstep:=true"
    ros.node("stage", *fast, "_speed:=0", "_wait_for_recorders:=1")
    ros.node("pioneer_control", *fast)
    record = ros.node("record", "--scenario", given, "--out", tmp_path / "over")
    record.wait(PATIENCE)  # its figures, too
    run_experiment(load_scenario(given), str(tmp_path / "alone"), formats=())
    over, alone = (text_of(tmp_path / name / "run.csv") for name in ("over", "alone"))
    assert over == alone and over.count("\n") == 1 + 3 * 31
    assert reproduce(str(tmp_path / "over" / "run.csv")) == 0


def test_a_run_is_judged_by_the_top_speed_that_its_control_keeps(ros, tmp_path):
    """The stage, whose scenario is recorded, knows nothing of it: a whole speed would fail the claims."""
    given = "--scenario", os.path.join(ROOT, "scenarios", "paper_four.yaml"), "_lockstep:=true"
    ros.node("stage", *given, "_speed:=0", "_wait_for_recorders:=1", "_wait_for_control:=true")
    ros.node("pioneer_control", *given, "_v_max:=0.2")
    record = ros.node("record", *given[:2], "--out", tmp_path, "--duration", 3)
    verdict = ros.judged(record, tmp_path, PATIENCE)
    recorded = load_scenario(str(tmp_path / "scenario.yaml"))
    assert recorded.limits.v_max == 0.2
    assert verdict["outcome"] != "failed" and not failed(verdict), verdict
    run = read_run_csv(str(tmp_path / "run.csv"), recorded)
    assert np.abs(run.command[..., 0]).max() == pytest.approx(0.2)


def test_a_run_behind_a_preset_is_made_again_by_the_launch_that_reproduce_prints(
    ros, tmp_path, capsys
):
    asked = "duration:=1", "robots:=2", "lockstep:=true", "speed:=0", "preset:=rosaria"
    launch(ros, tmp_path / "first", scenario("paper_four"), *asked)
    assert reproduce(str(tmp_path / "first" / "run.csv")) == 1
    said = capsys.readouterr().out
    assert "made with the preset rosaria, which a run without ROS does not have" in said
    again = shlex.split(said.partition("made again by: ")[2])
    assert again[:3] == ["roslaunch", "mrs_simulator", "simulation.launch"]
    assert again[-1] == "out:=ANOTHER_DIR"
    launch(ros, tmp_path / "again", *again[3:-1])
    first, second = (text_of(tmp_path / name / "run.csv") for name in ("first", "again"))
    assert first == second and first.count("\n") == 1 + 2 * 11
