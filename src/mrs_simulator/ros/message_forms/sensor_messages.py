"""Readings of sensors as messages, in types, frames and units of the usual drivers, and back.

A form converts one type of sensor to one type of message.  It is made for a mount, which publishers and
subscribers both know, so that what a message leaves out, such as where a transducer is, comes
from there.  Distances and directions are float32 in most messages; all else is exact.
"""

import genpy
import rospy

from mrs_simulator.core.discovery import classes_in
from mrs_simulator.ros.message_forms import sensor_forms
from mrs_simulator.ros.message_forms.sensor_forms.form import Form

# Those that the folder ``sensor_forms`` defines.
FORMS = [form for form in classes_in(sensor_forms.__name__, Form) if form.MESSAGE is not None]


def forms_of(mount, kind):
    """Return the forms of the ``mount`` on a robot of ``kind``.

    The first is listened to, with those that ``FILLS`` what it leaves out.
    """
    return [form(mount, kind) for form in _of_type(mount) if form.PUBLISHED]


def _of_type(mount):
    return [form for form in FORMS if mount.type == form.TYPE and form.fits(mount.settings)]


def parts_of(mount, kind):
    """Return the forms that make up a reading of the ``mount``; the others fill fields of the first."""
    first, *others = forms_of(mount, kind)
    return [first, *(form for form in others if form.FILLS)]


def others_of(mount, kind):
    """Return the forms in which real robots may publish the ``mount`` instead of those of ``parts_of``.

    RosAria and p2os_driver do.
    """
    return [form(mount, kind) for form in _of_type(mount) if form.BY_DRIVERS]


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
