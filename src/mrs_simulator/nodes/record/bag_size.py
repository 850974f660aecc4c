"""How much a rosbag of a scenario will take, estimated before it is recorded."""

import io
from typing import NamedTuple

import genpy
import numpy as np
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from mrs_simulator.core.step_rates import steps_between
from mrs_simulator.nodes.stage.robot_topics import Frames, lifts, transform
from mrs_simulator.ros.message_forms.messages import team_odometry, team_state
from mrs_simulator.ros.message_forms.sensor_messages import topic_of
from mrs_simulator.study.run.sensor_sizes import samples_at_start
from mrs_simulator.vehicles.odometry_rates import odometry_steps
from mrs_simulator.world.world import World

RECORD = 58.0  # [bytes] of each message in a bag besides itself: its record's header, and its index
USUAL_ODOMETRY = 50.0  # [Hz], or the rate of commands where that is higher
STAMP = genpy.Time(1, 1)
MEGABYTE = 1e6  # [bytes]
MOST_NAMED = 4  # [-] kinds of topics


class Written(NamedTuple):
    """What is written of one topic."""

    topic: str
    rate: float  # [Hz] of messages
    length: float  # [bytes] of one

    def size(self, duration):
        """Return how many bytes ``duration`` [s] take."""
        return self.rate * duration * (self.length + RECORD)


def written(scenario, forms, estimates=""):
    """Return a ``Written`` of each topic of a bag of ``scenario`` that takes room.

    ``forms``: ``{(name, number): forms}`` of its sensors; ``estimates``: a topic of all robots' poses,
    or "".  Left out is what comes seldom: status, collisions, what is latched.
    """
    world = World.from_scenario(scenario)
    steps_rate, frames = 1.0 / scenario.step, Frames()
    rate = scenario.odometry_rate or max(USUAL_ODOMETRY, scenario.control.rate)
    moves = 1.0 / (odometry_steps(world.team, rate, scenario.step).min() * scenario.step)
    poses = world.estimates.odometry().tolist()
    raised = lifts(world.estimates.spatial(), world.n)
    moved = TFMessage(
        [
            transform(STAMP, frames.odom(row + 1), frames.base(row + 1), pose, lift)
            for row, (pose, lift) in enumerate(zip(poses, raised))
        ]
    )
    result = [
        Written("/clock", steps_rate, length(Clock())),
        Written("/tf", moves, length(moved)),
        Written("/stage/state", steps_rate, length(team_state(world, STAMP, frames.world, (1, 1)))),
    ]
    if estimates:
        numbers = list(range(1, world.n + 1))
        known = length(team_odometry(numbers, world.pose, None, STAMP, world.spatial))
        result.append(Written(estimates, scenario.control.rate, known))
    return result + _of_sensors(scenario, world, forms, frames)


def _of_sensors(scenario, world, forms, frames):
    seen, result = {}, []
    names = {name for name, _ in forms}
    for mount, number, reading in samples_at_start(scenario, world.team, world.obstacles, names):
        seen.setdefault((mount.name, number), []).append(reading)
    for (name, number), own in sorted(forms.items()):
        for form in own:
            header = Header(0, STAMP, frames.mount(number, name))
            readings = seen.get((name, number))
            lengths = [length(_message(form, reading, header)) for reading in readings or (None,)]
            steps = steps_between(form.mount.rate, scenario.step)
            rate = 1.0 / (steps * scenario.step)
            result.append(Written(topic_of(number, form), rate, float(np.mean(lengths))))
    return result


def _message(form, reading, header):
    """Return a message as long as those of ``form``; without a reading its values are 0."""
    if reading is None:
        return form.message(form.blank(), header)
    if hasattr(reading, "numbers"):
        fields = ("numbers", *reading.PER_ROBOT)
        return form.message([getattr(reading, field) for field in fields], header)
    return form.message(form.rows(of_one(reading))[0], header)


def of_one(reading):
    """Return the ``reading`` of a robot as that of a team of one."""
    return reading._replace(
        **{name: np.asarray(getattr(reading, name))[np.newaxis] for name in reading.PER_ROBOT}
    )


def length(message):
    """Return how many bytes a ``message`` has."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return len(buffer.getvalue())


def size_text(items, duration):
    """Return in words how much a bag of ``duration`` [s] takes, and which topics the most."""
    by = {}
    for each in items:
        kind = each.topic.rpartition("/")[2] if each.topic.startswith("/robot") else each.topic
        by[kind] = by.get(kind, 0.0) + each.size(duration)
    total = sum(by.values())
    most = sorted(by.items(), key=lambda item: -item[1])[:MOST_NAMED]
    parts = ", ".join("{} {:.2g}".format(name, size / MEGABYTE) for name, size in most)
    text = "run.bag: about {:.2g} MB for {:g} s: {}"
    return text.format(total / MEGABYTE, duration, parts)
