"""Readings of sensors in words and numbers with units.  No Qt, no ROS."""

import math

import numpy as np

from mrs_simulator.sensors.types.battery import BatteryReading
from mrs_simulator.sensors.types.beacons import BeaconReading
from mrs_simulator.sensors.types.bumper import BumperReading
from mrs_simulator.sensors.types.camera import CameraReading
from mrs_simulator.sensors.types.encoders import EncoderReading
from mrs_simulator.sensors.types.inertial import AltimeterReading, CompassReading, ImuReading
from mrs_simulator.sensors.types.position import GpsReading, PoseReading
from mrs_simulator.sensors.types.range_bearing import RangeBearingReading
from mrs_simulator.sensors.types.ranging import RangeReading

MINUS, DEGREE = "\u2212", "\u00b0"
MOST_SEEN = 6  # [-] robots that are listed


def number(value, digits, unit=""):
    """Return ``value`` with its unit; a dash for NaN."""
    if not math.isfinite(value):
        return "\u2013" if math.isnan(value) else "\u221e"
    return "{:.{}f}".format(value, digits).replace("-", MINUS) + unit


def degrees(value):
    """Return an angle [rad] in degrees."""
    return number(math.degrees(value), 1, DEGREE)


def reading_text(reading):
    """Return the values of ``reading`` as a text."""
    for kind, text in TEXTS:
        if isinstance(reading, kind):
            return text(reading)
    fields = zip(reading._fields[1:], reading[1:])
    return ", ".join("{} {}".format(name, value) for name, value in fields)


def _ranges(reading):
    ranges = np.asarray(reading.ranges)
    known = np.isfinite(ranges)
    counts = ["{} of {} within {:g} m".format(int(known.sum()), len(ranges), reading.most)]
    lost = int(np.isnan(ranges).sum())
    if lost:
        counts.append("{} lost".format(lost))
    if known.any():
        first = int(np.argmin(np.where(known, ranges, np.inf)))
        near = number(ranges[first], 2, " m")
        way = degrees(math.remainder(float(reading.places[first, 2]), 2.0 * math.pi))
        counts.insert(0, "nearest {} at {}".format(near, way))
    return ", ".join(counts)


def _seen(reading, what="robot"):
    if not len(reading.numbers):
        return "sees no {}".format(what)
    parts = [
        "{} {}: {}{}".format(what, int(k), number(far, 2, " m"), _at(way))
        for k, far, way in zip(reading.numbers, reading.ranges, reading.bearings)
    ]
    more = len(parts) - MOST_SEEN
    return "; ".join(parts[:MOST_SEEN] + (["{} more".format(more)] if more > 0 else []))


def _at(way):
    return " at {}".format(degrees(way)) if math.isfinite(way) else ""


def _pressed(reading):
    parts = [
        "{} {}".format(side, ", ".join(str(k + 1) for k in np.flatnonzero(sections)))
        for side, sections in (("front", reading.front), ("rear", reading.rear))
        if np.any(sections)
    ]
    return "pressed: " + "; ".join(parts) if parts else "nothing is touched"


def _inertia(reading):
    force, rate = ("({})".format(", ".join(number(v, 2) for v in each)) for each in reading[1:3])
    return "a = {} m/s\u00b2, \u03c9 = {} rad/s".format(force, rate)


def _fix(reading):
    if not all(map(math.isfinite, reading[1:4])):
        return "no fix"
    return "{}, {}, {}".format(
        number(reading.latitude, 6, DEGREE),
        number(reading.longitude, 6, DEGREE),
        number(reading.altitude, 2, " m"),
    )


def _charge(reading):
    parts = [number(reading.voltage, 2, " V")]
    if not math.isnan(reading.charge):
        parts.append(number(100.0 * reading.charge, 0, " %") + " charged")
    if reading.charging is not None:
        parts.append("on the charger" if reading.charging else "not on the charger")
    return ", ".join(parts)


def _picture(reading):
    height, width = reading.image.shape[:2]
    return "picture of {} \u00d7 {} pixels".format(width, height)


TEXTS = (
    (BatteryReading, _charge),
    (BeaconReading, lambda r: _seen(r, "beacon")),
    (CameraReading, _picture),
    (RangeReading, _ranges),
    (RangeBearingReading, _seen),
    (BumperReading, _pressed),
    (EncoderReading, lambda r: ", ".join(number(value, 3, " m") for value in r.travel)),
    (ImuReading, _inertia),
    (CompassReading, lambda r: "heading {}".format(degrees(r.heading))),
    (AltimeterReading, lambda r: "z = {}".format(number(r.height, 3, " m"))),
    (GpsReading, _fix),
    (
        PoseReading,
        lambda r: "x = {}, y = {}, \u03b8 = {}".format(
            number(r.x, 3, " m"), number(r.y, 3, " m"), degrees(r.theta)
        ),
    ),
)
