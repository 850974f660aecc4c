"""Presets: simulated robots behind the interfaces of real ones, so that their nodes move over unchanged."""

from typing import Any, Callable, NamedTuple

from mrs_simulator.nodes.stage.driver_presets import ardrone, crazyswarm, heron, rosaria, wamv
from mrs_simulator.ros.node.node_parameters import PRESET
from mrs_simulator.ros.node.parameters import read


class Preset(NamedTuple):
    """What the stage does otherwise."""

    behind: Callable  # the scenario of robots behind that interface
    drivers: Any  # class: what their drivers make of commands
    odom_rate: Any = None  # [Hz], None: the stage's
    watch_period: float = 0.0  # [s] between two looks of the watchdogs
    odometry: str = ""  # as ``robot_topics.RobotTopics`` publishes it, "": as the scenario says


PRESETS = {
    "rosaria": Preset(
        rosaria.behind_rosaria, rosaria.Drivers, rosaria.ODOM_RATE, rosaria.WATCH_PERIOD, "rosaria"
    ),
    "crazyswarm": Preset(crazyswarm.behind, crazyswarm.Drivers),
    "ardrone": Preset(ardrone.behind, ardrone.Drivers),
    "heron": Preset(heron.behind, heron.Drivers),
    "wamv": Preset(wamv.behind, wamv.Drivers),
}


def chosen_preset(argument):
    """Return the name of the preset that the command line's ``argument`` or else ``~preset`` names."""
    preset = argument or read(PRESET)
    if preset not in PRESET.choices:
        raise ValueError("preset = {!r}: wanted {}".format(preset, PRESET.wanted()))
    return preset
