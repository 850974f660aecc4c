"""Simulated Pioneers that speak the robots' own protocol over TCP, for a driver to connect to.

``python3 pioneer_robots.py SCENARIO PORT``: robot n of the scenario's team listens on 127.0.0.1, port
PORT + n - 1.  Robots, obstacles and sonars are those of the simulator, with the firmware's limits, in wall
time; what is told is what the protocol can tell: whole mm, 4096 units in a turn, 0.1 V.  As on the robots
the transducers of each array of eight fire in turns, one every 40 ms, and only while the driver wants
them; the motors are off until the driver switches them on, and the firmware stops a robot 2 s after the
driver's last packet.  Mounts called ``bumper`` and ``battery`` are told where the scenario has them.

When standard input ends, where they truly were is printed, a line for each packet: wall time, and x, y,
theta of each robot.
"""

import contextlib
import functools
import math
import socket
import sys
import threading
import time

import numpy as np
import yaml
from pioneer_protocol import (
    CLOSE,
    CONFIG,
    ENABLE,
    ESTOP,
    OPEN,
    RVEL,
    SETRV,
    SETV,
    SONAR,
    STOP,
    SYNC2,
    VEL,
    Information,
    command,
    config_reply,
    information,
    packet,
    sync_reply,
    taken,
)

from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.world.world import World

KIND, MODEL = "Pioneer", "p3dx-sh"
FIRMWARE = 750, 100, 300, 100  # [mm/s, deg/s, mm/s^2, deg/s^2] as it leaves the factory
TOP = 1500, 360, 2000, 300
PACKET, FIRED = 0.1, 0.04  # [s] between two packets, and two shots of an array
ARRAY = 8  # [-] transducers
WATCHDOG = 2.0  # [s]
UNHEARD = 5000  # [mm] told where nothing was heard
VOLTAGE, LATEST = 12.6, 0.1  # [V] without a battery, [s] that one turn of the loop may stand for


class Robot:
    """What one robot was told, and its connection."""

    def __init__(self, row, port, arrays):
        self.row, self.arrays = row, arrays
        self.motors = self.listens = self.is_open = False
        self.wanted, self.most = [0.0, 0.0], [float(FIRMWARE[0]), float(FIRMWARE[1])]
        self.spoken, self.fired, self.commands = -math.inf, {}, []
        self.silent = False  # loses the link
        self._socket, self._syncing = None, True
        server = socket.socket()
        server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        server.bind(("127.0.0.1", port))
        server.listen(1)
        threading.Thread(target=self._serve, args=(server,), daemon=True).start()

    def _serve(self, server):
        while True:
            self._socket, _ = server.accept()
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._syncing, self.is_open = True, False
            with contextlib.suppress(OSError):
                self._listen(bytearray())
            self.is_open = False

    def _listen(self, buffer):
        for heard in iter(lambda: self._socket.recv(4096), b""):
            buffer += heard
            for data in iter(functools.partial(taken, buffer), None):
                self._obey(command(data), data)

    def _obey(self, told, data):
        number, value = told
        self.spoken = time.monotonic()
        if self._syncing and number <= SYNC2 and len(data) == 1:
            self.send(
                sync_reply("robot{}".format(self.row + 1), KIND, MODEL)
                if number == SYNC2
                else packet(data)
            )
            self._syncing = number != SYNC2
            return
        self.commands.append(told)
        if number == OPEN:
            self.is_open = True
        elif number == CLOSE:
            self.is_open, self._syncing = False, True
        elif number == ENABLE:
            self.motors = bool(value)
        elif number == CONFIG:
            self.send(config_reply(KIND, MODEL, FIRMWARE, TOP))
        elif number == SONAR:
            self.listens = bool(value)
            if not self.listens:
                self.fired.clear()
        elif number in (SETV, SETRV):
            self.most[number == SETRV] = float(min(value, TOP[number == SETRV]))
        elif number in (VEL, RVEL):
            self.wanted[number == RVEL] = float(value)
        elif number in (STOP, ESTOP):
            self.wanted = [0.0, 0.0]

    def command(self):
        """Return what the motors are to do, [m/s, rad/s]."""
        if not self.motors or time.monotonic() - self.spoken > WATCHDOG:
            return [0.0, 0.0]
        v, turn = (max(-most, min(most, x)) for x, most in zip(self.wanted, self.most))
        return [1e-3 * v, math.radians(turn)]

    def fire(self, ranges, turn):
        """Let the transducers of each array fire whose turn it is; all at once for a ``turn`` of None."""
        for k, far in enumerate(ranges.tolist()):
            if k // ARRAY < self.arrays and turn in (None, k % ARRAY):
                heard = UNHEARD if math.isinf(far) or math.isnan(far) else round(1e3 * far)
                self.fired[k] = min(heard, UNHEARD)

    def send(self, data):
        """Send ``data`` as far as there is a driver."""
        if self._socket is not None and not self.silent:
            with contextlib.suppress(OSError):
                self._socket.sendall(data)


class Team:
    """The robots, their world and its sonars."""

    def __init__(self, scenario, port, arrays=2, together=False):
        scenario = scenario.changed(odometry="wheel", limits="firmware", cmd_vel_timeout=WATCHDOG)
        self.world, self._together = World.from_scenario(scenario), together
        self.suite = Suite.of_scenario(scenario, *self.world.senses)
        wanted = [[m.name for m in own if m.name in NAMES] for own in self.suite.mounts]
        self.suite.activate(dict(enumerate(wanted)))
        self.robots = [Robot(row, port + row, arrays) for row in range(scenario.n)]
        self._shots = max(1, round(FIRED / scenario.step))
        self._packets = max(1, round(PACKET / scenario.step))
        self.truths = []  # (time, pose) of each packet

    def step(self):
        """Move on by a step of the world."""
        world = self.world
        rows = np.arange(world.n)
        world.set_commands(rows, np.array([robot.command() for robot in self.robots]))
        world.step()
        self.suite.update(world.steps, world.sensed)
        readings = self.suite.readings(world.time)
        if world.steps % self._shots == 0:
            turn = None if self._together else world.steps // self._shots % ARRAY
            for robot in self.robots:
                sonar = readings[robot.row].get("sonar")
                if robot.listens and sonar is not None:
                    robot.fire(sonar.ranges, turn)
        if world.steps % self._packets == 0:
            self.truths.append((time.time(), world.pose.copy()))
            odometry, twist = world.estimates.odometry(), world.twist
            for robot in self.robots:
                if robot.is_open:
                    robot.send(self._told(robot, odometry[robot.row], twist[robot.row], readings))

    def _told(self, robot, pose, twist, readings):
        own = readings[robot.row]
        half = 500.0 * twist[2] * 0.357
        bumper, battery = own.get("bumper"), own.get("battery")
        fired, robot.fired = robot.fired, {}
        told = Information(
            x=1e3 * pose[0],
            y=1e3 * pose[1],
            theta=pose[2] / math.tau,
            left=1e3 * twist[0] - half,
            right=1e3 * twist[0] + half,
            voltage=VOLTAGE if battery is None else float(battery.voltage),
            turn_rate=math.degrees(twist[2]),
            motors=robot.motors,
            sonar=tuple(sorted(fired.items())),
            listens=robot.listens,
            charge=0 if battery is None else round(100.0 * float(battery.charge)),
        )
        if bumper is not None:
            told = told._replace(
                front=tuple(bumper.front.tolist()), rear=tuple(bumper.rear.tolist())
            )
        return information(told)

    def run(self):
        """Run in wall time."""
        following = time.monotonic()
        while True:
            self.step()
            following = max(following + self.world.step_size, time.monotonic() - LATEST)
            time.sleep(max(0.0, following - time.monotonic()))


NAMES = ("sonar", "bumper", "battery")


def main(scenario, port, *more):
    """Run until standard input ends; ``more``: one_array, together (all transducers fire at once)."""
    with open(scenario) as file:
        content = yaml.safe_load(file)
    shots = {"mounts": {"sonar": {"rate": 1.0 / FIRED}}}
    content["sensors"] = [*content.get("sensors", []), shots]
    options = dict(arrays=1 if "one_array" in more else 2, together="together" in more)
    team = Team(scenario_from_dict(content), int(port), **options)
    threading.Thread(target=team.run, daemon=True).start()
    sys.stdin.read()
    for moment, poses in team.truths:
        print(moment, *poses.ravel().tolist(), sep=",")


if __name__ == "__main__":
    main(*sys.argv[1:])
