"""Pushes and holds robots of a simulated run with the mouse."""

from mrs_simulator.rqt_plugin.widgets.guard import guarded

MODE = "push"  # of the map
TOGETHER = 1.0  # [s] between two pushes of one robot that are reported once


@guarded
class Disturbance:
    """Has the simulation hold the robot that is dragged, until it is let go or the mode ends."""

    def __init__(self, panels, study):
        self._connection, self._held = study.connection, set()
        panels.map.robot_held.connect(self._on_held)
        panels.modes[MODE].toggled.connect(self._on_mode)

    def _on_held(self, number, place):
        (self._held.discard if place is None else self._held.add)(number)
        self._connection.hold(number, place)

    def _on_mode(self, _on):
        for number in sorted(self._held):
            self._connection.hold(number, None)
        self._held.clear()


class IncidentTexts:
    """Says what befell robots; pushes of one that follow each other are one."""

    def __init__(self):
        self._last = {}  # [s] of the newest incident, by what happened to whom

    def text(self, incident):
        """Return the ``incident`` in words, "" where it goes on from the one before."""
        key = incident.robot, incident.what, incident.rotor
        before, self._last[key] = self._last.get(key), incident.time
        if before is not None and 0.0 <= incident.time - before < TOGETHER:
            return ""
        return "{} at {:.2f} s".format(incident.text, incident.time)
