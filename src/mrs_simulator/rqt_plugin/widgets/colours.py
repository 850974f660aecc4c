"""Colours of robots, the same as in the saved figures."""

from python_qt_binding.QtGui import QColor

from mrs_simulator.study.figures import PALETTE


def colour(number):
    """Return the ``QColor`` of robot ``number``, 1 for the first."""
    return QColor(PALETTE[(number - 1) % len(PALETTE)])
