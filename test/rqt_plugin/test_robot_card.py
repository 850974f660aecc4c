"""The card of the robot selected."""

import os

import numpy as np

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PyQt5.QtWidgets import QApplication
from snapshots import snapshot_of

from mrs_simulator.rqt_plugin.map.robot_card import card_lines
from mrs_simulator.rqt_plugin.map.view import MapView

N = 4


def snapshot():
    pose, twist, command = np.zeros((N, 3)), np.zeros((N, 3)), np.tile([1.0, -0.25], (N, 1))
    pose[:, 0], pose[:, 1] = 4.9, 3.0 * np.arange(N)
    twist[:, 0], twist[:, 2] = 0.9, -0.2
    return snapshot_of(4.9, tuple(range(1, N + 1)), pose, twist, command, np.ones(N, dtype=bool))


def test_the_card_has_pose_speed_command_neighbours_and_distance_to_the_target():
    application = QApplication.instance() or QApplication([])
    view = MapView()
    view.show_snapshot(snapshot())
    targets = view.team.pose[:, :2] + (0.3, 0.4)
    edges = [(2, 1, 1.0), (2, 3, 1.0), (4, 2, 1.0)]
    assert card_lines(view.team, edges, True, targets, 2) == [
        "Robot 2",
        "(4.90, 3.00) m, \u03b8 0.0\u00b0",
        "v 0.90 m/s, \u03c9 \u22120.20 rad/s",
        "command 1.00 m/s, \u22120.25 rad/s",
        "receives from: 1, 3",
        "sends to: 4",
        "0.50 m from its target",
    ]
    lines = card_lines(view.team, edges, False, None, 2)
    assert lines[-1] == "neighbours: 1, 3, 4"
    assert card_lines(view.team, edges, True, None, 9) == []
    application.processEvents()
