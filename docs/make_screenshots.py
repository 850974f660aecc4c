#!/usr/bin/env python3
"""Make the pictures of the GUI that the README shows: python3 docs/make_screenshots.py DIR

Starts a ROS master of its own on this host; needs no display.
"""

import os
import socket
import subprocess
import sys
import time

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ["ROS_HOSTNAME"] = "localhost"
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SIZE = (1366, 768)  # [px]
LIMIT = 90.0  # [s] for anything to come about


def free_port():
    """Return a port of this host that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def main(folder):
    """Take the pictures of a whole study."""
    port = free_port()
    os.environ["ROS_MASTER_URI"] = "http://localhost:{}".format(port)
    master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)])
    try:
        _study(folder)
    finally:
        master.terminate()
        master.wait()


def _study(folder):
    import rosgraph
    import rospy
    from python_qt_binding.QtWidgets import QApplication

    from mrs_simulator import load_scenario
    from mrs_simulator.rqt_plugin.link import RosLink
    from mrs_simulator.rqt_plugin.processes import Processes
    from mrs_simulator.rqt_plugin.study_widget import StudyWidget

    application = QApplication([])

    def until(condition):
        end = time.monotonic() + LIMIT
        while not condition():
            if time.monotonic() > end:
                raise SystemExit("nothing to take a picture of within {:g} s".format(LIMIT))
            application.processEvents()
            time.sleep(0.005)

    def rest(seconds):
        end = time.monotonic() + seconds
        until(lambda: time.monotonic() > end)

    def picture(name):
        rest(0.8)
        gui.grab().save(os.path.join(folder, name + ".png"))

    until(rosgraph.is_master_online)
    rospy.init_node("screenshots", disable_signals=True)
    paper = load_scenario(os.path.join(ROOT, "scenarios", "paper.yaml"))
    gui = StudyWidget(RosLink(), Processes(), paper)
    gui.resize(*SIZE)
    gui.show()
    try:
        rest(1.5)
        picture("gui_team")
        gui.bar.set_speed(5)
        gui.bar.button("simulate").click()
        until(lambda: gui.link.is_fresh("stage"))
        gui.bar.button("control").click()
        gui.settings_tabs.setCurrentIndex(1)
        until(lambda: len(gui.history.time) and gui.history.command[-1].any())
        begun = gui.history.time[-1]
        until(lambda: gui.history.time[-1] > begun + 15.0)
        gui.curves.setFocus()
        picture("gui_run")
        until(lambda: gui.history.time[-1] > begun + 80.0)
        gui.settings_tabs.setCurrentIndex(2)
        gui.save_results(os.path.join(gui.study.processes.directory, "results"))
        until(lambda: gui.verdict.toPlainText())
        picture("gui_verdict")
    finally:
        gui.close_study()


if __name__ == "__main__":
    if len(sys.argv) != 2 or not os.path.isdir(sys.argv[1]):
        raise SystemExit(__doc__)
    main(sys.argv[1])
