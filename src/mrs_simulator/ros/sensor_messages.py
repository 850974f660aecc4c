"""Readings of sensors as messages, in types, frames and units of the usual drivers, and back.

A form tells one type of sensor in one type of message.  It is made for a mount, as those who publish and
those who listen both know it, so that what a message leaves out, such as where a transducer is, comes
from there.  Distances and directions are float32 in most messages; all else is told to the last digit.
"""

import rospy

from mrs_simulator.ros.sensor_forms.body import (
    Bumpers,
    Charge,
    Inertia,
    StateOfCharge,
    Voltage,
    Wheels,
)
from mrs_simulator.ros.sensor_forms.camera import (
    Colours,
    DepthPinhole,
    Depths,
    Pinhole,
    RawDepths,
)
from mrs_simulator.ros.sensor_forms.others import BeaconsHeard, Seen
from mrs_simulator.ros.sensor_forms.place import Fix, Heading, Height, Tracked, TrackedSurely
from mrs_simulator.ros.sensor_forms.ranging import Scan, SonarCloud, SonarCloud2, SonarRange

# Of each type of sensor; the first is listened to, with those that ``FILLS`` what it leaves out.
FORMS = {
    "altimeter": (Height,),
    "battery": (Charge, Voltage, StateOfCharge),
    "beacons": (BeaconsHeard,),
    "bumper": (Bumpers,),
    "camera": (Colours, Depths, RawDepths, Pinhole, DepthPinhole),
    "compass": (Heading,),
    "encoders": (Wheels,),
    "gps": (Fix,),
    "imu": (Inertia,),
    "laser": (Scan,),
    "motion_capture": (Tracked, TrackedSurely),
    "range_bearing": (Seen,),
    "sonar": (SonarCloud, SonarCloud2),
}


def forms_of(mount, kind):
    """Return the forms of the ``mount`` on a robot of ``kind``."""
    kinds = FORMS[mount.type]
    if mount.type == "camera" and not mount.numbers.has_depth:
        kinds = tuple(form for form in kinds if not form.SUFFIX.startswith(Depths.SUFFIX))
    if mount.type == "sonar" and len(mount.numbers.transducers) == 1:
        kinds = (*kinds, SonarRange)
    return [form(mount, kind) for form in kinds]


def parts_of(mount, kind):
    """Return the forms that make up a reading of the ``mount``; the others fill fields of the first."""
    first, *others = forms_of(mount, kind)
    return [first, *(form for form in others if form.FILLS)]


def topic_of(number, form):
    """Return the name of the topic of ``form`` of the robot ``number``."""
    return "/robot{}/{}{}".format(number, form.mount.name, form.SUFFIX)


def listened_topic(pattern, number, form):
    """Return the topic of ``form`` of the robot ``number`` by ``pattern``: {} its number, * the sensor.

    Raises ``ValueError`` for a pattern without the latter.
    """
    if pattern.count("*") != 1:
        text = "parameter {} = {!r}: wanted one * for the sensor's name"
        raise ValueError(text.format(rospy.resolve_name("~sensor_topic"), pattern))
    return pattern.replace("{}", str(number)).replace("*", form.mount.name + form.SUFFIX)
