"""Determines which robots are real, from the command line, a parameter or the clock in use."""

import rospy

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.ros.node.node_parameters import REAL
from mrs_simulator.ros.node.parameters import read


@explained_by("docs/robots.md#robots-and-simulated-robots-in-one-team")
def real_rows(text):
    """Return the rows of the robots whose numbers are listed in ``text``, such as "2,4"."""
    try:
        numbers = [int(part) for part in text.split(",")] if text.strip() else []
    except ValueError:
        raise ValueError(
            "real = {!r}: wanted robots' numbers with commas between them".format(text)
        ) from None
    return sorted({number - 1 for number in numbers})


@explained_by("docs/robots.md#robots-and-simulated-robots-in-one-team")
def real_among(n):
    """Return the rows of the robots of a team of n that are real, ascending.

    Without simulated time all are; with it those of the parameter ``~real``, "2,4" or [2, 4].
    """
    if not rospy.get_param("/use_sim_time", False):
        return list(range(n))
    rows = real_rows(read(REAL).strip("[] "))
    wrong = [row + 1 for row in rows if not 0 <= row < n]
    if wrong:
        name = rospy.resolve_name("~real")
        raise ValueError(
            "parameter {} names {}: wanted numbers from 1 to {}".format(name, wrong, n)
        )
    return rows
