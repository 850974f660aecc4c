"""Checked access to ROS parameters; errors name the parameter, its value and what was wanted."""

import math

import numpy as np
import rospy

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.ros.node import node_parameters as kinds


@explained_by("docs/nodes.md")
def read(parameter, default=None, n=None):
    """Return the value of a ``NodeParameter``, else ``default``, else the declared default.

    A number is a finite float, a flag a bool or one of the choices, numbers are a tuple; of a parameter
    for each robot an array (n,).  An empty text counts as not given: launch files pass it for an
    argument left out.  Raises ``ValueError``.
    """
    default = parameter.default if default is None else default
    value = rospy.get_param("~" + parameter.name, None)
    value = None if isinstance(value, str) and value == "" else value
    if parameter.kind == kinds.FOR_EACH_ROBOT:
        return _for_each_robot(parameter, value, n, default)
    if value is None:
        return float(default) if parameter.kind == kinds.NUMBER else default
    return _READERS[parameter.kind](parameter, value)


def is_given(parameter):
    """Return whether the parameter is set."""
    return rospy.get_param("~" + parameter.name, "") != ""


def _number(parameter, value):
    try:
        result = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        result = math.nan
    fits = math.isfinite(result)
    fits = fits and (parameter.low is None or result >= parameter.low)
    fits = fits and (parameter.above is None or result > parameter.above)
    if not fits or (parameter.high is not None and result > parameter.high):
        raise _refused(parameter, value)
    return result


def _flag(parameter, value):
    if not isinstance(value, bool) and value not in parameter.choices:
        raise _refused(parameter, value)
    return value


def _text(parameter, value):
    if not isinstance(value, str) or (parameter.choices and value not in parameter.choices):
        raise _refused(parameter, value)
    return value


def _pattern(parameter, value):
    if not isinstance(value, str):
        raise _refused(parameter, value, kinds.TEXT)
    if value.count("{}") != 1:
        raise _refused(parameter, value)
    return value


def _numbers(parameter, value, size=None):
    """Return ``value``, a list, or a launch file's text of numbers with commas between them."""
    sizes = (parameter.size, *parameter.sizes) if size is None else (size,)
    try:
        parts = value.strip(" []").split(",") if isinstance(value, str) else value
        result = tuple(math.nan if isinstance(part, bool) else float(part) for part in parts)
    except (TypeError, ValueError):
        result = ()
    if len(result) not in sizes or not all(map(math.isfinite, result)):
        wanted = " or ".join(map(str, sizes))
        raise _refused(parameter, value, "{} numbers".format(wanted))
    return result


def _for_each_robot(parameter, value, n, default):
    if value is None:
        return np.full(n, default)
    if not isinstance(value, (list, tuple)) and "," not in str(value):
        return np.full(n, _number(parameter._replace(kind=kinds.NUMBER), value))
    result = np.array(_numbers(parameter, value, n))
    if not (result > parameter.above).all():
        raise _refused(parameter, value, "{} numbers above {:g}".format(n, parameter.above))
    return result


def _as_text(_, value):
    return str(value)


def _refused(parameter, value, wanted=""):
    return ValueError(
        "parameter {} = {!r}: wanted {}".format(
            rospy.resolve_name("~" + parameter.name), value, wanted or parameter.wanted()
        )
    )


_READERS = {
    kinds.NUMBER: _number,
    kinds.FLAG: _flag,
    kinds.TEXT: _text,
    kinds.PATTERN: _pattern,
    kinds.NUMBERS: _numbers,
    kinds.ROBOTS: _as_text,
}
