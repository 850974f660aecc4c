"""The simulated Pioneers that genuine drivers are tried with: what they tell over their own protocol."""

import contextlib
import socket
import struct

import pioneer_protocol as protocol
import pytest
from pioneer_robots import Team
from ros_fixtures import free_port, wait_until

from mrs_simulator.scenario.scenario import scenario_from_dict

# Walls 2 m ahead of the robot's centre and 1.5 m to its left.
CONTENT = {
    "poses": [[0.0, 0.0, 0.0]],
    "obstacles": [
        {"type": "box", "name": "ahead", "center": [2.05, 0.0], "size": [0.1, 10.0]},
        {"type": "box", "name": "left", "center": [0.0, 1.55], "size": [6.0, 0.1]},
    ],
    "sensors": [
        {"mounts": {"sonar": {"rate": 25.0, "noise": {"stddev": 0.0}}}},
        {"mounts": {"bumper": {}, "battery": {"charge": 0.4}}},
    ],
}


class Driver:
    """What a driver does to begin with; the team steps while it waits."""

    def __init__(self, team, port):
        self.team, self._buffer = team, bytearray()
        self._socket = socket.create_connection(("127.0.0.1", port))
        self._socket.settimeout(0.0005)

    def send(self, number, value=None):
        data = bytes([number])
        if value is not None:
            sign = protocol.POSITIVE if value >= 0 else protocol.NEGATIVE
            data += struct.pack("<BH", sign, abs(value))
        self._socket.sendall(protocol.packet(data))

    def answer(self):
        def taken():
            self.team.step()
            with contextlib.suppress(socket.timeout):
                self._buffer.extend(self._socket.recv(4096))
            return protocol.taken(self._buffer)

        return wait_until(taken, nap=0.0)

    def told(self, condition):
        """Return the first of the robot's packets for which ``condition`` holds."""
        while True:
            self.send(protocol.PULSE)
            data = self.answer()
            found = Told(data)
            if data[0] in (protocol.STANDS, protocol.MOVES) and condition(found):
                return found


class Told:
    """The fields of a robot's packet."""

    def __init__(self, data):
        fields = struct.unpack_from("<BHHhhhBBBhHBB", data) if len(data) > 20 else [0] * 13
        self.kind, self.x, self.y, self.theta, self.left, self.right = fields[:6]
        self.rear, self.front, self.flags, self.count = fields[7], fields[8], fields[10], fields[12]
        pairs = [struct.unpack_from("<BH", data, 20 + 3 * k) for k in range(self.count)]
        self.sonar = dict(pairs)
        self.tail = struct.unpack_from("<HBh", data, 25 + 3 * self.count)
        self.charge = data[-1]


@pytest.fixture
def driver():
    port = free_port()
    team = Team(scenario_from_dict(CONTENT), port)
    driver = Driver(team, port)
    for number in (protocol.SYNC0, protocol.SYNC1):
        driver.send(number)
        assert driver.answer() == bytes([number])
    driver.send(protocol.SYNC2)
    assert driver.answer() == b"\x02robot1\0Pioneer\0p3dx-sh\0"
    driver.send(protocol.OPEN, 1)
    return driver


def test_broken_packets_are_left_out():
    buffer = bytearray(b"\xfa\x00" + protocol.packet(b"\x01abc")[:-1] + b"\0")
    buffer += protocol.packet(b"\x0b\x1b\x2c\x01") + b"\xfa\xfb\x20"
    assert protocol.command(protocol.taken(buffer)) == (protocol.VEL, -300)
    assert protocol.taken(buffer) is None
    assert protocol.checksum(b"\x00\x3b\x01\x00") == 0x013B
    assert protocol.checksum(b"\x12\x34\x56") == 0x1234 ^ 0x56


def test_it_drives_as_the_firmware_does_once_its_motors_are_on(driver):
    driver.send(protocol.VEL, 300)
    assert driver.told(lambda told: True).flags == 0
    driver.send(protocol.ENABLE, 1)
    moving = driver.told(lambda told: told.left == 300)
    assert moving.kind == protocol.MOVES and moving.flags == 1 and 140 < moving.x < 185
    driver.send(protocol.RVEL, -500)  # cut to 100 deg/s
    turning = driver.told(lambda told: told.tail[2] <= -1000)
    assert turning.tail[2] == -1000
    assert turning.left - turning.right == pytest.approx(357 * 1.74533, abs=1.0)


def test_transducers_fire_in_turns_while_they_are_wanted(driver):
    assert driver.told(lambda told: True).sonar == {}
    driver.send(protocol.SONAR, 1)
    first = driver.told(lambda told: told.sonar)
    counts, heard = [len(first.sonar)], dict(first.sonar)
    while len(heard) < 16:
        told = driver.told(lambda told: True)
        assert {k % 8 for k in told.sonar if k < 8} == {k % 8 for k in told.sonar if k > 7}
        counts.append(len(told.sonar))
        heard.update(told.sonar)
    assert len(counts) <= 5 and set(counts[1:]) <= {4, 6}
    assert heard[0] == 1500 - 136 and heard[3] == heard[4] == 2000 - 166
    assert heard[11] == heard[12] == 5000  # nothing is behind
    driver.send(protocol.SONAR, 0)
    assert driver.told(lambda told: told.flags == 0).sonar == {}


def test_bumpers_and_battery_are_published(driver):
    quiet = driver.told(lambda told: told.charge)
    assert quiet.front == quiet.rear == 0 and quiet.tail[:2] == (121, 0) and quiet.charge == 40
    driver.send(protocol.ENABLE, 1)
    driver.send(protocol.VEL, 750)
    assert (
        driver.told(lambda told: told.front).front & 0b001000
    )  # the middle one of five, bits 1 to 5
