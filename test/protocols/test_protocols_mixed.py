"""Every shipped protocol drives a team of three kinds; one of each family is run in the tests.

All of them: ``PYTHONPATH=test python3 test/protocols/test_protocols_mixed.py [kinds] [--ros] [--gui]``;
it prints what is not judged, and why, and how far the poses of a run over ROS, and of one started in
the GUI, are from those of the run without ROS at the same times.
"""

import argparse
import itertools
import os
import sys
import tempfile

import numpy as np
import pytest
from mixed_runs import difference, each_step, headless, in_gui, over_ros

from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.protocols import HOMES, shipped
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.team.sensor_changes import SensorChange
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.registry import shipped_kind

SCENARIOS = os.path.join(
    os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "scenarios"
)
OTHER_NAMES = {"formation": "paper_four"}
ON_THE_GROUND = {"trajectory": {"waypoints": "0 0, 3 0, 4 2.5, 1 4"}}  # of scenarios in space
KINDS = ("pioneer3dx", "robotino3", "turtlebot3_burger")
SAME = 1e-9  # [m, rad] by which poses at the same time may differ
WITH_ARMS = {"carrying"}  # laws of robots that carry a load
ANYBODY = {name: home for name, home in sorted(HOMES.items()) if name not in WITH_ARMS}
FAMILIES = sorted({module: name for name, (module, _) in ANYBODY.items()}.values())


def mixed(name, kinds=KINDS, duration=None):
    """Return the shipped scenario of the protocol ``name`` with robots of ``kinds`` by turns.

    They stand so that their controlled points are those of the scenario's own robots.
    """
    path = os.path.join(SCENARIOS, OTHER_NAMES.get(name, name) + ".yaml")
    scenario = load_scenario(path)
    kinds = tuple(itertools.islice(itertools.cycle(kinds), scenario.n))
    duration = min(scenario.duration, duration or scenario.duration)
    other = scenario._replace(kinds=kinds, duration=duration, sensors=_fitted(scenario, kinds))
    if name in ON_THE_GROUND:
        parameters = dict(scenario.control.parameters, **ON_THE_GROUND[name])
        control = scenario.control._replace(dimension=None, parameters=parameters)
        other = other._replace(altitude=None, control=control)
    l, poses = scenario.hand_length, scenario.poses.copy()
    points = Team.from_scenario(other).point(poses, np.zeros(other.n), l)
    poses[:, :2] += hand_points(poses, l) - points
    return other._replace(poses=poses)


def _fitted(scenario, kinds):
    """Return the scenario's sensors; robots of ``kinds`` that lack those of its own get them first."""
    own = shipped_kind(scenario.kinds[0]).mounts
    lacking = [
        SensorChange({name: {k: v for k, v in mount.items() if k != "fitted"}}, (row + 1,))
        for row, kind in enumerate(kinds)
        for name, mount in own.items()
        if name in shipped(scenario.control.protocol).SENSORS
        and name not in shipped_kind(kind).mounts
    ]
    return tuple(lacking) + scenario.sensors


@pytest.mark.parametrize("name", FAMILIES)
def test_a_protocol_of_each_family_runs_on_three_kinds(name, tmp_path):
    verdict, found = headless(mixed(name, duration=3.0), tmp_path)
    assert verdict["ended"] == "complete", verdict["ended"]
    wrong = [one for one in verdict["checks"] if one["passed"] is False]
    assert not wrong, wrong
    assert found.axes == ("linear.x", "linear.y", "angular.z")
    unicycles = [row for row, kind in enumerate(found.scenario.kinds) if kind != "robotino3"]
    bases = [row for row, kind in enumerate(found.scenario.kinds) if kind == "robotino3"]
    assert not found.command[:, unicycles, 1].any()
    np.testing.assert_array_equal(found.hand[:, bases], found.pose[:, bases, :2])


@pytest.mark.processes
@pytest.mark.parametrize("way", [over_ros, in_gui])
def test_a_protocol_on_three_kinds_goes_where_it_does_without_ros(way, tmp_path):
    scenario = mixed("formation", duration=3.0)
    (tmp_path / "alone").mkdir()
    (tmp_path / "other").mkdir()
    alone = headless(each_step(scenario), tmp_path / "alone")[1]
    assert np.abs(alone.pose[-1] - alone.pose[0]).max() > 0.5
    assert difference(alone, way(scenario, tmp_path / "other")) < SAME


def shown_differences(scenario, ways):
    """Return in words how far the ways' runs are from the one without ROS, and whether that is too far."""
    told, wrong = [], False
    if ways:
        with tempfile.TemporaryDirectory() as out:
            alone = headless(each_step(scenario), out)[1]
    for way in ways:
        with tempfile.TemporaryDirectory() as other:
            apart = difference(alone, way(scenario, other))
        told.append("{} {:.1e}".format(way.__name__, apart))
        wrong = wrong or not apart < SAME
    return ", ".join(told), wrong


def main():
    """Run protocols on teams of several kinds, and print what their verdicts say."""
    parser = argparse.ArgumentParser(description="Run every shipped protocol on a mixed team.")
    parser.add_argument("kinds", nargs="?", default=",".join(KINDS), help="default: %(default)s")
    parser.add_argument("--ros", action="store_true", help="over ROS in lockstep as well")
    parser.add_argument("--gui", action="store_true", help="started in the GUI as well")
    parser.add_argument("--only", default=",".join(ANYBODY), help="names of protocols")
    parser.add_argument(
        "--seconds", type=float, default=10.0, help="of runs that are compared (default: 10)"
    )
    options = parser.parse_args()
    ways = [over_ros] * options.ros + [in_gui] * options.gui
    kinds, failed = tuple(options.kinds.split(",")), 0
    for name in options.only.split(","):
        with tempfile.TemporaryDirectory() as out:
            verdict, _ = headless(mixed(name, kinds=kinds), out)
        bad = [check["name"] for check in verdict["checks"] if check["passed"] is False]
        short = mixed(name, kinds=kinds, duration=options.seconds)
        apart, wrong = shown_differences(short, ways)
        failed += bool(bad) or verdict["ended"] != "complete" or wrong
        print("{:28} {} {} {}".format(name, verdict["outcome"], apart, "; ".join(bad)), flush=True)
        for check in verdict["checks"]:
            if check["passed"] is None:
                print("    {name}: {note}".format(**check), flush=True)
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
