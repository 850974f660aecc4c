"""Keeps a widget over another one, so that nothing moves as it comes and goes."""

from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QObject, QPoint, Qt
from mrs_simulator.rqt_plugin.widgets.guard import guarded

MOVES = (QEvent.Resize, QEvent.Move)
GROWS = (QEvent.LayoutRequest, QEvent.Show)


class Overlay(QObject):
    """Places ``widget`` along an edge of ``floor``, as high as it needs to be."""

    def __init__(self, widget, floor, below=False):
        """``widget``: its parent contains ``floor``, or is that; ``below``: along the lower edge."""
        super().__init__(widget)
        self._widget, self._floor, self._below = widget, floor, below
        widget.setAttribute(Qt.WA_NoMousePropagation)
        widget.setCursor(Qt.ArrowCursor)
        widget.installEventFilter(self)
        while floor is not widget.parentWidget():
            floor.installEventFilter(self)
            floor = floor.parentWidget()
        floor.installEventFilter(self)

    def eventFilter(self, watched, event):
        """Follow what lies below, and what is shown."""
        if event.type() in (GROWS if watched is self._widget else MOVES):
            self.place()
        return False

    @guarded
    def place(self):
        """Put the widget in its place."""
        corner = self._floor.mapTo(self._widget.parentWidget(), QPoint(0, 0))
        width, layout = self._floor.width(), self._widget.layout()
        high = layout.totalHeightForWidth(width) if layout.hasHeightForWidth() else -1
        high = layout.totalSizeHint().height() if high < 0 else high
        down = self._floor.height() - high if self._below else 0
        self._widget.setGeometry(corner.x(), corner.y() + down, width, high)
        self._widget.raise_()
