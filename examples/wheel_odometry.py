"""A formation under wheel odometry.

The same law, once with true poses and once with what wheels count: radii and track are off by a percent or
so, wheels slip, and the estimate drifts. The picture has both side by side, and the second verdict says
how far theory is missed. Run: python3 examples/wheel_odometry.py
"""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mrs_simulator import simulate

SCENARIO = {
    "poses": [[5, -3, 0], [2, 3, 0], [-2, -4, 0], [-5, 2, 0]],
    "control": {"protocol": "formation", "parameters": {"k": 0.02, "T": 0.1, "l": 0.3, "c": 2.0}},
    "limits": {"v_max": 1.5, "omega_max": 6.0},
    "duration": 60,
}
SOURCES = {"world": "true poses", "wheel": "wheel odometry"}


def study(out, **changes):
    """Run both, draw them to ``out``, and return the run under wheel odometry."""
    figure = Figure(figsize=(10, 4.5), constrained_layout=True)
    FigureCanvasAgg(figure)
    runs = {}
    for axes, (source, title) in zip(figure.subplots(1, 2), SOURCES.items()):
        place = "{}/{}".format(out, source)
        runs[source] = simulate(SCENARIO, out=place, odometry=source, **changes)
        runs[source].trajectories(ax=axes)
        axes.set_xlabel("$x$ [m], {}".format(title))
    figure.savefig("{}/wheel_odometry.png".format(out))
    true, wheels = (runs[source].run.pose[-1, :, :2] for source in SOURCES)
    print("ends are up to {:.2f} m apart".format(np.linalg.norm(true - wheels, axis=1).max()))
    return runs["wheel"]


if __name__ == "__main__":
    print(study("runs/wheel_odometry"))
