"""An extended Kalman filter of the poses of a team, and of the biases of what measures them.

Each robot has its own (Thrun, Burgard, Fox, Probabilistic Robotics, 3.3).  Its state is x, y, theta and b
biases, constant but for a random walk; odometry predicts it, measurements of the pose correct it.
"""

import numpy as np

from mrs_simulator.core.kinematics import compose, cos_sin, wrap_angle

CERTAIN = 1e-12  # [m^2, rad^2] the least variance of a sensor


class Filter:
    """Filters of n robots: ``pose`` (n, 3), ``bias`` (n, b), ``covariance`` (n, 3 + b, 3 + b).

    The arrays are replaced, never changed in place: ``state`` may be kept and restored.
    """

    def __init__(self, pose, covariance=None, biases=()):
        """``pose`` (n, 3) [m, m, rad] at first, known with ``covariance`` (n, 3, 3), by default exactly.

        ``biases`` (b,): variances of the biases at first; their means are 0.
        """
        self.pose = np.array(pose, dtype=float)
        n, b = len(self.pose), len(biases)
        self.bias = np.zeros((n, b))
        self.covariance = np.zeros((n, 3 + b, 3 + b))
        if covariance is not None:
            self.covariance[:, :3, :3] = covariance
        self.covariance[:, range(3, 3 + b), range(3, 3 + b)] = biases

    @property
    def state(self):
        """Return poses, biases and covariances; assigning them restores the filter."""
        return self.pose, self.bias, self.covariance

    @state.setter
    def state(self, state):
        self.pose, self.bias, self.covariance = state

    def move(self, moved, variances, rows=None, turning=None, walked=0.0):
        """Move robots ``rows``, by default all m = n, by ``moved`` (m, 3), each in its own frame.

        ``variances`` (m, 3) along its own axes; ``turning`` (m, b) [s]: how much of each bias the turn
        contains, which is taken off; ``walked`` (b,) or 0: variances by which biases wander meanwhile.

            p' = p + R(theta) d,   theta' = theta + d_theta - turning b,   P' = F P F^T + G Q G^T.
        """
        rows = slice(None) if rows is None else rows
        pose, covariance = self.pose[rows], self.covariance[rows]
        if turning is not None:
            moved = moved.copy()
            moved[:, 2] -= (turning * self.bias[rows]).sum(axis=1)
        cos, sin = cos_sin(pose[:, 2])
        x, y, size = moved[:, 0], moved[:, 1], covariance.shape[1]
        jacobian = np.tile(np.eye(size), (len(moved), 1, 1))
        turn = np.tile(np.eye(3), (len(moved), 1, 1))
        jacobian[:, 0, 2], jacobian[:, 1, 2] = -sin * x - cos * y, cos * x - sin * y
        if turning is not None:
            jacobian[:, 2, 3:] = -turning
        turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1] = cos, -sin, sin, cos
        covariance = jacobian @ covariance @ np.swapaxes(jacobian, 1, 2)
        covariance[:, :3, :3] += (turn * variances[:, np.newaxis]) @ np.swapaxes(turn, 1, 2)
        if size > 3:
            covariance[:, range(3, size), range(3, size)] += walked
        self._put(rows, np.array(compose(pose, moved)), self.bias[rows], covariance)

    def correct(self, rows, off, slope, variances):
        """Correct by measurements of robots ``rows`` (m,), given the innovations ``off`` (m, k).

        ``slope`` (m, k, 3 + b): of the expected values by the state; ``variances`` (k,).

            K = P H^T (H P H^T + R)^-1,   P' = (1 - K H) P (1 - K H)^T + K R K^T.
        """
        before = self.covariance[rows]
        noise = np.diag(np.maximum(variances, CERTAIN))
        back = np.swapaxes(slope, 1, 2)
        gain = before @ back @ np.linalg.inv(slope @ before @ back + noise)
        change = np.einsum("ijk,ik->ij", gain, off)
        pose = self.pose[rows] + change[:, :3]
        pose[:, 2] = wrap_angle(pose[:, 2])
        left = np.eye(before.shape[1]) - gain @ slope
        after = left @ before @ np.swapaxes(left, 1, 2) + gain @ noise @ np.swapaxes(gain, 1, 2)
        self._put(rows, pose, self.bias[rows] + change[:, 3:], after)

    def restart(self, rows, pose):
        """Put robots ``rows`` at ``pose`` (m, 3), which is known exactly; their biases stay."""
        covariance = self.covariance[rows]
        covariance[:, :3], covariance[:, :, :3] = 0.0, 0.0
        self._put(rows, pose, self.bias[rows], covariance)

    def _put(self, rows, *state):
        result = []
        for old, new in zip(self.state, state):
            changed = old.copy()
            changed[rows] = new
            result.append(changed)
        self.state = result
