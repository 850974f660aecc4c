"""Scenarios that name no files, to be published or kept in a rosbag.

A program opens no file that a received scenario names, since its sender is unknown.  So a kind in a
file, its bases, its description and its model are included as data.
"""

import json
import os

from mrs_simulator.scenario.reading import ScenarioError, shown
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.vehicles.importing.placing import roll_pitch_yaw
from mrs_simulator.vehicles.kind import read_kind
from mrs_simulator.vehicles.registry import file_named, is_file, merged, names_a_file, shipped_kinds
from mrs_simulator.vehicles.shape import GREY, MOST_PARTS, Part
from mrs_simulator.vehicles.team import Team

# of a published kind: paths, and what receivers do not need
LEFT_OUT = ("model", "sources", "notes")


def portable(scenario):
    """Return ``scenario`` with kinds that name no files, what each of these stands for, and notes.

    The second is a mapping of the kinds' names, as the first has them, to those in ``scenario``; notes
    are texts on models left out, whose robots displays draw as outlines.
    """
    own, names, notes = {}, {}, []
    for name in dict.fromkeys((*scenario.kinds, *scenario.own_kinds)):
        if name in scenario.own_kinds and not names_a_file(name, scenario.own_kinds):
            own[name] = scenario.own_kinds[name]
        elif name in scenario.own_kinds or is_file(name):
            try:
                content = _portable_kind(name, scenario.directory, scenario.own_kinds, notes)
            except ScenarioError:
                if name in scenario.kinds:
                    raise
                continue  # no robot is of that kind
            free = _free_name(content["name"], own) if is_file(name) else name
            own[free], names[name] = content, free
    kinds = tuple(names.get(name, name) for name in scenario.kinds)
    scenario = scenario._replace(obstacles=obstacles_of(scenario), map=None)
    stands_for = {free: name for name, free in names.items()}
    return scenario._replace(kinds=kinds, own_kinds=own), stands_for, notes


def team_from_message(scenario):
    """Return the ``Team`` of a ``scenario`` received over a topic or read from a bag, opening no file.

    Raises ``ScenarioError`` for one that names a file, and ``ValueError`` as ``Team`` does.
    """
    named = file_named(scenario)
    if named:
        raise ScenarioError(
            "{}: a file, wanted a kind's data: no file is opened".format(shown(named))
        )
    return Team.from_scenario(scenario._replace(path=""))


def _free_name(name, taken):
    """Return ``name``, numbered where another kind has it."""
    name = name or "robot"
    count, result = 1, name
    while result in taken or result in shipped_kinds() or is_file(result):
        count += 1
        result = "{}_{}".format(name.replace(".", "_"), count)
    return result


def _portable_kind(name, relative_to, own, notes):
    """Return the content of the kind ``name`` over its bases, with the ``shape`` of its model."""
    content, where, directory = merged(name, relative_to, own)
    kind = read_kind(content, where, directory)
    plain = {key: value for key, value in content.items() if key not in LEFT_OUT}
    if kind.model and not kind.shape:
        try:
            plain["shape"] = [part.to_plain() for part in model_shape(kind.model)]
        except ScenarioError as error:
            notes.append("{}: displays draw its outline: {}".format(kind.name, error))
    return json.loads(json.dumps(plain))  # without numpy's numbers and shared objects


def model_shape(path):
    """Return the ``Part`` tuple of the visuals in the URDF at ``path``; a mesh is the box around it.

    Raises ``ScenarioError``.
    """
    # Models of a team's robots are read for pictures alone.
    from mrs_simulator.vehicles.importing.description import read_description
    from mrs_simulator.vehicles.importing.packages import Packages
    from mrs_simulator.vehicles.importing.shapes import solid
    from mrs_simulator.vehicles.importing.xacro_files import description_text

    packages = Packages(os.path.dirname(path))
    description = read_description(description_text(path, {}, packages), path)
    parts = []
    for name, link in description.links.items():
        for visual in link.visuals or link.collisions:
            found = solid(visual, description.places[name], packages, [], needed=False)
            if found is not None:
                parts.append(_part(found))
    if len(parts) > MOST_PARTS:
        raise ScenarioError(
            "{}: {} visuals, wanted at most {}".format(path, len(parts), MOST_PARTS)
        )
    return tuple(parts)


def _part(shape):
    place = (*shape.transform[:3, 3].tolist(), *roll_pitch_yaw(shape.transform).tolist())
    colour = tuple(min(1.0, max(0.0, float(value))) for value in shape.colour or GREY)
    return Part(shape.form, tuple(map(float, shape.size)), place, colour)
