"""Car-like robots: the bicycle model about the rear axle.

    x' = v cos(theta),  y' = v sin(theta),  theta' = v tan(delta)/L,

(x, y) the rear axle's centre, v its speed, delta the steering angle (positive to the left), L the
wheelbase.  Commands are Twists as ackermann controllers read them: ``linear.x = v``,
``angular.z = v tan(delta)/L``; ``v = 0`` gives no steering angle: the wheels stay.
Of m robots: ``pose`` (m, 3) [m, m, rad]; ``velocity`` and ``command`` (m, 2), one column for each of
``AXES``; ``inner`` (m, 2), what ramps: speed [m/s] and steering angle [rad]; ``joints`` (m,) [rad], the
steering angles.

**The controlled point** lies d ahead of the steered wheel's centre, along its direction
``phi = theta + delta``:

    p = (x, y) + L (cos theta, sin theta) + d (cos phi, sin phi).

With the inputs v and delta' its velocity, along and across the steered wheel, is

    p'_t = v/cos(delta),   p'_n = d (v tan(delta)/L + delta').

Proof: the steered wheel's centre rolls along phi; its component along theta is v, so its speed is
v/cos(delta), and p turns about it with ``phi' = theta' + delta'`` at radius d.  The matrix from
(v, delta') to p' has the determinant d/cos(delta): for d > 0 and |delta| < pi/2 every velocity u of the
point has exactly one

    v = u_t cos(delta),   delta' = u_n/d - u_t sin(delta)/L.

Condition: the steering angle has to stay within its limits, which are below pi/2.  It does not where a
car is commanded sideways or backwards: ``phi' = u_n/d`` turns the steered wheel towards u, away from
the heading.  At the limit one input is lost; the car then drives its tightest circle until the wanted
direction lies ahead again, and what theory says of points does not hold meanwhile.

The point ahead of the steered wheel: De Luca, Oriolo and Samson, "Feedback control of a nonholonomic
car-like robot", in Robot Motion Planning and Control (1998), section 3.2.
"""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin, displaced, wrap_angle
from mrs_simulator.vehicles.drives.differential import ride_height  # noqa: F401, as there
from mrs_simulator.vehicles.drives.omnidirectional import is_pushed  # noqa: F401
from mrs_simulator.vehicles.drives.wheel_stand import Stand

AXES = ("linear.x", "angular.z")
LIMIT_AXES = ("linear.x",)  # the turn rate follows from speed and steering angle
MEDIUM = "ground"  # in which the robots move: ground, water or air
SECTION = "wheels"  # of a kind's file
ENCODERS = 2  # distance of the rear axle [m], and angle turned [rad] as motor and servo give it
POINT = "point ahead of the steered wheel"
JOINTS = True  # whether ``joints`` move
OWN_LIMITS = True  # whether there are limits besides the axes': of steering, and backwards
RAMPS = True  # whether inner states ramp towards their targets
CREEP = 1e-6  # [m/s] forwards while a standing car steers: a Twist with v = 0 has none
STEEPEST = 1.5  # [rad] of any steering angle; at pi/2 a car turns about its rear axle
CLOSE = 1e-9  # [rad] to its limit a steering angle is at it


class CarParameters(NamedTuple):
    """Wheel parameters of a kind; of several kinds each number is a column (m,)."""

    wheelbase: float  # [m]
    steering_max: float  # [rad], to either side
    steering_rate: float = np.inf  # [rad/s]
    backward: float = np.inf  # [m/s], greatest speed backwards where it is less than forwards
    radius: float = 0.05  # [m] of the wheels
    track: float = 0.0  # [m] between left and right wheels
    mass_ahead: float = 0.0  # [m] of the centre of mass from the rear axle
    joints: Tuple[str, ...] = ()  # in the kind's model: steering left and right
    torque: float = 6.0  # [N m] of the motor at the rear wheels, together
    friction: float = 0.9  # [-]


COLUMNS = (  # the numbers that the functions below use
    "wheelbase", "steering_max", "steering_rate", "backward", "radius", "torque", "mass_ahead",
)  # fmt: skip


def read(section):
    """Return the ``CarParameters`` in a kind's ``section``, a ``QuantitySection``."""
    wheelbase = section.quantity("wheelbase", "m", above=0.0, high=100.0)
    return CarParameters(
        wheelbase=wheelbase,
        steering_max=section.quantity("steering", "rad", above=0.0, high=STEEPEST),
        steering_rate=_or_none(section, "steering_rate", "rad/s"),
        backward=_or_none(section, "backward", "m/s"),
        radius=section.quantity("radius", "m", above=0.0, high=100.0),
        track=section.quantity("track", "m", above=0.0, high=100.0),
        mass_ahead=section.quantity("mass_ahead", "m", 0.5 * wheelbase, above=0.0, high=wheelbase),
        joints=section.strings("joints", 2)
        if section.has("joints")
        else section.take("joints", ()),
        torque=section.quantity("torque", "N m", 6.0, above=0.0),
        friction=section.quantity("friction", "", 0.9, low=0.0),
    )


def _or_none(section, key, unit):
    """Return the limit ``key``; one that is not given is none."""
    if section.has(key):
        return section.quantity(key, unit, above=0.0)
    return section.take(key, np.inf)


def unlimited(numbers):
    """Return ``numbers`` without limits of steering rate and speed; the steering angle keeps its own."""
    return numbers._replace(steering_rate=np.inf, backward=np.inf)


def _columns(first, second):
    result = np.empty((len(first), 2), order="F")
    result[:, 0], result[:, 1] = first, second
    return result


def twist_of(speed, steering, numbers):
    """Return commands, (m, 2) [m/s, rad/s]: ``(v, v tan(delta)/L)``."""
    steering = np.array(steering)  # without gaps, as in core.kinematics.cos_sin
    return _columns(speed, speed * np.tan(steering) / numbers.wheelbase)


def steering_of(command, joints, numbers):
    """Return the steering angles, (m,) [rad], of ``command`` (m, 2): ``atan(L omega/v)``.

    Where ``v = 0`` the present angle.
    """
    v, asked = command[:, 0], numbers.wheelbase * command[:, 1]
    if np.count_nonzero(v) == len(v):  # quicker than v.all()
        return np.arctan(asked / v)
    moves = v != 0.0
    result = np.array(joints, dtype=float)
    result[moves] = np.arctan(asked[moves] / v[moves])
    return result


def _possible(steering, numbers):
    return _within(steering, -numbers.steering_max, numbers.steering_max)


def _within(value, least, most):
    return np.minimum(np.maximum(value, least), most)


def inner_command(command, joints, numbers):
    """Return the inner states (m, 2) of ``command`` (m, 2): speed and steering angle."""
    return _columns(command[:, 0], steering_of(command, joints, numbers))


def target(command, inner, limits, numbers):
    """Return the inner states (m, 2) to which the firmware ramps: the commanded ones, clipped."""
    return retargeted(_within(command, *bounds(limits, numbers)), command, inner, numbers)


def bounds(limits, numbers):
    """Return the least and the greatest command, (m, 2) each [m/s, rad/s], of which the speed counts."""
    least = np.array(-limits.top, order="F")
    least[..., 0] = -np.minimum(limits.top[..., 0], numbers.backward)
    return least, limits.top


def retargeted(clipped, command, inner, numbers):
    """Return the inner states (m, 2) to which the firmware ramps, by what is ``clipped`` of ``command``.

    The steering angle follows from the command before clipping.
    """
    steering = _possible(steering_of(command, inner[:, 1], numbers), numbers)
    return _columns(clipped[:, 0], steering)


def rates(limits, numbers):
    """Return the ramps' rates, (m, 2): acceleration [m/s^2] and steering rate [rad/s]."""
    result = np.array(limits.acceleration, dtype=float, order="F")
    result[..., 1] = numbers.steering_rate
    return result


def velocities(inner, numbers):
    """Return the velocities (m, 2) along ``AXES`` of ``inner`` states (m, 2)."""
    return twist_of(inner[:, 0], inner[:, 1], numbers)


def joints_of(inner):
    """Return the steering angles (m,) [rad] of ``inner`` states (m, 2)."""
    return inner[:, 1]


def blocked(inner, moved):
    """Return the ``inner`` states (m, 2) of robots that moved by ``moved`` (m, 2) [m/s] in a contact.

    ``moved`` is given in the body's frame.  A car is no faster than its wheels turn, and never goes the
    other way; its turn rate follows its speed.
    """
    result, own = inner.copy(), inner[:, 0]
    share = np.ones(len(own))
    np.divide(moved[:, 0], own, out=share, where=own != 0.0)
    result[:, 0] = own * np.clip(share, 0.0, 1.0)
    return result


def rim_speeds(mean, joints, numbers):
    """Return what is counted, (m, 2): speed [m/s], of a car's rear axle, and turn rate [rad/s]."""
    return mean


def odometry_pose(pose, rolled, joints, numbers):
    """Return the poses (m, 3) by odometry after ``rolled`` (m, 2): distance [m], turn [rad]."""
    return displaced(pose, rolled, 1.0)


def excess(inner, joints, numbers, period):
    """Return by which factor commanded ``inner`` states are beyond limits of the car's own, (m,).

    Of speed backwards, and of the steering rate that brings ``joints`` there within ``period`` [s].
    """
    turn = np.abs(inner[:, 1] - joints)
    return np.maximum(inner[:, 0] / -numbers.backward, turn / (numbers.steering_rate * period))


def at_limits(command, top, numbers, share):
    """Return where a ``command`` (..., m, 2) has reached ``share`` of its limits, (..., m) bool.

    Of speed, turn rate and steering angle; the steering rate shows in no single command.
    """
    v, omega = command[..., 0], command[..., 1]
    fast = v >= share * top[..., 0]
    fast |= -v >= share * np.minimum(numbers.backward, top[..., 0])
    # |tan(delta)| >= tan(share delta_max), also at v = 0 and omega = 0
    steepest = np.tan(share * numbers.steering_max)
    steered = (omega != 0.0) & (np.abs(numbers.wheelbase * omega) >= steepest * np.abs(v))
    return fast | steered | (np.abs(omega) >= share * top[..., 1])


def slowed(inner, factor, joints, numbers):
    """Return the commands (m, 2) of ``inner`` (m, 2) with speed and steering rate divided by
    ``factor``, a number or (m,).

    The point moves in the same direction, more slowly: the commanded steering angle comes nearer to the
    present one.  (The Twist over the factor would have the same angle.)  Then, and only then, it is
    clipped to what the wheels can do.
    """
    wanted = joints + (inner[:, 1] - joints) / factor
    return twist_of(inner[:, 0] / factor, _possible(wanted, numbers), numbers)


def stand(joints, numbers):
    """Return the ``Stand`` of the cars on a rear wheel, which is driven, and a steered front wheel.

    The bicycle of the kinematic model: each stands for the two wheels of its axle.
    """
    cos, sin = cos_sin(joints)
    wheelbase, m = numbers.wheelbase, len(joints)
    along, across = np.zeros((m, 2, 3)), np.zeros((m, 2, 3))
    along[:, 0, 0] = across[:, 0, 1] = 1.0
    along[:, 1] = np.stack([cos, sin, wheelbase * sin], axis=-1)
    across[:, 1] = np.stack([-sin, cos, wheelbase * cos], axis=-1)
    weight, push = np.empty((m, 2)), np.zeros((m, 2))
    weight[:, 1] = numbers.mass_ahead / wheelbase
    weight[:, 0] = 1.0 - weight[:, 1]
    push[:, 0] = numbers.torque / numbers.radius
    return Stand(along, across, weight, push, np.broadcast_to(numbers.mass_ahead, (m,)))


def rim_targets(velocity, joints, numbers):
    """Return the speeds (m, 2) [m/s] at which motors hold the rims: of the rear wheel; the front runs."""
    result = np.zeros((len(velocity), 2))
    result[:, 0] = velocity[:, 0]
    return result


def counted(turning, joints, numbers):
    """Return what the encoders count per second, (m, 2) [m/s, rad/s], of rims ``turning`` (m, 2)."""
    return twist_of(turning[:, 0], joints, numbers)


def joints_after(command, joints, numbers, period):
    """Return the steering angles (m,) [rad] after ``period`` [s] of ``command`` (m, 2)."""
    reach = numbers.steering_rate * period
    asked = _possible(steering_of(command, joints, numbers), numbers)
    return joints + _within(asked - joints, -reach, reach)


def lead(l, numbers):
    """Return how far [m] the controlled point is from the rear axle's centre at most."""
    return numbers.wheelbase + l


def arm(l, numbers):
    """Return how far [m] the controlled point is ahead of the steered wheel, in its direction."""
    return l


def pivot(numbers):
    """Return how far [m] ahead of the centre the steered wheel's is, about which the point turns."""
    return numbers.wheelbase


def joints_seen(pose, point, l, numbers):
    """Return the steering angles (m,) [rad] of cars at ``pose`` (m, 3) with points ``point`` (m, 2)."""
    cos, sin = cos_sin(pose[:, 2])
    x = point[:, 0] - pose[:, 0] - numbers.wheelbase * cos
    y = point[:, 1] - pose[:, 1] - numbers.wheelbase * sin
    return wrap_angle(np.arctan2(y, x) - pose[:, 2])


def inputs(along, across, joints, l, numbers):
    """Return speed [m/s] and steering rate [rad/s], (m,) each, that move the points ``along`` and
    ``across`` the steered wheels, (m,) [m/s]: the mapping derived above."""
    return _inputs(along, across, *cos_sin(joints), l, numbers)


def _inputs(along, across, cos, sin, l, numbers):
    return along * cos, across / l - along * sin / numbers.wheelbase


def point_velocity(speed, rate, joints, l, numbers):
    """Return the points' velocities along and across the steered wheels, (m,) [m/s]; undoes ``inputs``."""
    cos, sin = cos_sin(joints)
    along = speed / cos
    return along, l * (along * sin / numbers.wheelbase + rate)


def wanted(along, across, joints, l, period, numbers):
    """Return the inner states (m, 2), speed and steering angle, that move the points ``along`` and
    ``across`` the steered wheels, (m,) [m/s], over ``period`` [s].

    The commanded steering angle is ``delta + delta' period``, which may be more than the wheels can do
    until ``slowed``.  A car that cannot steer further drives forwards along its tightest circle, as fast
    as the point is wanted to move, until the wanted direction lies ahead.
    """
    cos, sin = cos_sin(joints)
    speed, rate = _inputs(along, across, cos, sin, l, numbers)
    steering, limit = joints + rate * period, numbers.steering_max - CLOSE
    if np.count_nonzero(np.abs(steering) >= limit):  # else nothing below changes anything
        steering, at_limit = _within(steering, -STEEPEST, STEEPEST), np.abs(joints) >= limit
        stuck = at_limit & (rate * joints > 0.0)
        np.copyto(steering, joints, where=stuck)
        np.multiply(np.hypot(along, across), cos, out=speed, where=stuck)
    if np.count_nonzero(speed) < len(speed):
        speed[(speed == 0.0) & (steering != joints)] = CREEP
    return _columns(speed, steering)


def command(along, across, joints, l, period, numbers):
    """Return the commands (m, 2) of what is :func:`wanted`."""
    return velocities(wanted(along, across, joints, l, period, numbers), numbers)


def velocity(command, joints, l, period, numbers):
    """Return the points' mean velocities along and across the steered wheels, (m,) [m/s], under ``command``
    (m, 2) held for ``period`` [s]."""
    rate = (steering_of(command, joints, numbers) - joints) / period
    return point_velocity(command[:, 0], rate, joints, l, numbers)
