"""A form on the left of what it is about, above it where there is little room."""

from mrs_simulator.rqt_plugin.qt.QtCore import Qt
from mrs_simulator.rqt_plugin.qt.QtWidgets import QSplitter, QStyle, QWidget
from mrs_simulator.rqt_plugin.widgets.boxes import column_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.scrolled import scrolled

# [lines of text] of width, below which they are stacked; of the content's height
NARROW, LEAST = 36, 15


@guarded
class FormBeside(QWidget):
    """Scrolls a form alone where its content is beside it, and both together where they are stacked."""

    def __init__(self, form, content, wide):
        """``wide`` [lines of text] is the form at first."""
        super().__init__()
        self._form, self._area, self.across = form, scrolled(form), QSplitter(Qt.Horizontal)
        self.across.addWidget(self._area)
        self.across.addWidget(content)
        self.across.setStretchFactor(1, 1)
        bar = self.style().pixelMetric(QStyle.PM_ScrollBarExtent)
        width = wide * self.fontMetrics().height() + bar
        self.across.setSizes([width, 2 * width])
        column_of(scrolled(self.across), owner=self, margins=0)

    def resizeEvent(self, event):
        """Put the form beside its content where there is room for both."""
        super().resizeEvent(event)
        line = self.fontMetrics().height()
        stacked = self.width() < NARROW * line
        self.across.setOrientation(Qt.Vertical if stacked else Qt.Horizontal)
        above = self._form.sizeHint().height() if stacked else 0
        self._area.setMinimumHeight(above)
        self.across.setMinimumHeight(above + LEAST * line if stacked else 0)
