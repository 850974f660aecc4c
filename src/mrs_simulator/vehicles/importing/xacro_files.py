"""Expanding xacro files with whichever tool is there: xacrodoc, or ROS's own xacro.

Neither is required: a plain URDF needs none.  Expanding evaluates expressions of the file, so it
may come from the user's own disk only.
"""

import importlib
import os
import re

from mrs_simulator.core.reading import ScenarioError, shown
from mrs_simulator.vehicles.importing.xml_reading import read_text

ADVICE = (
    "wanted xacrodoc (pip install xacrodoc) or ROS's xacro (apt install ros-noetic-xacro), or the "
    "file expanded before: rosrun xacro xacro {} > robot.urdf"
)


def description_text(path, arguments, packages):
    """Return the URDF text of the URDF or xacro file at ``path``.

    ``arguments``: values by name for ``$(arg name)``; ``packages``: a ``Packages``.  Raises
    ``ScenarioError``.
    """
    text = read_text(path)
    if not is_xacro(path, text):
        if arguments:
            name = sorted(arguments)[0]
            raise ScenarioError(
                "{}: argument {}, but it is no xacro file".format(path, shown(name))
            )
        return text
    values = {name: _spelled(value) for name, value in arguments.items()}
    try:
        return _expanded(path, values, packages)
    except ScenarioError:
        raise
    except ModuleNotFoundError as error:  # xacro from PyPI finds packages of ROS 2 only
        raise ScenarioError("{}: {}: {}".format(path, error, _advice(path))) from None
    except (Exception, SystemExit) as error:  # whatever the file's own expressions raise
        text = " ".join(str(error).split()) or type(error).__name__
        raise ScenarioError("{}: xacro cannot expand it: {}".format(path, text[:300])) from None


def is_xacro(path, text=""):
    """Return whether a file is xacro: by its ending, or by the namespace that it declares."""
    return path.endswith(".xacro") or re.search(r"xmlns:xacro\s*=", text) is not None


def _expanded(path, values, packages):
    if _there("xacrodoc"):
        import xacrodoc

        xacrodoc.packages.update_package_cache(packages.known())
        return xacrodoc.XacroDoc.from_file(path, subargs=values, resolve_packages=False).dom.toxml()
    if _there("xacro"):
        import xacro

        return xacro.process_file(path, mappings=values).toxml()
    raise ScenarioError("{}: is a xacro file: {}".format(path, _advice(path)))


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
