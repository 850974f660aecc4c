"""ROS parameters, checked: a wrong one is named with what came and what was wanted."""

import math

import rospy


def number_parameter(name, default, low=None, above=None):
    """Return the parameter as a finite float, at least ``low`` or above ``above``.

    An empty text counts as not given: launch files pass it for an argument left out.
    """
    value = _given(name, default)
    try:
        result = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        result = math.nan
    fits = math.isfinite(result)
    fits = fits and (low is None or result >= low) and (above is None or result > above)
    if not fits:
        wanted = "" if low is None else " of at least {:g}".format(low)
        wanted = wanted if above is None else " above {:g}".format(above)
        raise ValueError(
            "parameter {} = {!r}: wanted a number{}".format(rospy.resolve_name(name), value, wanted)
        )
    return result


def flag_parameter(name, default):
    """Return the parameter as a bool."""
    value = _given(name, default)
    if not isinstance(value, bool):
        raise ValueError(
            "parameter {} = {!r}: wanted true or false".format(rospy.resolve_name(name), value)
        )
    return value


def text_parameter(name, default, choices=()):
    """Return the parameter as a text, one of ``choices`` if given."""
    value = _given(name, default)
    if not isinstance(value, str) or (choices and value not in choices):
        wanted = "one of " + ", ".join(choices) if choices else "a text"
        raise ValueError(
            "parameter {} = {!r}: wanted {}".format(rospy.resolve_name(name), value, wanted)
        )
    return value


def _given(name, default):
    value = rospy.get_param(name, default)
    return default if isinstance(value, str) and value == "" else value
