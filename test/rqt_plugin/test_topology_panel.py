"""The topology editor's table: presets, edges, and the quantities that follow from them."""

import math
import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QPushButton

from mrs_simulator.rqt_plugin.team.topology_panel import TopologyPanel

APPLICATION = QApplication.instance() or QApplication([])


@pytest.fixture
def panel():
    made = TopologyPanel()
    made.set_team(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [9.0, 0.0]]))
    made.changes = []
    made.topology_changed.connect(lambda edges, directed: made.changes.append((edges, directed)))
    made.show()
    yield made
    made.deleteLater()


def click(panel, text):
    (button,) = [b for b in panel.findChildren(QPushButton) if b.text() == text]
    QTest.mouseClick(button, Qt.LeftButton)


def test_a_preset_gives_lambda_2_beside_the_predicted_time(panel):
    panel.preset.setCurrentText("path")
    click(panel, "Make")
    edges, directed = panel.changes[-1]
    assert [edge[:2] for edge in edges] == [(1, 2), (2, 3), (3, 4)] and not directed
    slowest = 2.0 * (1.0 - math.cos(math.pi / 4))  # of a path of four
    assert panel.figure("lambda") == "{:.4g}".format(slowest)
    panel.set_convergence_time("6.68 s to 2 %, at 0.586 /s")
    assert panel.figure("time") == "6.68 s to 2 %, at 0.586 /s"
    panel.set_convergence_time("")
    assert panel.figure("time") == "\u2013"


def test_presets_of_places_and_of_chance(panel):
    panel.preset.setCurrentText("k_nearest")
    panel.amount.setValue(1.0)
    click(panel, "Make")
    assert [edge[:2] for edge in panel.changes[-1][0]] == [(1, 2), (2, 1), (3, 2), (4, 3)]
    panel.preset.setCurrentText("erdos_renyi")
    assert panel.seed.isVisible() and panel.amount.value() == 0.3
    panel.amount.setValue(1.0)
    click(panel, "Make")
    assert len(panel.changes[-1][0]) == 12 and panel.changes[-1][1]  # directed, as before
    panel.preset.setCurrentText("path")
    assert not panel.seed.isVisible() and not panel.amount.isVisible()


def test_a_preset_that_cannot_be_is_said(panel):
    panel.preset.setCurrentText("k_nearest")
    panel.amount.setValue(9.0)
    click(panel, "Make")
    assert not panel.changes and "9" in panel.message.text()


def test_edges_are_added_removed_and_checked(panel):
    panel.add_edge(1, 2)
    panel.add_edge(2, 3)
    assert panel.figure("tree") == "no"
    panel.add_edge(3, 4)
    assert panel.figure("tree") == "yes"
    panel.add_edge(3, 4)  # twice: refused, and said
    assert len(panel.edges()) == 3 and "given twice" in panel.message.text()
    panel.remove_edge(2, 3)
    assert panel.edges() == [(1, 2, 1.0), (3, 4, 1.0)]
    assert len(panel.changes) == 4


def test_a_weight_typed_into_the_table_counts(panel):
    panel.add_edge(1, 2)
    panel.table.item(0, 2).setText("2.5")
    assert panel.changes[-1][0] == [(1, 2, 2.5)]
    panel.table.item(0, 2).setText("-1")
    assert panel.edges() == [(1, 2, 2.5)] and "above 0" in panel.message.text()
    panel.table.item(0, 1).setText("two")
    assert panel.edges() == [(1, 2, 2.5)] and "'two'" in panel.message.text()


def test_random_is_connected_and_proximity_is_by_distance(panel):
    panel.preset.setCurrentText("random")
    click(panel, "Make")
    assert panel.figure("tree") == "yes"
    panel.preset.setCurrentText("proximity")
    panel.amount.setValue(1.5)
    click(panel, "Make")
    assert [edge[:2] for edge in panel.edges()] == [(1, 2), (2, 3)]
    assert panel.figure("tree") == "no" and panel.figure("lambda") == "0"


def test_a_smaller_team_loses_the_edges_of_those_that_go(panel):
    panel.set_topology([(1, 2, 1.0), (3, 4, 1.0)], False)
    panel.set_team(np.zeros((3, 2)))
    assert panel.edges() == [(1, 2, 1.0)]
    assert panel.changes == []  # no edit was made


def test_undirected_takes_one_of_two_opposite_edges(panel):
    panel.set_topology([(1, 2, 1.0), (2, 1, 1.0), (2, 3, 1.0)], True)
    QTest.mouseClick(panel.as_directed, Qt.LeftButton, pos=panel.as_directed.rect().center())
    panel.as_directed.setChecked(False)
    assert panel.edges() == [(1, 2, 1.0), (2, 3, 1.0)] and not panel.directed()
