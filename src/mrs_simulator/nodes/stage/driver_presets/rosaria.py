"""The preset ``rosaria``: simulated robots behave like those behind the RosAria driver."""

import math

import numpy as np
import rospy
from std_msgs.msg import Bool, Int8
from std_srvs.srv import Empty, EmptyResponse

from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.vehicles import Team

ODOM_RATE = 10.0  # [Hz] at the usual packets of 100 ms
CMD_VEL_TIMEOUT = 0.6  # [s]
WATCH_PERIOD = 0.1  # [s] between two looks of the driver's watchdog
NOT_CHARGING = 0  # of ``battery_recharge_state``
# What the driver publishes of sensors that kinds declare, by type: all with its poses, voltages in steps of
# 0.1 V, echoes in whole mm; the transducers of an array of eight take turns.
PUBLISHED = {
    "battery": {"rate": ODOM_RATE, "noise": {"quantum": 0.1}},
    "bumper": {},
    "sonar": {"turns": 8, "cycle": 0.04, "noise": {"quantum": 0.001}},
}
UNIT = np.array([0.001, math.radians(1.0)])  # [m/s, rad/s] the finest command of the protocol


def behind_rosaria(scenario):
    """Return ``scenario`` with odometry, limits, watchdog and sensors of robots behind RosAria."""
    if scenario.fidelity == "point_mass":
        raise ValueError("preset rosaria: fidelity point_mass, wanted kinematic or dynamic")
    reported = {kind.name: _reported(kind) for kind in Team.from_scenario(scenario).kinds}
    sensors = [{"kind": name, "mounts": mounts} for name, mounts in reported.items() if mounts]
    added, own = (
        [change.to_plain() for change in each.sensors]
        for each in (scenario.changed(sensors=sensors), scenario)
    )
    is_behind = own[: len(added)] == added  # as a run's own scenario, recorded behind the driver
    return scenario.changed(
        odometry="wheel",
        limits="firmware",
        cmd_vel_timeout=CMD_VEL_TIMEOUT,
        sensors=own if is_behind else added + own,
    )


def _reported(kind):
    """Return what the driver publishes of the sensors that ``kind`` declares, mounts by name."""
    return {
        name: dict(PUBLISHED[mount["type"]])
        for name, mount in kind.mounts.items()
        if mount is not None and mount.get("type") in PUBLISHED
    }


def driver_commands(commands, top):
    """Return ``commands`` (n, 2) [m/s, rad/s] as the driver hands them to robots of speeds up to ``top``.

    In whole mm/s and deg/s, halves away from zero; nan is zero, and infinite the robot's maximum.
    """
    commands = np.clip(np.where(np.isnan(commands), 0.0, commands), -top, top)
    return np.sign(commands) * np.floor(np.abs(commands) / UNIT + 0.5) * UNIT


class Drivers(StagePart):
    """The drivers of all simulated robots: what they make of commands, and their motors."""

    def __init__(self, world, requests, absent=()):
        """``requests`` runs what services ask for; ``absent``: rows of robots without a driver here."""
        self._world, self._requests, self._absent = world, requests, set(absent)
        self._motors = {}

    def follow_team(self, scenario):
        """Open or withdraw topics and services, so that every simulated robot has its own."""
        n = self._world.n
        for row in [row for row in self._motors if row >= n]:
            self._motors.pop(row).close()
        for row in range(n):
            if row not in self._motors and row not in self._absent:
                self._motors[row] = Motors(row, self._switch, self._requests)

    def command(self, rows, commands):
        """Give the world's robots ``rows`` (m,) the commands (m, 2) [m/s, rad/s]."""
        rows = np.asarray(rows, dtype=int)
        self._world.commands.refused[rows[~np.isfinite(commands).all(axis=1)]] += 1
        commands = driver_commands(commands, self._world.team.limits.of(rows).top)
        commands[[row in self._motors and not self._motors[row].enabled for row in rows]] = 0.0
        self._world.set_commands(rows, commands)

    def _switch(self, row, on):
        if not on:
            self._world.commands.stop([row])
        if row in self._motors:
            self._motors[row].show(on)


class Motors:
    """``/robotN/motors_state``, the services that switch them, and ``/robotN/battery_recharge_state``."""

    def __init__(self, row, switch, requests):
        """``switch(row, on)`` is called in the main loop, by ``requests``, when a service asks."""
        name = "/robot{}/".format(row + 1)
        self._state = rospy.Publisher(name + "motors_state", Bool, queue_size=1, latch=True)
        self.enabled = None
        self.show(True)
        self._recharge = rospy.Publisher(
            name + "battery_recharge_state", Int8, queue_size=1, latch=True
        )
        self._recharge.publish(NOT_CHARGING)

        def service(verb, on):
            def answer(_):
                done, said = requests.ask(lambda: switch(row, on))
                if not done:
                    raise rospy.ServiceException(said)
                return EmptyResponse()

            return rospy.Service(name + verb, Empty, answer)

        self._services = [service("enable_motors", True), service("disable_motors", False)]

    def show(self, on):
        """Keep whether the motors are on, and publish it if that is new."""
        if on != self.enabled:
            self.enabled = on
            self._state.publish(Bool(data=on))

    def close(self):
        """Withdraw the topic and the services."""
        self._state.unregister()
        self._recharge.unregister()
        for service in self._services:
            service.shutdown("the robot was taken away")
