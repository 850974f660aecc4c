"""How wheels stand on the ground, for motion with forces."""

from typing import NamedTuple

import numpy as np


class Stand(NamedTuple):
    """w wheels of each of m robots; rows refer to the twist of the robot's centre.

    The ground under a wheel moves against it with ``along @ twist`` in the wheel's direction and with
    ``across @ twist`` across it; zero rows across for wheels with free rollers.
    """

    along: np.ndarray  # (m, w, 3)
    across: np.ndarray  # (m, w, 3)
    weight: np.ndarray  # (m, w) [-], share of the robot's weight; times friction the greatest force
    # (m, w) [N], greatest force of the motor at the rim, 0 for a wheel that runs freely
    push: np.ndarray
    ahead: np.ndarray  # (m,) [m] of the centre of mass from the centre
