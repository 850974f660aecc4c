"""Summary of a controller's messages during a run: failures of its law, gaps in its commands, deadlocks."""

import re

from mrs_simulator.core.doc_links import named
from mrs_simulator.core.fields import counted

GRACE = 0.5  # [s] after its first command for which a controller may still report the state before
MOST_NAMED = 3  # [-] reasons in one line
LAW_FAILED = "the law failed"  # how a controller's report of that begins
EMERGENCY = "emergency stop"  # and what it reports while that is pressed
DEADLOCK = "deadlock: the safety filter holds still "
HELD = "robot {} since {:.1f} s"


def failure(error):
    """Return the text by which a controller reports that its law raised ``error``."""
    return "{}: {}".format(LAW_FAILED, named(error))


class Interruptions:
    """The times at which a controller was stopped or in trouble, from what it reports."""

    def __init__(self):
        self._reported = []  # [(stamp [s], trouble, "" while it gives commands)]

    def note(self, stamp, running, trouble):
        """Note the controller's report at ``stamp`` [s]; a time that went back starts over."""
        report = stamp, trouble or ("" if running else "stopped")
        if self._reported and stamp < self._reported[-1][0]:
            self._reported = []
        kinds = [_kind(text) for _, text in [*self._reported[-1:], report]]
        if len(kinds) == 1 or kinds[0] != kinds[1]:
            self._reported.append(report)

    def failed(self):
        """Return ``(stamp, text)`` of a failed law, None if the newest report is another."""
        newest = self._reported[-1] if self._reported else (0.0, "")
        return newest if newest[1].startswith(LAW_FAILED) else None

    def ended(self, begin):
        """Return when and how the law of a run that began at ``begin`` [s] failed, or ""."""
        failed = self.failed()
        after = max(0.0, failed[0] - begin) if failed else 0.0
        return "at {:.3f} s {}".format(after, failed[1]) if failed else ""

    def emergency(self, begin, end):
        """Return when an emergency stop ended a run from ``begin`` to ``end`` [s], or "".

        From then on to its end its robots stood: that the stop was released let none go on.
        """
        pressed = None
        for stamp, trouble in self._reported:
            if stamp >= end:
                break
            if not trouble:
                pressed = None
            elif trouble == EMERGENCY and pressed is None:
                pressed = max(0.0, stamp - begin)
        return "" if pressed is None else "at {:.3f} s {}".format(pressed, EMERGENCY)

    def warnings(self, begin, end):
        """Return warnings about a run from ``begin`` to ``end`` [s], a list of texts."""
        times, total, reasons = 0, 0.0, []
        for since, until, reason in self._stretches(end):
            if until > begin + (GRACE if since < begin else 0.0) and since < end:
                times += 1
                total += min(until, end) - max(since, begin)
                reasons += [reason] if reason not in reasons else []
        if not times:
            return []
        more = ", ..." if len(reasons) > MOST_NAMED else ""
        return [
            "the controller was stopped or in trouble {}, {:.1f} s in all: {}{}".format(
                counted(times, "time"), total, "; ".join(reasons[:MOST_NAMED]), more
            )
        ]

    def _stretches(self, end):
        """Yield ``(since, until, reason)`` of each trouble up to ``end``, an emergency, or the first."""
        since, reason = None, ""
        for stamp, trouble in self._reported + [(end, "")]:
            if trouble and since is None:
                since, reason = stamp, trouble
            elif trouble == EMERGENCY:
                reason = trouble
            elif not trouble and since is not None:
                yield since, stamp, reason
                since = None


def _kind(trouble):
    return bool(trouble), trouble.startswith(LAW_FAILED), trouble == EMERGENCY


def deadlock_text(deadlock):
    """Return ``deadlock``, ``(number, since [s])`` of robots, as a text; "" without one."""
    return DEADLOCK + ", ".join(HELD.format(*each) for each in deadlock) if deadlock else ""


def deadlock_in(text):
    """Return the deadlock that :func:`deadlock_text` put into ``text``, () for another text."""
    if not text.startswith(DEADLOCK):
        return ()
    found = re.findall(r"robot (\d+) since ([0-9.]+) s", text)
    return tuple((int(number), float(since)) for number, since in found)
