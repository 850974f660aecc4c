"""A study on robots, rehearsed.

Robots obey late, and their wheels are not quite as the data sheet says. Here a simulation with such a
mismatch stands for the robots; ``write_comparison`` lays it over the nominal one and estimates delay,
wheels and track. With recordings from the laboratory the same comes from

    roslaunch mrs_simulator rosaria.launch scenario:=lab_four.yaml robots:=4 ports:=A,B,C,D out:=lab
    rosrun mrs_simulator report --compare lab/run.csv simulated/run.csv --out compared

Run: python3 examples/real_robots.py
"""

import yaml

from mrs_simulator import simulate
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.results.compare import comparison_text, write_comparison

MISMATCH = {"delay": 0.2, "speed": 0.96, "track": 1.05}


def study(out, **changes):
    """Run both, compare them in ``out``, and return the run that stands for the robots."""
    with open(scenario_path("lab_four.yaml"), encoding="utf-8") as file:
        scenario = yaml.safe_load(file)
    simulated = simulate(scenario, out="{}/simulated".format(out), **changes)
    scenario["mismatch"] = MISMATCH
    robots = simulate(scenario, out="{}/robots".format(out), **changes)
    robots.trajectories().savefig("{}/real_robots.png".format(out))
    print(comparison_text(write_comparison(robots.run, simulated.run, out, ("png",))))
    return robots


if __name__ == "__main__":
    print(study("runs/real_robots"))
