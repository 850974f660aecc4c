"""Runs a scenario headless, over ROS in lockstep, and through the GUI, and tells how far they differ."""

import glob
import os

import numpy as np
from gui_fixtures import run_gui
from ros_fixtures import Ros

from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.study.run.experiment import run_experiment

LIMIT = 180.0  # [s] of wall time for one run
ROUNDING = 1e-6  # [s] within which two samples are of the same time
IN_GUI = """
import numpy as np
gui.bar.set_speed(0)
click("simulate")
until(lambda: gui.connection.is_fresh("stage"))
# At full speed a run may be half over before the GUI receives from a new node: time waits for it.
click("pause")
until(lambda: gui.connection.newest("stage").paused)
click("control")
until(lambda: gui.study.is_controlled())
import rosgraph
def connected():
    published = dict(rosgraph.Master("/gui").getSystemState()[0])
    heard = gui.connection._master.subscribers.values()
    return all(each.get_num_connections() for each in heard if published.get(each.resolved_name))
until(connected)
# rospy counts a connection before the publisher knows of it: the latched estimate tells that it does.
until(lambda: gui.study.scenario.estimates is None or gui.history.estimate is not None)
click("pause")
span = float(sys.argv[2])
def done():
    history = gui.history
    if history.begun is None or history.time[-1] - history.begun < span + 0.5:
        return False
    # The estimates of a sample may come after it.
    compared = history.time <= history.begun + span
    return gui.study.scenario.estimates is None or (
        history.estimate is not None and np.isfinite(history.estimate[compared]).all(axis=(1, 2))[-1]
    )
until(done, limit=120)
trouble += [] if "data is kept in" in gui.study.files.keep(gui.history) else ["not kept"]
gui.history.saved = gui.history.moved  # it need not be kept at the end as well
"""


def each_step(scenario):
    """Return ``scenario`` recorded at each step."""
    return scenario._replace(record_rate=1.0 / scenario.step)


def headless(scenario, out):
    """Return the verdict and the run of ``scenario`` in this process."""
    verdict = run_experiment(scenario, str(out), formats=())
    return verdict, read_run_csv(os.path.join(str(out), "run.csv"), scenario)


def over_ros(scenario, out):
    """Return the run of ``scenario`` by stage, control and record nodes, in lockstep."""
    ros = Ros(str(out))
    try:
        path = _written(scenario._replace(speed=0.0), out)
        ros.node("stage", "--scenario", path, "_lockstep:=true", "_wait_for_recorders:=1")
        ros.node("pioneer_control", "--scenario", path, "_lockstep:=true")
        record = ros.node("record", "--scenario", path, "--out", os.path.join(str(out), "ros"))
        ros.judged(record, os.path.join(str(out), "ros"), LIMIT)
    finally:
        ros.close()
    return read_run_csv(os.path.join(str(out), "ros", "run.csv"), scenario)


def in_gui(scenario, out):
    """Return the run of ``scenario`` started by the GUI's buttons, as fast as possible."""
    ros = Ros(str(out))
    ros.environment["HOME"] = str(out)
    try:
        ros.use_quick_rosrun()
        run_gui(ros, IN_GUI, _written(scenario, out), scenario.duration, limit=LIMIT)
    finally:
        ros.close()
    return read_run_csv(run_file(out), scenario)


def run_file(out):
    """Return the path of the samples that the GUI has kept below ``out``."""
    (path,) = glob.glob(os.path.join(str(out), ".local/share/mrs_simulator/runs", "*", "run.csv"))
    return path


def _written(scenario, out):
    path = os.path.join(str(out), "scenario.yaml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(scenario.to_yaml())
    return path


def difference(run, other):
    """Return the largest difference [m, rad] of poses between ``other`` and ``run`` at the same times.

    ``run`` has a sample of each step, ``other`` of some of them, up to the end of ``run`` at least.
    """
    assert other.time[-1] > run.time[-1] - ROUNDING, (other.time[-1], run.time[-1])
    shared = other.time <= run.time[-1] + ROUNDING
    rows = np.searchsorted(run.time, other.time[shared] - ROUNDING)
    np.testing.assert_allclose(run.time[rows], other.time[shared], rtol=0.0, atol=ROUNDING)
    apart = other.pose[shared] - run.pose[rows]
    apart[:, :, 2] = wrap_angle(apart[:, :, 2])
    return float(np.abs(apart).max())
