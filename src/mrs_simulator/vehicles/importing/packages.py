"""Finding files that a robot's description names: ``package://``, ``file://`` and relative paths.

A package is found as ROS 1 finds it: the directories in ``ROS_PACKAGE_PATH`` are searched in
order for a ``package.xml`` with that name.  Before them come packages that the user names, and the
package in which the description itself lies.
"""

import os
import re
import urllib.parse
import xml.etree.ElementTree as ElementTree

from mrs_simulator.scenario.reading import shown, unwanted

IGNORED = ("CATKIN_IGNORE", "COLCON_IGNORE", "AMENT_IGNORE", "rospack_nosubdirs")
DEEPEST = 12  # [-] directories below one in ROS_PACKAGE_PATH


class Packages:
    """Finds packages' directories and the files that descriptions name."""

    def __init__(self, relative_to, given=None, search=None):
        """``relative_to``: directory of the description; ``given``: directories by package name.

        ``search``: directories in the manner of ``ROS_PACKAGE_PATH``, by default its own.
        """
        self._relative_to = os.path.abspath(relative_to)
        self._given = dict(given or {})
        paths = os.environ.get("ROS_PACKAGE_PATH", "") if search is None else search
        self._search = [path for path in paths.split(os.pathsep) if path]
        self._found = None

    def directory(self, name):
        """Return the directory of the package ``name``, None if there is none."""
        if name in self._given:
            return self._given[name]
        return self._around().get(name) or self._searched().get(name)

    def known(self):
        """Return the directories of all packages named by the user or that hold the description."""
        return dict(self._around(), **self._given)

    def _around(self):
        """Return the packages in which the description lies, by name."""
        found, directory = {}, self._relative_to
        while directory != os.path.dirname(directory):
            name = package_name(directory)
            if name:
                found.setdefault(name, directory)
            directory = os.path.dirname(directory)
        return found

    def _searched(self):
        if self._found is None:
            self._found = {}
            for top in self._search:
                for name, directory in _packages_in(top):
                    self._found.setdefault(name, directory)
        return self._found

    def file(self, uri, where):
        """Return ``(path, "")`` of the file that ``uri`` names, or ``(None, why)`` if there is none.

        Raises ``ScenarioError`` for an unknown scheme.
        """
        scheme, _, rest = uri.rpartition("://")
        if scheme == "package":
            name, _, inner = rest.partition("/")
            directory = self.directory(name)
            if directory is None:
                return None, "package {} is not in ROS_PACKAGE_PATH".format(shown(name))
            path = os.path.join(directory, inner)
        elif scheme in ("", "file"):
            path = os.path.join(self._relative_to, urllib.parse.unquote(rest) if scheme else rest)
        else:
            raise unwanted(where, uri, "package://, file:// or a path")
        path = os.path.abspath(path)
        try:
            there = os.path.isfile(path)
        except ValueError:  # a path with a zero byte
            there = False
        return (path, "") if there else (None, "no file {}".format(path))


def package_name(directory):
    """Return the name in ``directory``'s ``package.xml``, None if there is none."""
    try:
        root = ElementTree.parse(os.path.join(directory, "package.xml")).getroot()
    except (OSError, ElementTree.ParseError, ValueError, LookupError):
        return None
    name = root.findtext("name") if root.tag == "package" else None
    return name.strip() if name and re.fullmatch(r"\s*[\w-]+\s*", name) else None


def _packages_in(top):
    """Yield name and directory of the packages in and below ``top``; none lies within another."""
    for directory, inner, files in os.walk(top):
        if any(name in files for name in IGNORED):
            inner.clear()
            continue
        name = package_name(directory) if "package.xml" in files else None
        if name:
            yield name, directory
        too_deep = directory[len(top) :].count(os.sep) >= DEEPEST
        if name or too_deep:
            inner.clear()
        inner[:] = sorted(each for each in inner if not each.startswith("."))
