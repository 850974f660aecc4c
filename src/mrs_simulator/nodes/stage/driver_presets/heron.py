"""The preset ``heron``: vessels as heron_controller and the boat's own board obey, robot N in
``/robotN``."""

import numpy as np
from geometry_msgs.msg import Wrench

from mrs_simulator.nodes.stage.driver_presets.preset_drivers import PresetDrivers, refuse_without
from mrs_simulator.ros.message_forms.optional_messages import Offer
from mrs_simulator.vehicles.firmware import heron as firmware

NAME = "heron"


def behind(scenario):
    """Return ``scenario``, whose vessels obey as Herons; ``ValueError`` where there are none, or no
    forces."""
    refuse_without(scenario, NAME, "vessel", "heron", ("dynamic",))
    return scenario


class Drivers(PresetDrivers):
    """The controller of each boat; ``cmd_vel`` is speed and turn rate, as without a preset.

    The newest command counts, by whatever topic it came.
    """

    NAME, DRIVE = NAME, "vessel"
    OFFERS = (
        Offer("heron_msgs", "msg", ("Drive", "Helm", "Course"), ("cmd_drive", "cmd_helm", "cmd_course")),
    )  # fmt: skip

    def open_robot(self, row):
        name = "/robot{}/".format(row + 1)
        opened = [self.subscribe(name + "cmd_wrench", Wrench, lambda m: self._wrench(row, m))]
        if "Drive" in self.types:
            for topic, kind, receive in (
                ("cmd_drive", "Drive", self._drive),
                ("cmd_helm", "Helm", self._helm),
                ("cmd_course", "Course", self._course),
            ):
                to = lambda message, receive=receive: receive(row, message)  # noqa: E731
                opened.append(self.subscribe(name + topic, self.types[kind], to))
        return opened

    def _efforts(self, row, efforts, rate=0.0):
        self.goals.pop(row, None)
        self.give(row, [0.0, rate])
        self.world.commands.set_efforts([row], efforts[np.newaxis])

    def _drive(self, row, message):
        if self.fits(row, message.left, message.right):
            self._efforts(row, firmware.drive(message.left, message.right))

    def _helm(self, row, message):
        if self.fits(row, message.thrust, message.yaw_rate):
            efforts = firmware.helm(message.thrust, self.world.team.kinds[row].numbers)
            self._efforts(row, efforts, message.yaw_rate)

    def _wrench(self, row, message):
        if self.fits(row, message.force.x, message.torque.z):
            self._efforts(row, firmware.wrench(message.force.x, message.torque.z))

    def _course(self, row, message):
        if self.fits(row, message.yaw, message.speed):
            self.goals[row] = message.yaw, message.speed, self.world.time

    def go_on(self, row, goal):
        """Let boat ``row`` turn to the course that it was commanded, its ``goal``, while that is fresh."""
        (yaw, speed, since), world = goal, self.world
        if world.time - since <= world.commands.timeouts[row]:
            self.give(row, firmware.course(yaw, speed, float(world.pose[row, 2])))
