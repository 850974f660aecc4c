"""The stage node: a world of robots behind ROS topics and services."""

from mrs_simulator.nodes.real.real_robots import real_rows
from mrs_simulator.nodes.stage.presets import PRESETS, chosen_preset
from mrs_simulator.nodes.stage.stage import Stage
from mrs_simulator.ros.node.arguments import RUN_ARGUMENTS, parse, scenario_from
from mrs_simulator.ros.node.lifecycle import run, start_node
from mrs_simulator.study.bad_input import refusing_bad_input

LOCAL = dict(
    RUN_ARGUMENTS,
    preset="whose interface the robots have: " + ", ".join(PRESETS) + " (default: none)",
    real="numbers of the robots that are real, such as 2,4 (default: none)",
)


def main():
    """Run the node ``stage``."""
    with refusing_bad_input("stage", RuntimeError):
        arguments = parse("The stage: a world of robots behind ROS topics.", LOCAL, node="stage")
        scenario, real = scenario_from(arguments), real_rows(arguments.real)
        start_node("stage")
        stage = Stage(scenario, chosen_preset(arguments.preset), real)
    run(stage.spin)
