"""Command gate: publishes the robots' commands, and can be shut whatever state the law is in."""

import math
import threading
import time

import numpy as np

from mrs_simulator.core.kinematics import UNICYCLE_AXES
from mrs_simulator.ros.message_forms.planar_messages import QuickTwist
from mrs_simulator.ros.node.node_parameters import CMD_VEL_TOPIC
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.ros.nonblocking_publisher import prompt_publisher
from mrs_simulator.vehicles.team import on_all_axes

INSISTING = 3.0  # [s] of wall time for which zero commands to real robots that stand are repeated
AGAIN = 0.05  # [s] of wall time between two times


class CommandGate:
    """Publishes commands; while it is shut they are zeros, and shutting it waits for no law."""

    def __init__(
        self, topics, n, insists=False, clock=time.monotonic, axes=UNICYCLE_AXES, landing=None
    ):
        """``topics``: what publishes, None in a dry run; commands of ``n`` robots, of ``axes``.

        ``insists``: a stop is said again and again; ``clock`` gives wall time in s; ``landing``
        (n, a): what is commanded in an emergency, by default zeros; robots that fly come down by it.
        """
        self._topics, self._insists, self._clock = topics, insists, clock
        self._lock = threading.Lock()
        self._moved = self._sent = -math.inf
        self._open, self.emergency = False, False
        self.stalled = False  # whether it shut itself since it was opened
        self.command = np.zeros((n, len(axes)))  # [m/s, rad/s] the last that was sent
        self._landing = np.zeros_like(self.command) if landing is None else landing
        self._lands = bool(self._landing.any())

    def open(self):
        """Let commands pass, unless there is an emergency."""
        with self._lock:
            self._open, self.stalled = not self.emergency, False

    def shut(self):
        """Stop the robots, until it is opened."""
        with self._lock:
            self._open = False
            self._publish(self._resting())

    def alarm(self, on):
        """An emergency is there, ``on``, and it cannot be opened, or has gone: robots that fly land.

        Again while it is there, they still land; when it has gone, those in the air hover.
        """
        with self._lock:
            self.emergency = on
        if on:
            self.shut()

    def send(self, command, answered=None):
        """Publish ``command`` (n, a), or zeros while it is shut, in an emergency the landing.

        ``answered`` (n,) [s]: stamps of the odometry that it answers, None for no odometry.
        """
        with self._lock:
            self._publish(command if self._open else self._resting(), answered)

    def shut_if_stalled(self, patience):
        """Stop robots that move by a command older than ``patience`` [s]; return whether it did."""
        with self._lock:
            late = self._open and self._clock() - self._sent > patience
            if late and self.command.any():
                self._open, self.stalled = False, True
                self._publish(self._resting())
                return True
        return False

    def insist(self):
        """To be called all the time: repeat the stop of real robots, since one may have missed it.

        Robots that land, real or not, are commanded to all through an emergency.
        """
        with self._lock:
            now = self._clock()
            if self.emergency and self._lands and self._sent + AGAIN <= now:
                self._publish(self._resting())
                return
            due = self._sent + AGAIN <= now < self._moved + INSISTING
            if self._insists and due and not self.command.any():
                self._publish(self.command)

    def _resting(self):
        """Return what robots are commanded while it is shut, (n, a)."""
        return self._landing.copy() if self.emergency else np.zeros_like(self.command)

    def _publish(self, command, answered=None):
        self.command, self._sent = command, self._clock()
        if command.any():
            self._moved = self._sent
        if self._topics is not None:
            self._topics.publish(command, answered)


def command_topics(numbers):
    """Return the names of the robots' commands, by the parameter ``~cmd_vel_topic``."""
    pattern = read(CMD_VEL_TOPIC)
    return [pattern.replace("{}", str(number)) for number in numbers]


class RobotCommands:
    """Publishes the command of each robot on its own topic."""

    def __init__(self, names, real=(), axes=UNICYCLE_AXES, answers=None):
        """``names`` of the topics; ``real``: rows of the robots that are real; ``axes`` of commands.

        ``answers``: what publishes besides which odometry they answer, an ``AnswerPublisher``, or None.
        """
        self._driven, self._axes, self._answers = False, axes, answers
        self._publishers = [
            prompt_publisher(name, QuickTwist, self._first if row in real else None)
            for row, name in enumerate(names)
        ]

    def publish(self, command, answered=None):
        """Publish ``command`` (n, a) [m/s, rad/s], which answers odometry stamped ``answered`` (n,) [s]."""
        self._driven = True
        if self._answers is not None:
            self._answers.publish(command, answered)
        for publisher, values in zip(self._publishers, on_all_axes(command, self._axes).tolist()):
            publisher.publish(_twist(values))

    def _first(self):
        # What a robot received before its connection broke may be older than a stop.
        return _twist((0.0,) * 6) if self._driven else None


def _twist(values):
    message = QuickTwist()
    message.values = values
    return message
