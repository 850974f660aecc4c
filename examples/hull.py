"""Containment: followers go into the hull of their leaders.

The shipped protocol ``containment`` states the followers' places, -L_ff^-1 L_fl p_l, and its verdict
compares them with the run. The hull is drawn over the run's own figure. Run: python3 examples/hull.py
"""

from matplotlib.patches import Polygon

from mrs_simulator import simulate


def study(out, **changes):
    """Run it, draw it to ``out``, and return the run."""
    run = simulate("containment.yaml", out=out, **changes)
    leaders = run.run.hand[-1, -4:]  # the last four robots of that scenario stand around a square
    figure = run.trajectories()
    figure.axes[0].add_patch(Polygon(leaders, color="#0072b2", alpha=0.12, label="Hull"))
    figure.savefig("{}/hull.png".format(out))
    return run


if __name__ == "__main__":
    print(study("runs/hull"))
