"""Trajectories of an arm's joints, as points that are passed at given times on straight lines."""

import numpy as np


class PathError(ValueError):
    """A trajectory that an arm cannot follow; the message says what came and what was wanted."""


class JointPath:
    """A path of joints from where they are through points at given times, ending at rest."""

    def __init__(self, chain, begin, names, points, times):
        """``chain``: the arm's; ``begin`` (k,) [rad] where it is; ``names`` of joints, all of the arm's.

        ``points`` (p, k) [rad], in the order of ``names``; ``times`` (p,) [s] after the begin, ascending.
        Raises ``PathError``.
        """
        if sorted(names) != sorted(chain.joints):
            text = "joints {}, wanted {}"
            raise PathError(text.format(", ".join(names) or "none", ", ".join(chain.joints)))
        order = [list(names).index(name) for name in chain.joints]
        if any(len(point) != len(order) for point in points):
            raise PathError("points of other sizes, wanted {} positions each".format(len(order)))
        points = np.array(points, dtype=float).reshape(-1, len(order))[:, order]
        times = np.array(times, dtype=float)
        if not np.isfinite(points).all() or ((points < chain.lower) | (points > chain.upper)).any():
            raise PathError("a position beyond an end of its joint, wanted finite ones between")
        if len(times) and (times[0] < 0.0 or (np.diff(times) <= 0.0).any()):
            raise PathError("times from the start {}, wanted ascending".format(times[:5].tolist()))
        self._times = np.concatenate([[0.0], times])
        self._points = np.concatenate([[begin], points])

    @property
    def end(self):
        """Return the duration [s]."""
        return float(self._times[-1])

    def at(self, time):
        """Return the wanted joints (k,) [rad] at ``time`` [s] after the start."""
        return np.array([np.interp(time, self._times, column) for column in self._points.T])
