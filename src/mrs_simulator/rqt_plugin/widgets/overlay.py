"""Keeps a widget over another one, so that nothing moves as it comes and goes."""

from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QObject, QPoint, Qt
from mrs_simulator.rqt_plugin.widgets.guard import guarded

MOVES = (QEvent.Resize, QEvent.Move)
GROWS = (QEvent.LayoutRequest, QEvent.Show)


class Overlay(QObject):
    """Places ``widget`` along an edge of ``floor``, as high as it needs to be."""

    def __init__(self, widget, floor, area=None):
        """``widget``: its parent contains ``floor``, or is that.

        ``area()``: the ``QRect`` of ``floor`` along whose lower edge it is; None: the upper edge of all.
        """
        super().__init__(widget)
        self._widget, self._floor, self._area = widget, floor, area
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
        area = self._floor.rect() if self._area is None else self._area()
        width = area.width()
        high = self._high(width)
        down = 0 if self._area is None else area.bottom() + 1 - high
        self._widget.setGeometry(corner.x() + area.x(), corner.y() + down, width, high)
        self._widget.raise_()

    def _high(self, width):
        """Return how high [px] the widget needs to be."""
        layout = self._widget.layout()
        if layout is None:
            return self._widget.heightForWidth(width)
        high = layout.totalHeightForWidth(width) if layout.hasHeightForWidth() else -1
        return layout.totalSizeHint().height() if high < 0 else high
