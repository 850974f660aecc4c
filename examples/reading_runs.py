"""Read run.csv in pandas.

A run's table has one row for each sample and robot. Here: the path that each robot drove, its highest
speed, and from when on it was within 5 cm of where it ends. Wants pandas.
Run: python3 examples/reading_runs.py
"""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mrs_simulator import simulate

try:
    import pandas
except ModuleNotFoundError:
    raise SystemExit(
        "reading_runs.py: pandas is missing; wanted it installed: pip install pandas"
    ) from None


def study(out, **changes):
    """Run it, read it back, draw it to ``out``, and return the run."""
    run = simulate("paper_four.yaml", out=out, **changes)
    table = pandas.read_csv("{}/run.csv".format(out))  # the same: run.to_pandas()
    ends = table.groupby("robot")[["x", "y"]].transform("last")
    table["left"] = np.hypot(table.x - ends.x, table.y - ends.y)  # [m] to where it ends
    robots = table.groupby("robot")
    step = np.hypot(robots.x.diff(), robots.y.diff())
    table_of_robots = pandas.DataFrame(
        {
            "path [m]": step.groupby(table.robot).sum(),
            "highest speed [m/s]": robots.v.apply(lambda v: v.abs().max()),
            "within 5 cm from [s]": table[table.left > 0.05].groupby("robot").time.max(),
        }
    )
    print(table_of_robots.round(2).to_string())
    figure = Figure(constrained_layout=True)
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    table.pivot(index="time", columns="robot", values="left").plot(ax=axes, logy=True)
    axes.set(xlabel="time [s]", ylabel="way to go [m]")
    figure.savefig("{}/reading_runs.png".format(out))
    return run


if __name__ == "__main__":
    print(study("runs/reading_runs"))
