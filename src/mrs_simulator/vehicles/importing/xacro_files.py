"""Expanding xacro files with an installed tool: xacrodoc, or ROS's own xacro.

Neither is required: a plain URDF needs none.  Expanding evaluates expressions of the file, so it
may come from the user's own disk only.
"""

import functools
import importlib
import os
import re

from mrs_simulator.scenario.reading import ScenarioError, shown
from mrs_simulator.vehicles.importing.xml_reading import read_text

FIND = re.compile(r"\$\(find\s+([^\s()$]+)\s*\)")
ADVICE = (
    "wanted xacrodoc (pip install xacrodoc) or ROS's xacro (apt install ros-noetic-xacro), or the "
    "file expanded before: rosrun xacro xacro {} > robot.urdf"
)


def description_text(path, arguments, packages, notes=None):
    """Return the URDF text of the URDF or xacro file at ``path``.

    ``arguments``: values by name for ``$(arg name)``; ``packages``: a ``Packages``; ``notes``: a list to
    which a line is added for each include of a package that is not there.  Raises ``ScenarioError``.
    """
    text = read_text(path)
    if not is_xacro(text):
        if arguments:
            name = sorted(arguments)[0]
            raise ScenarioError(
                "{}: argument {}, but it is no xacro file".format(path, shown(name))
            )
        return text
    values = {name: _spelled(value) for name, value in arguments.items()}
    absent = []
    try:
        text = _expanded(path, values, packages, absent)
    except ScenarioError:
        raise
    except ModuleNotFoundError as error:  # xacro from PyPI finds packages of ROS 2 only
        raise ScenarioError("{}: {}: {}".format(path, error, _advice(path))) from None
    except (Exception, SystemExit) as error:  # whatever the file's own expressions raise
        text = " ".join(str(error).split()) or type(error).__name__
        raise ScenarioError(
            "{}: xacro cannot expand it: {}{}".format(path, text[:300], _needed(absent))
        ) from None
    if notes is not None:
        notes += ["{}: {}; its include is left out".format(path, each) for each in absent]
    return text


def is_xacro(text):
    """Return whether ``text`` is to be expanded: whether it has xacro's tags or substitutions.

    Files that xacro wrote declare its namespace and have neither.
    """
    if not re.search(r"xmlns:xacro\s*=", text):
        return False
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    return re.search(r"<xacro:|\sxacro:|\$[({]", text) is not None


def _expanded(path, values, packages, absent):
    xacro = _xacro(packages)
    if xacro is None:
        raise ScenarioError("{}: is a xacro file: {}".format(path, _advice(path)))
    include = xacro.process_include
    xacro.process_include = functools.partial(_included, include, packages, absent)
    try:
        return xacro.process_file(path, mappings=values).toxml()
    finally:
        xacro.process_include = include


def _xacro(packages):
    """Return the module of xacro, None if there is none; xacrodoc's finds ``packages`` of ROS 1."""
    if _there("xacrodoc"):
        import xacrodoc.xacrodoc

        xacrodoc.packages.update_package_cache(packages.known())
        return xacrodoc.xacrodoc.xacro
    return importlib.import_module("xacro") if _there("xacro") else None


def _included(include, packages, absent, element, *others):
    """Do what ``xacro.process_include`` does; leave the tag out whose package is not there.

    Descriptions include the macros of every sensor that a robot may carry, and use few of them.  A macro
    that is used all the same is an error of xacro's, which then names the packages.
    """
    file = element.getAttribute("filename")
    missing = [name for name in FIND.findall(file) if packages.directory(name) is None]
    if missing:
        why = "package {} is not in ROS_PACKAGE_PATH".format(shown(missing[0]))
        absent += [] if why in absent else [why]
        element.parentNode.removeChild(element)
        return
    found = FIND.sub(lambda match: packages.directory(match.group(1)), file)
    element.setAttribute("filename", found)
    include(element, *others)


def _needed(absent):
    """Return what an error adds of packages that are not there."""
    if not absent:
        return ""
    return "; {}: wanted there, or under the key packages".format(", ".join(absent))


def _advice(path):
    return ADVICE.format(os.path.basename(path))


def _there(name):
    try:
        importlib.import_module(name)
    except ImportError:
        return False
    return True


def _spelled(value):
    """Return ``value`` as xacro writes it."""
    return str(value).lower() if isinstance(value, bool) else str(value)
