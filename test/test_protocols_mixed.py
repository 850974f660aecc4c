"""Every shipped protocol drives a team of three kinds; one of each family is run in the tests.

All of them: ``python3 test/test_protocols_mixed.py [kinds]``; it prints what is not judged, and why.
"""

import itertools
import os
import sys

import numpy as np
import pytest

from mrs_simulator.control.laws import HOMES
from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.core.recording import read_run_csv
from mrs_simulator.core.scenario import load_scenario
from mrs_simulator.study.experiment import run_experiment
from mrs_simulator.vehicles import Team

SCENARIOS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenarios")
OTHER_NAMES = {"formation": "paper_four"}
KINDS = ("pioneer3dx", "robotino3", "turtlebot3_burger")
FAMILIES = sorted({home.partition(":")[0]: name for name, home in sorted(HOMES.items())}.values())


def mixed(name, kinds=KINDS, duration=None):
    """Return the shipped scenario of the protocol ``name`` with robots of ``kinds`` by turns.

    They stand so that their controlled points are those of the scenario's own robots.
    """
    path = os.path.join(SCENARIOS, OTHER_NAMES.get(name, name) + ".yaml")
    scenario = load_scenario(path)
    kinds = tuple(itertools.islice(itertools.cycle(kinds), scenario.n))
    duration = min(scenario.duration, duration or scenario.duration)
    other = scenario._replace(kinds=kinds, duration=duration)
    l, poses = scenario.hand_length, scenario.poses.copy()
    points = Team.from_scenario(other).point(poses, np.zeros(other.n), l)
    poses[:, :2] += hand_points(poses, l) - points
    return other._replace(poses=poses)


def run(name, out, **how):
    """Run ``mixed(name)``; return its verdict and its run."""
    scenario = mixed(name, **how)
    verdict = run_experiment(scenario, str(out), formats=())
    return verdict, read_run_csv(os.path.join(str(out), "run.csv"), scenario)


@pytest.mark.parametrize("name", FAMILIES)
def test_a_protocol_of_each_family_runs_on_three_kinds(name, tmp_path):
    verdict, found = run(name, tmp_path, duration=5.0)
    assert verdict["ended"] == "complete", verdict["ended"]
    wrong = [one for one in verdict["checks"] if one["passed"] is False]
    assert not wrong, wrong
    assert found.axes == ("linear.x", "linear.y", "angular.z")
    unicycles = [row for row, kind in enumerate(found.scenario.kinds) if kind != "robotino3"]
    bases = [row for row, kind in enumerate(found.scenario.kinds) if kind == "robotino3"]
    assert not found.command[:, unicycles, 1].any()
    np.testing.assert_array_equal(found.hand[:, bases], found.pose[:, bases, :2])


def main():
    """Run every protocol on three kinds, and print what its verdict says."""
    import tempfile

    kinds = tuple(sys.argv[1].split(",")) if len(sys.argv) > 1 else KINDS
    failed = 0
    for name in sorted(HOMES):
        with tempfile.TemporaryDirectory() as out:
            verdict, _ = run(name, out, kinds=kinds)
        bad = [check["name"] for check in verdict["checks"] if check["passed"] is False]
        failed += bool(bad) or verdict["ended"] != "complete"
        print("{:28} {} {}".format(name, verdict["outcome"], "; ".join(bad)), flush=True)
        for check in verdict["checks"]:
            if check["passed"] is None:
                print("    {name}: {note}".format(**check), flush=True)
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
