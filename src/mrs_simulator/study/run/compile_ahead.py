"""Compiles what moves the robots of shipped scenarios, so that the first long run need not wait for it.

What is compiled is kept where ``core.compiling.jit`` says.
"""

import argparse
import os
from importlib.util import find_spec

import numpy as np

from mrs_simulator.core.compiled_neighbours import compiled_near
from mrs_simulator.core.compiling import VARIABLE, chosen, is_chosen, is_wanted
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.protocols.exploration.equations import ways
from mrs_simulator.record.compiled_rows import Filler
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.shipped import scenario_path, shipped_scenarios
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.run.experiment import Experiment, steps_of

LAST = 10  # [-] steps of a run that are made from command to command where that can be
MEETING = {  # under the safety filter
    "poses": [[0.0, 0.0, 0.0], [1.5, 0.0, 3.1416]],
    "limits": "firmware",
    "duration": 2.0,
    "topology": {"preset": "complete"},
    "control": {"protocol": "consensus", "safety": True},
}
# Robots whose filter is compiled part by part, for so long that they brake before each other.
SLIDING = dict(MEETING, model="robotino3", duration=8.0)
# A crowd that is drawn together, of so many that pairs are looked for in a grid, and for so long that they
# are looked for again.
TOUCHING = {
    "robots": 289,
    "poses": {"layout": "grid", "spacing": 0.65},
    "limits": "top",
    "duration": 4.0,
    "topology": {"preset": "path"},
    "control": {"protocol": "consensus"},
}
FORCED = {
    "poses": [[0.0, 0.0, 0.0], [4.0, 0.0, 3.1416]],
    "fidelity": "dynamic",
    "limits": "top",
    "duration": 0.4,
    "topology": {"preset": "complete"},
    "control": {"protocol": "consensus"},
}
ROLLING = dict(FORCED, engine="planar")
AMONG_OTHERS = dict(ROLLING, model=["pioneer3dx", "husky"])  # whose wheels slide
SENSING = dict(FORCED, fidelity="kinematic", record=["laser", "others"])
SENSING["sensors"] = [{"mounts": {"laser": {}, "others": {"type": "range_bearing"}}}]
FLYING = dict(FORCED, model="crazyflie2", altitude=1.0)


def compile_ahead(names):
    """Compile for the scenarios ``names``; return the names of those that can be compiled.

    Of robots that fly also as they fly with forces, of robots on wheels with forces as the fast engine
    moves them.
    """
    return [name for name in names if _compile(load_scenario(scenario_path(name)))]


def _compile(scenario):
    experiment = Experiment(scenario)
    safety = experiment.control.safety_filter
    try:
        if safety.acts and not safety.sensors:
            for content in (MEETING, SLIDING):
                _compile_run(content)
            return True
        if scenario.fidelity == "kinematic" and experiment.world.team.is_spatial:
            return _compile(scenario.changed(fidelity="dynamic"))
        if _is_of_pybullet(scenario, experiment.world.team):
            return _compile(scenario.changed(engine="planar"))
        return experiment.compile()
    finally:
        experiment.world.close()


def _is_of_pybullet(scenario, team):
    """Return whether pybullet moves all robots of the ``team``, and the fast engine could."""
    on_wheels = all(kind.module.MEDIUM == "ground" for kind in team.kinds) and not team.has_arms
    return scenario.fidelity == "dynamic" and scenario.engine == "pybullet" and on_wheels


def compile_loops():
    """Compile what runs come to use after a while: the loops of contacts, of rays, of wheels and rotors
    with forces, of ways over a floor, and of text."""
    Filler([1], [""]).filled([0.0], np.zeros((1, 1, 7)))
    compiled_near()(np.zeros((2, 2)), 1.0)
    with chosen("1"):
        ways(np.ones((1, 1), dtype=bool), 1.0, (0, 0))
    for content in (TOUCHING, SENSING, ROLLING, AMONG_OTHERS, FLYING):
        _compile_run(content)


def _compile_run(content):
    """Compile the loops that a run of the scenario ``content`` uses, with the sensors that it records."""
    with chosen("1"):
        scenario = scenario_from_dict(content)
        experiment = Experiment(scenario)
        try:
            experiment.begin()
            experiment.watch(dict.fromkeys(range(scenario.n), scenario.record))
            while experiment.step < steps_of(scenario) - LAST:
                experiment.go_on()
            for _ in experiment.stepping():
                pass
        finally:
            experiment.world.close()


@printing
def main(argv=None):
    """Compile for the scenarios named, and print for which; by default for all that ship, and the loops of
    contacts, of rays, of forces, of ways and of text.

    Exits with 2 without numba, where the environment forbids compiling, and for bad scenarios.
    """
    parser = argparse.ArgumentParser(prog=program("compile"), description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="by default all that ship")
    names = parser.parse_args(argv).scenarios
    shipped = (each for each in os.listdir(shipped_scenarios()) if each.endswith(".yaml"))
    with refusing_bad_input("compile"):
        _check_able()
        done = compile_ahead(names or sorted(shipped))
        if not names:
            compile_loops()
    print("compiled: " + (", ".join(done) or "none of them can be"))


def _check_able():
    if find_spec("numba") is None:
        raise ValueError("numba is not installed, wanted `pip install numba`")
    if is_chosen() and not is_wanted():
        raise ValueError("{}=0: nothing is compiled".format(VARIABLE))


if __name__ == "__main__":
    main()
