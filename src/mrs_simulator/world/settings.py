"""``WorldSettings``: what a world is made of beside its robots."""

from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.scenario.scenario import DEFAULT_HAND_LENGTH, ENGINES
from mrs_simulator.scenario.surroundings.environment import CALM
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.scenario.team.mismatch import NO_MISMATCH
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.world import checks


class WorldSettings(NamedTuple):
    """How robots move, where, and what they obey and report; the same for any team."""

    obstacles: tuple = ()  # ``Box``, ``Cylinder``, ... as they begin: ``moving_obstacles.obstacles_at``
    fidelity: str = "kinematic"
    limits: Any = "firmware"  # as in ``vehicles.limits.kind_limits``
    step: float = 0.02  # [s]
    cmd_vel_timeout: Any = None  # [s] of simulated time; None: that of each robot's kind
    watch_period: float = 0.0  # [s] at which watchdogs look at the time, 0: at each step
    hand_length: float = DEFAULT_HAND_LENGTH  # [m]
    odometry_kind: str = "world"  # "wheel": what robots reckon from their wheels
    odometry_rate: Any = None  # [Hz] of estimates; "kinds": each kind's own; None: at each step
    odometry_errors: Any = None  # ``OdometryErrors``, instead of those built in
    counts_wheels: bool = False  # whether encoders are read beside the odometry
    seed: int = 0
    mirrored: Any = ()  # rows of robots that obey no command and are only where ``place`` puts them
    mismatch: Any = NO_MISMATCH  # how robots obey commands
    command_period: float = 0.0  # [s] for which a command is held; 0: ``step``
    environment: Any = CALM  # current, wind and waves
    events: tuple = ()  # ``scenario.incidents.Event``s by their times
    takeoff: bool = False  # whether robots begin on the ground and rise to ``z`` before the run
    load: Any = None  # ``scenario.team.load.Load`` that the robots' tools carry
    engine: str = ENGINES[0]  # what moves robots on wheels in fidelity dynamic

    def checked(self):
        """Return the settings with obstacles and events as tuples, and ``mirrored`` rows in order."""
        mirrored = np.array(sorted(set(self.mirrored)), dtype=int)
        return self._replace(
            obstacles=tuple(self.obstacles), events=tuple(self.events), mirrored=mirrored
        )

    @property
    def by_wheels(self):
        """Return whether robots report what they reckon from their wheels, and not their true poses."""
        return self.odometry_kind == "wheel"

    @property
    def has_encoders(self):
        """Return whether the turns of wheels are counted."""
        return self.counts_wheels or self.by_wheels

    @property
    def steps_per_watch(self):
        """Return in how many steps watchdogs look at the time once."""
        return max(1, int(round(self.watch_period / self.step)))


def settings_of(scenario, team):
    """Return the ``WorldSettings`` of ``scenario``, whose robots are the ``vehicles.Team``."""
    mounts = fitted_mounts(team, scenario.sensors)
    return WorldSettings(
        obstacles=obstacles_of(scenario),
        fidelity=scenario.fidelity,
        limits=scenario.limits,
        step=scenario.step,
        cmd_vel_timeout=scenario.cmd_vel_timeout,
        hand_length=scenario.hand_length,
        odometry_kind=scenario.odometry,
        odometry_rate=scenario.odometry_rate,
        odometry_errors=scenario.odometry_errors,
        counts_wheels=checks.count_wheels(mounts, scenario.fidelity),
        seed=scenario.seed,
        mismatch=scenario.mismatch,
        command_period=1.0 / scenario.control.rate,
        environment=scenario.environment,
        events=scenario.events,
        takeoff=scenario.takeoff,
        load=scenario.load,
        engine=scenario.engine,
    )
