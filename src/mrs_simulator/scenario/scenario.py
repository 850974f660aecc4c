"""Scenarios: one YAML file holds a whole experiment.

Every key is checked; what is wrong is said with the file, the key path, what came and what was
wanted.  Lengths in m, angles in rad, times in s, poses in the common frame.
"""

import math
import os
from typing import Any, Dict, NamedTuple, Optional, Tuple, Union

import numpy as np
import yaml

from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import DEFAULT_HAND_LENGTH, Limits
from mrs_simulator.core.step_rates import rate_note, steps_between
from mrs_simulator.scenario.control import Control, read_control
from mrs_simulator.scenario.incidents import Event, events_of_first, read_events
from mrs_simulator.scenario.network.links import NO_FAULTS, Links, read_links
from mrs_simulator.scenario.network.topology import read_topology
from mrs_simulator.scenario.reading import (
    ScenarioError,
    Section,
    load_yaml,
    parse_yaml,
    shown,
)
from mrs_simulator.scenario.requirements import Requirement, read_requirements
from mrs_simulator.scenario.search import NO_SEARCH, Search, read_search
from mrs_simulator.scenario.surroundings.environment import CALM, Environment, read_environment
from mrs_simulator.scenario.surroundings.maps import Map, read_map
from mrs_simulator.scenario.surroundings.obstacle_reading import obstacle_to_plain, read_obstacles
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.scenario.team.estimates import Estimates, read_estimates
from mrs_simulator.scenario.team.layouts import extend_poses
from mrs_simulator.scenario.team.limits import LoweredLimits, limits_to_plain, read_limits
from mrs_simulator.scenario.team.load import Load, read_load
from mrs_simulator.scenario.team.mismatch import NO_MISMATCH, Mismatch, read_mismatch
from mrs_simulator.scenario.team.odometry_errors import OdometryErrors, read_odometry_errors
from mrs_simulator.scenario.team.robots import (  # noqa: F401, names of the team that others know from here
    DEFAULT_KIND,
    FARTHEST,
    KIND_FILES,
    MOST_ROBOTS,
    located_kinds,
    read_team,
)
from mrs_simulator.scenario.team.sensor_changes import SensorChange, changes_for_robots

FIDELITIES = ("kinematic", "dynamic", "point_mass")
ENGINES = ("pybullet", "planar")  # of motion with forces on wheels, the first by default
ODOMETRIES = ("world", "wheel")
# Keys that command lines change, besides the number of robots and the protocol.
OVERRIDES = ("fidelity", "engine", "odometry", "limits", "duration", "seed")
LONGEST_STEP = 0.02  # [s], of the simulated world unless the scenario says otherwise
MOST_TURNED = 4.0 * math.pi  # [rad] of a heading, beyond which degrees may have been meant


class Scenario(NamedTuple):
    """A whole experiment.

    ``limits`` is a preset's name, ``LoweredLimits``, ``Limits``, or None for no limits.
    """

    poses: np.ndarray  # (n, 3) [m, m, rad], initial poses of the wheel-axle centres
    kinds: Tuple[str, ...]
    title: str = ""
    fidelity: str = "kinematic"
    limits: Union[str, LoweredLimits, Limits, None] = "firmware"
    odometry: str = "world"
    control: Control = Control()
    topology: Optional[Topology] = None
    links: Links = NO_FAULTS
    mismatch: Mismatch = NO_MISMATCH
    obstacles: Tuple[Union[Box, Cylinder], ...] = ()
    environment: Environment = CALM
    duration: float = 60.0  # [s]
    seed: int = 0
    speed: float = 1.0  # [-] simulated over wall time; 0: as fast as possible
    record_rate: float = 10.0  # [Hz]
    odometry_rate: Union[str, float, None] = (
        None  # [Hz], "kinds": each kind's own, None: as fast as can be
    )
    cmd_vel_timeout: Optional[float] = None  # [s], None: that of each robot's kind
    step: float = LONGEST_STEP  # [s]
    path: str = ""
    own_kinds: Dict[str, Any] = {}  # of robots, as the scenario describes them by name
    altitude: Optional[np.ndarray] = (
        None  # (n,) [m] heights at which robots begin, None: on the ground
    )
    sensors: Tuple[SensorChange, ...] = ()  # changes to the kinds' sensors
    odometry_errors: Optional[OdometryErrors] = None  # None: those built in, of the wheels
    map: Optional[Map] = None  # of walls: ``maps.obstacles_of``
    estimates: Optional[Estimates] = None  # None: those of odometry
    events: Tuple[Event, ...] = ()  # scheduled faults
    takeoff: bool = False  # whether robots begin on the ground and rise to ``altitude`` first
    load: Optional[Load] = None  # that the robots carry together
    record: Tuple[str, ...] = ()  # names of sensors whose readings are recorded
    engine: str = ENGINES[0]  # what moves robots on wheels with forces
    requirements: Tuple[Requirement, ...] = ()  # formulas that runs are to keep
    search: Search = NO_SEARCH  # what may vary between the runs of a search

    @property
    def n(self):
        """Return the number of robots."""
        return len(self.poses)

    @property
    def directory(self):
        """Return the directory of the scenario's file, "" without one."""
        return os.path.dirname(self.path)

    @property
    def starts(self):
        """Return the initial ``poses`` (n, 3), of robots off the ground with their heights, (n, 4)."""
        return self.poses if self.altitude is None else np.column_stack([self.poses, self.altitude])

    @property
    def hand_length(self):
        """Return the distance l [m] from the wheel-axle centre to the hand point."""
        return float(self.control.parameters.get("l", DEFAULT_HAND_LENGTH))

    @property
    def steps_per_command(self):
        """Return how many steps of the world one command is held."""
        return steps_between(self.control.rate, self.step)

    @property
    def steps_per_record(self):
        """Return how many steps of the world lie between two recorded samples."""
        return steps_between(self.record_rate, self.step)

    @property
    def record_period(self):
        """Return the time [s] between two recorded samples of simulated robots."""
        return self.steps_per_record * self.step

    def with_robots(self, n):
        """Return this scenario with n robots: the first n, or more of the same kind placed apart.

        Raises ``ScenarioError`` if its topology lists edges of a robot that is no longer there.
        """
        if n == self.n:
            return self
        if not 1 <= n <= MOST_ROBOTS:
            raise ScenarioError("robots = {}: wanted from 1 to {}".format(n, MOST_ROBOTS))
        size = max(20.0, 3.0 * math.sqrt(n))
        poses = (
            self.poses[:n] if n < self.n else extend_poses(self.poses, n, size=size, seed=self.seed)
        )
        kinds = (self.kinds + (self.kinds[-1],) * n)[:n]
        title = title_of(n, self.control.protocol)
        return self._replace(
            title=title,
            poses=poses,
            altitude=self._altitude_for(n),
            kinds=kinds,
            topology=self._topology_for(n),
            control=self.control.with_robots(n),
            mismatch=self.mismatch.with_robots(n),
            sensors=changes_for_robots(self.sensors, self.n, n),
            events=events_of_first(self.events, n),
            load=self.load and self.load.with_robots(n),
        )

    def _altitude_for(self, n):
        """Return the heights of n robots: more begin as high as the last."""
        if self.altitude is None:
            return None
        return np.concatenate([self.altitude[:n], np.full(max(0, n - self.n), self.altitude[-1])])

    def with_protocol(self, protocol):
        """Return this scenario under another protocol, with that protocol's own parameters.

        The parameters here belong to the protocol they were written for; only l is kept.
        """
        if protocol == self.control.protocol:
            return self
        kept = {key: value for key, value in self.control.parameters.items() if key == "l"}
        control = self.control._replace(protocol=protocol, parameters=kept)
        return self._replace(title=title_of(self.n, protocol), control=control)

    def overridden(self, robots=None, protocol=None, **values):
        """Return this scenario with the changes of a command line; None leaves a value.

        ``robots``: their number; ``protocol``: a name; ``values``: of the keys in ``OVERRIDES``.
        """
        result = self if robots is None else self.with_robots(robots)
        result = result if protocol is None else result.with_protocol(protocol)
        given = {key: value for key, value in values.items() if value is not None}
        return result.changed(**given) if given else result

    def changed(self, **values):
        """Return this scenario with other top-level keys, checked as in a file."""
        content = self.to_dict()
        if values.get("fidelity", "dynamic") != "dynamic":
            content.pop("engine", None)
        if "robots" in values and "mismatch" in content:
            content["mismatch"] = self.mismatch.with_robots(values["robots"]).to_plain()
        if "robots" in values:
            content["control"] = self.control.with_robots(values["robots"]).to_plain()
        if "robots" in values and self.altitude is not None:
            content["altitude"] = self._altitude_for(values["robots"]).tolist()
        if "robots" in values and self.sensors:
            kept = changes_for_robots(self.sensors, self.n, values["robots"])
            content["sensors"] = [change.to_plain() for change in kept]
        if "robots" in values and self.events:
            content["events"] = [
                e.to_plain() for e in events_of_first(self.events, values["robots"])
            ]
        if "robots" in values and self.load is not None:
            content["load"] = self.load.with_robots(values["robots"]).to_plain()
        content.update(values)
        return scenario_from_dict(content, "given value")._replace(path=self.path)

    def warnings(self):
        """Return a list of texts: what looks like a mistake, and rates that whole steps cannot keep."""
        note = rate_note("record_rate", self.record_rate, self.step)
        notes = [note] if note else []
        turned = np.flatnonzero(np.abs(self.poses[:, 2]) > MOST_TURNED)
        if not len(turned):
            return notes
        text = "robot{}: heading {:g} rad is more than {:g} turns; wanted radians, not degrees"
        warning = text.format(turned[0] + 1, self.poses[turned[0], 2], MOST_TURNED / (2 * math.pi))
        return [warning, *notes]

    def _topology_for(self, n):
        if self.topology is None:
            return None
        try:
            return Topology(n, self.topology.edges, self.topology.directed)
        except ValueError as error:
            raise ScenarioError("topology with {} robots: {}".format(n, error)) from None

    def to_dict(self):
        """Return the scenario as plain values that ``scenario_from_dict`` reads back."""
        result = {
            "title": self.title,
            "robots": self.n,
            "model": self.kinds[0] if len(set(self.kinds)) == 1 else list(self.kinds),
            "poses": [[float(value) for value in pose] for pose in self.poses],
            "fidelity": self.fidelity,
            "limits": limits_to_plain(self.limits),
            "odometry": self.odometry,
            "control": self.control.to_plain(),
            "obstacles": [obstacle_to_plain(obstacle) for obstacle in self.obstacles],
        }
        for key in ("duration", "seed", "speed", "record_rate", "step"):
            result[key] = getattr(self, key)
        if self.engine != ENGINES[0]:
            result["engine"] = self.engine
        if self.environment != CALM:
            result["environment"] = self.environment.to_plain()
        for key in ("cmd_vel_timeout", "odometry_rate"):
            if getattr(self, key) is not None:
                result[key] = getattr(self, key)
        if self.topology is not None:
            edges = [list(edge) for edge in self.topology.edges]
            result["topology"] = {"edges": edges, "directed": self.topology.directed}
        if self.altitude is not None:
            result["altitude"] = self.altitude.tolist()
        if self.odometry_errors is not None:
            result["odometry_errors"] = self.odometry_errors.to_plain()
        if self.estimates is not None:
            result["estimates"] = self.estimates.to_plain()
        if self.map is not None:
            result["map"] = self.map.to_plain()
        if self.load is not None:
            result["load"] = self.load.to_plain()
        if self.sensors:
            result["sensors"] = [change.to_plain() for change in self.sensors]
        if self.record:
            result["record"] = list(self.record)
        if self.takeoff:
            result["takeoff"] = True
        if self.events:
            result["events"] = [event.to_plain() for event in self.events]
        if self.requirements:
            result["requirements"] = dict(self.requirements)
        if self.search != NO_SEARCH:
            result["search"] = self.search.to_plain()
        if self.own_kinds:
            result["kinds"] = dict(self.own_kinds)
        if self.links != NO_FAULTS:
            result["links"] = self.links.to_plain(self.n)
        if self.mismatch != NO_MISMATCH:
            result["mismatch"] = self.mismatch.to_plain()
        return result

    def to_yaml(self):
        """Return the scenario as YAML text."""
        return yaml.safe_dump(self.to_dict(), sort_keys=False, default_flow_style=None)


def title_of(n, protocol):
    """Return a title for a scenario that is no longer the one that its author named."""
    name = protocol.rpartition(":")[2] if ":" in protocol else os.path.basename(protocol)
    return "{} robots, {}".format(n, name)


def load_scenario(path):
    """Return the ``Scenario`` in the YAML file at ``path``; ``ScenarioError`` if it is not one."""
    return scenario_of_file(load_yaml(str(path)), str(path))


def scenario_of_file(content, path, where=None):
    """Return the ``Scenario`` in the mapping ``content`` as if it stood in the file at ``path``."""
    scenario = scenario_from_dict(content, where or path)
    directory = os.path.dirname(os.path.abspath(path))
    kinds, own = located_kinds(scenario.kinds, scenario.own_kinds, directory)
    located = scenario.map and scenario.map.located(directory)
    return scenario._replace(kinds=kinds, own_kinds=own, map=located, path=os.path.abspath(path))


def scenario_from_yaml(text, where="scenario"):
    """Return the ``Scenario`` in YAML ``text``."""
    return scenario_from_dict(parse_yaml(text, where), where)


def scenario_from_dict(content, where="scenario"):
    """Return the ``Scenario`` in the mapping ``content``; ``where`` names it in errors."""
    if not isinstance(content, dict):
        raise ScenarioError("{}: {}, wanted a mapping of keys".format(where, shown(content)))
    top = Section(content, where)
    seed = top.whole("seed", 0, low=0, high=2**32 - 1)
    poses, kinds, own_kinds, altitude, sensors = read_team(top, seed)
    control = read_control(top, len(poses))
    topology = read_topology(top, poses, seed)
    scenario = Scenario(
        poses=poses,
        kinds=kinds,
        title=top.text("title", ""),
        fidelity=top.text("fidelity", "kinematic", FIDELITIES),
        limits=read_limits(top),
        odometry=top.text("odometry", "world", ODOMETRIES),
        control=control,
        topology=topology,
        links=read_links(top.take("links", {}), top.at("links"), len(poses), topology),
        mismatch=read_mismatch(top.take("mismatch", {}), top.at("mismatch"), len(poses)),
        obstacles=read_obstacles(top),
        environment=read_environment(top.take("environment", {}), top.at("environment")),
        duration=top.number("duration", 60.0, above=0.0),
        seed=seed,
        speed=top.number("speed", 1.0, low=0.0),
        record_rate=top.number("record_rate", 10.0, above=0.0),
        odometry_rate=_read_odometry_rate(top),
        cmd_vel_timeout=_read_timeout(top),
        step=_read_step(top, control.rate),
        own_kinds=own_kinds,
        altitude=altitude,
        sensors=sensors,
        record=_read_record(top),
        odometry_errors=read_odometry_errors(top),
        map=read_map(top),
        estimates=read_estimates(top),
        events=read_events(top, len(poses)),
        takeoff=top.flag("takeoff", False),
        load=read_load(top, len(poses)),
        engine=top.text("engine", ENGINES[0], ENGINES),
        requirements=read_requirements(top),
        search=read_search(top),
    )
    top.done()
    if scenario.engine != ENGINES[0] and scenario.fidelity != "dynamic":
        raise ScenarioError(
            "{}: {}, but fidelity is {}; wanted fidelity: dynamic".format(
                top.at("engine"), scenario.engine, scenario.fidelity
            )
        )
    if scenario.takeoff and altitude is None:
        raise ScenarioError(
            "{}: true, but no robot has an altitude; wanted that to which it rises".format(
                top.at("takeoff")
            )
        )
    if scenario.odometry_errors is not None and scenario.odometry != "wheel":
        raise ScenarioError(
            "{}: given, but odometry is {}; wanted odometry: wheel".format(
                top.at("odometry_errors"), scenario.odometry
            )
        )
    if scenario.odometry == "wheel" and scenario.fidelity == "point_mass":
        raise ScenarioError(
            "{}: wheel, but point masses have no wheels; wanted world, or another fidelity".format(
                top.at("odometry")
            )
        )
    return scenario


def _read_odometry_rate(top):
    if not top.has("odometry_rate"):
        return top.take("odometry_rate")
    given = top.take("odometry_rate")
    if given == "kinds":
        return given
    if isinstance(given, str):
        raise ScenarioError(
            "{}: {}, wanted a number [Hz], or kinds".format(top.at("odometry_rate"), shown(given))
        )
    return top.number("odometry_rate", above=0.0)


def _read_timeout(top):
    if not top.has("cmd_vel_timeout"):
        return top.take("cmd_vel_timeout")
    return top.number("cmd_vel_timeout", above=0.0)


def _read_step(top, rate):
    period = 1.0 / rate
    default = period / math.ceil(period / LONGEST_STEP - 1e-9)
    step = top.number("step", default, low=1e-5, high=1.0)
    if abs(period / step - round(period / step)) > 1e-6 or step > period * (1.0 + 1e-9):
        raise ScenarioError(
            "{}: {:g} s, wanted the command period 1/rate = {:g} s divided by a whole "
            "number".format(top.at("step"), step, period)
        )
    return step


def _read_record(top):
    """Return the names of the sensors under ``record``."""
    names, where = top.take("record", []), top.at("record")
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ScenarioError("{}: {}, wanted a list of sensors' names".format(where, shown(names)))
    for name in names:
        if names.count(name) > 1:
            raise ScenarioError("{}: {} twice".format(where, shown(name)))
    return tuple(names)
