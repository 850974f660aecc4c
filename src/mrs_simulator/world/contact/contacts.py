"""Which robots touch, when a touch is a new collision, and how close robots have come."""

import numpy as np

from mrs_simulator.core.compiling import same_bits
from mrs_simulator.record.recording import Collision
from mrs_simulator.scenario.scenario import MOST_ROBOTS
from mrs_simulator.world.contact.compiled_contacts import UNSORTED, compiled_note
from mrs_simulator.world.contact.contact_arrays import Touches, collisions_of
from mrs_simulator.world.part import Part

FORGET = 0.1  # [s] without contact after which touching again is a new collision
NO_PAIR = np.iinfo(int).max
FEW = 100  # [-] past contacts that may be kept in memory whatever their age


class Contacts(Part):
    """Collisions of a team, as a ``motion`` meets them."""

    can_fuse = True  # fused steps end before any bodies may touch

    def __init__(self, motion, clock):
        self._motion, self._clock = motion, clock
        self.reset()

    def reset(self):
        """Forget all contacts, and the distances so far."""
        self._last = {}  # the step of the last contact of each pair of names
        # The same of pairs of rows, in order; the last one, which is none, is never over.
        self._pairs, self._steps = np.array([NO_PAIR]), np.array([0])
        self._new = []
        self.closest = self._motion.closest()  # [m] between two centres so far

    def after_step(self):
        """Note the contacts of this step."""
        contacts = self._motion.contacts()
        if contacts:
            self.note(contacts)

    def note(self, contacts):
        """Note ``contacts`` of this step, ``(first, second, x, y)`` each, or ``Touches``."""
        if isinstance(contacts, Touches):
            self._note_pairs(contacts)
            contacts = [contact[:4] for contact in contacts.others]
        now = self._clock.steps
        for first, second, *place in contacts:
            last = self._last.get((first, second))
            if last is None or self._is_over(last):
                self._new.append(Collision(self._clock.time, first, second, *place))
            self._last[first, second] = now
        if len(self._last) > 2 * len(contacts) + FEW:
            self._last = {
                pair: last for pair, last in self._last.items() if not self._is_over(last)
            }
        self.measure()  # robots in contact are as close as robots come

    def _note_pairs(self, touches):
        """Note the pairs of robots of ``touches``, by their rows."""
        note = same_bits(compiled_note)
        if note is not None and self._note_by_loop(note, touches):
            return
        pairs = touches.first * MOST_ROBOTS + touches.second
        at = self._pairs.searchsorted(pairs)
        known = self._pairs[at] == pairs
        fresh = ~known | self._is_over(self._steps[at])
        self._begin(touches, fresh)
        self._steps[at[known]] = self._clock.steps
        if not known.all():
            kept = ~self._is_over(self._steps)
            kept[-1] = True
            merged = np.concatenate([pairs[~known], self._pairs[kept]])
            steps = np.concatenate([np.full((~known).sum(), self._clock.steps), self._steps[kept]])
            order = np.argsort(merged)
            self._pairs, self._steps = merged[order], steps[order]

    def _note_by_loop(self, note, touches):
        """As ``_note_pairs``, compiled; return whether that can be."""
        k, clock = len(touches.first), self._clock
        fresh = np.empty(k, dtype=bool)
        pairs, steps = np.empty((2, len(self._pairs) + k), dtype=np.int64)
        given = self._pairs, self._steps, clock.steps, clock.step_size, FORGET
        count = note((touches.first, touches.second), MOST_ROBOTS, *given, fresh, pairs, steps)
        if count == UNSORTED:
            return False
        self._pairs, self._steps = pairs[:count], steps[:count]
        self._begin(touches, fresh)
        return True

    def _begin(self, touches, fresh):
        """Note that the pairs of ``touches`` that are ``fresh``, (k,) bool, begin to touch now."""
        begun = np.flatnonzero(fresh)
        if len(begun):
            self._new.append(touches.starts(begun, self._clock.time))

    def measure(self):
        """Return the least distance [m] between two centres so far, now included."""
        self.closest = min(self.closest, self._motion.closest())
        return self.closest

    @property
    def pairs(self):
        """Return the pairs that have touched of late, ``first * MOST_ROBOTS + second`` (m,), ascending, and
        the steps of their last contacts (m,); the last one is none."""
        return self._pairs, self._steps

    def go_on_from(self, pairs, steps, closest, new):
        """Go on from ``pairs`` and ``steps`` as :attr:`pairs` has them, the distance ``closest`` [m] so far
        and the ``new`` collisions, ``PairsBegun``."""
        self._pairs, self._steps, self.closest = pairs, steps, closest
        self._new.append(new)

    def take(self):
        """Return the collisions begun since the last call."""
        return collisions_of(self.take_begun())

    def take_begun(self):
        """Return what :meth:`take` does, with pairs of robots as ``PairsBegun``."""
        taken, self._new = self._new, []
        return taken

    def _is_over(self, last):
        return self._clock.since(last) > FORGET
