"""The field for how long a run lasts."""

import re

from mrs_simulator.core.fields import shown
from mrs_simulator.rqt_plugin.qt.QtCore import Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QPalette
from mrs_simulator.rqt_plugin.widgets.commas import comma_remark
from mrs_simulator.rqt_plugin.widgets.fields import TextField, number_text
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import tint

UNITS = {"": 1.0, "s": 1.0, "min": 60.0, "h": 3600.0}  # [s]
TIP = "How long a run lasts in simulated time: seconds, or as 2 min or 1 h"
WANTED = "duration = {}: wanted a number of seconds, such as 20, 1.5 min or 1 h{}"
USUAL = "3600 s"  # has room


def read_duration(text):
    """Return the duration [s] that a ``text`` says, with a unit or without; else raise ``ValueError``."""
    number, unit = re.fullmatch(r"(.*?)\s*(s|min|h|)", text.strip()).groups()
    try:
        return float(number) * UNITS[unit]
    except ValueError:
        raise ValueError(WANTED.format(shown(text), comma_remark(number))) from None


@guarded
class DurationField(TextField):
    """A duration [s]; a refused text stays, in red, until there is another."""

    chosen = Signal(float)  # [s], a number in any range
    refused = Signal(str)  # why the text is no duration

    def __init__(self):
        super().__init__(is_number=False)
        self._duration, self.why = None, ""
        self._fit()
        self.setAccessibleName("Duration of the run")
        self.finished.connect(self._on_finished)
        self.given_up.connect(self._on_given_up)
        self._say("")

    def _fit(self):
        """Take the width of the text, and of a usual one at least."""
        metrics = self.fontMetrics()
        frame = self.sizeHint().width() - 17 * metrics.horizontalAdvance("x")  # as Qt's hint has it
        self.setFixedWidth(frame + max(map(metrics.horizontalAdvance, (USUAL, self.text()))))

    def show_duration(self, duration):
        """Show the ``duration`` [s] in force, unless another is being typed or was refused since."""
        if duration != self._duration or not (self.why or self.busy()):
            self._duration = duration
            self._say("")
            self.show_value(number_text(duration) + " s")
            self._fit()

    def refuse(self, why):
        """Show that the text is refused, and ``why``."""
        self._say(why)
        self.refused.emit(why)

    def _say(self, why):
        self.why = why
        self.setToolTip("\n".join(filter(None, [TIP, why])))
        palette = QPalette()
        if why:
            palette.setColor(QPalette.Text, QColor(tint("error", palette)))
        self.setPalette(palette)

    def _on_finished(self):
        if not self.isModified():
            return
        try:
            self.chosen.emit(read_duration(self.text()))
        except ValueError as error:
            self.refuse(str(error))

    def _on_given_up(self):
        duration, self._duration = self._duration, None
        self.show_duration(duration)
