"""Teams that the service ``~set_team`` asks for."""

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.ros.message_forms.messages import read_robot_specs
from mrs_simulator.scenario.scenario import DEFAULT_KIND
from mrs_simulator.vehicles import shipped_kinds


def with_robots(scenario, robots, stands_for):
    """Return ``scenario`` with the ``robots`` of a request, ``RobotSpec`` each; ``ValueError`` says what is
    wrong.

    ``stands_for``: kinds as they were published -> as the scenario has them.
    """
    kinds, poses, heights = read_robot_specs(robots, DEFAULT_KIND)
    # A request names no files to be read here but those that the scenario names.
    kinds = [stands_for.get(kind, kind) for kind in kinds]
    known = {*shipped_kinds(), *scenario.own_kinds, *scenario.kinds, *stands_for.values()}
    for kind in kinds:
        if kind not in known:
            raise ValueError(unknown_name("kind", kind, known))
    if scenario.topology is not None:
        scenario = scenario._replace(topology=scenario.topology.for_robots(len(poses)))
    return scenario.changed(robots=len(poses), poses=poses, altitude=heights, model=kinds)
