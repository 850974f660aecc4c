"""Commands of a team and the ``Twist`` messages of the hook: conversion, and what is refused."""

import functools
import importlib.util
import operator
import struct

import numpy as np

from mrs_simulator.core.kinematics import TWIST_AXES, UNICYCLE_AXES, max_abs


def _is_there(module):
    """Return whether there is a ``module``, without loading it."""
    try:
        return importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:
        return False


if not _is_there("geometry_msgs.msg"):
    import mrs_simulator.control.twist_message  # noqa: F401, so that laws find these messages


def __getattr__(name):
    """Return ``Twist`` or ``make_twist``: ROS's messages take 10 ms to load, and few laws need them."""
    if name not in ("Twist", "make_twist"):
        raise AttributeError("module {!r} has no attribute {!r}".format(__name__, name))
    from mrs_simulator.control import twist_message

    return getattr(twist_message, name)


class ControlError(ValueError):
    """A law that did not return one finite Twist for each robot; the message says which."""

    page = "docs/troubleshooting.md#protocols"


def twists_of(command, axes):
    """Return a list of the Twists of ``command`` (n, a), whose columns are ``axes``."""
    from mrs_simulator.control.twist_message import Twist, make_twist

    if axes == UNICYCLE_AXES:
        return [make_twist(v, omega) for v, omega in command.tolist()]
    places = [axis.split(".") for axis in axes if axis in TWIST_AXES]  # arms obey no Twist
    twists = []
    for row in command.tolist():
        twist = Twist()
        for (part, component), value in zip(places, row):
            setattr(getattr(twist, part), component, value)
        twists.append(twist)
    return twists


def commands_of(twists, numbers, team):
    """Return the commands (n, a) in what a law returned: Twists by number, or in that order.

    Raises ``ControlError`` for another number or kind of things, and for a component that a robot
    does not obey and that is not 0.
    """
    twists = _in_order(twists, numbers)
    if team.axes == UNICYCLE_AXES:
        command = _speeds(twists)
        if command is not None:
            return command
    table = _table(twists, numbers)
    refused = np.logical_and(table, team.ignored_axes)
    if refused.any():
        _refuse_components(refused, table, numbers, team)
    result = np.array(table[:, team.components], order="F")
    if team.has_arms:  # a law of Twists leaves them as they are
        result = np.pad(result, [(0, 0), (0, team.arm_joints)])
    return result


def _speeds(twists):
    """Return v and omega, (n, 2), of what ``make_twist`` made; None where there is anything else."""
    columns = np.empty((2, len(twists)))
    try:
        v, omega = [each._v for each in twists], [each._omega for each in twists]
        _packing(2 * len(v))(columns, 0, *v, *omega)
    except (AttributeError, struct.error):
        return None
    return columns.T


@functools.lru_cache(maxsize=8)
def _packing(count):
    """Return the function that packs ``count`` floats into an array."""
    return struct.Struct("{}d".format(count)).pack_into


def _in_order(twists, numbers):
    if isinstance(twists, dict):
        if tuple(twists) == numbers:
            return twists.values()
        if set(twists) != set(numbers):
            raise ControlError(
                "calculateControlLaw returned Twists for robots {}, wanted {}".format(
                    _listed(twists), _listed(numbers)
                )
            )
        return [twists[number] for number in numbers]
    if not isinstance(twists, (list, tuple)) or len(twists) != len(numbers):
        text = "calculateControlLaw returned {}, wanted {} Twists, one for each robot"
        raise ControlError(text.format(described(twists), len(numbers)))
    return twists


def _table(twists, numbers):
    """Return all components, (n, 6) in the order of ``TWIST_AXES``."""
    try:
        return _components_by_column(twists)
    except (AttributeError, struct.error):
        pass
    for number, twist in zip(numbers, twists):
        try:
            [float(value) for value in _components(twist)]
        except (AttributeError, TypeError, ValueError):
            text = "calculateControlLaw returned {} for robot {}, wanted a Twist of numbers"
            raise ControlError(text.format(described(twist), number)) from None
    return np.array([[float(value) for value in _components(twist)] for twist in twists])


_components = operator.attrgetter(*TWIST_AXES)


def _components_by_column(twists):
    """Return what :func:`_table` does, in half of the time; raises where one is no number."""
    table, columns = np.empty((len(TWIST_AXES), len(twists))), []
    for vectors in ([each.linear for each in twists], [each.angular for each in twists]):
        columns += [each.x for each in vectors]
        columns += [each.y for each in vectors]
        columns += [each.z for each in vectors]
    _packing(len(columns))(table, 0, *columns)
    return table.T


def _refuse_components(refused, table, numbers, team):
    row, column = np.argwhere(refused)[0]
    kind = team.kinds[row]
    raise ControlError(
        "the law gave robot {} {} = {:g}, which a {} does not obey; wanted 0 (it obeys {})".format(
            numbers[row], TWIST_AXES[column], table[row, column], kind.title, ", ".join(kind.axes)
        )
    )


def check_finite(command, numbers, axes):
    """Raise ``ControlError`` that names the first robot whose ``command`` (n, a) is not finite."""
    if max_abs(command) < np.inf:
        return
    row = np.flatnonzero(~np.isfinite(command).all(axis=1))[0]
    names = ("v", "omega") if axes == UNICYCLE_AXES else axes
    given = ", ".join(
        "{} = {} {}".format(name, value, "m/s" if axis.startswith("linear") else "rad/s")
        for name, axis, value in zip(names, axes, command[row])
    )
    raise ControlError(
        "the law gave robot {} {}, wanted finite numbers".format(numbers[row], given)
    )


def _listed(numbers):
    numbers = sorted(numbers, key=str)
    return ", ".join(map(str, numbers[:10])) + (", ..." if len(numbers) > 10 else "") or "none"


def described(value):
    """Return the type of ``value``, the length of a sequence, and an array's, for an error message."""
    count = " of {}".format(len(value)) if isinstance(value, (list, tuple)) else ""
    count = " of {}".format(value.dtype) if isinstance(value, np.ndarray) else count
    return "{}{}".format(type(value).__name__, count)
