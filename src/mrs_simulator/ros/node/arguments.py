"""Command-line arguments of the nodes that are not ROS parameters.

Names of protocols and files select code and places to write.  They come from the command line
(``--protocol NAME``, or ``_protocol:=NAME`` as rosrun users write it), never from the parameter
server, where anybody on the network could have put them.
"""

import argparse
import os
import sys
import xml.etree.ElementTree as ElementTree

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import shown, unknown_name
from mrs_simulator.ros.node.deferred_output import roslaunch_words
from mrs_simulator.ros.node.node_parameters import help_text
from mrs_simulator.scenario.scenario import OVERRIDES, load_scenario
from mrs_simulator.scenario.shipped import scenario_path

DEFAULT_SCENARIO = "paper.yaml"
# What selects and changes the scenario: the same for all nodes of a run.
RUN_ARGUMENTS = {
    "scenario": "YAML file of the scenario (default: the paper's)",
    "protocol": "a shipped one, package.module:Class or file.py:Class (default: the scenario's)",
    "robots": "number of robots (default: the scenario's)",
    "fidelity": "kinematic, dynamic or point_mass (default: the scenario's)",
    "engine": "of fidelity dynamic, pybullet or planar (default: the scenario's)",
    "odometry": "world or wheel (default: the scenario's)",
    "limits": "firmware, top or none (default: the scenario's)",
    "duration": "simulated seconds of the run (default: the scenario's)",
}
DIRECTORY_MEANING = "where relative file names begin (default: the current directory)"


def parse(description, names, argv=None, node=""):
    """Return the local arguments called ``names`` as attributes, "" where not given.

    roslaunch's ``__name:=`` and the ``_parameter:=`` and ``topic:=`` of others are left to rospy.
    ``--help`` lists the parameters of ``node`` too.
    """
    refuse_unknown_launch_arguments()
    parser = argparse.ArgumentParser(
        description=description,
        epilog=help_text(node) if node else None,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    for name, meaning in dict(names, directory=DIRECTORY_MEANING).items():
        parser.add_argument("--" + name, default="", help=meaning)
    plain = []
    for argument in sys.argv[1:] if argv is None else argv:
        name, assigned, value = argument.partition(":=")
        if assigned and name.lstrip("_") in names and name.startswith("_"):
            plain += ["--" + name.lstrip("_"), value]
        elif not assigned:
            plain.append(argument)
    arguments = parser.parse_args(plain)
    # roslaunch starts nodes in a directory of its own; on another machine there may be none like it.
    if os.path.isdir(arguments.directory):
        os.chdir(arguments.directory)
    return arguments


def scenario_from(arguments):
    """Return the scenario that the arguments name; the paper's by default."""
    scenario = load_scenario(scenario_path(arguments.scenario or DEFAULT_SCENARIO))
    given = {key: getattr(arguments, key, "") for key in ("protocol", *OVERRIDES)}
    given["robots"] = _number(arguments, "robots", int)
    given["duration"] = _number(arguments, "duration", float)
    return scenario.overridden(**{key: value or None for key, value in given.items()})


def _number(arguments, name, kind):
    text = getattr(arguments, name, "")
    try:
        return kind(text or 0)
    except ValueError:
        raise ValueError("{} = {}: wanted a number".format(name, shown(text))) from None


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
