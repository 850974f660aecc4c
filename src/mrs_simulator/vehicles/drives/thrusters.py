"""Two fixed thrusters astern, left and right: thrust curves, lag and allocation.

    X = T_left + T_right,   N = a (T_right - T_left),

a [m] from the middle to each.  A thruster has a ``command`` between -``astern`` and ``ahead``:

- ``linear``: from -1 to 1, in proportion to the greatest thrust astern and ahead;
- ``square``: a propeller's speed n [rad/s], ``T = k n |n|`` with another k astern (Otter);
- ``logistic``: from -1 to 1, by the two curves measured on a WAM-V that the simulator VRX has.
"""

import numpy as np

CURVES = ("linear", "square", "logistic")
# T = low + rise/(c + exp(-b (x - m)))^(1/v), ahead and astern; dead in between.
AHEAD = (0.01, 59.81, 0.56, 5.0, 0.28, 0.38)
ASTERN = (-199.13, 199.04, 0.99, 8.84, -0.57, 5.34)
DEAD = 0.01  # [-] of a command, to either side


def thrust(command, numbers):
    """Return the thrusts (m, 2) [N] of left and right thrusters at ``command`` (m, 2)."""
    return _by_curve(numbers, command, _thrust_of)


def command_for(wanted, numbers):
    """Return the commands (m, 2) at which the thrusts are ``wanted`` (m, 2) [N], or the nearest."""
    return _by_curve(numbers, wanted, _command_of)


def _by_curve(numbers, values, function):
    given = [
        _upright(each)
        for each in (numbers.factor_ahead, numbers.factor_astern, numbers.ahead, numbers.astern)
    ]
    if isinstance(numbers.curve, str):
        return function(numbers.curve, values, *given)
    columns = [np.broadcast_to(each, values.shape) for each in given]
    result = np.empty(values.shape, order="F")
    for curve in CURVES:
        rows = numbers.curve == curve
        if rows.any():
            result[rows] = function(curve, values[rows], *(f[rows] for f in columns))
    return result


def _upright(value):
    """Return a number as it is, and numbers (m,) as a column (m, 1)."""
    return value[:, np.newaxis] if getattr(value, "ndim", 0) else value


def _thrust_of(curve, command, factor, back, ahead, astern):
    command = np.minimum(np.maximum(command, -astern), ahead)
    if curve == "linear":
        return np.where(command > 0.0, factor, back) * command
    if curve == "square":
        return np.where(command > 0.0, factor, back) * command * np.abs(command)
    going = np.where(command > 0.0, _logistic(command, AHEAD), _logistic(command, ASTERN))
    return np.where(np.abs(command) > DEAD, going, 0.0)


def _command_of(curve, wanted, factor, back, ahead, astern):
    share = wanted / np.where(wanted > 0.0, factor, back)
    if curve == "linear":
        command = share
    elif curve == "square":
        command = np.sign(share) * np.sqrt(np.abs(share))
    else:
        forth = np.maximum(_logit(np.maximum(wanted, 0.02), AHEAD), DEAD)
        aback = np.minimum(_logit(np.minimum(wanted, -0.1), ASTERN), -DEAD)
        command = np.where(wanted > 0.0, forth, aback)
        command = np.where((wanted > -0.05) & (wanted < 0.01), 0.0, command)
    return np.minimum(np.maximum(command, -astern), ahead)


def _logistic(x, numbers):
    low, rise, c, b, m, v = numbers
    return low + rise / (c + np.exp(-b * (x - m))) ** (1.0 / v)


def _logit(thrust, numbers):
    """Undo ``_logistic``; beyond the curve's ends a command far beyond the limits."""
    low, rise, c, b, m, v = numbers
    inner = (rise / np.maximum(thrust - low, 1e-6)) ** v - c
    return m - np.log(np.maximum(inner, 1e-12)) / b


def allocated(force, torque, numbers):
    """Return the thrusts (m, 2) [N] of left and right that give ``force`` (m,) [N], ``torque`` (m,) [N m].

    Where a thruster would have to give more than it can, both give way by the same amount, so that the
    torque is kept as long as it can be; the rest is cut off.
    """
    most, least = numbers.most, numbers.least
    difference = np.minimum(np.abs(0.5 / numbers.arm * torque), 0.5 * (most - least))
    middle = np.minimum(np.maximum(0.5 * force, least + difference), most - difference)
    difference = np.copysign(difference, torque)
    result = np.empty((2, len(force)))
    np.subtract(middle, difference, out=result[0])
    np.add(middle, difference, out=result[1])
    return result.T


def ends(numbers):
    """Return the greatest thrusts ahead and astern, the latter below 0, a pair [N], of one kind."""
    most, least = thrust(np.array([[numbers.ahead, -numbers.astern]]), numbers)[0].tolist()
    return most, least


def after_lag(command, wanted, numbers, duration):
    """Return the commands (m, 2) in force after ``duration`` [s] towards ``wanted`` (m, 2), exactly."""
    lag = np.maximum(numbers.lag, 1e-3 * duration)  # of which nothing is left after the step
    left = np.reshape(np.exp(-duration / lag), (-1, 1))
    return wanted + left * (command - wanted)
