"""The GUI with real robots, alone and among simulated ones: marked, checked, started only if ready."""

import json
import re
import xmlrpc.client

import pytest
from ros_fixtures import wait_until
from test_real_mixed import start_driver
from test_rosaria import FORWARD

from mrs_simulator.scenario.scenario import load_scenario

FOUR = "scenarios/paper_four.yaml"


SHORT = """
gui.study.edited.scenario = gui.scenario._replace(duration=min(10.0, gui.scenario.duration))
"""


@pytest.fixture
def gui(gui):
    """``gui``, of a scenario that is short: checks before a start predict all of it."""
    return lambda code, *arguments, **given: gui(SHORT + code, *arguments, **given)


@pytest.fixture
def robots(ros):
    """Return a probe that is the odometry of four real robots at the scenario's poses."""
    be_patient(ros, use_sim_time=False)
    probe = ros.probe()
    for number, pose in enumerate(poses(), 1):
        probe.ask("stand_in({}, {})".format(number, pose))
    return probe


def be_patient(ros, **more):
    """Let robots be silent for long, as they are on a busy machine; set ``more`` parameters."""
    master = xmlrpc.client.ServerProxy(ros.uri)
    patience = {
        "pioneer_control/odom_timeout": 30.0,
        "stage/odom_timeout": 30.0,
        "preflight/time_limit": 20.0,
    }
    for name, value in dict(patience, **more).items():
        master.setParam("/test", "/" + name, value)


def poses():
    from gui_fixtures import ROOT

    return load_scenario(ROOT + "/" + FOUR).poses.tolist()


ALL_REAL = """
until(lambda: gui.status["robots"].text().endswith("4 real"))
until(lambda: gui.map.scene().state.robots == (1, 2, 3, 4))
"""
NOT_SIMULATED = """
for name in ("simulate", "pause", "step", "reset", "speed"):
    assert not gui.bar.button(name).isEnabled(), name
    assert "real" in gui.bar.button(name).toolTip().partition("Not now: ")[2], name
assert not gui.team.number.isEnabled() and "real" in gui.team.number.toolTip()
assert not gui.modes["poses"].isEnabled() and gui.team._open.isEnabled()
table = gui.team.table.model()
assert [table.index(row, 0).data() for row in range(4)] == ["1 real", "2 real", "3 real", "4 real"]
"""


def test_real_robots_are_marked_checked_and_started(gui, robots):
    gui(
        ALL_REAL
        + NOT_SIMULATED
        + """
key("k")
assert gui.results_tabs.currentWidget() is gui.preflight and "Checking" in gui.preflight.title.message
until(lambda: gui.preflight.title.message.startswith("All robots ready"))
assert rows_of(gui.preflight) == [] and not gui.study.is_controlled()
click("control")
assert not gui.study.processes.is_running("control")
until(lambda: gui.study.is_controlled())
# Another law does not take over real robots unchecked.
gui.protocol.protocol_chosen.emit("consensus")
until(lambda: not gui.study.is_controlled())
assert not gui.study.processes.is_running("control")
assert "start it for the new protocol" in gui.messages.toPlainText()
"""
    )


@pytest.mark.release
def test_a_person_may_judge_a_place(gui, robots):
    x, y, theta = poses()[2]
    robots.ask("stand_in(3, [{}, {}, {}])".format(x + 0.6, y, theta))
    gui(
        ALL_REAL
        + """
panel = gui.preflight
click("control")
until(lambda: panel.title.message.startswith("Not started"))
assert [row[:2] for row in rows_of(panel)] == [["robot3", "stands in place"]]
assert "0.60 m" in rows_of(panel)[0][2] and rows_of(panel)[0][3] == "at most 0.3 m and rad"
assert panel.start_button.isVisible() and not panel.start_button.isEnabled()
def judge():
    QTest.mouseClick(panel.judged, Qt.LeftButton, pos=QPoint(8, panel.judged.height() // 2))
    QTest.mouseClick(panel.start_button, Qt.LeftButton)
judge()
until(lambda: gui.study.is_controlled())
assert panel.title.message == "1 finding, 14 checks passed. The controller starts."
"""
    )


def test_what_is_no_matter_of_judgement_keeps_the_robots_standing(gui, robots, ros):
    xmlrpc.client.ServerProxy(ros.uri).setParam("/test", "/preflight/time_limit", 1.0)
    robots.ask("fall_silent(2)")
    gui(
        """
until(lambda: len(gui.connection.snapshot().robots if gui.connection.snapshot() else ()) == 3)
click("control")
until(lambda: gui.preflight.title.message.startswith("Not started"))
found = {(row[0], row[1]) for row in rows_of(gui.preflight)}
assert {("robot2", "publishes"), ("team", "predicted paths")} <= found, found
assert not gui.preflight.start_button.isVisible()
assert not gui.study.is_controlled() and not gui.study.processes.is_running("control")
"""
    )


def test_the_emergency_stop_calls_off_a_start(gui, robots):
    gui(
        ALL_REAL
        + """
click("control")
until(lambda: "checked before" in gui.status["controller"].text())
QTest.keyClick(gui, Qt.Key_F8)
until(lambda: gui.connection.newest("emergency") is not None)
QTest.mouseClick(gui.bar.button("emergency"), Qt.LeftButton)
until(lambda: not gui.study.preflight.running)
assert gui.preflight.title.message.startswith("All robots ready")
assert not gui.study.processes.is_running("control")
click("control")
assert gui.study.preflight.starting and gui.bar.button("stop").isEnabled()
QTest.mouseClick(gui.bar.button("stop"), Qt.LeftButton)
assert not gui.study.preflight.starting
until(lambda: not gui.study.preflight.running)
assert not gui.study.processes.is_running("control")
"""
    )


def test_silent_robots_and_odd_names_are_not_started(gui, robots):
    robots.ask("stand_in(5, [3.0, 0.0, 0.0], topic='/robot{}/RosAria/pose')")
    gui(
        """
until(lambda: gui.status["robots"].text().endswith("5 real"))
start = gui.bar.button("control")
until(lambda: not start.isEnabled() and "/robot5/RosAria/pose" in start.toolTip())
"""
    )
    robots.ask("fall_silent(1)")
    gui(
        """
until(lambda: gui.status["robots"].text().endswith("4 real"))
poses = gui.connection.snapshot().pose
assert poses[-1].tolist() == [3.0, 0.0, 0.0]
"""
    )


def test_a_team_that_is_partly_real(gui, ros):
    # What stands in for robot2 does not move: neither frozen nor stuck is it to count here.
    still = "pioneer_control/frozen_time", "pioneer_control/stuck_time"
    be_patient(ros, **dict.fromkeys(still, 1000.0))
    probe = ros.probe()
    probe.ask("stand_in(2, {})".format(poses()[1]))
    stage = ros.node("stage", "--scenario", FOUR.partition("/")[2], "--real", 2, "_speed:=2")
    gui(
        """
until(lambda: gui.status["robots"].text().endswith("3 simulated, 1 real"))
until(lambda: "but real robots run at 1" in gui.status["time"].text())
until(lambda: "robot2" in gui.bar.button("reset").toolTip() and gui.map.team.real == {2})
assert gui.bar.button("reset").isEnabled()
click("control")
until(lambda: gui.preflight.title.message.startswith("Not started"))
assert ["team", "speed", "2", "1, as real robots go"] in rows_of(gui.preflight)
assert not gui.preflight.start_button.isVisible()
gui.bar.speed_chosen.emit(5.0)
assert "robot2: real" in gui.messages.toPlainText()
gui.bar.speed_chosen.emit(1.0)
until(lambda: gui.connection.newest("stage").speed == 1.0)
click("control")
until(lambda: gui.study.is_controlled())
# One that has not driven yet would only wait until the second node is gone.
until(lambda: gui.connection.newest("control").command.any())
# The controller knows who is real: a second node that tells where it is stops all.
from nav_msgs.msg import Odometry
carried, pose = rospy.Publisher("/robot2/odom", Odometry, queue_size=1), Odometry()
pose.pose.pose.position.x, pose.pose.pose.orientation.w = 40.0, 1.0
troubles = set()
def is_shown():
    carried.publish(pose)
    troubles.add(gui.connection.newest("control").trouble)
    return any("both publish /robot2/odom" in trouble for trouble in troubles)
until(is_shown)
until(lambda: not gui.study.is_controlled())
"""
    )
    ros.stop(stage)


@pytest.mark.release
def test_a_controller_for_another_law_is_said(gui, robots, ros):
    ros.node("pioneer_control", "--robots", 4, "--protocol", "consensus", "_autostart:=false")
    gui(
        ALL_REAL
        + """
until(lambda: gui.connection.is_fresh("control"))
click("control")
until(lambda: gui.preflight.title.message.startswith("Not started"))
assert ["team", "controller", "runs Consensus", "Formation"] in rows_of(gui.preflight)
assert not gui.study.is_controlled()
"""
    )


def test_robots_behind_other_names_with_odometry_from_zero(gui, ros):
    fence = {"pioneer_control/geofence": [-1.0, -4.0, 4.0, 4.0]}
    be_patient(ros, use_sim_time=False, **fence)
    probe, names = ros.probe(), []
    for number in range(1, 5):
        topic = "/robot{}/RosAria/pose"
        probe.ask("stand_in({}, [0.0, 0.0, 0.0], topic={!r})".format(number, topic))
        names.append("/robot{0}/odom:=/robot{0}/RosAria/pose".format(number))
    ros.node("pioneer_control", "--scenario", "lab_four.yaml", "_autostart:=false", *names)
    gui(
        """
until(lambda: gui.status["robots"].text().endswith("4 real"))
until(lambda: gui.connection.is_fresh("control"))
assert abs(gui.connection.snapshot().pose - gui.scenario.poses).max() < 1e-6
click("control")
until(lambda: gui.preflight.title.message.startswith("Not started"))
# As the controller, the check received all robots on their own topics and knew the fence.
assert {row[1] for row in rows_of(gui.preflight)} >= {"geofence"}, rows_of(gui.preflight)
assert not any("publishes" in row[1] for row in rows_of(gui.preflight))
rospy.set_param("/pioneer_control/geofence", [-9.0, -9.0, 9.0, 9.0])
click("control")
until(lambda: gui.study.is_controlled())
assert not gui.study.processes.is_running("control")
""",
        scenario="lab_four",
    )


def test_once_the_simulation_is_gone_the_real_robots_alone_are_shown(gui, ros):
    be_patient(ros, **{"pioneer_control/frozen_time": 1000.0})
    ros.probe().ask("stand_in(2, {})".format(poses()[1]))
    stage = ros.node("stage", "--scenario", FOUR.partition("/")[2], "--real", 2)
    gui(
        """
until(lambda: gui.status["robots"].text().endswith("3 simulated, 1 real"))
click("control")
until(lambda: gui.preflight.title.message.startswith(("All robots", "Not started")))
until(lambda: gui.study.is_controlled())
until(lambda: gui.map.targets is not None)
os.kill(int(sys.argv[2]), 9)
until(lambda: gui.status["robots"].text().endswith(": 1 real"))
until(lambda: gui.map.scene().state.robots == (2,))
until(lambda: gui.status["stage"].text().endswith("no stage"))
until(lambda: not gui.study.is_controlled())
until(lambda: gui.map.targets is None, 30.0)
print("SHOWN", [gui.status[name].text() for name in ("stage", "controller", "robots", "time")])
assert "real time" not in gui.status["time"].text()
""",
        stage.pid,
    )


TWO = """
poses: [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]
odometry: wheel
duration: 3
record_rate: 10
control: {protocol: law.py, rate: 20}
requirements:
  slow: always(each robot(speed < 0.22 m/s))
  straight: always(each robot(abs(turn_rate) < 0.1 rad/s))
  free: always(contacts <= 0)
"""


@pytest.mark.parametrize(
    "real",
    [pytest.param((1,), id="mixed"), pytest.param((1, 2), id="real", marks=pytest.mark.release)],
)
def test_a_run_has_the_same_answers_from_the_window_as_from_the_recorder(gui, ros, tmp_path, real):
    be_patient(ros, use_sim_time=False)  # at which drivers look at once
    master = xmlrpc.client.ServerProxy(ros.uri)
    for number in real:
        start_driver(ros, number, rate=15)  # samples at 10 Hz leave out every third pose
        odom = ["/robot{}/odom".format(number), "nav_msgs/Odometry"]
        wait_until(lambda odom=odom: odom in master.getPublishedTopics("/test", "")[2])
    mixed = real == (1,)
    master.setParam("/test", "/use_sim_time", mixed)
    (tmp_path / "law.py").write_text(FORWARD)
    scenario, recorded, saved = (tmp_path / name for name in ("two.yaml", "recorded", "saved"))
    scenario.write_text(TWO)
    if mixed:
        ros.node("stage", "--scenario", scenario, "--real", 1)
    record = ros.node("record", "--scenario", scenario, "--out", recorded)
    own = ["_odom_timeout:=30", "_max_jump:=0"] + ["_real:=1"] * mixed
    ros.node("pioneer_control", "--scenario", scenario, *own, "_autostart:=false")
    output = gui(
        """
until(lambda: len(gui.history.real) == int(sys.argv[2]) and len(gui.history.numbers) == 2)
until(lambda: gui.connection.is_fresh("control"))
gui.connection.ask("start")
stands = set()
def judged():
    panel = gui.verdict
    if panel.verdict is None:
        rows = (panel.table.text(row, 1) + " " + panel.table.text(row, 2)
                for row in range(panel.table.rowCount()))
        stands.update(row for row in rows if "failing" in row)
    return panel.verdict is not None
until(judged)
assert not stands, stands
print("JUDGED", json.dumps(gui.verdict.verdict["requirements"]))
gui.study.files.save(gui.history, sys.argv[3])
until(lambda: os.path.exists(os.path.join(sys.argv[3], "verdict.json")))
""",
        len(real),
        saved,
        scenario=str(scenario),
    )
    ros.judged(record, recorded)
    seen = json.loads(re.search("^JUDGED (.*)$", output, re.MULTILINE).group(1))
    by_window, by_recorder = (
        json.loads((out / "verdict.json").read_text())["requirements"] for out in (saved, recorded)
    )
    same = "name", "met", "note", "predicate", "unit"
    answers = [
        [[each[key] for key in same] for each in found] for found in (by_recorder, by_window, seen)
    ]
    assert answers[0] == answers[1] == answers[2]
    assert [met for _, met, *_ in answers[0]] == [True, True, True if mixed else None]
    for ours, theirs in zip(by_window, by_recorder):
        if ours["met"] is not None:
            assert ours["margin"] == pytest.approx(theirs["margin"], abs=2e-3)
    facts = [json.loads((out / "run.json").read_text()) for out in (saved, recorded)]
    for key in ("real", "collisions_unknown", "collisions"):
        assert facts[0].get(key) == facts[1].get(key), key
    assert facts[0]["real"] == list(real)
