"""Locates the scenarios that come with the package."""

import argparse
import difflib
import os

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import load_scenario

PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
# Inside the installed package, or beside src in the repository.
PLACES = (
    os.path.join(PACKAGE, "scenarios"),
    os.path.join(os.path.dirname(os.path.dirname(PACKAGE)), "scenarios"),
)


def shipped_scenarios():
    """Return the directory of the shipped scenarios."""
    return next(filter(os.path.isdir, PLACES), PLACES[0])


@explained_by("docs/scenarios.md#shipped-scenarios")
def scenario_path(name):
    """Return the path of the scenario file ``name``; one without a directory may be a shipped one.

    A shipped one may be named without its ending.

    Raises ``ScenarioError`` that says where it was looked for, with the nearest name.
    """
    if os.path.exists(name) and not os.path.isdir(name):
        return name
    places = [os.path.dirname(os.path.abspath(name))]
    if os.path.basename(name) == name:
        places.append(shipped_scenarios())
        for file in (name, name + ".yaml"):
            if os.path.exists(os.path.join(places[-1], file)):
                return os.path.join(places[-1], file)
    if os.path.isdir(name):  # reading it reports that
        return name
    raise ScenarioError(_missing(name, places))


def _missing(name, places):
    there = [file for place in places if os.path.isdir(place) for file in os.listdir(place)]
    files = sorted({file for file in there if file.endswith((".yaml", ".yml"))})
    near = difflib.get_close_matches(os.path.basename(name), files, n=1)
    hint = "; did you mean {!r}?".format(near[0]) if near else ""
    return "scenario {}: no such file (looked in {}){}".format(name, ", ".join(places), hint)


@printing
def main(argv=None):
    """Run the command ``scenarios``: print the name and title of each."""
    argparse.ArgumentParser(
        prog=program("scenarios"), description="List the scenarios that ship."
    ).parse_args(argv)
    for name in sorted(os.listdir(shipped_scenarios())):
        if name.endswith(".yaml"):
            title = load_scenario(os.path.join(shipped_scenarios(), name)).title
            print("{:32}{}".format(name, title))
