"""The one module that knows which binding of Qt there is."""

import os
import subprocess
import sys

import pytest

WITHOUT = """
import sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {missing!r}:
            raise ImportError("no " + name)

sys.meta_path.insert(0, Missing())
"""
WORKS = """
from mrs_simulator.rqt_plugin.qt.QtCore import QObject, Signal, Slot
from mrs_simulator.rqt_plugin.qt.QtWidgets import QApplication
from mrs_simulator.rqt_plugin.widgets import banners, fields
from mrs_simulator.rqt_plugin.map import painted_map

class Sender(QObject):
    sent = Signal(int)

received = []
sender = Sender()
sender.sent.connect(received.append)
sender.sent.emit(3)
print(received, "python_qt_binding" in sys.modules)
"""


def ran(missing, code):
    """Return what a fresh interpreter without the packages ``missing`` says of ``code``."""
    environment = dict(os.environ, QT_QPA_PLATFORM="offscreen")
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT.format(missing=missing) + code],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=60,
    )
    return done.stdout.decode()


@pytest.mark.parametrize("missing, said", [((), "[3] True"), (("python_qt_binding",), "[3] False")])
def test_the_widgets_work_by_either_binding(missing, said):
    pytest.importorskip("python_qt_binding.QtCore")
    assert ran(missing, WORKS).strip() == said


def test_without_any_it_says_what_to_install():
    said = ran(("python_qt_binding", "PyQt5"), "import mrs_simulator.rqt_plugin.qt")
    assert "ImportError: the window needs PyQt5: pip install PyQt5" in said
