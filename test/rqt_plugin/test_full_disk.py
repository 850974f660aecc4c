"""A full disk: the window says so, goes on, and nothing that was recorded is lost."""

import errno
import os
import subprocess
import sys
import textwrap
import time

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from PyQt5.QtWidgets import QApplication, QLabel

from mrs_simulator.rqt_plugin.local_side import engine as engines
from mrs_simulator.rqt_plugin.local_side.connection import LocalConnection
from mrs_simulator.rqt_plugin.local_side.processes import ENGINE, LocalProcesses
from mrs_simulator.rqt_plugin.local_side.run_record import RunRecord
from mrs_simulator.rqt_plugin.run import stage_run
from mrs_simulator.rqt_plugin.run.autosave import Autosave
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.run.study_run import WHOLE, StudyRun
from mrs_simulator.rqt_plugin.window.export import save_picture
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.shipped import scenario_path

FULL = "/dev/full"  # where every write fails as on a full disk
APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.skipif(not os.path.exists(FULL), reason="no " + FULL)


def no_room(*_, **__):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "run.csv")


@pytest.mark.parametrize("kind", ["png", "pdf"])
def test_a_picture_that_finds_no_room_is_not_said_to_be_saved(tmp_path, kind):
    path, widget = tmp_path / ("map." + kind), QLabel("map")
    path.symlink_to(FULL)
    with pytest.raises(OSError, match="No space left") as raised:
        save_picture(widget, str(path))
    assert raised.value.filename == str(path)


def test_edits_that_find_no_room_leave_those_of_before(tmp_path):
    class Narrow:
        """A file without room for more than some bytes."""

        def __init__(self, file):
            self._file = file

        def __getattr__(self, name):
            return getattr(self._file, name)

        def write(self, content):
            room = 20 - self._file.tell()
            if room <= 0:
                no_room()
            return self._file.write(content[:room])

    autosave = Autosave(str(tmp_path))
    autosave.keep("edited once")
    autosave._file = Narrow(autosave._file)
    with pytest.raises(OSError, match="No space left"):
        autosave.keep("edited twice, at greater length")
    (path,) = tmp_path.iterdir()
    assert path.read_text() == "edited once"
    autosave.keep("and again")
    assert path.read_text() == "and again"
    autosave.forget()


@pytest.fixture
def study():
    connection = LocalConnection()
    run = StudyRun(
        connection, LocalProcesses(connection), load_scenario(scenario_path("paper_four"))
    )
    yield run
    run.processes.close()
    run.processes.wait_closed()
    connection.close()


def test_a_start_without_room_for_its_scenario_is_refused_with_a_message(study, monkeypatch):
    monkeypatch.setattr(stage_run, "write_scenario", no_room)
    assert not study.do(WHOLE)
    ((name, success, answer),) = study.connection.take_results()
    said = study.take_result(name, success, answer)
    assert (
        isinstance(said, ErrorMessage) and said.startswith("not started: ") and "No space" in said
    )
    assert not study.processes.is_running("stage") and study.stage.is_gone()


def test_what_was_recorded_stays_where_no_room_is_for_a_copy(study, tmp_path):
    recorded = os.path.join(study.processes.directory, "run_1")
    os.mkdir(recorded)
    open(os.path.join(recorded, "run.csv"), "w").close()
    shelf = tmp_path / "shelf" / "run"

    def write():
        (shelf / "run.csv").write_text("half a li")
        no_room()

    said = study.files._kept(write, str(shelf), recorded)
    assert isinstance(said, ErrorMessage) and "No space left" in said and "lost" not in said
    assert not shelf.exists()  # nor half a run on the shelf
    left = "{}_run_1".format(study.processes.directory)
    assert left in said and os.listdir(left) == ["run.csv"]
    study.processes.close()
    study.processes.wait_closed()
    assert os.listdir(left) == ["run.csv"]
    os.remove(os.path.join(left, "run.csv"))
    os.rmdir(left)
    shelf.mkdir()
    assert "is lost" in study.files._kept(write, str(shelf), None)
    assert shelf.exists()  # which was there before


def test_a_simulation_whose_output_finds_no_room_goes_on_and_so_does_a_law_that_prints(tmp_path):
    law = tmp_path / "prints.py"
    law.write_text(
        textwrap.dedent(
            """
            import sys
            import numpy as np
            from mrs_simulator.control.pioneer_control import PioneerControl

            class Prints(PioneerControl):
                def pointMassLaw(self, p):
                    print("here")
                    print("there", file=sys.stderr, flush=True)
                    return np.zeros_like(p)
            """
        )
    )
    path, connection = tmp_path / "prints.yaml", LocalConnection()
    content = {"poses": [[0, 0, 0], [2, 0, 0]], "control": {"protocol": str(law)}}
    path.write_text(scenario_from_dict(content, "test").to_yaml())
    command = [sys.executable, "-m", ENGINE, connection.address, str(path), "0", str(tmp_path)]
    with open(FULL, "w") as full:
        process = subprocess.Popen(
            command, stdout=full, stderr=full, env=dict(os.environ, PYTHONUNBUFFERED="1")
        )
    try:
        end = time.monotonic() + 120.0
        asked = False
        while connection.newest("control") is None or connection.newest("control").stamp < 1.0:
            assert process.poll() is None and time.monotonic() < end
            if connection.newest("stage") is not None and not asked:
                connection.ask("control", str(path))
                asked = True
            time.sleep(0.01)
        assert connection.newest("control").running and not connection.newest("control").trouble
    finally:
        process.kill()
        process.wait()
        connection.close()


def test_a_run_whose_facts_find_no_room_does_not_hold_up_the_next_one(
    tmp_path, monkeypatch, capsys
):
    sent = []

    class Link:
        def send(self, name, value=None):
            sent.append((name, value))

    scenario = load_scenario(scenario_path("paper_four"))
    path = tmp_path / "scenario.yaml"
    path.write_text(scenario.to_yaml())
    engine = engines.Engine(Link(), scenario, 0.0, str(tmp_path))
    engine._on_control(str(path))
    close = RunRecord.close
    monkeypatch.setattr(RunRecord, "close", lambda record: (close(record), no_room()))
    engine._on_reset()
    assert "No space left" in capsys.readouterr().err
    engine._on_control(str(path))
    engine._step()
    assert [value for name, value in sent if name == "run"][-1] == engine._record.directory
    engine.close()
