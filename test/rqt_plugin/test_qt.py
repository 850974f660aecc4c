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
            raise ModuleNotFoundError("no " + name, name=name)

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


def test_the_widgets_work_by_the_binding_of_ros():
    pytest.importorskip("python_qt_binding.QtCore")
    assert ran((), WORKS).strip() == "[3] True"


def test_without_any_it_says_what_to_install():
    said = ran(("python_qt_binding", "PyQt5"), "import mrs_simulator.rqt_plugin.qt")
    assert "ImportError: the window needs PyQt5: pip install PyQt5" in said


ROS = (
    "rospy",
    "rosgraph",
    "roslib",
    "rospkg",
    "genpy",
    "std_msgs",
    "std_srvs",
    "geometry_msgs",
    "nav_msgs",
)
UNLOADED = tuple(set(ROS) - {"geometry_msgs"})  # for which classes of our own stand in
WINDOW = """
from mrs_simulator.rqt_plugin.qt.QtWidgets import QApplication
application = QApplication([])
sys.path.insert(0, {test!r})
from gui_fixtures import quiet_study
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import shipped_scenarios
study = quiet_study(load_scenario(shipped_scenarios() + "/paper.yaml"))
study.show()
application.processEvents()
print(sorted(set(sys.modules) & set({ros!r})), study.scenario.n)
"""


def test_widgets_work_and_the_window_opens_where_there_is_no_ros():
    directory = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    code = WORKS + WINDOW.format(test=directory, ros=UNLOADED)
    said = ran((*ROS, "python_qt_binding"), code).splitlines()
    assert "[3] False" in said and said[-1] == "[] 7", said
