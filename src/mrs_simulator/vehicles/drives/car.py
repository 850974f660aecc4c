"""Car-like robots: the bicycle model about the rear axle.

    x' = v cos(theta),  y' = v sin(theta),  theta' = v tan(delta)/L,

(x, y) the rear axle's centre, v its speed, delta the steering angle (positive to the left), L the
wheelbase.  Commands are Twists as ackermann controllers read them: ``linear.x = v``,
``angular.z = v tan(delta)/L``; at ``v = 0`` the steering angle is not told and the wheels stay.
Of m robots: ``pose`` (m, 3) [m, m, rad]; ``velocity`` and ``command`` (m, 2), one column for each of
``AXES``; ``joints`` (m,) [rad], the steering angles.

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
car is told to go beside or behind itself: ``phi' = u_n/d`` turns the steered wheel towards u, away from
the heading.  At the limit one input is lost; the car then drives its tightest circle until the wanted
direction lies ahead again, and what theory says of points does not hold meanwhile.

The point ahead of the steered wheel: De Luca, Oriolo and Samson, "Feedback control of a nonholonomic
car-like robot", in Robot Motion Planning and Control (1998), section 3.2.
"""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import arc, cos_sin, ramp, wrap_angle
from mrs_simulator.vehicles.drives.differential import farthest, fill_twist, top_speed  # noqa: F401
from mrs_simulator.vehicles.drives.stand import Stand

AXES = ("linear.x", "angular.z")
LIMIT_AXES = ("linear.x",)  # the turn rate follows from speed and steering angle
MEDIUM = "ground"  # in which the robots move: ground, water or air
SECTION = "wheels"  # of a kind's file
ENCODERS = 2  # distance of the rear axle [m], and angle turned [rad] as motor and servo give it
POINT = "point ahead of the steered wheel"
JOINTS = True  # whether ``joints`` move
CREEP = 1e-6  # [m/s] forwards while a standing car steers: at v = 0 a Twist tells no steering angle
STEEPEST = 1.5  # [rad] of any steering angle; at pi/2 a car turns about its rear axle
CLOSE = 1e-9  # [rad] to its limit a steering angle is at it


class Numbers(NamedTuple):
    """What a kind tells of its wheels; of several kinds each number is a column (m,)."""

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
    """Return the ``Numbers`` in a kind's ``section``, a ``QuantitySection``."""
    wheelbase = section.quantity("wheelbase", "m", above=0.0, high=100.0)
    return Numbers(
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


def least_radius(numbers):
    """Return the least turning radius [m] of the rear axle's centre: ``L/tan(delta_max)``."""
    return numbers.wheelbase / np.tan(numbers.steering_max)


def twist_of(speed, steering, numbers):
    """Return commands, (m, 2) [m/s, rad/s]: ``(v, v tan(delta)/L)``."""
    result = np.empty((len(speed), 2), order="F")
    result[:, 0] = speed
    result[:, 1] = speed * np.tan(steering) / numbers.wheelbase
    return result


def steering_of(command, joints, numbers):
    """Return the steering angles, (m,) [rad], that ``command`` (m, 2) asks for: ``atan(L omega/v)``.

    Where ``v = 0`` the present angle.
    """
    v, asked = command[:, 0], numbers.wheelbase * command[:, 1]
    if np.logical_and.reduce(v):
        return np.arctan(asked / v)
    ratio = np.zeros(len(command))
    np.divide(asked, v, out=ratio, where=v != 0.0)
    return np.where(v != 0.0, np.arctan(ratio), joints)


def _possible(steering, numbers):
    return _within(steering, -numbers.steering_max, numbers.steering_max)


def _within(value, least, most):
    return np.minimum(np.maximum(value, least), most)


def move(pose, velocity, joints, command, limits, numbers, step):
    """Return velocity (m, 2), joints (m,), mean velocity (m, 2) and pose (m, 3) after ``step`` [s].

    The speed is clipped and ramps by ``limits``; the steering angle asked for is approached at the
    steering rate.  The pose follows the arc of the mean speed and the mean steering angle, exact while
    both hold.
    """
    velocity, joints, mean = ramped(velocity, joints, command, limits, numbers, step)
    after = arc(pose, mean, step)
    after[:, 2] = wrap_angle(after[:, 2])
    return velocity, joints, mean, after


def ramped(velocity, joints, command, limits, numbers, step):
    """Return velocity (m, 2), joints (m,) and mean velocity (m, 2) after ``step`` [s]: ``move`` but for
    the pose."""
    top, acceleration = limits.top[..., 0], limits.acceleration[..., 0]
    wanted = _within(command[:, 0], -np.minimum(top, numbers.backward), top)
    speed, mean_speed = ramp(velocity[:, 0], wanted, acceleration, step)
    asked = _possible(steering_of(command, joints, numbers), numbers)
    steering, mean_steering = ramp(joints, asked, numbers.steering_rate, step)
    mean = twist_of(mean_speed, mean_steering, numbers)
    return twist_of(speed, steering, numbers), steering, mean


def blocked(velocity, moved):
    """Return the velocities (m, 2) of robots that a contact let move by ``moved`` (m, 2) [m/s].

    ``moved`` is given in the body's frame.  A car is no faster than its wheels turn, and never goes the
    other way; its turn rate follows its speed.
    """
    own = velocity[:, 0]
    share = np.ones(len(own))
    np.divide(moved[:, 0], own, out=share, where=own != 0.0)
    return velocity * np.clip(share, 0.0, 1.0)[:, np.newaxis]


def rim_speeds(mean, joints, numbers):
    """Return what the encoders count, (m, 2): speed of the rear axle [m/s] and turn rate [rad/s]."""
    return mean


def reckoned(pose, rolled, joints, numbers):
    """Return the poses (m, 3) that odometry makes of ``rolled`` (m, 2): distance [m], turn [rad]."""
    after = arc(pose, rolled, 1.0)
    after[:, 2] = wrap_angle(after[:, 2])
    return after


def excess(command, joints, top, numbers, period):
    """Return by which factor each ``command`` (m, 2) is beyond the limits, (m,); up to 1 within.

    ``top`` (2,) or (m, 2): of speed and, if finite, turn rate.  The steering rate is that which brings
    ``joints`` to the angle asked for within ``period`` [s].
    """
    v, omega = command[:, 0], command[:, 1]
    ahead, back = v / top[..., 0], v / -np.minimum(numbers.backward, top[..., 0])
    turn = np.abs(steering_of(command, joints, numbers) - joints)
    share = np.maximum(np.maximum(ahead, back), np.abs(omega) / top[..., 1])
    return np.maximum(share, turn / (numbers.steering_rate * period))


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


def slowed(command, factor, joints, numbers):
    """Return ``command`` (m, 2) with speed and steering rate divided by ``factor``, a number or (m,).

    The point moves in the same direction, more slowly: the steering angle asked for comes nearer to the
    present one.  (The Twist over the factor would ask for the same angle.)  Then, and only then, it is
    clipped to what the wheels can do.
    """
    wanted = joints + (steering_of(command, joints, numbers) - joints) / factor
    return twist_of(command[:, 0] / factor, _possible(wanted, numbers), numbers)


def ride_height(numbers):
    """Return the height [m] of the model's base_link above the ground: that of the axles."""
    return numbers.radius


def is_pushed(numbers):
    """Return whether, in motion with forces, wheel forces of ``stand`` push the body: always."""
    return True


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


def point(pose, joints, l, numbers):
    """Return the points ``l`` [m] ahead of the steered wheels, (..., m, 2) [m]."""
    wheelbase = numbers.wheelbase
    cos, sin = cos_sin(pose[..., 2])
    cos_wheel, sin_wheel = cos_sin(pose[..., 2] + joints)
    result = np.empty(pose.shape[:-1] + (2,), order="F")
    result[..., 0] = pose[..., 0] + wheelbase * cos + l * cos_wheel
    result[..., 1] = pose[..., 1] + wheelbase * sin + l * sin_wheel
    return result


def joints_seen(pose, point, l, numbers):
    """Return the steering angles (m,) [rad] of cars at ``pose`` (m, 3) with points ``point`` (m, 2)."""
    cos, sin = cos_sin(pose[:, 2])
    x = point[:, 0] - pose[:, 0] - numbers.wheelbase * cos
    y = point[:, 1] - pose[:, 1] - numbers.wheelbase * sin
    return wrap_angle(np.arctan2(y, x) - pose[:, 2])


def inputs(velocity, pose, joints, l, numbers):
    """Return speed [m/s] and steering rate [rad/s], (m,) each, that move the points with ``velocity``
    (m, 2) [m/s] of the common frame: the mapping derived above."""
    cos, sin = cos_sin(pose[:, 2] + joints)
    along = cos * velocity[:, 0] + sin * velocity[:, 1]
    across = cos * velocity[:, 1] - sin * velocity[:, 0]
    cos_steering, sin_steering = cos_sin(joints)
    return along * cos_steering, across / l - along * sin_steering / numbers.wheelbase


def point_velocity(speed, rate, pose, joints, l, numbers):
    """Return the points' velocity, (m, 2) [m/s], under speeds and steering rates; undoes ``inputs``."""
    cos_steering, sin_steering = cos_sin(joints)
    along = speed / cos_steering
    across = l * (along * sin_steering / numbers.wheelbase + rate)
    cos, sin = cos_sin(pose[:, 2] + joints)
    result = np.empty((len(pose), 2), order="F")
    result[:, 0] = cos * along - sin * across
    result[:, 1] = sin * along + cos * across
    return result


def command(velocity, pose, joints, l, period, numbers):
    """Return the commands, (m, 2), for the points' ``velocity`` (m, 2) [m/s] over ``period`` [s].

    The steering angle asked for is ``delta + delta' period``, which may be more than the wheels can do
    until ``slowed``.  A car that cannot steer further drives forwards along its tightest circle, as fast
    as the point is wanted to move, until the wanted direction lies ahead.
    """
    speed, rate = inputs(velocity, pose, joints, l, numbers)
    at_limit = np.abs(joints) >= numbers.steering_max - CLOSE
    stuck = at_limit & (np.sign(rate) == np.sign(joints))
    steering = np.where(stuck, joints, _within(joints + rate * period, -STEEPEST, STEEPEST))
    speed = np.where(stuck, np.hypot(velocity[:, 0], velocity[:, 1]) * np.cos(joints), speed)
    speed = np.where((speed == 0.0) & (steering != joints), CREEP, speed)
    return twist_of(speed, steering, numbers)


def velocity(command, pose, joints, l, period, numbers):
    """Return the points' mean velocity, (m, 2) [m/s], under ``command`` (m, 2) held for ``period`` [s]."""
    rate = (steering_of(command, joints, numbers) - joints) / period
    return point_velocity(command[:, 0], rate, pose, joints, l, numbers)
