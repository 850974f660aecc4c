"""Lyapunov functions of the shipped laws and how fast theory says that they fall.

Each is written from its theorem, without the law's code: V of points p (n, d) and its dissipation D with
``V' = -D`` under the law, both one number.  Those of moving things also take velocities v (n, d) and
the time [s].
"""

import numpy as np

from mrs_simulator.protocols.curves import Energy

TABLE = 4001  # points at which a pair force is integrated
DOUBLINGS = 60  # [-] most of Smith's method
EPSILON, BUMP = 0.1, 0.2  # [1/m^2], [-] of the sigma-norm and the bump function: Olfati-Saber, 2006


def laplacian_energy(topology, gain, places=0.0, standing=0):
    """Return ``V = sum_edges a_ij |e_i - e_j|^2 / 2``, ``e = p - places``, of undirected consensus.

    ``D = gain sum_i |sum_j a_ij (e_i - e_j)|^2`` over the robots that move: the last ``standing`` do not.
    Olfati-Saber and Murray, 2004.
    """
    first, second, weights = topology.arcs
    laplacian = topology.laplacian()

    def value(hand):
        away = hand - places
        apart = away[..., first, :] - away[..., second, :]
        return 0.25 * (apart**2).sum(axis=-1) @ weights

    def dissipation(hand):
        pull = laplacian @ (hand - places)
        return gain * _squares(pull[..., : topology.n - standing, :])

    return Energy("$V = p^T L p/2$ [m$^2$]", value, dissipation, stacks=True)


def _squares(points):
    """Return ``|p|^2`` of ``points`` (..., n, d)."""
    return (points**2).sum(axis=(-2, -1))


def averaging_energy(topology, gain, places=0.0):
    """Return the energy of ``p' = -gain L (p - places)``, None where none is known.

    ``V = e^T L e/2`` on an undirected graph, else :func:`disagreement_energy`.
    """
    if gain <= 0.0:
        return None
    if not topology.directed:
        return laplacian_energy(topology, gain, places)
    if topology.n < 2 or not topology.has_spanning_tree():
        return None
    return disagreement_energy(topology.laplacian(), gain, places)


def disagreement_energy(laplacian, gain, places=0.0):
    """Return ``V = z^T P z`` of ``p' = -gain L (p - places)``, L (n, n) directed, and ``D = gain |z|^2``.

    ``z = U^T (p - places)``, U (n, n-1) an orthonormal basis of what robots do not share, and ``M^T P +
    P M = I``, ``M = U^T L U``.  L has a spanning tree, so that all eigenvalues of M are to the right.
    """
    basis = unshared(len(laplacian))
    weight = basis @ lyapunov(basis.T @ laplacian @ basis) @ basis.T

    def value(hand):
        away = hand - places
        return (away * (weight @ away)).sum(axis=(-2, -1))

    def dissipation(hand):
        away = hand - places  # |U^T e| is what is left of e without its mean
        return gain * _squares(away - away.mean(axis=-2, keepdims=True))

    return Energy("$V = e^T P e$ [m$^2$]", value, dissipation, stacks=True)


def unshared(n):
    """Return an orthonormal basis, (n, n-1), of what n robots do not share."""
    return np.linalg.qr(np.column_stack([np.ones(n), np.eye(n)[:, : n - 1]]))[0][:, 1:]


def error_energy(matrix, gain, error, moving=False):
    """Return ``V = e^T P e`` of ``e' = -gain M e``, and ``D = gain |e|^2``.

    M = ``matrix`` has eigenvalues of positive real parts, and ``M^T P + P M = I``.  ``error(p)``, or
    ``error(p, v, t)`` of a ``moving`` goal, returns e, (k, d) [m].
    """
    return _quadratic(matrix, gain, error, moving)


def _quadratic(matrix, gain, error, moving=False):
    weight = lyapunov(matrix)

    def value(*state):
        away = error(*state)
        return float((away * (weight @ away)).sum())

    def dissipation(*state):
        return gain * float((error(*state) ** 2).sum())

    return Energy("$V = e^T P e$ [m$^2$]", value, dissipation, moving)


def lyapunov(matrix):
    """Return P with ``M^T P + P M = I``, M = ``matrix`` with eigenvalues of positive real parts.

    By a Cayley transform and Smith's doubling: P is the sum of ``(A^k)^T W A^k``.
    """
    n = len(matrix)
    if not n:
        return np.zeros((0, 0))
    shift = max(np.linalg.norm(matrix, 2), 1e-300)
    inverse = np.linalg.inv(matrix + shift * np.eye(n))
    step, total = inverse @ (matrix - shift * np.eye(n)), 2.0 * shift * inverse.T @ inverse
    for _ in range(DOUBLINGS):
        added = step.T @ total @ step
        total = total + added
        if np.abs(added).max(initial=0.0) <= 1e-16 * np.abs(total).max(initial=1.0):
            break
        step = step @ step
    return 0.5 * (total + total.T)


def second_order_energy(topology, damping):
    """Return ``V = p^T L p/2 + |v|^2/2`` of ``v' = -L (p + g v)``, undirected, and ``D = g v^T L v``.

    v less the common velocity, which stays.  Over a directed graph ``V = x^T P x``, ``D = |x|^2`` of
    what robots do not share, ``x = (U^T p, U^T v)``; None where that grows.  Ren and Atkins, 2007.
    """
    if topology.directed:
        return _second_order_error(topology.laplacian(), damping)
    first, second, weights = topology.arcs

    def stretched(x):
        return 0.5 * float((weights * ((x[first] - x[second]) ** 2).sum(axis=1)).sum())

    def value(hand, velocity, time):
        slip = velocity - velocity.mean(axis=0)
        return 0.5 * stretched(hand) + 0.5 * float((slip**2).sum())

    def dissipation(hand, velocity, time):
        return damping * stretched(velocity)

    return Energy("$V = p^T L p/2 + |v|^2/2$ [m$^2$/s$^2$]", value, dissipation, True)


def _second_order_error(laplacian, damping):
    basis = unshared(len(laplacian))
    among = basis.T @ laplacian @ basis
    nothing, one = np.zeros_like(among), np.eye(len(among))
    matrix = np.block([[nothing, -one], [among, damping * among]])
    if np.linalg.eigvals(matrix).real.min(initial=1.0) <= 0.0:
        return None

    def error(hand, velocity, time):
        return np.concatenate([basis.T @ hand, basis.T @ velocity])

    return error_energy(matrix, 1.0, error, moving=True)


def edge_energy(pairs, of_length, slope, gain, name):
    """Return ``V = sum over pairs of of_length(d)`` and ``D = gain sum_i |grad_i V|^2``, robots from 0.

    ``of_length`` and its derivative ``slope`` are functions of the pairs' distances d (m,) [m].
    """
    first, second = np.asarray(pairs, dtype=int).reshape(-1, 2).T

    def value(hand):
        return float(of_length(np.linalg.norm(hand[first] - hand[second], axis=1)).sum())

    def dissipation(hand):
        apart = hand[first] - hand[second]
        distance = np.linalg.norm(apart, axis=1)
        pull = (slope(distance) / np.maximum(distance, 1e-12))[:, np.newaxis] * apart
        total = np.zeros_like(hand)
        np.add.at(total, first, pull)
        np.add.at(total, second, -pull)
        return gain * float((total**2).sum())

    return Energy(name, value, dissipation)


def tension_energy(pairs, radius, gain):
    """Return ``V = sum d^2/(D - d)`` over ``pairs`` (m, 2), D = ``radius``: Ji and Egerstedt, 2007."""

    def slope(d):
        return (2.0 * radius * d - d**2) / (radius - d) ** 2

    return edge_energy(pairs, lambda d: d**2 / (radius - d), slope, gain, "edge tension [m]")


def length_energy(topology, places, gain):
    """Return ``V = sum_edges a_ij (d^2 - d_ij^2)^2/4``, ``d_ij`` the lengths of ``places`` (n, d) [m].

    Krick, Broucke and Francis, 2009.
    """
    first, second, weights = _edges(topology)
    pairs = np.stack([first, second], axis=1)
    wanted = ((places[first] - places[second]) ** 2).sum(axis=1)
    return edge_energy(
        pairs,
        lambda d: 0.25 * weights * (d**2 - wanted) ** 2,
        lambda d: weights * (d**2 - wanted) * d,
        gain,
        "potential of the lengths [m$^4$]",
    )


def _edges(topology):
    """Return rows and weights of the arcs of an undirected graph, each pair once."""
    first, second, weights = topology.arcs
    once = first < second
    return first[once], second[once], weights[once]


def _units(apart):
    return apart / np.maximum(np.linalg.norm(apart, axis=1), 1e-12)[:, np.newaxis]


def bearing_energy(topology, goal, gain):
    """Return ``V = |p - p*|^2/2`` of the law by bearings alone, and its dissipation.

    ``goal``: p*, (n, d) [m], with the wanted bearings and the centroid and scale of the start, which
    stay.  ``D = gain sum_edges a_ij |p*_ij| g*_ij^T P(g_ij) g*_ij``.  Zhao and Zelazo, 2016.
    """
    first, second, weights = _edges(topology)
    far = goal[first] - goal[second]
    wanted = _units(far)
    stretch = weights * np.linalg.norm(far, axis=1)

    def value(hand):
        return 0.5 * float(((hand - goal) ** 2).sum())

    def dissipation(hand):
        along = (wanted * _units(hand[first] - hand[second])).sum(axis=1)
        return gain * float((stretch * (1.0 - along**2)).sum())

    return Energy("$V = |p - p^*|^2/2$ [m$^2$]", value, dissipation)


def bearing_leaders_energy(topology, places, gain, leaders):
    """Return ``V = sum_edges a_ij |P(g*_ij)(p_i - p_j)|^2/2``, the first ``leaders`` standing.

    ``D = gain sum_i |grad_i V|^2`` over the followers.  Zhao and Zelazo, 2016.
    """
    first, second, weights = _edges(topology)
    wanted = _units(places[first] - places[second])

    def across(hand):
        apart = hand[first] - hand[second]
        return apart - (apart * wanted).sum(axis=1)[:, np.newaxis] * wanted

    def value(hand):
        return 0.5 * float((weights * (across(hand) ** 2).sum(axis=1)).sum())

    def dissipation(hand):
        pull, total = weights[:, np.newaxis] * across(hand), np.zeros_like(hand)
        np.add.at(total, first, pull)
        np.add.at(total, second, -pull)
        return gain * float((total[leaders:] ** 2).sum())

    return Energy("$V$ of the bearings [m$^2$]", value, dissipation)


def flock_energy(law, middle, leader):
    """Return ``E = sum_pairs psi + c1 |p - p_r|^2/2 + |v - v_r|^2/2`` of algorithm 2, and its dissipation.

    ``law`` has ``distance``, ``reach`` [m], ``strength``, ``alignment``, ``c1``, ``c2``; the virtual leader
    goes from ``middle`` (d,) [m] with ``leader`` (d,) [m/s].  ``D = c2 |v - v_r|^2 + alignment sum_pairs
    rho(z) |v_i - v_j|^2``.  Olfati-Saber, 2006.
    """
    reach, rest = _sigma(law.reach), _sigma(law.distance)
    z = np.linspace(0.0, reach, TABLE)
    force = law.strength * _bump(z / reach) * (z - rest) / np.sqrt(1.0 + (z - rest) ** 2)
    grown = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(z))])

    def pairs(x):
        first, second = np.triu_indices(len(x), 1)
        return x[first] - x[second]

    def near(hand):
        return _sigma(np.linalg.norm(pairs(hand), axis=1))

    def value(hand, velocity, time):
        potential = (np.interp(near(hand), z, grown) - np.interp(rest, z, grown)).sum()
        away, slip = hand - middle - time * leader, velocity - leader
        return float(potential + 0.5 * law.c1 * (away**2).sum() + 0.5 * (slip**2).sum())

    def dissipation(hand, velocity, time):
        shared = (_bump(near(hand) / reach) * (pairs(velocity) ** 2).sum(axis=1)).sum()
        return float(law.c2 * ((velocity - leader) ** 2).sum() + law.alignment * shared)

    return Energy("$E$ of the flock [m$^2$/s$^2$]", value, dissipation, True)


def agreement_energy(gain, beta, reach):
    """Return ``V = sum |v_i - mean v|^2/2`` of Cucker and Smale, 2007, and its dissipation.

    ``D = gain/n sum_pairs (1 + (|p_ij|/reach)^2)^-beta |v_i - v_j|^2``.
    """

    def value(hand, velocity, time):
        return 0.5 * float(((velocity - velocity.mean(axis=0)) ** 2).sum())

    def dissipation(hand, velocity, time):
        first, second = np.triu_indices(len(hand), 1)
        far = ((hand[first] - hand[second]) ** 2).sum(axis=1)
        heard = (1.0 + far / reach**2) ** -beta
        slip = ((velocity[first] - velocity[second]) ** 2).sum(axis=1)
        return gain / len(hand) * float(heard @ slip)

    return Energy("$V = |v - \\bar v|^2/2$ [m$^2$/s$^2$]", value, dissipation, True)


def _sigma(distance):
    return (np.sqrt(1.0 + EPSILON * distance**2) - 1.0) / EPSILON


def _bump(share):
    falling = 0.5 * (1.0 + np.cos(np.pi * (share - BUMP) / (1.0 - BUMP)))
    return np.where(share < BUMP, 1.0, np.where(share <= 1.0, falling, 0.0))


def coverage_energy(samples, density, gain):
    """Return the locational cost ``H`` and ``D = 2 gain sum_i M_i |C_i - p_i|^2``.

    ``H = sum_q phi(q) min_i |q - p_i|^2 / sum_q phi(q)`` over the ``samples`` q (k, d) of ``density``
    phi (k,); ``M_i``, ``C_i`` are mass and centroid of the cell of robot i.  Cortes, Martinez, Karatas
    and Bullo, 2004.
    """
    share = density / density.sum()

    def cells(hand):
        squared = ((samples[:, np.newaxis] - hand[np.newaxis]) ** 2).sum(axis=2)
        return squared, squared.argmin(axis=1)

    def value(hand):
        squared, owner = cells(hand)
        return float(share @ squared[np.arange(len(samples)), owner])

    def dissipation(hand):
        owner = cells(hand)[1]
        mass = np.bincount(owner, share, len(hand))
        drawn = np.stack(
            [np.bincount(owner, share * column, len(hand)) for column in samples.T], axis=1
        )
        moment = drawn - mass[:, np.newaxis] * hand  # M_i (C_i - p_i)
        return 2.0 * gain * float((moment**2).sum(axis=1) @ (1.0 / np.maximum(mass, 1e-300)))

    return Energy("locational cost $H$ [m$^2$]", value, dissipation)
