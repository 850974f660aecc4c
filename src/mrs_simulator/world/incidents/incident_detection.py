"""Detection of incidents in the motion: each is reported once, when it begins."""

import numpy as np

from mrs_simulator.scenario.incidents import NOT_FINITE, SATURATED, UPSIDE_DOWN

HELD = {SATURATED: 0.5, UPSIDE_DOWN: 0.0}  # [s] for which it holds before it is reported
LASTING = (UPSIDE_DOWN,)  # reported once, and not at each turn of a body that tumbles


class IncidentDetector:
    """Detects incidents of m robots by how long their conditions hold."""

    def __init__(self, m, step):
        """``step`` [s] between two updates."""
        self._step = step
        self._since = {what: np.zeros(m) for what in HELD}
        self._found = []

    def update(self, what, holds):
        """Record for which robots, (m,) bool, the condition ``what`` holds now."""
        since = self._since[what]
        if what in LASTING:
            holds = holds | (since > 0.0)
        if not holds.any() and not since.any():
            return
        held = np.where(holds, since + self._step, 0.0)
        begun = (held > HELD[what]) & ~(since > HELD[what])
        self._since[what] = held
        self._found += [(row, what) for row in np.flatnonzero(begun).tolist()]

    @property
    def is_idle(self):
        """Return whether no condition holds, or has held and is remembered."""
        return not any(since.any() for since in self._since.values())

    def add(self, rows, what):
        """Record the incident ``what`` of robots ``rows``."""
        self._found += [(row, what) for row in rows]

    def take(self):
        """Return ``(row, what)`` of all incidents detected since the last call."""
        if not self._found:
            return ()
        taken, self._found = self._found, []
        return taken


def not_finite(inner):
    """Return the robots, (m,) bool, whose ``inner`` state is not finite; None where all are."""
    total = 0.0
    for part in _arrays(inner):
        total += part.sum()
    if np.isfinite(total):
        return None
    bad = np.zeros(len(_arrays(inner)[0]), dtype=bool)
    for part in _arrays(inner):
        bad |= ~np.isfinite(part.reshape(len(part), -1)).all(axis=1)
    return bad if bad.any() else None


def mended(inner, before, bad, detector):
    """Return ``inner`` with the states ``before`` of robots ``bad``, (m,) bool; report to ``detector``."""
    detector.add(np.flatnonzero(bad).tolist(), NOT_FINITE)
    return _replaced(inner, before, bad)


def _arrays(inner):
    found = []
    for part in inner:
        if isinstance(part, tuple):
            found += _arrays(part)
        elif isinstance(part, np.ndarray) and part.dtype.kind == "f":
            found.append(part)
    return found


def _replaced(inner, before, bad):
    parts = []
    for new, old in zip(inner, before):
        if isinstance(new, tuple):
            new = _replaced(new, old, bad)
        elif isinstance(new, np.ndarray) and new.dtype.kind == "f":
            new = new.copy(order="K")
            new[bad] = old[bad]
        parts.append(new)
    return type(inner)(*parts)
