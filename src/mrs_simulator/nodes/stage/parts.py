"""The parts of a stage."""

from mrs_simulator.nodes.stage.arm_topics import ArmTopics
from mrs_simulator.nodes.stage.flight_services import FlightServices
from mrs_simulator.nodes.stage.ignored_axes import IgnoredAxes
from mrs_simulator.nodes.stage.load_topics import LoadTopics
from mrs_simulator.nodes.stage.map_topics import MapTopics
from mrs_simulator.nodes.stage.mirror import Mirror
from mrs_simulator.nodes.stage.scenario_topic import ScenarioTopic
from mrs_simulator.nodes.stage.sensor_topics import SensorTopics
from mrs_simulator.nodes.stage.solver_window import Window
from mrs_simulator.nodes.stage.status import StatusTopic
from mrs_simulator.nodes.stage.world_topics import WorldTopics


def make_parts(stage, preset, real):
    """Return the ``WorldTopics`` of ``stage``, what gives robots commands, and all parts in their order.

    ``preset``: a ``Preset`` or None; ``real``: rows of robots that are real.  Sensors come before
    odometry: a node that waits for that has received them then.
    """
    world, inbox, frames = stage.world, stage.inbox, stage.frames
    mirror = Mirror(world, real, stage.scenario)
    sensors = SensorTopics(world, frames, real)
    odometry = (preset and preset.odometry) or stage.scenario.odometry
    topics = WorldTopics(world, frames, inbox, odometry, mirror, sensors.fixed_frames)
    drivers = preset and preset.drivers(world, stage.requests, absent=real)
    ignored = IgnoredAxes(world)
    parts = [
        mirror,
        sensors,
        topics,
        *([drivers] if drivers else []),
        ignored,
        ArmTopics(world, inbox),
        LoadTopics(world, frames.world),
        FlightServices(world, stage.requests, absent=real),
        ScenarioTopic(stage.stands_for, stage.preset),
        MapTopics(stage.scenario, frames.world, topics.stamp()),
        stage.length,
        StatusTopic(stage, mirror, sensors, ignored),
        Window(world),
    ]
    return topics, drivers.command if drivers else world.set_commands, parts
