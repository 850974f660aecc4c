"""Programs of the study: started, ended and started again in one place, and what they say of themselves."""

import os
import signal
import sys

import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import quiet_study
from ros_fixtures import wait_until

from mrs_simulator.ros.node.diagnostics import ERROR, OK, Health, array
from mrs_simulator.rqt_plugin.ros_side import diagnostics as diagnostics_module
from mrs_simulator.rqt_plugin.ros_side.diagnostics import DiagnosticsConnection
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.run.processes import Processes
from mrs_simulator.rqt_plugin.run.programs import _duration
from mrs_simulator.rqt_plugin.run.programs_panel import short
from mrs_simulator.scenario.scenario import scenario_from_dict

ENDS = "import sys; print('so far'); sys.exit(int(sys.argv[1]))"
RUNS = "import time; print('running', flush=True); time.sleep(1000)"


@pytest.fixture
def study(app, no_hidden_errors):
    """The GUI with nothing behind it but real processes, its panel of programs shown."""
    widget = quiet_study(scenario_from_dict({"poses": [[0, 0, 0]]}))
    processes = Processes()
    for part in (widget.study, widget.study.state, widget.program_control.programs):
        for name in ("processes", "_processes"):
            if hasattr(part, name):
                setattr(part, name, processes)
    widget.connection.master_online = True
    widget.results_tabs.setCurrentWidget(widget.programs)
    widget.resize(1366, 768)
    widget.show()
    app.processEvents()
    yield widget
    processes.close()
    processes.wait_closed()
    widget.study.edited.close()
    widget.close()
    widget.deleteLater()
    app.processEvents()


def add(study, *words):
    """Add a Python program by the panel, and select it; return its name."""
    study.programs.command.setText(" ".join([sys.executable, "-c", *words]))
    study.programs.add.click()
    return study.programs.selected


def press(study, action):
    assert study.programs.buttons[action].isEnabled()
    study.programs.buttons[action].click()


def state(study, name):
    """Return what the panel says of a program after a look; an end that it says has been reported, too."""
    study.program_control.follow()
    for text in study.study.ended_processes():
        study.say(text)
    table = study.programs.table
    rows = {table.text(row, 0): table.text(row, 1) for row in range(table.rowCount())}
    return rows[name]


def test_own_programs_survive_a_restart_and_wait_for_a_click(study, tmp_path):
    mark = tmp_path / "it ran"
    name = add(study, '\'open("{}", "w")\''.format(mark), "1")
    add(study, '"{}"'.format(ENDS), "2")
    kept = study.save_settings()
    again = quiet_study(scenario_from_dict({"poses": [[0, 0, 0]]}))
    processes = Processes()
    try:
        programs = again.program_control.programs
        programs._processes = processes
        again.restore_settings(kept)
        own = [program for program in programs.all() if programs.is_users(program.name)]
        assert [(program.name, program.state) for program in own] == [
            (name, "not started"),
            (name + "_2", "not started"),
        ]
        again.program_control.follow()
        assert not mark.exists() and not any(processes.is_running(each.name) for each in own)
        again.connection.master_online = True
        programs.start(name)
        wait_until(mark.exists)
        assert again.save_settings()["programs"] == kept["programs"]
    finally:
        processes.close()
        processes.wait_closed()
        again.study.edited.close()
        again.close()
        again.deleteLater()


def test_settings_that_are_no_commands_are_left_out(study):
    for text in (None, "", "[", "3", '{"a": 1}', '[3, null, "", "\'", "{}"]'):
        study.program_control.programs.take_up(text and text.replace("{}", "x" * 5000))
        assert not any(map(study.program_control.programs.is_users, ("program", "x" * 5000)))
        assert study.save_settings()["programs"] == "[]"


def test_a_program_of_ones_own_is_listed_started_and_its_end_reported(study):
    name = add(study, '"{}"'.format(ENDS), "3")
    assert state(study, name) == "not started"
    press(study, "start")
    assert wait_until(lambda: state(study, name) == "ended with 3")
    assert study.programs.output.toPlainText().strip() == "so far"
    assert "{} ended with 3".format(name) in study.messages.toPlainText()
    press(study, "remove")
    assert study.programs.table.rowCount() == 4


def test_programs_take_interrupts_though_a_background_job_ignores_them():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        processes = Processes()
        processes.launch("one", [sys.executable, "-c", RUNS])
        wait_until(lambda: "running" in processes.output("one"))
        signal.raise_signal(signal.SIGINT)  # the GUI itself still ignores it
        processes.close()
        processes.wait_closed()
    finally:
        signal.signal(signal.SIGINT, before)
    assert processes.code("one") in (1, -signal.SIGINT)


def test_one_that_runs_is_ended_restarted_and_killed(study):
    name = add(study, '"{}"'.format(RUNS))
    press(study, "start")
    assert wait_until(lambda: state(study, name).startswith("runs for"))
    assert not study.programs.buttons["remove"].isEnabled()
    wait_until(lambda: "running" in study.study.processes.output(name))
    first = study.study.processes.running[name].pid
    press(study, "restart")
    assert wait_until(lambda: state(study, name).startswith("runs for"))
    assert study.study.processes.running[name].pid != first
    press(study, "kill")
    assert wait_until(lambda: state(study, name) == "killed (signal 9)")
    press(study, "start")
    wait_until(lambda: "running" in study.study.processes.output(name))
    study.program_control.show()
    press(study, "end")
    assert wait_until(lambda: state(study, name) not in ("is ending", "not started"))
    assert state(study, name) in ("ended with 1", "interrupted (signal 2)")


def test_a_command_that_cannot_be_run_is_refused(study):
    for command, said in (
        ("", "no command: wanted one such as rosrun"),
        ("rosrun 'open", "No closing quotation"),
        ("no_such_program_here now", "no program 'no_such_program_here' is found"),
    ):
        study.programs.command.setText(command)
        study.programs.add.click()
        assert said in study.messages.toPlainText()
        assert len(study.program_control.programs.all()) == 4


def test_a_program_takes_neither_the_name_nor_the_log_of_the_guis_own(study, monkeypatch):
    monkeypatch.setattr("mrs_simulator.rqt_plugin.run.programs.shutil.which", lambda name: name)
    programs, names = study.program_control.programs, []
    for command, name in (
        ("rosrun mrs_simulator stage --help", "stage_2"),
        ("roslaunch mrs_simulator report.launch", "report_2"),
        ("python3 tools/follow.py fast", "follow"),
        ("python3 -c pass", "python3"),
    ):
        assert programs.add(command) == programs.add(command) == ""  # the same one once
        names.append(name)
        assert [p.name for p in programs.all() if programs.is_users(p.name)] == names


def test_the_stage_is_not_started_where_one_runs_elsewhere(study):
    study.connection.is_fresh.side_effect = lambda name: name in ("stage", "state")
    assert state(study, "stage") == "started elsewhere"
    study.connection.master_online = False
    study.programs.select("rosbag")
    study.program_control.show()
    assert not study.programs.buttons["start"].isEnabled()
    assert "no ROS master" in study.programs.buttons["start"].toolTip()


def test_times_in_words():
    assert [_duration(value) for value in (0.4, 59.0, 61.0, 3600.0)] == [
        "0 s",
        "59 s",
        "1 min 01 s",
        "60 min 00 s",
    ]


def test_diagnostics_are_shown_for_each_part_and_old_ones_are_stale(study, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(diagnostics_module.time, "monotonic", lambda: now[0])
    monkeypatch.setattr("mrs_simulator.ros.node.diagnostics.rospy.get_rostime", lambda: None)
    received = DiagnosticsConnection()
    message = array(
        "stage", [Health("", OK, "running", {"robots": 3}), Health("sensors", ERROR, "slow", {})]
    )
    received.on_message(message)
    study.connection.diagnostics.side_effect = received.parts

    def rows():
        study.program_control.show()
        table = study.programs.nodes
        return [tuple(table.text(row, c) for c in range(3)) for row in range(table.rowCount())]

    assert rows() == [("stage", "good", "running"), ("stage: sensors", "error", "slow")]
    assert "robots = 3" in study.programs.nodes.item(0, 0).toolTip()
    assert study.programs.details.tabText(1) == "Diagnostics (1)"
    now[0] += 6.0
    assert [row[1] for row in rows()] == ["stale", "stale"]
    now[0] += 60.0
    received.parts()
    assert rows() == [("", "", "Nothing has been received on /diagnostics yet.")]


@pytest.mark.parametrize(
    "name, shown",
    [
        ("mrs_gui_7882_1795362977123", "mrs_gui"),
        ("mrs_gui_7882_1795362977123: sensors", "mrs_gui: sensors"),
        ("laser_1_2", "laser_1_2"),
    ],
)
def test_what_makes_an_anonymous_name_unique_is_not_shown(name, shown):
    assert short(name) == shown


def test_what_is_asked_for_next_puts_the_last_error_away(study):
    study.say(ErrorMessage("stage killed"))
    assert study.banners.text("error")
    press(study, "end")
    assert not study.banners.text("error") and "stage killed" in study.messages.toPlainText()


def test_diagnostics_that_are_not_shown_have_no_subscriber(study):
    study.program_control.follow()
    study.connection.watch_diagnostics.assert_called_with(True)
    study.results_tabs.setCurrentIndex(0)
    study.program_control.follow()
    study.connection.watch_diagnostics.assert_called_with(False)
