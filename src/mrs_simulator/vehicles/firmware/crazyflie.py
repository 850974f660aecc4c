"""The Crazyflie's commander, as crazyswarm speaks to it: setpoints and planned flights.

Units, signs and frames are those of the firmware (bitcraze/crazyflie-firmware, crtp_commander_*.c) as the
crazyswarm server of 2022 fills its packets: the yaw rate of ``hover`` and ``velocity_world`` is in deg/s
and
positive clockwise, that of ``attitude`` counter-clockwise, the yaw of ``position`` is in degrees, that of
``go_to`` in radians, whatever the comment in GoTo.srv says.  Planned flights follow polynomials of seventh
degree at rest at their ends; take-off and landing turn to yaw 0, as the firmware's do.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.vehicles.drives.rotors import greatest_thrust
from mrs_simulator.vehicles.firmware import flying

DEGREES = math.pi / 180.0
LEAST_THRUST, MOST_THRUST, FULL = 1000.0, 60000.0, 65535.0  # of cmd_vel: cut off, clipped, all
COEFFICIENTS = 8  # of a piece of a trajectory, from that of 1 on
MOST_PIECES = 31  # that its memory holds
SETPOINT_VALID = 0.5  # [s] after which a setpoint expires


class State(NamedTuple):
    """Where a robot is."""

    place: np.ndarray  # (3,) [m], common frame
    velocity: np.ndarray  # (3,) [m/s], common frame
    heading: float  # [rad]


class Piece(NamedTuple):
    """Polynomials of x, y, z [m] and yaw [rad] over a duration."""

    coefficients: np.ndarray  # (4, 8), from that of 1 on
    duration: float  # [s]


class Goal(NamedTuple):
    """Wanted place, velocity and acceleration of a robot."""

    place: np.ndarray  # (3,) [m]
    velocity: np.ndarray  # (3,) [m/s]
    acceleration: np.ndarray  # (3,) [m/s^2]
    yaw: float  # [rad]
    rate: float  # [rad/s]


class Flight(NamedTuple):
    """Pieces one after the other, begun at a time."""

    pieces: Any
    begin: float  # [s]
    scale: float = 1.0  # [-] times as long
    reverse: bool = False
    shift: Any = 0.0  # (3,) [m]
    lands: bool = False

    def duration(self):
        """Return how long [s] it takes."""
        return self.scale * sum(piece.duration for piece in self.pieces)

    def goal(self, now):
        """Return the ``Goal`` at ``now`` [s]: at its end after it."""
        whole = sum(piece.duration for piece in self.pieces)
        time = min(max((now - self.begin) / self.scale, 0.0), whole)
        over = now - self.begin >= self.duration()
        sign = -1.0 if self.reverse else 1.0
        return goal_at(self.pieces, whole - time if self.reverse else time).moved(
            self.shift, 0.0 if over else sign / self.scale
        )


def goal_at(pieces, time):
    """Return the ``_Point`` of ``pieces`` at ``time`` [s] since their begin."""
    for piece in pieces[:-1]:
        if time < piece.duration:
            break
        time -= piece.duration
    else:
        piece = pieces[-1]
    return _Point(*(
        np.polynomial.polynomial.polyval(time, _derivative(piece.coefficients, order).T)
        for order in range(3)
    ))  # fmt: skip


def _derivative(coefficients, order):
    for _ in range(order):
        coefficients = coefficients[:, 1:] * np.arange(1, coefficients.shape[1])
    return coefficients


class _Point(NamedTuple):
    value: np.ndarray  # (4,)
    slope: np.ndarray
    curvature: np.ndarray

    def moved(self, shift, pace):
        slope, curvature = pace * self.slope, pace * pace * self.curvature
        place = self.value[:3] + shift
        return Goal(place, slope[:3], curvature[:3], float(self.value[3]), float(slope[3]))


def from_rest_to_rest(begin, end, duration):
    """Return the ``Piece`` from ``begin`` to ``end`` (4,) in ``duration`` [s], at rest at both ends.

    ``p = p0 + (p1 - p0)(35 s^4 - 84 s^5 + 70 s^6 - 20 s^7)``, s = t/duration: no velocity, acceleration or
    jerk at the ends.
    """
    powers = np.array([0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0])
    scaled = powers / duration ** np.arange(COEFFICIENTS)
    coefficients = np.outer(np.subtract(end, begin), scaled)
    coefficients[:, 0] += begin
    return Piece(coefficients, duration)


class Commander:
    """The commander of one robot: its latest setpoint or flight, and the command that follows.

    A setpoint that streams in has priority over planned flights until none came for ``SETPOINT_VALID``, or
    ``release``.  ``stopped``: whether its motors are off.
    """

    def __init__(self, kind, step):
        """``kind`` of the robot; ``step`` [s]."""
        self._response = flying.response(kind, step)
        self._most = greatest_thrust(kind.numbers) / kind.mass  # [m/s^2]
        self.group = 0
        self.stopped = False
        self._pieces, self._trajectories = {}, {}
        self._flight, self._setpoint, self._received = None, None, -math.inf

    @property
    def active(self):
        """Return whether it has received anything yet."""
        return self._flight is not None or self._setpoint is not None or self.stopped

    def is_in(self, mask):
        """Return whether it belongs to a group of ``mask``; 0: all do."""
        return mask == 0 or bool(mask & self.group)

    # Planned flights -----------------------------------------------------------------------------

    def take_off(self, now, state, height, duration):
        """Rise to ``height`` [m] within ``duration`` [s]."""
        self._fly(now, state, [*state.place[:2], height], 0.0, duration)

    def land(self, now, state, height, duration):
        """Sink to ``height`` [m] within ``duration`` [s], and onto the ground from there."""
        self._fly(now, state, [*state.place[:2], height], 0.0, duration, lands=True)

    def go_to(self, now, state, goal, yaw, duration, relative):
        """Fly to ``goal`` (3,) [m] and ``yaw`` [rad] within ``duration`` [s]; ``relative`` to where it
        is to be."""
        if relative:
            place, heading = self._from(now, state)
            goal, yaw = np.add(goal, place), yaw + heading
        self._fly(now, state, goal, yaw, duration)

    def _fly(self, now, state, goal, yaw, duration, lands=False):
        refuse_durations([duration])
        if not np.isfinite([*goal, yaw]).all():
            raise ValueError("goal {}, yaw {}: wanted finite numbers".format(list(goal), yaw))
        place, heading = self._from(now, state)
        piece = from_rest_to_rest([*place, heading], [*goal, yaw], duration)
        self._begin(Flight([piece], now, lands=lands))

    def _from(self, now, state):
        """Return the place and yaw from which flights are planned: those last aimed at, else as it is."""
        if self._flight is None or self._flight.lands or self._setpoint is not None:
            return state.place, state.heading
        goal = self._flight.goal(now)
        return goal.place, goal.yaw

    def _begin(self, flight):
        self._flight, self._setpoint, self.stopped = flight, None, False

    def upload(self, number, offset, pieces):
        """Keep ``pieces`` as trajectory ``number``, from place ``offset`` of the memory on."""
        refuse_durations([piece.duration for piece in pieces])
        if not pieces or offset + len(pieces) > MOST_PIECES:
            text = "{} pieces from {} on: wanted from 1 piece, and no place beyond {}"
            raise ValueError(text.format(len(pieces), offset, MOST_PIECES))
        self._pieces.update((offset + index, piece) for index, piece in enumerate(pieces))
        self._trajectories[number] = range(offset, offset + len(pieces))

    def start(self, now, state, number, scale, reverse, relative):
        """Fly the trajectory ``number``, ``scale`` times as long, from its end if ``reverse``, shifted
        to where the robot is to be if ``relative``."""
        if number not in self._trajectories:
            known = ", ".join(map(str, sorted(self._trajectories))) or "none"
            raise ValueError(
                "trajectory {}: wanted one that is uploaded ({})".format(number, known)
            )
        refuse_durations([scale], "timescale")
        pieces = [self._pieces[index] for index in self._trajectories[number]]
        flight = Flight(pieces, now, scale, reverse)
        if relative:
            flight = flight._replace(shift=self._from(now, state)[0] - flight.goal(now).place)
        self._begin(flight)

    # Setpoints -----------------------------------------------------------------------------------

    def stream(self, now, setpoint):
        """Follow ``setpoint``, a function of a ``State`` that returns velocity (3,) [m/s] and turn rate
        [rad/s]."""
        self._setpoint, self._received, self.stopped = setpoint, now, False
        self._flight = None

    def is_streaming(self, now):
        """Return whether setpoints have priority."""
        return self._setpoint is not None and now - self._received <= SETPOINT_VALID

    def release(self):
        """End the priority of setpoints over planned flights."""
        self._received = -math.inf

    def stop(self):
        """Switch the motors off."""
        self._flight = self._setpoint = None
        self.stopped = True

    def attitude(self, ahead, right, rate, thrust):
        """Return the setpoint of pitch ``ahead`` and roll ``right`` [deg], yaw ``rate`` [deg/s] and
        ``thrust``.

        ``thrust`` from 0 to 65535: none below 1000, no more than 60000, in proportion to what rotors give.
        """
        share = 0.0 if thrust < LEAST_THRUST else min(thrust, MOST_THRUST) / FULL

        def setpoint(state):
            tilt = ahead * DEGREES, -right * DEGREES
            wanted = flying.tilted(*tilt, share * self._most, state.heading)
            return state.velocity + self._response * wanted, rate * DEGREES

        return setpoint

    def position(self, place, yaw):
        """Return the setpoint of a ``place`` (3,) [m] and ``yaw`` [deg]."""
        return lambda state: (
            flying.towards(state.place, place),
            flying.turning(state.heading, yaw * DEGREES),
        )

    def velocity_world(self, velocity, rate):
        """Return the setpoint of a ``velocity`` (3,) [m/s], common frame, and yaw ``rate`` [deg/s],
        clockwise."""
        return lambda state: (np.array(velocity), -rate * DEGREES)

    def hover(self, ahead, left, rate, height):
        """Return the setpoint of velocities ``ahead`` and ``left`` [m/s], yaw ``rate`` [deg/s],
        clockwise, and ``height`` [m]."""

        def setpoint(state):
            cos, sin = math.cos(state.heading), math.sin(state.heading)
            up = flying.PLACE_GAIN * (height - state.place[2])
            return np.array(
                [cos * ahead - sin * left, sin * ahead + cos * left, up]
            ), -rate * DEGREES

        return setpoint

    def full_state(self, place, velocity, acceleration, yaw, rate):
        """Return the setpoint of a ``place`` [m], ``velocity``, ``acceleration`` (3,), ``yaw`` [rad] and
        ``rate`` [rad/s], counter-clockwise."""
        goal = Goal(*map(np.array, (place, velocity, acceleration)), yaw, rate)
        return lambda state: self._follow(goal, state)

    def _follow(self, goal, state):
        velocity = goal.velocity + self._response * goal.acceleration
        rate = flying.turning(state.heading, goal.yaw, goal.rate)
        return flying.towards(state.place, goal.place, velocity), rate

    # What follows --------------------------------------------------------------------------------

    def command(self, now, state):
        """Return the command (4,): level velocities and turn rate; None where nothing is wanted any
        more."""
        if self._setpoint is not None:
            if not self.is_streaming(now):
                return None
            velocity, rate = self._setpoint(state)
        elif self._flight is None:
            return None
        else:
            velocity, rate = self._follow(self._flight.goal(now), state)
            if self._flight.lands and now - self._flight.begin >= self._flight.duration():
                velocity, rate = np.array([0.0, 0.0, -LAST_SINKING]), 0.0
                if state.place[2] <= 0.0:
                    self._flight = None
        return flying.command(velocity, rate, state.heading)


LAST_SINKING = 0.2  # [m/s] from the height of a landing onto the ground


def refuse_durations(durations, name="duration"):
    """Raise ``ValueError`` that names one that is not above 0."""
    for each in durations:
        if not 0.0 < each < math.inf:
            raise ValueError("{} {:g}: wanted above 0".format(name, each))
