"""Which incoming poses are accepted: by their stamps, frames, rotations and places.

Stamps of simulated robots are compared with simulated time.  Those of real robots come from clocks
that are not synchronised: what counts is that they go on, and that the offset between arrival and
stamp stays what the first messages showed.
"""

import math

from mrs_simulator.core.fields import shown
from mrs_simulator.scenario.scenario import FARTHEST

LEARNING = 5  # [-] first messages of a real robot, which may show any offset of its clock
DRIFT = 1e-4  # [-] by which two clocks may run apart
FARTHEST_REAL = 1e4  # [m] from the origin of a real robot's odometry
UNIT = 1e-2  # [-] by which the length of a unit quaternion may be wrong
NOT_SET = 1e-6  # [s] a stamp below this was never set


class Intake:
    """Refuses, counts and names messages that do not show where a robot is now."""

    def __init__(self, real, timeout, wanted_frame=None, farthest=FARTHEST_REAL):
        """``real`` (n,) bool; ``timeout`` [s] after which a pose is too old.

        ``wanted_frame(row, frame)``: returns what frame was wanted instead, "" for a right one; None:
        any will do.  ``farthest`` [m]: of real robots' poses from the origin; of simulated ones it is
        ``scenario.FARTHEST``.
        """
        self._wanted_frame, self._frames = wanted_frame, [None] * len(real)
        self._real = [bool(each) for each in real]
        self._timeout, self._farthest = timeout, farthest
        self.refused = [0] * len(self._real)  # messages by row
        self.reasons = {}  # why a robot's newest message was refused, by row
        self.forget()

    def forget(self):
        """Learn the clocks anew: a person has said that the robots are right."""
        n = len(self._real)
        self._stamps, self._offsets = [-math.inf] * n, [0.0] * n
        self._seen, self._came = [0] * n, [0.0] * n

    def refuse(self, row, why):
        """Count a message of robot ``row`` as refused; return False."""
        self.refused[row] += 1
        self.reasons[row] = why
        return False

    def accepts_place(self, row, x, y, length=1.0, z=0.0):
        """Return whether a pose at ``(x, y, z)`` [m] can be; ``length`` of its quaternion [-]."""
        if not abs(length - 1.0) <= UNIT:
            return self.refuse(row, "its quaternion has length {:.3g}".format(length))
        bound = self._farthest if self._real[row] else FARTHEST
        if not (abs(x) < bound and abs(y) < bound):
            return self.refuse(row, "at ({:.4g}, {:.4g}) m".format(x, y))
        if not abs(z) < bound:
            return self.refuse(row, "at a height of {:.4g} m".format(z))
        return True

    def accepts_twist(self, row, twist):
        """Return whether the ``twist``, its components [m/s, rad/s], is a motion."""
        if all(map(math.isfinite, twist)):
            return True
        shown = ", ".join("{:.3g}".format(each) for each in twist)
        return self.refuse(row, "its twist is not finite: ({})".format(shown))

    def accepts_frame(self, row, frame):
        """Return whether ``frame`` is one in which robot ``row`` may publish its pose."""
        if self._wanted_frame is None or frame == self._frames[row]:
            return True
        wanted = self._wanted_frame(row, frame)
        if wanted:
            return self.refuse(row, "in frame {}, wanted {}".format(shown(frame), wanted))
        self._frames[row] = frame
        return True

    def accepts_stamp(self, row, stamp, simulated, arrival):
        """Return whether a message stamped ``stamp`` [s] is current.

        ``simulated`` [s]: simulated time, 0 while it is not known; ``arrival`` [s] of wall time.
        """
        if self._real[row]:
            accepted = self._accepts_real(row, stamp, arrival)
        else:
            accepted = self._accepts_simulated(row, stamp, simulated)
        if accepted:
            self._stamps[row], self._came[row] = stamp, arrival
            self.reasons.pop(row, None)
        return accepted

    def _accepts_simulated(self, row, stamp, now):
        if now <= 0.0:
            return True  # no clock to compare it with, and no robot is driven yet
        if abs(now - stamp) > self._timeout:
            side = "before" if stamp < now else "after"
            text = "stamped {:.4g} s {} the simulated time".format(abs(now - stamp), side)
            return self.refuse(row, text)
        # After a restart of the simulator the last stamp lies far ahead of its clock.
        if stamp < self._stamps[row] <= now + self._timeout:
            return self.refuse(row, "stamped before the one that came before it")
        return True

    def _accepts_real(self, row, stamp, arrival):
        if not stamp > NOT_SET:
            return self.refuse(row, "its stamp is not set")
        last, offset = self._stamps[row], arrival - stamp
        first = self._seen[row] == 0
        if not first and stamp <= last:
            how = "stands still" if stamp == last else "went back"
            return self.refuse(row, "its stamp {}".format(how))
        known = self._offsets[row] + DRIFT * (arrival - self._came[row])
        if self._seen[row] >= LEARNING and abs(offset - known) > self._timeout:
            how = "came {:.2f} s late" if offset > known else "its clock jumped {:.2f} s ahead"
            return self.refuse(row, how.format(abs(offset - known)))
        self._offsets[row] = offset if first else min(offset, known)
        self._seen[row] += 1
        if first:
            # One message alone may be of any age: the next shows whether time goes on there.
            self._stamps[row], self._came[row] = stamp, arrival
        return not first
