"""The scene's map as map_server publishes it: ``map`` and ``map_metadata``, latched."""

import math

import rospy
from nav_msgs.msg import MapMetaData, OccupancyGrid

from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.scenario.surroundings.grids import scene_grid


class MapTopics(StagePart):
    """Publishes what stands in a scenario's scene, if anything does."""

    def __init__(self, scenario, frame, stamp):
        """``frame``: the common one; ``stamp``: the present one."""
        self._publishers = ()
        grid = scene_grid(scenario)
        if grid is None:
            return
        about = metadata(grid, stamp)
        message = OccupancyGrid(info=about, data=grid.cells.ravel().tolist())
        message.header.stamp, message.header.frame_id = stamp, frame
        self._publishers = (latched("map", message), latched("map_metadata", about))


def metadata(grid, stamp):
    """Return the ``MapMetaData`` of a ``grids.Grid``."""
    rows, columns = grid.cells.shape
    about = MapMetaData(map_load_time=stamp, resolution=grid.side, width=columns, height=rows)
    place, turn = about.origin.position, about.origin.orientation
    place.x, place.y, yaw = grid.origin
    turn.z, turn.w = math.sin(0.5 * yaw), math.cos(0.5 * yaw)
    return about


def latched(name, message):
    """Return a publisher that gives ``message`` to every listener."""
    publisher = rospy.Publisher(name, type(message), queue_size=1, latch=True)
    publisher.publish(message)
    return publisher
