"""Sensors of the robots: those that are looked at are listened to, on the map and in their panel."""

from mrs_simulator.rqt_plugin.map.sensor_drawing import DRAWN, MOST_ROBOTS
from mrs_simulator.rqt_plugin.run.programs_panel import all_of, short
from mrs_simulator.rqt_plugin.run.trouble import reason
from mrs_simulator.rqt_plugin.sensing.own_parts import Told, parts_of, told_of
from mrs_simulator.rqt_plugin.sensing.received import mounts_of, spares_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded

DEPTH = " depth"  # after the name of a camera; no mount has a space in its name


class Sensing:
    """Tells the connection what is looked at, and shows what it hears."""

    def __init__(self, panels, study, history):
        """``history``: the ``History`` of the run, of whose incidents the panel tells."""
        self._panels, self._study, self._history = panels, study, history
        self._scenario, self._mounts, self._trouble = None, {}, ""
        self._spare = {}  # by number of a robot
        panels.map.robot_clicked.connect(self._on_robot)
        panels.sensors.robot_chosen.connect(self._on_robot)

    @guarded
    def _on_robot(self, number):
        """Show the sensors of the robot ``number``, chosen on the map or in the panel."""
        self._panels.sensors.show_robot(number)
        self._panels.map_panel.choose(number)

    def show(self):
        """Listen to what is looked at now, and show what was heard."""
        self._know_mounts()
        panels, connection = self._panels, self._study.connection
        panels.sensors.set_robots(range(1, self._study.scenario.n + 1))
        if panels.sensors.isVisible():
            self._show_state()
        on_map, in_panel = self._on_map(), self._in_panel()
        depth = self._depth(in_panel)
        connection.watch_sensors({**on_map, **in_panel, **depth})
        if not on_map and not in_panel and not panels.sensors.isVisible():
            panels.map.show_readings({})
            return
        heard = connection.heard_sensors()
        panels.map.show_readings(
            {key: heard[key] for key in on_map if key in heard and not self._is_old(key, heard)}
        )
        if panels.sensors.isVisible():
            readings = {key[1]: heard.get(key) for key in in_panel if self._is_shown(key, heard)}
            mounts = {key[1]: of[0] for key, of in in_panel.items() if key[1] in readings}
            of_depth = next((heard[key] for key in depth if key in heard), None)
            told = self._told(panels.sensors.number)
            panels.sensors.show_sensors(mounts, readings, self._trouble, of_depth, told)

    def _told(self, number):
        """Return the ``Told`` of the robot ``number``: motion, controller, and its own diagnostics."""
        if not number:
            return []
        connection = self._study.connection
        stage, control = (
            connection.newest(name) if connection.is_fresh(name) else None
            for name in ("stage", "control")
        )
        told = told_of(number, connection.snapshot(), stage, control)
        own = parts_of(number, connection.diagnostics())
        return told + [
            Told(short(part.name), part.message, part.level, part.age, all_of(part)) for part in own
        ]

    def _show_state(self):
        """Show what the robot in the panel does if it flies, and what has befallen it."""
        number, stage = self._panels.sensors.number, self._study.connection.newest("stage")
        fresh = stage is not None and self._study.connection.is_fresh("stage")
        told = stage.flight if fresh else ()
        flight = told[number - 1] if 0 < number <= len(told) else ""
        name = "robot{}".format(number)
        befell = [each for each in self._history.incidents if each.robot == name]
        self._panels.sensors.show_state(flight, befell)

    def _is_old(self, key, heard):
        return heard[key].reading is None or heard[key].is_stale(self._mounts[key][0])

    def _know_mounts(self):
        """Take in which sensors the robots of the scenario have."""
        scenario = self._study.scenario
        if scenario is self._scenario:
            return
        self._scenario, self._trouble, self._spare = scenario, "", {}
        try:
            self._mounts = mounts_of(scenario)
        except ValueError as error:
            self._mounts, self._trouble = {}, reason(error)

    def _on_map(self):
        """Return the sensors that the map shows."""
        panels = self._panels
        if not panels.shown["sensors"].isChecked() or not panels.map.isVisible():
            return {}
        few = self._study.scenario.n <= MOST_ROBOTS
        return {
            key: of
            for key, of in self._mounts.items()
            if of[0].type in DRAWN and (few or key[0] == panels.sensors.number)
        }

    def _depth(self, in_panel):
        """Return the depth of the camera that the panel shows, if it is that which is wanted."""
        found = [
            (key, (mount, kind))
            for key, (mount, kind) in in_panel.items()
            if mount.type == "camera" and mount.settings.has_depth
        ]
        if not found or not self._panels.sensors.wants_depth:
            return {}
        (number, name), of = found[0]
        return {(number, name + DEPTH): (*of, 1)}

    def _in_panel(self):
        """Return the sensors that the panel shows."""
        panel = self._panels.sensors
        if not panel.isVisible():
            return {}
        fitted = {key: of for key, of in self._mounts.items() if key[0] == panel.number}
        return {**self._spares(panel.number), **fitted}

    def _spares(self, number):
        """Return the sensors that the robot ``number`` may have besides: shown where they are told."""
        if number not in self._spare:
            known = 0 < number <= self._scenario.n and not self._trouble
            self._spare[number] = spares_of(self._scenario, number) if known else {}
        return self._spare[number]

    def _is_shown(self, key, heard):
        return key in self._mounts or (key in heard and bool(heard[key].topic))
