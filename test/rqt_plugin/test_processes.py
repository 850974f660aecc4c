"""Programs that the GUI starts are ended for certain: interrupted, then terminated, then killed."""

import os
import stat

import pytest
from ros_fixtures import wait_until

from mrs_simulator.rqt_plugin.run import processes as module

DEAF = """#!/bin/sh
trap '' INT TERM
sleep 1000 &
echo $! started
wait
while true; do sleep 0.1; done
"""


@pytest.fixture
def deaf(tmp_path, monkeypatch):
    """Return ``Processes`` whose programs heed neither INT nor TERM."""
    rosrun = tmp_path / "rosrun"
    rosrun.write_text(DEAF)
    rosrun.chmod(rosrun.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", "{}:{}".format(tmp_path, os.environ["PATH"]))
    short = [(number, 0.2) for number, _ in module.ENDINGS]
    monkeypatch.setattr(module, "ENDINGS", short)
    processes = module.Processes()
    processes.start("control", "pioneer_control")
    wait_until(lambda: "started" in processes.output("control"))
    yield processes
    processes.close()
    processes.wait_closed()


def exists(pid):
    try:
        with open("/proc/{}/stat".format(pid)) as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_program_that_heeds_no_signal_is_killed_with_all_it_has_started(deaf):
    child = int(deaf.output("control").split()[0])
    deaf.stop("control")
    assert not deaf.is_running("control") and deaf.is_ending("control")
    wait_until(lambda: not exists(child))
    (ended,) = wait_until(lambda: deaf.is_ending("control") and deaf.take_ended())
    assert ended[0].startswith("control ") and ended[1] == -9 and not deaf.is_ending("control")


def test_of_a_long_output_the_end_is_read_alone():
    processes = module.Processes()
    processes.launch("noise", ["sh", "-c", "yes '\u00e4' | head -n 60000; echo end"])
    wait_until(lambda: not processes.is_running("noise"))
    output = processes.output("noise")
    assert output.endswith("\u00e4\nend\n") and len(output) == module.TAIL
    processes.close()
    processes.wait_closed()


def test_closing_ends_what_heeds_no_signal(deaf):
    child = int(deaf.output("control").split()[0])
    deaf.close()
    deaf.wait_closed()
    wait_until(lambda: not exists(child))
    assert not os.path.exists(deaf.directory)


def test_a_hanging_program_is_killed_at_once_when_that_is_asked_for(deaf):
    deaf.kill("control")
    wait_until(lambda: not deaf.is_running("control"))
    assert deaf.take_ended()[0][:2] == ("control", -9)


WRITING = """#!/bin/sh
trap 'sleep 0.8; echo written; exit 0' INT
trap 'echo cut off; exit 1' TERM
echo started
while true; do sleep 0.1; done
"""


@pytest.mark.parametrize("closes", [False, True])
def test_a_recorder_has_the_time_to_write_its_results(deaf, tmp_path, closes):
    (tmp_path / "rosrun").write_text(WRITING)
    deaf.start("record", "record")
    wait_until(lambda: "started" in deaf.output("record"))
    process = deaf.running["record"]
    if closes:
        deaf.close()
    else:
        deaf.stop("record")
    assert process.wait(60) == 0
