"""Marching: a formation that moves along a path, and robots that keep their place beside a leader.

A path is a row of straight lines and arcs, passed at constant speed; ``s`` [m] is the way along it.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.edge_terms import difference_sum
from mrs_simulator.core.kinematics import arc, cos_sin, direction_of, wrap_angle
from mrs_simulator.protocols.common import level

PATHS = ("line", "circle", "eight", "polygon")


class Path(NamedTuple):
    """Pieces of constant curvature; after the last the first comes again."""

    begin: np.ndarray  # (k,) [m] s at which each piece begins
    pose: np.ndarray  # (k, 3) [m, m, rad] there, headings not wrapped
    curvature: np.ndarray  # (k,) [1/m]
    length: float  # [m] of one lap, inf for a path that does not return
    turn: float  # [rad] by which the heading grows in one lap

    def at(self, s):
        """Return the poses at ``s`` (m,) [m] from 0 on: (m, 3) [m, m, rad], headings not wrapped."""
        s = np.asarray(s, dtype=float)
        lap = np.floor(s / self.length)
        rest = s - np.where(lap > 0.0, lap * self.length, 0.0) if lap.any() else s
        piece = np.maximum(np.searchsorted(self.begin, rest, side="right") - 1, 0)
        unit = np.stack([np.ones(len(s)), self.curvature[piece]], axis=1)
        pose = arc(self.pose[piece], unit, (rest - self.begin[piece])[:, np.newaxis])
        pose[:, 2] += lap * self.turn
        return pose


def make_path(name, radius=4.0, waypoints=()):
    """Return the ``Path`` called ``name``, one of ``PATHS``, that leaves the origin along x.

    ``line``: straight on for ever; ``circle``: to the left; ``eight``: a circle to the left, then one
    to the right; ``polygon``: from the middle of the first side round the ``waypoints`` (k, 2) [m],
    wherever those are.  ``radius`` [m]: of the circles, and of the polygon's rounded corners.
    Raises ``ValueError`` for another name or a polygon whose corners do not fit.
    """
    if name == "polygon":
        return _polygon(np.asarray(waypoints, dtype=float), radius)
    lap, left, origin = 2.0 * np.pi * radius, 1.0 / radius, np.zeros(3)
    if name == "line":
        return _joined(origin, [np.inf], [0.0])
    if name == "circle":
        return _joined(origin, [lap], [left])
    if name == "eight":
        return _joined(origin, [lap, lap], [left, -left])
    raise ValueError("path {!r}: wanted one of {}".format(name, ", ".join(PATHS)))


def read_waypoints(text):
    """Return the waypoints (k, 2) [m] in ``text``, such as ``"0 0, 8 0, 8 6"``; ``ValueError``."""
    try:
        rows = [[float(value) for value in pair.split()] for pair in text.split(",")]
        points = np.array(rows, dtype=float).reshape(len(rows), 2)
    except ValueError:
        points = np.empty((0, 2))
    if len(points) < 3 or not np.isfinite(points).all() or np.abs(points).max() > 1e6:
        raise ValueError(
            "waypoints = {!r}: wanted at least three points, as in '0 0, 8 0, 8 6'".format(text)
        )
    return points


def reference(path, places, s, swing=1.0, turning=False):
    """Return where the robots are wanted, (m, n, d) [m], at ``s`` (m,) [m] along ``path``.

    ``places`` (n, d) about the path's point, ``swing`` (m,) times as large, turned by the path's
    heading where ``turning``.  In space the path is level, and the heading turns about the vertical.
    """
    pose = path.at(s)
    cos, sin = cos_sin(pose[:, 2] if turning else np.zeros(len(pose)))
    coordinates = [
        np.outer(cos, places[:, 0]) - np.outer(sin, places[:, 1]),
        np.outer(sin, places[:, 0]) + np.outer(cos, places[:, 1]),
        *(np.broadcast_to(heights, (len(pose), len(places))) for heights in places.T[2:]),
    ]
    turned = np.stack(coordinates, axis=2)
    path_points = level(pose[:, np.newaxis, :2], places.shape[1])
    return path_points + np.reshape(swing, (-1, 1, 1)) * turned


def marching(points, wanted, velocity, topology, gain, anchor=0.0):
    """Return ``u_i = v_i + gain sum_j a_ij (p_j - p_i - (d_j - d_i)) + anchor (d_i - p_i)``, (n, d).

    ``wanted`` d (n, d) [m] move at ``velocity`` v (n, d) [m/s]: the feed-forward, without which
    robots lag.  With it errors obey the displacement law and no steady error is left; ``gain`` and
    ``anchor`` in 1/s.  Oh, Park, Ahn, 2015.
    """
    keep = gain * difference_sum(points - wanted, topology)
    return velocity + keep + anchor * (wanted - points)


def leader_follower(pose, leader, command, separation, bearing, k1, k2, l):
    """Return the followers' ``(v, omega)``, (m, 2) [m/s, rad/s]: l-psi control.

    ``pose`` (m, 3) of the followers, ``leader`` (m, 3) and ``command`` (m, 2) of the robot that each
    follows.  The follower's hand point, ``l`` [m] ahead, is ``lambda`` [m] from the leader's centre,
    at the angle ``psi`` [rad] from its heading.  With ``gamma = theta_leader + psi - theta``

        rho = (k1 (separation - lambda) + v_leader cos psi) / cos gamma
        omega = cos gamma (k2 lambda (bearing - psi) - v_leader sin psi + lambda omega_leader
                           + rho sin gamma) / l
        v = rho - l omega tan gamma

    which gives ``lambda' = k1 (separation - lambda)`` and ``psi' = k2 (bearing - psi)``.  Written
    here without the divisions by ``cos gamma``.  Desai, Ostrowski, Kumar, 2001.
    """
    apart, psi = separation_and_bearing(pose, leader, l)
    gamma = leader[:, 2] + psi - pose[:, 2]
    v, omega = command.T
    along = k1 * (separation - apart) + v * np.cos(psi)
    across = apart * (omega + k2 * wrap_angle(bearing - psi)) - v * np.sin(psi)
    cos, sin = np.cos(gamma), np.sin(gamma)
    return np.stack([cos * along - sin * across, (sin * along + cos * across) / l], axis=1)


def separation_and_bearing(pose, leader, l):
    """Return ``lambda`` (...) [m] and ``psi`` (...) [rad] of poses (..., 3) beside a ``leader``."""
    cos, sin = cos_sin(pose[..., 2])
    x = pose[..., 0] + l * cos - leader[..., 0]
    y = pose[..., 1] + l * sin - leader[..., 1]
    return np.hypot(x, y), wrap_angle(np.arctan2(y, x) - leader[..., 2])


def _joined(first, length, curvature):
    """Return the path that begins at ``first`` (3,) with pieces of ``length`` and ``curvature``."""
    length, curvature = np.asarray(length, dtype=float), np.asarray(curvature, dtype=float)
    pose = [np.asarray(first, dtype=float)]
    for piece in zip(length, curvature):
        if np.isfinite(piece[0]):
            pose.append(arc(pose[-1][np.newaxis], np.array([[1.0, piece[1]]]), piece[0])[0])
    begin = np.concatenate([[0.0], np.cumsum(length)[:-1]])
    turn = pose[-1][2] - pose[0][2] if np.isfinite(length).all() else 0.0
    return Path(begin, np.array(pose[: len(length)]), curvature, float(length.sum()), turn)


def _polygon(corner, radius):
    side = np.roll(corner, -1, axis=0) - corner
    long = np.linalg.norm(side, axis=1)
    heading = direction_of(side)
    # The turn at the end of each side, and how much of the side its rounding takes.
    angle = wrap_angle(np.roll(heading, -1) - heading)
    cut = radius * np.tan(0.5 * np.abs(angle))
    room = np.minimum(long, np.roll(long, -1)) / 2.0
    if np.any(cut > room) or np.any(long <= 0.0):
        worst = int(np.argmax(cut - room))
        raise ValueError(
            "radius = {:g}: the corner at waypoint {} has room for {:.3g} m; wanted a smaller radius "
            "or other waypoints".format(
                radius, (worst + 1) % len(corner) + 1, radius * room[worst] / max(cut[worst], 1e-12)
            )
        )
    straight = long - cut - np.roll(cut, 1)
    pieces = [(0.5 * long[0] - cut[0], 0.0)]
    for k in range(len(corner)):
        pieces.append((radius * abs(angle[k]), np.sign(angle[k]) / radius))
        pieces.append((straight[(k + 1) % len(corner)], 0.0))
    pieces[-1] = (0.5 * long[0] - cut[-1], 0.0)
    middle = corner[0] + 0.5 * side[0]
    pieces = [piece for piece in pieces if piece[0] > 0.0]
    return _joined([middle[0], middle[1], heading[0]], *zip(*pieces))
