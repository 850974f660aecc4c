"""Numbers of quadrotors for tests, typed out, and runs of their physics."""

import numpy as np

from mrs_simulator.vehicles.drives import flight, quadrotor, quadrotor_forces
from mrs_simulator.vehicles.drives.rotors import hover_speed
from mrs_simulator.vehicles.quantities import QuantitySection

CRAZYFLIE = {
    "arm": "0.0397 m",
    "thrust": "3.16e-10 N/rpm^2",
    "torque": "7.94e-12 N m/rpm^2",
    "speed": "21703 rpm",
    "motor_lag": "72 ms",
    "inertia": {"xx": 1.4e-5, "yy": 1.4e-5, "zz": 2.17e-5},
    "drag": {"across": 9.1785e-7, "up": 1.0311e-6},
    "poles": {"tilt": 30.0, "turn": 12.0},
    "tilt": "30 deg",
    "response": {"across": "0.25 s", "up": "0.25 s"},
}


def crazyflie(**changes):
    """Return the ``QuadrotorParameters`` of a Crazyflie 2, some of them changed."""
    read = quadrotor.read(QuantitySection(dict(CRAZYFLIE), "flight"))
    return read._replace(mass=0.027, **changes)


def published():
    """Return those of gym-pybullet-drones' controller, in our form: motors without lag.

    k_v = D/m beside the drag, of 0.206/s and 0.231/s while hovering.
    Of the torque's gains per PWM step, 4 rotors at 28 mm, 0.2685 rpm a step at 14468 rpm make
    9.82e-3 rad/s^2: 2 P gives k_w k_R, D gives k_w, the clip of 3200 the greatest acceleration.
    """
    return crazyflie(
        lag=0.0,
        velocity_gain=(0.2 / 0.027 + 0.206, 0.2 / 0.027 + 0.206, 0.5 / 0.027 + 0.231),
        attitude_gain=(7.0, 7.0, 1.0),
        rate_gain=(196.4, 196.4, 100.0),
        rate_damping=(0.0, 0.0, 0.0),
        turning_max=(31.4, 31.4, 1000.0),
        tilt_max=1.2,
    )


def hovering(m, numbers, heading=0.0, height=0.0):
    """Return the ``Flight`` of m robots that hover in one place."""
    place = np.zeros((m, 3))
    place[:, 2] = height
    return flight.at_rest(place, np.full(m, heading) + 0.0, hover_speed(numbers))


def flown(state, wanted, duration, numbers, step=0.02, heading=0.0):
    """Return the states at each step of ``duration`` [s] towards ``wanted`` (m, 3), stacked."""
    m, states = len(wanted), []
    heading = np.full(m, heading) + 0.0
    for _ in range(int(round(duration / step))):
        state = quadrotor_forces.moved(state, wanted, heading, np.zeros(m), 0.0, numbers, step)
        states.append(state)
    return flight.Flight(*(np.array(part) for part in zip(*states)))


def tilts(attitude):
    """Return the tilts of ``attitude`` (..., 4) [rad]."""
    x, y = attitude[..., 0], attitude[..., 1]
    return np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0))
