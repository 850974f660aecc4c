"""Robots that users bring: a URDF or xacro file and what it says of its drive.

A differential drive is described by the gazebo_ros drive plugin in the file, or by the YAML file of a
``diff_drive_controller``; any other drive is named by the user.  All give
the content of a kind's file, which the user's own keys go over.
``docs/robots_of_your_own.md`` describes it.

Most runs import no robot, so what reads descriptions is imported where it is used.
"""

import os
from typing import Any, Dict, NamedTuple, Optional, Tuple

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.scenario.reading import ScenarioError, Section, shown, unwanted

ENDINGS = (".urdf", ".xacro")


class Request(NamedTuple):
    """The mapping ``import`` of a kind's file."""

    urdf: str  # absolute path
    arguments: Dict[str, Any]  # of xacro
    controller: Optional[str]  # absolute path of a controller's YAML file
    controller_name: Optional[str]
    packages: Dict[str, str]  # absolute directories by package name
    drive: Optional[str] = None  # that the description does not name


def is_description(name):
    """Return whether ``name`` is the path of a URDF or xacro file."""
    return str(name).endswith(ENDINGS)


@explained_by("docs/robots_of_your_own.md#from-a-urdf-or-xacro")
def read_request(content, where, directory):
    """Return the ``Request`` in the mapping ``content``; paths are relative to ``directory``."""
    from mrs_simulator.vehicles.importing.named_drives import DRIVES

    section = Section(content, where)
    urdf = section.text("urdf")
    arguments = _mapping(section, "arguments", (str, int, float, bool), "texts and numbers")
    packages = _mapping(section, "packages", (str,), "directories by package name")
    controller = section.text("controller") if section.has("controller") else None
    name = section.text("controller_name") if section.has("controller_name") else None
    drive = section.text("drive", choices=DRIVES) if section.has("drive") else None
    section.take("drive")
    if drive is not None and controller is not None:
        text = "{}: {}, and a controller is given, wanted one of them"
        raise ScenarioError(text.format(section.at("drive"), shown(drive)))
    section.take("controller"), section.take("controller_name")
    section.done()
    if name is not None and controller is None:
        raise ScenarioError(
            "{}: {}, but controller is not given".format(section.at("controller_name"), shown(name))
        )

    def absolute(path):
        return os.path.abspath(os.path.join(directory, os.path.expanduser(path)))

    return Request(
        absolute(urdf),
        arguments,
        None if controller is None else absolute(controller),
        name,
        {key: absolute(path) for key, path in packages.items()},
        drive,
    )


def _mapping(section, key, types, wanted):
    value = section.take(key, {})
    fits = isinstance(value, dict) and all(isinstance(each, str) for each in value)
    if not fits or not all(isinstance(each, types) for each in value.values()):
        raise unwanted(section.at(key), value, "a mapping of {}".format(wanted))
    return value


@explained_by("docs/robots_of_your_own.md#from-a-urdf-or-xacro")
def imported(request, given, where) -> Tuple[Dict[str, Any], Tuple[str, ...]]:
    """Return the content of the kind that ``request`` describes, and notes of what was replaced.

    ``given``: the keys of the kind's own file, which say what the description lacks (``body``,
    ``mass``, ``limits``); ``where`` names that file in errors.  Raises ``ScenarioError`` that names
    the link, joint or tag.
    """
    from mrs_simulator.vehicles.importing.assembling import assembled
    from mrs_simulator.vehicles.importing.description import read_description
    from mrs_simulator.vehicles.importing.named_drives import ASSEMBLED
    from mrs_simulator.vehicles.importing.packages import Packages
    from mrs_simulator.vehicles.importing.xacro_files import description_text

    packages = Packages(os.path.dirname(request.urdf), request.packages)
    absent = []
    text = description_text(request.urdf, request.arguments, packages, absent)
    description = read_description(text, request.urdf)
    if request.drive in ASSEMBLED:
        content, notes = ASSEMBLED[request.drive](description, packages, given, where)
    else:
        facts = _facts(request, description)
        content, notes = assembled(description, facts, packages, given, where)
    return content, tuple(absent) + tuple(notes)


def _facts(request, description):
    """Return the ``DriveFacts`` of a differential drive, from whatever the request names."""
    from mrs_simulator.vehicles.importing.drive_facts import controller_facts, plugin_facts
    from mrs_simulator.vehicles.importing.named_drives import differential_facts

    if request.drive is not None:
        return differential_facts(description)
    if request.controller is not None:
        return controller_facts(request.controller, request.controller_name)
    return plugin_facts(description)
