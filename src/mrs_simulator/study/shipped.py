"""Locates the scenarios that come with the package."""

import difflib
import os

from mrs_simulator.core.reading import ScenarioError


def shipped_scenarios():
    """Return the directory of the shipped scenarios."""
    import rospkg  # only who asks for them needs it

    return os.path.join(rospkg.RosPack().get_path("mrs_simulator"), "scenarios")


def scenario_path(name):
    """Return the path of the scenario file ``name``; one without a directory may be a shipped one.

    Raises ``ScenarioError`` that says where it was looked for, with the nearest name.
    """
    if os.path.exists(name):
        return name
    places = [os.path.dirname(os.path.abspath(name))]
    if os.path.basename(name) == name:
        places.append(shipped_scenarios())
        if os.path.exists(os.path.join(places[-1], name)):
            return os.path.join(places[-1], name)
    raise ScenarioError(_missing(name, places))


def _missing(name, places):
    there = [file for place in places if os.path.isdir(place) for file in os.listdir(place)]
    files = sorted({file for file in there if file.endswith((".yaml", ".yml"))})
    near = difflib.get_close_matches(os.path.basename(name), files, n=1)
    hint = "; did you mean {!r}?".format(near[0]) if near else ""
    return "scenario {}: no such file (looked in {}){}".format(name, ", ".join(places), hint)
