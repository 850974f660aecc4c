"""RViz opens with a view that holds all robots and obstacles of the scenario."""

import os

import numpy as np
import yaml

from mrs_simulator.nodes.display.rviz_view import AREA, bounds, set_views
from mrs_simulator.scenario.scenario import scenario_from_dict

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCENARIO = {
    "poses": [[0.0, 0.0, 0.0], [4.0, 2.0, 0.0]],
    "obstacles": [
        {"type": "box", "center": [60.0, -45.0], "size": [2.0, 4.0]},
        {"type": "land", "name": "shore", "center": [0.0, 900.0], "size": [9.0, 9.0]},
    ],
}


def test_views_hold_robots_and_obstacles():
    low, high = bounds(scenario_from_dict(SCENARIO))
    np.testing.assert_allclose([low, high], [[0.0, -47.0], [61.0, 2.0]])
    with open(os.path.join(ROOT, "rviz", "mrs_simulator.rviz"), encoding="utf-8") as file:
        configuration = yaml.safe_load(file)
    set_views(configuration, low, high)
    view = configuration["Visualization Manager"]["Views"]["Current"]
    half = 0.5 * AREA / view["Scale"]
    middle = np.array([view["X"], view["Y"]])
    assert (middle - half < low).all() and (middle + half > high).all()
    assert (half < 1.5 * (high - low)).any()  # and not much more
    assert yaml.safe_load(yaml.safe_dump(configuration)) == configuration
