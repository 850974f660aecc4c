"""Two driven wheels on an axle and casters, on flat ground: dry friction as impulses, without a solver.

Of each robot, in the frame of its body, about its centre of mass: velocity ``(vx, vy, omega)``; wheels left
and right at ``(x, +-y)``; over a substep h they get the impulses p along and q across from the ground,

    m (vx+ - vx) = sum p,   m (vy+ - vy) = sum q,   I (omega+ - omega) = sum (x q - y p),

so large that both wheels roll, ``vx+ - y omega+ = rim`` and ``vy+ + x omega+ = 0``, at the speeds at which
motors hold their rims, but within the motor's force and the circle of traction,

    |p| <= F h,   hypot(p, q) <= mu N h.

Where they are within it the robot rolls as without forces.  Else they are found by projection, as solvers
of contacts find them: each impulse takes away what slides, and is brought back to its circle (projected
Jacobi, as in Jean, The non-smooth contact dynamics method, 1999).  Loads follow forces at once: with the
ground's force (X, Y) on the wheels, the centre of mass at height z, and casters without friction at c,

    N = (-c W - z X)/(x - c),   N_left - N_right = -z Y/y.

Where a caster or a wheel would have to pull, the robot tips; then this is no model of it.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin, displaced, wrap_angle
from mrs_simulator.world.motion.planar_body import GRAVITY, TINY

SWEEPS = 8  # [-] of the projection in a substep
ROLLS = 1.0 - 1e-9  # [-] of a limit, within which a wheel rolls


class Wheels(NamedTuple):
    """m robots on two wheels each; columns (m,)."""

    mass: np.ndarray  # [kg]
    inertia: np.ndarray  # [kg m^2] about the vertical through the centre of mass
    ahead: np.ndarray  # [m] of the centre of mass from the middle of the axle
    height: np.ndarray  # [m] of the centre of mass
    half: np.ndarray  # [m] of a wheel from the middle
    load: np.ndarray  # [N] on both wheels at rest
    shift: np.ndarray  # [-] of that for the force ahead, -dN/dX
    front: np.ndarray  # [m] of the foremost and rearmost support from the centre of mass
    rear: np.ndarray
    friction: np.ndarray  # [-]
    force: np.ndarray  # [N] of a motor at its rim, at most

    def of(self, rows):
        """Return the same of the robots in ``rows``."""
        return Wheels(*(column[rows] for column in self))


def rolled(wheels, pose, twist, rims, step, substeps):
    """Move m robots for a ``step`` [s] in so many ``substeps``.

    ``pose`` and body ``twist`` (m, 3) of the middles of the axles; ``rims`` (2, m) [m/s]: the speeds at
    which motors hold the rims, left and right.  Returns poses, twists, how far the rims turned, (2, m)
    [m], and which robots would tip, (m,) bool.
    """
    duration, held = step / substeps, held_twists(wheels, rims)
    p, q = _rolling_impulses(wheels, at_mass(wheels, twist), at_mass(wheels, held), duration)
    slides, tips = ~_within(wheels, p, q, duration), np.zeros(len(pose), dtype=bool)
    turned = step * rims
    after = displaced(pose, held, step)
    if not slides.any():
        return after, held, turned, tips
    rows = np.flatnonzero(slides)
    moved = _slid(
        wheels.of(rows), pose[rows], twist[rows], held[rows], rims[:, rows], duration, substeps
    )
    after[rows], held[rows], turned[:, rows], tips[rows] = moved
    return after, held, turned, tips


def held_twists(wheels, rims):
    """Return the twists (m, 3) of robots whose wheels roll at ``rims`` (2, m) [m/s]."""
    held = np.zeros((rims.shape[1], 3))
    held[:, 0] = 0.5 * (rims[0] + rims[1])
    held[:, 2] = 0.5 * (rims[1] - rims[0]) / wheels.half
    return held


def _slid(wheels, pose, twist, held, rims, duration, substeps):
    """As ``rolled``, of robots some of whose wheels slide; ``held``: the twists of those that roll."""
    held, velocity = at_mass(wheels, held), at_mass(wheels, twist)
    place, theta = mass_centre(wheels, pose), pose[:, 2]
    turned, pushed = np.zeros_like(rims), np.zeros((2, len(pose)))
    for _ in range(substeps):
        p, q = _rolling_impulses(wheels, velocity, held, duration)
        slides = ~_within(wheels, p, q, duration)
        free, velocity, rows = velocity, held.copy(), np.flatnonzero(slides)
        if len(rows):  # mostly those whose wheels have just got another target speed
            own = _unpushed(free[rows], duration), rims[:, rows], p[:, rows], q[:, rows]
            velocity[rows], p[:, rows], q[:, rows] = _projected(wheels.of(rows), *own, duration)
        cos, sin = cos_sin(ways(theta, slides, velocity, duration))
        place[:, 0] += duration * (cos * velocity[:, 0] - sin * velocity[:, 1])
        place[:, 1] += duration * (sin * velocity[:, 0] + cos * velocity[:, 1])
        theta = theta + duration * velocity[:, 2]
        ground = velocity[:, 0] - _left_right(wheels.half) * velocity[:, 2]
        weak = np.abs(p) >= ROLLS * wheels.force * duration
        turned += duration * np.where(weak, ground, rims)
        pushed += np.stack([p[0] + p[1], q[0] + q[1]])
    pose, twist = of_axle(wheels, place, theta, velocity)
    return pose, twist, turned, who_tips(wheels, *(pushed / (substeps * duration)))


def ways(theta, slides, velocity, duration):
    """Return the headings (m,) along which robots go in a substep.

    On an arc where they roll; where they slide the velocity goes first, then the place.
    """
    return theta + np.where(slides, 1.0, 0.5) * duration * velocity[:, 2]


def of_axle(wheels, place, theta, velocity):
    """Return pose and twist (m, 3) of the axles' middles, of those of the centres of mass."""
    cos, sin = cos_sin(theta)
    pose, twist = np.empty((len(theta), 3)), velocity.copy()
    pose[:, 0], pose[:, 1] = place[:, 0] - wheels.ahead * cos, place[:, 1] - wheels.ahead * sin
    pose[:, 2] = wrap_angle(theta)
    twist[:, 1] -= wheels.ahead * velocity[:, 2]
    return pose, twist


def _left_right(half):
    return np.stack([half, -half])


def at_mass(wheels, twist):
    """Return the ``twist`` (m, 3) of the axles' middles as that of the centres of mass."""
    result = twist.copy()
    result[:, 1] += wheels.ahead * twist[:, 2]
    return result


def mass_centre(wheels, pose):
    """Return the places (m, 2) of the centres of mass of robots at ``pose`` (m, 3)."""
    cos, sin = cos_sin(pose[:, 2])
    return np.column_stack([pose[:, 0] + wheels.ahead * cos, pose[:, 1] + wheels.ahead * sin])


def _unpushed(velocity, duration):
    """Return the velocities (m, 3) after ``duration`` without forces, in the frames as they have turned."""
    cos, sin = cos_sin(duration * velocity[:, 2])
    free = velocity.copy()
    free[:, 0] = cos * velocity[:, 0] + sin * velocity[:, 1]
    free[:, 1] = cos * velocity[:, 1] - sin * velocity[:, 0]
    return free


def _rolling_impulses(wheels, velocity, held, duration):
    """Return the impulses p and q, (2, m) each [N s], that make velocities (m, 3) those ``held``."""
    change = held - _unpushed(velocity, duration)
    along, across = 0.5 * wheels.mass * change[:, 0], 0.5 * wheels.mass * change[:, 1]
    # Both wheels are ``-ahead`` before the centre of mass.
    turn = wheels.inertia * change[:, 2] + 2.0 * wheels.ahead * across
    turn *= 0.5 / wheels.half
    return np.stack([along - turn, along + turn]), np.stack([across, across])


def loads(wheels, ahead, aside):
    """Return the wheels' loads (2, m) [N] that the ground pushes ``ahead`` and ``aside``, (m,) [N]."""
    both = np.maximum(wheels.load - wheels.shift * ahead, 0.0)
    result = np.empty((2, len(both)))
    left = np.subtract(0.5 * both, 0.5 * wheels.height / wheels.half * aside, out=result[0])
    np.minimum(np.maximum(left, 0.0, out=left), both, out=left)
    np.subtract(both, left, out=result[1])
    return result


def who_tips(wheels, ahead, aside):
    """Return which robots, (m,) bool, cannot stand on all supports under forces (m,) of the ground [N]."""
    weight = GRAVITY * wheels.mass
    centre = -wheels.height * ahead / weight  # of pressure, from the centre of mass
    both = np.maximum(wheels.load - wheels.shift * ahead, 0.0)
    leans = wheels.height * np.abs(aside) > both * wheels.half
    return (centre > wheels.front) | (centre < wheels.rear) | leans


def _circles(wheels, ahead, aside, duration):
    """Return the greatest impulses (2, m) [N s] of the ground, under loads as they go with impulses
    ``ahead`` and ``aside`` (m,) on both wheels."""
    rate = 1.0 / duration
    return duration * wheels.friction * loads(wheels, rate * ahead, rate * aside)


def _within(wheels, p, q, duration):
    """Return which robots, (m,) bool, roll: the impulses are within all limits."""
    most = _circles(wheels, p[0] + p[1], q[0] + q[1], duration)
    fits = (p * p + q * q <= most * most) & (np.abs(p) <= wheels.force * duration)
    return fits[0] & fits[1]


def _projected(wheels, free, rims, p, q, duration):
    """Return velocities (m, 3) and impulses p and q, (2, m), of a substep that without them ends with the
    velocities ``free`` (m, 3)."""
    mass, inertia, x, y = wheels.mass, wheels.inertia, -wheels.ahead, wheels.half
    # Row sums of the contacts' matrix: no step is then longer than its motion allows.
    cross = np.abs(x) * y / inertia
    along = np.maximum(2.0 / mass, 2.0 * y * y / inertia)
    across = 2.0 / mass + 2.0 * x * x / inertia
    gain = 1.0 / (np.maximum(along, across) + 2.0 * cross)
    most = duration * wheels.force
    still = np.zeros(len(free))
    p, q = _bounded(p, q, most, _circles(wheels, still, still, duration))
    for _ in range(SWEEPS):
        ahead, aside = p[0] + p[1], q[0] + q[1]
        vx, vy, omega = _pushed(free, p, ahead, aside, wheels)
        circle = _circles(wheels, ahead, aside, duration)
        slip, turn = vx - rims, y * omega
        slip[0] -= turn
        slip[1] += turn
        p, q = _bounded(p - gain * slip, q - gain * (vy + x * omega), most, circle)
    pushed = _pushed(free, p, p[0] + p[1], q[0] + q[1], wheels)
    return np.stack(pushed, axis=1), p, q


def _pushed(free, p, ahead, aside, wheels):
    """Return the velocities, (m,) each, after impulses p (2, m), ``ahead`` and ``aside`` (m,) in all."""
    omega = free[:, 2] + (wheels.half * (p[1] - p[0]) - wheels.ahead * aside) / wheels.inertia
    return free[:, 0] + ahead / wheels.mass, free[:, 1] + aside / wheels.mass, omega


def _bounded(p, q, most, circle):
    """Return impulses p and q, (2, m) each, brought back to what motors and ``circle`` (2, m) allow."""
    p = np.minimum(np.maximum(p, -most), most)
    share = circle / np.maximum(np.maximum(np.hypot(p, q), circle), TINY)
    return share * p, share * q
