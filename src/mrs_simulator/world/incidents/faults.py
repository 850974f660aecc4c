"""Faults: scheduled by the scenario, injected by a service, or detected in the simulation."""

from mrs_simulator.scenario.incidents import LOST, PUSHED, Incident
from mrs_simulator.world.part import Part


class Faults(Part):
    """Injects the faults that are due, and collects incidents."""

    def __init__(self, motion, clock, events):
        """``events``: ``scenario.incidents.Event``s in the order of their times."""
        self._motion, self._clock, self._events = motion, clock, events
        self._detected = getattr(motion, "detected_incidents", None)
        self._due, self._injected, self._new = list(events), {}, []
        if not events:
            self.before_step = None
        if self._detected is None:
            self.after_step = None

    def reset(self):
        """Drop the incidents that were not taken yet."""
        self._new = []

    @property
    def can_fuse(self):
        """Return whether none is scheduled; fused steps end before one that the motion would detect."""
        return not self._events

    def before_step(self, command):
        """Inject the faults that the scenario has scheduled for now; return ``command``."""
        now = self._clock.since(self._clock.begun)
        while self._due and self._due[0].at <= now + 1e-9 and not self._clock.waits:
            event = self._due.pop(0)
            if event.by is None:
                self.inject(event.robot - 1, event.event, event.rotor or 0)
            else:
                self.push(event.robot - 1, event.by)
        return command

    def inject(self, row, fault, rotor=0):
        """Inject a ``fault`` into robot ``row``; ``rotor``: its number."""
        self._motion.inject(row, fault, rotor - 1)
        self._injected[row] = LOST if self.lost_rotor(row) else fault
        self.report(row, fault, rotor)

    def push(self, row, by):
        """Put robot ``row`` elsewhere, ``by`` (2,) [m] in the common frame; its wheels do not turn."""
        self._motion.displace(row, by)
        self._new.append(
            Incident(self._clock.time, "robot{}".format(row + 1), PUSHED, ordered=True)
        )

    def lost_rotor(self, row):
        """Return whether robot ``row`` has lost a rotor."""
        return self._injected.get(row) == LOST

    def after_step(self):
        """Report the incidents that the motion has detected in this step."""
        for row, what in self._detected():
            self.report(row, what)

    def report(self, row, what, part=0):
        """Add the incident ``what`` of robot ``row``; ``part``: the number of a rotor or joint."""
        name, ordered = "robot{}".format(row + 1), row in self._injected
        self._new.append(Incident(self._clock.time, name, what, part, ordered))

    def take(self):
        """Return the ``scenario.incidents.Incident``s since the last call."""
        taken, self._new = self._new, []
        return taken
