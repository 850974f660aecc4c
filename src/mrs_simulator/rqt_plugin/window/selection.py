"""One robot selected in the whole window: chosen in any part, picked out in all."""

from mrs_simulator.rqt_plugin.widgets.guard import guarded


class Selection:
    """Tells map, 3D view, curves, table and the tab *Robot* which robot was chosen, 0 for none."""

    def __init__(self, panels):
        self._panels, self.number = panels, 0
        for chosen in (
            panels.map.robot_clicked,
            panels.view.canvas.robot_clicked,
            panels.curves.robot_clicked,
            panels.team.robot_chosen,
            panels.sensors.robot_chosen,
        ):
            chosen.connect(self.choose)

    @guarded
    def choose(self, number):
        """Select the robot ``number``, 0 for none."""
        panels, self.number = self._panels, int(number)
        panels.sensors.show_robot(self.number)
        panels.map_panel.choose(self.number)
        panels.curves.pick_out(self.number)
        panels.team.select(self.number)
