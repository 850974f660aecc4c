"""Keeps the window responsive while a user's law is loaded in its process."""

from mrs_simulator.rqt_plugin.qt.QtCore import QEventLoop
from mrs_simulator.rqt_plugin.qt.QtWidgets import QApplication

LONGEST = 20  # [ms] that events are handled between two looks at the law


class LawTrial:
    """Meanwhile only the emergency stop and *Cancel* work."""

    def __init__(self, panels, laws, began):
        """``laws``: the ``LawProcess`` that tries them; ``began()`` is called as a long trial begins."""
        self._panels, self._laws, self._began = panels, laws, began
        self._cancelled, self._closed = False, False
        laws.waiting, laws.waited = self._show_progress, self._after

    @property
    def is_under_way(self):
        """Return whether edits wait for a law."""
        return not self._panels.across.isEnabled()

    def close(self):
        """Cancel the current trial, and all that follow."""
        self._closed = True

    def _show_progress(self, seconds):
        if not self.is_under_way:
            self._panels.across.setEnabled(False)
            self._cancelled = False
            self._began()
        text = "Loading the protocol: {:.0f} of at most {:g} s".format(seconds, self._laws.limit)
        self._panels.banners.notify("law", "aside", text, ("Cancel", self._cancel))
        QApplication.processEvents(QEventLoop.AllEvents, LONGEST)
        if self._cancelled or self._closed:
            raise ValueError("cancelled after {:.0f} s".format(seconds))

    def _cancel(self):
        self._cancelled = True

    def _after(self):
        self._panels.banners.clear("law")
        self._panels.across.setEnabled(True)
