"""Refuses names on a node's command line that no code reads, such as misspelt limits."""

import difflib
import sys

import rospy

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import unknown_name
from mrs_simulator.ros.node.arguments import RUN_ARGUMENTS
from mrs_simulator.ros.node.node_parameters import NAMES

# Arguments that some nodes have besides.
LOCAL = ("directory", "json", "last", "out", "preset", "real", "require_verdict")
PARAMETERS = NAMES.union(RUN_ARGUMENTS, LOCAL)
ALIKE = 0.75  # of 1, from which on a name is taken for another one misspelt


@explained_by("docs/nodes.md")
def refuse_unknown(more=(), foreign=False):
    """Raise ``ValueError`` for a ``_name:=`` that is no parameter, and for a ``name:=`` that is one.

    ``more``: names that count as parameters, besides ``PARAMETERS``; ``foreign``: a law of one's own
    may read others, as long as they are not like one of these.
    """
    known = PARAMETERS.union(more)
    for argument in sys.argv[1:]:
        name, assigned, value = argument.partition(":=")
        if not assigned or name.startswith("__"):
            continue
        if not name.startswith("_"):
            near = _nearest(name, known)
            if near:
                text = "{}: this would rename a topic; for the parameter wanted _{}:={}"
                raise ValueError(text.format(argument, near, value))
        elif name[1:] not in known and (not foreign or _nearest(name[1:], known)):
            raise ValueError(unknown_name(argument, name[1:], known))


def warn_of_unknown(more=()):
    """Warn of this node's parameters on the parameter server that may be others misspelt.

    Of others not: those of the protocol before stay there, and a law may read what it likes.
    """
    known = PARAMETERS.union(more)
    for name in sorted(set(rospy.get_param("~", {})) - known):
        near = _nearest(name, known)
        if near:
            text = "parameter %s: nothing reads it; did you mean %s?"
            rospy.logwarn(text, rospy.resolve_name("~" + name), near)


def _nearest(name, known):
    return next(iter(difflib.get_close_matches(name, known, 1, ALIKE)), "")
