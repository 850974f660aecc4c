"""Consensus under loss: a sweep.

Six points agree over a ring whose messages are lost with a chance of 0 to 0.8, three seeds each. The runs
are spread over the machine's cores; ``sweep.csv`` holds every number, ``sweep.png`` draws them. An
interrupted sweep goes on where it was. Run: python3 examples/lossy_sweep.py
"""

from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.run.sweep import make_runs, read_axis, run_sweep, summary

AXES = ("links.loss=0.0..0.8/5", "seed=0..2")


def study(out, axes=AXES, jobs=None, **changes):
    """Sweep ``axes``, write table and picture to ``out``, and return the verdicts."""
    path = scenario_path("consensus_drops.yaml")
    runs = make_runs(path, map(read_axis, axes), given=changes)
    return run_sweep(runs, out, jobs=jobs)


if __name__ == "__main__":
    print("\n".join(summary(study("runs/lossy_sweep"))))
