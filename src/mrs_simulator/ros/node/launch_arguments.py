"""Misspelt arguments of roslaunch, which it ignores without a word."""

import os
import xml.etree.ElementTree as ElementTree

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import unknown_name
from mrs_simulator.ros.node.deferred_output import roslaunch_words


@explained_by("docs/nodes.md#simulationlaunch")
def refuse_unknown_launch_arguments():
    """Raise ``ValueError`` for a ``name:=value`` that the launch file of this node does not declare.

    Asks the roslaunch that started this process for its command line; does nothing without one.
    """
    words = roslaunch_words()
    if words is None:
        return
    declared = _declared([word for word in words if ":=" not in word])
    if declared is None:
        return
    for word in words:
        name, assigned, _ = word.partition(":=")
        if assigned and not name.startswith("_") and name not in declared:
            raise ValueError(unknown_name("roslaunch: {}".format(word), name, declared))


def _declared(words):
    """Return the arguments that the launch files among ``words`` declare, None if none is found."""
    paths = [word for word in words if os.path.isfile(word)]
    for package, name in zip(words, words[1:]):
        if name.endswith(".launch") and not os.path.isfile(name):
            paths += _in_package(package, name)
    try:
        trees = [ElementTree.parse(path) for path in paths]
    except (OSError, ElementTree.ParseError):
        return None
    return {arg.get("name") for tree in trees for arg in tree.getroot().iter("arg")} or None


def _in_package(package, name):
    import roslib.packages  # slow to import, wanted only under roslaunch
    import rospkg

    try:
        return roslib.packages.find_resource(package, name)
    except (rospkg.ResourceNotFound, roslib.packages.ROSPkgException):
        return []
