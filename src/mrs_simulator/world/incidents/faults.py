"""What befalls robots: by a scenario's orders, by somebody's hand, or by itself."""

from mrs_simulator.scenario.incidents import LOST, Incident


class Faults:
    """Strikes robots with what is due, and keeps what is to be told of it."""

    def __init__(self, motion, clock, events):
        """``events``: ``core.incidents.Event``s in the order of their times."""
        self._motion, self._clock, self._events = motion, clock, events
        self._noticed = getattr(motion, "mishaps", None)
        self.begin()

    def begin(self):
        """Let nothing have happened yet."""
        self.due, self._struck, self._new = list(self._events), {}, []

    @property
    def can_leap(self):
        """Return whether nothing can befall robots: neither ordered, nor noticed by the motion."""
        return not (self._events or self._noticed)

    def strike_due(self):
        """Let what the scenario has ordered for now befall robots."""
        now = self._clock.since(self._clock.begun)
        while self.due and self.due[0].at <= now + 1e-9:
            event = self.due.pop(0)
            self.strike(event.robot - 1, event.event, event.rotor or 0)

    def strike(self, row, fault, rotor=0):
        """Let a ``fault`` befall robot ``row``; ``rotor``: its number."""
        self._motion.strike(row, fault, rotor - 1)
        self._struck[row] = LOST if self.has_lost_rotor(row) else fault
        self.report(row, fault, rotor)

    def has_lost_rotor(self, row):
        """Return whether robot ``row`` has lost a rotor."""
        return self._struck.get(row) == LOST

    def look(self):
        """Report what the motion has noticed in this step."""
        if self._noticed is not None:
            for row, what in self._noticed():
                self.report(row, what)

    def report(self, row, what, part=0):
        """Keep that ``what`` has come over robot ``row``; ``part``: the number of a rotor or joint."""
        name, ordered = "robot{}".format(row + 1), row in self._struck
        self._new.append(Incident(self._clock.time, name, what, part, ordered))

    def take(self):
        """Return the ``core.incidents.Incident``s since the last call."""
        taken, self._new = self._new, []
        return taken

    def discard(self):
        """Keep nothing of what was to be told."""
        self._new = []
