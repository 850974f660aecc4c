"""Ctrl-C in the terminal of the host closes its windows from the event loop, never within a paint."""

import os
import signal

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from python_qt_binding.QtWidgets import QApplication

from mrs_simulator.rqt_plugin.interrupts import defer_interrupts

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
