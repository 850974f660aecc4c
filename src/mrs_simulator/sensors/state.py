"""The state of the robots at one time, as sensors read it."""

from typing import Any, NamedTuple, Tuple

import numpy as np


class State(NamedTuple):
    """True state of n robots."""

    time: float  # [s]
    pose: np.ndarray  # (n, 3) [m, m, rad] in the common frame
    twist: np.ndarray  # (n, 3) [m/s, m/s, rad/s] in the bodies' frames
    z: Any = None  # (n,) [m] heights, None on the ground
    spatial: Any = None  # ``core.spatial.Spatial``, None on the ground
    travel: Tuple[
        Any, ...
    ] = ()  # (m, wheels) [m] that the wheels of each group of the team have rolled
    contacts: Tuple[Any, ...] = ()  # (first, second, x, y) of each, names and place [m]

    def heights(self):
        """Return the robots' heights (n,) [m]."""
        return np.zeros(len(self.pose)) if self.z is None else self.z
