"""Lets a widget scroll where there is less room than it needs."""

from mrs_simulator.rqt_plugin.qt.QtWidgets import QFrame, QScrollArea


def scrolled(widget):
    """Return an area with ``widget``, which is as large as the area at least."""
    area = QScrollArea(widgetResizable=True, frameShape=QFrame.NoFrame)
    area.setWidget(widget)
    return area
