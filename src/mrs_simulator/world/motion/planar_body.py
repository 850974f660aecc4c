"""Rigid bodies in the plane under forces, and the forces of wheels on the ground.

n bodies: ``pose`` (n, 3) of the centre of mass, x, y [m], theta [rad]; ``twist`` (n, 3), its velocity
vx, vy [m/s] in the body's frame and omega [rad/s]; ``wrench`` (n, 3), forward and sideways force [N] and
torque [N m] about the centre of mass.  With M = diag(m, m, I), in the body's frame,

    m (vx' - omega vy) = Fx,   m (vy' + omega vx) = Fy,   I omega' = Mz.

Wheels push by dry friction, made regular: a force grows with the speed at which the contact slides and
is limited by the motor's torque and by the circle of traction, ``hypot(f, g) <= mu N``.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin, wrap_angle

GRAVITY = 9.81  # [m/s^2]
TINY = 1e-300  # [N] stands for no force where one is divided by
RESPONSE = 0.01  # [s] in which sliding dies out, as long as no limit is reached


class Footing(NamedTuple):
    """How w wheels of n bodies stand on the ground; rows refer to the body's twist.

    ``along`` and ``across`` (n, w, 3): the speed of the ground under a wheel, in its direction and across
    it, is ``along @ twist`` and ``across @ twist``; zero across for wheels with free rollers.
    """

    along: np.ndarray
    across: np.ndarray
    grip: np.ndarray  # (n, w) [N], mu N: the greatest force of the contact
    # (n, w) [N], greatest force of the motor at the rim, 0 for a wheel that runs freely
    push: np.ndarray


def about(rows, ahead):
    """Return ``rows`` (n, w, 3), given for the twist of a point, for the twist of one ``ahead`` (n,) [m].

    Of a body whose reference lies at the rear axle, say, to the centre of mass: ``vy = vy_ahead - ahead
    omega``.
    """
    result = np.array(rows, dtype=float)
    result[:, :, 2] -= rows[:, :, 1] * np.reshape(ahead, (-1, 1))
    return result


def stiffness(footing, mass, inertia):
    """Return the force per sliding speed, (n,) [N s/m], with which sliding dies out in ``RESPONSE``.

    All wheels of a body have the same; the fastest motion they can brake decides: the greatest
    eigenvalue of ``M^-1/2 J' J M^-1/2``, J all rows of the footing.
    """
    rows = np.concatenate([footing.along, footing.across], axis=1)
    scale = np.stack(np.broadcast_arrays(mass, mass, inertia), axis=-1) ** -0.5
    rows = rows * np.reshape(scale, (-1, 1, 3))
    fastest = np.linalg.eigvalsh(np.einsum("nwi,nwj->nij", rows, rows))[:, -1]
    return 1.0 / (RESPONSE * fastest)


def wheel_forces(twist, rims, footing, gain):
    """Return the wheels' wrench (n, 3) and the speeds at which their rims turn, (n, w) [m/s].

    ``rims`` (n, w) [m/s]: the speeds at which motors hold the rims; ``gain`` (n,): the ``stiffness``.
    Where the motor is too weak the rim turns only as fast as its force allows; where the ground is too
    slippery the wheel spins.
    """
    gain = np.reshape(gain, (-1, 1))
    ground = np.einsum("nwk,nk->nw", footing.along, twist)
    wanted = gain * (rims - ground)
    forward = np.clip(wanted, -footing.push, footing.push)
    turning = ground + forward / gain
    sideways = -gain * np.einsum("nwk,nk->nw", footing.across, twist)
    total = np.maximum(np.hypot(forward, sideways), TINY)
    share = footing.grip / np.maximum(total, footing.grip)
    pulls, drags = share * forward, share * sideways
    weak = (share < 1.0) & (forward != wanted) & (footing.push > 0.0)
    if weak.any():
        slid = sliding(wanted[weak], sideways[weak], footing.grip[weak], footing.push[weak])
        pulls[weak], drags[weak], rim = slid
        turning[weak] = ground[weak] + rim / np.broadcast_to(gain, weak.shape)[weak]
    wrench = np.einsum("nwk,nw->nk", footing.along, pulls)
    return wrench + np.einsum("nwk,nw->nk", footing.across, drags), turning


def sliding(forward, sideways, grip, push):
    """Return forces along and across m wheels that slide, and ``forward`` as their rims turn, (m,) [N].

    ``forward`` and ``sideways`` [N]: ``gain`` times the speeds of sliding if the motors held the rims.  The
    contact pushes against that with ``grip``; a motor that has only ``push`` lets its rim slow down until
    the direction of sliding leaves it no more.
    """
    pull = np.sign(forward) * np.minimum(grip * np.abs(forward) / np.hypot(forward, sideways), push)
    drag = np.sign(sideways) * np.sqrt(np.maximum(grip**2 - pull**2, 0.0))
    held = (np.abs(pull) < push) | (drag == 0.0)
    rim = np.where(held, forward, pull * np.abs(sideways) / np.where(held, 1.0, np.abs(drag)))
    return pull, drag, rim


class PlanarBodies:
    """Bodies moved by wrenches; the velocity goes first, then the place (symplectic Euler)."""

    def __init__(self, mass, inertia, pose, twist=None):
        """``mass`` (n,) [kg], ``inertia`` (n,) [kg m^2] about the centre of mass; at rest by default."""
        self.pose = np.array(pose, dtype=float)
        n = len(self.pose)
        self.mass = np.broadcast_to(np.asarray(mass, dtype=float), (n,))
        self.inertia = np.broadcast_to(np.asarray(inertia, dtype=float), (n,))
        self.twist = np.zeros((n, 3)) if twist is None else np.array(twist, dtype=float)

    def advance(self, wrench, duration):
        """Move by one step of ``duration`` [s] under ``wrench`` (n, 3), held in the body's frame."""
        pushed = self.twist.copy()
        pushed[:, :2] += duration * wrench[:, :2] / self.mass[:, np.newaxis]
        pushed[:, 2] += duration * wrench[:, 2] / self.inertia
        cos, sin = cos_sin(self.pose[:, 2])
        across = np.stack(
            [cos * pushed[:, 0] - sin * pushed[:, 1], sin * pushed[:, 0] + cos * pushed[:, 1]],
            axis=1,
        )
        self.pose = self.pose.copy()
        self.pose[:, :2] += duration * across
        self.pose[:, 2] = wrap_angle(self.pose[:, 2] + duration * pushed[:, 2])
        # The velocity over ground stays; the frame has turned.
        cos, sin = cos_sin(self.pose[:, 2])
        pushed[:, 0] = cos * across[:, 0] + sin * across[:, 1]
        pushed[:, 1] = cos * across[:, 1] - sin * across[:, 0]
        self.twist = pushed
