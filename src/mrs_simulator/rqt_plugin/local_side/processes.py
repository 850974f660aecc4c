"""The programs of a GUI without ROS: one simulates, and runs the controller too."""

import sys

from mrs_simulator.rqt_plugin.run.processes import Processes

ENGINE = "mrs_simulator.rqt_plugin.local_side.engine"


class LocalProcesses(Processes):
    """``Processes`` whose ``stage`` is an ``engine``, which is asked for a ``control``."""

    def __init__(self, connection):
        """``connection``: the ``LocalConnection``."""
        super().__init__()
        self._connection, self._controlled = connection, False

    def start(self, name, script, *arguments, package="mrs_simulator"):
        """Start the simulation or the controller of the scenario that ``arguments`` name."""
        given = [str(each) for each in arguments]
        path = given[given.index("--scenario") + 1]
        if name == "control":
            self._connection.ask("control", path)
            self._controlled = True
            return
        speed = next(each[8:] for each in given if each.startswith("_speed:="))
        # Runs are recorded where files go once all programs have ended.
        arguments = [self._connection.address, path, speed, self.directory]
        self.launch(name, [sys.executable, "-m", ENGINE, *arguments])

    def command(self, script):
        return [sys.executable, "-m", "mrs_simulator", script]

    def is_running(self, name):
        if name == "control":
            self._controlled = self._controlled and super().is_running("stage")
            return self._controlled
        return super().is_running(name)

    def age(self, name):
        """Return the wall time [s] since the simulation began, for a controller too."""
        return super().age("stage" if name == "control" else name)

    def take_ended(self):
        ended = [
            ("control", 1 if said else 0, said) for said in self._connection.take("control_ended")
        ]
        self._controlled = self._controlled and not ended
        return [*super().take_ended(), *ended]

    def stop(self, name):
        """End the program called ``name``; a controller gives way, and its robots stand."""
        if name == "control":
            if self._controlled:
                self._connection.ask("end_control")
            self._controlled = False
            return
        super().stop(name)

    def kill(self, name):
        """Kill the program ``name`` at once; the simulation with a controller that hangs."""
        super().kill("stage" if name == "control" else name)
