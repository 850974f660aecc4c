"""The topics ``~scenario`` and ``~preset`` of a stage."""

import rospy
from std_msgs.msg import String

from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.nodes.stage.world_topics import publisher
from mrs_simulator.vehicles.portable import portable


class ScenarioTopic(StagePart):
    """Publishes the scenario without the names of files: displays draw what they receive."""

    def __init__(self, stands_for, preset):
        """``stands_for`` takes in kinds as they are published -> as the scenario has them.

        ``preset``: its name, which no scenario has.
        """
        self._stands_for = stands_for
        self._publisher = publisher("~scenario", String, queue_size=1, latch=True)
        self._preset = publisher("~preset", String, queue_size=1, latch=True)
        self._preset.publish(String(data=preset))

    def follow_team(self, scenario):
        """Publish ``scenario``, and log what others cannot know of it."""
        published, stands_for, notes = portable(scenario)
        self._stands_for.update(stands_for)  # a team may be of these kinds again
        for note in notes:
            rospy.logwarn("stage: %s", note)
        self._publisher.publish(String(data=published.to_yaml()))
