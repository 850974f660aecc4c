"""Compiles what moves the robots of shipped scenarios, so that the first long run need not wait for it.

    python3 -m mrs_simulator.study.run.compile_ahead [SCENARIO ...]

What is compiled is kept where ``core.compiling.jit`` says.  Without numba nothing is done.
"""

import argparse
import os
from importlib.util import find_spec

from mrs_simulator.core.compiling import is_chosen, is_wanted
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path, shipped_scenarios
from mrs_simulator.study.run.experiment import Experiment


def compile_ahead(names):
    """Compile for the scenarios ``names``; return those of which that is possible."""
    return [name for name in names if _compile(load_scenario(scenario_path(name)))]


def _compile(scenario):
    experiment = Experiment(scenario)
    try:
        return experiment.compile()
    finally:
        experiment.world.close()


def main(argv=None):
    """Compile for the scenarios named, by default for all that ship, and print for which."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="by default all that ship")
    names = parser.parse_args(argv).scenarios
    if find_spec("numba") is None or (is_chosen() and not is_wanted()):
        return
    shipped = (each for each in os.listdir(shipped_scenarios()) if each.endswith(".yaml"))
    print("compiled: " + ", ".join(compile_ahead(names or sorted(shipped))))


if __name__ == "__main__":
    main()
