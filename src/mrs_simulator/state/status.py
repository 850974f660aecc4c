"""What a simulation and a controller report of themselves."""

from typing import NamedTuple, Tuple

import numpy as np


class Controller(NamedTuple):
    """Status of a control node."""

    stamp: float  # [s]
    protocol: str
    period: float  # [s]
    running: bool
    trouble: str
    stale: Tuple[int, ...]
    stopped: Tuple[int, ...]
    axes: Tuple[str, ...]
    command: np.ndarray  # (n, a) [m/s, rad/s]
    edges: Tuple[Tuple[int, int, float], ...]  # (i, j, weight): robot i receives from robot j
    directed: bool
    targets: np.ndarray  # (n, 2) or (n, 3) [m] where points are wanted, (0, 2) for nowhere
    warnings: Tuple[str, ...] = ()


class Stage(NamedTuple):
    """Status of a stage."""

    stamp: float  # [s]
    fidelity: str
    robots: int
    speed: float  # [-] wanted
    real_time_factor: float  # [-]
    paused: bool
    lockstep: bool
    trouble: str
    missed_periods: int
    command_periods: int
    real_silent: Tuple[int, ...]
    closest_approach: float  # [m]
    flight: Tuple[
        str, ...
    ] = ()  # what each robot does that flies, "" for others; () where none does
    timed_out: Tuple[int, ...] = ()  # robots that their watchdogs stopped
