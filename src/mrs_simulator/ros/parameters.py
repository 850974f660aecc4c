"""Checked access to ROS parameters; errors name the parameter, its value and what was wanted."""

import math

import numpy as np
import rospy


def number_parameter(name, default, low=None, above=None, high=None):
    """Return the parameter as a finite float, at least ``low`` or above ``above``, at most ``high``.

    An empty text counts as not given: launch files pass it for an argument left out.
    """
    value = _given(name, default)
    try:
        result = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        result = math.nan
    fits = math.isfinite(result)
    fits = fits and (low is None or result >= low) and (above is None or result > above)
    fits = fits and (high is None or result <= high)
    if not fits:
        wanted = "" if low is None else " of at least {:g}".format(low)
        wanted = wanted if above is None else " above {:g}".format(above)
        if high is not None:
            wanted += (
                " and at most {:g}".format(high) if wanted else " of at most {:g}".format(high)
            )
        raise ValueError(
            "parameter {} = {!r}: wanted a number{}".format(rospy.resolve_name(name), value, wanted)
        )
    return result


def flag_parameter(name, default, or_text=None):
    """Return the parameter as a bool, or as the text ``or_text`` if that is allowed too."""
    value = _given(name, default)
    if not isinstance(value, bool) and (or_text is None or value != or_text):
        more = ", or {}".format(or_text) if or_text else ""
        raise ValueError(
            "parameter {} = {!r}: wanted true or false{}".format(
                rospy.resolve_name(name), value, more
            )
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


def pattern_parameter(name, default):
    """Return the parameter as a text with one ``{}`` for the robot's number, or "" if that is default."""
    value = text_parameter(name, default)
    if value.count("{}") != 1 and value != default:
        raise ValueError(
            "parameter {} = {!r}: wanted one {{}} for the robot's number".format(
                rospy.resolve_name(name), value
            )
        )
    return value


def numbers_parameter(name, count):
    """Return the parameter as a tuple of ``count`` finite numbers, None where it is not given.

    A launch file's text of numbers with commas between them will do.
    """
    value = _given(name, None)
    if value is None:
        return None
    parts = value.strip(" []").split(",") if isinstance(value, str) else value
    try:
        result = tuple(math.nan if isinstance(part, bool) else float(part) for part in parts)
    except (TypeError, ValueError):
        result = ()
    if len(result) != count or not all(map(math.isfinite, result)):
        raise ValueError(
            "parameter {} = {!r}: wanted {} numbers".format(rospy.resolve_name(name), value, count)
        )
    return result


def robots_parameter(name, n, default):
    """Return the parameter as numbers above 0, one for each of n robots, (n,); one holds for all."""
    value = _given(name, None)
    if value is None:
        return np.full(n, default)
    if not isinstance(value, (list, tuple)) and "," not in str(value):
        return np.full(n, number_parameter(name, default, above=0.0))
    result = np.array(numbers_parameter(name, n))
    if not (result > 0.0).all():
        text = "parameter {} = {!r}: wanted {} numbers above 0"
        raise ValueError(text.format(rospy.resolve_name(name), value, n))
    return result


def _given(name, default):
    value = rospy.get_param(name, default)
    return default if isinstance(value, str) and value == "" else value
