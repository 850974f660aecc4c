"""The services of a stage: pause, pause_after, step, reset, set_speed and set_team."""

import rospy
from std_srvs.srv import SetBool, Trigger

from mrs_simulator.core.fields import counted, unknown_name
from mrs_simulator.ros.message_forms.messages import read_robot_specs
from mrs_simulator.ros.node.node_parameters import MOST_BY_SERVICE
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.scenario.scenario import DEFAULT_KIND
from mrs_simulator.srv import SetSpeed, SetTeam, StepStage
from mrs_simulator.vehicles import Team, shipped_kinds

MOST_STEPS = 1000000  # [-] of one request


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


class StageServices:
    """Services that change a stage; its main loop answers them."""

    def __init__(self, stage):
        self._stage = stage
        self._most_robots = max(int(read(MOST_BY_SERVICE)), stage.scenario.n)

    def open(self):
        """Open the services."""
        self._services = [
            self._service("~pause", SetBool, self._on_pause),
            self._service("~pause_after", StepStage, self._on_pause_after),
            self._service("~step", StepStage, self._on_step),
            self._service("~reset", Trigger, self._on_reset),
            self._service("~set_speed", SetSpeed, self._on_set_speed),
            self._service("~set_team", SetTeam, self._on_set_team),
        ]

    def _service(self, name, kind, handler):
        ask = self._stage.requests.ask
        return rospy.Service(name, kind, lambda request: ask(lambda: handler(request)))

    def _on_pause(self, request):
        stage = self._stage
        stage.paused = request.data
        stage.steps_asked = 0
        stage.pacer.resume()
        return "paused" if stage.paused else "running"

    def _on_pause_after(self, request):
        self._stage.length.ask(request.steps)
        after = "{} steps of {:g} s".format(request.steps, self._stage.world.step_size)
        return "pauses after " + after if request.steps else "goes on without an end"

    def _on_step(self, request):
        stage = self._stage
        if not stage.paused:
            raise ValueError("the stage is running; pause it before stepping")
        if not 1 <= request.steps <= MOST_STEPS:
            raise ValueError("steps = {}: wanted from 1 to {}".format(request.steps, MOST_STEPS))
        stage.steps_asked += request.steps
        return "stepping {} times {:g} s".format(request.steps, stage.world.step_size)

    def _on_reset(self, _):
        stage = self._stage
        stage.world.reset()
        for part in stage.parts:
            part.reset()
        stage.after_change()
        return counted(stage.world.n, "robot") + " back at their initial poses"

    def _on_set_speed(self, request):
        stage = self._stage
        if not 0.0 <= request.speed < float("inf"):
            raise ValueError("speed = {}: wanted 0 or a positive number".format(request.speed))
        stage.pacer.set_speed(request.speed)
        return "speed {:g}".format(request.speed) if request.speed else "as fast as possible"

    def _on_set_team(self, request):
        stage = self._stage
        if len(request.robots) > self._most_robots:
            text = "{} robots: wanted at most {}, the stage's parameter most_robots"
            raise ValueError(text.format(len(request.robots), self._most_robots))
        team = with_robots(stage.scenario, request.robots, stage.stands_for)
        stage.world.set_team(Team.from_scenario(team), team.poses, team.altitude)
        stage.scenario = team
        stage.after_change()
        return counted(stage.world.n, "robot")
