"""Safety filter for any law: the nearest velocities with which no two robots touch."""

import numpy as np

GAMMA = 1.0  # [1/(s m^4)] how fast a pair may use up its margin
SWIRL = 0.15  # [rad] by which robots close to others turn aside, so that exact symmetry does not stop them
SWEEPS = 400  # [-] most steps of the solver
TOLERANCE = 1e-7  # [-] of a constraint, relative to its size


def margins(points, distance):
    """Return ``h_ij = |p_i - p_j|^2 - D_s^2`` of all pairs, (m,) [m^2], and their rows (m,), (m,).

    ``distance``: ``D_s`` [m] of all pairs, or of each, (n, n).
    """
    first, second = np.triu_indices(len(points), 1)
    apart, distance = points[first] - points[second], of_pairs(distance, first, second)
    return np.einsum("ij,ij->i", apart, apart) - distance * distance, first, second


def of_pairs(distance, first, second):
    """Return ``distance`` as it is if it is one number, else (n, n) that of the pairs, (m,)."""
    return distance if np.ndim(distance) == 0 else distance[first, second]


def safe_velocities(wanted, points, distance, period, gamma=GAMMA, swirl=SWIRL):
    """Return the velocities nearest to ``wanted`` that keep all pairs apart, (n, 2) [m/s].

    Minimises ``sum |u_i - wanted_i|^2`` subject to, for every pair,

        -2 p_ij^T u_i + 2 p_ij^T u_j <= min(gamma h_ij^3, h_ij / period),

    ``p_ij = p_i - p_j``, ``h_ij = |p_ij|^2 - distance^2``; ``points`` (n, 2) [m].  The second bound is
    for velocities that are held for ``period`` [s]: since ``|p + d|^2 >= |p|^2 + 2 p^T d``, no pair
    that starts with ``h >= 0`` ever has less.  Wang, Ames and Egerstedt, 2017.
    """
    wanted = np.asarray(wanted, dtype=float)
    margin, first, second = margins(points, distance)
    # At first those pairs matter that both robots, heading for each other, could bring too near.
    apart = points[first] - points[second]
    gap = np.linalg.norm(apart, axis=1)
    bound = np.minimum(gamma * margin**3, margin / period)
    speed = np.linalg.norm(wanted, axis=1)
    near = 2.0 * gap * 2.0 * (speed[first] + speed[second]) >= bound
    if not near.any():
        return wanted
    close = near & (gap < 2.0 * of_pairs(distance, first, second))
    wanted = _turned_aside(wanted, first, second, close, swirl)
    # Each row divided by its length: a_k u <= b_k with |a_k| = 1.
    size = 2.0 * np.sqrt(2.0) * np.maximum(gap, 1e-9)
    rows, limit = 2.0 * apart / size[:, np.newaxis], bound / size
    while True:
        velocity = _nearest(wanted, first[near], second[near], rows[near], limit[near])
        pressure = _pressure(velocity, first, second, rows)
        # Whoever is pushed aside may be pushed towards a robot that it did not head for.
        pushed = ~near & (pressure > limit)
        if not pushed.any():
            return velocity * _feasible_share(pressure, limit)
        near |= pushed


def filter_acts(velocity, points, distance, period, gamma=GAMMA):
    """Return whether the filter may have changed what was wanted to ``velocity`` (n, 2) [m/s].

    A velocity that was changed lies on the bound of some pair, or some robot was turned aside.
    """
    margin, first, second = margins(points, distance)
    apart = points[first] - points[second]
    gap = np.linalg.norm(apart, axis=1)
    bound = np.minimum(gamma * margin**3, margin / period)
    used = 2.0 * np.einsum("ij,ij->i", apart, velocity[second] - velocity[first])
    speed = np.linalg.norm(velocity, axis=1)
    near = 4.0 * gap * (speed[first] + speed[second]) >= bound
    return bool(
        np.any((used >= 0.99 * bound) | (near & (gap < 2.0 * of_pairs(distance, first, second))))
    )


def _turned_aside(wanted, first, second, close, swirl):
    """Turn the wanted velocities of robots with others close by, all to the same side."""
    turned = np.zeros(len(wanted), dtype=bool)
    turned[first[close]] = turned[second[close]] = True
    angle = np.where(turned, swirl, 0.0)
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = wanted.T
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)


def _pressure(velocity, first, second, rows):
    """Return ``a_k u``, (m,): how much each pair's margin is used up."""
    return np.einsum("ij,ij->i", rows, velocity[second] - velocity[first])


def _nearest(wanted, first, second, rows, limit):
    """Solve the quadratic programme in its dual, by accelerated projected gradients.

    A force pushes each pair apart; its step is 1 over the sum of what all forces do to its pair: 1
    itself, and at most half for each other pair of one of the two robots.
    """
    n = len(wanted)
    place = np.stack([2 * first, 2 * first + 1, 2 * second, 2 * second + 1])
    share = np.stack([-rows[:, 0], -rows[:, 1], rows[:, 0], rows[:, 1]])  # a_k, at its four places
    begun, places = wanted.ravel(), place.ravel()

    def pushed(force):
        """Return ``u - A^T lambda``, (2n,)."""
        return begun - np.bincount(places, (share * force).ravel(), 2 * n)

    pairs = np.bincount(np.concatenate([first, second]), minlength=n)
    step = 1.0 / (1.0 + 0.5 * (pairs[first] + pairs[second] - 2))
    force = ahead = np.zeros(len(limit))
    momentum = 1.0
    tolerance = TOLERANCE * max(1e-3, float(np.abs(limit).max()), float(np.abs(wanted).max()))
    for _ in range(SWEEPS):
        excess = (share * pushed(ahead)[place]).sum(axis=0) - limit
        new = np.maximum(0.0, ahead + step * excess)
        change = new - force
        following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum * momentum))
        if np.dot(change, excess) < 0.0:
            following = momentum = 1.0  # start the acceleration anew where it leads astray
        ahead = new + (momentum - 1.0) / following * change
        force, momentum = new, following
        if (np.abs(change) < tolerance * step).all():
            break
    return pushed(force).reshape(n, 2)


def _feasible_share(pressure, limit):
    """Return the largest factor up to 1 by which all may move: standing still is always allowed."""
    over = pressure > np.maximum(limit, 0.0)
    if not over.any():
        return 1.0
    return float(np.clip(np.min(np.maximum(limit[over], 0.0) / pressure[over]), 0.0, 1.0))
