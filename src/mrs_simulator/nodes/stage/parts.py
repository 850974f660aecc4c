"""The parts of a stage."""

from mrs_simulator.nodes.stage.flight_services import FlightServices
from mrs_simulator.nodes.stage.load_topics import LoadTopics


def parts_of(stage, absent):
    """Return the parts of ``stage``, each a ``StagePart``; ``absent``: rows of robots that are real."""
    world = stage.world
    parts = [stage.drivers] if stage.drivers else []
    parts += [stage.arms, LoadTopics(world, stage.frames.world)]
    return [*parts, FlightServices(world, stage.requests, absent=absent)]
