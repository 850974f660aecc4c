"""The program ``requirements``: the signals that formulas may use, and those that a scenario states."""

import argparse
import sys

from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.requirements import OPEN, SIGNALS
from mrs_simulator.scenario.scenario import load_scenario


def listing():
    """Return the signals, their units and domains, as lines of text."""
    row = "  {:20} {:6} {:8} {}"
    lines = [row.format("signal", "unit", "of each", "")]
    for name, kind in {**SIGNALS, **OPEN}.items():
        lines.append(row.format(name, kind.unit or "-", kind.domain or "-", kind.meaning))
    return "\n".join(lines)


@printing
def main(argv=None):
    """Print the signals; of a scenario, its requirements too; exit with 2 where it cannot be read."""
    parser = argparse.ArgumentParser(
        prog=program("requirements"), description="List the signals of requirements."
    )
    parser.add_argument("scenario", nargs="?", help="whose requirements are read and printed, too")
    parser.add_argument("--list", action="store_true", help="as without it: print the signals")
    arguments = parser.parse_args(argv)
    if arguments.scenario:
        try:
            scenario = load_scenario(arguments.scenario)
        except (OSError, ScenarioError) as error:
            print("requirements: {}".format(error), file=sys.stderr)
            sys.exit(2)
        for each in scenario.requirements:
            print("  {}: {}".format(each.name, each.text))
    print(listing())
