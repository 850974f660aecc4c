"""Flocking: velocities agree, robots keep together and apart."""

import functools
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.edge_terms import apart, inner, pair_sum, weighted_differences
from mrs_simulator.core.kinematics import phase_of
from mrs_simulator.core.neighbours import all_pairs, close_pairs

EPSILON = 0.1  # [1/m^2] of the sigma-norm, as published
BUMP_START = 0.2  # [-] share of the range up to which the bump function is 1, as published
POTENTIAL_STEPS = 4000  # [-] of the table of the pair potential
MOST_LOG_DISTANCE = 700.0  # [-] e to this is still a number


# Flocking, algorithm 2 of Olfati-Saber -----------------------------------------------------------


class Lattice(NamedTuple):
    """The pair force of flocking: wanted distance d and range r [m], 0 < a <= b [m/s^2] its strength."""

    distance: float
    reach: float
    a: float = 1.0
    b: float = 1.0


def sigma_norm(squared):
    """Return ``(sqrt(1 + eps |z|^2) - 1)/eps``, the shape of ``squared`` |z|^2 [m^2]."""
    return (np.sqrt(1.0 + EPSILON * squared) - 1.0) / EPSILON


def bump(z, start):
    """Return the bump function rho_h: 1 below h = ``start``, smoothly down to 0 at 1 and beyond.

    ``z``: an array of the arguments.
    """
    falling = 0.5 * (1.0 + np.cos(np.pi * (z - start) / (1.0 - start)))
    return np.where(z < start, 1.0, np.where(z <= 1.0, falling, 0.0))


def pair_force(z, lattice):
    """Return ``phi_alpha(z) = rho_h(z/r_a) phi(z - d_a)`` [m/s^2] of sigma-distances ``z``.

    ``phi(z) = ((a + b) s(z + c) + (a - b))/2`` with ``s(z) = z/sqrt(1 + z^2)`` and
    ``c = |a - b|/sqrt(4ab)``: negative, pushing, below d_a; positive above; zero from r_a on.
    """
    a, b = lattice.a, lattice.b
    shifted = z - sigma_norm(lattice.distance**2) + abs(a - b) / np.sqrt(4.0 * a * b)
    pull = 0.5 * ((a + b) * shifted / np.sqrt(1.0 + shifted**2) + a - b)
    return bump(z / sigma_norm(lattice.reach**2), BUMP_START) * pull


def flocking(points, velocities, lattice, alignment, leader, c1, c2):
    """Return the accelerations ``u_i`` (n, d) [m/s^2] of algorithm 2.

    ``u_i = sum_j phi_alpha(|p_j - p_i|_s) n_ij + alignment sum_j a_ij (v_j - v_i) - c1 (p_i - p_r)
    - c2 (v_i - v_r)``, over neighbours within ``lattice.reach``; ``a_ij = rho_h(|p_ij|_s/r_a)``,
    ``n_ij = p_ij/sqrt(1 + eps |p_ij|^2)``; ``leader`` (2, d) holds the gamma agent's place p_r [m] and
    velocity v_r [m/s], constant; ``c1`` [1/s^2], ``c2``, ``alignment`` [1/s].

    With all gains above 0 :func:`flocking_energy` never increases, velocities agree on v_r, and no
    robot is ever farther than ``sqrt(2 E(0)/c1)`` from p_r.  Olfati-Saber, 2006.
    """
    pairs = close_pairs(points, lattice.reach)
    among = pair_sum(alpha, pairs, points, apart(velocities, pairs), lattice, alignment)
    return among - c1 * (points - leader[0]) - c2 * (velocities - leader[1])


def alpha(apart, slip, lattice, alignment):
    """Return the term ``phi_alpha n_ij + alignment a_ij (v_j - v_i)``, ``slip`` being ``v_j - v_i``."""
    squared = inner(apart, apart)
    z = sigma_norm(squared)
    pull = pair_force(z, lattice) / np.sqrt(1.0 + EPSILON * squared)
    agreement = alignment * bump(z / sigma_norm(lattice.reach**2), BUMP_START)
    return pull * apart + agreement * slip


def flocking_energy(points, velocities, lattice, leader, c1):
    """Return ``E = V + sum c1 |p_i - p_r|^2/2 + sum |v_i - v_r|^2/2`` [m^2/s^2], relative to the leader.

    V is the sum over pairs of ``psi(z)``, the integral of :func:`pair_force` from d_a to z.
    """
    between = apart(points, all_pairs(len(points)))
    potential = pair_potential(sigma_norm(inner(between, between)), lattice).sum()
    away, slip = points - leader[0], velocities - leader[1]
    return float(potential + 0.5 * (c1 * np.sum(away**2) + np.sum(slip**2)))


def pair_potential(z, lattice):
    """Return ``psi(z) = integral of phi_alpha from d_a to z``, the shape of ``z``; 0 at d_a, else above."""
    return np.interp(z, *_potential(lattice))


@functools.lru_cache(maxsize=8)
def _potential(lattice):
    """Return the sigma-distances of a table of ``psi``, and psi there."""
    table = np.linspace(0.0, sigma_norm(lattice.reach**2), POTENTIAL_STEPS + 1)
    force = pair_force(table, lattice)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(table) * (force[1:] + force[:-1]))])
    rest = np.interp(sigma_norm(lattice.distance**2), table, integral)
    return table, integral - rest


def stiffness(lattice):
    """Return by how much [1/s^2] the pair potential psi curves at most, per ``a_ij``, over distances r [m].

    Along a pair it curves by ``f'(r)``, across it by ``f(r)/r``, with the force ``f``, which is
    ``phi_alpha(z) r/sqrt(1 + eps r^2)``.
    """
    distance = np.linspace(0.0, lattice.reach, POTENTIAL_STEPS + 1)[:-1]
    z = sigma_norm(distance**2)
    force = pair_force(z, lattice) * distance / np.sqrt(1.0 + EPSILON * distance**2)
    along, across = np.gradient(force, distance), force[1:] / distance[1:]
    curved = np.maximum(along, np.append(0.0, across))
    return float((curved / bump(z / sigma_norm(lattice.reach**2), BUMP_START)).max())


def held_flock(n, lattice, alignment, c1, c2, period):
    """Return ``max Tc (c^2 + k)/(2 c)`` over the modes of a flock of n whose neighbours stay the same.

    Below 1 commands held for ``period`` Tc [s] never raise its energy.  A mode of the Laplacian of
    ``a_ij``, with the eigenvalue b up to n, is damped by ``c = c2 + alignment b``; the potential is no
    stiffer along it than ``k = c1 + b`` :func:`stiffness`.  From ``v+ = v - Tc (grad V + c v)`` and
    ``V(x + Tc v+) <= V(x) + Tc v+ . grad V + k Tc^2 |v+|^2/2``,

        E+ - E <= Tc (-c |v+|^2 + c v+ . (v+ - v)) - |v+ - v|^2/2 + k Tc^2 |v+|^2/2
               <= Tc (-c + Tc c^2/2 + Tc k/2) |v+|^2.
    """
    most = n if n > 1 else 0  # b of a graph of all pairs
    stiff = np.array([c1, c1 + most * stiffness(lattice)])
    damping = np.array([c2, c2 + most * alignment])
    # What the bound lacks or exceeds is convex in b: largest at an end.
    return float((period * (damping**2 + stiff) / (2.0 * damping)).max())


# Cucker and Smale --------------------------------------------------------------------------------


def cucker_smale(points, velocities, beta, reach=1.0):
    """Return the accelerations ``1/n sum_j psi(|p_j - p_i|) (v_j - v_i)``, (n, d) [m/s^2] per gain.

    ``psi(r) = (1 + (r/reach)^2)^-beta``.  Velocities agree from any start if ``beta <= 1/2``, else
    from starts within :func:`flock_bound`.  Cucker and Smale, 2007; the factor 1/n as in Ha and
    Liu, 2009.
    """
    return weighted_differences(influence, points, velocities, beta, reach, 1.0 / len(points))


def influence(apart, beta, reach, share):
    """Return the weight ``share psi(|p_j - p_i|)``."""
    return share * (1.0 + inner(apart, apart) / reach**2) ** -beta


def communication(distance, beta, reach=1.0):
    """Return ``psi(r) = (1 + (r/reach)^2)^-beta`` of ``distance`` r [m]."""
    return (1.0 + (np.asarray(distance) / reach) ** 2) ** -beta


def flock_bound(size, spread, gain, beta, reach=1.0):
    """Return the bound [m] on the flock's diameter for ever, or inf if theory promises no flock.

    The x with ``gain integral of psi from size to x = spread``: ``size`` [m] and ``spread`` [m/s] are
    the largest distance and difference of velocities at the start.  With it the spread is at most
    ``spread exp(-gain psi(x) t)``, since ``spread' <= -gain psi(size) spread``.
    """
    wanted = spread / (gain * reach)
    begin = np.arcsinh(size / reach)
    # With r = reach sinh(s), psi dr = reach cosh(s)^(1 - 2 beta) ds, which grows where beta < 1/2.
    length = wanted if beta <= 0.5 else min(MOST_LOG_DISTANCE - begin, 40.0 / (2.0 * beta - 1.0))
    s = np.linspace(begin, begin + length, 20001)
    density = np.exp((1.0 - 2.0 * beta) * (np.logaddexp(s, -s) - np.log(2.0)))
    total = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(s) * (density[1:] + density[:-1]))])
    if total[-1] < wanted * (1.0 - 1e-6):
        return np.inf
    return float(reach * np.sinh(np.interp(wanted, total, s)))


def diameter(points):
    """Return the largest distance between two of ``points`` (n, d); 0 of one."""
    between = apart(points, all_pairs(len(points)))
    return float(np.sqrt(inner(between, between).max(initial=0.0)))


# Vicsek ------------------------------------------------------------------------------------------


def vicsek(points, headings, radius, disturbance):
    """Return the new headings (n,) [rad]: the mean direction of all within ``radius`` plus noise.

    ``theta_i+ = arg sum_j exp(i theta_j) + xi_i`` over robots j, itself too, closer than ``radius`` [m];
    ``disturbance`` xi (n,) [rad] is uniform in +-eta/2.  Vicsek and others, 1995.
    """
    near = _apart(points)[1] < radius**2
    mean = near @ np.exp(1j * np.asarray(headings))
    # Directions that cancel out leave a robot its own.
    turned = np.where(np.abs(mean) > 1e-12, phase_of(mean), headings)
    return phase_of(np.exp(1j * (turned + disturbance)))


def order(velocities):
    """Return the order parameter of ``velocities`` (..., n, d), (...,): 1 parallel, about 0 disordered."""
    speed = np.linalg.norm(velocities, axis=-1, keepdims=True)
    direction = velocities / np.where(speed > 0.0, speed, 1.0)
    return np.linalg.norm(direction.mean(axis=-2), axis=-1)


def vicsek_order(noise, n):
    """Return the root mean square order of n robots that all receive from all, under ``noise`` eta [rad].

    ``sqrt(s^2 + (1 - s^2)/n)``, ``s = sin(eta/2)/(eta/2)`` the mean of ``exp(i xi)``: exact, and a bound
    where robots receive from fewer.
    """
    s = np.sinc(0.5 * noise / np.pi)
    return float(np.sqrt(s**2 + (1.0 - s**2) / n))


# Reynolds ----------------------------------------------------------------------------------------


def reynolds(points, velocities, radius, separation, alignment, cohesion):
    """Return the accelerations (n, d) [m/s^2] of Reynolds' three rules, 1987, in a common form.

    Over the neighbours j closer than ``radius`` [m]: ``separation sum (p_i - p_j)/|p_ij|^2``,
    ``alignment (mean v_j - v_i)`` and ``cohesion (mean p_j - p_i)``; gains in m^2/s^2, 1/s and 1/s^2.
    No theorem is known for them.
    """
    pairs = close_pairs(points, radius)
    neighbours = np.bincount(np.concatenate(pairs), minlength=len(points))
    share = 1.0 / np.maximum(neighbours, 1)[:, np.newaxis]
    gather = share * pair_sum(difference, pairs, points)
    align = share * pair_sum(difference, pairs, velocities)
    return alignment * align + cohesion * gather + separation * pair_sum(repulsion, pairs, points)


def difference(apart):
    """Return the term ``x_j - x_i``."""
    return apart


def repulsion(apart):
    """Return the term ``(p_i - p_j)/|p_ij|^2``, zero where points coincide."""
    squared = inner(apart, apart)
    return -apart / np.where(squared > 0.0, squared, 1.0)


def within_speeds(velocities, low, high):
    """Return ``velocities`` (n, d) with each speed brought into [low, high] [m/s]; zero stays zero."""
    speed = np.linalg.norm(velocities, axis=1, keepdims=True)
    return velocities * np.clip(speed, low, high) / np.where(speed > 0.0, speed, 1.0)


# Distances ---------------------------------------------------------------------------------------


def groups(points, radius):
    """Return into how many groups robots closer than ``radius`` [m] make of ``points`` (n, d)."""
    first, second = close_pairs(points, radius)
    group = np.arange(len(points))
    while True:
        # Both ends of each pair join the lower group, and groups that joined another follow it.
        joined = group.copy()
        np.minimum.at(joined, group[first], group[second])
        np.minimum.at(joined, group[second], group[first])
        joined = joined[joined]
        if np.array_equal(joined, group):
            return len(np.unique(group))
        group = joined


def _apart(points):
    """Return ``p_j - p_i`` (n, n, d) and its length squared (n, n)."""
    apart = points[np.newaxis] - points[:, np.newaxis]
    return apart, np.einsum("ijk,ijk->ij", apart, apart)
