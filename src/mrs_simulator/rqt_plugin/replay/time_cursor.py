"""The moment of a run that all views show: its newest sample, or one that has passed."""

import numpy as np

from mrs_simulator.rqt_plugin.qt.QtCore import QObject, Signal

SPEEDS = (0.5, 1.0, 2.0, 5.0, 10.0, 50.0)  # [-] recorded over wall time


class TimeCursor(QObject):
    """A moment of the run in a ``History``; ``time`` [s] is None while the newest sample is shown."""

    changed = Signal()

    def __init__(self, history, parent=None):
        super().__init__(parent)
        self._history, self._run = history, history.cleared
        self.time, self.playing, self.speed = None, False, 1.0

    def take_history(self, history):
        """Choose moments of the run in another ``history``, its newest or last one first."""
        self._history, self._run = history, history.cleared
        self.playing = False
        self.time = None
        self.changed.emit()

    @property
    def span(self):
        """Return the times [s] at which the run begins and of its newest sample, None before two."""
        time = self._history.time[self._history.first_row() :]
        return (float(time[0]), float(time[-1])) if len(time) > 1 else None

    @property
    def row(self):
        """Return the row of the sample that is shown, the last one where nothing else was chosen."""
        time = self._history.time
        if self.time is None:
            return len(time) - 1
        return max(0, int(np.searchsorted(time, self.time, side="right")) - 1)

    @property
    def is_past(self):
        """Return whether another sample than the newest is shown."""
        return self.time is not None

    def go(self, time):
        """Show the sample of ``time`` [s], or the nearest there is."""
        span = self.span
        if span is not None:
            self._set(min(max(float(time), span[0]), span[1]))

    def step(self, samples):
        """Show the sample so many ``samples`` later, or earlier."""
        if self.span is not None:
            first, last = self._history.first_row(), len(self._history.time) - 1
            row = min(max(first, self.row + samples), last)
            self.play(False)
            self._set(float(self._history.time[row]))

    def follow(self):
        """Show the newest sample from now on."""
        self.playing = False
        self._set(None)

    def play(self, on):
        """Let recorded time pass, from the beginning where the end is shown; or no longer."""
        span = self.span
        self.playing = bool(on) and span is not None
        if self.playing and (self.time is None or self.time >= span[1]):
            self.time = span[0]
        self.changed.emit()

    def pass_time(self, seconds):
        """Let ``seconds`` of wall time pass; a run that was cleared is followed again."""
        if self._history.cleared != self._run:
            self._run = self._history.cleared
            if self.is_past:
                self.follow()
        elif self.playing:
            time = self.time + self.speed * seconds
            self.playing = time < self.span[1]
            self._set(min(time, self.span[1]))

    def _set(self, time):
        if time != self.time:
            self.time = time
            self.changed.emit()
