"""Faults: scheduled by the scenario, injected by a service, or detected in the simulation."""

from mrs_simulator.scenario.incidents import LOST, Incident


class Faults:
    """Injects the faults that are due, and collects incidents."""

    def __init__(self, motion, clock, events):
        """``events``: ``scenario.incidents.Event``s in the order of their times."""
        self._motion, self._clock, self._events = motion, clock, events
        self._detected = getattr(motion, "detected_incidents", None)
        self.begin()

    def begin(self):
        """Reset: no fault has occurred."""
        self.due, self._injected, self._new = list(self._events), {}, []

    @property
    def can_leap(self):
        """Return whether there can be no incident: none is scheduled, and the motion detects none."""
        return not (self._events or self._detected)

    def inject_due(self):
        """Inject the faults that the scenario has scheduled for now."""
        now = self._clock.since(self._clock.begun)
        while self.due and self.due[0].at <= now + 1e-9:
            event = self.due.pop(0)
            self.inject(event.robot - 1, event.event, event.rotor or 0)

    def inject(self, row, fault, rotor=0):
        """Inject a ``fault`` into robot ``row``; ``rotor``: its number."""
        self._motion.inject(row, fault, rotor - 1)
        self._injected[row] = LOST if self.lost_rotor(row) else fault
        self.report(row, fault, rotor)

    def lost_rotor(self, row):
        """Return whether robot ``row`` has lost a rotor."""
        return self._injected.get(row) == LOST

    def look(self):
        """Report the incidents that the motion has detected in this step."""
        if self._detected is not None:
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

    def clear_reports(self):
        """Drop the incidents that were not taken yet."""
        self._new = []
