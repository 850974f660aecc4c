"""Starts RViz with a view that holds all robots and obstacles of the scenario."""

import os
import signal
import subprocess
import sys
import tempfile

import numpy as np
import yaml

from mrs_simulator.ros.node.arguments import RUN_ARGUMENTS, parse, scenario_from
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.scenario.surroundings.obstacles import with_obstacles
from mrs_simulator.study.bad_input import refusing_bad_input

AREA = np.array([820.0, 600.0])  # [px] of the drawing in the window that the configuration asks for
MARGIN = 0.15  # about what is to be seen, as a share of its size
LEAST_EXTENT = 6.0  # [m] of what is to be seen
DISTANCE = 1.3  # [-] of the camera from the middle, over the larger side
LOCAL = dict(RUN_ARGUMENTS, config="RViz's configuration whose views are set")


def bounds(scenario):
    """Return the corners (low, high), each (2,) [m], of all robots' starts and obstacles but land."""
    low, high = scenario.poses[:, :2].min(axis=0), scenario.poses[:, :2].max(axis=0)
    return with_obstacles(low, high, obstacles_of(scenario), np.inf)


def set_views(configuration, low, high):
    """Have the views of RViz's ``configuration`` hold the rectangle from ``low`` to ``high`` [m]."""
    size = np.maximum(high - low, LEAST_EXTENT) * (1.0 + 2.0 * MARGIN)
    x, y = (0.5 * (low + high)).tolist()
    views = configuration["Visualization Manager"]["Views"]
    views["Current"].update(Scale=float(np.min(AREA / size)), X=x, Y=y)
    for view in views["Saved"]:
        view["Focal Point"].update(X=x, Y=y)
        view["Distance"] = DISTANCE * float(size.max())


def main():
    """Run RViz until its window is closed, with the arguments of the nodes of a run."""
    with refusing_bad_input("rviz_view"):
        arguments = parse("RViz, with a view of all robots and obstacles.", LOCAL)
        corners = bounds(scenario_from(arguments))
        with open(arguments.config, encoding="utf-8") as file:
            configuration = yaml.safe_load(file)
        set_views(configuration, *corners)
    with tempfile.TemporaryDirectory() as directory:
        path = os.path.join(directory, "mrs_simulator.rviz")
        with open(path, "w", encoding="utf-8") as file:
            yaml.safe_dump(configuration, file, sort_keys=False)
        for number in (signal.SIGINT, signal.SIGTERM):  # RViz gets them, too
            signal.signal(number, lambda *_: None)
        given = [word for word in sys.argv[1:] if word.startswith("__")]
        with refusing_bad_input("rviz_view"):
            code = subprocess.call(["rviz", "-d", path, *given])
    sys.exit(code)
