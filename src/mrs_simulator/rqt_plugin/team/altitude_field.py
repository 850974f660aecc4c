"""A field for the initial height of robots that fly."""

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.widgets.fields import PointSpinBox
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.scenario.scenario import FARTHEST

SEVERAL = -0.1  # [m], shown as text: the heights differ
STEP = 0.1  # [m]
TIP = (
    "Initial height above the ground of robots that fly: of those selected in the table, or of all if "
    "none is selected"
)


@guarded
class AltitudeField(PointSpinBox):
    """A height [m], or a text where heights differ."""

    chosen = Signal(float)  # the user wants this height

    def __init__(self, parent=None):
        super().__init__(parent)
        self.setRange(SEVERAL, FARTHEST)
        self.setSpecialValueText("several initial heights")
        self.setPrefix("initial height ")
        self.setSuffix(" m")
        self.setSingleStep(STEP)
        self.setKeyboardTracking(False)
        self.setFocusPolicy(Qt.StrongFocus)
        self.setToolTip(TIP)
        self.valueChanged.connect(self._on_changed)

    def show_heights(self, heights):
        """Show ``heights`` (n,) [m]; no signal."""
        one = len(heights) and (heights == heights[0]).all()
        blocked = self.blockSignals(True)
        self.setValue(float(heights[0]) if one else SEVERAL)
        self.blockSignals(blocked)

    def wheelEvent(self, event):
        """Leave the wheel to the scroll area around."""
        event.ignore()

    def _on_changed(self, *_):
        if self.value() >= 0.0:
            self.chosen.emit(self.value())
