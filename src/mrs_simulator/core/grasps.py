"""Statics of a rigid body grasped at several points: where it is, and how its weight is shared.

Grips hold points and turn freely: each exerts a force ``f_i`` on the body, no torque.  With the grips at
``r_i`` from the body's centre, in the axes of the forces, the wrench of all is ``w = G f`` with the grasp
matrix ``G = [I ... I; [r_1]x ... [r_n]x]``, (6, 3 n).  Forces split into the smallest that give w, ``G+ w``
with the pseudo-inverse, and internal ones, ``(I - G+ G) f``, which pull the grips against each other and
move nothing (Nakamura, Nagai and Yoshikawa, Int. J. Robotics Research, 1989).
"""

import numpy as np

from mrs_simulator.core.spatial import quaternion_product, rotated

ROUNDS = 30  # [-] of Newton's method, of which six are enough
LEAST_WIDTH = 0.02  # [m] of grasps across the line that they are nearest to


def grasp_matrix(arms):
    """Return ``G`` (..., 6, 3 n) of grips at ``arms`` (..., n, 3) [m] from the centre."""
    arms = np.asarray(arms, dtype=float)
    n = arms.shape[-2]
    result = np.zeros(arms.shape[:-2] + (6, n, 3))
    x, y, z = np.moveaxis(arms, -1, 0)
    result[..., [0, 1, 2], :, [0, 1, 2]] = 1.0
    result[..., 3, :, 1], result[..., 3, :, 2] = -z, y
    result[..., 4, :, 0], result[..., 4, :, 2] = z, -x
    result[..., 5, :, 0], result[..., 5, :, 1] = -y, x
    return result.reshape(arms.shape[:-2] + (6, 3 * n))


def least_forces(arms, wrench):
    """Return the smallest forces (..., n, 3) [N] that give ``wrench`` (..., 6) [N, N m]: ``G+ w``."""
    matrix = grasp_matrix(arms)
    forces = np.linalg.pinv(matrix) @ np.asarray(wrench, dtype=float)[..., np.newaxis]
    return forces.reshape(np.shape(arms))


def internal_forces(arms, forces):
    """Return the internal part (..., n, 3) [N] of ``forces`` (..., n, 3): ``(I - G+ G) f``."""
    matrix = grasp_matrix(arms)
    flat = np.reshape(forces, np.shape(forces)[:-2] + (-1, 1))
    return (flat - np.linalg.pinv(matrix) @ (matrix @ flat)).reshape(np.shape(forces))


def fitted_pose(grasps, points):
    """Return place (..., 3) [m] and unit quaternion (..., 4) of a body held at ``points`` (..., n, 3) [m].

    ``grasps`` (n, 3): where it is held, in its own axes.  The sum of the squared misfits is least: so it
    rests between equal springs (Horn, J. Optical Society of America A, 1987).
    """
    grasps, points = np.asarray(grasps, dtype=float), np.asarray(points, dtype=float)
    middle, about = points.mean(axis=-2), grasps.mean(axis=0)
    s = np.einsum("na,...nb->...ab", grasps - about, points - middle[..., np.newaxis, :])
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = ([s[..., a, b] for b in range(3)] for a in range(3))
    rows = (
        (xx + yy + zz, yz - zy, zx - xz, xy - yx),
        (yz - zy, xx - yy - zz, xy + yx, zx + xz),
        (zx - xz, xy + yx, yy - xx - zz, yz + zy),
        (xy - yx, zx + xz, yz + zy, zz - xx - yy),
    )
    matrix = np.moveaxis(np.array(rows), (0, 1), (-2, -1))
    turn = np.linalg.eigh(matrix)[1][..., -1]
    turn = np.where(turn[..., :1] < 0.0, -turn, turn)[..., [1, 2, 3, 0]]
    return middle - rotated(turn, np.broadcast_to(about, middle.shape)), turn


def hanging_pose(grasps, points, weight, stiffness):
    """Return where a body of ``weight`` (6,) [N, N m] hangs at rest: place (3,) [m] and quaternion (4,).

    Springs from ``points`` (n, 3) [m] hold it at its ``grasps`` (n, 3): ``G f = w``, ``f_i = K (p_i - x -
    R r_i)``, by Newton's method from where it would rest without weight.
    """
    place, turn = fitted_pose(grasps, points)
    for _ in range(ROUNDS):
        at = grasp_points(grasps, place, turn)
        matrix = grasp_matrix(at - place)
        left = matrix @ (stiffness * (points - at)).ravel() - weight
        step = np.linalg.solve(matrix @ matrix.T, left) / stiffness
        place, turn = place + step[:3], quaternion_product(np.append(0.5 * step[3:], 1.0), turn)
        turn = turn / np.linalg.norm(turn)
    return place, turn


def grasp_points(grasps, place, turn):
    """Return where the grips (..., n, 3) [m] of a body at ``place`` (..., 3), turned by ``turn``, are."""
    turn = np.asarray(turn)[..., np.newaxis, :]
    shape = np.shape(place)[:-1] + np.shape(grasps)
    return np.asarray(place)[..., np.newaxis, :] + rotated(turn, np.broadcast_to(grasps, shape))


def are_noncollinear(grasps):
    """Return whether ``grasps`` (n, 3) [m] hold a body firmly: three or more, not on one line."""
    grasps = np.asarray(grasps, dtype=float)
    if len(grasps) < 3:
        return False
    return bool(np.linalg.svd(grasps - grasps.mean(axis=0))[1][1] > LEAST_WIDTH)
