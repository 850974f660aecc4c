"""The paper's discrete-time formation law (6) on hand points, and what theory says of it.

Robot i steers its hand point ``alpha_i`` to a target ``alpha_i*`` that its neighbours define.
For a straight line parallel to the x axis with separation ``c``, robot i belongs at
``d_i = ((n - i) c, 0)`` relative to robot n, in space at ``((n - i) c, 0, 0)``, and

    alpha_i* = sum_j a_ij (alpha_j + d_i - d_j) / sum_j a_ij,

which is ``alpha_{i+1} + (c, 0)`` where i receives only from i+1.  A robot without neighbours stands still.
"""

import numpy as np

from mrs_simulator.core.edge_terms import flow_to_mean, from_mean
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import HAND_LENGTH
from mrs_simulator.core.neighbours import squared
from mrs_simulator.core.sample_blocks import blocks
from mrs_simulator.core.spectra import left_null_vector

CLOSURES = ("chain", "cycle", "path", "topology")
MOST_STEPS = 10**9  # [-] of the law that are looked ahead for when it settles
FEW = 50  # [-] robots, of whom all steps at once cost less than one after the other
SMALL_TEAM = 200  # [-] robots, whose powers of a matrix cost little
MOST_ROBOT_STEPS = 10**7  # [-] the same times robots: some seconds of arithmetic


# The paper's law, described once for scenarios, launch files, ROS and forms.
PARAMETERS = (
    Parameter(
        "k",
        0.02,
        **POSITIVE,
        high=1.0,
        open_high=True,
        meaning="share of the error removed in each step T",
        why="alpha+ = (1-k) alpha + k alpha* diverges for k <= 0 and overshoots for k >= 1",
    ),
    Parameter("T", 0.1, "s", **POSITIVE, high=1e3, meaning="step of the discrete-time law"),
    HAND_LENGTH,
    Parameter("c", 2.0, "m", low=-1e3, high=1e3, meaning="separation along the line"),
    Parameter(
        "closure",
        "chain",
        choices=CLOSURES,
        meaning="who closes the chain: none, robot 1, both neighbours, or the topology",
    ),
)


def line_offsets(n, c, dimension=2):
    """Return ``d``, shape (n, d) [m]: ``d_i = ((n - i) c, 0, ...)``, the line with separation c [m]."""
    offsets = np.zeros((n, dimension), order="F")
    offsets[:, 0] = c * np.arange(n - 1, -1, -1)
    return offsets


def closure_topology(closure, n, topology=None):
    """Return the graph of a closure of the paper's chain: who defines whose target.

    ``chain``: robot n stands still; ``cycle``: robot n receives from robot 1; ``path``: each receives
    from its one or two neighbours; ``topology``: the given graph.  Raises ``ValueError`` if that is
    missing.
    """
    if closure != "topology":
        return Topology.preset(closure, n)
    if topology is None:
        raise ValueError('closure "topology": the scenario has no topology, wanted one')
    return topology


def target_errors(hand, offsets, topology):
    """Return ``alpha_i - alpha_i*``, shape (n, d) [m], zero for a robot without neighbours."""
    return from_mean(hand - offsets, topology)


def formation_flow(offsets, topology, k, T):
    """Return the ``Flow`` ``u_i = -(k/T)(alpha_i - alpha_i*)``, (n, d) [m/s], law (6) before mapping (7).

    With step ``T`` [s] it gives (5), ``alpha+ = (1-k) alpha + k alpha*``.
    """
    return flow_to_mean(k / T, topology, offsets)


def predict(hand, offsets, topology, k, steps):
    """Return the hand points of (5), shape (steps + 1, n, d) [m], from ``hand`` (n, d)."""
    return predicted_after(np.arange(steps + 1), hand, offsets, topology, k)


def predicted_after(steps, hand, offsets, topology, k):
    """Return the hand points of (5) after each of so many ``steps`` (m,), (m, n, d) [m].

    Of a few robots by powers of (5)'s matrix, where ``steps`` are evenly spaced, else step by step.
    """
    distinct, place = np.unique(steps, return_inverse=True)
    if len(distinct) and len(hand) <= FEW and len(np.unique(np.diff(distinct))) <= 1:
        track = _by_powers(distinct, hand - offsets, topology, k) + offsets
        if np.isfinite(track).all():
            return track[place]
    track = np.empty((len(distinct),) + hand.shape)
    for row, count in enumerate(np.diff(distinct, prepend=0)):
        for _ in range(count):
            hand = hand - k * target_errors(hand, offsets, topology)
        track[row] = hand
    return track[place]


@np.errstate(all="ignore")
def _by_powers(steps, away, topology, k):
    """Return ``away`` (n, d) after each of evenly spaced ``steps`` of ``I - k M``, M of the errors.

    From the first K of them the next K follow by a power of the matrix, as the errors are linear.
    """
    step = np.eye(len(away)) - k * from_mean(np.eye(len(away)), topology)
    track, known = np.empty((len(steps),) + away.shape), 1
    track[0] = np.linalg.matrix_power(step, steps[0]) @ away
    power = np.linalg.matrix_power(step, steps[1] - steps[0]) if len(steps) > 1 else step
    while known < len(steps):
        more = min(known, len(steps) - known)
        track[known : known + more] = power @ track[:more]
        power, known = power @ power, known + more
    return track


def limit(hand, offsets, topology):
    """Return where (5) goes, shape (n, d) [m]: ``d + w^T (alpha(0) - d)``, ``w^T (I - D^-1 A) = 0``.

    ``w`` is the left null vector of L times the degrees: of the chain robot n alone, of the cycle
    the mean, of the path weights 1, 2, ..., 2, 1.  Without edges all stand.  Raises
    ``ValueError`` if the graph has edges and no spanning tree.
    """
    if not topology.edges:
        return hand
    degree = topology.in_degree()
    # A root without neighbours is where all go.
    weights = left_null_vector(topology) * (degree if degree.all() else 1.0)
    return offsets + weights @ (hand - offsets) / weights.sum()


def error_norm(hand, offsets, topology):
    """Return the largest ``|alpha_i - alpha_i*|`` [m] over the robots."""
    return _largest(target_errors(hand, offsets, topology))


def error_norms(hand, offsets, topology):
    """Return the largest ``|alpha_i - alpha_i*|`` [m] in each of the samples ``hand`` (m, n, d), (m,)."""
    if topology.n > SMALL_TEAM:
        parts = (hand[rows] for rows in blocks(len(hand), topology.n))
        return np.array(
            [error_norm(points, offsets, topology) for part in parts for points in part]
        )
    errors = from_mean(np.eye(topology.n), topology)  # of each other robot's place: they are linear
    result = np.empty(len(hand))
    for rows in blocks(len(hand), topology.n):
        squares = squared(errors @ (hand[rows] - offsets))
        result[rows] = np.sqrt(squares.max(axis=1))
    return result


def _largest(errors):
    return float(np.sqrt(squared(errors).max()))


def settling_index(errors, share):
    """Return the first index from which ``errors`` (m,) stays below ``share`` of its first value.

    Returns ``len(errors)`` when it never does.
    """
    errors = np.asarray(errors)
    above = np.flatnonzero(errors >= share * errors[0])
    if errors[0] == 0.0 or not len(above):
        return 0
    return int(above[-1]) + 1


def predicted_settling(hand, offsets, topology, k, share):
    """Return the number of steps of (5) until the largest error is below ``share`` of its start.

    It stays there: (5) replaces errors by means of errors.  So small teams need few powers of its matrix
    only, found by bisection.  Returns ``None`` where ``k`` is 1 or more, or if it takes more than
    ``MOST_STEPS``, in larger teams ``MOST_ROBOT_STEPS`` over the number of robots.
    """
    if k >= 1.0:
        return None
    if len(hand) <= SMALL_TEAM:
        return _settling_by_powers(hand - offsets, topology, k, share)
    errors = target_errors(hand, offsets, topology)
    first = _largest(errors)
    if first == 0.0:
        return 0
    for step in range(1, min(MOST_STEPS, MOST_ROBOT_STEPS // len(hand))):
        hand = hand - k * errors
        errors = target_errors(hand, offsets, topology)
        if _largest(errors) < share * first:
            return step
    return None


def _settling_by_powers(away, topology, k, share):
    """Return the same by squaring ``I - k M``, with ``M away`` the errors of ``away`` (n, d) [m]."""
    errors = np.eye(len(away)) - topology.neighbour_mean(np.eye(len(away)))
    wanted = share * _largest(errors @ away)
    if wanted == 0.0:
        return 0
    powers = [np.eye(len(away)) - k * errors]
    while _largest(errors @ powers[-1] @ away) >= wanted:
        if 2 ** len(powers) > MOST_STEPS:
            return None
        powers.append(powers[-1] @ powers[-1])
    # The last power is far enough; of the others those are taken after which it is not yet.
    step = 0
    for exponent in reversed(range(len(powers) - 1)):
        ahead = powers[exponent] @ away
        if _largest(errors @ ahead) >= wanted:
            away, step = ahead, step + 2**exponent
    return step + 1


def largest_stable_period(k, T, l, e_max, omega_max):
    """Return the longest command period [s] that is safe on a unicycle.

    The held arc contracts for sure while ``Tc <= l / (kappa e_max)``, ``kappa = k/T``, with
    ``e_max`` [m] the largest error, or while ``omega_max Tc <= 1``: limiting the turn rate bounds
    the rotation of the error in one period.  The larger of the two is returned.
    """
    by_error = l * T / (k * e_max) if e_max > 0.0 else np.inf
    by_limit = 1.0 / omega_max if omega_max > 0.0 else np.inf
    return max(by_error, by_limit)


def line_gaps(hand):
    """Return the gaps between consecutive robots along x, shape (n-1,) [m]: ``x_i - x_{i+1}``."""
    return hand[:-1, 0] - hand[1:, 0]


def y_spread(hand):
    """Return ``max y - min y`` [m] over the robots; in space the larger of that and the same of z."""
    return float(np.ptp(hand[:, 1:], axis=0).max())
