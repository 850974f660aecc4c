"""Scenarios: one YAML file holds a whole experiment.

Every key is checked; what is wrong is said with the file, the key path, what came and what was
wanted.  Lengths in m, angles in rad, times in s, poses in the common frame.
"""

import functools
import math
import os
import pickle

import numpy as np
import yaml

from mrs_simulator.core.fields import counted
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import DEFAULT_HAND_LENGTH
from mrs_simulator.core.step_rates import rate_note, steps_between
from mrs_simulator.scenario.control import Control  # noqa: F401, known from here
from mrs_simulator.scenario.keys import ENGINES, FIDELITIES, KEYS, SEED  # noqa: F401, likewise
from mrs_simulator.scenario.reading import (
    ScenarioError,
    Section,
    as_plain,
    load_yaml,
    parse_yaml,
    record,
    unwanted,
    written,
)
from mrs_simulator.scenario.team.layouts import extend_poses
from mrs_simulator.scenario.team.robots import (  # noqa: F401, names of the team that others know from here
    DEFAULT_KIND,
    FARTHEST,
    KIND_FILES,
    MOST_ROBOTS,
    located_kinds,
    read_team,
)
from mrs_simulator.scenario.team.sensor_changes import changes_for_robots

# Keys that command lines change, besides the number of robots and the protocol.
OVERRIDES = ("fidelity", "engine", "odometry", "limits", "duration", "seed")
MOST_TURNED = 4.0 * math.pi  # [rad] of a heading, beyond which degrees may have been meant
TEAM = {"own_kinds": {}, "altitude": None, "sensors": ()}


class Scenario(record("Scenario", KEYS, ("poses", "kinds"), dict(TEAM, path=""))):
    """A whole experiment: the values of ``KEYS``, as docs/scenarios.md lists them, and the team's.

    ``poses`` (n, 3) [m, m, rad]: initial poses of the wheel-axle centres; ``kinds``: names, n of them;
    ``own_kinds``: those that the scenario describes, by name; ``altitude`` (n,) [m]: heights at which
    robots begin, None on the ground; ``sensors``: changes to those of the kinds, ``SensorChange``s;
    ``path`` of its file.  ``limits`` is a preset's name, ``LoweredLimits``, ``Limits``, or None for none.
    """

    __slots__ = ()

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
        return self._replace(
            title=title_of(n, self.control.protocol),
            poses=poses,
            kinds=kinds,
            topology=self._topology_for(n),
            **self._values_for(n),
        )

    def _values_for(self, n):
        """Return what has values of each robot, but for poses, kinds and topology, for n robots."""
        return dict(
            altitude=self._altitude_for(n),
            control=self.control.with_robots(n),
            mismatch=self.mismatch.with_robots(n),
            sensors=changes_for_robots(self.sensors, self.n, n),
            events=tuple(event for event in self.events if event.robot <= n),
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
        kept = self
        if "robots" in values:
            kept = self._replace(**self._values_for(values["robots"]))
        content = kept.to_dict()
        if values.get("fidelity", "dynamic") != "dynamic":
            content.pop("engine", None)
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
        team = {
            "robots": self.n,
            "model": self.kinds[0] if len(set(self.kinds)) == 1 else list(self.kinds),
            "poses": [[float(value) for value in pose] for pose in self.poses],
            "altitude": None if self.altitude is None else self.altitude.tolist(),
            "sensors": as_plain(self.sensors),
            "kinds": dict(self.own_kinds),
        }
        team = {key: value for key, value in team.items() if value}
        return {**team, **written(self, KEYS, self.n)}

    def to_yaml(self):
        """Return the scenario as YAML text."""
        return "".join(_lines_of(key, pickle.dumps(value)) for key, value in self.to_dict().items())


BESIDE = {"beside": [[]]}  # an entry with which a mapping has an entry a line
SHORT = 1000  # [bytes] of a pickle, below which the lines of many are kept


def _lines_of(key, value):
    """Return the YAML lines of a scenario's ``key`` and its ``value``, a pickle.

    YAML takes long to write: scenarios of a sweep share nearly all of them, and each is written for the
    name of its run, beside the run, and for the stamp of all.
    """
    return _short_lines(key, value) if len(value) < SHORT else _long_lines(key, value)


def _written(key, value):
    text = _yaml({key: pickle.loads(value), **BESIDE})
    return text[: -len(_yaml(BESIDE))]


_short_lines = functools.lru_cache(maxsize=4096)(_written)
_long_lines = functools.lru_cache(maxsize=256)(_written)  # as of poses of a thousand robots


def _yaml(content):
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=None)


def title_of(n, protocol):
    """Return a title for a scenario that is no longer the one that its author named."""
    name = protocol.rpartition(":")[2] if ":" in protocol else os.path.basename(protocol)
    return "{}, {}".format(counted(n, "robot"), name)


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
        raise unwanted(where, content, "a mapping of keys")
    top = Section(content, where)
    seed = top.field(SEED)
    poses, kinds, own_kinds, altitude, sensors = read_team(top, seed)
    top.n = len(poses)
    team = dict(poses=poses, kinds=kinds, own_kinds=own_kinds, altitude=altitude, sensors=sensors)
    scenario = Scenario(**top.values(KEYS, seed=seed, **team))
    _refuse_conflicts(scenario, top)
    return scenario


def _refuse_conflicts(scenario, top):
    """Raise ``ScenarioError`` for keys that contradict each other."""
    odometry, fidelity = scenario.odometry, scenario.fidelity
    for key, is_wrong, text in (
        (
            "engine",
            scenario.engine != ENGINES[0] and fidelity != "dynamic",
            "{}, but fidelity is {}; wanted fidelity: dynamic".format(scenario.engine, fidelity),
        ),
        (
            "takeoff",
            scenario.takeoff and scenario.altitude is None,
            "true, but no robot has an altitude; wanted that to which it rises",
        ),
        (
            "odometry_errors",
            scenario.odometry_errors is not None and odometry != "wheel",
            "given, but odometry is {}; wanted odometry: wheel".format(odometry),
        ),
        (
            "odometry",
            odometry == "wheel" and fidelity == "point_mass",
            "wheel, but point masses have no wheels; wanted world, or another fidelity",
        ),
    ):
        if is_wrong:
            raise ScenarioError("{}: {}".format(top.at(key), text))
