"""Numbers of vessels for tests, typed out."""

from mrs_simulator.vehicles.drives import vessel
from mrs_simulator.vehicles.quantities import QuantitySection

HERON = {
    "bow": 0.675,
    "inertia": {"surge": 28.0, "sway": 28.0, "yaw": 10.0},
    "linear": {"surge": 16.45, "sway": 15.80, "yaw": 6.0},
    "quadratic": {"surge": 2.942, "sway": 2.762, "yaw": 5.0},
    "thrusters": {"curve": "linear", "arm": 0.378, "thrust_ahead": 45.0, "thrust_astern": 25.0},
    "gains": {
        "surge": {"kf": 20.0, "kp": 40.0, "ki": 2.0, "kd": 20.0},
        "yaw": {"kf": 10.0, "kp": 60.0, "kd": 20.0},
    },
}
OTTER = {
    "bow": 1.0,
    "inertia": {"surge": 85.5, "sway": 162.5, "yaw": 42.65, "sway_yaw": 12.25},
    "linear": {"surge": 77.55, "sway": 162.5, "yaw": 42.65},
    "quadratic": {"surge": 0.0, "sway": 0.0, "yaw": 426.5},
    "thrusters": {
        "curve": "square",
        "arm": 0.395,
        "thrust_ahead": 0.01108,
        "thrust_astern": 0.006445,
        "ahead": 103.93,
        "astern": 101.74,
        "lag": 0.1,
    },
    "gains": {
        "surge": {"kf": 77.55, "kp": 85.5, "ki": 20.0},
        "yaw": {"kf": 42.65, "kp": 85.0, "ki": 20.0},
    },
}
WAMV = {
    "bow": 2.45,
    "inertia": {"surge": 211.0, "sway": 211.0, "yaw": 653.0},
    "linear": {"surge": 51.3, "sway": 40.0, "yaw": 400.0},
    "quadratic": {"surge": 72.4},
    "wind": {"surge": 0.5, "sway": 0.5, "yaw": 0.33},
    "thrusters": {"curve": "logistic", "arm": 1.027135},
    "gains": {
        "surge": {"kf": 51.3, "kp": 200.0, "ki": 20.0},
        "yaw": {"kf": 400.0, "kp": 900.0, "ki": 100.0},
    },
}


def numbers_of(content):
    """Return the ``VesselParameters`` in a section such as those above."""
    return vessel.read(QuantitySection(dict(content), "hull"))
