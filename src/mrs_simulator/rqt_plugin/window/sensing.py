"""Subscribes to the sensors that the map or their panel shows, and shows their readings."""

from mrs_simulator.rqt_plugin.map.sensor_drawing import DRAWN, MOST_ROBOTS
from mrs_simulator.rqt_plugin.run.error_message import reason
from mrs_simulator.rqt_plugin.run.programs_panel import part_text, short
from mrs_simulator.rqt_plugin.sensing.readings import mounts_of, spare_mounts_of
from mrs_simulator.rqt_plugin.sensing.robot_status import StatusRow, parts_of, status_rows

DEPTH = " depth"  # after the name of a camera; no mount has a space in its name


class Sensing:
    """Selects the sensors to subscribe to, and shows what is received."""

    def __init__(self, panels, study, history):
        """``history``: the ``History`` of the run, whose incidents the panel shows."""
        self._panels, self._study, self._history = panels, study, history
        self._scenario, self._mounts, self._trouble = None, {}, ""
        self._spare = {}  # by number of a robot

    def show(self):
        """Subscribe to the sensors shown now, and show their newest readings."""
        self._update_mounts()
        panels, connection = self._panels, self._study.connection
        panels.sensors.set_robots(range(1, self._study.scenario.n + 1))
        if panels.sensors.isVisible():
            self._show_state()
        on_map, in_panel = self._shown_of(DRAWN), self._in_panel()
        depth = self._depth(in_panel)
        connection.watch_sensors({**on_map, **in_panel, **depth})
        # whose fields of view are drawn without a subscription
        cameras = self._shown_of(("camera",))
        mounts = {key: of[0] for key, of in {**on_map, **cameras}.items()}
        if not on_map and not in_panel and not panels.sensors.isVisible():
            panels.map.show_readings({}, mounts)
            return
        received = connection.sensor_readings()
        panels.map.show_readings(
            {
                key: received[key]
                for key in on_map
                if key in received and not self._is_old(key, received)
            },
            mounts,
        )
        if panels.opened.run is not None:
            status = self._status(panels.sensors.number)
            panels.sensors.show_sensors({}, {}, status=status, recorded=True)
        elif panels.sensors.isVisible():
            readings = {
                key[1]: received.get(key) for key in in_panel if self._is_shown(key, received)
            }
            mounts = {key[1]: of[0] for key, of in in_panel.items() if key[1] in readings}
            of_depth = next((received[key] for key in depth if key in received), None)
            status = self._status(panels.sensors.number)
            panels.sensors.show_sensors(mounts, readings, self._trouble, of_depth, status)

    def _status(self, number):
        """Return the ``StatusRow``s of the robot ``number``."""
        if not number:
            return []
        connection = self._study.connection
        if self._panels.opened.run is not None:  # of which no program of now knows
            return status_rows(number, self._panels.map.team.state, None, None)
        stage, control = (
            connection.newest(name) if connection.is_fresh(name) else None
            for name in ("stage", "control")
        )
        shown = self._panels.map
        state = shown.team.state if shown.is_past else connection.snapshot()
        rows = status_rows(number, state, stage, control)
        own = parts_of(number, connection.diagnostics())
        return rows + [
            StatusRow(short(part.name), part.message, part.level, part.age, part_text(part))
            for part in own
        ]

    def _show_state(self):
        """Show the flight state and the incidents of the robot in the panel."""
        number, stage = self._panels.sensors.number, self._study.connection.newest("stage")
        fresh = stage is not None and self._study.connection.is_fresh("stage")
        states = stage.flight if fresh else ()
        flight = states[number - 1] if 0 < number <= len(states) else ""
        name = "robot{}".format(number)
        incidents = [each for each in self._history.incidents if each.robot == name]
        self._panels.sensors.show_state(flight, incidents)

    def _is_old(self, key, received):
        return received[key].reading is None or received[key].is_stale(self._mounts[key][0])

    def _update_mounts(self):
        """Read the robots' sensors from a new scenario."""
        scenario = self._study.scenario
        if scenario is self._scenario:
            return
        self._scenario, self._trouble, self._spare = scenario, "", {}
        try:
            self._mounts = mounts_of(scenario)
        except ValueError as error:
            self._mounts, self._trouble = {}, reason(error)

    def _shown_of(self, types):
        panels = self._panels
        if not panels.shown["sensors"].isChecked() or not panels.map.isVisible():
            return {}
        few = self._study.scenario.n <= MOST_ROBOTS
        return {
            key: of
            for key, of in self._mounts.items()
            if of[0].type in types and (few or key[0] == panels.sensors.number)
        }

    def _depth(self, in_panel):
        """Return the depth image of the camera in the panel, {} unless it is shown."""
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
        """Return the sensors that the robot ``number`` may have besides: shown if they are published."""
        if number not in self._spare:
            known = 0 < number <= self._scenario.n and not self._trouble
            self._spare[number] = spare_mounts_of(self._scenario, number) if known else {}
        return self._spare[number]

    def _is_shown(self, key, received):
        return key in self._mounts or (key in received and bool(received[key].topic))
