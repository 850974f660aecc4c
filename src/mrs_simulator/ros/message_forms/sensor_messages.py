"""Readings of sensors as messages, in types, frames and units of the usual drivers, and back.

A form converts one type of sensor to one type of message.  It is made for a mount, which publishers and
subscribers both know, so that what a message leaves out, such as where a transducer is, comes
from there.  Distances and directions are float32 in most messages; all else is exact.
"""

import genpy
import rospy

from mrs_simulator.ros.message_forms.sensor_forms.body import (
    Bumpers,
    Charge,
    Inertia,
    Recharging,
    StateOfCharge,
    Voltage,
    Wheels,
)
from mrs_simulator.ros.message_forms.sensor_forms.camera import (
    Colours,
    DepthPinhole,
    Depths,
    Pinhole,
    RawDepths,
)
from mrs_simulator.ros.message_forms.sensor_forms.drivers import Distances, P2osVoltage
from mrs_simulator.ros.message_forms.sensor_forms.others import BeaconsHeard, Seen
from mrs_simulator.ros.message_forms.sensor_forms.place import (
    Fix,
    Heading,
    Height,
    Tracked,
    TrackedSurely,
)
from mrs_simulator.ros.message_forms.sensor_forms.ranging import (
    Scan,
    SonarCloud,
    SonarCloud2,
    SonarRange,
)

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
# As drivers of real robots may publish it instead: RosAria and p2os_driver.
OTHERS = {
    "battery": (Voltage, StateOfCharge, Recharging, P2osVoltage),
    "sonar": (Distances,),
}


def forms_of(mount, kind):
    """Return the forms of the ``mount`` on a robot of ``kind``."""
    kinds = FORMS[mount.type]
    if mount.type == "camera" and not mount.settings.has_depth:
        kinds = tuple(form for form in kinds if not form.SUFFIX.startswith(Depths.SUFFIX))
    if mount.type == "sonar" and len(mount.settings.transducers) == 1:
        kinds = (*kinds, SonarRange)
    return [form(mount, kind) for form in kinds]


def parts_of(mount, kind):
    """Return the forms that make up a reading of the ``mount``; the others fill fields of the first."""
    first, *others = forms_of(mount, kind)
    return [first, *(form for form in others if form.FILLS)]


def others_of(mount, kind):
    """Return the forms in which real robots may publish the ``mount`` instead of those of ``parts_of``."""
    return [form(mount, kind) for form in OTHERS.get(mount.type, ())]


def stamp_of(message):
    """Return the stamp of ``message``, the present time for one that has no header."""
    header = getattr(message, "header", None)
    return rospy.get_rostime() if header is None else header.stamp


def listen(name, forms, take, refuse, **options):
    """Return a subscriber to the topic ``name``, on which a message of any of ``forms`` may come.

    ``take(message, form)`` is called with each, ``refuse(form, text)`` with why one is none of them;
    ``options`` are those of ``rospy.Subscriber``.
    """
    first = forms[0]
    if len(forms) == 1:
        return rospy.Subscriber(name, first.MESSAGE, take, callback_args=first, **options)
    known = {(form.MESSAGE._type, form.MESSAGE._md5sum): form for form in forms}

    def dispatch(raw):
        header = raw._connection_header
        form = known.get((header.get("type"), header.get("md5sum")))
        if form is None:
            wanted = " or ".join(form.MESSAGE._type for form in forms)
            return refuse(first, "a {}, wanted {}".format(header.get("type"), wanted))
        try:
            message = form.MESSAGE().deserialize(raw._buff)
        except genpy.DeserializationError as error:
            return refuse(form, str(error))
        message._connection_header = header
        return take(message, form)

    return rospy.Subscriber(name, rospy.AnyMsg, dispatch, **options)


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
