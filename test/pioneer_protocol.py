"""Packets of the protocol that Pioneers speak with their drivers (P2OS, ARCOS), as a robot needs them.

A packet is 0xFA 0xFB, the number of bytes that follow, these bytes, of which the last two are a checksum.
Numbers are little-endian but for the checksum, the sum of the others in pairs, the first of a pair high.
"""

import struct
from typing import Any, NamedTuple

HEADER = b"\xfa\xfb"
POSITIVE, NEGATIVE, TEXT = 0x3B, 0x1B, 0x2B  # types of a command's argument
TURN = 4096  # [-] units of angle in a turn
WRAP = 0x8000  # [mm] at which places begin anew
STANDS, MOVES, CONFIG_REPLY = 0x32, 0x33, 0x20  # kinds of packets that a robot sends

PULSE = 0
SYNC0, SYNC1, SYNC2, OPEN, CLOSE, ENABLE = 0, 1, 2, 1, 2, 4
SETV, SETRV, VEL, CONFIG, RVEL, SONAR, STOP, VEL2, ESTOP = 6, 10, 11, 18, 21, 28, 29, 32, 55


class Command(NamedTuple):
    """A command to the robot: its number and argument."""

    number: int
    argument: Any = None


class Information(NamedTuple):
    """What a robot tells ten times a second."""

    x: float  # [mm]
    y: float  # [mm]
    theta: float  # [-] of a turn
    left: float  # [mm/s]
    right: float  # [mm/s]
    voltage: float  # [V]
    turn_rate: float  # [deg/s]
    motors: bool
    front: tuple = (False,) * 5  # bumper sections, each from the left to the right
    rear: tuple = (False,) * 5
    sonar: tuple = ()  # (transducer, [mm]) of those that have fired since the last packet
    listens: bool = False  # whether the sonars are on
    charging: int = 0
    charge: int = 0  # [%], 0: not known


def checksum(data):
    """Return the checksum of ``data``.

    >>> hex(checksum(bytes([0, 0x3B, 1, 0])))
    '0x13b'
    >>> hex(checksum(bytes([0x12, 0x34, 0x56])))
    '0x1262'
    """
    total = 0
    for k in range(0, len(data) - 1, 2):
        total += data[k] << 8 | data[k + 1]
    total &= 0xFFFF
    return total ^ data[-1] if len(data) % 2 else total


def packet(data):
    """Return the packet of ``data``."""
    return HEADER + bytes([len(data) + 2]) + data + struct.pack(">H", checksum(data))


def taken(buffer):
    """Take the first packet out of the bytearray ``buffer``; return its data, None where none is whole.

    What is no packet, or has a wrong checksum, is left out.
    """
    while True:
        at = buffer.find(HEADER)
        del buffer[: at if at >= 0 else max(0, len(buffer) - 1)]
        if len(buffer) < 3 or len(buffer) < 3 + buffer[2]:
            return None
        data, told = bytes(buffer[3 : 1 + buffer[2]]), bytes(buffer[1 + buffer[2] : 3 + buffer[2]])
        if told == struct.pack(">H", checksum(data)):
            del buffer[: 3 + len(data) + 2]
            return data
        del buffer[:2]


def command(data):
    """Return the ``Command`` in the ``data`` of a packet."""
    if len(data) < 4:
        return Command(data[0])
    if data[1] == TEXT:
        return Command(data[0], data[3 : 3 + data[2]])
    value = struct.unpack_from("<H", data, 2)[0]
    return Command(data[0], -value if data[1] == NEGATIVE else value)


def sync_reply(name, kind, model):
    """Return what a robot answers to ``SYNC2``: who it is."""
    texts = b"".join(text.encode() + b"\0" for text in (name, kind, model))
    return packet(bytes([SYNC2]) + texts)


def config_reply(kind, model, firmware, top):
    """Return the packet with the robot's settings.

    ``firmware``, ``top``: speed, turn rate, acceleration and turn acceleration in mm and degrees, as they
    are and as they can be at most; what else there is is zero, or as the factory leaves it.
    """
    v, turn, accel, turn_accel = firmware
    words = struct.Struct("<B4HH").pack(0, top[1], top[0], top[3], top[2], 500)
    parts = [bytes([CONFIG_REPLY])]
    parts += [text.encode() + b"\0" for text in (kind, model, "0000")]
    parts += [words, b"pioneer\0", bytes([100, 0, 0])]  # packets every 100 ms
    parts += [struct.pack("<HHBHHHBHHHH", 0, 1, 1, 110, 16570, 2000 // 2, 0, 200, 50, 0, 0)]
    parts += [struct.pack("<HHHHHHH", turn, v, turn_accel, turn_accel, 40, 20, 0)]
    parts += [struct.pack("<HHHHH", accel, accel, 40, 30, 0)]
    parts += [struct.pack("<BBBBBB", 5, 5, 0, 40, 0, 0)]  # bumpers, charger, sonar cycle
    parts += [struct.pack("<hBBHH", 0, 0, 0, 138, 110), b"2.9\0", bytes(100)]
    return packet(b"".join(parts)[:200])


def information(told):
    """Return the packet of an ``Information``."""
    stands = not (round(told.left) or round(told.right))
    flags = int(told.motors) | (0x1E if told.listens else 0)
    theta = round(told.theta * TURN)
    theta = (theta + TURN // 2) % TURN - TURN // 2
    data = struct.pack(
        "<BHHhhhBBBhHBB",
        STANDS if stands else MOVES,
        round(told.x) % WRAP,
        round(told.y) % WRAP,
        theta,
        round(told.left),
        round(told.right),
        round(10.0 * told.voltage) & 0xFF,
        sum(pressed << k for k, pressed in enumerate(told.rear[::-1], start=1)),
        sum(pressed << k for k, pressed in enumerate(told.front, start=1)),
        theta,
        flags,
        0,
        len(told.sonar),
    )
    for number, distance in told.sonar:
        data += struct.pack("<BH", number, distance)
    data += struct.pack("<HBBB", 0, 0, 0, 0)  # ports
    data += struct.pack(
        "<HBh", round(10.0 * told.voltage), told.charging, round(10.0 * told.turn_rate)
    )
    return packet(data + struct.pack("<HhbB", 0, 0, 20, told.charge))
