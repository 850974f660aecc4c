"""Which robots a scenario has: their kinds and initial poses, one by one or in groups."""

import os

import numpy as np

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.scenario.reading import (
    ScenarioError,
    Section,
    number,
    number_list,
    shown,
    unwanted,
)
from mrs_simulator.scenario.team.layouts import LAYOUTS, make_layout
from mrs_simulator.scenario.team.sensor_changes import read_sensor_changes

DEFAULT_KIND = "pioneer3dx"
KIND_FILES = (".yaml", ".urdf", ".xacro")  # a kind whose name ends so is a file
MOST_ROBOTS = 20000
FARTHEST = 1e6  # [m], a position beyond this is a mistake


def read_team(top, seed):
    """Return poses (n, 3), the kinds' names (n of them), own kinds by name, altitudes, and sensors.

    Altitudes are (n,) [m], None for a team on the ground; sensors a tuple of ``SensorChange``.

    ``top``: the scenario's ``Section``; ``seed`` of random layouts.
    """
    own = _read_own_kinds(top)
    if top.has("groups"):
        poses, kinds, altitude, groups = _read_groups(top, seed)
        return poses, kinds, own, altitude, read_sensor_changes(top, kinds, groups)
    top.take("groups")
    poses = _read_poses(top, "robots", seed)
    kinds, altitude = _read_kinds(top, len(poses)), _read_altitude(top, len(poses))
    return poses, kinds, own, altitude, read_sensor_changes(top, kinds)


def _read_altitude(section, n):
    """Return the heights (n,) [m] at which robots begin: one for all, or one for each; None for 0."""
    given = section.take("altitude", 0.0)
    if isinstance(given, list):
        heights = np.array(number_list(given, n, section.at("altitude")))
    else:
        heights = np.full(n, number(given, section.at("altitude")))
    for height in heights.tolist():
        number(height, section.at("altitude"), low=0.0, high=FARTHEST)
    return heights if heights.any() else None


@explained_by("docs/scenarios.md#teams-of-several-kinds")
def _read_own_kinds(top):
    given = top.take("kinds", {})
    fits = isinstance(given, dict) and all(isinstance(name, str) for name in given)
    for name, content in given.items() if fits else ():
        if not isinstance(content, dict) or name.endswith(KIND_FILES):
            text = "{}.{}: {}, wanted a name, and a mapping such as {{base: {}}}"
            raise ScenarioError(text.format(top.at("kinds"), name, shown(content), DEFAULT_KIND))
    if not fits:
        raise unwanted(top.at("kinds"), given, "a mapping")
    return given


@explained_by("docs/scenarios.md#teams-of-several-kinds")
def _read_groups(top, seed):
    """Return poses, kinds and altitudes of the robots of all groups, in the groups' order.

    And of each group its robots' numbers and its section.
    """
    given = top.take("groups")
    if not isinstance(given, list) or not given:
        raise unwanted(top.at("groups"), given, "a list of {number, kind, layout or poses}")
    for key in ("poses", "model", "kind"):
        if top.has(key):
            raise ScenarioError("{}: given beside groups, wanted one of them".format(top.at(key)))
        top.take(key)
    if top.has("altitude"):
        raise ScenarioError(
            "{}: given beside groups, wanted in each of them".format(top.at("altitude"))
        )
    top.take("altitude")
    poses, kinds, altitudes, groups = [], [], [], []
    for index, item in enumerate(given):
        section = Section(item, "{}[{}]".format(top.at("groups"), index))
        group = _read_group(section, (seed + index) % 2**32)
        poses.append(group)
        altitude = _read_altitude(section, len(group))
        altitudes.append(np.zeros(len(group)) if altitude is None else altitude)
        groups.append((tuple(range(len(kinds) + 1, len(kinds) + len(group) + 1)), section))
        section.take("sensors")
        kinds += [section.text("kind", DEFAULT_KIND)] * len(group)
        if len(kinds) > MOST_ROBOTS:
            raise ScenarioError(
                "{}: {} robots, wanted at most {}".format(top.at("groups"), len(kinds), MOST_ROBOTS)
            )
        section.done()
    count = top.whole("robots", len(kinds), low=1, high=MOST_ROBOTS)
    if count != len(kinds):
        raise ScenarioError(
            "{}: {}, but groups have {}".format(top.at("robots"), count, len(kinds))
        )
    altitude = np.concatenate(altitudes)
    poses = checked_poses(np.concatenate(poses), top.at("groups"))
    return poses, tuple(kinds), altitude if altitude.any() else None, groups


def _read_group(section, seed):
    """Return the poses (m, 3) of a group, about its ``center``."""
    if section.has("layout") and section.has("poses"):
        raise ScenarioError("{}: given beside layout, wanted one".format(section.at("poses")))
    if section.has("layout"):
        name = section.text("layout", choices=sorted(LAYOUTS))
        keys = [parameter.name for parameter in LAYOUTS[name]]
        values = {key: section.take(key) for key in keys if section.has(key)}
        for key in keys + ["poses"]:
            section.take(key)
        poses = _laid_out(
            name, section.whole("number", low=1, high=MOST_ROBOTS), section, seed, values
        )
    else:
        section.take("layout")
        poses = _read_poses(section, "number", seed)
    if section.has("center"):
        poses[:, :2] += section.numbers("center", 2)
    section.take("center")
    return poses


def _laid_out(name, count, section, seed, values):
    if "seed" in values:
        text = "{}.seed: {}, wanted none: the scenario's own seed is that of its layouts"
        raise ScenarioError(text.format(section.at("poses"), shown(values["seed"])))
    try:
        return make_layout(name, count, seed=seed, **values)
    except (ValueError, TypeError) as error:
        raise ScenarioError("{}: {}".format(section.at("poses"), error)) from None


def _read_poses(section, number, seed):
    """Return the poses in ``section``; its key ``number`` says how many."""
    where, given = section.at("poses"), section.take("poses")
    if isinstance(given, dict):
        count = section.whole(number, low=1, high=MOST_ROBOTS)
        name = Section(given, where).text("layout", choices=sorted(LAYOUTS))
        values = {key: given[key] for key in given if key != "layout"}
        return checked_poses(_laid_out(name, count, section, seed, values), where)
    if not isinstance(given, list) or not given or len(given) > MOST_ROBOTS:
        raise unwanted(where, given, "a list of [x, y, theta] or a layout")
    rows = [number_list(row, 3, "{}[{}]".format(where, i)) for i, row in enumerate(given)]
    poses = checked_poses(np.array(rows), where)
    count = section.whole(number, len(rows), low=1, high=MOST_ROBOTS)
    if count != len(rows):
        raise ScenarioError("{}: {}, but poses has {}".format(section.at(number), count, len(rows)))
    return poses


def checked_poses(poses, where):
    """Return ``poses`` (n, 3); ``ScenarioError`` names the first that is too far away."""
    far = np.flatnonzero(np.abs(poses).max(axis=1) > FARTHEST)
    if len(far):
        text = "{}[{}]: {}, wanted within {:g} m"
        raise ScenarioError(text.format(where, far[0], poses[far[0]].tolist(), FARTHEST))
    return poses


def _read_kinds(top, n):
    key = "kind" if top.has("kind") else "model"
    if top.has("kind") and top.has("model"):
        raise ScenarioError("{}: given beside kind, wanted one of them".format(top.at("model")))
    kinds = top.take(key, DEFAULT_KIND)
    for other in ("kind", "model"):
        top.take(other)
    kinds = [kinds] * n if isinstance(kinds, str) else kinds
    if not isinstance(kinds, list) or len(kinds) != n or not all(isinstance(k, str) for k in kinds):
        raise unwanted(top.at(key), kinds, "one kind or a list of {}".format(n))
    return tuple(kinds)


def located_kinds(kinds, own, directory):
    """Return ``kinds`` and ``own`` with the absolute paths of files that are relative to ``directory``."""
    own = {name: _located_content(content, directory) for name, content in own.items()}
    return tuple(_located(kind, directory) for kind in kinds), own


def _located(kind, directory):
    return _absolute(kind, directory) if kind.endswith(KIND_FILES) else kind


def _absolute(path, directory):
    return os.path.abspath(os.path.join(directory, os.path.expanduser(path)))


def _located_content(content, directory):
    result = dict(content)
    if isinstance(content.get("base"), str):
        result["base"] = _located(content["base"], directory)
    if isinstance(content.get("model"), str):
        result["model"] = _absolute(content["model"], directory)
    request = content.get("import")
    if isinstance(request, str):
        result["import"] = _absolute(request, directory)
    elif isinstance(request, dict):
        result["import"] = {
            key: _absolute(value, directory) if _is_file(value, directory) else value
            for key, value in request.items()
        }
    return result


def _is_file(value, directory):
    return isinstance(value, str) and os.path.isfile(_absolute(value, directory))
