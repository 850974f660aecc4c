"""The preset ``wamv``: vessels by the thruster topics of VRX, robot N in ``/robotN``."""

import numpy as np
import rospy
from std_msgs.msg import Float32

from mrs_simulator.nodes.stage.driver_presets.preset_drivers import PresetDrivers, refuse_without
from mrs_simulator.vehicles.firmware.heron import drive

NAME, SIDES = "wamv", ("left", "right")
TIMEOUT = 1.0  # [s] of each thruster's command


def behind(scenario):
    """Return ``scenario``, whose vessels have VRX's topics; ``ValueError`` where there are none, or no
    forces."""
    refuse_without(scenario, NAME, "vessel", "wamv", ("dynamic",))
    return scenario


class Drivers(PresetDrivers):
    """The thrusters of each boat: ``thrusters/left_thrust_cmd`` and ``right_thrust_cmd``, -1..1.

    Each has a watchdog of its own.  The thrusters of these models do not swivel: angles are left out.
    """

    NAME, DRIVE = NAME, "vessel"

    def open_robot(self, row):
        """Return the subscribers of robot ``row``."""
        name = "/robot{}/thrusters/".format(row + 1)
        opened = []
        for side, which in enumerate(SIDES):
            to = lambda message, side=side: self._thrust(row, side, message.data)  # noqa: E731
            opened.append(self.subscribe(name + which + "_thrust_cmd", Float32, to))
            no = lambda message, which=which: self._angle(row, which, message.data)  # noqa: E731
            opened.append(self.subscribe(name + which + "_thrust_angle", Float32, no))
        return opened

    def _thrust(self, row, side, command):
        if self.fits(row, command):
            commands, when = self.goals.setdefault(row, (np.zeros(2), np.full(2, -np.inf)))
            commands[side], when[side] = command, self.world.time

    def _angle(self, row, which, angle):
        if angle:
            text = "stage: robot%d: %s_thrust_angle is left out: its thrusters do not swivel"
            rospy.logwarn_throttle(5.0, text % (row + 1, which))

    def go_on(self, row, goal):
        """Let the thrusters of boat ``row`` obey the last commands, ``goal``, while these are fresh."""
        commands, when = goal
        fresh = self.world.time - when <= TIMEOUT
        if fresh.any():
            efforts = drive(*np.where(fresh, commands, 0.0))
            self.world.commands.set_efforts([row], efforts[np.newaxis])
