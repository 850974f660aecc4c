"""What each drive makes of a velocity of its point, and how it moves, written a second time for verdicts.

Nothing is shared with ``vehicles.drives``, whose functions drive the robots, but the numbers of the
kinds.  Robots are complex numbers here: ``z`` (m,) [m] the centre, ``theta`` (m,) [rad] the heading,
``steered`` (m,) [rad] the steering angle of a car, else 0.
"""

import math

import numpy as np

from mrs_simulator.core.kinematics import max_of_rows, phase_of
from mrs_simulator.vehicles.drives import car, differential, omnidirectional, quadrotor, vessel

SMALL = 1e-9  # [rad] of a turn, below which an arc is a straight line to rounding
CREEP = 1e-6  # [m/s] that conveys a standing car's steering angle
STEEPEST = 1.5  # [rad] that a Twist may ask of a steering angle
CLOSE = 1e-9  # [rad] within which a steering angle has reached its limit


class Unicycles:
    """Differential drives: ``z' = v e^{i theta}``, ``theta' = omega``; the point is ``z + l e^{i theta}``.

    Its velocity is ``p' = (v + i l omega) e^{i theta}``, so that ``v + i l omega = u e^{-i theta}``.
    Several teams at once have further axes in front, but for :meth:`lags`.
    """

    _ahead = None, None  # headings, and e^{i theta} of these

    def __init__(self, group, l, period):
        """``group``: a ``vehicles.team.Group``; ``l`` [m]; ``period`` [s] between two commands."""
        self.group, self.l, self.period = group, l, period
        self.numbers, self.top = group.numbers, group.limits.top
        self.acceleration = group.limits.acceleration
        if np.isinf(self.acceleration).all():
            self.acceleration = np.inf

    def be(self, z, theta, steered):
        """Be at rest at ``z`` (m,) [m], ``theta`` (m,) [rad], steered by ``steered`` (m,) [rad]."""
        self.z, self.theta, self.steered = z, theta, steered
        self.velocity = np.zeros(z.shape + (self.top.shape[-1],))

    def speed_up(self, twist, climb):
        """Be as fast as body ``twist`` (m, 3) [m/s, m/s, rad/s]; ``climb`` (m,) [m/s] upwards, or None."""
        self.velocity = twist[:, ::2].copy()

    @property
    def is_ramped(self):
        """Return whether speeds change in ramps, so that motion is reckoned step by step."""
        return bool(np.isfinite(self.acceleration).any())

    @property
    def ahead(self):
        """Return ``e^{i theta}``, (m,) complex, made once of the headings that robots have."""
        if self._ahead[0] is not self.theta:
            self._ahead = self.theta, np.exp(1j * self.theta)
        return self._ahead[1]

    def points(self):
        """Return the controlled points, (m,) complex [m]."""
        return self.z + self.l * self.ahead

    def angles_at(self, points, z, theta):
        """Return the steering angles (m,) [rad] with which the points are at ``points`` (m,)."""
        return np.zeros(z.shape)

    def commands(self, u):
        """Return the commands (m, a) that give the points the velocities ``u`` (m,) complex [m/s]."""
        ahead = u * self.ahead.conj()
        result = ahead.view(float).reshape(ahead.shape + (2,))
        result[..., 1] /= self.l
        return result

    def velocities(self, command):
        """Return the points' mean velocities, (m,) complex [m/s], while ``command`` is held."""
        return (command[..., 0] + 1j * self.l * command[..., 1]) * self.ahead

    def is_full(self):
        """Return whether an inner joint is at its limit, (m,) bool or False for all."""
        return False

    def sizes(self, command):
        """Return how fast ``command`` (m, a), or a difference of two, moves the points, (m,) [m/s]."""
        return np.hypot(command[..., 0], self.l * command[..., 1])

    def twists(self, command):
        """Return the commands (m, a) for ``(v, omega)``, (m, 2)."""
        return command

    def unicycle(self, command):
        """Return ``(v, omega)``, (m, 2), of commands (m, a); undoes :meth:`twists`."""
        return command

    def excess(self, command):
        """Return by which factor each ``command`` (m, a) is beyond a limit, (m,)."""
        return max_of_rows(np.abs(command) / self.top)

    def slowed(self, command, factor):
        """Return ``command`` (m, a) that moves the points the same way, ``factor`` (m,) more slowly."""
        return command / factor[..., np.newaxis]

    def obeyed(self, command):
        """Return ``command`` (m, a) as the firmware takes it: each axis up to its limit."""
        return np.minimum(np.maximum(command, -self.top), self.top)

    def is_steady(self, command):
        """Return whether nothing changes any more under ``command`` (m, a)."""
        return not self.lags(command).any()

    def lags(self, command):
        """Return which robots have not reached the speeds of ``command`` (m, a) yet, (m,) bool."""
        return (self.velocity != self.obeyed(command)).any(axis=-1)

    def move(self, command, duration):
        """Move for ``duration`` [s] under ``command`` (m, a)."""
        self.velocity, mean = reached(
            self.velocity, self.obeyed(command), self.acceleration, duration
        )
        self._along(mean[..., 0], mean[..., 1], duration)

    def _along(self, v, omega, duration):
        """Move on arcs of circles at speeds ``v`` (m,), complex in the body, and ``omega`` (m,)."""
        turn = omega * duration
        slow = np.abs(turn) < SMALL
        chord = (np.exp(1j * turn) - 1.0) / (1j * np.where(slow, 1.0, turn))
        chord[slow] = 1.0 + 0.5j * turn[slow]
        self.z = self.z + v * duration * chord * self.ahead
        self.theta = self.theta + turn


class Bases(Unicycles):
    """Omnidirectional bases: ``z' = w e^{i theta}``, ``w = vx + i vy``; the point is ``z`` itself.

    The law leaves the heading alone: ``w = u e^{-i theta}``, ``omega = 0``.
    """

    def speed_up(self, twist, climb):
        """As ``Unicycles``, along both axes."""
        self.velocity = twist.copy()

    def points(self):
        """Return the centres, (m,) complex [m]."""
        return self.z

    def commands(self, u):
        """Return ``(vx, vy, 0)``, (m, 3)."""
        w = u * self.ahead.conj()
        return np.stack([w.real, w.imag, np.zeros(len(w))], axis=1)

    def velocities(self, command):
        """Return the centres' velocities, (m,) complex [m/s], while ``command`` is held."""
        return (command[:, 0] + 1j * command[:, 1]) * self.ahead

    def sizes(self, command):
        """Return the speeds (m,) [m/s] of ``command`` (m, 3): of the centre, or of ``l`` beside it."""
        return np.sqrt(command[:, 0] ** 2 + command[:, 1] ** 2 + (self.l * command[:, 2]) ** 2)

    def twists(self, command):
        return np.stack([command[:, 0], np.zeros(len(command)), command[:, 1]], axis=1)

    def unicycle(self, command):
        """Return ``(vx, omega)``, (m, 2)."""
        return command[:, ::2]

    def _rims(self, command):
        """Return the greatest speed (m,) [m/s] of a rim, a row of ``rolling`` times the twist."""
        rolling = np.broadcast_to(np.asarray(self.numbers.rolling), (len(command), 4, 3))
        return np.abs((rolling * command[:, np.newaxis]).sum(axis=2)).max(axis=1)

    def excess(self, command):
        """Return by which factor each ``command`` (m, 3) is beyond a limit of an axis or a rim, (m,)."""
        return np.maximum(super().excess(command), self._rims(command) / self.numbers.rim_max)

    def obeyed(self, command):
        """Return ``command`` (m, 3), each axis up to its limit, then all slowed for the fastest rim."""
        clipped = super().obeyed(command)
        return self.slowed(clipped, np.maximum(self._rims(clipped) / self.numbers.rim_max, 1.0))

    def move(self, command, duration):
        self.velocity, mean = reached(
            self.velocity, self.obeyed(command), self.acceleration, duration
        )
        self._along(mean[:, 0] + 1j * mean[:, 1], mean[:, 2], duration)


class Cars(Unicycles):
    """Cars: ``z' = v e^{i theta}``, ``theta' = v tan(delta)/L``, the steering rate an input of its own.

    The point is ``p = z + e^{i theta}(L + l e^{i delta})``, so that

        e^{-i theta} p' = v (1 + i tan(delta) + i (l/L) tan(delta) e^{i delta}) + delta' i l e^{i delta},

    two real equations for ``v`` and ``delta'``.  A steering angle at its limit, asked for more, stays,
    and the car drives on as fast as the steered wheel would have to.
    """

    bent = False  # whether an angle was commanded that no Twist expresses

    def speed_up(self, twist, climb):
        """As ``Unicycles``, along; the rest follows from the steering angle."""
        self.velocity = twist[:, :1].copy()

    @property
    def is_ramped(self):
        """Return whether speeds or steering angles change step by step."""
        return super().is_ramped or bool(np.isfinite(self.numbers.steering_rate).any())

    def points(self):
        """Return the points ``l`` ahead of the steered wheels, (m,) complex [m]."""
        ahead = self.numbers.wheelbase + self.l * np.exp(1j * self.steered)
        return self.z + ahead * self.ahead

    def angles_at(self, points, z, theta):
        return phase_of((points - z) * np.exp(-1j * theta) - self.numbers.wheelbase)

    def _columns(self):
        """Return what ``v`` and ``delta'`` each do to the points, (m,) complex, in the bodies' frames."""
        tan, turned = np.tan(self.steered), np.exp(1j * self.steered)
        return 1.0 + 1j * tan * (
            1.0 + self.l / self.numbers.wheelbase * turned
        ), 1j * self.l * turned

    def commands(self, u):
        """Return ``(v, v tan(delta + delta' period)/L)``, (m, 2)."""
        w, (by_speed, by_steering) = u * self.ahead.conj(), self._columns()
        # Cramer's rule; Im(conj(a) b) is the determinant of the columns a and b.
        both = (by_speed.conj() * by_steering).imag
        v = (w.conj() * by_steering).imag / both
        rate = (by_speed.conj() * w).imag / both
        wanted = self.steered + rate * self.period
        self.bent = np.abs(wanted) > STEEPEST
        wanted = np.clip(wanted, -STEEPEST, STEEPEST)
        full = np.abs(self.steered) >= self.numbers.steering_max - CLOSE
        full &= rate * self.steered > 0.0
        wanted = np.where(full, self.steered, wanted)
        v = np.where(full, np.abs(u) * np.cos(self.steered), v)
        v = np.where((v == 0.0) & (wanted != self.steered), CREEP, v)
        return self._twist(v, wanted)

    def _twist(self, v, steering):
        return np.stack([v, v * np.tan(steering) / self.numbers.wheelbase], axis=1)

    def _asked(self, command):
        """Return the steering angles (m,) [rad] that ``command`` (m, 2) asks for; at rest the present."""
        v, omega = command.T
        goes = v != 0.0
        asked = np.arctan(self.numbers.wheelbase * omega / np.where(goes, v, 1.0))
        return np.where(goes, asked, self.steered)

    def velocities(self, command):
        rate = (self._asked(command) - self.steered) / self.period
        by_speed, by_steering = self._columns()
        return (command[:, 0] * by_speed + rate * by_steering) * self.ahead

    def is_full(self):
        """Return whether the steering angle, or that last asked for, is at its limit, (m,) bool."""
        return self.bent | (np.abs(self.steered) >= self.numbers.steering_max - CLOSE)

    def sizes(self, command):
        """Return the speeds (m,) [m/s] of ``command`` (m, 2), at most: of the point straight ahead."""
        return np.hypot(command[:, 0], (self.numbers.wheelbase + self.l) * command[:, 1])

    def excess(self, command):
        """Return by which factor each ``command`` (m, 2) is beyond a limit of speed or steering rate."""
        v, top = command[:, 0], self.top[..., 0]
        back = np.minimum(top, self.numbers.backward)
        speed = np.maximum(v / top, -v / back)
        rate = np.abs(self._asked(command) - self.steered) / self.period
        turn = np.abs(command[:, 1]) / self.top[..., 1]
        return np.maximum(np.maximum(speed, turn), rate / self.numbers.steering_rate)

    def slowed(self, command, factor):
        """Return ``command`` (m, 2) with speed and steering rate ``factor`` (m,) times less.

        Of the steering angle then what the wheels can do.
        """
        most = self.numbers.steering_max
        wanted = self.steered + (self._asked(command) - self.steered) / factor
        return self._twist(command[:, 0] / factor, np.clip(wanted, -most, most))

    def is_steady(self, command):
        """Return False: a car is asked for another angle with each command."""
        return False

    def lags(self, command):
        """Return which cars have not reached speed and steering angle of ``command`` yet, (m,) bool."""
        target, asked = self._targets(command)
        return (self.velocity[:, 0] != target) | (np.abs(self.steered - asked) > CLOSE)

    def _targets(self, command):
        """Return speeds [m/s] and angles [rad], (m,) each, that ``command`` (m, 2) asks wheels for."""
        top, most = self.top[..., 0], self.numbers.steering_max
        speed = np.clip(command[:, 0], -np.minimum(top, self.numbers.backward), top)
        return speed, np.clip(self._asked(command), -most, most)

    def _along_axis(self):
        return self.acceleration if np.isscalar(self.acceleration) else self.acceleration[..., 0]

    def move(self, command, duration):
        target, asked = self._targets(command)
        speed, mean = reached(self.velocity[:, 0], target, self._along_axis(), duration)
        steered, between = reached(self.steered, asked, self.numbers.steering_rate, duration)
        self.velocity = speed[:, np.newaxis]
        self._along(mean, mean * np.tan(between) / self.numbers.wheelbase, duration)
        self.steered = steered


class Boats(Unicycles):
    """Vessels without forces, in still water: unicycles whose u and r follow ``e' = -e/T``.

    T is ``(M + k_d)/(d + k_p)``, and no speed changes faster than its axis allows; the point lies ``l``
    ahead of the bow.
    """

    is_ramped = True

    def __init__(self, group, l, period):
        """As ``Unicycles``."""
        super().__init__(group, group.numbers.point + l, period)
        rows = {
            key: np.reshape(getattr(self.numbers, key), (-1,) + shape)
            for key, shape in (("inertia", (4,)), ("linear", (3,)), ("gains", (2, 4)))
        }
        held = rows["inertia"][:, [0, 2]] + rows["gains"][:, :, 3]
        self.times = held / (rows["linear"][:, [0, 2]] + rows["gains"][:, :, 1])

    def excess(self, command):
        back = -command[:, 0] / self.numbers.backward
        return np.maximum(super().excess(command), back)

    def obeyed(self, command):
        """Return ``command`` (m, 2), each axis up to its limit, backwards up to that."""
        result = super().obeyed(command)
        result[:, 0] = np.maximum(result[:, 0], -self.numbers.backward)
        return result

    def is_steady(self, command):
        """Return False: they come ever nearer."""
        return False

    def lags(self, command):
        return (np.abs(self.velocity - self.obeyed(command)) > CLOSE).any(axis=1)

    def move(self, command, duration):
        self.velocity, mean = approached(
            self.velocity, self.obeyed(command), self.acceleration, self.times, duration
        )
        self._along(mean[:, 0], mean[:, 1], duration)


class Quadrotors(Bases):
    """Quadrotors without forces: ``z' = V``, ``V' = (w e^{i theta} - V)/T`` up to the tilt.

    The tilt allows ``|V'| = 9.81 tan(tilt_max)``.  Heights h obey ``h'' = (w_z - h')/T_z`` apart from that,
    upwards with at most 0.8 of what four rotors at full speed have left, ``4 k W^2/m - 9.81``, downwards
    with at most half of 9.81.  The law leaves the heading alone.
    """

    is_ramped = True

    def be(self, z, theta, steered):
        """Be at rest at ``z`` (m,) [m], ``theta`` (m,) [rad]."""
        super().be(z, theta, steered)
        self.velocity = np.zeros(len(z), dtype=complex)
        self.height, self.rise = np.zeros(len(z)), np.zeros(len(z))

    def speed_up(self, twist, climb):
        """As ``Unicycles``, in the common frame, and upwards."""
        self.velocity = (twist[:, 0] + 1j * twist[:, 1]) * self.ahead
        self.rise = np.zeros(len(twist)) if climb is None else climb.copy()

    def begin_at(self, height):
        """Be at ``height`` (m,) [m]."""
        self.height = height

    def _complex(self, command):
        return command[:, 0] + 1j * command[:, 1]

    def commands(self, u):
        return np.concatenate([super().commands(u), np.zeros((len(u), 1))], axis=1)

    def sizes(self, command):
        return np.sqrt((command[:, :3] ** 2).sum(axis=1) + (self.l * command[:, 3]) ** 2)

    def twists(self, command):
        result = np.zeros((len(command), 4))
        result[:, [0, 3]] = command
        return result

    def unicycle(self, command):
        return command[:, [0, 3]]

    def excess(self, command):
        return (np.abs(command) / self.top).max(axis=1)

    def obeyed(self, command):
        """Return ``command`` (m, 4), its velocity slowed as a whole, the turn rate up to its limit."""
        factor = np.maximum((np.abs(command) / self.top)[:, :3].max(axis=1), 1.0)
        result = self.slowed(command, factor)
        most = self.top[..., 3]
        result[:, 3] = np.clip(command[:, 3], -most, most)
        return result

    def is_steady(self, command):
        """Return False: they come ever nearer."""
        return False

    def lags(self, command):
        command_obeyed = self.obeyed(command)
        wanted = self._complex(command_obeyed) * self.ahead
        away = np.maximum(np.abs(self.velocity - wanted), np.abs(self.rise - command_obeyed[:, 2]))
        return away > CLOSE

    def move(self, command, duration):
        command_obeyed = self.obeyed(command)
        turn = command_obeyed[:, 3] * duration
        wanted = self._complex(command_obeyed) * np.exp(1j * (self.theta + 0.5 * turn))
        error = wanted - self.velocity
        size = np.abs(error)
        along = np.where(size > 0.0, error / np.maximum(size, 1e-300), 1.0)
        most = 9.81 * np.tan(self.numbers.tilt_max)
        time = np.reshape(self.numbers.response, (-1, 3))[:, 0]
        left, mean = approached(size, np.zeros(len(size)), most, time, duration)
        self.velocity = wanted - left * along
        self.z = self.z + duration * (wanted - mean * along)
        self.theta = self.theta + turn
        self._climb(command_obeyed[:, 2], duration)

    def _climb(self, wanted, duration):
        """Climb for ``duration`` [s] towards the speed ``wanted`` (m,) [m/s]."""
        numbers = self.numbers
        thrust = 4.0 * np.reshape(numbers.effect, (-1, 4))[:, 0] * numbers.speed_max**2
        up = 0.8 * (thrust / numbers.mass - 9.81)
        most = np.where(wanted > self.rise, up, 0.5 * 9.81)
        time = np.reshape(numbers.response, (-1, 3))[:, 2]
        self.rise, mean = approached(self.rise, wanted, most, time, duration)
        self.height = self.height + duration * mean


STATED = {
    differential: Unicycles,
    omnidirectional: Bases,
    car: Cars,
    vessel: Boats,
    quadrotor: Quadrotors,
}


def approached(value, target, rate, time, duration):
    """Return ``value`` after ``duration`` [s] of ``e' = -e/time``, at most ``rate``, and its mean.

    ``e = target - value``: a ramp until ``|e| = rate time``, from then on exponentially.
    """
    rate = np.minimum(rate, 1e12)
    error = target - value
    ramp = np.minimum(np.maximum(np.abs(error) / rate - time, 0.0), duration)
    after = value + np.sign(error) * rate * ramp
    left, rest = target - after, duration - ramp
    end = target - left * np.exp(-rest / np.maximum(time, 1e-12))
    # The integral of an exponential is what it loses, times its time.
    way = 0.5 * (value + after) * ramp + target * rest - time * (end - after)
    return end, way / duration


def reached(value, target, rate, duration):
    """Return ``value`` after a ramp to ``target`` at ``rate`` for ``duration`` [s], and its mean."""
    if np.isscalar(rate) and math.isinf(rate):
        return target, target
    gap = target - value
    with np.errstate(invalid="ignore", divide="ignore"):
        needed = np.where(gap == 0.0, 0.0, np.abs(gap) / rate)  # [s] until it is there
        change = np.where(needed > duration, np.sign(gap) * rate * duration, gap)
    ramping = np.minimum(needed, duration)
    # Along the ramp the mean is half the change, after it all of it.
    return value + change, value + change * (1.0 - 0.5 * ramping / duration)
