"""Records a rosbag of the stage and of the sensors that the scenario's ``record`` names."""

import os
import sys

from mrs_simulator.core.writing import printing
from mrs_simulator.nodes.record.bag_size import size_text, written
from mrs_simulator.nodes.record.sensor_source import recorded_of
from mrs_simulator.ros.message_forms.sensor_messages import forms_of, topic_of
from mrs_simulator.ros.node.arguments import RUN_ARGUMENTS, parse, scenario_from
from mrs_simulator.study.bad_input import refusing_bad_input

STAGE = ("/clock", "/tf", "/tf_static")
STAGE += tuple(
    "/stage/" + name for name in ("state", "status", "collisions", "incidents", "scenario")
)
OBEYED = "/pioneer_control/scenario"
ESTIMATES = "/pioneer_control/estimates"
PICTURES = ("", "_info", "_depth")  # what of a camera is recorded
LOCAL = dict(RUN_ARGUMENTS, out="directory for run.bag")


def bagged_forms(scenario):
    """Return ``{(name, number): forms}`` of what ``scenario`` records; of cameras all but the raw depth."""
    _, forms = recorded_of(scenario)
    return {
        key: [each for each in forms_of(form.mount, form.kind) if each.SUFFIX in PICTURES]
        if form.mount.type == "camera"
        else [form]
        for key, form in forms.items()
    }


def command_of(scenario, directory, more=()):
    """Return the command line of rosbag that records ``scenario`` to ``directory``; ``more``: arguments.

    Topics by name: rosbag looks for patterns by simulated time, which waits for it.
    """
    forms = bagged_forms(scenario)
    topics = [topic_of(number, form) for (_, number), own in sorted(forms.items()) for form in own]
    if scenario.map is not None or scenario.obstacles:
        topics = ["/map", *topics] if topics else topics
    topics += [ESTIMATES] if scenario.estimates is not None else []
    to = os.path.join(directory, "run.bag")
    given = ["rosrun", "rosbag", "record", "--tcpnodelay", "-O", to]
    return [*given, *STAGE, OBEYED, *topics, *more]


@printing
def main():
    """Become ``rosbag record``; exits with 2 for bad input."""
    with refusing_bad_input("bag"):
        arguments = parse("Record a bag of the stage and of sensors.", LOCAL)
        directory = os.path.abspath(arguments.out or ".")
        scenario = scenario_from(arguments)
        own = [argument for argument in sys.argv[1:] if argument.startswith("__")]
        command = command_of(scenario, directory, own)
        estimates = ESTIMATES if scenario.estimates is not None else ""
        items = written(scenario, bagged_forms(scenario), estimates)
        print("bag: " + size_text(items, scenario.duration), file=sys.stderr)
        os.makedirs(directory, exist_ok=True)
    os.execvp(command[0], command)
