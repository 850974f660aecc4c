"""The way of the commands to the robots, which is shut whatever the law is at."""

import threading

import numpy as np

from mrs_simulator.nodes.prompt import prompt_publisher
from mrs_simulator.nodes.wire import PlanarTwist


class Outlet:
    """Publishes commands; while it is shut they are zeros, and shutting it waits for no law."""

    def __init__(self, topics, n):
        """``topics``: what publishes, None in a dry run; commands of ``n`` robots."""
        self._topics = topics
        self._lock = threading.Lock()
        self._open, self.emergency = False, False
        self.command = np.zeros((n, 2))  # [m/s, rad/s] the last that was sent

    def open(self):
        """Let commands pass, unless there is an emergency."""
        with self._lock:
            self._open = not self.emergency

    def shut(self):
        """Stop the robots, until it is opened."""
        with self._lock:
            self._open = False
            self._publish(np.zeros_like(self.command))

    def alarm(self, on):
        """An emergency is there, ``on``, and it cannot be opened, or has gone."""
        with self._lock:
            self.emergency = on
        if on:
            self.shut()

    def send(self, command):
        """Publish ``command`` (n, 2) [m/s, rad/s], or zeros while it is shut."""
        with self._lock:
            self._publish(command if self._open else np.zeros_like(command))

    def _publish(self, command):
        self.command = command
        if self._topics is not None:
            self._topics.publish(command)


class RobotCommands:
    """Publishes ``/robotN/cmd_vel`` of each robot."""

    def __init__(self, numbers):
        """``numbers``: the robots' numbers."""
        self._publishers = [
            prompt_publisher("/robot{}/cmd_vel".format(number), PlanarTwist) for number in numbers
        ]

    def publish(self, command):
        """Publish ``command`` (n, 2) [m/s, rad/s]."""
        for publisher, pair in zip(self._publishers, command.tolist()):
            message = PlanarTwist()
            message.command = pair
            publisher.publish(message)
