"""Checked access to ROS parameters; errors name the parameter, its value and what was wanted."""

import contextlib

import numpy as np
import rospy

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import EACH, NUMBER, NUMBERS
from mrs_simulator.ros.node.node_parameters import ROBOTS


@explained_by("docs/nodes.md")
def read(field, default=None, n=None):
    """Return the value of the parameter that ``field`` declares, else ``default``, else the declared one.

    Numbers are a tuple; of a parameter for each robot an array (n,).  An empty text counts as not given:
    launch files pass it for an argument left out.  Raises ``ValueError``.
    """
    result = field.default if default is None else default
    value = rospy.get_param("~" + field.name, "")
    if value != "":
        result = str(value) if field.kind == ROBOTS else field.typed(_numbers(field, value), n)
    if result is None and value != "":
        text = "parameter {} = {!r}: wanted {}"
        name = rospy.resolve_name("~" + field.name)
        raise ValueError(text.format(name, value, field.wanted(n)))
    if field.kind == EACH:
        return np.full(n, result)
    return float(result) if field.kind == NUMBER else result


def is_given(field):
    """Return whether the parameter is set."""
    return rospy.get_param("~" + field.name, "") != ""


def _numbers(field, value):
    """Return ``value``, of a launch file's text of numbers, with commas between them, the numbers."""
    if not isinstance(value, str):
        return value
    with contextlib.suppress(ValueError):
        if field.kind == NUMBER:
            return float(value)
        if field.kind == NUMBERS or "," in value:
            return [float(part) for part in value.strip(" []").split(",")]
        return float(value) if field.kind == EACH else value
    return value
