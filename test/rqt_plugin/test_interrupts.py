"""Ctrl-C closes the host's windows from the event loop, and ends what is only starting quietly."""

import glob
import os
import signal
import subprocess
import sys

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from PyQt5.QtWidgets import QApplication
from ros_fixtures import heed_interrupts

from mrs_simulator.rqt_plugin.widgets.interrupts import defer_interrupts

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPTS = sorted(glob.glob(os.path.join(ROOT, "src", "mrs_simulator", "scripts", "*")))
APP = QApplication.instance() or QApplication([])


@pytest.fixture
def closed():
    """Return the list that the host's handler appends to."""
    called, before = [], signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, lambda *given: called.append(given[0]))
    yield called
    signal.signal(signal.SIGINT, before)


def test_the_hosts_handler_waits_for_the_event_loop(closed):
    defer_interrupts()
    defer_interrupts()  # by a second instance of the plugin
    os.kill(os.getpid(), signal.SIGINT)
    for _ in range(1000):  # Python calls the handler here
        assert closed == []
    APP.processEvents()
    APP.processEvents()
    assert closed == [signal.SIGINT]


def test_a_host_without_a_handler_keeps_its_own_way(closed):
    for own in (signal.SIG_DFL, signal.SIG_IGN, signal.default_int_handler):
        signal.signal(signal.SIGINT, own)
        defer_interrupts()
        assert signal.getsignal(signal.SIGINT) is own


def test_an_interrupt_while_modules_load_shows_no_traceback(tmp_path):
    texts = set()
    for script in SCRIPTS:
        with open(script, encoding="utf-8") as file:
            texts.add(file.read())
    assert len(texts) == 1 and len(SCRIPTS) >= 20  # one program: what one of them does all do
    (tmp_path / "mrs_simulator").mkdir()
    loading = "import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n"
    (tmp_path / "mrs_simulator" / "__init__.py").write_text(loading)
    ended = subprocess.run(
        [sys.executable, SCRIPTS[0]],
        env=dict(os.environ, PYTHONPATH=str(tmp_path)),
        preexec_fn=heed_interrupts,
        stderr=subprocess.PIPE,
        timeout=60,
    )
    assert (ended.returncode, ended.stderr) == (-signal.SIGINT, b"")
