"""A sweep and a search of the GUI over ROS, whose programs rosrun starts."""

CODE = """
gui.bring_forward("Sweep")
panel = gui.sweep
until(lambda: panel.axes[1].name.currentText() == "control.rate")
for form, low, high in zip(panel.axes, ("0.5", "4"), ("4", "20")):
    form.low.setText(low)
    form.high.setText(high)
    form.count.setValue(2)
QTest.mouseClick(panel.start, Qt.LeftButton)
until(lambda: gui.sweep_control.cells and len(gui.sweep_control.cells.known()) == 4)
print([[cell.outcome for cell in row] for row in gui.sweep_control.cells.cells])
QTest.mouseClick(panel.map, Qt.LeftButton, Qt.NoModifier, panel.map.cell_box(0, 1).center().toPoint())
until(lambda: gui.opened.run is not None)
print(gui.opened.run.scenario.control.parameters["gain"])
gui.bring_forward("Search")
until(gui.search.vary.toPlainText)
gui.search.share.setText("0.5")
gui.search.confidence.setText("0.5")
QTest.mouseClick(gui.search.buttons["assure"], Qt.LeftButton)
until(lambda: not gui.search.cancel.isEnabled())
print(gui.search.text.toPlainText())
"""


def test_cells_and_searches_are_run_by_the_package_s_programs(gui):
    output = gui(CODE, scenario="consensus")
    assert "[['passed', 'failed'], ['passed', 'passed']]" in output
    assert "\n4.0\n" in output
    assert "with 50 % confidence at least 50 % of the runs drawn from this search" in output
