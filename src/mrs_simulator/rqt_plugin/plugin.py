"""The rqt plugin: the study widget inside rqt."""

from qt_gui.plugin import Plugin

from mrs_simulator.rqt_plugin.qt.QtCore import QCoreApplication, QEvent, QTimer
from mrs_simulator.rqt_plugin.ros_side.connection import RosConnection
from mrs_simulator.rqt_plugin.run.autosave import Autosave
from mrs_simulator.rqt_plugin.run.processes import Processes
from mrs_simulator.rqt_plugin.study_widget import StudyWidget
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.interrupts import defer_interrupts
from mrs_simulator.rqt_plugin.window.saved_layout import LAYOUT
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import shipped_scenarios

KEYS = ("scenario", "programs", *LAYOUT)


class MrsSimulator(Plugin):
    """Coordination studies of multi-robot systems."""

    def __init__(self, context):
        super().__init__(context)
        self.setObjectName("MrsSimulator")
        scenario = load_scenario(shipped_scenarios() + "/paper.yaml")
        self._widget = StudyWidget(RosConnection(), Processes(), scenario, Autosave())
        if context.serial_number() > 1:
            title = "{} ({})".format(self._widget.windowTitle(), context.serial_number())
            self._widget.setWindowTitle(title)
        context.add_widget(self._widget)
        defer_interrupts()

    @guarded
    def shutdown_plugin(self):
        """End what was started here."""
        self._widget.close_study()
        # Qt can crash over what still waits to be painted when rqt takes the widget out.
        QCoreApplication.sendPostedEvents(self._widget.window(), QEvent.UpdateRequest)
        # Closed by its title bar, the widget has left rqt, which then does not delete it.
        if self._widget.parent() is None:
            self._widget.deleteLater()

    @guarded
    def save_settings(self, _plugin_settings, instance_settings):
        """Keep scenario, layout and the user's own programs."""
        for key, value in self._widget.save_settings().items():
            instance_settings.set_value(key, value)

    @guarded
    def restore_settings(self, _plugin_settings, instance_settings):
        """Take up scenario, layout and the user's own programs, none of which is started."""
        settings = {key: instance_settings.value(key) for key in KEYS}
        # Later, as a user's law may take its time: rqt is to have its windows up by then.
        QTimer.singleShot(0, guarded(lambda: self._begin(settings)))

    def _begin(self, settings):
        self._widget.restore_settings(settings)
        if not settings["scenario"]:  # a new place in rqt
            self._widget.start.begin()
